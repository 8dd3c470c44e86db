"""Links that bend or stretch without load: both engines, the arc and the length that they take."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    FourBar,
    InputError,
    Laminate,
    LaminateSection,
    Material,
    Mechanism,
    Ply,
    ReferenceEngine,
    RotatingArm,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from flexmech.materials import Layer

ALUMINIUM = Material(69e9, 2700.0, 0.33)
SECTION = BeamSection.rectangle(ALUMINIUM, 0.003, 0.02)
ANGLES = np.radians([10.0, 130.0, 250.0])
# Hardly a motion: two samples of a crank that turns by a thousandth of a degree.
STILL = ResponseRequest(ConstantSpeed(0.1), 1e-4, samples=20_000, start="equilibrium")
KINDS = [
    *((ReferenceEngine, element) for element in ("euler", "timoshenko", "reddy", "zigzag")),
    *((ExudynEngine, element) for element in ("ancf", "geometrically-exact")),
]


def four_bar(curvature: float = 0.0, section: BeamSection = SECTION, grown: float = 1.0):
    """Coupler and rocker bend without load."""
    bent = replace(section, free_curvature=curvature)
    lengths = FourBar(0.25, 0.1 * grown, 0.28 * grown, 0.26 * grown)
    return Mechanism(lengths, {"crank": section, "coupler": bent, "rocker": bent})


def deflection(engine: Any) -> np.ndarray:
    return response(engine, STILL).dataset["deflection"].values[0, 0]


@pytest.mark.parametrize(("kind", "element"), KINDS)
def test_links_between_pins_are_arcs_of_their_free_curvature(kind: Any, element: str) -> None:
    """The middle stands off the chord by ``(1 - cos(k L / 2)) / k``.

    In the reference inside an element, whose shape has its curvature at both nodes.
    """
    curvature, lengths = 0.1, np.array([0.28, 0.26])
    found = deflection(kind(four_bar(curvature), 3 if kind is ReferenceEngine else 4, element))
    wanted = -(1 - np.cos(curvature * lengths / 2)) / curvature
    assert found[1:] == pytest.approx(wanted, rel=1e-5 if kind is ReferenceEngine else 1e-4)
    assert abs(found[0]) < 1e-6


@pytest.mark.parametrize(("kind", "element"), KINDS[1::3])
def test_the_tip_of_a_free_arm_is_where_its_arc_ends(kind: Any, element: str) -> None:
    """Straight elements inscribe the arc, with an error of second order."""
    length, curvature, errors = 0.5, 1.2, []
    turned, section = curvature * length, replace(SECTION, free_curvature=curvature)
    wanted = np.array([np.sin(turned) / curvature - length, (1 - np.cos(turned)) / curvature])
    for elements in (8, 16):
        arm = kind(Mechanism(RotatingArm(length), {"arm": section}), elements, element)
        motion = arm.mechanism.linkage.motion(np.zeros(1))
        moved = arm.stressed_links(motion, "equilibrium").displacement[0][0]
        errors.append(np.abs(moved[arm.links[0].end] / wanted - 1).max())
    assert errors[1] < 1e-3
    assert errors[0] / errors[1] > 3.5


def test_joints_of_bowed_links_carry_the_same_in_runs_of_both_engines() -> None:
    """In a linear run about the equilibrium: what the joints pass on is in its internal forces."""
    request = ResponseRequest(
        ConstantSpeed(5.0), 0.2, samples=20, step=1e-3, modes=2, start="rigid"
    )
    forces, torques = [], []
    for kind in (ReferenceEngine, ExudynEngine):
        data = response(kind(four_bar(0.3), 2), replace(request, start="equilibrium")).dataset
        assert float(data["energy_error"].item()) < 5e-5
        forces.append(data["joint_force"].values[0])
        torques.append(data["driving_torque"].values[0])
    np.testing.assert_allclose(forces[0], forces[1], atol=0.02 * np.abs(forces[1]).max())
    np.testing.assert_allclose(torques[0], torques[1], atol=0.01 * np.abs(torques[1]).max())


@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_free_strain_is_a_swollen_length(kind: Any) -> None:
    """By the dry length: a swollen link is thinner by what it is longer, and as much stiffer."""
    strain = 0.01
    stretched = replace(SECTION, free_strain=strain)
    grown = replace(
        SECTION,
        axial_stiffness=(1 + strain) * SECTION.axial_stiffness,
        bending_stiffness=(1 + strain) * SECTION.bending_stiffness,
        mass_per_length=SECTION.mass_per_length / (1 + strain),
    )
    found, wanted, dry = (
        natural_frequencies(kind(four_bar(0.0, section, factor), 8), ANGLES, modes=3)
        for section, factor in ((stretched, 1.0), (grown, 1 + strain), (SECTION, 1.0))
    )
    assert found == pytest.approx(wanted, rel=2e-4)
    assert np.abs(dry / wanted - 1).max() > 5e-3


@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_engines_agree_on_bent_links(speed: float) -> None:
    """The gap falls with the square of the element length, as the reference's error."""
    gaps = []
    for elements in (8, 16):
        reference, exudyn = (
            natural_frequencies(kind(four_bar(0.8), elements), ANGLES, speed)
            for kind in (ReferenceEngine, ExudynEngine)
        )
        gaps.append(np.abs(reference / exudyn - 1).max())
    assert gaps[1] < 3e-4
    assert gaps[0] / gaps[1] > 2.8
    straight = natural_frequencies(ReferenceEngine(four_bar(), 8), ANGLES, speed)
    assert np.abs(exudyn / straight - 1).max() > 0.02


