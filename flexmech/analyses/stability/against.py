"""Stability over the crank speed and a second parameter."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from flexmech.analyses.damping_ratios import (
    DAMPING_RATIO,
    lowest_frequency,
    with_damping_ratio,
    with_damping_time,
)
from flexmech.analyses.parallel import in_order
from flexmech.analyses.parameters import DAMPING_PARAMETER, MOISTURE, Parameters
from flexmech.analyses.stability.growth import NO, NO_EQUILIBRIUM, NOT_COMPUTED, YES, Band
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.speed_range import (
    windows_are_cheaper,
    with_windows,
)
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import ComputationError, InputError, naming, suggestion
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.quantity_lists import parse_quantities
from flexmech.solvers.floquet_modes import VibratingLinkage, step_error
from flexmech.solvers.stability import NODES, LinkageSolver
from flexmech.units import TEMPERATURE_DIFFERENCE, Dimension, parse_number, parse_quantity
from flexmech.validation import check_number, checked_array

# More are taken for a slip: each value is a map of its own.
MOST_VALUES = 1000
# Most steps of a range that a user writes: more than three digits are a slip of the keyboard.
MOST_STEPS = 999


def values_of(text: str, dimension: Dimension, default: str | None) -> list[float]:
    """Values of a parameter as a user writes them.

    Parameters
    ----------
    text : str
        A comma list, or START:STOP:STEPS, with one unit at the end for all.
    dimension : Dimension
        Dimension of the parameter.
    default : str or None
        Unit of bare numbers; None refuses them.

    Returns
    -------
    list of float
        In SI units.

    Raises
    ------
    InputError
        If it is neither, or a unit is missing or of something else.
    """

    def values(entries: str) -> list[float]:
        if default is None:
            # Without a unit it is refused, with an example.
            parse_quantity(entries.split(",")[-1].strip(), dimension)
        unit = dimension.unit if default is None else default
        return list(parse_quantities(entries, dimension, unit).values)

    if ":" not in text:
        return values(text)
    parts = [part.strip() for part in text.split(":")]
    remedy = 'write START:STOP:STEPS, as in "0:2%:20" for 20 equal steps from 0 to 2 %'
    if len(parts) != 3 or not all(parts):
        raise InputError(f"got {text!r}; {remedy}, or a comma list")
    start, stop = values(",".join(parts[:2]))
    try:
        steps = parse_number(parts[2])
    except InputError as error:
        raise InputError(
            f"got {text!r}, whose last part is not a number of steps; {remedy}"
        ) from error
    if steps != int(steps) or not 1 <= steps <= MOST_STEPS:
        raise InputError(
            f"got {text!r}; STEPS must be a whole number from 1 to {MOST_STEPS}; {remedy}"
        )
    if not stop > start:
        raise InputError(f"got {text!r}; STOP must be greater than START; {remedy}")
    count = int(steps)
    return [start + (stop - start) * number / count for number in range(count)] + [stop]


def asked_range(mechanism: Mechanism, parameter: str, text: str) -> tuple[str, list[float]]:
    """A parameter and its values as a user writes them; see :func:`values_of`.

    Bare numbers are ratios, kelvins, percent of moisture, or SI values of what needs no unit.

    Parameters
    ----------
    mechanism : Mechanism
    parameter, text : str

    Returns
    -------
    str
    list of float
        In SI units.

    Raises
    ------
    InputError
        If there is no such parameter, or as :func:`values_of`.
    """
    dimension = Parameters.of(mechanism).dimension(parameter)
    default = None if dimension.unit else ""
    if dimension is TEMPERATURE_DIFFERENCE:
        default = "K"
    # As --moisture is.
    return parameter, values_of(text, dimension, "%" if parameter == MOISTURE else default)


@dataclass(frozen=True)
class Against:
    """A parameter and its values.

    Parameters
    ----------
    parameter : str
        One of :class:`flexmech.analyses.parameters.Parameters`.
    values : ndarray, shape (P,)
        In SI units; kept ascending.
    dimension : Dimension

    Raises
    ------
    InputError
        If a value is not finite or repeats.
    """

    parameter: str
    values: FloatArray
    dimension: Dimension

    def __post_init__(self) -> None:
        values = checked_array(self.values, f"against: {self.parameter}", self.dimension.unit)
        if values.ndim != 1 or not 1 <= len(values) <= MOST_VALUES:
            raise InputError(f"against: give a list of 1 to {MOST_VALUES} values")
        if len(np.unique(values)) != len(values):
            raise InputError("against: a value repeats; give each one once")
        if self.parameter == DAMPING_PARAMETER:
            for value in values.tolist():
                check_number(value, "against: damping-ratio", bounds=DAMPING_RATIO)
        object.__setattr__(self, "values", np.sort(values))

    @classmethod
    def of(cls, mechanism: Mechanism, asked: tuple[str, ArrayLike]) -> Against:
        """A parameter of a mechanism and its values, as a user gives them.

        Parameters
        ----------
        mechanism : Mechanism
        asked : tuple of str and array_like
            Values as numbers in SI units, or as a text that :func:`values_of` reads.

        Returns
        -------
        Against

        Raises
        ------
        InputError
            If the mechanism has no such parameter, or values are impossible.
        """
        if not isinstance(asked, Sequence) or isinstance(asked, str) or len(asked) != 2:
            raise InputError(
                'against: give a parameter and its values, such as ("damping-ratio", [0.0, 0.01]), '
                f"got {asked!r}"
            )
        parameter, values = asked
        known = Parameters.of(mechanism).dimensions
        if not isinstance(parameter, str) or parameter not in known:
            raise InputError(
                f"against: there is no {parameter!r}; {suggestion(str(parameter), list(known))}"
            )
        if isinstance(values, str):
            with naming("against"):
                parameter, values = asked_range(mechanism, parameter, values)
        return cls(parameter, np.asanyarray(values), known[parameter])

    @property
    def column(self) -> str:
        """Column of tables, with the unit: ``damping_ratio`` or ``linkage_coupler_m``."""
        unit = self.dimension.unit.replace("/", "_").replace("^", "")
        return re.sub(r"\W+", "_", f"{self.parameter}_{unit}".rstrip("_"))

    def engine_at(self, engine: Engine, value: float) -> Engine:
        """The engine with the parameter at a value.

        Parameters
        ----------
        engine : Engine
        value : float
            In SI units.

        Returns
        -------
        Engine

        Raises
        ------
        InputError
            If the mechanism cannot be so.
        """
        return Parameters.of(engine.mechanism).engine_with(engine, {self.parameter: value})


# A growth rate in 1/s, and what the column ``unstable`` says.
Grown = tuple[float, str]
NOTHING: Grown = (np.nan, NO_EQUILIBRIUM)
ONE = np.ones(1)


def map_against(
    engines: Sequence[Engine],
    request: StabilityRequest,
    against: Against,
    bands: Sequence[Band],
    report: LabelledProgress,
) -> xr.Dataset:
    """Growth rates over the parameter and the crank speed.

    Parameters
    ----------
    engines : sequence of Engine
    request : StabilityRequest
    against : Against
    bands : sequence of Band
        That are known between the crank speeds. Where the parameter is the damping, growth is
        found in them too: the linkage is the same, and it costs little.
    report : callable

    Returns
    -------
    xarray.Dataset
        ``against_growth_rate`` and ``against_unstable`` over (engine, parameter, crank_speed); in
        bands ``against_band_growth_rate`` and ``against_band_unstable`` over (engine, parameter,
        against_speed). An interruption leaves the rest out and is noted as
        ``interrupted_against`` in the attributes.
    """
    asked = request.crank_speeds
    inside = np.zeros(0)
    if _is_of_damping(against, request):
        inside = np.setdiff1d(speeds_about(bands, request.ends), asked)
    speeds = np.concatenate([asked, inside])
    shape = len(engines), len(against.values), len(speeds)
    rate, state = np.full(shape, np.nan), np.full(shape, NOT_COMPUTED, dtype=object)
    interrupted = False
    try:
        for number, engine in enumerate(engines):
            _fill(rate[number], state[number], engine, request, against, speeds, report)
    except KeyboardInterrupt:
        interrupted = True
    over = ("engine", "parameter", "crank_speed"), ("engine", "parameter", "against_speed")
    count, texts = len(asked), state.astype(str)
    variables = {
        "against_growth_rate": (over[0], rate[..., :count]),
        "against_unstable": (over[0], texts[..., :count]),
    }
    if inside.size:
        variables["against_band_growth_rate"] = over[1], rate[..., count:]
        variables["against_band_unstable"] = over[1], texts[..., count:]
    words = re.sub("[-_.]", " ", against.parameter)
    attributes = {"units": against.dimension.unit or "1", "long_name": words}
    return xr.Dataset(
        variables,
        coords={"parameter": ("parameter", against.values, attributes), "against_speed": inside},
        attrs={
            "against": against.parameter,
            "against_column": against.column,
            "interrupted_against": int(interrupted),
        },
    )


def _fill(
    rate: FloatArray,
    state: NDArray[np.object_],
    engine: Engine,
    request: StabilityRequest,
    against: Against,
    crank_speeds: FloatArray,
    report: LabelledProgress,
) -> None:
    """Rates and states of one engine, (parameter, speed), row by row or speed by speed."""
    label = f"{engine.name}: {against.parameter}"
    speeds, done = crank_speeds.tolist(), 0
    if _is_of_damping(against, request):
        # The linkage is the same at all damping ratios, and damping enters the system linearly;
        # its periodic motion is not the same.
        solvers = [(slice(None), _solver(with_damping_ratio(engine, 1.0), request), against.values)]
    else:
        solvers = [
            (slice(row, row + 1), _solver(_changed(engine, request, against, value), request), ONE)
            for row, value in enumerate(against.values.tolist())
        ]
    for rows, solver, factors in solvers:
        task = partial(_at_dampings, _with_windows(solver, speeds), factors)
        for place, grown in enumerate(in_order(task, speeds)):
            rate[rows, place] = [each for each, _ in grown]
            state[rows, place] = [each for _, each in grown]
            done += len(grown)
            report(label, done, rate.size)


def _is_of_damping(against: Against, request: StabilityRequest) -> bool:
    """Whether the linkage and its motion are the same at all values of the parameter."""
    return against.parameter == DAMPING_PARAMETER and request.prestress != "trajectory"


# Parts of a band's width from its lower edge: inside, and as far outside of each edge as the first
# is inside, so that cells of a picture meet at the edges. Bands narrower than the part of the range
# are strokes.
WIDE, STROKE, NARROW = (-0.08, 0.08, 0.3, 0.5, 0.7, 0.92, 1.08), (-0.5, 0.5, 1.5), 1 / 200


def speeds_about(bands: Sequence[Band], ends: tuple[float, float]) -> FloatArray:
    """Crank speeds that show bands: inside of each, and just outside.

    Parameters
    ----------
    bands : sequence of Band
    ends : tuple of float
        Ends of the map in rad/s.

    Returns
    -------
    ndarray, shape (n,)
        Ascending, between the ends.
    """
    blocks = [np.zeros(0)]
    for band in bands:
        low, high = band.lower.crank_speed, band.upper.crank_speed
        parts = STROKE if high - low < NARROW * (ends[1] - ends[0]) else WIDE
        blocks.append(low + (high - low) * np.array(parts))
    every = np.unique(np.concatenate(blocks))
    return every[(every > ends[0]) & (every < ends[1])]


def _changed(engine: Engine, request: StabilityRequest, against: Against, value: float) -> Engine:
    """The engine at a value of the parameter, with the damping that counts."""
    changed = against.engine_at(engine, value)
    ratio = None if against.parameter == DAMPING_PARAMETER else request.damping_ratio
    return changed if ratio is None else with_damping_ratio(changed, ratio)


def _solver(engine: Engine, request: StabilityRequest) -> LinkageSolver:
    return LinkageSolver(
        engine, request.prestress, request.modes, steps=request.steps, frame=request.frame
    )


def _with_windows(solver: LinkageSolver, speeds: Sequence[float]) -> LinkageSolver:
    """The same with windows of speeds, where these take less than the speeds by themselves."""
    if len(speeds) <= NODES:
        return solver
    # However strong the damping is by whose factors the map goes.
    lowest = lowest_frequency(with_damping_time(solver.engine, 0.0))
    if not windows_are_cheaper(speeds, lowest):
        return solver
    return with_windows(solver, speeds, lowest)


def _at_dampings(solver: LinkageSolver, factors: FloatArray, speed: float) -> list[Grown]:
    """Growth at one crank speed with the damping times factors."""
    try:
        moving = solver.moving(speed)
    except ComputationError:
        return [NOTHING] * len(factors)
    buckled = moving.least_square <= 0
    grown = [_grown(solver, moving, factor) for factor in factors.tolist()]
    return [(rate, NO_EQUILIBRIUM) for rate, _ in grown] if buckled else grown


def _grown(solver: LinkageSolver, moving: VibratingLinkage, factor: float) -> Grown:
    """Growth rate, and whether it exceeds the error of the steps."""
    growth = solver.growth_at(moving, factor)
    if growth <= 0:
        return growth, NO
    modes = solver.solve(moving, factor)
    exceeds = modes.grows_beyond(step_error(moving, modes, factor))
    return modes.growth_rate, YES if exceeds else NO
