"""Names of unstable bands: which frequencies add up to a multiple of the crank's."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.stability.engine_stability import Kind, TrackedSpeed
from flexmech.analyses.stability.mode_tracking import TrackedModes, likeness
from flexmech.analyses.stability.selected_modes import SelectedModes, wrapped
from flexmech.arrays import FloatArray

# A branch that is a smaller part of the mode that grows has no part in the band: two that meet
# have about 0.7 each, and what others are like by chance is a twentieth.
LEAST_PART = 0.15
# Farther from a whole multiple, relative to the crank's frequency, there is no name: half-way to
# the next one chance would name it as well.
FARTHEST = 0.25
# In a band frequencies are pulled to its order: by no more than its width tells, or by this, which
# interpolation between speeds a fortieth of the lowest frequency apart leaves in a narrow band.
PULLED = 0.01
# A smaller Krein signature is that of a multiplier beside the unit circle, or about to leave it:
# round-off tells its sign.
LEAST_SIGNATURE = 0.01


@dataclass(frozen=True)
class BandName:
    """What meets in a band.

    Parameters
    ----------
    kind : Kind
    branches : tuple of int
        From 1; empty without a name.
    order : int
        0 without a name.
    mismatch : float
        How far ``(f_a + f_b) / f_crank`` or ``(f_a - f_b) / f_crank`` is from the order.
    frequencies : tuple of float
        ``f_a`` and ``f_b`` in Hz beside the band; empty without a name.
    """

    kind: Kind
    branches: tuple[int, ...]
    order: int
    mismatch: float
    frequencies: tuple[float, ...] = ()


def band_name(
    frequency: FloatArray,
    part: FloatArray,
    usual: FloatArray,
    crank_frequency: float,
    width: float,
    *,
    differences: bool,
    is_refused: Callable[[BandName], bool] = lambda name: False,
) -> BandName:
    """Name of a band.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        Floquet frequencies of the branches in Hz where none of them grows, at the band's speed.
    part : ndarray, shape (m,)
        How alike the mode that grows is to the shape of each branch.
    usual : ndarray, shape (m,)
        Median of each branch's frequency over the speeds. Modes that were mixtures may have
        changed their branches; a name goes by the nearest frequency.
    crank_frequency : float
        In Hz.
    width : float
        Of the band, relative to its speed.
    differences : bool
        Whether differences of frequencies can be unstable.
    is_refused : callable, optional
        Tells names that cannot be, whatever the frequencies.

    Returns
    -------
    BandName
    """
    found: list[tuple[float, BandName]] = []
    # Of too few steps a mode may not turn at all: its frequency is zero.
    height, usual_height = (
        np.log(np.maximum(of, np.finfo(float).tiny)) for of in (frequency, usual)
    )
    label = np.abs(height[:, None] - usual_height).argmin(axis=1) + 1
    count = len(frequency)
    for a in range(count):
        for b in range(a, count):
            common = min(part[a], part[b])
            if common < LEAST_PART:
                continue
            kinds: list[tuple[Kind, float]] = [("sum", frequency[a] + frequency[b])]
            if label[a] == label[b]:
                kinds = [("principal", frequency[a] + frequency[b])]
            elif differences:
                kinds.append(("difference", abs(frequency[b] - frequency[a])))
            for kind, meeting in kinds:
                ratio = float(meeting) / crank_frequency
                order = round(ratio)
                if order == 0 or abs(ratio - order) > FARTHEST:
                    continue
                both = sorted((int(label[each]), float(frequency[each])) for each in (a, b))
                branches, frequencies = zip(*both, strict=True)
                name = BandName(kind, branches, order, abs(ratio - order), frequencies)
                if is_refused(name):
                    continue
                pulled = max(PULLED, order * width / 2)
                found.append((common / (1 + ((ratio - order) / pulled) ** 2), name))
    if not found:
        return BandName("unnamed", (), 0, float("nan"))
    return max(found, key=lambda scored: scored[0])[1]


def signatures_of(
    name: BandName, ends: tuple[float, float], tracked: Sequence[TrackedSpeed]
) -> tuple[float, float]:
    """Krein signatures of the two multipliers that meet in a band.

    Parameters
    ----------
    name : BandName
    ends : tuple of float
        Of the band in rad/s.
    tracked : sequence of TrackedSpeed

    Returns
    -------
    tuple of float
        At the nearest speed beside the band at which both are clear: those of the multipliers of
        ``f_a`` and of ``-f_b``, or of ``f_b`` for a difference. Not a number without a name, or
        where there is no such speed.
    """
    if not name.branches:
        return float("nan"), float("nan")
    first, last = name.frequencies
    sense = 1 if name.kind == "difference" else -1
    low, high = sorted(ends)
    beside = [f for f in tracked if not low <= f.crank_speed <= high]
    for each in sorted(beside, key=lambda f: max(low - f.crank_speed, f.crank_speed - high)):
        found = each.signature_of(first, 1), each.signature_of(last, sense)
        if min(map(abs, found)) > LEAST_SIGNATURE:
            return found
    return float("nan"), float("nan")


def name_of_growth(
    modes: SelectedModes,
    ends: tuple[float, float],
    tracked: Sequence[TrackedSpeed],
    branches: TrackedModes,
    *,
    differences: bool,
) -> BandName:
    """Name of the band that grows fastest at these modes.

    Parameters
    ----------
    modes : SelectedModes
    ends : tuple of float
        Of the band in rad/s.
    tracked : sequence of TrackedSpeed
        By increasing size of the speed.
    branches : TrackedModes
        At the same speeds.
    differences : bool
        Whether differences of frequencies can be unstable.

    Returns
    -------
    BandName
    """
    speeds = np.abs([each.crank_speed for each in tracked])
    below = int(np.searchsorted(speeds, abs(modes.crank_speed), side="right")) - 1
    growing = modes.shape[..., modes.exponent.real.argmax(), None]
    before = branches.shapes[max(below, 0)]
    part = likeness(before.shape, growing)[:, 0].reshape(-1, 2).max(axis=1)
    frequency = np.abs(before.frequency[::2])
    crank = 1 / modes.period
    for after, other in zip(tracked[below + 1 :], branches.shapes[below + 1 :], strict=True):
        if not after.is_unstable:
            ahead = np.abs(other.frequency[::2])
            step = abs(after.crank_speed) - speeds[below]
            share = (abs(modes.crank_speed) - speeds[below]) / step
            frequency = frequency + share * wrapped(ahead - frequency, crank)
            break
    width = (ends[1] - ends[0]) / abs(modes.crank_speed)

    def pass_through(name: BandName) -> bool:
        # Multipliers of one Krein signature meet on the unit circle and stay on it. Sums meet with
        # opposite ones unless the Hamilton function is far from definite.
        first, second = signatures_of(name, ends, tracked)
        return name.kind == "difference" and first * second > 0

    return band_name(
        frequency,
        part,
        branches.usual_frequency,
        crank,
        width,
        differences=differences,
        is_refused=pass_through,
    )
