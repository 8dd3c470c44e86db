"""From counterweights to one labelled dataset: the linkage as given, and balanced."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.shaking import harmonic_values
from flexmech.analyses.balance.compromise import inertia_loads
from flexmech.analyses.balance.counterweights import Counterweight
from flexmech.analyses.balance.elastic import ElasticShaking
from flexmech.analyses.balance.peaks import rigid_peaks
from flexmech.analyses.balance.request import BalanceRequest
from flexmech.analyses.datasets import origin
from flexmech.analyses.schema import Values, schema_of
from flexmech.linkages.frame_forces import ShakingForce, shaft_axis
from flexmech.mechanism import Mechanism

STATES = ("as given", "balanced")
"""Of the linkage, along the dimension ``state``."""

SCHEMA = schema_of(__package__)
# Of a turn whose harmonics are told.
_STEPS = 720
_TURN = 2 * np.pi


def balance_dataset(
    states: Sequence[Mechanism], weights: Sequence[Counterweight], request: BalanceRequest
) -> xr.Dataset:
    """Loads of rigid links before and after, and the counterweights.

    Parameters
    ----------
    states : sequence of Mechanism
        As given, and balanced.
    weights : sequence of Counterweight
    request : BalanceRequest

    Returns
    -------
    xarray.Dataset
    """
    given, point = states[0], request.moment_point
    topology = given.linkage.topology
    if point is None:
        point = shaft_axis(topology, given.linkage.motion(request.crank_angles[:1]))
    values: Values = {
        "state": list(STATES),
        "crank_angle": request.crank_angles,
        "component": ["x", "y"],
        "joint": list(topology.joint_names),
        "moment_point": np.array(point),
        "counterweight": [weight.link.name for weight in weights],
        "counterweight_mass": [weight.mass for weight in weights],
        "counterweight_radius": [weight.radius for weight in weights],
        "counterweight_angle": [weight.angle for weight in weights],
        "counterweight_place": [weight.place for weight in weights],
        "counterweight_about": [_joint_at(given, weight) for weight in weights],
    }
    parts = [_state(each, request) for each in states]
    dataset = SCHEMA.dataset(values, parts=parts, along="state")
    dataset = dataset.merge(rigid_peaks(states, request))
    return dataset.assign_attrs(
        {
            **origin(given),
            "crank_speed": request.speed_of(given),
            "speed_unit": request.shown_unit(given),
            "weight": float(np.linalg.norm(given.gravity)),
        }
    )


def _joint_at(mechanism: Mechanism, weight: Counterweight) -> str:
    """Joint about which the link of a counterweight rotates."""
    topology, link = mechanism.linkage.topology, weight.link
    fixed = {pivot.link_end: pivot.joint for pivot in topology.pivots}
    fixed |= {clamp.link_end: clamp.joint for clamp in topology.clamps}
    return next(joint for end, joint in fixed.items() if end.link == link.name)


def _state(mechanism: Mechanism, request: BalanceRequest) -> Values:
    """Loads of one state over the crank angles."""
    speed = request.speed_of(mechanism)
    motion = mechanism.linkage.motion(request.crank_angles, speed)
    loads = inertia_loads(mechanism, motion, request.moment_point)
    forces = mechanism.without_loads_over_time.inverse_dynamics(motion)
    joints = mechanism.linkage.topology.joint_names
    return {
        "shaking_force": loads.force,
        "shaking_moment": loads.moment,
        "driving_torque": loads.torque,
        "joint_force": np.stack([forces.joint_force[name] for name in joints], axis=1),
        "moving_mass": sum(mass.moment(0) for mass in mechanism.link_masses_in_order),
        **_harmonics(mechanism, speed, request),
    }


def _harmonics(mechanism: Mechanism, speed: float, request: BalanceRequest) -> Values:
    """Harmonics of the shaking force, where the angles asked for span a turn."""
    first, last = request.crank_angles[[0, -1]].tolist()
    if last - first < _TURN * (1 - 1e-9):
        return {}
    angles = first + _TURN * np.arange(_STEPS) / _STEPS
    loads = inertia_loads(mechanism, mechanism.linkage.motion(angles, speed), request.moment_point)
    return harmonic_values(ShakingForce(loads.force, loads.moment, (0.0, 0.0)), angles)


def elastic_variables(found: Sequence[ElasticShaking]) -> xr.Dataset:
    """Shaking force of elastic links in periodic motion, and the first natural frequency.

    Parameters
    ----------
    found : sequence of ElasticShaking
        Of each state.

    Returns
    -------
    xarray.Dataset
    """
    return SCHEMA.dataset(
        {
            "elastic_shaking_force": np.stack([each.force for each in found]),
            "elastic_shaking_moment": np.stack([each.moment for each in found]),
            "first_frequency": [each.first_frequency for each in found],
            "first_frequency_error": [
                each.first_frequency * each.frequency_error for each in found
            ],
            "state": list(STATES),
            "elastic_angle": found[0].crank_angle,
            "component": ["x", "y"],
        }
    )
