"""A frame on springs against closed forms, and its energies against the work of the drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

import flexmech
from flexmech.analyses import amplitudes_after_stop
from flexmech.linkages import GROUND, AttachmentPoint, carried_motion
from flexmech.solvers import NonlinearOrbit, nonlinear_orbit
from tests.support.sprung_frame_data import framed_file, on_springs, sprung, stiffened

ANGLES = np.radians([0.0, 100.0, 250.0])


def total_mass(mechanism: flexmech.Mechanism) -> float:
    return sum(float(link.moment(0)) for link in mechanism.link_masses_in_order)


def test_stiff_links_and_their_frame_are_one_mass(aluminium: flexmech.Mechanism) -> None:
    """sqrt(k / (M + m)) of a frame that hardly turns, whatever the crank angle."""
    frame = sprung((1e4, 3e4), inertia=1e6)
    mechanism = on_springs(stiffened(aluminium, 1e4), frame)
    found = flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism), ANGLES, modes=3)
    mass = frame.mass + total_mass(aluminium)
    expected = np.sqrt(np.array([2e4, 6e4]) / mass) / (2 * np.pi)
    assert found[:, 1:] == pytest.approx(np.tile(expected, (3, 1)), rel=1e-5)


def test_weight_softens_a_frame_that_rocks(aluminium: flexmech.Mechanism) -> None:
    """The weight of links above the centre takes m g h from the stiffness against rocking.

    As the frequency of the frame says, whose springs hold it but for rocking.
    """
    centre = (0.127, -0.02)
    springs = tuple(flexmech.FrameSpring((x, -0.02), (1e9, 5e3)) for x in (0.027, 0.227))
    frame = flexmech.SprungFrame(1e4, 3e3, centre, springs)
    mechanism = on_springs(stiffened(aluminium, 1e6), frame)
    squares = []
    for gravity in (0.0, -9.81):
        engine = flexmech.ReferenceEngine(replace(mechanism, gravity=(0.0, gravity)), 2, "euler")
        modes = flexmech.natural_frequencies(engine, ANGLES[:1], modes=1, prestress="none")
        squares.append((2 * np.pi * modes[0, 0]) ** 2)
    motion = aluminium.linkage.motion(ANGLES[:1])
    height = inertia = 0.0
    for number, link in enumerate(aluminium.link_masses_in_order):
        mass, moment = float(link.moment(0)), float(link.moment(1))
        place = motion.position(number, moment / mass)[0] - centre
        height += mass * place[1]
        inertia += mass * float(place @ place)
    change = (squares[1] - squares[0]) * (frame.inertia + inertia)
    assert change == pytest.approx(-9.81 * height, rel=1e-3)


def test_a_stiff_frame_and_a_heavy_one_are_the_ground(aluminium: flexmech.Mechanism) -> None:
    def frequencies(mechanism: flexmech.Mechanism, modes: int) -> np.ndarray:
        engine = flexmech.ReferenceEngine(mechanism, elements=4, component_modes=False)
        return flexmech.natural_frequencies(engine, ANGLES, 20.0, modes=modes)

    fixed = frequencies(aluminium, 3)
    stiff = on_springs(aluminium, sprung((1e12, 1e12)))
    assert frequencies(stiff, 3) == pytest.approx(fixed, rel=1e-6)
    heavy = on_springs(aluminium, sprung((1e6, 1e6), mass=1e9, inertia=1e9))
    assert frequencies(heavy, 6)[:, 3:] == pytest.approx(fixed, rel=1e-6)


def run(mechanism: flexmech.Mechanism, **asked: Any) -> Any:
    engine = flexmech.ReferenceEngine(mechanism, elements=4, component_modes=False)
    settings = {"revolutions": 1.0, "samples": 60, "prestress": "none", "modes": 3}
    request = flexmech.analyses.ResponseRequest(flexmech.ConstantSpeed(20.0), **settings | asked)
    return flexmech.response(engine, request).dataset.isel(engine=0)


def test_an_unbalanced_arm_shakes_its_frame_as_a_rotor_does(models: Path) -> None:
    """m e W^2 / (k - (M + m) W^2) along x and y (Den Hartog, Mechanical Vibrations, sec. 2.6)."""
    arm = stiffened(flexmech.load_mechanism(models / "rotating_arm.toml"), 1e5)
    arm = replace(arm, gravity=(0.0, 0.0))
    springs = tuple(flexmech.FrameSpring((x, 0.0), (4e3, 9e3)) for x in (-0.1, 0.1))
    frame = flexmech.SprungFrame(1.5, 1e9, (0.0, 0.0), springs)
    data = run(on_springs(arm, frame), start="periodic", step=2 * np.pi / 20.0 / 1440)
    (link,) = arm.link_masses_in_order
    mass = float(link.moment(0))
    moment = float(link.moment(1)) + arm.linkage.hub_radius * mass
    amplitude = moment * 400.0 / (np.array([8e3, 18e3]) - (frame.mass + mass) * 400.0)
    angle = data["crank_angle"].values
    wanted = amplitude * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    found = data["frame_displacement"].values
    np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-4 * amplitude.max())
    # Paths are in ground axes: the tip of the stiff arm leaves its own as far as the frame moves.
    tip = data["path_deviation"].sel(point="tip").values
    np.testing.assert_allclose(tip, np.hypot(*found.T), rtol=0, atol=2e-4 * abs(amplitude).max())


@pytest.mark.thorough
def test_the_work_of_the_drive_is_the_energy_with_that_of_the_frame(
    aluminium: flexmech.Mechanism,
) -> None:
    """The remaining error is that of the time step, of second order."""
    mechanism = replace(on_springs(aluminium, sprung((2e4, 4e4))), gravity=(0.0, -9.81))
    mechanism = replace(mechanism, loads=(PUSH,))
    turn = 2 * np.pi / 20.0
    coarse, fine = (
        float(run(mechanism, start="equilibrium", step=turn / steps)["energy_error"])
        for steps in (1440, 2880)
    )
    assert fine < 2e-5
    assert coarse / fine == pytest.approx(4.0, rel=0.2)


def test_springs_put_on_the_floor_the_mean_of_what_shakes_the_frame(
    models: Path, tmp_path: Path
) -> None:
    """Over a turn of the periodic motion; the table has what the dataset has."""
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(file), elements=2)
    request = flexmech.analyses.ResponseRequest(
        flexmech.ConstantSpeed(20.0), 1.0, samples=180, start="periodic", step=1e-3, modes=2
    )
    found = flexmech.response(engine, request)
    data = found.dataset.isel(engine=0, time=slice(0, -1))
    shaking, floor = (data[name].mean("time").values for name in ("shaking_force", "floor_force"))
    assert floor == pytest.approx(shaking, abs=2e-3 * float(abs(data["floor_force"]).max()))
    table = found.tables()["response"]
    rotation = np.degrees(found.dataset["frame_rotation"][0].values)
    assert table["frame_rotation_deg"].to_numpy() == pytest.approx(rotation)


def test_dampers_of_the_frame_damp_its_modes(models: Path, tmp_path: Path) -> None:
    """The frame alone has c / (2 sqrt(k m)); what the links add to its mass lowers it."""
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(file), elements=4)
    result = flexmech.moving_frequencies(engine, ANGLES[:2], [0.0], modes=3)
    found = result.dataset["damping_ratio"].squeeze().values
    alone = 10.0 / (2 * np.sqrt(4e4 * 2.0))
    assert (found > 0.1 * alone).all()
    assert (found < 2.0 * alone).all()


def test_a_turn_damps_a_frame_under_a_stiff_arm_as_dampers_do(models: Path) -> None:
    """Floquet exponents -c / (2 (M + m)) and sqrt(k / (M + m)) along x and y, whatever turns."""
    arm = stiffened(flexmech.load_mechanism(models / "rotating_arm.toml"), 1e5)
    arm = replace(arm, gravity=(0.0, 0.0))
    springs = tuple(flexmech.FrameSpring((x, 0.0), (4e3, 9e3), (3.0, 5.0)) for x in (-100.0, 100.0))
    frame = flexmech.SprungFrame(1.5, 1e4, (0.0, 0.0), springs)
    engine = flexmech.ReferenceEngine(on_springs(arm, frame), 1)
    data = flexmech.stability(engine, [20.0], modes=3).dataset.isel(engine=0, crank_speed=0)
    mass = frame.mass + float(arm.link_masses_in_order[0].moment(0))
    decay = -np.sort(data["log_modulus"].values.ravel()) * 20.0 / (2 * np.pi)
    assert decay[2:] == pytest.approx(np.repeat([10.0, 6.0], 2) / (2 * mass), rel=1e-3)
    # The angle of a multiplier is the frequency in turns of the crank, less whole turns.
    turns = np.sqrt(np.array([8e3, 18e3]) / mass - np.array([3.0, 5.0]) ** 2 / mass**2) / 20.0
    angles = np.abs(data["angle"].values.ravel())
    for angle in 2 * np.pi * np.abs(turns - np.round(turns)):
        assert np.abs(angles - angle).min() < 2e-3


def test_a_hammer_hits_the_modes_of_a_linkage_with_its_frame(models: Path, tmp_path: Path) -> None:
    """Frequency responses of Exudyn's nonlinear transient beside those of the linear modes."""
    aluminium = flexmech.load_mechanism(framed_file(tmp_path, models / "aluminium_fourbar.toml"))
    sections = {k: one.with_damping_time(2e-4) for k, one in aluminium.sections.items()}
    mechanism = replace(aluminium, sections=sections)
    found = flexmech.hammer_test(
        flexmech.ExudynEngine(mechanism, 2), flexmech.analyses.HammerRequest(ANGLES[1:2], modes=3)
    )
    reference = flexmech.ReferenceEngine(mechanism, 2)
    modes = flexmech.natural_frequencies(reference, ANGLES[1:2], modes=3)[0]
    assert found.dataset["eigen_frequency"][0, :3].values == pytest.approx(modes, rel=1e-4)
    assert float(found.dataset["simulation_error"][0]) < 3e-3


