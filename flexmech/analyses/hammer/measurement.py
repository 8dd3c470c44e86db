r"""One hammer test at one crank angle: what was recorded, estimated and identified.

Where the impact roves over points of all links, the response point stays. By reciprocity the
residues of one mode over the impact points are its shape there, times what the mode moves at the
response point.

Records of force and displacement at a locked crank, as an analyser takes them.

The transient is computed in steps ten times finer than the samples and goes through a linear-phase
low-pass filter that keeps the band and lets nothing pass that sampling would fold into it (80 dB);
force and displacement go through the same one. The reference engine's transient is exact. That
of Exudyn has the error of the trapezoidal rule, which is known exactly as long as displacements are
small: a step h answers at frequency :math:`\hat f` as the equations of motion do at

.. math:: f = \frac{\tan(\pi \hat f h)}{\pi h}

(docs/theory/hammer_test.md). Both records are read at :math:`\hat f` for the
lines f, which takes this off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.fft
from scipy import signal
from scipy.interpolate import CubicSpline

from flexmech.analyses.hammer.plan import LockedLinkage, RecordPlan
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.response.start import frame_at_rest
from flexmech.arrays import ComplexArray, FloatArray, LabelledProgress, StepProgress
from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import direct_receptance
from flexmech.errors import InputError
from flexmech.linkages import LockedCrank
from flexmech.mechanics import Engine, LinkPoint
from flexmech.mechanics.running import Impact, LinkState
from flexmech.modal_testing import (
    ORDERS,
    FrfEstimate,
    IdentifiedModes,
    complexity_factor,
    estimate_frf,
    identify,
    mac,
    with_noise,
)
from flexmech.solvers import simulator

# In dB, of what sampling would fold into the band: what records leave of a vibration at their end.
_ATTENUATION = 80.0
# The spectrum is read between lines of a record that is so many times longer, with zeros.
_PADDED = 16


@dataclass(frozen=True)
class Record:
    """Force and displacement without noise.

    Parameters
    ----------
    force : ndarray, shape (N,)
        In N.
    response : ndarray, shape (N,)
        In m, from the position at rest.
    """

    force: FloatArray
    response: FloatArray


def taken_record(
    locked: LockedLinkage,
    plan: RecordPlan,
    impact: LinkPoint,
    response: LinkPoint,
    direction: LinkDirection,
    progress: StepProgress | None = None,
) -> Record:
    """Hit a linkage and record force and displacement.

    Parameters
    ----------
    locked : LockedLinkage
    plan : RecordPlan
    impact, response : LinkPoint
    direction : {"transverse", "axial"}
    progress : callable, optional

    Returns
    -------
    Record

    Raises
    ------
    InputError
        If a point is on no link, or held by a joint, or straight links with weight are to be
        simulated.
    ComputationError
        If a step of Exudyn does not converge.
    """
    taps = _filter(plan)
    steps = plan.samples * plan.oversampling + len(taps) // 2
    time = np.asarray(plan.step * np.arange(steps + 1), dtype=float)
    simulates = locked.engine.simulates
    if simulates:
        fine = _simulated(locked, plan, impact, response, direction, steps, progress)
    else:
        hit = locked.rows([impact], direction)[0]
        fine = locked.motion(locked.rows([response], direction), hit, plan.pulse, time)[:, 0]
    both = np.stack([plan.pulse.force(time), fine])
    sampled = _sampled(both, taps, plan)
    if simulates:
        sampled = unwarped(sampled, plan.sampling_rate, plan.step)
    return Record(*sampled)


def _simulated(
    locked: LockedLinkage,
    plan: RecordPlan,
    impact: LinkPoint,
    response: LinkPoint,
    direction: LinkDirection,
    steps: int,
    progress: StepProgress | None,
) -> FloatArray:
    """Displacement at every step of the engine's nonlinear transient, (steps + 1,)."""
    engine = locked.engine
    if locked.prestress == "axial" and any(engine.mechanism.gravity):
        raise InputError(
            f"prestress 'axial' with the links' weight is of straight links, but the {engine.name} "
            "engine's transient bends them; use prestress 'equilibrium', or the reference engine"
        )
    start = LinkState.rigid(engine.links)
    if locked.prestress == "none":
        # Links without stress carry no weight and no loads.
        unloaded = replace(engine.mechanism, gravity=(0.0, 0.0), loads=())
        engine = engine.with_(mechanism=unloaded)
    else:
        motion = engine.mechanism.linkage.motion(np.array([locked.angle]))
        static = engine.stressed_links(motion, "equilibrium").displacement
        if static is not None:
            start = LinkState([q[0] for q in static], start.rate)
        start = replace(start, frame=frame_at_rest(engine, LockedCrank(locked.angle)))
    run = partial(
        simulator(engine).point_histories,
        LockedCrank(locked.angle),
        start,
        [(response, direction)],
        plan.step,
        steps,
        progress=progress,
    )
    runs = run(impacts=[Impact(impact, direction, plan.pulse)])[:, 0]
    at_rest = runs[0]
    stressed = any(engine.mechanism.gravity) or engine.connectors.any
    if engine.mechanism.frame is not None and stressed:
        # The frame starts where linear equations let it sink, and rings a little without a hit.
        at_rest = run()[:, 0]
    return np.asarray(runs - at_rest)


