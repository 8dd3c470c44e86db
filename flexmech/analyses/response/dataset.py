"""From runs to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies import Formulation, frequencies_at, natural_frequencies
from flexmech.analyses.provenance import provenance, with_units
from flexmech.analyses.response.measurements import (
    bending_strains,
    constraint_drift,
    deflections,
    ground_displacements,
    probes,
)
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.run import EngineRun
from flexmech.analyses.response.spectra import amplitude_spectrum, spectrogram
from flexmech.analyses.stations import rigid_positions
from flexmech.analyses.turn import sampled_turn
from flexmech.linear_system import Engine
from flexmech.linkages import RigidMotion, Topology, inverse_dynamics
from flexmech.types import FloatArray

__all__ = ["build_dataset"]

Variables = dict[str, tuple[tuple[str, ...], Any]]

# Spectra reach this far above the highest natural frequency asked for.
SPECTRUM_REACH = 1.5


def build_dataset(
    runs: Sequence[EngineRun],
    request: ResponseRequest,
    refinement: int,
    highest: float,
    mesh_errors: Sequence[float] | None,
) -> xr.Dataset:
    """Label the runs of all engines.

    Parameters
    ----------
    runs : sequence of EngineRun
        At samples ``refinement`` times as dense as asked for.
    request : ResponseRequest
    refinement : int
    highest : float
        Highest natural frequency asked for in Hz.
    mesh_errors : sequence of float, or None

    Returns
    -------
    xarray.Dataset
    """
    engines = [run.engine for run in runs]
    time = request.sample_time()
    motion = _motion(engines[0], request, time)
    topology = engines[0].mechanism.linkage.topology
    variables: Variables = {
        **_histories(runs, motion, refinement),
        **_rigid_values(engines[0], motion),
        **_checks(runs, mesh_errors),
    }
    spectra, coordinates = _spectra(runs, request, refinement, highest)
    variables.update(spectra)
    dataset = xr.Dataset(
        variables,
        coords={
            "engine": [e.name for e in engines],
            "element": ("engine", [e.element for e in engines]),
            "time": time,
            "crank_angle": ("time", motion.crank_angle),
            "link": list(topology.link_names),
            "probe": ("link", probes(engines[0])),
            "joint": list(topology.joint_names),
            "joint_kind": ("joint", [_kind(topology, name) for name in topology.joint_names]),
            "station": np.linspace(0.0, 1.0, engines[0].links[0].shape.shape[0]),
            "component": ["x", "y"],
            **coordinates,
        },
        attrs={
            **provenance(engines),
            "crank_speed": request.drive.speed,
            "speed_unit": request.speed_unit,
            "run_up_time": request.drive.run_up_time,
            "revolutions": request.revolutions,
            "start": request.start,
            "integrator": request.integrator,
            "prestress": request.prestress,
        },
    )
    return with_units(dataset, "response")


def _kind(topology: Topology, joint: str) -> str:
    if any(clamp.joint == joint for clamp in topology.clamps):
        return "clamp"
    return "pivot" if any(pivot.joint == joint for pivot in topology.pivots) else "pin"


def _motion(engine: Engine, request: ResponseRequest, time: FloatArray) -> RigidMotion:
    drive = request.drive
    return engine.mechanism.linkage.motion(
        drive.crank_angle(time), drive.crank_speed(time), drive.crank_acceleration(time)
    )


def _histories(runs: Sequence[EngineRun], motion: RigidMotion, refinement: int) -> Variables:
    asked = slice(None, None, refinement)
    energies = {
        "kinetic_energy": "kinetic",
        "strain_energy": "strain",
        "gravity_energy": "gravity",
        "dissipated_energy": "dissipated",
        "drive_work": "drive_work",
        "prestress_work": "prestress_work",
    }
    trajectories = [run.trajectory[asked] for run in runs]
    pairs = [(run.engine, trajectory) for run, trajectory in zip(runs, trajectories, strict=True)]
    variables: Variables = {
        "deflection": (("engine", "time", "link"), np.stack([deflections(*p) for p in pairs])),
        "strain": (("engine", "time", "link"), np.stack([bending_strains(*p) for p in pairs])),
        "driving_torque": (("engine", "time"), np.stack([t.driving_torque for t in trajectories])),
        "joint_force": (
            ("engine", "time", "joint", "component"),
            np.stack([t.joint_force for t in trajectories]),
        ),
        "displacement": (
            ("engine", "time", "link", "station", "component"),
            np.stack([ground_displacements(*p, motion) for p in pairs]),
        ),
        "constraint_drift": (
            ("engine",),
            np.array([constraint_drift(*p, motion) for p in pairs]),
        ),
    }
    for name, field in energies.items():
        values = np.stack([getattr(t.energy, field) for t in trajectories])
        variables[name] = (("engine", "time"), values)
    return variables


def _rigid_values(engine: Engine, motion: RigidMotion) -> Variables:
    mechanism = engine.mechanism
    topology = mechanism.linkage.topology
    forces = inverse_dynamics(topology, motion, mechanism.link_masses_in_order, mechanism.gravity)
    return {
        "rigid_driving_torque": (("time",), forces.driving_torque),
        "rigid_joint_force": (
            ("time", "joint", "component"),
            np.stack([forces.joint_force[name] for name in topology.joint_names], axis=1),
        ),
        "rigid_position": (
            ("time", "link", "station", "component"),
            rigid_positions(engine, motion),
        ),
    }


def _checks(runs: Sequence[EngineRun], mesh_errors: Sequence[float] | None) -> Variables:
    checks = {
        "step": [run.trajectory.step for run in runs],
        "energy_error": [run.trajectory.energy_error for run in runs],
        "step_error": [run.step_error for run in runs],
        "reduction_error": [run.reduction_error for run in runs],
    }
    if mesh_errors is not None:
        checks["mesh_error"] = list(mesh_errors)
    return {name: (("engine",), np.array(values)) for name, values in checks.items()}


def _spectra(
    runs: Sequence[EngineRun], request: ResponseRequest, refinement: int, highest: float
) -> tuple[Variables, dict[str, Any]]:
    """Spectra of the run at its final speed, and their axes."""
    steady = request.sample_time(refinement) >= request.drive.run_up_time - 1e-12
    signals = [deflections(run.engine, run.trajectory)[steady].T for run in runs]
    interval = request.sample_interval / refinement
    up_to = SPECTRUM_REACH * highest
    whole = [amplitude_spectrum(signal, interval, up_to) for signal in signals]
    variables: Variables = {
        "spectrum": (("engine", "link", "spectrum_frequency"), np.stack([a for _, a in whole]))
    }
    coordinates: dict[str, Any] = {"spectrum_frequency": whole[0][0]}
    engine, turn = runs[0].engine, sampled_turn(request.drive.start_angle)
    at_rest = natural_frequencies(engine, turn, modes=1, prestress=engine.prestress_at_rest)
    lowest = float(at_rest.min())
    pictures = [spectrogram(signal, interval, lowest, up_to) for signal in signals]
    shown = [picture for picture in pictures if picture is not None]
    if not shown:
        return variables, coordinates
    start = request.drive.run_up_time
    middle = shown[0].time + start
    prediction = [
        frequencies_at(
            run.engine,
            np.asarray(request.drive.crank_angle(middle)),
            request.drive.speed,
            Formulation(request.prestress, modes=request.modes),
        )
        for run in runs
    ]
    variables["spectrogram"] = (
        ("engine", "link", "window_frequency", "window_time"),
        np.stack([picture.amplitude for picture in shown]),
    )
    variables["natural_frequency"] = (("engine", "window_time", "mode"), np.stack(prediction))
    coordinates.update(
        window_frequency=shown[0].frequency,
        window_time=middle,
        mode=np.arange(1, request.modes + 1),
    )
    return variables, coordinates
