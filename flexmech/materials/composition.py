"""Composition of a ply, so that it can be computed again with a softer resin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from flexmech.materials.constituents import Fibre, Matrix
from flexmech.materials.hygrothermal import ResinContent
from flexmech.model_text import SharedTables, TomlTable, short_repr
from flexmech.validation import check_instance

Rule = Literal["chamis", "halpin-tsai", "rule-of-mixtures"]
RULES: tuple[Rule, ...] = get_args(Rule)


@dataclass(frozen=True)
class PlyComposition:
    """Fibre, resin and rule of a ply.

    Parameters
    ----------
    fibre : Fibre
    matrix : Matrix
    fibre_volume_fraction : float
    rule : {"chamis", "halpin-tsai", "rule-of-mixtures"}
    woven : bool
        Whether half of the fibres run each way.

    Raises
    ------
    InputError
        If fibre and matrix are none, or in each other's place.
    """

    fibre: Fibre
    matrix: Matrix
    fibre_volume_fraction: float
    rule: Rule
    woven: bool = False

    def __post_init__(self) -> None:
        remedy = "take one of published_constituents(), or make your own"
        check_instance(self.fibre, Fibre, "fibre", remedy)
        check_instance(self.matrix, Matrix, "matrix", remedy)

    def __repr__(self) -> str:
        share = f"fibre volume fraction {self.fibre_volume_fraction:.6g}"
        weave = "woven" if self.woven else ""
        return short_repr(self, self.fibre.name, self.matrix.name, share, self.rule, weave)

    @property
    def resin(self) -> ResinContent:
        """The resin and its share of the ply."""
        volume = 1 - self.fibre_volume_fraction
        mass = volume * self.matrix.density
        whole = mass + self.fibre_volume_fraction * self.fibre.density
        return ResinContent(self.matrix.hygrothermal, mass / whole, volume)

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Keys of a ply in a model file; fibre and resin are added to the shared tables."""
        return {
            "fibre": self.fibre.name_in(shared),
            "matrix": self.matrix.name_in(shared),
            "fibre_volume_fraction": float(self.fibre_volume_fraction),
            "rule": self.rule,
            "weave": "woven" if self.woven else "unidirectional",
        }
