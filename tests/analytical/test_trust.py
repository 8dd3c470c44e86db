"""The errors that a map reports are true."""

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    PointMass,
    ReferenceEngine,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.analyses.frequencies.discretisation import check_angle_indices, mesh_error
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.linkages import JointSpring
from flexmech.mechanism import Mechanism

ANGLES = np.radians(np.arange(0, 360, 30))
CASES = [("none", 0.0, False), ("axial", 20.0, True), ("equilibrium", 20.0, True)]


def within_factor_two(engines, prestress, speed, rotation_terms):
    """Of engines of one kind and mechanism, which differ in their elements alone."""
    options = {"modes": 4, "prestress": prestress, "rotation_terms": rotation_terms}
    angles = ANGLES[::2]
    fine = natural_frequencies(engines[0].with_(elements=64), angles, speed, **options)
    for engine in engines:
        systems = Systems(engine, Formulation(**options))
        estimate = mesh_error(systems, angles, speed).frequency.max(axis=0)
        found = natural_frequencies(engine, angles, speed, **options)
        true = np.abs(found / fine - 1).max(axis=0)
        np.testing.assert_array_less(estimate, 2 * true)
        np.testing.assert_array_less(true, 2 * estimate)


@pytest.mark.parametrize("name", ["aluminium", pytest.param("steel", marks=pytest.mark.thorough)])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case[0])
def test_discretisation_error_of_the_reference(mechanisms, name, case):
    """Within a factor of two of the distance to 64 elements a link."""
    within_factor_two([ReferenceEngine(mechanisms[name], n) for n in (8, 16)], *case)


@pytest.mark.parametrize("element", ["ancf", "geometrically-exact"])
def test_discretisation_error_of_exudyn(aluminium, element):
    within_factor_two([ExudynEngine(aluminium, 8, element)], "none", 0.0, False)


@pytest.mark.thorough
def test_discretisation_error_with_point_masses(aluminium):
    loaded = Mechanism(
        aluminium.linkage,
        aluminium.sections,
        joint_masses={"A": 0.02},
        link_masses=(PointMass("coupler", 0.1, 0.02),),
    )
    within_factor_two([ReferenceEngine(loaded, 12)], "equilibrium", 20.0, True)


@pytest.mark.parametrize(
    ("make", "element"),
    [
        (ReferenceEngine, "euler"),
        (ReferenceEngine, "timoshenko"),
        (ExudynEngine, "ancf"),
        (ExudynEngine, "geometrically-exact"),
    ],
)
def test_discretisation_error_of_axial_modes(unit_arm, make, element):
    """The third mode of an arm of slenderness 30 stretches: of second order, bars being linear.

    In ANCF of first order, because the point mass makes the stretch jump; of fourth in exact beams.
    """
    arm = unit_arm(30)
    loaded = Mechanism(arm.linkage, arm.sections, link_masses=(PointMass("arm", 0.45, 0.2),))
    engine, options = (
        make(loaded, 8, element),
        {"modes": 3, "prestress": "none", "rotation_terms": False},
    )
    systems = Systems(engine, Formulation(**options))
    estimate = mesh_error(systems, np.zeros(1), 0.0).frequency[0, 2]
    fine, found = (
        natural_frequencies(e, 0.0, **options)[2] for e in (engine.with_(elements=80), engine)
    )
    assert estimate == pytest.approx(abs(found / fine - 1), rel=0.25)


@pytest.mark.parametrize(("prestress", "speed"), [("none", 0.0), ("equilibrium", 20.0)])
def test_reduction_error_is_the_distance_to_the_unreduced_matrices(mechanisms, prestress, speed):
    for mechanism in mechanisms.values():
        engine = ReferenceEngine(mechanism, 8)
        options = {"modes": 6, "prestress": prestress}
        dataset = moving_frequencies(engine, ANGLES, [speed], **options).dataset
        reduced = dataset["frequency"][0, 0].values
        exact = natural_frequencies(engine.unreduced(), ANGLES, speed, **options)
        where = check_angle_indices(ANGLES, full_turn=True)
        true = np.abs(reduced / exact - 1)[where]
        assert true.max() < 2e-5
        reported = dataset["reduction_error"][0, 0].values
        assert reported.max() == pytest.approx(true.max(), rel=0.3)


