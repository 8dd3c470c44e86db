"""What a ply was computed from, so that it can be computed again with a softer resin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from flexmech.materials.constituents import Fibre, Matrix
from flexmech.materials.hygrothermal import ResinContent

__all__ = ["RULES", "PlyRecipe", "Rule"]

Rule = Literal["chamis", "halpin-tsai", "rule-of-mixtures"]
RULES: tuple[Rule, ...] = ("chamis", "halpin-tsai", "rule-of-mixtures")


@dataclass(frozen=True)
class PlyRecipe:
    """Fibre, resin and rule of a ply.

    Parameters
    ----------
    fibre : Fibre
    matrix : Matrix
    fibre_volume_fraction : float
    rule : {"chamis", "halpin-tsai", "rule-of-mixtures"}
    woven : bool
        Whether half of the fibres run each way.
    """

    fibre: Fibre
    matrix: Matrix
    fibre_volume_fraction: float
    rule: Rule
    woven: bool = False

    @property
    def resin(self) -> ResinContent:
        """The resin and its share of the ply."""
        volume = 1 - self.fibre_volume_fraction
        mass = volume * self.matrix.density
        whole = mass + self.fibre_volume_fraction * self.fibre.density
        return ResinContent(self.matrix.hygrothermal, mass / whole, volume)
