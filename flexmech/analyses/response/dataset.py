"""From runs to one labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import attributes_of, provenance, rigid_positions
from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.analyses.response import measurements
from flexmech.analyses.response.driven import (
    drive_attributes,
    driven_values,
    law_of_run,
    motor_of_run,
    spectra_from,
)
from flexmech.analyses.response.measurements import (
    WHOLE_PERIODS,
    amplitude_spectrum,
    resolution_note,
    spectrogram,
    window_duration,
)
from flexmech.analyses.response.path import path_values, rigid_path
from flexmech.analyses.response.plan import SPECTRUM_REACH, RunPlan, oscillating, vibrating_engine
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.residual_vibration import residual_values
from flexmech.analyses.response.run import EngineRun, RunError
from flexmech.analyses.response.shaking import rigid_shaking, running_shaking
from flexmech.analyses.response.sizes import sizes_of_run
from flexmech.analyses.response.sprung_frame import carried_along, frame_values
from flexmech.analyses.response.stresses import peak_stresses
from flexmech.analyses.schema import Values, schema_of
from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import Drive, RigidMotion
from flexmech.mechanics import Engine
from flexmech.mechanics.running import Trajectory
from flexmech.mechanism import drawing
from flexmech.solvers.formulation import Formulation

SCHEMA = schema_of(__package__)

# Positions at which the length of the spectrogram's window is chosen, every 10 deg of four turns,
# and at which ranges of natural frequencies are sought, every 2.5 deg of a turn.
_PREDICTIONS = 145


def build_dataset(runs: Sequence[EngineRun], request: ResponseRequest, plan: RunPlan) -> xr.Dataset:
    """Label the runs of all engines.

    Parameters
    ----------
    runs : sequence of EngineRun
    request : ResponseRequest
    plan : RunPlan
        Plan of the runs.

    Returns
    -------
    xarray.Dataset
    """
    engines, time = [run.engine for run in runs], request.sample_time()
    first, topology = engines[0], engines[0].mechanism.linkage.topology
    motion = request.drive.motion(first.mechanism.linkage, time)
    duration, turns = _window(first, request, plan.lowest), whole_turns(request)
    last_turn = slice(-request.samples * plan.refinement - 1 if turns else None, None)
    parts = [
        {
            **_history(run, motion, plan.refinement, request, rotor_torque),
            **_peaks(run, request.drive),
            **path_values(run.engine, run.trajectory, motion, request.drive, plan.refinement),
            **_spectra(run, request, plan, duration),
            **driven_values(run.trajectory, request, plan.refinement),
            **motor,
            **sizes_of_run(run.engine, run.trajectory, request, driven, last_turn),
        }
        for run in runs
        for motor, rotor_torque, driven in [motor_of_run(run.trajectory, request, plan.refinement)]
    ]
    values = {
        "engine": [engine.name for engine in engines],
        "element": [engine.element for engine in engines],
        "nonlinear": [engine.simulates for engine in engines],
        "time": time,
        "crank_angle": motion.crank_angle,
        "link": list(topology.link_names),
        "probe": measurements.probes(first),
        "length": [link.length for link in topology.links],
        "joint": list(topology.joint_names),
        "joint_kind": list(topology.joint_kinds),
        "force_on": [on for on, _ in topology.joint_sides],
        "force_by": [by for _, by in topology.joint_sides],
        "station": np.linspace(0.0, 1.0, parts[0]["displacement"].shape[2]),
        "component": ["x", "y"],
        **_rigid_values(first, motion),
        **rigid_path(first.mechanism, motion),
        **rigid_shaking(first, motion, request),
        **law_of_run(first, request),
        **_ranges(first, request),
    }
    dataset = SCHEMA.dataset(values, "time", parts, "engine")
    rests = [residual_values(run.engine, run.trajectory, request, plan.refinement) for run in runs]
    dataset = dataset.merge(SCHEMA.dataset({}, "time", rests, "engine"))
    if "spectrogram" in dataset:
        step = float(dataset["window_frequency"][1] - dataset["window_frequency"][0])
        predicted = dataset["natural_frequency"].transpose(..., "mode").values
        note = resolution_note(predicted.reshape(-1, request.modes), 1 / step)
        dataset = dataset.assign_attrs(spectrogram_note=note)
    if (point := first.mechanism.coupler_point) is not None:
        place = {"coupler_point_distance": point.distance, "coupler_point_angle": point.angle}
        dataset = dataset.assign_attrs(place)
    asked = ("revolutions", "start", "integrator", "prestress")
    return dataset.assign_attrs(
        provenance(engines) | attributes_of(request, *asked),
        drawing=drawing(first.mechanism),
        **drive_attributes(request),
        speed_unit=request.shown_unit,
        run_up_time=request.drive.law_time,
        shaft=first.shaft,
        force_band=plan.band,
        damped=int(first.has_damped_links),
        start=request.start,
        spectrum_turns=turns,
        sizing_over="the last turn" if turns else "the run",
    )


def whole_turns(request: ResponseRequest) -> int:
    """Whole turns of a run on the periodic motion, whose spectrum has lines at the orders alone.

    Parameters
    ----------
    request : ResponseRequest

    Returns
    -------
    int
        0 for other runs, and for shorter ones.
    """
    turns = request.duration / request.drive.revolution_time
    return int(turns + 1e-9) if request.start == "periodic" else 0


def _history(
    run: EngineRun,
    motion: RigidMotion,
    refinement: int,
    request: ResponseRequest,
    rotor_torque: FloatArray | None,
) -> Values:
    """What a run measures at the samples asked for, and how far it may be trusted."""
    engine, trajectory = run.engine, run.trajectory[::refinement]
    energy = trajectory.energy
    carried = carried_along(engine, motion, trajectory)
    displacement = measurements.ground_displacements(engine, trajectory, carried)
    drift = measurements.constraint_drift(engine, displacement, carried)
    if carried is not motion:
        displacement = displacement + rigid_positions(engine, carried)
        displacement -= rigid_positions(engine, motion)
    return {
        "deflection": measurements.deflections(engine, trajectory.displacement),
        "strain": measurements.bending_strains(engine, trajectory),
        "driving_torque": trajectory.driving_torque,
        "joint_force": trajectory.joint_force,
        "displacement": displacement,
        "kinetic_energy": energy.kinetic,
        "strain_energy": energy.strain,
        "gravity_energy": energy.gravity,
        "dissipated_energy": energy.dissipated,
        "drive_work": energy.drive_work,
        "prestress_work": energy.prestress_work,
        "constraint_drift": drift,
        "step": trajectory.step,
        "energy_error": trajectory.energy_error,
        "peak_driving_torque": trajectory.peak_driving_torque,
        "peak_joint_force": trajectory.peak_joint_force,
        **_errors("step", run.step_error),
        **_errors("reduction", run.reduction_error),
        **({} if trajectory.frame is None else _errors("rotation", run.rotation_error)),
        **_shaft(trajectory, run.trajectory),
        **frame_values(engine, trajectory, run.trajectory),
        **running_shaking(engine, trajectory, carried, request, rotor_torque),
    }


def _shaft(trajectory: Trajectory, refined: Trajectory) -> Values:
    """How a free shaft turns against its prescribed angle; nothing where it does not."""
    shaft, every = trajectory.shaft, refined.shaft
    if shaft is None or every is None:
        return {}
    return {
        "shaft_rotation": shaft.rotation,
        "crank_speed_fluctuation": shaft.rate,
        "peak_shaft_rotation": np.abs(every.rotation).max(),
        "peak_crank_speed_fluctuation": np.abs(every.rate).max(),
    }


def _peaks(run: EngineRun, drive: Drive) -> Values:
    """Greatest deflections, strains and stresses, between the samples that were asked for too."""
    angle = drive.crank_angle(run.trajectory.time)
    moved = measurements.deflections(run.engine, run.trajectory.displacement)
    deflection, where = peaks_between(moved, angle)
    strain, _ = peaks_between(measurements.bending_strains(run.engine, run.trajectory), angle)
    stressed = peak_stresses(run.engine, run.trajectory, drive)
    return {
        "peak_deflection": deflection,
        "peak_deflection_angle": where,
        "peak_strain": strain,
        "peak_stress": stressed.stress,
        "peak_axial_stress": stressed.axial,
        "peak_stress_place": stressed.place,
        "peak_stress_angle": stressed.crank_angle,
        "yield_strength": stressed.yield_strength,
    }


def add_mesh_errors(dataset: xr.Dataset, errors: Sequence[RunError]) -> None:
    """Label the errors of the mesh, one for each engine."""
    parts = [_errors("mesh", error) for error in errors]
    dataset.update(SCHEMA.dataset({}, "time", parts, "engine"))


# Errors of each link, joint or point; those of others are single numbers.
_OF_EACH = ("deflection", "stress", "force", "path")


def _errors(cause: str, error: RunError) -> Values:
    """Errors by one cause: of deflections over link, of forces over joint, of paths over point."""
    return {f"{cause}_error": error.linkage} | {
        f"{cause}_error_of_{name}": values
        if name.removeprefix("peak_") in _OF_EACH
        else float(values[0])
        for name, values in error.of.items()
    }


def _rigid_values(engine: Engine, motion: RigidMotion) -> Values:
    """Torque, forces and positions if the links were rigid."""
    mechanism = engine.mechanism
    topology = mechanism.linkage.topology
    forces = mechanism.inverse_dynamics(motion)
    joint_force = np.stack([forces.joint_force[name] for name in topology.joint_names], axis=1)
    return {
        "rigid_driving_torque": forces.driving_torque,
        "rigid_joint_force": joint_force,
        "rigid_position": rigid_positions(engine, motion),
    }


def _predicted(engine: Engine, request: ResponseRequest, time: FloatArray) -> FloatArray:
    """Natural frequencies at times; shape (time, mode) in Hz."""
    drive, formulation = request.drive, Formulation(request.prestress, modes=request.modes)
    # A crank that stands has one position.
    states = np.column_stack([drive.crank_angle(time), drive.crank_speed(time)])
    if not np.ptp(states, axis=0).any():
        states = states[:1]
    angle, speed = states.T
    found = oscillating(
        lambda one: frequencies_at(one, angle, speed, formulation), vibrating_engine(engine)
    )[0]
    return np.broadcast_to(found, (len(time), request.modes))


def _ranges(engine: Engine, request: ResponseRequest) -> Values:
    """Range of each natural frequency over a turn; where the speed changes, over what is passed.

    Of a run at constant speed a whole turn counts, however long the run. The spectra of a law of
    motion or under a motor are of the crank angles from :func:`spectra_from` on.
    """
    drive, begin = request.drive, spectra_from(request)
    end = float(request.sample_time()[-1])
    if drive.turns_on:
        end = begin + drive.revolution_time
    found = _predicted(engine, request, np.linspace(begin, end, _PREDICTIONS))
    return {
        "lowest_natural_frequency": found.min(axis=0),
        "highest_natural_frequency": found.max(axis=0),
        "mode": np.arange(1, request.modes + 1),
    }


def _window(engine: Engine, request: ResponseRequest, lowest: float) -> float:
    """Length of the spectrogram's window in s, the same for all engines."""
    ends = spectra_from(request), float(request.sample_time()[-1])
    time = np.linspace(*ends, _PREDICTIONS)
    return window_duration(time, _predicted(engine, request, time), lowest)


