"""What is done to the input before the methods see it; errors are measured against the clean cloud."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Perturbation:
    """A kind of damage and how much of it.

    Attributes
    ----------
    kind : str
        ``none``.
    level : float
    """

    kind: str = "none"
    level: float = 0.0

    @property
    def label(self) -> str:
        """Empty for the clean cloud, else for example ``noise 0.5``."""
        return "" if self.kind == "none" else f"{self.kind} {self.level:g}"


CLEAN = Perturbation()
