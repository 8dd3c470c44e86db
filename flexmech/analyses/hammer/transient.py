r"""Records of force and displacement at a locked crank, as an analyser takes them.

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

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.fft
from scipy import signal
from scipy.interpolate import CubicSpline

from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.plan import RecordPlan
from flexmech.analyses.response.start import frame_at_rest
from flexmech.arrays import FloatArray, StepProgress
from flexmech.choices import LinkDirection
from flexmech.errors import InputError
from flexmech.linear_system import LinkPoint
from flexmech.linkages import LockedCrank
from flexmech.time_domain import Impact, LinkState, simulator

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
        # Links without stress carry no weight.
        engine = engine.with_(mechanism=replace(engine.mechanism, gravity=(0.0, 0.0)))
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
    found = run(impacts=[Impact(impact, direction, plan.pulse)])[:, 0]
    at_rest = found[0]
    if engine.mechanism.frame is not None and any(engine.mechanism.gravity):
        # The frame starts where linear equations let it sink, and rings a little without a hit.
        at_rest = run()[:, 0]
    return np.asarray(found - at_rest)


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
        Of the rule in s.

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
