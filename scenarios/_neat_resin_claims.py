"""What Singh & Sanyal 2022 say of their Figures 3 to 12, and whether the curves look like it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from _cusp_transitions import CuspTransition
from papers._claims import Verdict, verdict_on

from flexmech.linkages import CouplerCurve, DoublePoint, double_points

CLAIMS = {
    "3": "path of A in heat and moisture deviates",
    "4": "path of B in heat and moisture deviates",
    "5": "coupler curve deviates",
    "6": "figure-eight with a crunode",
    "7": "teardrop cusp",
    "8": "figure-eight crunode dry becomes a cusp wet",
    "9": "teardrop cusp",
    "10": "teardrop cusp dry becomes a figure-eight crunode wet",
    "11": "kidney bean",
    "12": "crescent",
}

Look = Literal["crunode", "cusp", "smooth"]
# A bend whose radius is a smaller part of the curve's extent looks like a cusp.
SHARP = 1e-3
# Of the search for the sharpest bend, each fifty times as fine as the one before.
REFINEMENTS = 3
# Every caption says that the curve deviates: by more than a line's width of half a millimetre in
# a picture of 100 mm.
VISIBLE = 5e-3
# Looks dry and wet that the words claim. A caption with one word says it of every curve that it
# draws; that of Figure 5 has none.
LOOKS: Mapping[str, tuple[Look, Look]] = {
    "6": ("crunode", "crunode"),
    "7": ("cusp", "cusp"),
    "8": ("crunode", "cusp"),
    "9": ("cusp", "cusp"),
    "10": ("cusp", "crunode"),
    "11": ("smooth", "smooth"),
    "12": ("cusp", "cusp"),
}
# Concave stretch: kidney beans and crescents turn inward once.
CONCAVE_ONCE = ("11", "12")
# The caption of Figure 8 names no material, the others "different material": both resins. Figure
# 8 is judged on R-914, which alone takes up the 7 % that the paper works with.
JUDGED_ON: Mapping[str, tuple[str, ...]] = {"8": ("R-914",)}
BOTH_RESINS = ("R-914", "8551-7")


@dataclass(frozen=True)
class Shape:
    """What a coupler curve looks like.

    Parameters
    ----------
    crunodes : tuple of DoublePoint
        And cusps, if the curve has one to the last digit.
    inflections : int
    bend_angle : float
        Crank angle in rad of the sharpest bend.
    bend_radius : float
        Radius of curvature there in m.
    size : float
        Greater extent of the curve in m.
    """

    crunodes: tuple[DoublePoint, ...]
    inflections: int
    bend_angle: float
    bend_radius: float
    size: float

    @property
    def look(self) -> Look:
        """The shape in a word."""
        if self.crunodes:
            return "crunode"
        return "cusp" if self.bend_radius < SHARP * self.size else "smooth"


def shape_of(curve: CouplerCurve, angles: int = 3600) -> Shape:
    """Shape of a curve over a full turn of the crank."""
    turn = np.linspace(0, 2 * np.pi, angles, endpoint=False)
    curvature = curve.curvature(turn)
    turning = np.sign(curvature)
    step, middle = turn[1], turn[np.abs(curvature).argmax()]
    for _ in range(REFINEMENTS):
        near = np.linspace(middle - step, middle + step, 101)
        bent = np.abs(curve.curvature(near))
        step, middle = near[1] - near[0], near[bent.argmax()]
    return Shape(
        crunodes=double_points(curve.linkage, curve.point),
        inflections=int(np.sum(turning != np.roll(turning, 1))),
        bend_angle=float(middle),
        bend_radius=float(1 / bent.max()),
        size=float(np.ptp(curve.position(turn), axis=0).max()),
    )


NO_COUNTS = (None, None, None)


@dataclass(frozen=True)
class FigureClaim:
    """A figure's words and what was found.

    Parameters
    ----------
    figure : str
    claim : str
    dry, wet, other : int or None
        Crunodes dry, with R-914 and with 8551-7 saturated at 80 K; None where no curve is.
    verdict : {"reproduced", "not reproduced", "not judged"}
    reason : str
    """

    figure: str
    claim: str
    dry: int | None
    wet: int | None
    other: int | None
    verdict: Verdict
    reason: str


def judged(
    figure: str,
    shapes: Mapping[str, Shape],
    moved: Mapping[str, float],
    cusps: Sequence[CuspTransition] = (),
) -> FigureClaim:
    """A figure's claim against its curves.

    Parameters
    ----------
    figure : str
        From 5 on.
    shapes : mapping of str to Shape
        ``"dry"`` and of each resin.
    moved : mapping of str to float
        Greatest distance in m by which each wet resin moves the point.
    cusps : sequence of CuspTransition
        Moistures at which the curve of R-914 has a cusp, at 80 K.

    Returns
    -------
    FigureClaim
        Reproduced if all that the caption says holds for every curve that it draws.
    """
    resins = JUDGED_ON.get(figure, BOTH_RESINS)
    failed = [text for name in resins for text in _failures(figure, name, shapes, moved[name])]
    if figure in LOOKS:
        failed = _looks_otherwise(LOOKS[figure][0], "dry", shapes["dry"]) + failed
    number = {name: len(shape.crunodes) for name, shape in shapes.items()}
    reason = "; ".join(
        [
            *([f"against the caption: {', '.join(failed)}"] if failed else []),
            *(["judged on R-914: no material is named"] if figure in JUDGED_ON else []),
            f"dry {_words(shapes['dry'])}",
            *(
                f"{name} wet {_words(shapes[name])}, point moved by up to {1e3 * distance:.4g} mm"
                for name, distance in moved.items()
            ),
            *(
                f"a cusp in the strict sense at {100 * cusp.parameter:.4g} % alone"
                for cusp in cusps
            ),
        ]
    )
    return FigureClaim(
        figure,
        CLAIMS[figure],
        number["dry"],
        number["R-914"],
        number["8551-7"],
        verdict_on(not failed),
        reason,
    )


def _failures(figure: str, resin: str, shapes: Mapping[str, Shape], moved: float) -> list[str]:
    """In what a wet curve is not as the caption has it."""
    dry, wet = shapes["dry"], shapes[resin]
    failed = [] if deviates(moved, dry.size) else [f"{resin} does not deviate"]
    if figure in LOOKS:
        failed += _looks_otherwise(LOOKS[figure][1], f"{resin} wet", wet)
    if figure in CONCAVE_ONCE and not dry.inflections == wet.inflections == 2:
        failed.append(f"{resin} is not concave once")
    return failed


def _looks_otherwise(said: Look, name: str, shape: Shape) -> list[str]:
    return [] if shape.look == said else [f"{name} is no {said} but a {shape.look}"]


def deviates(moved: float, size: float) -> bool:
    """Whether a point has moved by more than a picture of its path hides."""
    return moved > VISIBLE * size


def _words(shape: Shape) -> str:
    if shape.crunodes:
        number = len(shape.crunodes)
        return f"{number} crunode{'s' if number > 1 else ''}"
    return (
        f"no crunode, {shape.inflections} inflections, sharpest bend of radius "
        f"{1e3 * shape.bend_radius:.2g} mm in {1e3 * shape.size:.4g} mm"
    )


@dataclass(frozen=True)
class PinPaths:
    """What was found of a pin's path with links of R-914.

    Parameters
    ----------
    apart : float
        Greatest distance in m of the path from the dry one.
    moved : float
        Greatest distance in m of the pin from its dry place at the same crank angle.
    size : float
        Greater extent of the dry path in m.
    state : str
    unknown : str
        What is not known of the links in the caption's state; empty if there is nothing.
    """

    apart: float
    moved: float
    size: float
    state: str
    unknown: str


def judged_pin(figure: str, found: PinPaths) -> FigureClaim:
    """Claim of Figure 3 or 4, whose curves have no double points, in its caption's state.

    Along an arc a pin may move and its path not deviate: the distance of the paths counts.
    """
    holds = deviates(found.apart, found.size)
    words = "deviates" if holds else "does not deviate"
    reason = (
        f"R-914 at {found.state} {words}: its path is up to {1e3 * found.apart:.4g} mm off the dry "
        f"one of {1e3 * found.size:.4g} mm, the pin moves by up to {1e3 * found.moved:.4g} mm"
    )
    if found.unknown:
        reason += f"; a path needs no stiffness, which is not known there: {found.unknown}"
    return FigureClaim(figure, CLAIMS[figure], *NO_COUNTS, verdict_on(holds), reason)


def other_claims(refusal: str) -> list[FigureClaim]:
    """What the paper says of resins that cannot be, or cannot be known.

    Parameters
    ----------
    refusal : str
        What 8551-7 says to 7 % of water; empty if it takes them up.
    """
    unknown = "the paper prints no property of resin 3502"
    water = refusal or "8551-7 takes up as much"
    claim = "7 % moisture in 8551-7"
    return [
        FigureClaim("3 and 4", "paths of A and B, 3502", *NO_COUNTS, verdict_on(None), unknown),
        FigureClaim("all", claim, *NO_COUNTS, verdict_on(not refusal), water),
    ]
