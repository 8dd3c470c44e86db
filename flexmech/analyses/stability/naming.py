"""Names of unstable bands: which frequencies add up to a multiple of the crank's.

A name holds whatever speeds a map was asked for: modes are followed from standstill in the same
steps in every map (:func:`following_speeds`), and nothing else than the mode that grows fastest in
the band decides. A real multiplier has met its own conjugate, so that both modes are the same, and
is positive for an even order and negative for an odd one; any other multiplier is that of two
different modes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.damping_ratios import TURN, with_damping_time
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.analyses.stability.engine_stability import Kind, TrackedSpeed
from flexmech.analyses.stability.mode_tracking import likeness, track_modes
from flexmech.analyses.stability.selected_modes import GROWS, SelectedModes, wrapped
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError

# A branch that is a smaller part of the mode that grows has no part in the band: two that meet
# have about 0.7 each, and what others are like by chance is a twentieth.
LEAST_PART = 0.15
# Farther from a whole multiple, relative to the crank's frequency, there is no name: half-way to
# the next one chance would name it as well.
FARTHEST = 0.25
# In a band frequencies are pulled to its order: by no more than its growth tells, or by this, which
# interpolation between speeds a fortieth of the lowest frequency apart leaves in a narrow band.
PULLED = 0.01
# In turns: the angle of a multiplier that is real but for round-off.
REAL = 1e-6
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
        From 1; empty without a name, and where a mode diverges.
    order : int
        0 without branches.
    mismatch : float
        How far ``(f_a + f_b) / f_crank`` or ``(f_a - f_b) / f_crank`` is from the order.
    frequencies : tuple of float
        ``f_a`` and ``f_b`` in Hz beside the band; empty without branches.
    """

    kind: Kind
    branches: tuple[int, ...]
    order: int
    mismatch: float
    frequencies: tuple[float, ...] = ()


UNNAMED = BandName("unnamed", (), 0, float("nan"))
DIVERGENCE = BandName("divergence", (), 0, float("nan"))
# Damping that closes a band lies within this factor of what the two modes of its name need: within
# 1.2 in bands whose modes were followed to them from far below; of wrong names it is 4 to 17.
CLOSING_WITHIN = 2.0


def closing_fits(
    name: BandName, growth_rate: float, start: float, closing: float, lowest: float
) -> bool:
    """Whether the damping that closes a band is what the modes of its name need.

    Two modes that meet grow with ``(s + d_a) (s + d_b) = g^2``, in which ``d`` are their rates of
    decay and ``g`` is the growth without damping (Nayfeh and Mook, combination resonances); the
    band is closed where ``d_a d_b = g^2``. A damping ratio Z of all links has
    ``d_k = Z omega_k^2 / omega_1``.

    Parameters
    ----------
    name : BandName
    growth_rate : float
        Greatest in the band, in 1/s.
    start : float
        Damping ratio at which it grows so.
    closing : float
        Damping ratio that closes the band.
    lowest : float
        ``omega_1`` in rad/s.

    Returns
    -------
    bool
        True where nothing can be compared: without a name, for a difference of frequencies, or
        where no damping closes the band.
    """
    comparable = name.kind in ("principal", "sum") and np.isfinite(closing) and closing > start
    if not comparable or min(name.frequencies) <= 0:
        return True
    decay = (2 * np.pi * np.array(name.frequencies)) ** 2 / lowest
    needed = float(np.sqrt(np.prod(growth_rate + start * decay) / np.prod(decay)))
    return bool(1 / CLOSING_WITHIN < closing / needed < CLOSING_WITHIN)


