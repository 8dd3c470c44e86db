"""Points of links, and the half-sine pulse of a hammer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import flexmech
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.errors import InputError
from flexmech.linear_system import LinkPoint, displacement_row, point_rows
from flexmech.linkages.motion import direction, normal
from flexmech.reference import ReferenceEngine
from flexmech.time_domain import Impact

ANGLES = np.radians([20.0, 130.0])
FOURBAR = ReferenceEngine(
    flexmech.load_mechanism(flexmech.example_model("aluminium_fourbar")), elements=4
)


@pytest.mark.parametrize("text", ["coupler", "coupler:", ":0.5", "coupler:half", "coupler:0.5:x"])
def test_what_is_no_point_is_refused_with_an_example(text):
    with pytest.raises(InputError, match=r"no point of a link; write LINK:FRACTION, such as"):
        LinkPoint.parse(text)


@pytest.mark.parametrize("fraction", ["1.2", "-0.1", "nan"])
def test_a_point_off_its_link_is_refused(fraction):
    with pytest.raises(InputError, match=r"off its link; give a fraction|be a number"):
        LinkPoint.parse(f"coupler:{fraction}")


def test_an_unknown_link_is_refused_with_those_there_are():
    system = FOURBAR.linear_system(ANGLES, prestress="none")
    with pytest.raises(InputError, match=r"did you mean 'coupler'.*crank, coupler, rocker"):
        point_rows(system, LinkPoint.parse("couple:0.5"), "transverse")


@pytest.mark.parametrize("reduced", [True, False])
@pytest.mark.parametrize("link", ["crank", "coupler", "rocker"])
def test_rows_are_the_displacement_at_the_stations(link, reduced):
    """Stations stand inside elements and at nodes, and on ends that follow another link."""
    engine = FOURBAR if reduced else FOURBAR.unreduced()
    system = engine.linear_system(ANGLES, prestress="none")
    number = system.frames.topology.index(link)
    vectors = np.random.default_rng(1).normal(size=(len(ANGLES), system.size, 1))
    ground = system.displacements(vectors)[:, 0, number]
    angle = system.motion.angle[:, number]
    for station, fraction in ((0, 0.0), (7, 0.35), (20, 1.0)):
        for axis, name in ((direction(angle), "axial"), (normal(angle), "transverse")):
            rows = point_rows(system, LinkPoint(link, fraction), name)
            found = np.einsum("bn,bnm->b", rows, vectors)
            expected = np.sum(axis * ground[:, station], axis=-1)
            np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_a_rigid_turn_moves_each_point_by_its_distance():
    link = FOURBAR.links[1]
    row = displacement_row(link, 0.3, "transverse")
    assert row @ link.fields.tangential == pytest.approx(0.3 * link.readings.nodes[-1])
    assert displacement_row(link, 0.3, "axial") @ link.fields.along == pytest.approx(1.0)


def test_the_spectrum_is_the_fourier_integral_of_the_force():
    pulse = HalfSinePulse(3.0, 2e-3, start=1e-3)
    for frequency in (0.0, 100.0, 250.0, 700.0, -400.0):  # 250 Hz is one half over the duration
        parts = [
            quad(lambda t, f=f: pulse.force(t) * f(t), 1e-3, 3e-3)[0]
            for f in (
                lambda t: np.cos(2 * np.pi * frequency * t),  # noqa: B023
                lambda t: -np.sin(2 * np.pi * frequency * t),  # noqa: B023
            )
        ]
        assert pulse.spectrum(frequency) == pytest.approx(complex(*parts), abs=1e-12)
    assert abs(pulse.spectrum(500.0)) == pytest.approx(pulse.momentum / 3)


def test_a_pulse_pushes_while_it_lasts():
    pulse = HalfSinePulse(-2.0, 1e-3, start=0.5)
    np.testing.assert_allclose(pulse.force([0.4999, 0.5005, 0.501001]), [0, -2, 0])


def test_bad_pulses_and_impacts_are_refused():
    with pytest.raises(InputError, match="duration of a pulse must be positive"):
        HalfSinePulse(1.0, 0.0)
    point, pulse = LinkPoint("coupler", 0.5), HalfSinePulse(1.0, 1e-3)
    with pytest.raises(InputError, match="direction of an impact must be one of transverse, axial"):
        Impact(point, "upward", pulse)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="point of an impact must be a LinkPoint"):
        Impact("coupler:0.5", "axial", pulse)  # type: ignore[arg-type]


@pytest.mark.parametrize("fraction", [0.05, 0.4, 0.96])
def test_the_rotation_inside_an_element_is_the_slope_of_its_cubic(fraction):
    link = ReferenceEngine(FOURBAR.mechanism, 3, "euler").links[1]
    x, place = link.readings.nodes, fraction * link.readings.nodes[-1]
    q = np.zeros(link.size)
    q[1::3], q[2::3] = x**3, 3 * x**2
    assert link.readings.rotation_at(fraction) @ q == pytest.approx(3 * place**2, rel=1e-5)


def test_a_place_at_a_node_has_the_rotation_of_the_node():
    """It is not the slope of an axis that shears."""
    readings = ReferenceEngine(FOURBAR.mechanism, 4, "timoshenko").links[1].readings
    at_node = readings.rotation_at(0.5)
    assert np.flatnonzero(at_node).tolist() == [2 * readings.per_node + readings.slope]
    np.testing.assert_array_equal(readings.rotation_at(0.5 * (1 + 1e-12)), at_node)
    assert np.abs(readings.rotation_at(0.5 * (1 + 1e-6)) - at_node).max() > 0.1