def test_a_fast_arm_gets_the_component_modes_that_it_needs(unit_arm):
    """At 50 times its own frequency scale, tension shapes the modes: few are not enough."""
    engine = ReferenceEngine(unit_arm(70), 32)
    options = {"modes": 4, "prestress": "axial"}
    reduced = natural_frequencies(engine, 0.0, 50.0, **options)
    exact = natural_frequencies(engine.unreduced(), 0.0, 50.0, **options)
    np.testing.assert_allclose(reduced, exact, rtol=2e-5)


@pytest.mark.parametrize("speed", [0.0, 10.0])
def test_an_axial_mode_among_the_lowest_is_not_lost(unit_arm, speed):
    """At slenderness 70 the fourth mode stretches: pi / 2 * 70 against 120.9 in bending."""
    engine = ReferenceEngine(unit_arm(70), 24)
    options = {"modes": 5, "prestress": "axial"}
    reduced = natural_frequencies(engine, 0.0, speed, **options)
    exact = natural_frequencies(engine.unreduced(), 0.0, speed, **options)
    np.testing.assert_allclose(reduced, exact, rtol=2e-5)
    if speed == 0.0:
        assert 2 * np.pi * reduced[3] == pytest.approx(np.pi / 2 * 70, rel=1e-3)


def test_the_terms_of_the_speed_effect_add_up(unit_arm):
    dataset = moving_frequencies(
        ReferenceEngine(unit_arm(70), 24),
        [0.0],
        [0.0, 10.0, 50.0],
        prestress="axial",
        speed_effect=True,
    ).dataset
    frequency = dataset["frequency"].isel(engine=0)
    total = dataset["speed_effect"].sum("term")
    np.testing.assert_allclose(total, frequency - frequency[0], atol=1e-4)


def test_the_mesh_is_refined_to_the_tolerance(aluminium):
    """Each engine by itself; without a tolerance the elements are those of the engines."""
    engines = [ReferenceEngine(aluminium, 2), ExudynEngine(aluminium, 4, "geometrically-exact")]
    angles, options = np.radians([0.0, 120.0]), {"modes": 2, "prestress": "none"}
    kept = moving_frequencies(engines, angles, [0.0], **options).dataset
    assert kept["elements"].values.tolist() == [2, 4]
    assert kept["discretisation_error"].max() > 1e-3
    refined = moving_frequencies(engines, angles, [0.0], tolerance=5e-4, **options)
    assert refined.dataset["elements"].values.tolist() == [4, 8]
    assert refined.dataset["discretisation_error"].max() < 5e-4
    capped = moving_frequencies(engines[0], angles, [0.0], tolerance=1e-12, **options).dataset
    assert capped["elements"].values.tolist() == [32]


def test_discretisation_error_of_links_that_springs_bend(aluminium):
    """Component modes of straight links are off by more than the mesh: they have no part in it."""
    spring = JointSpring("B", torsional_stiffness=0.05, free_angle=-1.0)
    bent = Mechanism(aluminium.linkage, aluminium.sections, joint_springs=(spring,))
    engine, options = ExudynEngine(bent, 8), {"modes": 3, "rotation_terms": False}
    estimate = mesh_error(Systems(engine, Formulation(**options)), ANGLES[:1], 0.0).frequency[0]
    found, fine = (
        natural_frequencies(each.unreduced(), ANGLES[0], **options)
        for each in (engine, engine.with_(elements=32))
    )
    assert estimate == pytest.approx(np.abs(found / fine - 1), rel=0.25)
