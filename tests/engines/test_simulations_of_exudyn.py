"""Exudyn's simulation of the running linkage, against what is known of it in closed form."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    BeamSection,
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    InputError,
    Load,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    Spring,
    response,
)
from flexmech.analyses import ResponseRequest, deflections
from flexmech.mechanics.running import LinkState
from flexmech.solvers import nonlinear_orbit
from tests.support.mechanisms import at, case, eccentric_arm, fixed, strip

ELEMENTS = pytest.mark.parametrize("element", ["ancf", "geometrically-exact"])
INTEGRATORS = pytest.mark.parametrize("integrator", ["trapezoidal", "generalized-alpha"])


def simulate(engine: Any, drive: Any, time: Any, step: float, start: Any = None, **asked: Any):
    return engine.simulate(drive, start or LinkState.rigid(engine.links), time, step, **asked)


def stiffened(mechanism: Mechanism, factor: float) -> Mechanism:
    """Sections so stiff that links hardly bend; their mass as before."""
    kinds = ("axial_stiffness", "bending_stiffness", "shear_stiffness")
    sections = {
        name: replace(one, **{kind: factor * getattr(one, kind) for kind in kinds})
        for name, one in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


@INTEGRATORS
@ELEMENTS
def test_energy_is_balanced(element: str, integrator: Any) -> None:
    """With weight, masses and damping; the elements' strains are this package's own."""
    engine = ExudynEngine(case("of all kinds").mechanism, 3, element)
    run = simulate(
        engine,
        ConstantSpeed(10.0, start_angle=0.5),
        np.linspace(0.0, 0.1, 41),
        2e-4,
        integrator=integrator,
    )
    energy = run.energy
    assert run.energy_error < 2e-5
    assert energy.dissipated[-1] > 10 * run.energy_error * energy.kinetic.max()
    assert np.ptp(energy.gravity) > 0.1 * energy.kinetic.max()


END = at("arm", 0.3)
ACTING: dict[str, dict[str, Any]] = {
    "couple": {"loads": (Load("couple", END, torque=(0.3,)),)},
    "spring": {"springs": (Spring("return", END, fixed(0.1, 0.35), 300.0, 0.4, 5.0),)},
    "load over the crank angle": {
        "loads": (
            Load(
                "push",
                END,
                ((0.0, 0.0), (1.0, 2.0), (-2.0, 1.0), (0.0, 0.0)),
                (0.0,) * 4,
                over="crank_angle",
                at=(0.0, 0.6, 1.2, 1.8),
            ),
        )
    },
    "body": {"bodies": (AttachedBody("arm", 0.2, 0.05, 1e-5, (0.01, -0.03)),)},
}


@ELEMENTS
@pytest.mark.parametrize("name", ACTING)
def test_work_on_a_soft_arm_that_bends_far_is_in_the_energies(name: str, element: str) -> None:
    """A torque's work on the rigid arm alone misses the energies by 0.13 of their peak."""
    mechanism = Mechanism(RotatingArm(0.3), {"arm": strip(2e-3)}, **ACTING[name])
    drive, time = ConstantSpeed(20.0, run_up_time=0.05), np.linspace(0.0, 0.1, 21)
    assert simulate(ExudynEngine(mechanism, 4, element), drive, time, 1e-4).energy_error < 2e-3


@pytest.mark.parametrize("offset", [(0.0, 0.02), (0.01, -0.03)])
def test_a_body_on_an_eccentric_arm_keeps_its_energy(offset: tuple[float, float]) -> None:
    """It counts from the pins' axis, its matrices in Exudyn from the node."""
    body = AttachedBody("arm", 0.2, 0.05, 1e-5, offset)
    engine = ExudynEngine(eccentric_arm(1e-3, 0.0, bodies=(body,)), 2, "geometrically-exact")
    drive, time = ConstantSpeed(8.0, run_up_time=0.05), np.linspace(0.0, 0.1, 21)
    assert simulate(engine, drive, time, 1e-4).energy_error < 1e-4


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["L-arm with bodies", "rigid ternary coupler", "moving guide"])
def test_a_run_keeps_its_energy_and_its_joints(name: str) -> None:
    engine, drive = ExudynEngine(case(name).mechanism, 3), ConstantSpeed(20.0)
    data = response(
        engine, ResponseRequest(drive, 0.03, samples=400, step=4e-5, start="rigid")
    ).dataset
    assert float(data["energy_error"].item()) < 1e-6
    assert float(data["constraint_drift"].item()) < 1e-5
    assert float(np.abs(data["deflection"]).max()) > 1e-5