def test_the_frame_counts_in_orders_of_a_running_linkage(models: Path, tmp_path: Path) -> None:
    """Harmonic balance and more moving modes agree on them."""
    bare = models / "aluminium_fourbar.toml"
    points = (flexmech.LinkPoint.parse(text) for text in ("coupler:0.5", "rocker:0.5"))
    asked = dict(zip(("impact", "response"), points, strict=True))
    asked |= {"prestress": "axial", "damping_ratio": 0.1, "bandwidth": 60.0, "orders": 1}
    framed, held = (
        flexmech.running_hammer_test(
            flexmech.ReferenceEngine(flexmech.load_mechanism(file), elements=4), 20.0, **asked
        ).dataset
        for file in (framed_file(tmp_path, bare), bare)
    )
    assert np.abs(framed["peak"] / held["peak"] - 1).max() > 0.01
    assert framed["balance_error"].max() < 1e-4
    assert framed["reduction_error"].max() < 1e-2


def test_frequencies_change_with_the_mass_of_the_frame(models: Path, tmp_path: Path) -> None:
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    mechanism = flexmech.load_mechanism(file)
    asked = {"modes": 4, "prestress": "axial"}

    def frequencies(mass: float) -> np.ndarray:
        changed = replace(mechanism, frame=replace(mechanism.frame, mass=mass))
        engine = flexmech.ReferenceEngine(changed, 2, component_modes=False)
        return flexmech.natural_frequencies(engine, ANGLES[:1], 20.0, **asked)

    slope = flexmech.frequency_derivatives(
        flexmech.ReferenceEngine(mechanism, 2), ["frame.mass"], ANGLES[:1], 20.0, **asked
    )[0]
    change = (frequencies(2.001) - frequencies(1.999)) / 0.002
    assert slope == pytest.approx(change, rel=1e-4)


