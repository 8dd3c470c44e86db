"""Figures 3 to 12 of Singh & Sanyal 2022: their linkages and the states they are in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from _common import MODELS
from _cusp_transitions import CuspTransition, cusp_transitions

from flexmech import CouplerCurve, CouplerPoint, FourBar, HygrothermalState, Mechanism
from flexmech.materials import Hygrothermal
from flexmech.modelfile import mechanism_from_toml

RISE = 80.0
"""Temperature rise of the paper's text in K."""
RISE_OF_CAPTION = {"3": 95.0, "4": 95.0}
"""Of the captions that name another one."""
RESINS = ("R-914", "8551-7")
FIGURES = tuple(str(number) for number in range(3, 13))
# Linkages whose number of crunodes changes, by one of the figures that show them.
CHANGING = {"5": "5", "8": "7 and 8", "10": "9 and 10"}
SAME_LINKAGE = {"7": "8", "9": "10"}


@lru_cache
def neat_resin(figure: str, resin: str = "R-914") -> Mechanism:
    """Mechanism of a figure with all links of one of the two resins.

    The frame expands as the links' saturated resin does.
    """
    file = MODELS / f"neat_resin_figure_{'3' if figure == '4' else figure}.toml"
    text = file.read_text(encoding="utf-8")
    renamed = text.replace('material = "R-914"', f'material = "{resin}"')
    mechanism = mechanism_from_toml(renamed, file.name)
    expansion = resin_of(mechanism).wet_thermal_expansion
    assert expansion is not None
    return replace(mechanism, ground_thermal_expansion=expansion)


def resin_of(mechanism: Mechanism) -> Hygrothermal:
    """The resin of the links: all three are of one."""
    layers = mechanism.sections["coupler"].layers
    assert layers is not None
    resin = layers.laminate.layers[0].ply.resin
    assert resin is not None
    return resin.hygrothermal


def rise_of(figure: str) -> float:
    """Temperature rise of a figure in K: that of its caption, or of the text."""
    return RISE_OF_CAPTION.get(figure, RISE)


def saturated(mechanism: Mechanism, rise: float = RISE) -> HygrothermalState:
    """The paper's state: so many K hotter, and all the water that the resin takes up."""
    equilibrium = resin_of(mechanism).equilibrium
    assert equilibrium is not None
    return HygrothermalState(rise, equilibrium.saturation)


def coupler_curve(figure: str, mechanism: Mechanism, state: HygrothermalState) -> CouplerCurve:
    """Curve of a figure in a state.

    Evenly moist neat resin swells alike everywhere, so that the strain is all that counts:
    what ``linkage_in_state`` finds by way of the sections, a thousand times as fast.

    Parameters
    ----------
    figure : str
    mechanism : Mechanism
        Dry.
    state : HygrothermalState

    Returns
    -------
    CouplerCurve
        In Figures 3 and 4 of the pins A and B.
    """
    linkage = mechanism.linkage
    assert isinstance(linkage, FourBar)
    pin = CouplerPoint(0.0 if figure == "3" else linkage.coupler, 0.0)
    point = mechanism.coupler_point or pin
    link = 1 + resin_of(mechanism).free_strain(state.temperature_rise, state.moisture)
    swollen = replace(
        linkage,
        ground=linkage.ground * (1 + mechanism.ground_thermal_expansion * state.temperature_rise),
        crank=linkage.crank * link,
        coupler=linkage.coupler * link,
        rocker=linkage.rocker * link,
    )
    return CouplerCurve(swollen, point.scaled(link))


@dataclass(frozen=True)
class Path:
    """A way from one state to another along which a parameter grows.

    Parameters
    ----------
    name : str
    parameter : {"temperature_rise", "moisture"}
        What grows, in K or as a fraction.
    stop : float
        Where it ends; it starts at zero.
    rise : float
        Temperature rise in K all along, where moisture grows.
    wet_expansion : bool
        Whether the resin has its wet expansion from the start, as the paper's equations do
        with one coefficient; else it goes from the dry to the wet one with the moisture.
    frame : float, optional
        Expansion of the frame in 1/K; that of the saturated resin if left out.
    """

    name: str
    parameter: Literal["temperature_rise", "moisture"]
    stop: float
    rise: float = 0.0
    wet_expansion: bool = False
    frame: float | None = None

    def state(self, value: float) -> HygrothermalState:
        """State at a value of the parameter."""
        if self.parameter == "temperature_rise":
            return HygrothermalState(value, 0.0)
        return HygrothermalState(self.rise, value)


STEEL = 11.7e-6
MAIN_PATH = Path("moistened at +80 K", "moisture", 0.07, RISE)
PATHS = (
    Path("heated dry", "temperature_rise", RISE),
    MAIN_PATH,
    Path("moistened at +80 K, wet expansion", "moisture", 0.07, RISE, wet_expansion=True),
    Path("moistened, not heated", "moisture", 0.07),
    Path("heated dry, steel frame", "temperature_rise", RISE, frame=STEEL),
    Path("moistened at +80 K, steel frame", "moisture", 0.07, RISE, frame=STEEL),
)


def transitions(figure: str, path: Path, steps: int = 64) -> tuple[CuspTransition, ...]:
    """Where along a path crunodes of a figure's curve, of R-914, come and go."""
    mechanism = with_wet_expansion(figure) if path.wet_expansion else neat_resin(figure)
    if path.frame is not None:
        mechanism = replace(mechanism, ground_thermal_expansion=path.frame)

    def family(value: float) -> tuple[FourBar, CouplerPoint]:
        curve = coupler_curve(figure, mechanism, path.state(value))
        return curve.linkage, curve.point

    return cusp_transitions(family, 0.0, path.stop, steps)


@lru_cache
def with_wet_expansion(figure: str) -> Mechanism:
    """Mechanism of a figure whose R-914 expands by its wet coefficient at any moisture."""
    file = MODELS / f"neat_resin_figure_{figure}.toml"
    dry, wet = (f'\nthermal_expansion = "{value}e-6 1/K"' for value in ("58.4", "62.6"))
    return mechanism_from_toml(file.read_text(encoding="utf-8").replace(dry, wet), file.name)
