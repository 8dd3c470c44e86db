"""Stability of the running linkage over crank speed, by one engine or several.

Floquet frequencies are drawn over bands of the moving natural frequencies at a few crank speeds:
without rotation terms, for with them frozen frequencies depend on the frame that they are written
in. The stress of the running links is in them.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.crank_speeds import STABILITY, asked_speeds
from flexmech.analyses.damping_ratios import CountedLoss, with_damping_ratio
from flexmech.analyses.remarks import left_out_attributes
from flexmech.analyses.requests import Engines, engines_of
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.stability.against import Against, map_against
from flexmech.analyses.stability.dataset import dataset_of
from flexmech.analyses.stability.engine_map import map_engine
from flexmech.analyses.stability.engine_stability import EngineStability
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.result import StabilityMap
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.choices import KEPT_MODES, MapPrestress, MovingFrame, Prestress, ShaftChoice
from flexmech.errors import ComputationError, InputError
from flexmech.interruption import tidying
from flexmech.linear_system import Engine, is_constant_turn, stressed_along_turn
from flexmech.linkages import ConstantSpeed, refuse_passing
from flexmech.threads import one_thread
from flexmech.time_domain import (
    DrivenLinkage,
    SampledTurn,
    periodic_turn,
    quasi_static_turn,
    require_periodic_motion,
)

logger = logging.getLogger(__name__)

# Each is a search for the equilibria of a turn of its own; the bands change slowly with the speed.
MOST_SPEEDS = 9
# Steps a turn of the linear periodic motion, whose distance from the equilibrium is a percentage.
MOTION_STEPS = 720
# It shakes the lowest modes alone: fewer component modes than a start at speed.
MOTION_DETAIL = 2.0
# Every 10 deg: the bands stand beside the multipliers as a picture, without errors.
ANGLES = 36


def _moving(engine: Engine, request: StabilityRequest) -> xr.Dataset:
    """Bands of the moving frequencies, without rotation terms, at nine of the speeds at most.

    Those without equilibrium are left out. Of the modes asked for, or of as many as there are;
    zero where the linkage is statically unstable.
    """
    level: Prestress = "equilibrium" if request.prestress == "trajectory" else request.prestress
    speeds = request.crank_speeds
    places = np.linspace(0, len(speeds) - 1, min(len(speeds), MOST_SPEEDS)).round().astype(int)
    found, rows = [], []
    for speed in speeds[places].tolist():
        try:
            hertz = _frequencies(engine, speed, level, request.modes)
        except ComputationError:
            continue
        found.append(speed)
        rows.append((hertz.min(axis=0), hertz.mean(axis=0), hertz.max(axis=0)))
    modes = len(rows[0][0]) if rows else request.modes
    values = np.array(rows).reshape(len(rows), 3, modes)
    names = ("lowest_frequency", "mean_frequency", "highest_frequency")
    return xr.Dataset(
        {name: (("moving_speed", "branch"), values[:, n]) for n, name in enumerate(names)},
        coords={"moving_speed": np.array(found), "branch": np.arange(1, modes + 1)},
    )


def _frequencies(engine: Engine, speed: float, prestress: Prestress, modes: int) -> FloatArray:
    """Of the lowest modes at evenly spaced crank angles, (ANGLES, m)."""
    angle = 2 * np.pi / ANGLES * np.arange(ANGLES)
    motion = engine.mechanism.linkage.motion(angle, speed)
    stressed = stressed_along_turn(engine, motion, prestress)
    turn = SampledTurn.of(engine, motion, stressed, prestress, modes)
    squares = turn.frozen_squares[:, turn.rigid_modes :][:, :modes]
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi))


def _settles(engine: Engine) -> bool:
    """Whether links settle on a periodic motion other than a steady equilibrium in their frames."""
    damped = any(link.damping.any() for link in engine.links)
    turn = engine.mechanism.linkage.motion(2 * np.pi / ANGLES * np.arange(ANGLES), 1.0)
    if not damped or engine.turns_as_one_body or is_constant_turn(engine, turn):
        return False
    try:
        require_periodic_motion(engine)
    except InputError as refusal:
        logger.info("stability is about the quasi-static equilibrium: %s", refusal)
        return False
    return True


def _motion_distance(engine: Engine, request: StabilityRequest) -> float:
    """Distance of the periodic motion from the equilibrium at the fastest speed.

    By the linear equations about the equilibrium, over the greatest deflection of the motion;
    not a number where there is no such motion.
    """
    speed = float(request.crank_speeds[-1])
    prescribed = engine.with_(shaft="prescribed") if engine.shaft == "free" else engine
    try:
        require_periodic_motion(engine)
        linkage = DrivenLinkage(
            *(prescribed, ConstantSpeed(speed), "equilibrium"),
            modes=request.modes,
            detail=MOTION_DETAIL,
            with_energy=False,
        )
        moved, still = (
            deflections(prescribed, turn(linkage, MOTION_STEPS))
            for turn in (periodic_turn, quasi_static_turn)
        )
    except (ComputationError, InputError) as refusal:
        logger.info("the distance of the periodic motion is not known: %s", refusal)
        return float("nan")
    return float(np.abs(moved - still).max() / np.abs(moved).max())


def stability(
    engine: Engines,
    crank_speeds: ArrayLike | None = None,
    *,
    prestress: MapPrestress | None = None,
    frame: MovingFrame = "link",
    modes: int = KEPT_MODES,
    steps: int | None = None,
    damping_ratio: float | None = None,
    against: tuple[str, ArrayLike] | None = None,
    speed_unit: str | None = None,
    shaft: ShaftChoice | None = None,
    progress: LabelledProgress | None = None,
) -> StabilityMap:
    """At which crank speeds vibrations of the running linkage grow by themselves.

    At constant crank speed the linear equations of the links' vibration are periodic. Floquet's
    multipliers say by what factor each vibration has grown after a turn; where one exceeds 1, the
    linkage shakes itself up although it may be stable in every frozen position.

    Parameters
    ----------
    engine : Engine, Mechanism or sequence of them
        Several engines give results side by side; of a mechanism the reference engine is made.
    crank_speeds : array_like, shape (S,), optional
        In ``speed_unit``, not zero, all of one sign. Left out: from half to 1.5 times the greatest
        speed at which the mechanism operates.
    prestress : {"none", "axial", "equilibrium", "trajectory"}, optional
        Of the motion that vibrations are about: the quasi-static equilibrium along the turn, or
        the periodic motion itself (``trajectory``). Left out: the periodic motion of damped links,
        which settle on it; the equilibrium of undamped links, with ``against``, and where
        :func:`flexmech.time_domain.nonlinear_orbit` refuses what acts on the links.
    frame : {"link", "inertial"}
        Of the coordinates. The multipliers are the same in both.
    modes : int
        Natural modes whose Floquet modes are kept.
    steps : int, optional
        Of the propagator a turn, a multiple of 16. Left out: chosen by the fastest mode.
    damping_ratio : float, optional
        Z: all links get the Kelvin-Voigt time 2 Z/omega_1, with the first natural frequency at
        rest averaged over the turn. Left out: the model's damping counts.
    against : tuple of (str, array_like), optional
        A second parameter and its values in SI units: ``"damping-ratio"``, ``"moisture"``,
        ``"temperature-rise"``, or a quantity of the model file by its key, such as
        ``"linkage.coupler"`` or ``"links.coupler.in_plane_thickness"``. With prestress
        ``trajectory`` each point has a periodic motion of its own, which takes its time.
    speed_unit : str, optional
        Unit of the crank speeds given, such as ``"rpm"``, in which the result speaks of them. Left
        out: rad/s, and the unit of the model file for speeds that are its own.
    shaft : {"prescribed", "free"}, optional
        Of all engines: whether the shaft turns as prescribed, or its rotation against that is one
        more coordinate. Left out: that of the engines.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    StabilityMap
        A speed without equilibrium is a row that says so. Where Ctrl-C interrupts the map, what
        is done is in it.

    Raises
    ------
    InputError
        If the request makes no sense or the crank cannot turn round.
    ComputationError
        If there is an equilibrium at none of the speeds.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=2)
    >>> found = flexmech.stability(
    ...     engine, [86.0, 87.0, 88.0], prestress="axial", modes=2, damping_ratio=0.01
    ... )
    >>> found.bands()[["from_rad_s", "to_rad_s", "kind", "branches", "order"]].round(1)
       from_rad_s  to_rad_s       kind branches  order
    0        86.2      88.0  principal        2      7
    """
    engines = engines_of(engine, modes, shaft)
    speeds, unit = asked_speeds(crank_speeds, speed_unit, engines[0].mechanism, STABILITY)
    request = StabilityRequest(
        speeds,
        prestress or "equilibrium",
        frame,
        modes,
        steps,
        damping_ratio,
        unit,
    )
    refuse_passing(engines[0].mechanism.linkage, np.array([0.0, 2 * np.pi]))
    second = None if against is None else Against.of(engines[0].mechanism, against)
    report = progress or silent
    maps: list[EngineStability] = []
    attributes = theory_attributes(engines, modes)
    with one_thread(), tidying():
        if damping_ratio is None:
            loss = CountedLoss.of(engines[0])
            engines = [loss.engine(each) for each in engines]
            attributes |= loss.attributes
        damped = engines[0]
        if damping_ratio is not None:
            damped = with_damping_ratio(damped, damping_ratio)
        if prestress is None and against is None and _settles(damped):
            request = replace(request, prestress="trajectory")
        extra = _moving(engines[0], request)
        distance = np.nan
        if request.prestress == "equilibrium":
            distance = _motion_distance(damped, request)
        for each in engines:
            maps.append(map_engine(each, request, report))
            if maps[-1].interrupted:
                break
        if second is not None and not maps[-1].interrupted:
            bands = [band for each in maps for band in each.bands]
            over_both = map_against(engines, request, second, bands, report)
            extra = extra.merge(over_both).assign_attrs(over_both.attrs)
    dataset = dataset_of(maps, request).assign_attrs(motion_distance=distance)
    attributes = dataset.attrs | extra.attrs | attributes
    attributes |= left_out_attributes(engines[0].mechanism)
    return StabilityMap(
        StabilityMap.schema().labelled(dataset.merge(extra)).assign_attrs(attributes)
    )