@pytest.mark.thorough
def test_parts_on_a_heavy_frame_bear_what_they_bear_on_the_ground(
    aluminium: flexmech.Mechanism,
) -> None:
    request = flexmech.analyses.StrengthRequest(
        20.0, source="transient", revolutions=0.1, search_speed=False
    )
    heavy = on_springs(aluminium, sprung((1e6, 1e6), mass=1e9, inertia=1e9))
    found, wanted = (
        flexmech.strength(flexmech.ReferenceEngine(each, 2), request).dataset["margin_load_factor"]
        for each in (heavy, aluminium)
    )
    assert found.values == pytest.approx(wanted.values, rel=1e-6)


@pytest.mark.thorough
def test_what_rings_after_a_stop_rings_with_the_frame(models: Path, tmp_path: Path) -> None:
    """Amplitudes fitted to the rest of a run, and those by the state at the stop alone."""
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    mechanism = replace(flexmech.load_mechanism(file), gravity=(0.0, -9.81))
    mechanism = replace(mechanism, frame=mechanism.frame.undamped)
    law = flexmech.LawDrive("cycloid", np.radians(120), 0.15, dwell=0.4, start_angle=0.3)
    shaping, engine = flexmech.Shaping("zv", modes=(1,)), flexmech.ReferenceEngine(mechanism, 2)
    request = flexmech.analyses.ResponseRequest(
        law, samples=120, step=2e-4, modes=5, shaping=shaping
    )
    data = flexmech.response(engine, request).dataset
    run, state = data["modal_amplitude"][0], amplitudes_after_stop(engine, law, 5)
    np.testing.assert_allclose(state, run.values, rtol=0, atol=1e-2 * float(run.max()))
    # The lowest mode is that of the frame: nearly all of it is left out.
    shaped = data["shaped_modal_amplitude"][0]
    assert float(shaped.sel(mode=1).max()) < 0.6 * float(run.sel(mode=1).max())


