"""Validation V15: the four-bar of Turcic, Midha & Bosnik (1984) at rest.

The published frequencies and those at 0 and 60 degrees are cases of the verification.
"""

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, load_mechanism, natural_frequencies
from flexmech.verification import verification_case

SUBJECT = "Four-bar of Turcic, Midha & Bosnik at rest"
ENGINES = {"reference": ReferenceEngine, "exudyn": ExudynEngine}
# Of crank, coupler and rocker: A in m^2 and EI in N m^2; E in Pa, rho in kg/m^3.
STATED = {"crank": (1.0774e-4, 11.472), "coupler": (4.0645e-5, 0.616), "rocker": (4.0645e-5, 0.616)}
MODULUS, DENSITY = 71e9, 2714.0


@pytest.fixture(scope="module")
def turcic(models):
    return load_mechanism(models / "turcic_midha_bosnik_fourbar.toml")


def test_the_model_is_what_the_source_states(turcic):
    for name, (area, bending) in STATED.items():
        section = turcic.sections[name]
        assert section.axial_stiffness == pytest.approx(MODULUS * area, rel=1e-12)
        assert section.bending_stiffness == bending
        assert section.mass_per_length == pytest.approx(DENSITY * area, rel=1e-12)
        assert section.rotary_inertia == pytest.approx(DENSITY * bending / MODULUS, rel=1e-6)
        # Of a rectangle, of which the thickness is known by area and second moment.
        thickness = np.sqrt(12 * bending / (MODULUS * area))
        assert section.in_plane_thickness == pytest.approx(thickness, rel=1e-4)
        assert not section.shears
    lengths = {"ground": 0.254, "crank": 0.108, "coupler": 0.2794, "rocker": 0.2705}
    assert turcic.linkage.lengths == pytest.approx(lengths, rel=1e-14)
    assert turcic.linkage.branch == "open"
    assert turcic.joint_masses == {"A": 0.042, "B": 0.042}


@pytest.mark.parametrize("engine", ENGINES)
def test_every_published_frequency(engine):
    """By mode, closer than the tolerance of the case."""
    case = verification_case(f"{SUBJECT}: 51 crank angles, {engine}")
    outcome = case.outcome()
    assert case.tolerance == 1e-3
    assert outcome.verdict == "passed"
    deviation = outcome.deviation.reshape(51, 2).max(axis=0)
    assert np.all(deviation < [7e-4, 2.5e-4])


def test_labels_are_the_crank_angles_of_the_published_frequencies():
    """Labels of 102 numbers; the first point and the highest of each mode, as read off."""
    case = verification_case(f"{SUBJECT}: 51 crank angles, reference")
    angles = np.arange(51) * 7.2
    labels = tuple(f"{angle:g} deg, mode {mode}" for angle in angles for mode in (1, 2))
    assert case.labels == labels
    published = 2 * np.pi * case.expected_values()
    at = dict(zip(labels, published, strict=True))
    assert at["0 deg, mode 1"] == pytest.approx(269.79, rel=1e-12)
    assert at["144 deg, mode 1"] == pytest.approx(298.80, rel=1e-12)
    assert at["259.2 deg, mode 2"] == pytest.approx(318.77, rel=1e-12)


@pytest.mark.parametrize("degrees", [0, 60])
@pytest.mark.parametrize("engine", ENGINES)
def test_the_first_three_modes(turcic, engine, degrees):
    expected = verification_case(f"{SUBJECT}: {degrees} deg, {engine}").expected_values()
    assert expected.size == 3
    found = natural_frequencies(ENGINES[engine](turcic, 16), np.radians(degrees), modes=3)
    np.testing.assert_allclose(found, expected, rtol=1e-5)


@pytest.mark.parametrize(("elements", "most"), [(8, 1e-6), (16, 1e-7)])
def test_engines_agree_at_other_angles(turcic, elements, most):
    """Three modes, on one mesh; 1e-5 is asked for. By default both engines take slender beams."""
    angles = np.radians(np.arange(0.0, 360.0, 7.2) + 3.1)
    engines = [engine(turcic, elements) for engine in ENGINES.values()]
    assert [engine.element for engine in engines] == ["euler", "ancf"]
    reference, exudyn = (natural_frequencies(engine, angles, modes=3) for engine in engines)
    np.testing.assert_allclose(exudyn, reference, rtol=most)