@INTEGRATORS
@pytest.mark.parametrize("name", ["of all kinds", "three links on a pin", "arm on a hub"])
def test_stiff_links_have_the_forces_of_rigid_ones(name: str, integrator: Any) -> None:
    known = "arm on a hub with free shaft" if name == "arm on a hub" else name
    mechanism = replace(stiffened(case(known).mechanism, 300.0), gravity=(0.0, 0.0))
    engine = ExudynEngine(mechanism, 3, "geometrically-exact")
    drive = ConstantSpeed(-8.0, run_up_time=0.4, start_angle=1.0)
    time = np.linspace(0.0, 0.5, 41)
    run = simulate(engine, drive, time, time[-1] / 800, integrator=integrator)
    motion = drive.motion(mechanism.linkage, time)
    rigid, names = mechanism.inverse_dynamics(motion), mechanism.linkage.topology.joint_names
    forces = np.stack([rigid.joint_force[joint] for joint in names], axis=1)
    size = np.abs(forces).max()
    np.testing.assert_allclose(run.joint_force, forces, rtol=0, atol=1e-3 * size)
    size = np.abs(rigid.driving_torque).max()
    np.testing.assert_allclose(run.driving_torque, rigid.driving_torque, atol=1e-3 * size)


UNIT = BeamSection(
    axial_stiffness=4e3,
    bending_stiffness=2.0,
    shear_stiffness=1e3,
    mass_per_length=1.0,
    rotary_inertia=1e-6,
    in_plane_thickness=0.01,
)


@INTEGRATORS
def test_a_clamped_arm_swings_by_the_beam_formula(integrator: Any) -> None:
    """Let go from its bow under a force at the tip: 3.5160 sqrt(EI / (m L^4)) above all."""
    mechanism = Mechanism(RotatingArm(1.0), {"arm": UNIT})
    engine, still = ExudynEngine(mechanism, 4, "ancf"), ConstantSpeed(1e-4)
    start = LinkState.rigid(engine.links)
    x = np.linspace(0.0, 1.0, 5)
    beta, sigma = 1.8751040687, 0.7340955137
    mode = np.cosh(beta * x) - np.cos(beta * x) - sigma * (np.sinh(beta * x) - np.sin(beta * x))
    slope = np.sinh(beta * x) + np.sin(beta * x) - sigma * (np.cosh(beta * x) - np.cos(beta * x))
    size = 1e-5 / mode[-1]
    start.displacement[0][1::4], start.displacement[0][3::4] = size * mode, size * beta * slope
    start = replace(start, rate=[0 * rate for rate in start.rate])
    frequency = beta**2 * np.sqrt(2.0)
    period = 2 * np.pi / frequency
    time = np.linspace(0.0, 2 * period, 33)
    run = simulate(engine, still, time, period / 400, start, integrator=integrator)
    tip = run.displacement[0][:, engine.links[0].end[1]]
    np.testing.assert_allclose(tip, 1e-5 * np.cos(frequency * time), rtol=0, atol=2e-8)


@INTEGRATORS
def test_runs_are_of_second_order_in_the_step(integrator: Any) -> None:
    engine = ExudynEngine(case("aluminium four-bar").mechanism, 2)
    drive, time = ConstantSpeed(20.0, run_up_time=0.1), np.linspace(0.0, 0.1, 41)
    coarse, fine, finest = (
        deflections(
            engine, simulate(engine, drive, time, step, integrator=integrator).displacement
        )[:, 1]
        for step in (4e-4, 2e-4, 1e-4)
    )
    ratio = np.linalg.norm(coarse - fine) / np.linalg.norm(fine - finest)
    assert ratio == pytest.approx(4.0, abs=0.4)


