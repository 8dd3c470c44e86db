"""Strengths of a ply: stresses along its axes that it just bears, each alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

from flexmech import si
from flexmech.errors import InputError
from flexmech.model_text import TomlTable, short_repr

SYMBOLS = {
    "longitudinal_tension": "Xt",
    "longitudinal_compression": "Xc",
    "transverse_tension": "Yt",
    "transverse_compression": "Yc",
    "in_plane_shear": "S12",
    "transverse_shear": "S23",
}
"""Textbooks' symbols of strengths, which are their keys in a model file too."""
INCLINATIONS = ("inclination_tension", "inclination_compression")
"""Slopes of Puck's inter-fibre failure curve, beside the strengths."""
_OF_FIBRES = "longitudinal_tension"
# Where a number is wanted that is not stated.
_REMEDIES = {
    "transverse_shear": "the shear strength in the plane across the fibres",
    "inclination_tension": "VDI 2014 recommends 0.30 for glass and 0.35 for carbon in epoxy",
    "inclination_compression": "VDI 2014 recommends 0.25 for glass and 0.30 for carbon in epoxy",
}


@dataclass(frozen=True)
class PlyStrength:
    """Strengths of a unidirectional ply in Pa, all positive.

    Parameters
    ----------
    longitudinal_tension, longitudinal_compression : float
        Xt and Xc, along the fibres.
    transverse_tension, transverse_compression : float
        Yt and Yc, across them.
    in_plane_shear : float
        S12.
    transverse_shear : float, optional
        S23, which Hashin's criterion needs.
    inclination_tension : float, optional
        Puck's inclination of the failure curve at no transverse stress, on the side of tension
        (VDI 2014: 0.30 for glass, 0.35 for carbon in epoxy).
    inclination_compression : float, optional
        The same on the side of compression (VDI 2014: 0.25 for glass, 0.30 for carbon in epoxy).
    source : str
        Where the numbers are from.

    Raises
    ------
    InputError
        If a strength is not positive, or an inclination not between 0 and 1.

    Examples
    --------
    >>> flexmech.PlyStrength(1500e6, 1500e6, 40e6, 246e6, 68e6)
    <PlyStrength: Xt 1500 MPa, Xc 1500 MPa, Yt 40 MPa, Yc 246 MPa, S12 68 MPa>
    """

    longitudinal_tension: si.Stress
    longitudinal_compression: si.Stress
    transverse_tension: si.Stress
    transverse_compression: si.Stress
    in_plane_shear: si.Stress
    transverse_shear: si.Stress | None = None
    inclination_tension: si.Inclination | None = None
    inclination_compression: si.Inclination | None = None
    source: str = ""

    def __post_init__(self) -> None:
        si.check(self, "{} of a ply's strength")

    def __repr__(self) -> str:
        known = {symbol: getattr(self, name) for name, symbol in SYMBOLS.items()}
        texts = (f"{s} {value / 1e6:.6g} MPa" for s, value in known.items() if value is not None)
        return short_repr(self, *texts)

    def needed(self, name: str, criterion: str) -> float:
        """A number that not every ply states.

        Parameters
        ----------
        name : str
            Name of the field.
        criterion : str
            Which needs it.

        Returns
        -------
        float

        Raises
        ------
        InputError
            If it is not known; says where to add it.
        """
        value: float | None = getattr(self, name)
        if value is None:
            key = SYMBOLS.get(name, name)
            raise InputError(
                f"the criterion {criterion} needs {key}, which the ply's strength does not state; "
                f"add it ({_REMEDIES[name]}), or choose another criterion"
            )
        return value

    def in_state(self, retention: float) -> PlyStrength:
        """Strengths of the ply in heat and water.

        The fibres alone bear the tension along them; all other strengths are in proportion to the
        resin's, which supports the fibres in compression too (Chamis, NASA TM-83320, 1983).

        Parameters
        ----------
        retention : float
            Part of its strength that the resin keeps.

        Returns
        -------
        PlyStrength
        """
        known = {name: getattr(self, name) for name in SYMBOLS if name != _OF_FIBRES}
        return replace(self, **{n: retention * v for n, v in known.items() if v is not None})

    def diluted(self, growth: float) -> PlyStrength:
        """Strengths where the same fibres lie in a volume that has grown by a factor."""
        return replace(self, longitudinal_tension=self.longitudinal_tension / growth)

    def to_table(self) -> TomlTable:
        """Table ``[plies.NAME.strength]`` of a model file."""
        stated = {SYMBOLS.get(name, name): value for name, value in si.table(self).items()}
        return stated | ({"source": self.source} if self.source else {})
