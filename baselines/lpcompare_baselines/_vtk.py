"""VTK's point filters on numpy arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # pyright: ignore[reportMissingImports]
from vtkmodules.vtkCommonCore import vtkPoints  # pyright: ignore[reportMissingImports]
from vtkmodules.vtkCommonDataModel import vtkPolyData  # pyright: ignore[reportMissingImports]
from vtkmodules.vtkFiltersPoints import vtkPoissonDiskSampler, vtkVoxelGrid  # pyright: ignore

from lpcompare.geometry.neighbors import Neighbors
from lpcompare.geometry.scale import about_center, bounding_box_center
from lpcompare.types import Indices, Points


def finest_length(points: Points) -> float:
    """The smallest size that is tried: a 1024th of the longest side, as VTK lays a dense grid of cubes."""
    return float(np.ptp(points, axis=0).max()) / 1024


def voxel_means(points: Points, cell_size: float) -> Points:
    """The means of the occupied cubes, shape (m, 3)."""
    grid = vtkVoxelGrid()
    grid.SetConfigurationStyleToLeafSize()
    grid.SetLeafSize(cell_size, cell_size, cell_size)
    center = bounding_box_center(points)
    return _run(grid, points - center) + center


def poisson_disk(points: Points, radius: float) -> Indices:
    """Rows of points that are at least a radius apart, ascending.

    VTK names no rows and writes single precision, so they are the rows nearest to what it returns.
    """
    sampler = vtkPoissonDiskSampler()
    sampler.SetRadius(radius)
    centred = about_center(points)
    return np.unique(Neighbors(centred).query(_run(sampler, centred), 1)[1])


def _run(algorithm: Any, points: Points) -> Points:
    places = vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points), deep=True))
    cloud = vtkPolyData()
    cloud.SetPoints(places)
    algorithm.SetInputData(cloud)
    algorithm.Update()
    return np.array(vtk_to_numpy(algorithm.GetOutput().GetPoints().GetData()), dtype=float)