def test_a_record_of_exudyns_frame_gives_its_damping_back(aluminium: flexmech.Mechanism) -> None:
    mechanism = on_springs(aluminium, sprung((2e4, 4e4)))
    sections = {k: one.with_damping_time(2e-4) for k, one in aluminium.sections.items()}
    engine = flexmech.ExudynEngine(replace(mechanism, sections=sections), 2)
    asked = {"samples": 360, "start": "rigid", "modes": 4, "step": 4e-4}
    data = flexmech.response(engine, flexmech.analyses.ResponseRequest(20.0, 2.0, **asked)).dataset
    bent = data["deflection"].isel(engine=0).sel(link="coupler").values
    column = flexmech.MeasuredQuantity("coupler:deflection", "m", bent)
    record = flexmech.MeasuredRecord("time", data["time"].values, (column,))
    engine = flexmech.ReferenceEngine(mechanism, 2)
    found = flexmech.compare_with_record(engine, record, 20.0, fit=("damping",))
    assert found.fitted("damping").value == pytest.approx(2e-4, rel=2e-2)


PUSH = flexmech.Load("push", AttachmentPoint("rocker", 0.15), ((3.0, 2.0),), (0.1,))


def test_a_load_softens_a_frame_that_rocks_as_weight_does(aluminium: flexmech.Mechanism) -> None:
    """A force F at the arm r from the centre adds r F to the stiffness against rocking."""
    centre = (0.127, -0.02)
    springs = tuple(flexmech.FrameSpring((x, -0.02), (1e9, 5e3)) for x in (0.027, 0.227))
    frame = flexmech.SprungFrame(1e4, 3e3, centre, springs)
    mechanism = on_springs(stiffened(aluminium, 1e6), frame)
    squares = []
    for loads in ((), (PUSH,)):
        engine = flexmech.ReferenceEngine(replace(mechanism, loads=loads), 2, "euler")
        modes = flexmech.natural_frequencies(engine, ANGLES[:1], modes=1, prestress="none")
        squares.append((2 * np.pi * modes[0, 0]) ** 2)
    arm = aluminium.linkage.motion(ANGLES[:1]).position(2, 0.15)[0] - centre
    change = (squares[1] - squares[0]) * frame.inertia
    assert change == pytest.approx(float(arm @ PUSH.force[0]), rel=1e-3)


@pytest.mark.thorough
def test_a_spring_between_link_and_frame_pulls_alike_in_both_engines(
    models: Path, tmp_path: Path
) -> None:
    """Its end on the ground is on the frame, which it moves with the link."""
    ends = AttachmentPoint(GROUND, 0.3, 0.1), AttachmentPoint("rocker", 0.15)
    spring = flexmech.Spring("return", *ends, stiffness=40.0, free_length=0.1, damping=1.0)
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    mechanism = replace(flexmech.load_mechanism(file), springs=(spring,))
    engines = [kind(mechanism, 2) for kind in (flexmech.ReferenceEngine, flexmech.ExudynEngine)]
    asked = {"samples": 90, "modes": 4, "step": 4e-4, "start": "equilibrium"}
    data = flexmech.response(engines, flexmech.analyses.ResponseRequest(20.0, 0.5, **asked)).dataset
    for name, near in (("floor_force", 2e-3), ("frame_displacement", 2e-3)):
        linear, finite = data[name].values
        assert np.abs(linear - finite).max() < near * np.abs(finite).max()
    assert float(data["energy_error"].max()) < 2e-4