def test_bent_and_eccentric_links_agree() -> None:
    """A bimetal coupler, its neutral axis off the pins, bent by heat; frequencies extrapolated."""
    metals = Ply.isotropic(ALUMINIUM), Ply.isotropic(Material(200e9, 7800.0))
    strip = Laminate((Layer(metals[0], 0.004), Layer(metals[1], 0.003)))
    section = replace(BeamSection.of_laminate(LaminateSection(strip, 0.02)), free_curvature=-0.3)
    plain = BeamSection.rectangle(ALUMINIUM, 0.008, 0.02)
    sections = {"crank": plain, "coupler": section, "rocker": plain}
    mechanism = Mechanism(FourBar(0.25, 0.1, 0.28, 0.26), sections)
    limits = []
    for kind in (ReferenceEngine, ExudynEngine):
        coarse, fine = (
            natural_frequencies(kind(mechanism, elements), ANGLES, 30.0, modes=3)
            for elements in (8, 16)
        )
        limits.append(fine + (fine - coarse) / 3)
    assert limits[0] == pytest.approx(limits[1], rel=2e-4)


@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_levels_of_straight_links_are_refused_of_bent_ones(kind: Any) -> None:
    for prestress in ("none", "axial"):
        with pytest.raises(InputError, match="use prestress 'equilibrium'"):
            natural_frequencies(kind(four_bar(0.5)), ANGLES, 10.0, prestress=prestress)


def test_exact_beams_refuse_a_free_strain() -> None:
    stretched = four_bar(0.0, replace(SECTION, free_strain=0.01))
    with pytest.raises(InputError, match="swollen length"):
        ExudynEngine(stretched, element="geometrically-exact")


@pytest.mark.thorough
def test_bent_links_run_alike() -> None:
    """From the equilibrium on, with links bowed by 8 mm: ten times their thickness."""
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=0.08, start="equilibrium")
    reference, exudyn = (
        response(kind(four_bar(0.8), 6), request).dataset["deflection"].values[0]
        for kind in (ReferenceEngine, ExudynEngine)
    )
    gap = np.abs(reference - exudyn).max(axis=0) / np.abs(exudyn).max(axis=0)
    assert gap[0] < 2e-3
    assert np.all(gap[1:] < 2e-4)
