"""A record over time beside the running linkage: aligned, and its damping found.

The motion of the record is the periodic one that the linkage's own inertia drives, and a free
vibration from an unknown state at its beginning. That state enters linearly: for any damping and
crank angle it is the one nearest to the record (variable projection, Golub & Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from flexmech.analyses.comparison.fit import Parameter
from flexmech.analyses.comparison.parameters import (
    GAIN,
    OFFSET,
    Fitted,
    with_damping_times,
    with_stiffness,
)
from flexmech.analyses.comparison.quantities import Gauge, gauges
from flexmech.analyses.comparison.start import (
    START_ANGLE,
    USUAL_RATIO,
    named,
    parameters_from,
    start_values,
)
from flexmech.analyses.damping_ratios import lowest_frequency
from flexmech.choices import MODES
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.time_domain.periodic_motion import ForcedModes, FreeAndForced, forced_modes
from flexmech.types import FloatArray

# Singular values of the free vibrations below this part of the greatest tell nothing.
UNTOLD = 1e-9
# A mode is sampled if its frequency is below this part of half the sampling rate.
SAMPLED = 0.9
# A record must be so many periods of the first mode, and so many samples for each unknown.
LEAST_PERIODS = 3.0
SAMPLES_AN_UNKNOWN = 4
# Running linkages of other stiffness that are kept.
MOST_MODELS = 8
# Samples of a turn among which the greatest deflection is sought.
TURN_SAMPLES = 361


@dataclass(frozen=True)
class TimeProblem:
    """A record of a gauge on the running linkage.

    Parameters
    ----------
    engine : Engine
        Of the mechanism as its model says.
    crank_speed : float
        In rad/s.
    gauge : Gauge
    time : ndarray, shape (N,)
        Evenly spaced, in s, from zero.
    record : ndarray, shape (N,)
    angle : ndarray, shape (N,), optional
        Crank angle of each sample in rad; found from the record where it is left out.
    fitted : Fitted
    source : str
        File that messages name.
    """

    engine: Engine
    crank_speed: float
    gauge: Gauge
    time: FloatArray
    record: FloatArray
    angle: FloatArray | None
    fitted: Fitted
    source: str = "record"
    _models: dict[tuple[float, ...], ForcedModes] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        lowest = self.first_frequency / (2 * np.pi)
        rate, length = 1 / float(self.time[1]), float(self.time[-1])
        if rate < 2 * lowest / SAMPLED:
            raise InputError(
                f"{self.source}: {rate:.4g} samples a second cannot show vibrations of "
                f"{lowest:.4g} Hz, the first natural frequency; sample at {4 * lowest:.3g} Hz or "
                "faster"
            )
        least = SAMPLES_AN_UNKNOWN * (2 * MODES + 4)
        if length < LEAST_PERIODS / lowest or len(self.time) < least:
            raise InputError(
                f"{self.source}: is too short: {length:.4g} s and {len(self.time)} samples; give "
                f"at least {LEAST_PERIODS / lowest:.3g} s, {LEAST_PERIODS:g} periods of the first "
                f"natural frequency, and {least} samples"
            )

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the links."""
        return self.engine.mechanism.linkage.topology.link_names

    @cached_property
    def first_frequency(self) -> float:
        """First natural frequency at rest, averaged over a turn, in rad/s."""
        return lowest_frequency(self.engine)

    @cached_property
    def _unit_time(self) -> float:
        """Kelvin-Voigt time that damps the first mode by the usual ratio, in s."""
        return 2 * USUAL_RATIO / self.first_frequency

    @property
    def measured(self) -> FloatArray:
        """Record, (1, N)."""
        return self.record[None]

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is fitted, and from where."""
        start = start_values(self._names, self._unit_time, self.misfit)
        return parameters_from(start, self._unit_time, self.gauge.unit, float(np.std(self.record)))

    @property
    def linear_unknowns(self) -> int:
        """Numbers of the free vibration's state."""
        return len(self._free_states(self._model(dict.fromkeys(self.fitted.stiff_links, 1.0))))

    def computed(self, values: Sequence[float]) -> FloatArray:
        """Computed record (1, N) for values of the parameters, nearest to the measured one."""
        return self._nearest(self._by_name(values))[None]

    def forced(self, values: Sequence[float]) -> FloatArray:
        """Periodic part of the computed record, (N,)."""
        return self._motions(self._by_name(values))[0]

    def _by_name(self, values: Sequence[float]) -> dict[str, float]:
        return dict(zip(self._names, values, strict=True))

    @cached_property
    def _names(self) -> tuple[str, ...]:
        return named(self.fitted, free_angle=self.angle is None)

    def misfit(self, values: Mapping[str, float]) -> float:
        """Sum of squares of the residual for values by name."""
        return float(np.sum((self.record - self._nearest(values)) ** 2))

    def _nearest(self, values: Mapping[str, float]) -> FloatArray:
        forced, free = self._motions(values)
        left, sizes, _ = np.linalg.svd(free, full_matrices=False)
        span = left[:, sizes > UNTOLD * sizes[0]]
        return np.asarray(forced + span @ (span.T @ (self.record - forced)))

    def _motions(self, values: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Forced motion (N,) and free ones (N, k) at the record's times."""
        model = self._model(self.fitted.factors(values))
        forced, free = self._motion(values).readings(self._phase(values))
        free = free[:, self._free_states(model)]
        forced = values.get(GAIN, 1.0) * forced + values.get(OFFSET, 0.0)
        return forced, free / np.maximum(np.linalg.norm(free, axis=0), np.finfo(float).tiny)

    def _motion(self, values: Mapping[str, float]) -> FreeAndForced:
        """Free and forced motion for values by name."""
        times = self.fitted.times_of(self.links, values)
        damping = [times[link] / self._unit_time if link in times else 1.0 for link in self.links]
        return self._moved(self._model(self.fitted.factors(values)), tuple(damping))

    @cached_property
    def _moved(self) -> Callable[[ForcedModes, tuple[float, ...]], FreeAndForced]:
        """Free and forced motion, kept for the last damping: for other crank angles."""
        last: list[tuple[int, tuple[float, ...], FreeAndForced]] = []

        def moved(model: ForcedModes, damping: tuple[float, ...]) -> FreeAndForced:
            if not last or last[0][:2] != (id(model), damping):
                last[:] = [(id(model), damping, model.with_damping(damping))]
            return last[0][2]

        return moved

    def crank_angle(self, values: Mapping[str, float]) -> FloatArray:
        """Crank angle at each sample in rad, for values by name."""
        if self.angle is not None:
            return self.angle
        return np.asarray(np.radians(values[START_ANGLE]) + self.crank_speed * self.time)

    @property
    def fastest_frequency(self) -> float:
        """Greatest natural frequency of the moving modes in Hz."""
        return float(
            self._model(dict.fromkeys(self.fitted.stiff_links, 1.0)).frequency_ranges().max()
        )

    def _phase(self, values: Mapping[str, float]) -> FloatArray:
        """Turns of the crank at each sample, in the order of time."""
        way = np.sign(self.crank_speed)
        return np.asarray(way * self.crank_angle(values) / (2 * np.pi))

    def _model(self, factors: Mapping[str, float]) -> ForcedModes:
        """The running linkage of some stiffness, whose fitted links have the unit damping."""
        key = tuple(factors.values())
        if key not in self._models:
            damped = self.links if self.fitted.damping else self.fitted.damped_links
            engine = with_damping_times(self.engine, dict.fromkeys(damped, self._unit_time))
            engine = with_stiffness(engine, factors)
            read = [self.gauge, *(g for g in gauges(engine) if g.kind == "deflection")]
            # The first ones were of steps that the fit has left behind.
            while len(self._models) >= MOST_MODELS:
                del self._models[next(iter(self._models))]
            self._models[key] = forced_modes(
                engine, self.crank_speed, [self._rows(engine, gauge) for gauge in read]
            )
        return self._models[key]

    def _rows(self, engine: Engine, gauge: Gauge) -> list[FloatArray | None]:
        """What a gauge reads of each link."""
        return [gauge.row(engine) if link == gauge.link else None for link in self.links]

    def bow(self, values: Sequence[float]) -> float:
        """Greatest deflection of a link over its length in the periodic motion."""
        motion, turn = self._motion(self._by_name(values)), np.linspace(0.0, 1.0, TURN_SAMPLES)
        lengths = [link.length for link in self.engine.mechanism.linkage.topology.links]
        # The gauge's own reading comes first.
        return max(
            float(np.abs(motion.readings(turn, number)[0]).max()) / length
            for number, length in enumerate(lengths, 1)
        )

    def _free_states(self, model: ForcedModes) -> list[int]:
        """States of the moving modes that the sampling rate can show."""
        limit = SAMPLED / 2 / float(self.time[1])
        modes = [m for m, (_, most) in enumerate(model.frequency_ranges()) if most < limit]
        return [state + m for state in (0, model.moving.size) for m in modes]
