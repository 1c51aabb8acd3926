"""Exchange of kept points against eq. 27: a stage that can follow any method that keeps a subset."""

from lpcompare.refinement.density import DensityBand
from lpcompare.refinement.exchange import refine

__all__ = ["DensityBand", "refine"]
