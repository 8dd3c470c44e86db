"""Response of the running linkage to a force: harmonic transfer functions H_n(f).

The linkage at a constant crank speed is a periodic system (docs/theory/harmonic_response.md). Its
answer follows from the time-varying linear equations in their moving modes; harmonic balance and
more moving modes say how far it may be off.

Harmonic transfer functions of the running linkage: tables, picture and words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_attributes, theory_lines
from flexmech.analyses.crank_speeds import RAD_S
from flexmech.analyses.damping_ratios import (
    CountedLoss,
    lowest_frequency,
    with_damping_ratio,
    with_damping_time,
)
from flexmech.analyses.datasets import (
    attributes_of,
    complex_parts,
    provenance,
    table_of,
)
from flexmech.analyses.digits import Quantity
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.hammer.request import RunningHammerRequest
from flexmech.analyses.requests import asks, engines_of
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Summary, Table, crank_speed_text, warnings_of
from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.dynamical_systems import (
    ForcedPeriodicSystem,
    balanced_response,
    floquet_modes,
    harmonic_response,
    state_modes,
)
from flexmech.errors import CRANK_SPEED, ComputationError, InputError
from flexmech.linkages import refuse_passing
from flexmech.mechanics import Engine, point_rows
from flexmech.mechanics.running.driven_connectors import DrivenConnectors
from flexmech.mechanism import Mechanism
from flexmech.solvers import forced_linkage
from flexmech.solvers.floquet_modes import VibratingLinkage
from flexmech.solvers.stability import LinkageSolver
from flexmech.threads import one_thread

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Columns of the table of peaks, and their variables.
_PEAKS = {"order": "order", "peak_m_N": "peak", "peak_frequency_Hz": "peak_frequency"}
_ERRORS = ("step_error", "balance_error", "reduction_error")


class RunningHammerTest(Result):
    """Harmonic transfer functions of the running linkage, and those of the frozen one.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``receptance`` and ``frozen``, each by its real and imaginary part, over (order, frequency
        of the force); peaks and errors over ``order``.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "harmonic_frf"
    subject = "hammer test on the running linkage"
    hallmark = "peak_frequency"

    def peaks(self) -> pd.DataFrame:
        """Greatest amplitude of each order.

        Returns
        -------
        pandas.DataFrame
        """
        return table_of(self.dataset, ("order",), _PEAKS)

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw amplitude and phase of each order, of the running linkage and of the frozen one.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            Two an order.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the axes are too few or too many.
        """
        return plots.plot_harmonic_frf(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Peaks of the orders, what was solved, and how far it may be off."""
        data = self.dataset
        attrs = data.attrs
        step, balance, reduction = (float(data[name].max()) for name in _ERRORS)
        details = (
            f"force on {attrs['impact_point']}, read at {attrs['response_point']}, "
            f"{attrs['direction']}, at {crank_speed_text(attrs)}",
            f"equations: {int(attrs['moving_modes'])} moving modes about the quasi-static state "
            f"(prestress {attrs['prestress']}) with the static answer of those left out, by the "
            f"propagator in {int(attrs['propagator_steps'])} steps a turn; the slowest vibration "
            f"decays by {float(attrs['decay_rate']):.4g} 1/s",
            *theory_lines(attrs),
        )
        verdict = (
            f"{attrs['engine']}: errors over each order's greatest amplitude: steps {step:.1e}, "
            f"moving modes {reduction:.1e}; harmonic balance differs by {balance:.1e}"
        )
        warned = warnings_of(attrs)
        return Summary(_answer(data), _peak_table(data), verdict, details, warned, _numbers(data))


def _answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Greatest amplitude of all orders, and how strong the sidebands are against it."""
    peaks = dataset["peak"]
    order = int(peaks.idxmax("order"))
    [greatest] = (one for one in _numbers(dataset) if one.of == f"order {order}")
    at = float(dataset["peak_frequency"].sel(order=order))
    said = f"The response is greatest at {at:.4g} Hz, {greatest} of order {order}"
    sides = peaks.sel(order=peaks["order"] != 0)
    if order == 0:
        share = 100 * float(sides.max() / peaks.max())
        strongest = int(sides.idxmax("order"))
        said += f"; the strongest sideband, order {strongest:+d}, has {share:.2g} % of it"
    return (f"{said}.",)


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest amplitude of each order with all its errors."""
    error = dataset["peak"] * sum(dataset[name] for name in _ERRORS)
    return tuple(
        Quantity("peak", float(peak), "m/N", float(off), f"order {order}")
        for order, peak, off in zip(
            dataset["order"].values.tolist(), dataset["peak"].values, error.values, strict=True
        )
    )


