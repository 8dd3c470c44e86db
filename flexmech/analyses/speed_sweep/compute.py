"""Steady-state deflection against crank speed, and the speeds at which a linkage rings.

At constant crank speed every load repeats itself with each turn. Where a natural frequency
is a whole multiple of the turning frequency, a harmonic of the loads meets it: the critical
speeds are natural frequencies divided by whole numbers, each a range because the frequencies
move with the crank angle.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.crank_speeds import RAD_S, rad_per_s
from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.datasets import provenance, with_units
from flexmech.analyses.frequencies.discretisation import mesh_error, share_of_error
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.requests import CHECKED_SPEEDS, check_list, engine_of, sampled_turn
from flexmech.analyses.response.measurements import deflections, probes
from flexmech.analyses.response.plan import STEPS_PER_PERIOD
from flexmech.analyses.speed_sweep.result import SpeedSweep
from flexmech.arrays import FloatArray, IntArray, LabelledProgress, silent
from flexmech.choices import MOST_MODES, PRESTRESS_LEVELS, Prestress
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.linkages import ConstantSpeed
from flexmech.mechanism import Mechanism
from flexmech.threads import one_thread
from flexmech.time_domain import DrivenLinkage, periodic_turn, quasi_static_turn
from flexmech.validation import check_choice, check_count

# Half a degree, where the highest frequency asks for no shorter step.
LEAST_STEPS = 720
# A degree: of the peaks of five harmonics, which are level, it misses less than a thousandth.
QUASI_STATIC_ANGLES = 360
# A steady state shakes the lowest modes alone: fewer component modes than a start at speed.
DETAIL = 2.0
# Elements, time steps and component modes of the run that a checked one is compared with, over its
# own: twice as many tell what an error is within a factor of 1.4, whatever order it has.
FINER = 2
# Every second of the sampled angles, 30 deg apart, as the maps of frequencies check.
EVERY_CHECKED = 2
# More are taken for a slip: a thousand curves are drawn as one surface.
MOST_ORDERS = 1000


def speed_sweep(
    engine: Engine | Mechanism,
    crank_speeds: ArrayLike,
    *,
    modes: int = 3,
    orders: int = 24,
    prestress: Prestress = "equilibrium",
    speed_unit: str | None = None,
    progress: LabelledProgress | None = None,
) -> SpeedSweep:
    """Periodic motion at many crank speeds, each found without its transient.

    Parameters
    ----------
    engine : Engine or Mechanism
        Of a mechanism the reference engine is made.
    crank_speeds : array_like, shape (S,)
        Increasing, positive, in ``speed_unit``.
    modes : int
        Natural frequencies whose critical speeds are marked; three by default, since harmonics
        of the crank that reach the fourth are weak.
    orders : int
        Highest harmonic of the crank that is marked.
    prestress : {"none", "axial", "equilibrium"}
    speed_unit : str, optional
        Unit of the crank speeds, such as ``"rpm"``, in which the result speaks of them. Left out:
        rad/s.
    progress : callable, optional
        Called with a label, the speeds done and the speeds to do.

    Returns
    -------
    SpeedSweep

    Raises
    ------
    InputError
        If the speeds are not positive and increasing, or the crank cannot turn round.
    ComputationError
        At a speed without periodic motion, or without equilibrium.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> sweep = flexmech.speed_sweep(engine, [10.0, 20.0])
    >>> sweep.dataset["peak_deflection"].dims
    ('crank_speed', 'link')
    """
    speeds = rad_per_s(crank_speeds, speed_unit)
    if speeds.ndim != 1 or not len(speeds) or not np.all(speeds > 0):
        raise InputError("crank_speeds must be a list of positive speeds")
    check_list("crank_speeds", speeds, increasing=True)
    check_choice(prestress, PRESTRESS_LEVELS, "prestress")
    check_count(orders, "orders", most=MOST_ORDERS)
    check_count(modes, "modes", most=MOST_MODES)
    engine, report = engine_of(engine).fit_for(modes), progress or silent
    found = []
    with one_thread():
        loss = CountedLoss.of(engine)
        engine = loss.engine(engine)
        frequency = _at_rest(engine, modes)
        for number, speed in enumerate(speeds.tolist()):
            linkage = vibrating_linkage(engine, speed, modes, prestress)
            found.append(_deflections(linkage, float(frequency.max())))
            report("crank speeds", number + 1, len(speeds))
        peaks = np.stack([np.abs(each).max(axis=0) for each in found])
        at_rest = Systems(engine, Formulation(engine.prestress_at_rest, modes=modes))
        by_mesh = mesh_error(at_rest, sampled_turn()[::EVERY_CHECKED], 0.0).frequency.max(axis=0)
        checked, errors = _checked_speeds(peaks), []
        finer = engine.with_(elements=FINER * engine.elements)
        for number, place in enumerate(checked.tolist()):
            linkage = vibrating_linkage(finer, speeds[place], modes, prestress, FINER * DETAIL)
            other = _deflections(linkage, float(frequency.max()), FINER)
            errors.append(_error_of(found[place], other))
            report("errors of the peaks", number + 1, len(checked))
    order = np.arange(1, orders + 1)
    critical = 2 * np.pi * frequency[:, :, None] / order
    dataset = xr.Dataset(
        {
            "peak_deflection": (("crank_speed", "link"), peaks),
            "peak_error": (("check_speed", "link"), np.stack(errors)),
            "discretisation_error": ("mode", by_mesh),
            "critical_speed_low": (("mode", "order"), critical.min(axis=0)),
            "critical_speed_high": (("mode", "order"), critical.max(axis=0)),
        },
        coords={
            "crank_speed": speeds,
            "check_speed": speeds[checked],
            "link": list(engine.mechanism.linkage.topology.link_names),
            "probe": ("link", probes(engine)),
            "mode": np.arange(1, modes + 1),
            "order": order,
        },
        attrs={
            **provenance([engine]),
            **theory_attributes([engine], modes),
            **loss.attributes,
            "engine": engine.name,
            "prestress": prestress,
            "speed_unit": speed_unit or RAD_S,
        },
    )
    return SpeedSweep(with_units(dataset, "speed_sweep"))


def vibrating_linkage(
    engine: Engine, speed: float, modes: int, prestress: Prestress, detail: float = DETAIL
) -> DrivenLinkage:
    """Linear equations of a linkage at a steady speed.

    Parameters
    ----------
    engine : Engine
    speed : float
        Of the crank, rad/s, not zero.
    modes : int
    prestress : {"none", "axial", "equilibrium"}
    detail : float
        How many component modes to take.

    Returns
    -------
    DrivenLinkage

    Raises
    ------
    ComputationError
        If there is no equilibrium.
    """
    drive = ConstantSpeed(speed)
    engine.require_prescribed_shaft("a speed sweep")
    return DrivenLinkage(engine, drive, prestress, modes=modes, detail=detail, with_energy=False)


def periodic_peaks(linkage: DrivenLinkage, highest: float) -> FloatArray:
    """Greatest deflections over a turn of the periodic motion.

    Parameters
    ----------
    linkage : DrivenLinkage
    highest : float
        Greatest frequency in Hz that the time step resolves.

    Returns
    -------
    ndarray, shape (n_links,)
        m.

    Raises
    ------
    ComputationError
        If there is no equilibrium, or no periodic motion.
    """
    return _greatest(linkage, _turn(linkage, highest))


def _turn(linkage: DrivenLinkage, highest: float, finer: int = 1) -> list[FloatArray]:
    """Displacements (N, n_link) along a turn, with so many times the usual steps."""
    turn = linkage.drive.revolution_time
    steps = max(LEAST_STEPS, int(np.ceil(STEPS_PER_PERIOD * highest * turn)))
    return periodic_turn(linkage, finer * steps)


def _deflections(linkage: DrivenLinkage, highest: float, finer: int = 1) -> FloatArray:
    """Deflections (N, n_links) along a turn, with so many times the usual steps."""
    return deflections(linkage.engine, _turn(linkage, highest, finer))


def _checked_speeds(peaks: FloatArray) -> IntArray:
    """Numbers of the speeds whose peaks (S, n_links) are checked.

    Both ends and the middle, and where a link bends most: there a resonance is near, and the
    peak moves most with its frequency.
    """
    evenly = np.linspace(0, len(peaks) - 1, CHECKED_SPEEDS).astype(np.intp)
    return np.union1d(evenly, peaks.argmax(axis=0))


def _error_of(deflection: FloatArray, finer: FloatArray) -> FloatArray:
    """Estimated relative error of the peaks of deflections (N, n_links) by a finer run's.

    Peaks at different instants may be equally high by chance: what differs where the finer run
    peaks counts as well, as in a response in time.
    """
    here, there = np.abs(deflection), np.abs(finer)
    same = there[::FINER]
    at_peak = same.argmax(axis=0), np.arange(same.shape[1])
    peak = there.max(axis=0)
    apart = np.maximum(np.abs(here.max(axis=0) - peak), np.abs(here - same)[at_peak])
    # A link that no load bends has no error.
    return np.asarray(apart / np.where(peak > 0, peak, 1.0) / share_of_error(1, FINER))


def quasi_static_peaks(linkage: DrivenLinkage) -> FloatArray:
    """Greatest deflections over a turn if nothing vibrated, in m, shape (n_links,)."""
    return _greatest(linkage, quasi_static_turn(linkage, QUASI_STATIC_ANGLES))


def _greatest(linkage: DrivenLinkage, displacement: Sequence[FloatArray]) -> FloatArray:
    """Greatest deflections of displacements (n_links of (N, n)) of the engine's links."""
    return np.asarray(np.abs(deflections(linkage.engine, displacement)).max(axis=0))


def highest_frequency(engine: Engine, modes: int) -> float:
    """Greatest frequency in Hz of so many modes at rest, over the turn."""
    return float(_at_rest(engine, modes).max())


def _at_rest(engine: Engine, modes: int) -> FloatArray:
    return natural_frequencies(
        engine, sampled_turn(), modes=modes, prestress=engine.prestress_at_rest
    )
