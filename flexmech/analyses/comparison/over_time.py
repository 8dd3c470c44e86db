"""A record over time beside the running linkage: aligned, and its damping found.

The motion of the record is the periodic one that the linkage's own inertia drives, and a free
vibration from an unknown state at its beginning. That state enters linearly: for any damping and
crank angle it is the one nearest to the record (variable projection, Golub & Pereyra 1973).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.fit import Fit, Parameter, nearest_values
from flexmech.analyses.comparison.problem import (
    CURVES,
    DAMPING,
    GAIN,
    LINEAR,
    LITTLE_EXPLAINED,
    OFFSET,
    START_ANGLE,
    ComparisonRequest,
    LinearTerms,
    RecordProblem,
    damping_times,
    fitted_engine,
    fitted_names,
    stiffness_factors,
)
from flexmech.analyses.comparison.quantities import Gauge, gauges, matched
from flexmech.analyses.damping_ratios import lowest_frequency
from flexmech.analyses.response.measurements import amplitude_spectrum
from flexmech.analyses.response.plan import SPECTRUM_REACH
from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.measured_data import MeasuredRecord, sampling_interval
from flexmech.mechanics import Engine
from flexmech.solvers import ForcedModes, FreeAndForced, forced_modes

# Singular values of the free vibrations below this part of the greatest are round-off.
_ROUND_OFF = 1e-9
# A mode is sampled if its frequency is below this part of half the sampling rate.
_SAMPLED = 0.9
# A record must be so many periods of the first mode, and so many samples for each unknown.
_LEAST_PERIODS = 3.0
_SAMPLES_AN_UNKNOWN = 4
# A wrong stiffness lets free vibrations fall behind those of the record: where by more than half a
# period, another stiffness seems nearest. So stiffness is sought in the begin of the record first,
# and this part of it follows each time.
_GROWTH = 3
# Running linkages of other stiffness that are in memory: of one central difference, and more.
# Memory and speed alone.
_MOST_MODELS = 8
# Samples of a turn among which the greatest deflection is sought: each degree, for a warning.
_TURN_SAMPLES = 361
# Relative difference of the record's own crank speed from the one given that is no rounding.
_SPEED_TOLERANCE = 0.01


@dataclass(frozen=True, kw_only=True)
class TimeProblem(RecordProblem):
    """A record of a gauge on the running linkage.

    Parameters
    ----------
    engine : Engine
    record : ndarray, shape (N,)
    names : tuple of str
    column, unit, quantity : str
    crank_speed : float
        In rad/s.
    gauge : Gauge
    time : ndarray, shape (N,)
        Evenly spaced, in s, from zero.
    angle : ndarray, shape (N,), optional
        Crank angle of each sample in rad; found from the record where it is left out.
    begin : float
        Time of the record's first sample in s.
    source : str
        File that messages name.
    """

    crank_speed: float
    gauge: Gauge
    time: FloatArray
    angle: FloatArray | None
    begin: float = 0.0
    source: str = "record"
    _models: dict[tuple[float, ...], ForcedModes] = field(default_factory=dict, repr=False)

    dimension = "time"

    def __post_init__(self) -> None:
        lowest = self.first_frequency / (2 * np.pi)
        rate, length = 1 / float(self.time[1]), float(self.time[-1])
        if rate < 2 * lowest / _SAMPLED:
            raise InputError(
                f"{self.source}: {rate:.4g} samples a second cannot show vibrations of "
                f"{lowest:.4g} Hz, the first natural frequency; sample at {4 * lowest:.3g} Hz or "
                "faster"
            )
        least = _SAMPLES_AN_UNKNOWN * (2 * MODES + 4)
        if not self._is_long_enough(len(self.time)):
            raise InputError(
                f"{self.source}: is too short: {length:.4g} s and {len(self.time)} samples; give "
                f"at least {_LEAST_PERIODS / lowest:.3g} s, {_LEAST_PERIODS:g} periods of the "
                f"first natural frequency, and {least} samples"
            )

    @cached_property
    def first_frequency(self) -> float:
        """First natural frequency at rest, averaged over a turn, in rad/s."""
        return lowest_frequency(self.engine)

    def _is_long_enough(self, samples: int) -> bool:
        """Whether so many samples hold enough of the first mode and of unknowns."""
        periods = float(self.time[samples - 1]) * self.first_frequency / (2 * np.pi)
        return samples >= _SAMPLES_AN_UNKNOWN * (2 * MODES + 4) and periods >= _LEAST_PERIODS

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Fitted parameters and their starts: a stiffness from that of the record's begin."""
        samples = len(self.time) // _GROWTH
        fits_stiffness = bool(stiffness_factors(dict.fromkeys(self.names, 1.0)))
        if not fits_stiffness or not self._is_long_enough(samples):
            return super().parameters
        begin = replace(
            self,
            record=self.record[:samples],
            time=self.time[:samples],
            angle=None if self.angle is None else self.angle[:samples],
        )
        try:
            values = nearest_values(begin)
        except ComputationError:
            return begin.parameters  # a part of the record need not tell everything
        return tuple(
            replace(parameter, start=value)
            for parameter, value in zip(begin.parameters, values.tolist(), strict=True)
        )

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Fitted parameters, and the crank angle at the beginning where the record has none."""
        return self.names if self.angle is not None else (*self.names, START_ANGLE)

    @property
    def linear_unknowns(self) -> int:
        """Numbers of the free vibration's state."""
        return self._free_states(self._as_modelled)

    def linear_terms(self, values: Mapping[str, float]) -> LinearTerms:
        """Forced motion for values by name, and the span of the free vibrations."""
        forced, free = self._motions(values)
        left, sizes, _ = np.linalg.svd(free, full_matrices=False)
        span = left[:, sizes > _ROUND_OFF * sizes[0]]
        return LinearTerms({GAIN: forced, OFFSET: np.ones(len(forced))}, span)

    def labelled(self, dataset: xr.Dataset, fit: Fit) -> xr.Dataset:
        """The dataset with time, crank angle, the periodic motion and the curves' spectra."""
        values = self.by_name(fit.values.tolist())
        angle = self._crank_angle(values)
        periodic = values.get(GAIN, LINEAR[GAIN]) * self._motions(values)[0]
        dataset["periodic"] = "time", periodic + values.get(OFFSET, LINEAR[OFFSET])
        dataset["periodic"].attrs.update(units=self.unit or "1", long_name="periodic motion")
        return (
            dataset.assign_coords(time=self.begin + self.time, crank_angle=("time", angle))
            .merge(self._spectra(dataset))
            .assign_attrs(
                free_states=self.linear_unknowns,
                bow=self._greatest_deflection(values),
                aligned_by="record" if self.angle is None else "crank angle column",
                start_angle=float(np.mod(angle[0], 2 * np.pi)),
                turned_unexplained=self._unexplained_if_reversed(fit.unexplained),
            )
        )

    def _motions(self, values: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Forced motion (N,) and free ones (N, k) at the record's times."""
        model = self._model(stiffness_factors(values))
        # Turns of the crank at each sample, in the order of time.
        phase = np.sign(self.crank_speed) * self._crank_angle(values) / (2 * np.pi)
        motion = self._motion(values)
        forced, free = motion.readings(phase)
        free = free @ motion.slowest(float(phase[0]), self._free_states(model))
        return forced, free / np.maximum(np.linalg.norm(free, axis=0), np.finfo(float).tiny)

    def _motion(self, values: Mapping[str, float]) -> FreeAndForced:
        """Free and forced motion for values by name."""
        times = damping_times(self.links, values)
        damping = [times[link] / self.unit_time if link in times else 1.0 for link in self.links]
        return self._moved(self._model(stiffness_factors(values)), tuple(damping))

    @cached_property
    def _moved(self) -> Callable[[ForcedModes, tuple[float, ...]], FreeAndForced]:
        """Free and forced motion; that of the last damping serves other crank angles."""
        last: list[tuple[int, tuple[float, ...], FreeAndForced]] = []

        def moved(model: ForcedModes, damping: tuple[float, ...]) -> FreeAndForced:
            if not last or last[0][:2] != (id(model), damping):
                last[:] = [(id(model), damping, model.with_damping(damping))]
            return last[0][2]

        return moved

    def _crank_angle(self, values: Mapping[str, float]) -> FloatArray:
        """Crank angle at each sample in rad, for values by name."""
        if self.angle is not None:
            return self.angle
        return np.asarray(np.radians(values[START_ANGLE]) + self.crank_speed * self.time)

    @property
    def _as_modelled(self) -> ForcedModes:
        """The running linkage with the stiffness of the model."""
        return self._model(stiffness_factors(dict.fromkeys(self.names, 1.0)))

    def _model(self, factors: Mapping[str, float]) -> ForcedModes:
        """The running linkage of some stiffness, whose fitted links have the unit damping."""
        key = tuple(factors.values())
        if key not in self._models:
            values = {name: self.unit_time for name in self.names if name.startswith(DAMPING)}
            values |= {f"stiffness:{link}": factor for link, factor in factors.items()}
            engine = fitted_engine(self.engine, values)
            read = [self.gauge, *(g for g in gauges(engine) if g.kind == "deflection")]
            # The first ones were of steps that the fit has left behind.
            while len(self._models) >= _MOST_MODELS:
                del self._models[next(iter(self._models))]
            self._models[key] = forced_modes(
                engine, self.crank_speed, [self._rows(engine, gauge) for gauge in read]
            )
        return self._models[key]

    def _rows(self, engine: Engine, gauge: Gauge) -> list[FloatArray | None]:
        """Reading of a gauge on each link."""
        return [gauge.row(engine) if link == gauge.link else None for link in self.links]

    def _greatest_deflection(self, values: Mapping[str, float]) -> float:
        """Greatest deflection of a link over its length in the periodic motion."""
        motion, turn = self._motion(values), np.linspace(0.0, 1.0, _TURN_SAMPLES)
        lengths = [link.length for link in self.engine.mechanism.linkage.topology.links]
        # The gauge's own reading comes first.
        return max(
            float(np.abs(motion.readings(turn, number)[0]).max()) / length
            for number, length in enumerate(lengths, 1)
        )

    def _free_states(self, model: ForcedModes) -> int:
        """Number of states of the modes that the sampling rate can show."""
        limit = _SAMPLED / 2 / float(self.time[1])
        return 2 * int(np.sum(model.frequency_ranges()[:, 1] < limit))

    def _unexplained_if_reversed(self, unexplained: float) -> float:
        """Part unexplained of the record with the other sign, where little is explained."""
        if unexplained < LITTLE_EXPLAINED:
            return float("nan")
        other = replace(self, record=-self.record)
        start = {parameter.name: parameter.start for parameter in other.parameters}
        spread = float(np.sum((self.record - self.record.mean()) ** 2))
        return other.misfit(start) / spread

    def _spectra(self, dataset: xr.Dataset) -> xr.Dataset:
        """Amplitude spectra of the three curves under a Hann window."""
        curves = np.stack([dataset[name].values for name in CURVES])
        up_to = SPECTRUM_REACH * float(self._as_modelled.frequency_ranges().max())
        frequency, amplitude = amplitude_spectrum(curves, float(self.time[1]), up_to)
        spectrum = xr.DataArray(
            amplitude,
            dims=("curve", "spectrum_frequency"),
            coords={"curve": list(CURVES), "spectrum_frequency": frequency},
            attrs={"units": self.unit or "1", "long_name": "amplitude"},
        )
        return xr.Dataset({"spectrum": spectrum})


def time_problem(engine: Engine, record: MeasuredRecord, request: ComparisonRequest) -> TimeProblem:
    """Read a record over time, and find the gauge that it is of.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over time.
    request : ComparisonRequest
        With a crank speed.

    Returns
    -------
    TimeProblem

    Raises
    ------
    InputError
        If the record has gaps or unequal steps, is too short or of another crank speed.
    """
    assert request.crank_speed is not None
    measured, gauge = matched(record, request.quantity, engine)
    interval = sampling_interval(record.position, record.source, record.rounding)
    time: FloatArray = interval * np.arange(len(record.position), dtype=float)
    links = engine.mechanism.linkage.topology.link_names
    return TimeProblem(
        engine=engine,
        record=np.asarray(measured.values, dtype=float),
        names=fitted_names(request.fit or (DAMPING,), links),
        column=measured.header or measured.name,
        unit=gauge.unit,
        quantity=gauge.column,
        crank_speed=request.crank_speed,
        gauge=gauge,
        time=time,
        angle=_crank_angle(record, request.crank_speed, time),
        begin=float(record.position[0]),
        source=record.source,
    )


def _crank_angle(record: MeasuredRecord, speed: float, time: FloatArray) -> FloatArray | None:
    """Crank angle at each sample in rad, where the record has it, at a constant speed."""
    if "crank_angle" not in (*record.names, *record.unreadable):
        return None
    column = record.quantity("crank_angle")
    if column.unit != "rad":
        raise InputError(
            f"{record.source}: {column.header!r} is no angle; give the crank angle in deg or rad, "
            "or leave its column out"
        )
    recorded_speed, start = np.polyfit(time, np.unwrap(np.asarray(column.values, dtype=float)), 1)
    if abs(recorded_speed - speed) > _SPEED_TOLERANCE * abs(speed):
        raise InputError(
            f"{record.source}: its crank turns at {recorded_speed:.5g} rad/s "
            f"({recorded_speed * 30 / np.pi:.5g} rpm) by the column "
            f"{column.header!r}, not at {CRANK_SPEED}; give that speed",
            crank_speed=speed,
        )
    return np.asarray(start + recorded_speed * time)