def band_name(
    frequency: FloatArray,
    part: FloatArray,
    usual: FloatArray,
    crank_frequency: float,
    pull: float,
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
    pull : float
        How far growth may pull the sum of the frequencies, over the crank's frequency.
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
                pulled = max(PULLED, pull)
                found.append((common / (1 + ((ratio - order) / pulled) ** 2), name))
    if not found:
        return UNNAMED
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


def following_speeds(fastest: float, step: float) -> FloatArray:
    """Crank speeds at which modes are followed for names, the same in every map.

    Parameters
    ----------
    fastest : float
        Crank speed that the map reaches, rad/s.
    step : float
        rad/s.

    Returns
    -------
    ndarray, shape (n,)
        Multiples of the step, from the second to the first beyond the fastest speed.
    """
    last = max(2, int(np.floor(abs(fastest) / step)) + 1)
    return np.asarray(np.sign(fastest) * step * np.arange(2, last + 1))


def passes_through(
    name: BandName, ends: tuple[float, float], tracked: Sequence[TrackedSpeed]
) -> bool:
    """Whether the two multipliers of a difference have one Krein signature beside the band.

    Such multipliers meet on the unit circle and stay on it. Those of sums have opposite ones
    unless the Hamilton function is far from definite.

    Parameters
    ----------
    name : BandName
    ends : tuple of float
        Of the band in rad/s.
    tracked : sequence of TrackedSpeed
        By increasing size of the speed.

    Returns
    -------
    bool
    """
    first, second = signatures_of(name, ends, tracked)
    return name.kind == "difference" and first * second > 0


def name_of_growth(
    modes: SelectedModes, followed: Sequence[SelectedModes], *, differences: bool
) -> BandName:
    """Name of the band that grows fastest at these modes.

    Parameters
    ----------
    modes : SelectedModes
        Where it grows fastest.
    followed : sequence of SelectedModes
        At some of :func:`following_speeds`, by increasing size of the speed.
    differences : bool
        Whether differences of frequencies can be unstable.

    Returns
    -------
    BandName
        :data:`DIVERGENCE` where the mode grows without oscillating.
    """
    number = int(modes.exponent.real.argmax())
    if not modes.exponent.imag[number]:
        return DIVERGENCE
    size = abs(modes.crank_speed)
    before = [each for each in followed if abs(each.crank_speed) <= size]
    if not before:
        return UNNAMED
    # What comes later than the next speed tells nothing, lest a name depends on how far a map goes.
    branches = track_modes([*before, *followed[len(before) :][:1]])
    last, crank = branches.shapes[len(before) - 1], 1 / modes.period
    part = likeness(last.shape, modes.shape[..., number, None])[:, 0].reshape(-1, 2).max(axis=1)
    frequency = np.abs(last.frequency[::2])
    after = branches.modes[len(before) :]
    if after and after[0].growth_rate * after[0].period < GROWS:
        below = abs(before[-1].crank_speed)
        share = (size - below) / (abs(after[0].crank_speed) - below)
        ahead = np.abs(branches.shapes[-1].frequency[::2])
        frequency = frequency + share * wrapped(ahead - frequency, crank)
    return band_name(
        frequency,
        part,
        branches.usual_frequency,
        crank,
        2 * modes.growth_rate / size,
        differences=differences,
        is_refused=lambda name: not multiplier_fits(name, modes),
    )


def multiplier_fits(name: BandName, modes: SelectedModes) -> bool:
    """Whether the multiplier that grows fastest is one of two modes that meet as a name says.

    Parameters
    ----------
    name : BandName
    modes : SelectedModes
        Where the band grows fastest.

    Returns
    -------
    bool
    """
    parity = parity_of(modes)
    if parity is None:
        return name.kind != "principal"
    return name.kind == "principal" and parity == name.order % 2


def parity_of(modes: SelectedModes) -> int | None:
    """Whether the order of a band whose multiplier is real is even or odd.

    Parameters
    ----------
    modes : SelectedModes

    Returns
    -------
    int or None
        0 or 1 of the multiplier that grows fastest; None where it is not real.
    """
    angle = float(modes.angle[modes.exponent.real.argmax()]) / np.pi
    return round(angle) % 2 if abs(angle - round(angle)) < 2 * REAL else None


def order_is_nearest(name: BandName, solver: LinkageSolver, modes: SelectedModes) -> bool:
    """Whether the order of a name is the nearest that natural frequencies allow.

    Where the crank is slow beside a vibration, it oscillates at its natural frequency averaged over
    the turn; modes that are counted by their order at every crank angle need no following.

    Parameters
    ----------
    name : BandName
    solver : LinkageSolver
    modes : SelectedModes
        Where the band grows fastest.

    Returns
    -------
    bool
        Of a principal band only every second order is possible. False where a frozen mode does not
        oscillate, so that nothing tells.
    """
    if not name.branches:
        return True
    undamped = with_damping_time(solver.engine, 0.0)
    formulation = Formulation(solver.quasi_static, modes=max(name.branches))
    try:
        found = frequencies_at(undamped, TURN, modes.crank_speed, formulation)
    except ComputationError:
        return False
    first, second = found.mean(axis=0)[[name.branches[0] - 1, name.branches[-1] - 1]]
    meeting = abs(first - second) if name.kind == "difference" else first + second
    farthest = 1.0 if name.kind == "principal" else 0.5
    return bool(abs(meeting * modes.period - name.order) < farthest)


def without_repetition(names: Sequence[BandName]) -> list[BandName]:
    """Names of the bands of a map, in which no two have the same.

    Two modes meet at a multiple of the crank's frequency once: of equal names at most one is true.
    """
    meetings = [(name.kind, name.branches, name.order) for name in names]
    return [
        UNNAMED if name.branches and meetings.count(meeting) > 1 else name
        for name, meeting in zip(names, meetings, strict=True)
    ]