def _spectra(run: EngineRun, request: ResponseRequest, plan: RunPlan, duration: float) -> Values:
    """Spectra of a run at its final speed; in time as well where it is long enough."""
    begin, interval = spectra_from(request), request.sample_interval / plan.refinement
    steady = run.trajectory.time >= begin - 1e-12
    signals = measurements.deflections(run.engine, run.trajectory.displacement)[steady].T
    up_to = SPECTRUM_REACH * plan.highest
    frequency, amplitude = amplitude_spectrum(signals, interval, up_to)
    if turns := whole_turns(request):
        # Of what repeats every turn, over whole turns: lines at the orders.
        last = signals[:, -turns * request.samples * plan.refinement :]
        frequency, amplitude = amplitude_spectrum(last, interval, up_to, WHOLE_PERIODS)
    spectra = {"spectrum": amplitude, "spectrum_frequency": frequency}
    moving = spectrogram(signals, interval, plan.lowest, up_to, duration)
    if moving is None:
        return spectra
    middle = moving.time + begin
    return spectra | {
        "spectrogram": moving.amplitude,
        "natural_frequency": _predicted(run.engine, request, middle),
        "window_frequency": moving.frequency,
        "window_time": middle,
    }


# Where links are takes nine tenths of a run, and is drawn for the animation's last turn alone.
_PLACES = ("displacement", "rigid_position")
# Whose balance is stored: none is drawn, and none is in a table.
ENERGIES = (
    "kinetic_energy",
    "strain_energy",
    "gravity_energy",
    "dissipated_energy",
    "drive_work",
    "prestress_work",
)
# Twice the pictures of an animation: its path has a point between two of them.
MOST_FRAMES = 240
# Round-off must not lose the sample a full turn before the last one.
_ROUND_OFF = 1e-9


def needed(dataset: xr.Dataset) -> xr.Dataset:
    """Leave out what neither pictures nor comparisons need.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``rigid_position`` over ``frame_time``, which are samples of the last
        turn, instead of ``time``, and no energies but the error of their balance.
    """
    if "frame_time" in dataset.dims:
        return dataset
    frames = _frames(dataset["crank_angle"].values)
    places = dataset[[*_PLACES]].isel(time=frames)
    places = places.rename(time="frame_time", crank_angle="frame_angle")
    whole = dataset.drop_vars([*_PLACES, *ENERGIES])
    return whole.merge(places, combine_attrs="override")


def _frames(angle: FloatArray) -> IntArray:
    """Samples of the last turn, evenly spaced up to the last one."""
    shown = np.flatnonzero(np.abs(angle[-1] - angle) <= 2 * np.pi * (1 + _ROUND_OFF))
    intervals = len(shown) - 1
    least = max(1, -(-intervals // MOST_FRAMES))
    # If it can be, the first one is a whole number of frames before the last one.
    whole = [step for step in range(least, 2 * least) if intervals % step == 0]
    return np.asarray(shown[:: -(whole or [least])[0]][::-1])
