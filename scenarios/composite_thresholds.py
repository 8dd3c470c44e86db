"""From which crank speed on do the composite crank-rockers shake themselves up?

Elamy et al. 2023 name instability thresholds in their abstract and print none. Here they are, by
Floquet multipliers about the quasi-static equilibrium, over the four linkages and the six
stackings: the crank speed at which the first band of growth opens, its width, and the damping ratio
that closes it. Without damping there is no lowest band, for the slower the crank, the higher the
order of a band and the narrower it is: a threshold belongs to a damping ratio. Links that only bend
have one map a linkage, over the speed in parts of its lowest natural frequency; a stacking
stretches it by sqrt(EI / (rho A)), its plies parallel to the plane of motion or stacked in it.
Other stackings, computed by themselves, test that. Last, eigenvalues of frozen positions in link
frames, with rotation terms and the stress of the running links, are held against the bands. Speeds
in rad/s are of the link size that is assumed, for the paper prints none.

    python scenarios/composite_thresholds.py [--out results/composite_thresholds]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import output_folder, save_pictures
from _composite_pictures import draw_bands, draw_frozen, draw_thresholds
from _composite_thresholds import (
    CASES,
    DAMPING_RATIO,
    FROZEN_SPEEDS,
    LAYERS,
    RATIOS,
    SPEEDS,
    CaseMap,
    Scales,
    case_map,
    claims_of,
    mapped_bands,
    scales,
)
from papers._claims import Claim
from papers._elamy_linkages import crank_rocker

from flexmech.arrays import FloatArray
from flexmech.sections import LayerDirection

# Beside the C1 that is mapped: the stacking that differs most by the way its plies lie.
CHECKED_LAMINATE = "C4"
# Around the first band, over the lowest natural frequency.
BEFORE, BEYOND, CHECKED_SPEEDS = 0.02, 0.02, 5


@dataclass(frozen=True)
class ScaleCheck:
    """First band of a stacking computed by itself, beside the one that scaling gives.

    Parameters
    ----------
    case : int
    layers : {"across width", "through thickness"}
    edges : float
        Greatest difference of an edge, as a part of it.
    width, closing : float
        Differences of width and closing damping ratio, as parts of them.
    mesh : float
        Error of the edges by the mesh and the number of moving modes, as a part of them.
    """

    case: int
    layers: LayerDirection
    edges: float
    width: float
    closing: float
    mesh: float

    @property
    def scales(self) -> bool:
        """Whether the edges differ by less than the mesh leaves them known."""
        return self.edges < self.mesh


@dataclass(frozen=True)
class ThresholdAnswer:
    """Maps of the cases, scales of the stackings, how well these scale, and the claims."""

    maps: list[CaseMap]
    scale: Scales
    checks: list[ScaleCheck]
    claims: list[Claim]


def main(
    out: Path,
    *,
    cases: tuple[int, ...] = CASES,
    checked_case: int = 1,
    speeds: FloatArray = SPEEDS,
) -> ThresholdAnswer:
    """Map the linkages, test the scale, judge the claims, draw and tell all.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    cases : tuple of int
        Claims are judged where all four are mapped.
    checked_case : int
        One of them, of which other stackings are computed by themselves.
    speeds : ndarray, shape (S,)
        Crank speeds over the lowest natural frequency.

    Returns
    -------
    ThresholdAnswer
    """
    scale = scales()
    maps = [case_map(case, speeds=speeds) for case in cases]
    for found in maps:
        print(*_lines(found), sep="\n")
    (checked,) = (found for found in maps if found.case == checked_case)
    checks = [scale_check(checked, scale, layers) for layers in LAYERS]
    for check in checks:
        print(
            f"scale, case {check.case}, {CHECKED_LAMINATE}, plies {check.layers}, computed by "
            f"itself: edges {check.edges:.0e} off, width {check.width:.0e}, closing damping ratio "
            f"{check.closing:.0e}; edges are known to {check.mesh:.0e}: "
            f"{'it scales' if check.scales else 'it does not scale'}"
        )
    claims = claims_of(maps, scale) if cases == CASES else []
    for claim in claims:
        print(f"{claim.verdict}: {claim.place}, {claim.statement}: printed {claim.printed}")
        print(f"  computed {claim.computed}\n  fails if {claim.fails_if}")
        if claim.reason:
            print(f"  {claim.reason}")
    figures = {
        "thresholds": draw_thresholds(maps, scale),
        "bands": draw_bands(maps),
        "frozen": draw_frozen(maps),
    }
    save_pictures(figures, out)
    return ThresholdAnswer(maps, scale, checks, claims)


def scale_check(found: CaseMap, scale: Scales, layers: LayerDirection) -> ScaleCheck:
    """Compute the first band of another stacking, and hold it against the scaled one.

    Parameters
    ----------
    found : CaseMap
    scale : Scales
    layers : {"across width", "through thickness"}
        Of the other stacking.

    Returns
    -------
    ScaleCheck
    """
    first = found.first(DAMPING_RATIO)
    lowest = found.lowest * scale.over().loc[CHECKED_LAMINATE, layers]
    mechanism = crank_rocker(found.case, CHECKED_LAMINATE, layers=layers)
    speeds = np.linspace(first["lower"] - BEFORE, first["upper"] + BEYOND, CHECKED_SPEEDS)
    bands = mapped_bands(mechanism, lowest, speeds)
    own = bands.loc[(bands["lower"] - first["lower"]).abs().idxmin()]
    edges = [abs(own[edge] / first[edge] - 1) for edge in ("lower", "upper")]
    widths = [each["upper"] - each["lower"] for each in (own, first)]
    return ScaleCheck(
        case=found.case,
        layers=layers,
        edges=max(edges),
        width=abs(widths[0] / widths[1] - 1),
        closing=abs(own["closing"] / first["closing"] - 1),
        mesh=first["error"] / first["lower"],
    )


def _lines(found: CaseMap) -> Sequence[str]:
    """First bands of a linkage, and what its frozen positions say."""
    lines = [
        f"case {found.case}, C1: lowest natural frequency {found.lowest:.1f} rad/s, at crank angle "
        f"{np.degrees(found.lowest_angle):.0f} deg; bands up to {SPEEDS[-1]:g} of it that a "
        f"damping ratio of {100 * DAMPING_RATIO:g} % leaves open: {len(found.bands)}"
    ]
    for ratio in RATIOS:
        band = found.first(ratio)
        opens, width = band["lower"], 100 * (band["upper"] / band["lower"] - 1)
        said = (
            "no band in this range"
            if np.isnan(opens)
            else f"from {found.lowest * opens:.1f} rad/s, {opens:.4f} of the lowest frequency, "
            f"{'at least ' * bool(band['open'])}{width:.2f} % wide; closed by "
            f"{100 * band['closing']:.2f} %, a damping time of "
            f"{1e6 * found.damping_time(band['closing']):.1f} us"
        )
        lines.append(f"  damping ratio {100 * ratio:g} %: {said}")
    first, frozen = found.threshold(DAMPING_RATIO), found.frozen_threshold
    says = (
        f"one grows from {frozen:.3f} on, first at crank angle "
        f"{np.degrees(found.frozen_angle):.0f} deg"
        if np.isfinite(frozen)
        else "none grows"
    )
    diverges = found.frozen_least <= 0
    lines.append(
        f"  frozen positions up to {FROZEN_SPEEDS[-1]:g}, damping ratio {100 * DAMPING_RATIO:g} %: "
        f"{says}, {'some diverge' if diverges else 'none diverges'}; Floquet multipliers from "
        f"{first:.3f} on, so that frozen positions "
        f"{verdict_on_frozen(first, frozen)}"
    )
    return lines


def verdict_on_frozen(first: float, frozen: float) -> str:
    """What frozen eigenvalues are worth against the first band: both speeds over one frequency."""
    if frozen < first:
        return f"raise a false alarm {first / frozen:.1f} times too early"
    return "miss the first band" if frozen > first else "tell the first band"


if __name__ == "__main__":
    main(output_folder(__doc__, "results/composite_thresholds"))
