"""Welds, sliders and rigid links in Exudyn, held against Exudyn itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech import BeamSection, ConstantSpeed, ExudynEngine, FourBar, Material, Mechanism
from flexmech.linear_system import DeadMoments, inertia_loads
from flexmech.linkages import Linkage, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import AttachedBody
from flexmech.multibody.linearize import internal_forces, running_tangents, static_equilibrium
from flexmech.multibody.static_model import StaticModel
from flexmech.multibody.straight_links import link_models
from flexmech.time_domain import LinkState
from tests.cross_engine.joined_linkages import LArm, QuickReturn, SliderCrank, Ternary, Ties

FloatArray = NDArray[np.float64]
FOUR_BAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
ELASTIC: dict[str, Linkage] = {
    "L-arm": LArm(),
    "ternary coupler": Ternary(FOUR_BAR),
    "slider-crank": SliderCrank(),
    "slider-crank uphill": SliderCrank(line=0.4),
}
RIGID: dict[str, Linkage] = {
    "rigid arm": LArm(rigid=("arm",)),
    "rigid leg": LArm(rigid=("leg",)),
    "rigid crank": SliderCrank(rigid=("crank",)),
    "rigid connecting rod": SliderCrank(rigid=("coupler",)),
    "rigid rocker": Ternary(FOUR_BAR, rigid=("rocker",)),
    "rigid coupler": Ternary(FOUR_BAR, rigid=("coupler",)),
    "rigid ternary coupler": Ternary(FOUR_BAR, rigid=("coupler", "beyond")),
    "rigid guide": QuickReturn(),
}
LINKAGES = ELASTIC | RIGID
KINDS = ("ancf", "geometrically-exact")


BODIES: dict[str, tuple[AttachedBody, ...]] = {
    "L-arm": (
        AttachedBody("leg", 0.2, 0.02, 3e-6, (0.01, 0.015)),
        AttachedBody("arm", 0.1, 0.03, 5e-6, (-0.02, 0.01)),
    ),
    "slider-crank": (
        AttachedBody("coupler", 0.3, 0.05, 2e-5, (0.01, -0.004)),
        AttachedBody("crank", 0.0, 0.2, 1e-5, (-0.03, 0.0)),
        AttachedBody("coupler", 0.11, 0.01, 0.0, (0.0, 0.02)),
    ),
    "rigid crank": (AttachedBody("crank", 0.0, 0.2, 1e-5, (-0.03, 0.0)),),
    "rigid connecting rod": (AttachedBody("coupler", 0.3, 0.05, 2e-5, (0.01, -0.004)),),
}


def strips(name: str, thickness: float = 2e-3, bodies: bool = False) -> Mechanism:
    """Aluminium strips under their weight."""
    linkage = LINKAGES[name]
    section = BeamSection.rectangle(Material(68.9e9, 2923.0), thickness, 25.4e-3)
    sections = dict.fromkeys(linkage.topology.link_names, section)
    attached = BODIES[name] if bodies else ()
    return Mechanism(linkage, sections, gravity=(0.0, -9.81), bodies=attached)


CASES = pytest.mark.parametrize(
    ("name", "bodies"), [*((name, False) for name in LINKAGES), *((name, True) for name in BODIES)]
)


class Static:
    """Equilibria of one position under the inertia forces and further ones."""

    def __init__(self, mechanism: Mechanism, kind: str, angle: float, speed: float) -> None:
        self.topology = mechanism.linkage.topology
        self.model = StaticModel(mechanism, 4, kind)
        self.links = link_models(self.model)
        self.motion: RigidMotion = mechanism.linkage.motion(np.array([angle]), speed)
        self.loads = inertia_loads(self.links, self.motion, mechanism.gravity)

    def equilibrium(self, further: Sequence[FloatArray] | None = None) -> Any:
        loads = [load.copy() for load in self.loads]
        for load, more in zip(loads, further or [], strict=bool(further)):
            load += more
        gravity = self.model.assembly.mechanism.gravity
        dead = DeadMoments.of(self.links, self.motion, gravity, loads)
        return static_equilibrium(self.model, self.motion, loads, dead)

    def displacement(self, further: Sequence[FloatArray]) -> FloatArray:
        return np.concatenate([q[0] for q in self.equilibrium(further).displacement])


@CASES
@pytest.mark.parametrize("kind", KINDS)
def test_the_tangent_tells_how_the_equilibrium_moves(name: str, bodies: bool, kind: str) -> None:
    """Small forces on nodes move it by the inverse tangent, whatever forces the joints carry."""
    case = Static(strips(name, bodies=bodies), kind, np.radians(40.0), 20.0)
    found = case.equilibrium()
    ties = Ties(case.topology, case.motion, case.links, found.displacement)
    stiffness = scipy.linalg.block_diag(*(k[0] for k in found.tangent))
    stiffness += ties.line_stiffness(found.line_force[0])
    basis = ties.basis
    stiffness = basis.T @ stiffness @ basis
    # Joints keep what they join: places, and angles of welds, also where links bend far.
    assert np.abs(ties.gaps).max() < 1e-13
    random = np.random.default_rng(1)
    for _ in range(3):
        forces = [np.zeros_like(load) for load in case.loads]
        for link, force in zip(case.links, forces, strict=True):
            at = np.flatnonzero(link.fields.along + link.fields.across)
            force[0, at] = random.normal(size=len(at))
        step = 2e-3 * max(np.abs(load).max() for load in case.loads)
        ahead, back = (case.displacement([s * step * f for f in forces]) for s in (1, -1))
        moved = (ahead - back) / (2 * step)
        together = np.concatenate([force[0] for force in forces])
        expected = basis @ np.linalg.solve(stiffness, basis.T @ together)
        np.testing.assert_allclose(moved, expected, rtol=0, atol=5e-7 * np.abs(moved).max())


@pytest.mark.parametrize("kind", KINDS)
def test_tangents_of_running_states_are_derivatives_of_internal_forces(kind: str) -> None:
    case = Static(strips("L-arm"), kind, 0.3, 20.0)
    state = [q.copy() for q in case.equilibrium().displacement]
    tangent, _ = running_tangents(case.model, case.motion, state)
    step = 1e-7
    for link, q in enumerate(state):
        derivative = np.empty_like(tangent[link][0])
        for column in range(q.shape[1]):
            both = []
            for sign in (1, -1):
                moved = [each.copy() for each in state]
                moved[link][0, column] += sign * step
                both.append(internal_forces(case.model, moved)[link][0])
            derivative[:, column] = (both[0] - both[1]) / (2 * step)
        size = np.abs(derivative).max()
        np.testing.assert_allclose(tangent[link][0], derivative, rtol=0, atol=1e-7 * size)


@CASES
@pytest.mark.parametrize(
    "kind", ["ancf", pytest.param("geometrically-exact", marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize(
    "integrator",
    ["trapezoidal", pytest.param("generalized-alpha", marks=pytest.mark.thorough)],
)
def test_a_run_keeps_its_energy_and_its_joints(
    name: str, bodies: bool, kind: str, integrator: Any
) -> None:
    mechanism = strips(name, 4e-3, bodies)
    engine, drive = ExudynEngine(mechanism, 3, kind), ConstantSpeed(20.0)
    time = np.linspace(0.0, 0.02, 21)
    run = engine.simulate(drive, LinkState.rigid(engine.links), time, 2e-5, integrator=integrator)
    assert run.energy_error < 1e-6
    assert max(np.abs(q).max() for q in run.displacement) > 1e-5
    for instant in (7, 20):
        motion = mechanism.linkage.motion(drive.crank_angle(time[instant : instant + 1]), 20.0)
        displaced = [q[instant : instant + 1] for q in run.displacement]
        ties = Ties(mechanism.linkage.topology, motion, engine.links, displaced)
        assert np.abs(ties.gaps).max() < 1e-13


@pytest.mark.parametrize("kind", KINDS)
def test_forces_of_joints_balance_inertia(kind: str) -> None:
    """Stiff links: a weld, a line and a pin carry what the rigid linkage asks for."""
    linkage = SliderCrank()
    steel = BeamSection.rectangle(Material(2e16, 7800.0), 10e-3, 20e-3)
    mechanism = Mechanism(linkage, dict.fromkeys(linkage.topology.link_names, steel))
    engine, drive = ExudynEngine(mechanism, 2, kind), ConstantSpeed(20.0)
    time = np.linspace(0.0, 0.05, 6)
    run = engine.simulate(
        drive, LinkState.rigid(engine.links), time, 1e-4, integrator="generalized-alpha"
    )
    motion = linkage.motion(drive.crank_angle(time), 20.0)
    mass = mechanism.link_mass("coupler").moment(0)
    centre = motion.acceleration(1, linkage.coupler / 2)
    names = linkage.topology.joint_names
    pin, line = (run.joint_force[:, names.index(joint)] for joint in ("A", "B"))
    # On the coupler: the pin's force, for it follows, and the line's.
    # The axial vibration of the start has died out by the second sample.
    size = np.abs(mass * centre).max()
    np.testing.assert_allclose((pin + line)[2:], (mass * centre)[2:], rtol=0, atol=1e-5 * size)
    assert np.abs(line[:, 0]).max() < 1e-9 * size
    assert np.abs(line[:, 1]).max() > 0.05 * size


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("kind", KINDS)
def test_loads_of_bodies_are_those_of_the_rigid_linkage(name: str, kind: str) -> None:
    """Force and moment of each link's inertia and weight, bodies included."""
    mechanism = strips(name, bodies=True)
    case = Static(mechanism, kind, 0.7, 20.0)
    rigid = mechanism.inverse_dynamics(case.motion)
    for number, (link, load) in enumerate(zip(case.links, case.loads, strict=True)):
        fields, angle = link.fields, case.motion.angle[0, number]
        along, across = load[0] @ fields.along, load[0] @ fields.across
        force = along * direction(angle) + across * normal(angle)
        wanted = rigid.inertia_force[0, number]
        np.testing.assert_allclose(force, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
        moment = load[0] @ fields.tangential
        wanted = rigid.inertia_moment[0, number]
        if kind == "geometrically-exact" and not link.rigid:
            # The rigid linkage's strips are lines.
            section, length = mechanism.sections[link.name], mechanism.link_mass(link.name).length
            turning = case.motion.angular_acceleration[0, number]
            wanted -= section.rotary_inertia * length * turning
        assert moment == pytest.approx(wanted, rel=1e-11, abs=1e-13)
