"""How far points of a running linkage leave the paths that they have where all links are rigid.

A point off the axis of a link is carried by the section at its foot: by a rigid arm, which turns by
the section's finite rotation, as the tool does that is a body of the model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.kinematics.positions import points_of
from flexmech.analyses.response.agreement import best_known, errors_of
from flexmech.analyses.response.sprung_frame import carried_along
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect, Table
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.linkages import Drive, RigidMotion
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory
from flexmech.mechanics.section_forces import displaced_axis
from flexmech.mechanism import Mechanism


@dataclass(frozen=True)
class CarriedPoint:
    """A point that a section of a link carries.

    Parameters
    ----------
    link : int
    foot : float
        Place of the section, from the link's start in m.
    arm : complex
        From there to the point in m: along the link, and across it times i.
    """

    link: int
    foot: float
    arm: complex = 0.0

    def rigid_position(self, motion: RigidMotion) -> FloatArray:
        """Place on a rigid link in ground axes in m; (N, 2)."""
        return motion.position(self.link, self.foot + self.arm.real, self.arm.imag)


def carried_points(mechanism: Mechanism) -> dict[str, CarriedPoint]:
    """Points that move, by their names in the model file: joints, coupler point and bodies.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict of str to CarriedPoint
        A body is named by its link and its number among those of the link, as ``"coupler body 1"``.
        The foot of a coupler point is opposite to it, or the nearer end of its link.
    """
    topology, points = mechanism.linkage.topology, dict[str, CarriedPoint]()
    for name, (link, x, y) in points_of(mechanism).items():
        foot = float(np.clip(x, 0.0, topology.links[link].length))
        points[name] = CarriedPoint(link, foot, complex(x - foot, y))
    counted = dict.fromkeys(topology.link_names, 0)
    for body in mechanism.bodies:
        if body.mass:
            counted[body.link] += 1
            place = CarriedPoint(topology.index(body.link), body.position, complex(*body.offset))
            points[f"{body.link} body {counted[body.link]}"] = place
    return points


def rigid_path(mechanism: Mechanism, motion: RigidMotion) -> Values:
    """Where the points are in a motion of the rigid linkage.

    Parameters
    ----------
    mechanism : Mechanism
    motion : RigidMotion
        Batch of shape (N,).

    Returns
    -------
    dict
        ``rigid_point_position`` (N, P, 2) in m, and names as ``point``; empty without points.
    """
    points = carried_points(mechanism)
    if not points:
        return {}
    places = [point.rigid_position(motion) for point in points.values()]
    return {"point": list(points), "rigid_point_position": np.stack(places, axis=1)}


def path_deviation(engine: Engine, trajectory: Trajectory, motion: RigidMotion) -> FloatArray:
    """Places of points along a run less those at the same time on rigid links, in ground axes.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
    motion : RigidMotion
        Prescribed motion of the rigid linkage on a frame that stands, at the N samples.

    Returns
    -------
    ndarray, shape (N, P, 2)
        In m. Rotation of a free shaft and motion of a frame on springs are in it.
    """
    points = carried_points(engine.mechanism)
    carried, found = carried_along(engine, motion, trajectory), []
    for point in points.values():
        number = point.link
        # The axis of a rigid link is straight: its start carries all of it.
        foot = 0.0 if engine.links[number].rigid else point.foot
        at, turned = displaced_axis(
            engine.links[number], trajectory.displacement[number], np.array([foot])
        )
        arm = point.arm + point.foot - foot
        place = (at + arm * np.exp(1j * turned))[:, 0] * np.exp(1j * carried.angle[:, number])
        moved = carried.origin[:, number] + np.stack([place.real, place.imag], axis=-1)
        found.append(moved - point.rigid_position(motion))
    deviation = np.stack(found, axis=1) if found else np.zeros((len(trajectory.time), 0, 2))
    extent = sum(body.length for body in engine.mechanism.linkage.topology.links)
    # Less is what round-off leaves of none.
    deviation[np.linalg.norm(deviation, axis=-1) <= ROUND_OFF * extent] = 0.0
    return deviation


def path_values(
    engine: Engine, trajectory: Trajectory, motion: RigidMotion, drive: Drive, refinement: int
) -> Values:
    """Places of points along a run, and how far they are off their paths on rigid links.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the refined samples.
    motion : RigidMotion
        Prescribed, at the N samples asked for.
    drive : Drive
    refinement : int
        Refined samples for each one asked for.

    Returns
    -------
    dict
        Empty without points.
    """
    rigid = rigid_path(engine.mechanism, motion)
    if not rigid:
        return {}
    refined = drive.motion(engine.mechanism.linkage, trajectory.time)
    deviation = path_deviation(engine, trajectory, refined)
    size = np.linalg.norm(deviation, axis=-1)
    peak, where = peaks_between(size, refined.crank_angle)
    return {
        "point_position": rigid["rigid_point_position"] + deviation[::refinement],
        "path_deviation": size[::refinement],
        "peak_path_deviation": peak,
        "peak_path_deviation_angle": where,
    }


def path_words(data: xr.Dataset, greatest: Quantity) -> str:
    """Sentence on the point that leaves its path most.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.
    greatest : Quantity
        That of the peaks which is the greatest.

    Returns
    -------
    str
    """
    angle = data["peak_path_deviation_angle"].sel(point=greatest.of).isel(engine=0)
    who = f"{'joint ' * (greatest.of in data['joint'])}{greatest.of}"
    return (
        f"{who[:1].upper()}{who[1:]} leaves its path on rigid links by up to {greatest}, at "
        f"{DEGREES * float(angle) % 360:.0f} deg."
    )


def path_aspect(data: xr.Dataset) -> Aspect:
    """How far each point leaves its path, by each engine.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    Aspect
        Nothing where no point moves.
    """
    if "path_deviation" not in data:
        return Aspect()
    peaks, place = data["peak_path_deviation"], best_known(errors_of(data)["deflection"])
    errors = errors_of(data)["peak_path_deviation"] * peaks
    angles = DEGREES * data["peak_path_deviation_angle"].isel(engine=place) % 360
    texts = np.vectorize(rounded, otypes=[object])(1e3 * peaks.values, 1e3 * errors.values)
    rows = tuple(
        (str(point), *texts[:, number], f"{float(angles[number]):.1f}")
        for number, point in enumerate(data["point"].values)
    )
    headings = ("point", *map(str, data["engine"].values), "at deg")
    title = "greatest distance in mm from the point's place on rigid links"
    return Aspect(details=(Table(title, headings, (rows,)), _axes(data)))


def _axes(data: xr.Dataset) -> str:
    """In which axes the paths are, and what the distance counts besides elastic links."""
    moves = ["the motion of the frame on its springs"] if "frame_rotation" in data else []
    moves += ["the rotation of the free shaft"] if "shaft_rotation" in data else []
    counted = f"; the distance counts {' and '.join(moves)} too" if moves else ""
    return f"paths: in ground axes{counted}"