def test_a_load_reaches_the_floor(models: Path, tmp_path: Path) -> None:
    """Over a turn of the periodic motion the floor bears load and weight, and nothing else."""
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    mechanism = replace(flexmech.load_mechanism(file), loads=(PUSH,), gravity=(0.0, -9.81))
    data = run(mechanism, start="periodic", step=1e-3, samples=180)
    floor = data["floor_force"].isel(time=slice(0, -1)).mean("time").values
    weight = 9.81 * (mechanism.frame.mass + total_mass(mechanism))
    assert floor == pytest.approx(np.array(PUSH.force[0]) - [0.0, weight], abs=2e-3 * weight)


def test_a_moving_frame_carries_velocities_and_accelerations(
    aluminium: flexmech.Mechanism,
) -> None:
    """Central differences of positions as the frame moves along a known path."""
    drive, step = flexmech.ConstantSpeed(20.0, run_up_time=0.2), 1e-5
    time = 0.1 + step * np.arange(-1.0, 2.0)
    rates = np.array([3.0, 5.0, 7.0])
    place = 0.01 * np.sin(np.outer(time, rates))
    rate = 0.01 * rates * np.cos(np.outer(time, rates))
    change = -0.01 * rates**2 * np.sin(np.outer(time, rates))
    motion = drive.motion(aluminium.linkage, time)
    moved = carried_motion((0.127, -0.02), motion, place, rate, change)
    speed = (moved.origin[2] - moved.origin[0]) / (2 * step)
    assert moved.origin_velocity[1] == pytest.approx(speed, abs=1e-6)
    gain = (moved.origin_velocity[2] - moved.origin_velocity[0]) / (2 * step)
    assert moved.origin_acceleration[1] == pytest.approx(gain, abs=1e-5)
    spin = (moved.angle[2] - moved.angle[0]) / (2 * step)
    assert moved.angular_velocity[1] == pytest.approx(spin, abs=1e-6)


def test_a_frame_is_written_and_read_as_it_was(models: Path, tmp_path: Path) -> None:
    mechanism = flexmech.load_mechanism(framed_file(tmp_path, models / "aluminium_fourbar.toml"))
    assert mechanism.frame == flexmech.SprungFrame(
        2.0,
        0.03,
        (0.127, -0.02),
        tuple(flexmech.FrameSpring((x, -0.06), (2e4, 4e4), (5.0, 5.0)) for x in (0.0, 0.254)),
    )
    again = tmp_path / "again.toml"
    again.write_text(mechanism.to_toml(), encoding="utf-8")
    assert flexmech.load_mechanism(again) == mechanism


def test_a_frame_alone_has_the_frequencies_of_its_springs() -> None:
    squares = (2 * np.pi * sprung((2e4, 4e4)).natural_frequencies) ** 2
    assert squares == pytest.approx(sorted([4e4 / 2.0, 8e4 / 2.0, 2 * 4e4 * 0.1**2 / 0.03]))


