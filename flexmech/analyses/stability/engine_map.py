"""Stability of one engine's linkage over crank speeds: modes, unstable bands, errors."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, compress
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.damping_ratios import lowest_frequency, with_damping_time
from flexmech.analyses.parallel import in_order
from flexmech.analyses.requests import CHECKED_SPEEDS
from flexmech.analyses.stability.collisions import MetModes, meetings, met, promising
from flexmech.analyses.stability.edges import (
    UNNAMED,
    ClosingSearch,
    EdgeSearch,
    FoundEdge,
    closing_damping_ratio,
    closing_fits,
    edge_errors,
    exponent_errors,
    find_edge,
    find_top,
    following_speeds,
    name_of_growth,
    order_is_nearest,
    passes_through,
    signatures_of,
    without_repetition,
)
from flexmech.analyses.stability.growth import (
    Band,
    BandEdge,
    EngineStability,
    ExponentErrors,
    NoEquilibrium,
    Sample,
    SignedGrowth,
    TrackedSpeed,
    dips,
    runs_of_growth,
    speeds_between,
    speeds_inside,
)
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.speed_range import speeds_without_equilibrium, with_windows
from flexmech.arrays import ROUND_OFF, FloatArray, LabelledProgress
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.mechanics import Engine
from flexmech.solvers import NonlinearOrbit
from flexmech.solvers.floquet_modes import SelectedModes, matched
from flexmech.solvers.stability import LinkageSolver, SolvedSpeed, track_modes
from flexmech.units import from_si

logger = logging.getLogger(__name__)

# Branches are numbered at this part of the lowest natural frequency, where they are those of the
# linkage at rest, and tracked in steps of it, in which frequencies change by far less than what
# tells modes from each other.
FOLLOWING_STEP = 1 / 40
# Speeds beyond, 250 times the lowest frequency, come from wrong units.
MOST_STEPS = 10_000
# A band that this damping ratio closes is not worth a line: no material has less than ten times it.
LEAST_CLOSING_RATIO = 1e-5
# Between growing speeds farther apart than this part of the lowest frequency, a band may end and
# another begin: bands that are narrower are found by the modes that meet in them.
BETWEEN = 1 / 300
# Bands narrower than this part of the range of speeds, and than the distance above, are strokes in
# a picture; others are divided into so many parts, to show their growth and their gaps.
LEAST_SHOWN, SHOWN_PARTS = 1e-2, 6

# Speeds whose periodic motions one process finds, each from the one before. Speed alone: the first
# takes three times as long as another.
CHAIN = 6

# Modes at a speed, or why there are none.
_Outcome = SolvedSpeed | ComputationError
Item = TypeVar("Item")
Answer = TypeVar("Answer")


def map_engine(
    engine: Engine, request: StabilityRequest, report: LabelledProgress
) -> EngineStability:
    """Stability map of one engine.

    Parameters
    ----------
    engine : Engine
    request : StabilityRequest
    report : callable
        Progress: ``report(label, done, total)``.

    Returns
    -------
    EngineStability
        What was done before an interruption, if one came while the speeds were solved for.

    Raises
    ------
    ComputationError
        If there is an equilibrium at none of the speeds.
    """
    return _EngineMap(engine, request, report).made()


class _EngineMap:
    """The steps that lead to an engine's map."""

    def __init__(self, engine: Engine, request: StabilityRequest, report: LabelledProgress) -> None:
        self._request = request
        self._report = report
        self._lowest = lowest_frequency(engine)
        _refuse_too_many_steps(request, self._lowest)
        # A damping ratio is the factor on the damping of links whose time is that of ratio 1.
        by_ratio = with_damping_time(engine, 2 / self._lowest)
        self._by_ratio = LinkageSolver(
            by_ratio, request.prestress, request.modes, steps=request.steps, frame=request.frame
        )
        self._has_own_damping = request.damping_ratio is None and engine.has_damped_links
        if request.damping_ratio is not None:
            self._solver = replace(self._by_ratio, damping=request.damping_ratio)
        elif self._has_own_damping:
            self._solver = replace(self._by_ratio, engine=engine)
        else:
            self._solver = replace(self._by_ratio, damping=0.0)
        if request.prestress == "trajectory":
            running = self._solver.engine
            if running is by_ratio:
                running = with_damping_time(engine, self._solver.damping * 2 / self._lowest)
            self._by_ratio = replace(self._by_ratio, orbit_engine=running)
            self._solver = replace(self._solver, orbit_engine=running)

    def made(self) -> EngineStability:
        every = self._request.crank_speeds.tolist()
        # A periodic motion may run where there is no quasi-static equilibrium.
        probed = [] if self._request.prestress == "trajectory" else every
        refused = speeds_without_equilibrium(self._solver, probed)
        solvable = [speed for speed in every if speed not in refused]
        if not solvable:
            raise next(iter(refused.values()))
        if self._request.prestress != "trajectory":
            self._open_windows(solvable)
        outcomes, interrupted = self._outcomes(solvable)
        asked = set(self._request.crank_speeds.tolist())
        refused |= {w: each for w, each in outcomes.items() if isinstance(each, ComputationError)}
        solved = [each for each in outcomes.values() if isinstance(each, SolvedSpeed)]
        if not solved:
            raise self._without_any(refused)
        fastest = abs(self._request.crank_speeds[-1]) * (1 + ROUND_OFF)
        branches = track_modes([each.modes for each in solved])
        tracked = [
            _tracked(each, modes, alike)
            for each, modes, alike in zip(solved, branches.modes, branches.likeness, strict=True)
        ]
        # The last one followed is beyond the speeds asked for.
        slowest = abs(self._request.crank_speeds[0]) * (1 - ROUND_OFF)
        asked_for = [each for each in solved if slowest <= abs(each.modes.crank_speed) <= fastest]
        if not asked_for:
            raise self._without_any(refused)
        definite = all(each.is_definite for each in asked_for)
        bands: list[Band] = []
        samples: list[Sample] = []
        narrower = 0
        within = [f for f in tracked if slowest <= abs(f.crank_speed) <= fastest]
        errors: list[ExponentErrors] = []
        measure = SignedGrowth(self._solver).of_exponents
        samples += [
            Sample(f.crank_speed, measure(f.exponent, f.period), f.growth_rate) for f in within
        ]
        try:
            if not interrupted and within:
                found, narrower = self._meetings(within)
                samples += [sample for meeting in found for sample in meeting.samples]
                every_mode = [each.modes for each in solved]
                at = np.array([modes.crank_speed for modes in every_mode])
                followed = list(compress(every_mode, _among(self._following_speeds(), at)))
                bands, errors = self._bands(within, followed, samples, list(refused), definite)
        except KeyboardInterrupt:
            interrupted = True
        unit = self._request.shown_unit
        speeds: list[TrackedSpeed | NoEquilibrium] = [
            *(each for each in tracked if each.crank_speed in asked),
            *(NoEquilibrium(w, e.in_unit(unit)) for w, e in refused.items() if w in asked),
        ]
        return EngineStability(
            engine=self._solver.engine,
            speeds=sorted(speeds, key=lambda each: abs(each.crank_speed)),
            bands=bands,
            growth=samples,
            errors=errors,
            is_definite=definite,
            moving_modes=asked_for[-1].moving_modes,
            closed_early=narrower,
            interrupted=interrupted,
        )

    def _open_windows(self, speeds: Sequence[float]) -> None:
        """Build the linkage at the nodes of windows over the whole range of speeds."""
        self._by_ratio = self._with_windows("stress", self._by_ratio, speeds)
        if self._solver.engine is self._by_ratio.engine:
            self._solver = replace(self._solver, windows=self._by_ratio.windows)
        else:
            self._solver = self._with_windows("damping", self._solver, speeds)

    def _with_windows(
        self, label: str, solver: LinkageSolver, speeds: Sequence[float]
    ) -> LinkageSolver:
        """A solver with windows over a range of speeds, with progress."""
        return with_windows(solver, speeds, self._lowest, partial(self._each, label))

    def _outcomes(self, asked: Sequence[float]) -> tuple[dict[float, _Outcome], bool]:
        """Modes at the speeds asked for and those between, by which modes are tracked."""
        steps = self._following_speeds()
        steps = steps[~_among(np.array(asked), steps)]
        speeds = sorted([*asked, *steps.tolist()], key=abs)
        found: dict[float, _Outcome] = {}
        # Beside the speeds asked for modes are but followed: the equilibrium has their shapes.
        beside = replace(self._solver, prestress=self._solver.quasi_static)
        low, high = self._request.ends
        if self._request.prestress == "trajectory":
            found.update(self._without_orbit([w for w in speeds if low <= w <= high]))
        solvable = [speed for speed in speeds if speed not in found]
        tasks = [
            partial(_outcome, self._solver if low <= speed <= high else beside, speed)
            for speed in solvable
        ]
        try:
            outcomes = in_order(_answer, tasks)
            for speed, outcome in zip(solvable, outcomes, strict=True):
                found[speed] = outcome
                self._progress("speeds", len(found), len(speeds))
        except KeyboardInterrupt:
            if not any(isinstance(tried, SolvedSpeed) for tried in found.values()):
                raise
            logger.info("interrupted after %d of %d speeds", len(found), len(speeds))
            return found, True
        return found, False

    def _without_orbit(self, speeds: Sequence[float]) -> dict[float, ComputationError]:
        """Find the periodic motions at all speeds; why there is none at some."""
        chains = [speeds[n : n + CHAIN] for n in range(0, len(speeds), CHAIN)]
        refused: dict[float, ComputationError] = {}
        for motions in self._each("periodic motions", partial(_orbits, self._solver), chains):
            for speed, motion in motions.items():
                if isinstance(motion, ComputationError):
                    refused[speed] = motion
                else:
                    self._solver.orbits[speed] = motion
        return refused

    def _without_any(self, refused: dict[float, ComputationError]) -> ComputationError:
        """Why there is a motion at none of the speeds."""
        first = next(iter(refused.values()))
        if self._request.prestress != "trajectory":
            return first
        return ComputationError(
            f"{first.message}; or judge vibrations about the quasi-static equilibrium, by "
            "prestress 'equilibrium'",
            crank_speed=first.crank_speed,
        )

    def _following_speeds(self) -> FloatArray:
        return following_speeds(self._request.crank_speeds[-1], FOLLOWING_STEP * self._lowest)

    def _meetings(self, tracked: Sequence[TrackedSpeed]) -> tuple[list[MetModes], int]:
        """Modes that meet between the speeds, and grow or nearly do."""
        least = LEAST_CLOSING_RATIO
        if self._request.damping_ratio is not None:
            least = max(least, self._request.damping_ratio)
        pairs = meetings(tracked, self._request.modes)
        ends = self._request.ends
        if self._request.prestress == "trajectory":
            # Each speed takes a periodic motion; the equilibrium says where one is worth it.
            about = replace(self._solver, prestress=self._solver.quasi_static)
            quasi_static = self._with_windows("stress", about, ends)
            near = partial(promising, quasi_static, lowest=self._lowest, least_ratio=least)
            pairs = [pair for pair in self._each("meeting modes", near, pairs) if pair.meetings]
        task = partial(met, self._solver, lowest=self._lowest, least_ratio=least, ends=ends)
        answers = self._each("meeting modes", task, pairs)
        return [meeting for some, _ in answers for meeting in some], sum(
            left for _, left in answers
        )

    def _bands(
        self,
        tracked: Sequence[TrackedSpeed],
        followed: Sequence[SelectedModes],
        samples: list[Sample],
        refused: Sequence[float],
        definite: bool,
    ) -> tuple[list[Band], list[ExponentErrors]]:
        """Bands, and errors of exponents; further samples of growth are added to those known."""
        growth = SignedGrowth(self._solver)
        step = BETWEEN * self._lowest
        between = speeds_between(samples, step, refused)
        samples += self._each("growth in bands", growth.sample, between)
        seen = LEAST_SHOWN * abs(tracked[-1].crank_speed - tracked[0].crank_speed)
        inside = speeds_inside(runs_of_growth(samples, refused), SHOWN_PARTS, min(step, seen))
        samples += self._each("growth in bands", growth.sample, inside)
        samples += chain(*self._each("growth in bands", growth.into, dips(samples, refused)))
        runs = runs_of_growth(samples, refused)
        known = {sample.crank_speed: sample.signed_growth for sample in samples}
        searches = [
            EdgeSearch(inside, outside, known[inside], known[outside])
            for run in runs
            for inside, outside in run.brackets
        ]
        found_edges = self._each("edges of bands", partial(find_edge, self._solver), searches)
        ends = [
            (lower.crank_speed, upper.crank_speed)
            for lower, upper in zip(found_edges[::2], found_edges[1::2], strict=True)
        ]
        places = [(run.fastest, *pair) for run, pair in zip(runs, ends, strict=True)]
        found_tops = self._each("growth in bands", partial(find_top, self._solver), places)
        tops = [modes for modes, _ in found_tops]
        start = self._request.damping_ratio or 0.0
        closings = [
            ClosingSearch(top.crank_speed, *pair, start)
            for top, pair in zip(tops, ends, strict=True)
        ]
        edges, ratios, errors = self._measured(found_edges, closings, tracked)
        names, bands = [], []
        for n, (top, ratio) in enumerate(zip(tops, ratios, strict=True)):
            name = name_of_growth(top, followed, differences=not definite)
            possible = found_tops[n][1] and order_is_nearest(name, self._solver, top)
            if passes_through(name, ends[n], tracked) or not possible:
                name = UNNAMED
            closes = closing_fits(name, top.growth_rate, start, ratio, self._lowest)
            names.append(name if self._has_own_damping or closes else UNNAMED)
        for n, name in enumerate(without_repetition(names)):
            bands.append(
                Band(
                    lower=edges[2 * n],
                    upper=edges[2 * n + 1],
                    kind=name.kind,
                    branches=name.branches,
                    order=name.order,
                    largest_growth_rate=tops[n].growth_rate,
                    fastest_speed=tops[n].crank_speed,
                    closing_damping_ratio=ratios[n],
                    mismatch=name.mismatch,
                    signatures=signatures_of(name, ends[n], tracked),
                )
            )
        return bands, errors

    def _measured(
        self,
        edges: Sequence[FoundEdge],
        closings: Sequence[ClosingSearch],
        tracked: Sequence[TrackedSpeed],
    ) -> tuple[list[BandEdge], list[float], list[ExponentErrors]]:
        """Errors of edges, damping ratios that close bands, and errors at some steady speeds.

        None needs another's answer. The longest come first, so that no process waits in the end:
        turns at slow speeds take many steps, and at fast ones the mesh moves edges.
        """
        steady = [each.crank_speed for each in tracked if not each.is_unstable]
        # Periodic motions on the finer mesh take ten times as long: one is checked, in the middle.
        places = np.unique(np.linspace(0, len(steady) - 1, CHECKED_SPEEDS).astype(np.intp))
        if self._request.prestress == "trajectory":
            places = places[len(places) // 2 :][:1]
        speeds = [steady[place] for place in places.tolist()] if steady else []
        jobs: list[Callable[[], ExponentErrors | BandEdge | float]] = [
            *(partial(exponent_errors, self._solver, speed) for speed in speeds),
            *(partial(edge_errors, self._solver, edge) for edge in reversed(edges)),
            *(partial(closing_damping_ratio, self._by_ratio, each) for each in closings),
        ]
        answers = self._each("errors, and damping that closes bands", _answer, jobs)
        return (
            [answer for answer in answers if isinstance(answer, BandEdge)][::-1],
            [answer for answer in answers if isinstance(answer, float)],
            [answer for answer in answers if isinstance(answer, ExponentErrors)],
        )

    def _each(
        self, label: str, task: Callable[[Item], Answer], items: Sequence[Item]
    ) -> list[Answer]:
        """Answers of a task to all items, with progress."""
        answers: list[Answer] = []
        for answer in in_order(task, items):
            answers.append(answer)
            self._progress(label, len(answers), len(items))
        return answers

    def _progress(self, label: str, done: int, total: int) -> None:
        self._report(f"{self._solver.engine.name}: {label}", done, total)


def _answer(job: Callable[[], Answer]) -> Answer:
    return job()


def _outcome(solver: LinkageSolver, crank_speed: float) -> _Outcome:
    try:
        return solver.solved(crank_speed)
    except ComputationError as refusal:
        return refusal


def _orbits(
    solver: LinkageSolver, speeds: Sequence[float]
) -> dict[float, NonlinearOrbit | ComputationError]:
    """Periodic motions at speeds, each from the one before; or why there is none."""
    motions: dict[float, NonlinearOrbit | ComputationError] = {}
    for speed in speeds:
        try:
            motions[speed] = solver.orbit(speed)
        except ComputationError as refusal:
            motions[speed] = refusal
    return motions


def _refuse_too_many_steps(request: StabilityRequest, lowest: float) -> None:
    """Refuse speeds so far above the lowest frequency that no run of steps reaches them."""
    speeds, unit = request.crank_speeds, request.shown_unit
    fastest = float(speeds[np.argmax(np.abs(speeds))])
    most = MOST_STEPS * FOLLOWING_STEP * lowest
    if abs(fastest) > most:
        raise InputError(
            f"crank speed {CRANK_SPEED} is {abs(fastest) / lowest:.3g} times the lowest natural "
            f"frequency of {lowest / (2 * np.pi):.3g} Hz; branches are followed in steps of a "
            f"fortieth of it, {MOST_STEPS} at most: ask for speeds below "
            f"{from_si(most, unit):.3g} {unit}, or check the sizes, stiffnesses and masses of the "
            "links",
            crank_speed=fastest,
        )


def _among(known: FloatArray, speeds: FloatArray) -> NDArray[np.bool_]:
    """Whether each of the speeds is one of some but for round-off."""
    near = np.isclose(speeds[:, None], known, rtol=1e-9, atol=0.0)
    return np.asarray(near.any(axis=1))


def _tracked(solved: SolvedSpeed, modes: SelectedModes, alike: FloatArray) -> TrackedSpeed:
    order = matched(modes.exponent * modes.period, solved.modes.exponent * modes.period)
    return TrackedSpeed(
        crank_speed=modes.crank_speed,
        exponent=modes.exponent,
        step_error=solved.step_error[order],
        likeness=alike,
        harmonic_share=modes.harmonic_share,
        krein_signature=solved.krein_signature[order],
        liouville_defect=modes.liouville_defect,
        steps=modes.steps,
        buckled_angle=solved.buckled_angle,
        orbit_distance=solved.orbit_distance,
        orbit_residual=solved.orbit_residual,
        rigid=modes.rigid,
    )
