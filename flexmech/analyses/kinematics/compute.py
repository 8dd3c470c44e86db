"""Rigid motion and inverse dynamics of a mechanism over crank angles."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.kinematics.dataset import kinematics_dataset
from flexmech.analyses.kinematics.request import KinematicsRequest
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.linear_system import checked_mechanism
from flexmech.mechanism import Mechanism
from flexmech.numbers import check_instance


def kinematics(mechanism: Mechanism, request: KinematicsRequest | None = None) -> Kinematics:
    """Angles, velocities, accelerations, joint forces and driving torque of the rigid linkage.

    The shaft turns at constant speed. Loads over time begin at crank angle zero.

    Parameters
    ----------
    mechanism : Mechanism
    request : KinematicsRequest, optional
        A turn in steps of one degree at the mechanism's speed if left out.

    Returns
    -------
    Kinematics

    Raises
    ------
    InputError
        If the linkage cannot be assembled or locks at a crank angle, its connections do not
        determine the forces, or the numbers of lumped masses do not fit its links.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.kinematics(mechanism, flexmech.KinematicsRequest(crank_speed=20.0))
    >>> float(abs(found.dataset["driving_torque"]).max().round(3))  # N m
    0.33
    """
    mechanism = checked_mechanism(mechanism)
    request = KinematicsRequest() if request is None else request
    check_instance(request, KinematicsRequest, "request", "give a flexmech.KinematicsRequest")
    speed, elements = request.speed_of(mechanism), request.lumped_of(mechanism)
    motion = mechanism.linkage.motion(request.crank_angles, speed)
    time = request.crank_angles / speed if speed else np.zeros_like(request.crank_angles)
    forces = mechanism.inverse_dynamics(motion, time)
    lumped = None
    if elements is not None:
        lumped = mechanism.inverse_dynamics(motion, time, elements)
    return Kinematics(kinematics_dataset(mechanism, forces, lumped, elements, request))
