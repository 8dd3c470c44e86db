"""Figures 3 to 12 of Singh & Sanyal 2022: their linkages, their states, and a verdict on each."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

from paper_claims import Verdict

from flexmech import CouplerCurve, CouplerPoint, HygrothermalState, Mechanism, example_model
from flexmech.materials import Hygrothermal
from flexmech.modelfile import mechanism_from_toml

FIGURES = tuple(str(number) for number in range(3, 13))
RESINS = ("R-914", "8551-7")
RISE = 80.0
"""Temperature rise of the paper's text in K."""
RISE_OF_CAPTION = {"3": 95.0, "4": 95.0}
"""Temperature rise of the captions that name another one."""
# Every figure is said to deviate: by more than a line's width of half a millimetre in a picture of
# 100 mm.
VISIBLE = 5e-3


class FigureClaim(NamedTuple):
    """What the paper says of a figure or in a section, and what was found.

    Parameters
    ----------
    figure, claim : str
    dry, wet, other : int or None
        Crunodes dry, with R-914 and with 8551-7 saturated; None where no curve is.
    verdict : {"reproduced", "not reproduced", "not judged"}
    reason : str
    """

    figure: str
    claim: str
    verdict: Verdict
    reason: str
    dry: int | None = None
    wet: int | None = None
    other: int | None = None

    def __str__(self) -> str:
        return f"{self.figure}: {self.claim}: {self.verdict} ({self.reason})"


@lru_cache
def neat_resin(
    figure: str, resin: str = "R-914", *, both_faces: bool = False, wet_expansion: bool = False
) -> Mechanism:
    """Mechanism of a figure with all links of a resin; the frame expands as it does saturated.

    Parameters
    ----------
    figure : str
    resin : {"R-914", "8551-7"}
    both_faces : bool
        Whether the links take up water through both faces, as equation 4 has it.
    wet_expansion : bool
        Whether R-914 expands by its wet coefficient at any moisture.
    """
    text = example_model(f"neat_resin_figure_{'3' if figure == '4' else figure}").read_text()
    text = text.replace('material = "R-914"', f'material = "{resin}"')
    if both_faces:
        text = text.replace("exposed_sides = true", "exposed_sides = false")
    if wet_expansion:
        dry, wet = (f'\nthermal_expansion = "{value}e-6 1/K"' for value in ("58.4", "62.6"))
        text = text.replace(dry, wet)
    mechanism = mechanism_from_toml(text)
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
    """Curve of a dry mechanism in a state; in Figures 3 and 4 that of the pins A and B.

    Evenly moist neat resin swells alike everywhere, so that the strain is all that counts:
    what ``linkage_in_state`` finds by way of the sections, a thousand times as fast.
    """
    linkage = mechanism.linkage
    pin = CouplerPoint(0.0 if figure == "3" else linkage.coupler, 0.0)
    link = 1 + resin_of(mechanism).free_strain(state.temperature_rise, state.moisture)
    swollen = replace(
        linkage,
        ground=linkage.ground * (1 + mechanism.ground_thermal_expansion * state.temperature_rise),
        crank=linkage.crank * link,
        coupler=linkage.coupler * link,
        rocker=linkage.rocker * link,
    )
    return CouplerCurve(swollen, (mechanism.coupler_point or pin).scaled(link))


def deviates(moved: float, size: float) -> bool:
    """Whether a point has moved by more than a picture of its path of a size hides."""
    return moved > VISIBLE * size