def _filter(plan: RecordPlan) -> FloatArray:
    """Low-pass filter at the transient's rate, of odd length."""
    rate = plan.sampling_rate * plan.oversampling
    falls = plan.sampling_rate - 2 * plan.bandwidth
    count, beta = signal.kaiserord(_ATTENUATION, falls / (rate / 2))
    taps = signal.firwin(count | 1, plan.sampling_rate / 2, window=("kaiser", beta), fs=rate)
    return np.asarray(taps)


def _sampled(fine: FloatArray, taps: FloatArray, plan: RecordPlan) -> FloatArray:
    """Signals (k, steps) filtered without delay and sampled, (k, N)."""
    filtered = signal.oaconvolve(fine, taps[None], mode="full", axes=1)
    first = len(taps) // 2
    return np.asarray(filtered[:, first :: plan.oversampling][:, : plan.samples])


def unwarped(records: FloatArray, sampling_rate: float, step: float) -> FloatArray:
    """Records of the trapezoidal rule, with its shift of frequencies taken off.

    Parameters
    ----------
    records : ndarray, shape (k, N)
        That begin and end near zero; N is even.
    sampling_rate : float
        In Hz.
    step : float
        Step of the rule in s.

    Returns
    -------
    ndarray, shape (k, N)
    """
    count = records.shape[1]
    lines = sampling_rate / count * np.arange(count // 2 + 1)
    read = np.arctan(np.pi * lines * step) / (np.pi * step)
    padded = _PADDED * count
    spectrum = scipy.fft.rfft(records, padded, axis=1)
    between = CubicSpline(sampling_rate / padded * np.arange(spectrum.shape[1]), spectrum, axis=1)
    return np.asarray(scipy.fft.irfft(between(read), count, axis=1))


# Modes up to this multiple of the bandwidth are superposed; the rest adds its flexibility.
_SUPERPOSED = 2.0
# Lines at which the direct solution is compared with the superposition of all modes: enough to
# meet every resonance, and few, since each is a solution of its own.
_CHECKED_LINES = 64


@dataclass(frozen=True, eq=False)
class GridShapes:
    """Shapes of the modes of one crank angle at the points of a grid.

    Parameters
    ----------
    shape : ndarray of complex, shape (P, k)
        Identified; the point that moves most has 1. Not a number for modes that were not found.
    eigen_shape : ndarray of complex, shape (P, k)
        Shape of the eigen model, scaled to the identified one.
    mac : ndarray, shape (k,)
        Modal assurance criterion of both.
    complexity_factor, eigen_complexity_factor : ndarray, shape (k,)
    """

    shape: ComplexArray
    eigen_shape: ComplexArray
    mac: FloatArray
    complexity_factor: FloatArray
    eigen_complexity_factor: FloatArray


def grid_points(engine: Engine, count: int) -> list[LinkPoint]:
    """Points at the middles of as many equal parts of each link: none is at a joint.

    Parameters
    ----------
    engine : Engine
    count : int
        Points a link.

    Returns
    -------
    list of LinkPoint
        Link by link, from its first joint.
    """
    fractions = (np.arange(count) + 0.5) / count
    names = engine.mechanism.linkage.topology.link_names
    return [LinkPoint(name, float(fraction)) for name in names for fraction in fractions]


def _grid_shapes(
    locked: LockedLinkage,
    points: Sequence[LinkPoint],
    direction: LinkDirection,
    poles: ComplexArray,
    modes: IdentifiedModes,
) -> GridShapes:
    """Compare identified shapes with those of the eigen model at P points.

    The modes are in the order of ``poles``; their last P rows of residues are those of the points.
    """
    identified = modes.residue[-len(points) :]
    column = [int(np.argmin(np.abs(locked.modes.poles - pole))) for pole in poles]
    eigen = locked.rows(points, direction) @ locked.modes.right[:, column]
    shape = _scaled(identified)
    likeness = np.array([mac(a, b)[0, 0] for a, b in zip(shape.T, eigen.T, strict=True)])
    return GridShapes(
        shape,
        _fitted(eigen, shape),
        likeness,
        complexity_factor(identified),
        complexity_factor(eigen),
    )


def _scaled(shapes: ComplexArray) -> ComplexArray:
    """Columns over their greatest entry."""
    greatest = np.argmax(np.abs(shapes), axis=0)
    # Modes that were not found are not numbers.
    with np.errstate(invalid="ignore"):
        return np.asarray(shapes / shapes[greatest, np.arange(shapes.shape[1])])


def _fitted(shapes: ComplexArray, wanted: ComplexArray) -> ComplexArray:
    """Columns scaled to others by least squares; over their greatest entry where those are none."""
    known = np.isfinite(wanted).all(axis=0)
    target = np.where(known, wanted, _scaled(shapes))
    factor = np.sum(shapes.conj() * target, axis=0) / np.sum(np.abs(shapes) ** 2, axis=0)
    return np.asarray(shapes * factor)


@dataclass(frozen=True, eq=False)
class Measurement:
    """A test of one impact point and one response point.

    Parameters
    ----------
    locked : LockedLinkage
    force, response : ndarray, shape (A, N)
        Records with their noise, in N and m.
    estimate : FrfEstimate
        At the lines kept, (F,).
    exact, superposed : ndarray of complex, shape (F,)
        Receptance of the eigen model by all modes, and by those up to twice the bandwidth with
        the residual term.
    residual : float
        That term: static flexibility of the modes left out in m/N.
    direct_difference : float
        Greatest difference of the direct solution from ``exact`` over the peak.
    poles : ndarray of complex, shape (k,)
        Poles of the eigen model in the band.
    modes : IdentifiedModes
        In the order of ``poles``; the first row of residues is that of the impact point, then
        those of the grid.
    seen, hit : ndarray, shape (1, n)
        Rows of the response point and of the impact point.
    unwindowed : ndarray of complex, shape (1 + P, F)
        Receptances of the impact point and of the P points of the grid, what the exponential
        window adds taken off.
    grid : GridShapes, optional
    """

    locked: LockedLinkage
    force: FloatArray
    response: FloatArray
    estimate: FrfEstimate
    exact: ComplexArray
    superposed: ComplexArray
    residual: float
    direct_difference: float
    poles: ComplexArray
    modes: IdentifiedModes
    seen: FloatArray
    hit: FloatArray
    unwindowed: ComplexArray
    grid: GridShapes | None = None

    def exact_at(self, frequency: FloatArray) -> ComplexArray:
        """Exact receptance at frequencies (F,) in Hz, with what the window adds; (F,)."""
        shift = self.estimate.added_damping
        modes = self.locked.modes
        return modes.receptance(self.seen, self.hit, frequency, shift=shift)[:, 0, 0]


def measured(
    locked: LockedLinkage,
    plan: RecordPlan,
    request: HammerRequest,
    number: int,
    report: LabelledProgress,
) -> Measurement:
    """Take the records of one crank angle, and identify the modes.

    Parameters
    ----------
    locked : LockedLinkage
    plan : RecordPlan
    request : HammerRequest
    number : int
        Number of the crank angle, for its noise.
    report : callable
        Shows the progress.

    Returns
    -------
    Measurement

    Raises
    ------
    InputError
        As of :func:`flexmech.hammer_test`.
    ComputationError
        If a step of Exudyn does not converge.
    """
    hit = locked.rows([request.impact], request.direction)
    seen = locked.rows([request.response], request.direction)
    force, response, estimate = _estimated(locked, plan, request, request.impact, [number], report)
    lines, shift = estimate.frequency, plan.decay_rate
    exact = locked.modes.receptance(seen, hit, lines, shift=shift)[:, 0, 0]
    kept = locked.modes.below(_SUPERPOSED * plan.bandwidth)
    superposed = locked.modes.receptance(seen, hit, lines, kept, shift=shift)[:, 0, 0]
    checked = lines[:: max(1, len(lines) // _CHECKED_LINES)]
    gap = direct_receptance(*locked.matrices, seen, hit, checked)
    gap = gap - locked.modes.receptance(seen, hit, checked)
    poles = locked.poles(plan.bandwidth)
    points = [] if request.grid is None else grid_points(locked.engine, request.grid)
    roved = [
        _estimated(locked, plan, request, point, [number, place], report)[2].h1
        for place, point in enumerate(points, 1)
    ]
    windowed = np.stack([estimate.h1, *roved])
    modes = identify(
        lines,
        windowed,
        band=(0.0, plan.bandwidth),
        expected=np.abs(poles) / (2 * np.pi),
        method=request.method,
        added_damping=shift,
        noise=estimate.noise,
        # A short record has few lines: models of fewer modes than usual.
        orders=min(ORDERS, len(lines) // 2 - 1),
    )
    return Measurement(
        locked,
        force,
        response,
        estimate,
        exact,
        superposed,
        float(locked.modes.residual(seen, hit, kept)[0, 0]),
        float(np.abs(gap).max() / np.abs(exact).max()),
        poles,
        modes,
        seen,
        hit,
        windowed + modes.receptance(lines) - modes.receptance(lines, shift),
        _grid_shapes(locked, points, request.direction, poles, modes) if points else None,
    )


def _estimated(
    locked: LockedLinkage,
    plan: RecordPlan,
    request: HammerRequest,
    impact: LinkPoint,
    numbers: list[int],
    report: LabelledProgress,
) -> tuple[FloatArray, FloatArray, FrfEstimate]:
    """Records of force and response with their noise, (A, N) each, and what they give.

    The noise is that of the request's seed and some numbers.
    """
    label = f"hammer at {np.degrees(locked.angle):.6g} deg"
    if len(numbers) > 1:
        label += f", impact at {impact}"
    record = taken_record(
        locked,
        plan,
        impact,
        request.response,
        request.direction,
        partial(report, label),
    )
    generator = np.random.default_rng([request.seed, *numbers])
    force, response = (
        with_noise(np.tile(signal, (request.averages, 1)), request.noise, generator)
        for signal in (record.force, record.response)
    )
    estimate = estimate_frf(
        force,
        response,
        plan.sampling_rate,
        force_window=plan.force_window,
        exponential_window=plan.window,
    )
    return force, response, _in_band(estimate, plan.bandwidth)


def _in_band(whole: FrfEstimate, bandwidth: float) -> FrfEstimate:
    """The lines above zero and up to the bandwidth."""
    return whole.at((whole.frequency > 0) & (whole.frequency <= bandwidth * (1 + 1e-9)))