def _peak_table(dataset: xr.Dataset) -> Table:
    """Greatest amplitude of each order, and what the frozen linkage has at most."""
    parts = (dataset[f"frozen_{part}"].values for part in ("real", "imag"))
    frozen = np.hypot(*parts).max(axis=1)
    rows = [
        (
            f"{peak.order:+d}" if peak.order else "0",
            f"{peak.peak:.4g}",
            f"{peak.peak_frequency:.5g}",
            f"{alone:.4g}",
        )
        for peak, alone in zip(
            dataset[["peak", "peak_frequency"]].to_dataframe().reset_index().itertuples(),
            frozen,
            strict=True,
        )
    ]
    resolution = float(dataset["frequency"][1] - dataset["frequency"][0])
    return Table(
        f"harmonic response, {dataset.attrs.get('mechanism', '')}",
        ("order", "greatest m/N", "at Hz", "frozen linkage m/N"),
        (tuple(rows),),
        caption=(
            "greatest amplitude of each order: response at f + n f_crank to a force at f, at the "
            f"force's frequency f; lines every {resolution:.4g} Hz"
        ),
    )


# Bandwidth over the first natural frequency at rest, if none is asked for. It holds the first
# resonance and the beginning of what lies between it and the second.
_BANDWIDTH = 2.0
# Natural frequencies that elements which were not asked for must be fit for: those that the orders
# asked for reach at usual crank speeds.
_MODES = 6
# Orders beyond those asked for whose frequencies the moving modes must reach.
_GUARD_ORDERS = 3
# Part of its greatest response to which an impact has died out at the end of a record, and turns
# besides those in which it does: the one in which it comes, and one more.
_DECAYED, _MORE_TURNS = 1e-4, 2
# More frequencies take hours.
_MOST_FREQUENCIES = 25_000

# Natural modes up to this part of the highest frequency of force and response are kept, and tried.
_DETAIL = 1.5
_COUNTS = (3, 4, 6, 8, 12, 16)
_COARSE_TURN = np.radians(np.arange(0.0, 360.0, 30.0))
# Crank angles at which the frozen linkage is solved: its resonances move by less than their
# width from one to the next.
_FROZEN_ANGLES = 180
# Frequencies at which harmonic balance is solved, and harmonics beyond those of the fastest
# moving mode and the orders.
_BALANCED, _SPARE_HARMONICS = 5, 20
_MOST_HARMONICS = 60


@asks(RunningHammerRequest)
def running_hammer_test(
    mechanism: Engine | Mechanism, request: RunningHammerRequest
) -> RunningHammerTest:
    """Response of the running linkage to a force: harmonic transfer functions H_n(f).

    The running linkage is a periodic system: a force at f answers at f and at f plus or minus
    multiples of the crank's frequency. H_n(f) is the response at f + n f_crank to a force at f, in
    the axes of the links' rigid frames, with phases that count from crank angle 0. They are those
    of the time-varying linear equations.

    Parameters
    ----------
    mechanism : Mechanism or ReferenceEngine

    Returns
    -------
    RunningHammerTest

    Raises
    ------
    InputError
        If the engine simulates, a point is on no link of the linkage, the linkage is not damped,
        or the frequencies are too many.
    ComputationError
        If vibrations grow at this crank speed.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=2)
    >>> hit, seen = map(flexmech.LinkPoint.parse, ("coupler:0.5", "rocker:0.5"))
    >>> asked = {"impact": hit, "response": seen, "bandwidth": 60.0, "orders": 1}
    >>> found = flexmech.running_hammer_test(
    ...     engine, 20.0, prestress="axial", damping_ratio=0.1, **asked
    ... )
    >>> found.peaks()["order"].tolist()
    [-1, 0, 1]
    """
    [chosen] = engines_of(mechanism, request)
    if chosen.simulates:
        raise InputError(
            f"a hammer test of the running linkage is the linear periodic answer of the reference "
            f"engine, not of the {chosen.name} engine; use flexmech.ReferenceEngine (--engine "
            "reference)"
        )
    chosen.require_prescribed_shaft("a hammer test of the running linkage")
    chosen = chosen.fit_for(_MODES)
    request = request.of(chosen.mechanism)
    with one_thread():
        # A crank that cannot turn round shows itself here, before anything is computed.
        turn = np.linspace(0.0, 2 * np.pi, 73)
        chosen.mechanism.linkage.motion(turn, 1.0)
        refuse_passing(chosen.mechanism.linkage, turn)
        DrivenConnectors(chosen, chosen.frames).require_periodic()
        attributes = theory_attributes([chosen], _MODES)
        if request.damping_ratio is not None:
            chosen = with_damping_ratio(chosen, request.damping_ratio)
        else:
            loss = CountedLoss.of(chosen)
            chosen = loss.engine(chosen)
            attributes |= loss.attributes
        dataset = _dataset(chosen, request, _running_linkage(chosen, request))
    dataset.attrs |= attributes
    return RunningHammerTest(dataset)