def test_linear_equations_of_a_frame_that_turns_are_off_by_its_rotation_in_rad(
    aluminium: flexmech.Mechanism,
) -> None:
    """Beside Exudyn, in which it turns by any angle; a frame that turns far is refused."""
    heavy = replace(aluminium, gravity=(0.0, -9.81))
    request = flexmech.analyses.ResponseRequest(
        19.9, revolutions=1.0, samples=90, modes=1, step=4e-4, start="rigid"
    )
    kinds = (flexmech.ReferenceEngine, flexmech.ExudynEngine)
    springs = tuple(flexmech.FrameSpring((x, -0.06), (400.0, 800.0)) for x in (0.0, 0.254))
    frame = flexmech.SprungFrame(2.0, 0.03, (0.127, -0.02), springs)
    run = flexmech.response([kind(on_springs(heavy, frame), 1) for kind in kinds], request)
    data = run.dataset
    turned = float(data["peak_frame_rotation"][0])
    assert 0.05 < turned < 0.5
    assert data["rotation_error_of_peak_frame"].values.tolist() == pytest.approx([turned, 0.0])
    gaps = run.force_agreement()
    assert gaps is not None
    away = abs(data["frame_rotation"][0] - data["frame_rotation"][1]).max()
    off = float(away / abs(data["frame_rotation"][1]).max())
    assert float(gaps["frame_rotation"]) == pytest.approx(off)
    assert 0.05 * turned < off < 2 * turned
    peak = next(one for one in run.summary().numbers if one.name == "peak_frame_rotation")
    assert abs(np.radians(peak.value) - turned) <= np.radians(peak.error) + 1e-12
    assert any("hold for small rotations" in line for line in run.summary().warnings)
    loose = tuple(replace(spring, stiffness=(60.0, 120.0)) for spring in springs)
    soft = on_springs(heavy, replace(frame, inertia=0.01, springs=loose))
    with pytest.raises(flexmech.ComputationError, match="exudyn engine"):
        flexmech.response(flexmech.ReferenceEngine(soft, 1), replace(request, revolutions=2.0))


def geared_motor(inertia: float = 1e-4, **coupling: float) -> flexmech.MotorDrive:
    curve = (0.0, 200.0), (0.6, 0.0)
    motor = flexmech.TorqueMotor(*curve, inertia=inertia, gear_ratio=5.0, **coupling)
    return flexmech.MotorDrive(motor)


COUPLINGS = [{}, {"coupling_stiffness": 500.0, "coupling_damping": 0.5}]


def by_both(
    mechanism: flexmech.Mechanism,
    speed: float | flexmech.MotorDrive,
    elements: int = 2,
    shaft: str = "free",
    kinds: Sequence[Any] = (flexmech.ReferenceEngine, flexmech.ExudynEngine),
    **asked: Any,
) -> Any:
    engines = [kind(mechanism, elements, shaft=shaft) for kind in kinds]
    settings = {"revolutions": 0.2, "samples": 90, "start": "equilibrium", "modes": 3}
    request = flexmech.analyses.ResponseRequest(speed, **settings | {"step": 2e-4} | asked)
    return flexmech.response(engines, request).dataset


def off(data: Any, wanted: Any, name: str) -> float:
    """Greatest difference of a quantity over its greatest size."""
    return float(abs(data[name].values - wanted[name].values).max() / abs(wanted[name]).max())


@pytest.fixture
def heavy(aluminium: flexmech.Mechanism) -> flexmech.Mechanism:
    sections = {k: one.with_damping_time(2e-4) for k, one in aluminium.sections.items()}
    return replace(aluminium, sections=sections, gravity=(0.0, -9.81), shaft_inertia=2e-3)


@pytest.mark.parametrize("coupling", COUPLINGS, ids=["rigid", "coupled"])
def test_the_work_of_a_motor_is_the_energy_with_that_of_its_frame(
    heavy: flexmech.Mechanism, coupling: dict[str, float]
) -> None:
    """The frame bears the reactions of stator, gear and rotor; both engines move it alike."""
    mechanism = on_springs(heavy, sprung((1e5, 2e5)))
    drive = geared_motor(**coupling)
    data = by_both(mechanism, drive, 4, step=1e-4, start="rigid", revolutions=0.1)
    linear, finite = data["energy_error"].values
    assert linear < 1e-5
    assert finite < 3e-6
    one, other = (data.isel(engine=number) for number in (0, 1))
    for name in ("frame_displacement", "floor_force", "driving_torque"):
        assert off(one, other, name) < 5e-3


def test_a_free_shaft_on_a_frame_is_turned_alike_in_both_engines(
    heavy: flexmech.Mechanism,
) -> None:
    """The torque that drives the rigid linkage turns the frame the other way."""
    data = by_both(on_springs(heavy, sprung((2e4, 4e4))), 20.0)
    assert float(data["energy_error"].isel(engine=1)) < 5e-6
    one, other = (data.isel(engine=number) for number in (0, 1))
    for name in ("frame_displacement", "frame_rotation", "floor_force"):
        assert off(one, other, name) < 1e-2


