"""Strains by which Exudyn's beams store energy: bent, stretched and swollen in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.arrays import FloatArray
from flexmech.multibody.beams import BEAM_KINDS
from flexmech.sections import BeamSection, DampingTimes
from tests.cross_engine.test_composite_sections import section

KINDS = pytest.mark.parametrize("kind", list(BEAM_KINDS))
SIZES = np.array([0.11, 0.07, 0.12])
PLACES = np.concatenate([[0.0], np.cumsum(SIZES)])
LENGTH = PLACES[-1]
TIMES = DampingTimes(axial=2e-4, bending=5e-4, shear=9e-4)


def coordinates(kind: str, place: FloatArray, turn: FloatArray, stretch: float = 0.0) -> FloatArray:
    """Nodes at complex places with the link's direction there, less those of the straight link."""
    moved = place - PLACES
    slope = (1 + stretch) * np.exp(1j * turn) - 1
    own = [slope.real, slope.imag] if kind == "ancf" else [turn]
    return np.stack([moved.real, moved.imag, *own], axis=1).ravel()[None]


def arc(kind: str, curvature: float) -> FloatArray:
    """Link bent to a circle."""
    turn = curvature * PLACES
    return coordinates(kind, (np.exp(1j * turn) - 1) / (1j * curvature), turn)


@KINDS
@pytest.mark.parametrize("free", [0.0, 0.3, -0.2])
def test_an_arc_stores_the_energy_of_its_curvature_beyond_the_free_one(
    kind: str, free: float
) -> None:
    curvature, swollen = 0.5, replace(section(), free_curvature=free)
    chain = arc(kind, curvature)
    bending = BEAM_KINDS[kind].strains(chain, 0 * chain, SIZES, swollen)[-1]
    energy = swollen.bending_stiffness * (curvature - free) ** 2 * LENGTH / 2
    assert bending.energy[0] == pytest.approx(energy, rel=2e-3)


@pytest.mark.parametrize("free", [0.0, 3e-4])
def test_a_stretched_cable_stores_the_energy_of_its_strain_beyond_the_free_one(free: float) -> None:
    strain, swollen = 1e-3, replace(section(), free_strain=free)
    chain = coordinates("ancf", (1 + strain) * PLACES + 0j, 0 * PLACES, strain)
    stretch = BEAM_KINDS["ancf"].strains(chain, 0 * chain, SIZES, swollen)[0]
    energy = swollen.axial_stiffness * (strain - free) ** 2 * LENGTH / 2
    assert stretch.energy[0] == pytest.approx(energy, rel=1e-9)


def both(kind: str, size: float) -> tuple[FloatArray, FloatArray]:
    """Random coordinates and rates of a chain of nodes."""
    count = BEAM_KINDS[kind].per_node * len(PLACES)
    displacement, rate = size * np.random.default_rng(6).uniform(-1, 1, (2, 1, count))
    return displacement, rate


@KINDS
def test_the_power_of_each_strain_is_the_rate_of_its_energy(kind: str) -> None:
    """Far from the straight link, stretched, sheared and bent at once."""
    own: BeamSection = replace(section(), free_curvature=0.4)
    displacement, rate = both(kind, 0.05)
    strains = BEAM_KINDS[kind].strains
    step = 1e-5
    sides = [strains(displacement + s * step * rate, rate, SIZES, own) for s in (1, -1)]
    for now, ahead, back in zip(strains(displacement, rate, SIZES, own), *sides, strict=True):
        change = (ahead.energy - back.energy) / (2 * step)
        np.testing.assert_allclose(now.power, change, rtol=1e-6)


@KINDS
def test_strains_that_grow_in_proportion_dissipate_by_their_damping_times(kind: str) -> None:
    """With the rate s of a strain e, ``tau E (s e)^2`` is twice tau s^2 times its energy."""
    growth, plain = 30.0, replace(section(), damping=TIMES)
    displacement, _ = both(kind, 1e-7)
    found = BEAM_KINDS[kind].strains(displacement, growth * displacement, SIZES, plain)
    times = {"ancf": [TIMES.axial, TIMES.bending]}.get(kind, [TIMES.axial, None, TIMES.bending])
    for strain, time in zip(found, times, strict=True):
        if time is not None:
            expected = 2 * time * growth**2 * strain.energy
            np.testing.assert_allclose(strain.dissipation, expected, rtol=1e-5)
