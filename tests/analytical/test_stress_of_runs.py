"""Normal stress of running links against formulas of the strength of materials."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    Load,
    Material,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    response,
)
from flexmech.linkages import AttachmentPoint, forces_by_joints
from flexmech.linkages.applied_forces import applied_forces

STEEL = Material(200e9, 7800.0, 0.3, yield_strength=235e6)
LENGTH, THICKNESS, WIDTH = 0.3, 4e-3, 20e-3
SECTION = BeamSection.rectangle(STEEL, THICKNESS, WIDTH).with_damping_ratio(0.05, frequency=40.0)
MODELS = Path(__file__).parents[2] / "models"


def run(mechanism: Mechanism, speed: float, revolutions: float = 1.0, modes: int = 2) -> Response:
    request = ResponseRequest(speed, revolutions, start="periodic", modes=modes)
    return response(ReferenceEngine(mechanism, 6), request)


def test_a_rotating_arm_is_pulled_by_its_own_mass() -> None:
    """At the root rho omega^2 L^2 / 2."""
    speed = 100.0
    found = run(Mechanism(RotatingArm(LENGTH), {"arm": SECTION}), speed).dataset.squeeze()
    pulled = STEEL.density * speed**2 * LENGTH**2 / 2
    # Elastic stretch moves the mass outward: 5 / 12 rho omega^2 L^2 / E = 1.5e-5 more. The rule of
    # integration, which has no numerical damping, leaves a vibration along the arm of 5e-5.
    assert float(found["peak_axial_stress"]) == pytest.approx(pulled, rel=1e-4)
    assert float(found["peak_stress"]) == pytest.approx(pulled, rel=1e-4)
    assert float(found["peak_stress_place"]) == 0.0


def test_a_force_across_its_tip_bends_an_arm_most_at_its_clamp() -> None:
    """F L h / (2 I), at a speed at which inertia counts for nothing."""
    force = 10.0
    load = Load("tip", AttachmentPoint("arm", LENGTH), ((0.0, force),), axes="link")
    slow = 5.0
    mechanism = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, loads=(load,))
    # The force is at no joint: component modes, not static shapes, follow it to the clamp.
    found = run(mechanism, slow, 0.1, modes=6)
    second_moment = WIDTH * THICKNESS**3 / 12
    bent = force * LENGTH * THICKNESS / 2 / second_moment
    # Its direction turns with the slope of the tip, and pushes by F^2 L^2 / (2 E I) then.
    slope = force * LENGTH**2 / (2 * STEEL.youngs_modulus * second_moment)
    pulled = STEEL.density * slow**2 * LENGTH**2 / 2 - force * slope / (WIDTH * THICKNESS)
    (number,) = (one for one in found.summary().numbers if one.name == "peak_stress")
    assert number.value == pytest.approx(1e-6 * (bent + pulled), rel=1e-3)
    peaks = found.dataset.squeeze()
    assert float(peaks["peak_stress_place"]) == 0.0
    assert float(peaks["peak_axial_stress"]) == pytest.approx(pulled, rel=0.02)


@pytest.mark.parametrize(
    "name", ["aluminium_fourbar", "carton_pusher", "slider_crank", "stephenson_six_bar"]
)
def test_forces_inside_links_follow_from_the_joint_forces(name: str) -> None:
    """Those of the rigid linkage are those of its own inverse dynamics."""
    mechanism = load_mechanism(MODELS / f"{name}.toml")
    topology = mechanism.linkage.topology
    angles = np.linspace(0.1, 6.2, 7)
    motion = mechanism.linkage.motion(angles, 12.0)
    known = mechanism.inverse_dynamics(motion)
    joint_force = np.stack([known.joint_force[joint] for joint in topology.joint_names], axis=-2)
    applied = applied_forces(
        topology,
        motion,
        mechanism.loads,
        mechanism.springs,
        mechanism.joint_springs,
        motion.angle,
        0.0,
    )
    found = forces_by_joints(
        topology, motion, mechanism.link_masses_in_order, mechanism.gravity, joint_force, applied
    )
    for number, link in enumerate(topology.links):
        places = link.length * np.array([0.0, 0.3, 0.9])
        for force in ("axial_force", "shear_force"):
            expected = getattr(known, force)(number, places)
            size = np.abs(joint_force).max()
            assert getattr(found, force)(number, places) == pytest.approx(
                expected, abs=1e-12 * size
            )


def test_a_link_above_its_yield_strength_is_warned_of() -> None:
    speed = 100.0
    pulled = STEEL.density * speed**2 * LENGTH**2 / 2
    arm = Mechanism(RotatingArm(LENGTH), {"arm": SECTION})
    said = run(arm, speed).summary()
    assert not said.warnings
    assert "it yields at 235 MPa" in said.answer[0]
    weak = replace(STEEL, yield_strength=0.9 * pulled)
    section = BeamSection.rectangle(weak, THICKNESS, WIDTH).damped_as(SECTION)
    (warning, *_) = run(replace(arm, sections={"arm": section}), speed).summary().warnings
    assert warning.startswith("the arm yields: its stress reaches 3.510 MPa, above the yield ")
    # Nothing is said where the material does not state it.
    silent = BeamSection.rectangle(replace(STEEL, yield_strength=None), THICKNESS, WIDTH)
    said = run(replace(arm, sections={"arm": silent.damped_as(SECTION)}), speed).summary()
    assert not said.warnings
    assert "yields" not in " ".join(said.answer)


def test_a_yield_strength_is_kept_by_a_model_file(tmp_path: Path) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(Mechanism(RotatingArm(LENGTH), {"arm": SECTION}).to_toml())
    section = load_mechanism(path).sections["arm"]
    assert section.layers.laminate.layers[0].ply.isotropic_material == STEEL
    assert section == SECTION
