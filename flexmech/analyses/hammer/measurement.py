"""One hammer test at one crank angle: what was recorded, estimated and identified.

Where the impact roves over points of all links, the response point stays. By reciprocity the
residues of one mode over the impact points are its shape there, times what the mode moves at the
response point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.plan import RecordPlan
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.hammer.transient import taken_record
from flexmech.arrays import ComplexArray, FloatArray, LabelledProgress
from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import direct_receptance
from flexmech.linear_system import Engine, LinkPoint
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
        Of the eigen model, scaled to the identified one.
    mac : ndarray, shape (k,)
        Of both.
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
        Of the eigen model in the band.
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
        Of the crank angle, for its noise.
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
    some = lines[:: max(1, len(lines) // _CHECKED_LINES)]
    gap = direct_receptance(*locked.matrices, seen, hit, some)
    gap = gap - locked.modes.receptance(seen, hit, some)
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
