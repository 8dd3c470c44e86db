"""Exudyn's ANCF cables against the reference on the same mesh, over a whole turn."""

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    FourBar,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.verification import verification_case

TURN = np.radians(np.arange(0, 360, 10))


def case(name):
    """Case of the verification, which has a position every 30 degrees."""
    return verification_case(f"Both engines on one mesh: {name}")


def difference(mechanism, elements, speed, *, angles=TURN, prestress="equilibrium", **options):
    """Greatest relative difference in the first three modes."""
    first, second = (
        natural_frequencies(
            engine(mechanism, elements), angles, speed, modes=3, prestress=prestress, **options
        )
        for engine in (ReferenceEngine, ExudynEngine)
    )
    return np.abs(second / first - 1).max()


@pytest.mark.parametrize("name", ["aluminium", "steel"])
@pytest.mark.parametrize("elements", [8, 16])
def test_at_rest(mechanisms, name, elements):
    assert difference(mechanisms[name], elements, 0.0) < case(f"{name}, at rest").tolerance


@pytest.mark.parametrize("name", ["aluminium", "steel"])
@pytest.mark.parametrize("rotation_terms", [False, True])
def test_at_equilibrium(mechanisms, name, rotation_terms):
    """At the highest speed; at 10 rad/s the gap is two to four times smaller."""
    found = difference(mechanisms[name], 16, 20.0, rotation_terms=rotation_terms)
    assert found < case(f"{name}, 20 rad/s, equilibrium").tolerance


@pytest.mark.parametrize("name", ["aluminium", "steel"])
def test_the_gap_closes_with_the_mesh(mechanisms, name):
    """Second order: cables interpolate the stretch cubically, the reference linearly."""
    angles = np.radians(np.arange(0, 360, 30))
    coarse, fine = (difference(mechanisms[name], n, 20.0, angles=angles) for n in (8, 16))
    assert np.log2(coarse / fine) > 1.8


@pytest.mark.parametrize(("prestress", "order"), [("none", 4), ("equilibrium", 2)])
def test_geometrically_exact_beams_tend_to_the_same_frequencies(aluminium, prestress, order):
    """Linear elements with their mass at the nodes bend in fourth order; stress adds a second."""
    angles, error = np.radians([0.0, 120.0]), []
    options = {"modes": 2, "prestress": prestress, "rotation_terms": False}
    exact = natural_frequencies(ReferenceEngine(aluminium, 32, "timoshenko"), angles, 20, **options)
    for n in (8, 16):
        beams = ExudynEngine(aluminium, n, "geometrically-exact")
        error.append(np.abs(natural_frequencies(beams, angles, 20, **options) / exact - 1).max())
    assert np.log2(error[0] / error[1]) == pytest.approx(order, abs=0.35)
    assert error[0] < 4e-4


@pytest.fixture(scope="module")
def everything() -> Mechanism:
    """Crossed branch, unlike links, joint and link masses, gravity, damping."""
    steel, plastic = Material(200e9, 7800.0), Material(3e9, 1200.0, 0.35)
    sections = {
        "crank": BeamSection.rectangle(steel, 6e-3, 10e-3),
        "coupler": BeamSection.rectangle(plastic, 8e-3, 12e-3).with_damping_ratio(0.02, 50.0),
        "rocker": BeamSection.rectangle(steel, 3e-3, 10e-3).with_damping_time(1e-5),
    }
    return Mechanism(
        FourBar(0.3, 0.1, 0.28, 0.25, "crossed"),
        sections,
        joint_masses={"A": 0.02, "B": 0.03, "O4": 1.0},
        link_masses=(PointMass("coupler", 0.1, 0.015), PointMass("rocker", 0.125, 0.01)),
        gravity=(0.0, -9.81),
    )


@pytest.mark.parametrize("speed", [0.0, 25.0])
def test_masses_gravity_damping_and_the_crossed_branch(everything, speed):
    angles = np.radians(np.arange(0, 360, 45))
    assert difference(everything, 12, speed, angles=angles) < 1e-4


def test_damping_ratios(everything):
    from flexmech.analyses import solve_modes

    angles = np.radians(np.arange(0, 360, 45))
    first, second = (
        solve_modes(engine(everything, 12).linear_system(angles, 25.0, modes=3), 3).damping_ratio
        for engine in (ReferenceEngine, ExudynEngine)
    )
    assert first.max() > 1e-3
    np.testing.assert_allclose(second, first, rtol=1e-3, atol=1e-6)


def test_term_by_term(aluminium):
    """The link-frame matrices act alike on the same rigid-body-like field of the stations.

    Kinetic energy, Coriolis power and centripetal work of a displacement that both meshes
    can represent are equal, whatever their coordinates.
    """
    motion = aluminium.linkage.motion(np.radians([40.0]), 20.0)
    values = []
    for engine in (ReferenceEngine(aluminium, 8), ExudynEngine(aluminium, 8)):
        for link in engine.links:
            fields = link.fields
            values.append(
                [
                    fields.across @ link.mass @ fields.tangential,
                    fields.across @ link.gyroscopic @ fields.centripetal,
                    fields.centripetal @ link.centrifugal_mass @ fields.centripetal,
                    fields.along @ link.gyroscopic @ fields.tangential,
                ]
            )
    assert motion.angle.shape == (1, 3)
    np.testing.assert_allclose(values[:3], values[3:], rtol=1e-10)