@INTEGRATORS
def test_forces_at_time_zero_are_those_that_follow(integrator: Any) -> None:
    engine, step = ExudynEngine(case("of all kinds").mechanism, 4), 1e-9
    start = LinkState.rigid(engine.links)
    start.displacement[1][1::4] = 1e-3 * np.sin(np.pi * np.linspace(0, 1, 5))
    time = step * np.arange(3.0)
    run = simulate(engine, ConstantSpeed(20.0), time, step, start, integrator=integrator)
    scale = np.abs(run.joint_force).max()
    assert np.abs(run.joint_force[0] - run.joint_force[1]).max() < 1e-2 * scale
    assert run.driving_torque[0] == pytest.approx(run.driving_torque[1], rel=1e-2)


def at_stations(engine: Any, displacement: list[np.ndarray]) -> np.ndarray:
    """Displacements of all links at their stations, (time, ...)."""
    pairs = zip(engine.links, displacement, strict=True)
    return np.concatenate(
        [np.einsum("scn,bn->bsc", one.shape, q).reshape(len(q), -1) for one, q in pairs], axis=1
    )


def apart(first: np.ndarray, second: np.ndarray) -> float:
    return float(np.abs(second - first).max() / np.abs(first).max())


@pytest.mark.parametrize(
    ("name", "speed"),
    [
        ("aluminium four-bar", 20.0),
        ("rigid coupler", 12.0),
        ("spring and damper", 15.0),
        ("sprung joints of a rigid rocker", 20.0),
    ],
)
def test_a_simulation_stays_on_the_periodic_motion(name: str, speed: float) -> None:
    """Found by Newton's method for Fourier series, a tenth of the displacement off equilibrium."""
    engine, drive = ExudynEngine(case(name).mechanism, 3), ConstantSpeed(speed)
    orbit = nonlinear_orbit(engine, speed)
    assert orbit.residual < 1e-9
    time = drive.revolution_time / 96 * np.arange(25)
    exact = at_stations(engine, orbit.at(drive.crank_angle(time))[0])
    gaps = [
        apart(
            exact,
            at_stations(
                engine,
                simulate(
                    engine, drive, time, drive.revolution_time / n, orbit.state(0.0)
                ).displacement,
            ),
        )
        for n in (1440, 2880)
    ]
    assert gaps[1] < 3e-3
    assert gaps[1] < 0.4 * gaps[0]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "speed", "damping", "near"),
    [("aluminium four-bar", 20.0, 0.0, 2e-3), ("steel four-bar", 100.0, 1e-4, 1e-2)],
)
def test_periodic_motions_of_both_engines_are_one(
    name: str, speed: float, damping: float, near: float
) -> None:
    mechanism = case(name).mechanism
    sections = {key: one.with_damping_time(damping) for key, one in mechanism.sections.items()}
    mechanism = replace(mechanism, sections=sections) if damping else mechanism
    curves = []
    for engine in (ReferenceEngine(mechanism), ExudynEngine(mechanism)):
        orbit = nonlinear_orbit(engine, speed)
        assert orbit.residual < 1e-9
        curves.append(at_stations(engine, orbit.at(np.radians(range(0, 360, 3)))[0]))
    assert apart(*curves) < near


@pytest.mark.parametrize(
    ("time", "step", "asked", "words"),
    [
        ([0.1, 0.05], 1e-3, {}, "time"),
        ([0.0, 0.1], 0.0, {}, "step"),
        ([0.0, 0.1], 1e-3, {"integrator": "euler"}, "integrator"),
    ],
)
def test_what_cannot_be_simulated_is_refused(
    time: Any, step: float, asked: Any, words: str
) -> None:
    engine = ExudynEngine(case("aluminium four-bar").mechanism, 2)
    with pytest.raises(InputError, match=words):
        simulate(engine, ConstantSpeed(20.0), np.array(time), step, **asked)


def test_a_step_that_does_not_converge_is_named_with_its_time_and_crank_angle() -> None:
    engine = ExudynEngine(case("aluminium four-bar").mechanism, 2)
    with pytest.raises(ComputationError, match=r"0\.01 s, crank angle .* deg: .*smaller"):
        simulate(engine, ConstantSpeed(3000.0), np.array([0.0, 1.0]), 0.01)


def test_a_start_that_tears_a_pin_is_refused() -> None:
    engine = ExudynEngine(case("aluminium four-bar").mechanism, 2)
    start = LinkState.rigid(engine.links)
    start.displacement[1][1] = 1e-3
    with pytest.raises(InputError, match=r"joint holds by 0\.001 m"):
        simulate(engine, ConstantSpeed(20.0), np.array([0.0, 0.1]), 1e-3, start)
