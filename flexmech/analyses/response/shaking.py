"""What a running mechanism exerts on its frame."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.shaking import (
    harmonic_values,
    harmonics_line,
    point_text,
    shaft_torque,
    shaking_of,
)
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.agreement import errors_of
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.linkages import MotorRun, RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import Moved
from flexmech.linkages.frame_forces import ShakingForce, shaking_force
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory


def running_shaking(
    engine: Engine,
    trajectory: Trajectory,
    carried: RigidMotion,
    request: ResponseRequest,
    rotor_torque: FloatArray | None = None,
) -> Values:
    """Shaking force and moment along a run of elastic links, and harmonics of its last turn.

    By the joint forces of the run, as far as its band lets them through, and the springs to the
    ground at their displaced ends.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the N samples asked for.
    carried : RigidMotion
        Motion of the rigid linkage at the angles that the shaft has.
    request : ResponseRequest
    rotor_torque : ndarray, shape (N,), optional
        For a motor: rate of the angular momentum of its rotor in N m.

    Returns
    -------
    dict
    """
    mechanism = engine.mechanism
    turning = any(spring.torsional_stiffness for spring in mechanism.joint_springs)
    torque = trajectory.driving_torque
    if trajectory.shaft is None:
        # Of a free shaft the drive gives the torque that it has, its inertia's share included.
        torque = torque + shaft_torque(request.drive, mechanism.shaft_inertia, trajectory.time)
    elif rotor_torque is not None and isinstance(request.drive, MotorRun):
        # That of a rotor which turns rigidly with the crank is what gear and motor exert together.
        train = request.drive.equation.train
        torque = torque + (1.0 - (not train.is_coupled) * train.motor.gear_ratio) * rotor_torque
    found = shaking_force(
        mechanism.linkage.topology,
        carried,
        trajectory.joint_force,
        torque,
        request.moment_point,
        springs=mechanism.springs,
        joint_springs=mechanism.joint_springs,
        angles=continuous_angles(mechanism.linkage, carried) if turning else None,
        moved=_moved(engine, trajectory, carried),
    )
    return _values(found, trajectory.time, request)


def rigid_shaking(engine: Engine, motion: RigidMotion, request: ResponseRequest) -> Values:
    """The same if the links were rigid, with names that begin with ``rigid_``.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Prescribed, at the N samples asked for.
    request : ResponseRequest

    Returns
    -------
    dict
        With ``moment_point`` (component).
    """
    mechanism, time = engine.mechanism, request.sample_time()
    forces = mechanism.inverse_dynamics(motion, time)
    shaft = shaft_torque(request.drive, mechanism.shaft_inertia, time)
    found = shaking_of(mechanism, forces, request.moment_point, shaft)
    values = _values(found, time, request, "rigid_")
    return {**values, "moment_point": np.array(found.point)}


def _values(
    found: ShakingForce, time: FloatArray, request: ResponseRequest, prefix: str = ""
) -> Values:
    values = {f"{prefix}shaking_force": found.force, f"{prefix}shaking_moment": found.moment}
    last = slice(-request.samples, None)
    whole = len(time) > request.samples and time[last][0] > request.drive.law_time
    if request.drive.turns_on and whole:
        turn = ShakingForce(found.force[last], found.moment[last], found.point)
        angle = request.drive.crank_angle(time[last])
        values |= harmonic_values(turn, angle, prefix)
    return values


def _moved(engine: Engine, trajectory: Trajectory, motion: RigidMotion) -> Moved:
    """Displacement and rotation of places on links along a run, and their rates."""
    lengths = [link.length for link in engine.mechanism.linkage.topology.links]

    def moved(link: int, x: float) -> tuple[FloatArray, FloatArray]:
        readings, part = engine.links[link].readings, x / lengths[link]
        rows = readings.displacement_at(np.array([part]))[0]
        turn = readings.rotation_at(part)
        q, rate = trajectory.displacement[link], trajectory.rate[link]
        to_ground = np.exp(1j * motion.angle[:, link])
        place = (q @ (rows[0] + 1j * rows[1])) * to_ground
        velocity = (rate @ (rows[0] + 1j * rows[1])) * to_ground
        velocity = velocity + 1j * motion.angular_velocity[:, link] * place
        return (
            np.stack([place.real, place.imag, q @ turn], axis=-1),
            np.stack([velocity.real, velocity.imag, rate @ turn], axis=-1),
        )

    return moved


def shaking_aspect(data: xr.Dataset) -> Aspect:
    """What shakes the frame along a run: peaks and harmonics.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    Aspect
    """
    return Aspect(details=tuple(_lines(data)), numbers=_numbers(data))


def _lines(data: xr.Dataset) -> list[str]:
    """Greatest shaking force and moment of each engine and of rigid links, and their harmonics."""
    engines = [str(name) for name in data["engine"].values]
    errors = _force_errors(data)

    def told(what: str, values: Iterable[tuple[float, float]], unit: str, rigid: float) -> str:
        pairs = zip(values, engines, strict=True)
        shown = ", ".join(
            f"{rounded(size, error)} {unit} ({name})" for (size, error), name in pairs
        )
        return f"{what}: {shown}, {rigid:.4g} {unit} (rigid links)"

    force, moment = (_peaks(data, name).values.tolist() for name in _NAMES)
    rigid_force, rigid_moment = (float(_peaks(data, f"rigid_{name}")) for name in _NAMES)
    unknown = [float("nan")] * len(engines)
    lines = [
        told("peak shaking force", zip(force, errors, strict=True), "N", rigid_force),
        told(
            f"peak shaking moment about {point_text(data)}",
            zip(moment, unknown, strict=True),
            "N m",
            rigid_moment,
        ),
    ]
    if "order" in data:
        for name in engines:
            lines.append(harmonics_line(data.sel(engine=name), f"{name}, last turn: shaking"))
    return lines


_NAMES = ("shaking_force", "shaking_moment")


def _peaks(data: xr.Dataset, name: str) -> xr.DataArray:
    """Greatest size of a shaking force or moment over the samples."""
    values = data[name]
    size = (values**2).sum("component") ** 0.5 if "component" in values.dims else abs(values)
    return size.max("time")


def _force_errors(data: xr.Dataset) -> list[float]:
    """Error in N of each engine's peak shaking force: errors at the joints to the frame, summed."""
    on_frame = np.isin(data["force_by"].values, ["shaft", "ground"])
    own = errors_of(data)["peak_joint_force"] * data["peak_joint_force"]
    return [float(each) for each in own.isel(joint=on_frame).sum("joint").values]


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Peak shaking force and moment of the first engine."""
    force, moment = (float(_peaks(data, name)[0]) for name in _NAMES)
    return (
        Quantity("peak_shaking_force", force, "N", _force_errors(data)[0], "frame"),
        Quantity("peak_shaking_moment", moment, "N m", of="frame"),
    )