@dataclass(frozen=True)
class _RunningLinkage:
    """The running linkage as a periodic system, and the frequencies asked for.

    Parameters
    ----------
    forced, larger : ForcedPeriodicSystem
        In its moving modes, and in the next larger number of them.
    steps : int
        Steps of the propagator a turn.
    moving_modes : int
        That the states are of.
    growth_rate : float
        Growth rate of the vibration that dies out last, in 1/s; negative.
    bandwidth : float
        In Hz.
    frequency : ndarray, shape (F,)
        Frequency of the force, in Hz.
    """

    forced: ForcedPeriodicSystem
    larger: ForcedPeriodicSystem
    steps: int
    moving_modes: int
    growth_rate: float
    bandwidth: float
    frequency: FloatArray

    def response(self, orders: IntArray) -> ComplexArray:
        """Harmonic transfer functions, (O, F) in m/N."""
        return harmonic_response(self.forced, self.frequency, orders, self.steps)

    def errors(self, orders: IntArray, answer: ComplexArray) -> dict[str, FloatArray]:
        """How far an answer (O, F) may be off, over the greatest amplitude of each order, (O,).

        By the steps of the propagator (change by half of them), by harmonic balance, and by the
        next larger number of moving modes.
        """
        size = np.abs(answer).max(axis=1)
        size = np.where(size > 0, size, 1.0)

        def change(other: ComplexArray, mine: ComplexArray) -> FloatArray:
            return np.asarray(np.abs(other - mine).max(axis=1) / size, dtype=float)

        half = harmonic_response(self.forced, self.frequency, orders, self.steps // 2)
        more = harmonic_response(self.larger, self.frequency, orders, self.steps)
        spread = np.linspace(0, len(self.frequency) - 1, _BALANCED).round().astype(np.intp)
        some = np.unique(np.concatenate([np.abs(answer).argmax(axis=1), spread]))
        harmonics = 1 if self.forced.system.is_constant else self._harmonics(orders)
        balanced = balanced_response(self.forced, self.frequency[some], orders, harmonics)
        return {
            "step_error": change(half, answer),
            "balance_error": change(balanced, answer[:, some]),
            "reduction_error": change(more, answer),
        }

    def _harmonics(self, orders: IntArray) -> int:
        system = self.forced.system
        matrix = system.matrix.coefficients[0]
        fastest = float(np.abs(np.linalg.eigvals(matrix)).max()) * system.period / (2 * np.pi)
        wanted = int(fastest) + int(np.abs(orders).max()) + _SPARE_HARMONICS
        return min(wanted, _MOST_HARMONICS)


def _running_linkage(engine: Engine, request: RunningHammerRequest) -> _RunningLinkage:
    """Linearize the running linkage, and make sure that an impact on it decays."""
    if not engine.has_damped_links:
        raise InputError(
            "the response of an undamped linkage is unbounded at its resonances; give the links "
            "damping: --damping-ratio 0.5% (damping_ratio=0.005), or damping in the model file"
        )
    undamped = with_damping_time(engine, 0.0)
    bandwidth = request.bandwidth
    if bandwidth is None:
        bandwidth = _BANDWIDTH * lowest_frequency(undamped) / (2 * np.pi)
    reach = (request.orders + _GUARD_ORDERS) * abs(request.crank_speed) / (2 * np.pi)
    # Strongly damped modes that creep back have no frequency to be counted by.
    modes = _modes_below(undamped, _DETAIL * (bandwidth + reach))
    systems, counts, steps = [], [], 0
    for larger in (0, 1):
        solver = LinkageSolver(engine, request.prestress, modes, larger=larger)
        moving = solver.moving_modes(request.crank_speed)
        stressed = engine.stressed_links(moving.turn.motion, request.prestress)
        acting = engine.connected_matrices(
            engine.frames, moving.turn.displaced, request.prestress, stressed
        )
        connected = None if acting is None else acting.stiffness
        pair = (request.impact, request.response)
        systems.append(forced_linkage(moving, stressed, *pair, request.direction, connected))
        counts.append(moving.size)
        steps = max(steps, solver.steps_for(VibratingLinkage.of(moving, modes)))
    steps *= 2
    growth_rate = float(floquet_modes(systems[0].system, steps).exponent.real.max())
    if growth_rate >= 0:
        raise ComputationError(
            f"no record decays at crank speed {CRANK_SPEED}: a vibration of the running linkage "
            f"grows by {growth_rate:.3g} 1/s; give the links more damping, or take another speed "
            "(flexmech stability finds the speeds of growth)",
            crank_speed=request.crank_speed,
        )
    frequency = _frequencies(request, bandwidth, systems[0].system.period, growth_rate)
    forced, more = systems
    return _RunningLinkage(forced, more, steps, counts[0], growth_rate, bandwidth, frequency)


def _frequencies(
    request: RunningHammerRequest, bandwidth: float, turn_time: float, growth_rate: float
) -> FloatArray:
    """Frequencies of the force from zero up to the bandwidth, one over the record apart, (F,)."""
    if request.duration is None:
        decay = -np.log(_DECAYED) / -growth_rate / turn_time
        turns = int(np.ceil(decay)) + _MORE_TURNS
    else:
        turns = int(np.ceil(request.duration / turn_time * (1 - 1e-9)))
    resolution = 1 / (turns * turn_time)
    count = bandwidth / resolution * (1 + 1e-9) + 1
    if count < 2:
        raise InputError(
            f"a record of {1 / resolution:.4g} s has no frequency between zero and the bandwidth "
            f"of {bandwidth:.4g} Hz; give a longer --duration, or a wider --bandwidth"
        )
    if count > _MOST_FREQUENCIES:
        raise InputError(
            f"{count:.3g} frequencies, {resolution:.3g} Hz apart, are more than "
            f"{_MOST_FREQUENCIES}; ask for a lower --bandwidth, a shorter --duration, or more "
            "damping (--damping-ratio)"
        )
    return np.asarray(resolution * np.arange(int(count), dtype=float))


def _dataset(engine: Engine, request: RunningHammerRequest, running: _RunningLinkage) -> xr.Dataset:
    """Label the answer of the running linkage and of the frozen one over order and frequency."""
    orders = np.arange(-request.orders, request.orders + 1)
    answer = running.response(orders)
    frozen = _frozen_response(engine, request, running.frequency, orders)
    at = np.abs(answer).argmax(axis=1)
    values: Values = {
        "order": orders,
        "frequency": running.frequency,
        **complex_parts("receptance", answer),
        **complex_parts("frozen", frozen),
        **running.errors(orders, answer),
        "peak": np.abs(answer).max(axis=1),
        "peak_frequency": running.frequency[at],
    }
    dataset = RunningHammerTest.schema().dataset(values)
    return dataset.assign_attrs(
        provenance([engine])
        | attributes_of(request, "direction", "prestress")
        | attributes_of(running, "bandwidth", "moving_modes"),
        crank_speed=request.crank_speed,
        speed_unit=request.speed_unit or RAD_S,
        engine=engine.name,
        element=engine.element,
        impact_point=str(request.impact),
        response_point=str(request.response),
        damping_ratio=np.nan if request.damping_ratio is None else request.damping_ratio,
        propagator_steps=running.steps,
        decay_rate=-running.growth_rate,
    )


def _frozen_response(
    engine: Engine, request: RunningHammerRequest, frequency: FloatArray, orders: IntArray
) -> ComplexArray:
    """Receptance of the frozen linkage at all crank angles, a Fourier series over the turn, (O, F).

    What the crank would make of the orders if it turned infinitely slowly: the mean over the
    turn is that of order 0. Without rotation terms, at the stress of the running linkage.
    """
    phase = 2 * np.pi / _FROZEN_ANGLES * np.arange(_FROZEN_ANGLES)
    system = engine.linear_system(
        np.sign(request.crank_speed) * phase,
        request.crank_speed,
        prestress=request.prestress,
        rotation_terms=False,
        detail=1.0,
    )
    points = (request.response, request.impact)
    read, put = (point_rows(system, point, request.direction) for point in points)
    total: ComplexArray = np.zeros((len(orders), len(frequency)), dtype=complex)
    for number in range(_FROZEN_ANGLES):
        matrices = (system.mass[number], system.damping[number], system.stiffness[number])
        modes = state_modes(*matrices)
        own = modes.receptance(read[number, None], put[number, None], frequency)[:, 0, 0]
        total += np.exp(-1j * orders * phase[number])[:, None] * own
    return np.asarray(total / _FROZEN_ANGLES)


def _modes_below(engine: Engine, frequency: float) -> int:
    """Number of natural modes that reach beyond a frequency in Hz at every crank angle."""
    for count in _COUNTS:
        found = natural_frequencies(
            engine,
            _COARSE_TURN,
            modes=count,
            prestress=engine.prestress_at_rest,
            rotation_terms=False,
        )
        if found[:, -1].min() > frequency:
            return count
    raise InputError(
        f"more than {_COUNTS[-1]} natural modes lie below {frequency:.6g} Hz, more than a hammer "
        "test on the running linkage takes; ask for a narrower --bandwidth"
    )