@pytest.mark.parametrize("driven", ["motor", "free", "periodic"])
def test_stiff_springs_of_a_frame_are_the_ground(heavy: flexmech.Mechanism, driven: str) -> None:
    asked: dict[str, Any] = {"speed": geared_motor() if driven == "motor" else 20.0}
    if driven == "periodic":
        asked |= {"start": "periodic", "shaft": "prescribed"}
    stiff = on_springs(heavy, sprung((1e9, 1e9)))
    data, wanted = (by_both(one, revolutions=0.1, **asked) for one in (stiff, heavy))
    for name in ("deflection", "driving_torque"):
        assert off(data, wanted, name) < 2e-5


def test_the_common_centre_of_mass_stays_where_no_spring_holds_it(
    aluminium: flexmech.Mechanism,
) -> None:
    """From rest a motor moves links and frame against each other along x."""
    springs = tuple(flexmech.FrameSpring((x, -0.02), (1e-3, 1e5)) for x in (0.027, 0.227))
    frame = flexmech.SprungFrame(2.0, 100.0, (0.127, -0.02), springs)
    mechanism = on_springs(stiffened(aluminium, 30.0), frame)
    data = by_both(mechanism, geared_motor(), start="rigid")
    whole = frame.mass + total_mass(mechanism)
    for engine in (0, 1):
        run_of = data.isel(engine=engine)
        angle = data["crank_angle"].values + run_of["shaft_rotation"].values
        motion = mechanism.linkage.motion(angle)
        moment = whole * run_of["frame_displacement"].values[:, 0]
        greatest = float(np.abs(moment).max())
        for number, link in enumerate(mechanism.link_masses_in_order):
            mass = float(link.moment(0))
            place = motion.position(number, float(link.moment(1)) / mass)[:, 0]
            moment = moment + mass * (place - place[0])
        assert np.abs(moment).max() < 5e-3 * greatest


@pytest.mark.parametrize("coupling", COUPLINGS, ids=["rigid", "coupled"])
def test_a_rotor_behind_a_gear_turns_its_frame_back(
    models: Path, coupling: dict[str, float]
) -> None:
    """Angular momentum (I_f + I + J) phi' + (I + n J) theta' is what the springs gave."""
    arm = stiffened(flexmech.load_mechanism(models / "rotating_arm.toml"), 10.0)
    arm = replace(arm, gravity=(0.0, 0.0), linkage=replace(arm.linkage, hub_radius=0.0))
    springs = tuple(flexmech.FrameSpring((x, 0.0), (1e5, 1e5)) for x in (-0.05, 0.05))
    frame = flexmech.SprungFrame(2.0, 0.5, (0.0, 0.0), springs)
    rotor, drive = 4e-3, geared_motor(inertia=4e-3, **coupling)
    asked = {"start": "rigid", "revolutions": 0.1, "modes": 1, "samples": 500}
    data = by_both(on_springs(arm, frame), drive, **asked)
    time, inertia = data["time"].values, float(arm.link_masses_in_order[0].moment(2))
    for engine in (0, 1):
        run_of = data.isel(engine=engine)
        turned = run_of["frame_rotation"].values
        crank = data["crank_angle"].values + run_of["shaft_rotation"].values
        once = cumulative_simpson(turned, x=time, initial=0)
        given = 2 * 1e5 * 0.05**2 * cumulative_simpson(once, x=time, initial=0)[-1]
        own = (frame.inertia + inertia + rotor) * turned[-1]
        assert own + given == pytest.approx(-(inertia + 5 * rotor) * (crank[-1] - crank[0]), 1e-3)


@pytest.mark.parametrize(
    ("kind", "near"), [(flexmech.ReferenceEngine, 1e-2), (flexmech.ExudynEngine, 3e-5)]
)
def test_a_run_from_the_periodic_motion_on_a_frame_ends_as_it_begins(
    heavy: flexmech.Mechanism, kind: Any, near: float
) -> None:
    """The reference leaves out the square of the frame's rotation; Exudyn takes any rotation."""
    springs = tuple(flexmech.FrameSpring((x, -0.08), (2e3, 4e3), (30.0, 30.0)) for x in (0, 0.25))
    mechanism = on_springs(heavy, flexmech.SprungFrame(2.0, 0.03, (0.127, -0.02), springs))
    asked = {"start": "periodic", "revolutions": 1.0, "shaft": "prescribed", "kinds": [kind]}
    data = by_both(mechanism, 20.0, step=2 * np.pi / 20.0 / 1440, **asked).isel(engine=0)
    assert float(data["peak_frame_rotation"]) > 0.01
    for name in ("deflection", "frame_displacement", "frame_rotation"):
        values = data[name].transpose("time", ...).values
        assert np.abs(values[-1] - values[0]).max() < near * np.abs(values).max()


