"""What Singh & Sanyal 2022 say of their Figures 3 to 12, and whether the curves look like it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexmech.linkages import CouplerCurve, CuspTransition, DoublePoint, double_points
from flexmech.studies import Verdict

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
# Looks dry and with R-914 wet that the words claim; None: not said.
LOOKS: Mapping[str, tuple[Look | None, Look | None]] = {
    "5": (None, None),
    "6": ("crunode", "crunode"),
    "7": (None, "cusp"),
    "8": ("crunode", "cusp"),
    "9": ("cusp", None),
    "10": ("cusp", "crunode"),
    "11": ("smooth", "smooth"),
    "12": ("cusp", "cusp"),
}
# Concave stretch: kidney beans and crescents turn inward once.
CONCAVE_ONCE = ("11", "12")


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


@dataclass(frozen=True)
class FigureClaim:
    """A figure's words and what was found.

    Parameters
    ----------
    figure : str
    claim : str
    dry, wet, other : int or None
        Crunodes dry, with R-914 and with 8551-7 saturated at 80 K; None where no curve is.
    verdict : {"reproduced", "not reproduced", "not checkable"}
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
    moved: float,
    cusps: Sequence[CuspTransition] = (),
) -> FigureClaim:
    """A figure's claim against its curves.

    Parameters
    ----------
    figure : str
        From 5 on.
    shapes : mapping of str to Shape
        ``"dry"`` and of each resin.
    moved : float
        Greatest distance in m by which the wet R-914 moves the point.
    cusps : sequence of CuspTransition
        Moistures at which the curve of R-914 has a cusp, at 80 K.

    Returns
    -------
    FigureClaim
    """
    dry, wet = shapes["dry"], shapes["R-914"]
    holds = all(
        said is None or shape.look == said
        for said, shape in zip(LOOKS[figure], (dry, wet), strict=True)
    )
    if figure in CONCAVE_ONCE:
        holds = holds and dry.inflections == wet.inflections == 2
    number = {name: len(shape.crunodes) for name, shape in shapes.items()}
    verdict: Verdict = "reproduced" if holds else "not reproduced"
    reason = f"dry {_words(dry)}; wet {_words(wet)}; point moved by up to {1e3 * moved:.4g} mm"
    for cusp in cusps:
        reason += f"; a cusp in the strict sense at {100 * cusp.parameter:.4g} % alone"
    if figure == "7":
        reason += "; dry it is the figure-eight of Figure 8's caption"
    return FigureClaim(
        figure,
        CLAIMS[figure],
        number["dry"],
        number["R-914"],
        number["8551-7"],
        verdict,
        reason,
    )


def _words(shape: Shape) -> str:
    if shape.crunodes:
        number = len(shape.crunodes)
        return f"{number} crunode{'s' if number > 1 else ''}"
    return (
        f"no crunode, {shape.inflections} inflections, sharpest bend of radius "
        f"{1e3 * shape.bend_radius:.2g} mm in {1e3 * shape.size:.4g} mm"
    )


def judged_pin(figure: str, moved: float) -> FigureClaim:
    """Claim of Figure 3 or 4, whose curves have no double points."""
    reason = (
        f"moved by up to {1e3 * moved:.4g} mm at 80 K, no number is printed; the captions' 95 K "
        "is above the wet glass transition taken here"
    )
    return FigureClaim(figure, CLAIMS[figure], None, None, None, "reproduced", reason)


def other_claims(refusal: str) -> list[FigureClaim]:
    """What the paper says of resins that cannot be, or cannot be known."""
    unknown = "the paper prints no property of resin 3502"
    return [
        FigureClaim(
            "3 and 4", "paths of A and B, 3502", None, None, None, "not checkable", unknown
        ),
        FigureClaim("all", "7 % moisture in 8551-7", None, None, None, "not reproduced", refusal),
    ]
