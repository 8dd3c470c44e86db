"""How a frame on springs moves along a run, and what its springs put on the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity
from flexmech.analyses.response.agreement import CAUSES, quantities_of
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.linkages import RigidMotion, carried_motion, turned
from flexmech.mechanics import Engine
from flexmech.mechanics.running import FrameMotion, Trajectory
from flexmech.mechanism import SprungFrame

# In rad. Linear equations of a frame are of first order in its rotation, by which their numbers are
# off: of frames on soft springs 0.3 to 1.3 times as much. Beyond the greatest they tell nothing.
_WORTH_A_WARNING, _GREATEST_ROTATION = 0.05, 0.5
# Variables with a peak, its printed unit, and what a number is multiplied by.
_PEAKS = {
    "frame_displacement": ("mm", 1e3),
    "frame_rotation": ("deg", DEGREES),
    "floor_force": ("N", 1.0),
}


def carried_by_frame(engine: Engine, motion: RigidMotion, trajectory: Trajectory) -> RigidMotion:
    """Motion of the rigid linkage in ground axes, as a frame on springs carries it along a run.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        On a frame that stands, at the N samples of the run.
    trajectory : Trajectory

    Returns
    -------
    RigidMotion
        The same where the frame stands.
    """
    frame, moved = engine.mechanism.frame, trajectory.frame
    if frame is None or moved is None:
        return motion
    change = _derivative(moved.rate, trajectory.time)
    return carried_motion(frame.centre, motion, moved.displacement, moved.rate, change)


def carried_along(engine: Engine, motion: RigidMotion, trajectory: Trajectory) -> RigidMotion:
    """Motion of the rigid linkage in ground axes, by the angles that a free shaft has along a run.

    Parameters
    ----------
    engine, motion, trajectory
        As of :func:`carried_by_frame`.

    Returns
    -------
    RigidMotion
        The same where the shaft turns as prescribed and the frame stands.
    """
    if trajectory.shaft is not None:
        turned = motion.crank_angle + trajectory.shaft.rotation
        motion = engine.mechanism.linkage.motion(turned, motion.crank_speed)
    return carried_by_frame(engine, motion, trajectory)


def in_axes_of_frame(engine: Engine, motion: RigidMotion, trajectory: Trajectory) -> RigidMotion:
    """Motion whose accelerations and spins are those in ground axes, written in axes of the frame.

    Links and their joints stand in these axes as on a frame that stands; weight, which does not
    turn with them, is made up for by the accelerations.

    Parameters
    ----------
    engine, motion, trajectory
        As of :func:`carried_by_frame`.

    Returns
    -------
    RigidMotion
        The same where the frame stands.
    """
    moved, weight = trajectory.frame, np.asarray(engine.mechanism.gravity)
    if moved is None:
        return motion
    carried = carried_by_frame(engine, motion, trajectory)
    felt = turned(carried.origin_acceleration - weight, -moved.displacement[:, 2, None])
    return replace(
        motion,
        angular_velocity=carried.angular_velocity,
        angular_acceleration=carried.angular_acceleration,
        origin_acceleration=felt + weight,
    )


def _derivative(rate: FloatArray, time: FloatArray) -> FloatArray:
    """Time derivative of samples (N, 3) by a cubic spline through them."""
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(time, rate, axis=0)(time, 1), dtype=float)


def frame_values(engine: Engine, trajectory: Trajectory, refined: Trajectory) -> Values:
    """Motion of a frame on springs, force on the floor, and their peaks.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the samples asked for.
    refined : Trajectory
        At all samples.

    Returns
    -------
    dict
        Empty where the frame stands.
    """
    frame, moved, every = engine.mechanism.frame, trajectory.frame, refined.frame
    if frame is None or moved is None or every is None:
        return {}
    force, greatest = _floor_force(frame, moved), _floor_force(frame, every)
    return {
        "frame_displacement": moved.displacement[:, :2],
        "frame_rotation": moved.displacement[:, 2],
        "floor_force": force,
        "peak_frame_displacement": np.hypot(*every.displacement[:, :2].T).max(),
        "peak_frame_rotation": np.abs(every.displacement[:, 2]).max(),
        "peak_floor_force": np.hypot(*greatest.T).max(),
    }


def rotation_error(engine: Engine, trajectory: Trajectory) -> float:
    """Part by which linear equations of a frame on springs are off: its greatest rotation in rad.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory

    Returns
    -------
    float
        Zero of an engine that simulates, in which a frame turns by any angle, and of a frame that
        stands.

    Raises
    ------
    ComputationError
        If the frame turns so far that linear equations do not tell its motion.
    """
    if trajectory.frame is None or engine.simulates:
        return 0.0
    turned = float(np.abs(trajectory.frame.displacement[:, 2]).max())
    if turned > _GREATEST_ROTATION:
        raise ComputationError(
            f"the frame turns by {DEGREES * turned:.3g} deg in the linear equations of the "
            f"{engine.name} engine, which hold for small rotations; run it by the exudyn engine, "
            "in which a frame turns by any angle, or state stiffer springs in [frame]"
        )
    return turned


def frame_aspect(dataset: xr.Dataset) -> Aspect:
    """How a frame on springs moves, and what its springs put on the floor.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    Aspect
        Nothing where the frame stands. An error is that by step, component modes, mesh and
        rotation, or the difference of two engines where that is more.
    """
    if "frame_rotation" not in dataset:
        return Aspect()
    numbers = _numbers(dataset)
    return Aspect(_answer(numbers), _lines(dataset), _warnings(dataset), numbers)


def _warnings(dataset: xr.Dataset) -> tuple[str, ...]:
    """What to do where a frame turns further than linear equations tell well."""
    errors = dataset.get("rotation_error")
    if errors is None or float(errors.max()) <= _WORTH_A_WARNING:
        return ()
    turned, linear = float(errors.max()), str(errors.idxmax("engine").item())
    return (
        f"the frame turns by up to {DEGREES * turned:.3g} deg: the linear equations of {linear} "
        f"hold for small rotations, and are off by about {100 * turned:.2g} %; trust the exudyn "
        "engine, in which a frame turns by any angle, or state stiffer springs in [frame]",
    )


def _floor_force(frame: SprungFrame, moved: FrameMotion) -> FloatArray:
    """Resultant of the springs and their dampers on the floor in ground axes, (N, 2)."""
    force = moved.displacement @ frame.stiffness + moved.rate @ frame.damping
    return np.asarray(force[:, :2])


def _numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Greatest displacement, rotation and floor force, of the engine whose errors are least."""
    found = list[Quantity]()
    causes = (f"{cause}_error_of_peak_frame" for cause in CAUSES)
    known = sum((dataset[cause] for cause in causes if cause in dataset), xr.DataArray(0.0))
    place = int(known.argmin("engine"))
    for name, (unit, factor) in _PEAKS.items():
        peaks = dataset[f"peak_{name}"]
        found += quantities_of(peaks, known * peaks, place, f"peak_{name}", unit, factor)
    return tuple(one for one in found if math.isfinite(one.value) and one.value)


def _answer(numbers: Sequence[Quantity]) -> tuple[str, ...]:
    """How far a frame on springs moves, and what its springs put on the floor."""
    told = {one.name.removeprefix("peak_"): one for one in numbers}
    said = {
        "frame_displacement": "moves by at most {}",
        "frame_rotation": "turns by at most {}",
        "floor_force": "its springs put up to {} on the floor",
    }
    parts = [words.format(told[name]) for name, words in said.items() if name in told]
    if not parts:
        return ()
    *before, last = parts
    if not before:
        return (f"On its springs the frame stands still; {last}.",)
    return (f"The frame {' and '.join(before)}; {last}.",)


def _lines(dataset: xr.Dataset) -> tuple[str, ...]:
    """How the shaking force compares with that on the floor."""
    shaking = (dataset["shaking_force"] ** 2).sum("component") ** 0.5
    pairs = zip(
        dataset["engine"].values,
        shaking.max("time").values,
        dataset["peak_floor_force"].values,
        strict=True,
    )
    told = (f"{force:.4g} N and {floor:.4g} N ({engine})" for engine, force, floor in pairs)
    return (
        "frame: on springs; greatest shaking force and force on the floor: "
        f"{', '.join(told)}; joint forces and the shaking force are in ground axes",
    )
