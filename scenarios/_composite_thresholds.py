"""Thresholds of instability of the composite crank-rockers: maps, their scale, and the claims."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pandas as pd
from _ground_axes import frozen_eigenvalues
from papers._claims import Claim, verdict_on, within_a_tenth
from papers._elamy_linkages import crank_rocker, published_case

from flexmech import Mechanism, ReferenceEngine, natural_frequencies, stability
from flexmech.arrays import FloatArray
from flexmech.sections import LayerDirection

__all__ = [
    "CASES",
    "DAMPING_RATIO",
    "LAMINATES",
    "LAYERS",
    "RATIOS",
    "SPEEDS",
    "CaseMap",
    "Scales",
    "case_map",
    "claims_of",
    "mapped_bands",
    "scales",
]

CASES, LAMINATES = (1, 2, 3, 4), ("C1", "C2", "C3", "C4", "C5", "C6")
# The paper's links are cut from flat sheets.
LAYERS: tuple[LayerDirection, ...] = ("across width", "through thickness")
# Of the links, at which bands are mapped: what they grow by is told at this damping.
DAMPING_RATIO = 0.001
# Of the thresholds. In percent the paper's damping factors, 0.231 to 0.461, lie among them.
RATIOS = (0.001, 0.002, 0.005)
# Over the lowest natural frequency of the turn, a step apart that is as wide as the narrowest first
# band: narrower ones can be missed. Not far beyond the last one case 4 has no equilibrium.
SPEEDS = np.linspace(0.2, 0.67, 672)
FROZEN_SPEEDS = np.linspace(0.01, 0.67, 34)
TURN = np.radians(np.arange(0.0, 361.0, 5.0))
FROZEN_MODES = 3
# By which frequencies fall from C1 to C6 in the paper, in percent.
PRINTED_FALL = 62.22


@dataclass(frozen=True)
class CaseMap:
    """One linkage, whatever its stacking: speeds and rates over the lowest natural frequency.

    Parameters
    ----------
    case : int
    lowest : float
        First natural frequency at rest of the linkage computed, in rad/s, at the crank angle where
        it is least.
    lowest_angle : float
        That crank angle in rad.
    mean : float
        The first natural frequency averaged over the turn, over the lowest.
    frequency : ndarray, shape (A, 2)
        First two natural frequencies at rest over ``TURN``.
    bands : DataFrame
        ``lower``, ``upper`` (edges), ``growth`` and ``closing`` (a damping ratio), ``error`` of the
        edges, and ``open`` (whether it goes on beyond the fastest speed). Without names: in case 2
        modes change places so often that the step decides which ones are said to meet.
    frozen : ndarray, shape (S, A)
        Greatest real part of the frozen eigenvalues over ``FROZEN_SPEEDS`` and ``TURN``.
    frozen_least : float
        Least imaginary part of all of them: zero where a position diverges.
    """

    case: int
    lowest: float
    lowest_angle: float
    mean: float
    frequency: FloatArray
    bands: pd.DataFrame
    frozen: FloatArray
    frozen_least: float

    def first(self, ratio: float) -> pd.Series:
        """First band that a damping ratio leaves open; not a number where there is none."""
        left = self.bands[self.bands["closing"] > ratio]
        if left.empty:
            return pd.Series(np.nan, index=self.bands.columns)
        return left.iloc[0]

    def threshold(self, ratio: float) -> float:
        """Crank speed at which that band opens."""
        return float(self.first(ratio)["lower"])

    def damping_time(self, ratio: float) -> float:
        """Kelvin-Voigt time in s of the linkage computed at a damping ratio."""
        return 2 * ratio / (self.lowest * self.mean)

    @property
    def thresholds(self) -> list[float]:
        """Crank speeds at which the first bands open at ``RATIOS``."""
        return [self.threshold(ratio) for ratio in RATIOS]

    @property
    def deviation(self) -> float:
        """Greatest deviation of the transmission angle from a right one, in rad."""
        limits = published_case(self.case).transmission_angle_limits()
        return max(abs(limit - np.pi / 2) for limit in limits)

    @property
    def frozen_threshold(self) -> float:
        """Crank speed from which on an eigenvalue of a frozen position grows; else infinite."""
        greatest = self.frozen.max(axis=1)
        if not (greatest > 0).any():
            return float("inf")
        place = int(np.argmax(greatest > 0))
        if place == 0:
            return float(FROZEN_SPEEDS[0])
        around = slice(place - 1, place + 1)
        return float(np.interp(0.0, greatest[around], FROZEN_SPEEDS[around]))

    @property
    def frozen_angle(self) -> float:
        """Crank angle in rad at which it grows most where it begins to; else not a number."""
        growing = np.flatnonzero(self.frozen.max(axis=1) > 0)
        if not growing.size:
            return float("nan")
        return float(TURN[self.frozen[growing[0]].argmax()])


def case_map(
    case: int, *, speeds: FloatArray = SPEEDS, laminate: str = "C1", elements: int = 4
) -> CaseMap:
    """Map the bands and the frozen eigenvalues of one linkage.

    Parameters
    ----------
    case : int
    speeds : ndarray, shape (S,)
        Crank speeds over the lowest natural frequency.
    laminate : str
        Of the linkage computed.
    elements : int
        Elements a link.

    Returns
    -------
    CaseMap
    """
    engine = ReferenceEngine(crank_rocker(case, laminate), elements, "euler")
    frequency = 2 * np.pi * natural_frequencies(engine, TURN, modes=2)
    lowest = float(frequency[:, 0].min())
    mean = float(frequency[:-1, 0].mean())
    damped = engine.with_(mechanism=_damped(engine.mechanism, 2 * DAMPING_RATIO / mean))
    speed, angle = (grid.ravel() for grid in np.meshgrid(FROZEN_SPEEDS, TURN, indexing="ij"))
    values = frozen_eigenvalues(damped, angle, lowest * speed, modes=FROZEN_MODES) / lowest
    return CaseMap(
        case,
        lowest,
        float(TURN[frequency[:, 0].argmin()]),
        mean / lowest,
        frequency / lowest,
        mapped_bands(engine.mechanism, lowest, speeds, elements),
        values.real.max(axis=1).reshape(len(FROZEN_SPEEDS), len(TURN)),
        float(values.imag.min()),
    )


def mapped_bands(
    mechanism: Mechanism, lowest: float, speeds: FloatArray, elements: int = 4
) -> pd.DataFrame:
    """Bands of a linkage at the light damping, in the order of their lower edges.

    Parameters
    ----------
    mechanism : Mechanism
    lowest : float
        Natural frequency in rad/s by which speeds and rates are divided.
    speeds : ndarray, shape (S,)
        Over it.
    elements : int

    Returns
    -------
    DataFrame
        As of :class:`CaseMap`.
    """
    engine = ReferenceEngine(mechanism, elements, "euler")
    mapped = stability(
        engine,
        lowest * speeds,
        prestress="equilibrium",
        modes=3,
        damping_ratio=DAMPING_RATIO,
    )
    found = mapped.bands()
    bands = pd.DataFrame(
        {
            "lower": found["from_rad_s"] / lowest,
            "upper": found["to_rad_s"] / lowest,
            "error": found["error_rad_s"] / lowest,
            "growth": found["largest_growth_rate_1_s"] / lowest,
            # No damping ratio below 1 closes what has none.
            "closing": found["closing_damping_ratio"].fillna(1.0),
            "open": mapped.dataset["band_upper_open"].values,
        }
    )
    return bands.sort_values("lower", ignore_index=True)


def _damped(mechanism: Mechanism, time: float) -> Mechanism:
    sections = {
        name: section.with_damping_time(time) for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


@dataclass(frozen=True)
class Scales:
    """``sqrt(EI / (rho A))`` of the links in m^2/s: all links of a linkage have one section.

    Parameters
    ----------
    values : DataFrame
        Laminates by the way their plies lie.
    """

    values: pd.DataFrame

    def over(self, laminate: str = "C1", layers: LayerDirection = LAYERS[0]) -> pd.DataFrame:
        """All over that of one."""
        return self.values / self.values.loc[laminate, layers]

    @property
    def falls(self) -> bool:
        """Whether every laminate has less than the one before, whichever way the plies lie."""
        return bool((self.values.diff().iloc[1:] < 0).all(axis=None))


def scales() -> Scales:
    """Scales of all laminates, from the sections of their model files."""
    rows = {}
    for laminate in LAMINATES:
        sections = {
            layers: crank_rocker(1, laminate, layers=layers).sections["coupler"]
            for layers in LAYERS
        }
        rows[laminate] = {
            layers: np.sqrt(one.bending_stiffness / one.mass_per_length)
            for layers, one in sections.items()
        }
    return Scales(pd.DataFrame(rows).T)


def claims_of(maps: Sequence[CaseMap], scale: Scales) -> list[Claim]:
    """What the paper says of frequencies and of smooth running, put to the thresholds.

    Parameters
    ----------
    maps : sequence of CaseMap
        Of all cases.
    scale : Scales

    Returns
    -------
    list of Claim
        A comparison counts where the errors of both speeds leave it; one with a threshold that
        was not found does not hold.
    """
    by_case = {each.case: each for each in maps}
    speeds = "; ".join(
        f"case {each.case} {_span([each.lowest * z for z in each.thresholds], '.0f')}"
        for each in maps
    )
    speeds = f"C1, damping ratios {100 * RATIOS[0]:g} to {100 * RATIOS[-1]:g} %: {speeds} rad/s"
    by_deviation = sorted(maps, key=lambda each: -each.deviation)
    fall = 100 * (1 - scale.over().loc["C6"])
    angles = [np.degrees(each.frozen_angle) for each in maps]
    return [
        Claim(
            place="abstract",
            statement="proportions and stacking change instability thresholds",
            printed="no threshold",
            from_tables="",
            computed=speeds,
            other_models="",
            verdict=verdict_on(None),
            reason="what the paper says of frequencies and of smooth running is put to the "
            "thresholds below",
            fails_if="nothing: no number is printed to compare with",
        ),
        *(
            Claim(
                place="section 5.2.2",
                statement=f"case {case} is {word} (of frequencies), of thresholds",
                printed=f"case {case}",
                from_tables="",
                computed=speeds,
                other_models="",
                verdict=verdict_on(
                    all(
                        _opens_below(*(pair if word == "lowest" else pair[::-1]), absolute=True)
                        for pair in ((by_case[case], each) for each in maps)
                        if pair[1].case != case
                    )
                ),
                fails_if=f"another case is {word} at a damping ratio, or may be by the errors",
            )
            for case, word in ((2, "lowest"), (3, "highest"))
        ),
        Claim(
            place="section 1",
            statement="the farther transmission angles are from 90 deg, the rougher the linkage "
            "runs at high speeds: the lower its threshold over its lowest frequency",
            printed="no number",
            from_tables="",
            computed=", ".join(
                f"case {each.case} (up to {np.degrees(each.deviation):.0f} deg off) "
                f"{_span(each.thresholds, '.3f')}"
                for each in by_deviation
            ),
            other_models="",
            verdict=verdict_on(all(_opens_below(*pair) for pair in pairwise(by_deviation))),
            fails_if="two cases are in the other order at a damping ratio, or may be by the errors",
        ),
        Claim(
            place="section 5.2.1",
            statement="from C1 to C6 each is below the one before (of frequencies), of thresholds",
            printed="everywhere",
            from_tables="",
            computed="; ".join(
                f"plies {layers} " + ", ".join(f"{value:.3f}" for value in column)
                for layers, column in scale.over().items()
            ),
            other_models="",
            verdict=verdict_on(scale.falls),
            reason="over C1, in every case alike",
            fails_if="one is not below the one before, whichever way the plies lie",
        ),
        Claim(
            place="section 5.2.1",
            statement="C6 is below C1 (of frequencies), of thresholds by",
            printed=f"{PRINTED_FALL} %",
            from_tables="",
            computed=", ".join(f"plies {layers} {value:.2f} %" for layers, value in fall.items()),
            other_models="",
            verdict=verdict_on(all(within_a_tenth(PRINTED_FALL, value) for value in fall)),
            reason="all of one material they bend alike, whichever way the plies lie",
            fails_if="ours is more than a tenth of the number off",
        ),
        Claim(
            place="abstract",
            statement="best at a transmission angle of 90 deg",
            printed="90 deg",
            from_tables="",
            computed="frozen eigenvalues begin to grow at crank angles of "
            + ", ".join(f"{angle:.0f}" for angle in angles)
            + f" deg (cases {', '.join(str(each.case) for each in maps)})",
            other_models="",
            verdict=verdict_on(None),
            reason="a running crank passes all positions, and frozen ones do not tell growth",
            fails_if="nothing: a threshold has no crank angle",
        ),
    ]


def _opens_below(low: CaseMap, high: CaseMap, *, absolute: bool = False) -> bool:
    """Whether a case opens first at every damping ratio, by more than the errors of the edges.

    Speeds are those over the lowest natural frequency of each, or absolute ones.
    """
    first, second = ([each.first(ratio) for ratio in RATIOS] for each in (low, high))
    scale = (low.lowest, high.lowest) if absolute else (1.0, 1.0)
    return all(
        scale[0] * (one["lower"] + one["error"]) < scale[1] * (two["lower"] - two["error"])
        for one, two in zip(first, second, strict=True)
    )


def _span(values: Sequence[float], digits: str) -> str:
    return f"{values[0]:{digits}} to {values[-1]:{digits}}"