def test_links_on_a_tilted_frame_have_the_stress_of_tilted_weight(
    heavy: flexmech.Mechanism,
) -> None:
    """On a frame of 1 t that hangs askew, at 0.075 rad, as on the ground under tilted weight.

    With the tension inside elements by the frame as it is drawn 3e-5 of the stiffness is off.
    """
    weighty, stiff = replace(heavy, gravity=(0.0, -200.0)), 200.0 * 1e3 / 0.6
    springs = tuple(flexmech.FrameSpring((0.127 + x, -0.02), (stiff, k * stiff)) for x, k in SKEW)
    frame = flexmech.SprungFrame(1e3, 1e2, (0.127, -0.02), springs)
    orbit, engine = of_slow_turn(replace(weighty, frame=frame))
    moved = orbit.frame_motion(ANGLES)
    assert moved is not None
    tilt = float(moved.displacement[:, 2].mean())
    assert tilt == pytest.approx(0.0749, abs=1e-4)
    assert moved.displacement[:, 2] == pytest.approx(tilt, abs=2e-6)
    gravity = (-200.0 * np.sin(tilt), -200.0 * np.cos(tilt))
    still, on_ground = of_slow_turn(replace(weighty, gravity=gravity))
    turns = slice(2, None, 3)
    for tilted, wanted in zip(
        orbit.stressed_links(engine, ANGLES).tangent,
        still.stressed_links(on_ground, ANGLES).tangent,
        strict=True,
    ):
        gap = np.linalg.norm((tilted - wanted)[:, turns, turns])
        assert gap < 1e-6 * np.linalg.norm(wanted[:, turns, turns])


SKEW = ((-1.0, 1.0), (1.0, 2.0))


def of_slow_turn(mechanism: flexmech.Mechanism) -> tuple[NonlinearOrbit, flexmech.ReferenceEngine]:
    engine = flexmech.ReferenceEngine(mechanism, 2)
    return nonlinear_orbit(engine, 3.0), engine


def test_the_periodic_motion_of_stiff_links_on_a_frame_is_that_of_linear_equations(
    heavy: flexmech.Mechanism,
) -> None:
    mechanism = on_springs(stiffened(heavy, 30.0), sprung((1e5, 2e5)))
    asked = {"start": "periodic", "shaft": "prescribed", "step": 1e-4, "revolutions": 0.1}
    nonlinear, linear = (
        by_both(mechanism, 20.0, prestress=level, **asked, kinds=[flexmech.ReferenceEngine])
        for level in ("equilibrium", "none")
    )
    for name in ("deflection", "frame_displacement", "frame_rotation"):
        assert off(nonlinear, linear, name) < 2e-3


def test_exudyn_closes_the_hub_and_sprung_joints_on_a_frame(
    heavy: flexmech.Mechanism, models: Path
) -> None:
    """As the reference does: linear equations are off by the rotation of the frame."""
    bearings = (
        flexmech.JointSpring("O4", 2.0, 0.01, 1.0, radial_stiffness=1e5, radial_damping=20.0),
        flexmech.JointSpring("B", 0.5, 0.01, radial_stiffness=1e5, radial_damping=20.0),
    )
    sprung_joints = replace(on_springs(heavy, sprung((2e4, 4e4))), joint_springs=bearings)
    springs = tuple(flexmech.FrameSpring((x, -0.05), (2e4, 2e4), (3.0, 3.0)) for x in (-0.1, 0.1))
    arm = flexmech.load_mechanism(models / "rotating_arm.toml")
    assert arm.linkage.hub_radius
    arm = on_springs(arm, flexmech.SprungFrame(1.5, 0.03, (0.0, -0.02), springs))
    for mechanism in (sprung_joints, arm):
        data = by_both(mechanism, 20.0, shaft="prescribed")
        one, other = (data.isel(engine=number) for number in (0, 1))
        for name in ("frame_displacement", "frame_rotation", "floor_force", "driving_torque"):
            assert off(one, other, name) < 2e-2
