"""Nonlinear beam elements and dead moments: energies, forces and tangents are derivatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from flexmech.materials import Material
from flexmech.mechanics import DeadMoments
from flexmech.mechanics.beams.elements import BEAM_SHAPES, BeamElements
from flexmech.reference.corotational import CorotationalElements
from flexmech.sections import BeamSection
from tests.support.strategies import numbers

LENGTH, AXIAL, BENDING = 0.7, 40.0, 0.3
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)
PLACES, WEIGHTS = (POINTS + 1) / 2, WEIGHTS / 2
# Chords that are neither folded over nor turned by more than half a turn.
deformed = st.lists(numbers(-0.2, 0.2), min_size=12, max_size=12).map(np.array)


def element_response(elements, q):
    """Forces (2 p,) and tangent (2 p, 2 p) of one element in nodal coordinates."""
    force, tangent, _ = elements.response(elements.relative(q[:, None]))
    return elements.on_nodes(force)[:, 0], elements.of_link(tangent)[0]


def energy(q):
    """Strain energy by quadrature along the chord: mean shallow-arch strain, linear curvature."""
    end = complex(LENGTH + q[3] - q[0], q[4] - q[1])
    ends = np.array([q[2], q[5]]) - np.angle(end)
    turns = ends[0] * Polynomial([0, 1, -2, 1]) + ends[1] * Polynomial([0, 0, -1, 1])
    slope, curvature = turns.deriv()(PLACES), turns.deriv(2)(PLACES) / LENGTH
    strain = (abs(end) - LENGTH) / LENGTH + WEIGHTS @ slope**2 / 2
    return LENGTH / 2 * (AXIAL * strain**2 + BENDING * (WEIGHTS @ curvature**2))


@given(deformed)
def test_forces_of_an_euler_element_are_the_gradient_of_its_strain_energy(q):
    section = BeamSection(AXIAL, BENDING, 1.0, 1.0, 1.0, 1.0)
    beam = BeamElements(BEAM_SHAPES["euler"], section, np.array([LENGTH]))
    force = element_response(CorotationalElements(beam), q[:6])[0]
    step, gradient = 1e-3, []
    for unit in np.eye(6):
        near, far = (energy(q[:6] + h * unit) - energy(q[:6] - h * unit) for h in (step, 2 * step))
        gradient.append((8 * near - far) / (12 * step))
    assert force == pytest.approx(np.array(gradient), abs=1e-7)


@pytest.mark.parametrize("kind", tuple(BEAM_SHAPES))
@given(q=deformed, angle=numbers(-2.5, 2.5))
@settings(max_examples=15)
def test_tangents_are_derivatives_of_forces_that_turn_with_the_element(kind, q, angle):
    """All theories, bent, stretched and off the pins' axis."""
    shapes = BEAM_SHAPES[kind]
    section = BeamSection.rectangle(Material(70e9, 2700.0, 0.3), 1 / 8, 0.02)
    if kind != "reddy":
        section = replace(section, neutral_axis=0.03, free_curvature=0.2)
    beam = BeamElements(shapes, section, np.array([LENGTH]))
    elements, unit, size = CorotationalElements(beam), section.bending_stiffness, shapes.per_node
    q = q[: 2 * size]

    def force(x):
        return element_response(elements, x)[0] / unit

    step, tangent = 1e-5, element_response(elements, q)[1] / unit
    slope = np.stack(
        [(force(q + step * d) - force(q - step * d)) / (2 * step) for d in np.eye(2 * size)], axis=1
    )
    largest = np.abs(tangent).max()
    assert tangent == pytest.approx(slope, abs=1e-6 * largest)
    assert tangent == pytest.approx(tangent.T, abs=1e-12 * largest)
    turned = q.copy()
    for first, start in ((0, 0.0), (size, LENGTH)):
        place = complex(start + q[first], q[first + 1]) * np.exp(1j * angle)
        turned[first : first + 2] = place.real - start, place.imag
        turned[[first + a for a in shapes.angles]] += angle
    before, after = force(q), force(turned)
    for first in (0, size):
        expected = complex(*before[first : first + 2]) * np.exp(1j * angle)
        assert complex(*after[first : first + 2]) == pytest.approx(expected, abs=1e-8 * largest)
        rest = slice(first + 2, first + size)
        assert after[rest] == pytest.approx(before[rest], abs=1e-8 * largest)


def test_the_stiffness_of_dead_moments_is_the_derivative_of_their_decrease():
    """A dead force keeps its direction while its arm turns with the section."""
    virial, moment = np.array([[3.0], [-2.0]]), np.array([[0.7], [1.9]])
    dead = DeadMoments(np.zeros(2, dtype=int), np.array([2, 5]), virial, moment)
    q = np.array([[0.0], [0.0], [0.4], [0.0], [0.0], [-1.1]])

    def force(displacement):
        found = [np.zeros_like(q)]
        dead.add_forces(found, [displacement])
        return found[0][[2, 5], 0]

    rows, stiffness = dead.rotation_stiffness([q])[0]
    step = 1e-6
    change = (force(q + step) - force(q - step)) / (2 * step)
    assert rows.tolist() == [2, 5]
    assert stiffness[:, 0] == pytest.approx(change, rel=1e-8)
    # By hand: at an angle a force F on an arm r has lost r x F - (turned r) x F.
    assert force(q)[0] == pytest.approx(3.0 * np.sin(0.4) + 0.7 * (1 - np.cos(0.4)), rel=1e-12)
