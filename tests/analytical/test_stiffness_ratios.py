"""A soft link beside stiff ones: neither equilibrium nor frequencies drown in round-off.

The same configuration one turn later differs by the round-off of its coordinates alone, and so
must everything that is computed from it.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, moving_frequencies
from flexmech.linkages import FourBar
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.reference import equilibrium
from flexmech.sections import BeamSection

LINKS = ("crank", "coupler", "rocker")
LINKAGE = FourBar(ground=0.06257, crank=0.01487, coupler=0.07313, rocker=0.07385)
MATERIAL = Material(145e9, 1433.0)
TURNS = np.arange(3) * 2 * np.pi


def fourbar(thicknesses, widths):
    """Links of one material; thicknesses in the plane, in m."""
    sections = {
        name: BeamSection.rectangle(MATERIAL, in_plane_thickness=t, out_of_plane_width=b)
        for name, t, b in zip(LINKS, thicknesses, widths, strict=True)
    }
    return Mechanism(LINKAGE, sections)


def scatter(mechanism, angle, speed, *, rotation_terms, element="timoshenko"):
    """Greatest relative change of the first two frequencies from turn to turn."""
    result = moving_frequencies(
        ReferenceEngine(mechanism, element=element),
        np.radians(angle) + TURNS,
        [speed],
        modes=2,
        rotation_terms=rotation_terms,
    )
    frequency = result.dataset["frequency"].values[0, 0]
    return np.abs(frequency / frequency[0] - 1).max()


@pytest.mark.parametrize("rotation_terms", [False, True])
def test_a_crank_like_a_hair_beside_stout_links(rotation_terms):
    """The highest frequency of the mesh is ten million times the lowest of the linkage."""
    mechanism = fourbar((0.0634e-3, 0.794e-3, 2.6e-3), (0.341e-3, 6.93e-3, 2.19e-3))
    assert scatter(mechanism, 312.9405, 4.0, rotation_terms=rotation_terms) < 1e-7


@pytest.mark.parametrize("seed", range(3))
def test_random_ratios_of_stiffness(seed):
    """Crank the softest, by bending stiffness up to a million times."""
    draw = np.random.default_rng(seed)
    thickness = 1e-3 * np.array([draw.uniform(0.05, 0.1), *10 ** draw.uniform(-0.5, 0.7, 2)])
    mechanism = fourbar(thickness, 1e-3 * 10 ** draw.uniform(-0.5, 1.0, 3))
    for element in ("euler", "timoshenko"):
        angle, speed = draw.uniform(0, 360), 10 ** draw.uniform(0, 1)
        found = scatter(mechanism, angle, speed, rotation_terms=False, element=element)
        assert found < 1e-7


def test_the_equilibrium_of_a_soft_crank_does_not_stop_at_the_round_off_of_stiff_links():
    """Two units in the last place of the crank angle change it by 2e-12, steps of 5e-6 by 2e-10."""
    mechanism = fourbar((0.03e-3, 8e-3, 8e-3), (3e-3, 3e-3, 3e-3))
    angles = np.linspace(0, 2 * np.pi, 12, endpoint=False) + 1e-3
    engine = ReferenceEngine(mechanism)
    here, later = (
        engine.stressed_links(mechanism.linkage.motion(a, np.ones(12)), "equilibrium").displacement
        for a in (angles, angles + 2 * np.pi)
    )
    for first, second in zip(here, later, strict=True):
        assert np.abs(second - first).max() < 1e-11 * np.abs(first).max()


@pytest.mark.parametrize("element", ["ancf", "geometrically-exact"])
def test_exudyns_equilibrium_is_the_same_from_wherever_it_is_sought(element):
    """From straight links, from the same position and from another one: 3e-6 apart, if Newton's
    method may stop at what the round-off of stiff links leaves out of balance."""
    mechanism = fourbar((0.0634e-3, 0.794e-3, 2.6e-3), (0.341e-3, 6.93e-3, 2.19e-3))
    angles = np.radians([312.9405, 672.9405, 670.0, 1032.9405])
    found = ExudynEngine(mechanism, 4, element).stressed_links(
        mechanism.linkage.motion(angles, np.full(4, 4.0)), "equilibrium"
    )
    for q in found.displacement:
        assert np.abs(q[[1, 3]] - q[0]).max() < 1e-8 * np.abs(q[0]).max()


@pytest.mark.parametrize(("speed", "most"), [(20.0, 4), (45.0, 5)])
def test_newtons_method_takes_few_steps(aluminium, monkeypatch, speed, most):
    """One or two more, if the tension of what a step bends too far went into the next tangent."""
    steps, factorize = [], equilibrium.banded.factorize

    def counted(band: np.ndarray) -> np.ndarray:
        steps.append(band.shape[-1])
        return factorize(band)

    monkeypatch.setattr(equilibrium.banded, "factorize", counted)
    angles = np.radians(np.arange(0.0, 360.0, 5.0))
    motion = aluminium.linkage.motion(angles, np.full(len(angles), speed))
    ReferenceEngine(aluminium).stressed_links(motion, "equilibrium")
    assert len(steps) <= most


def test_positions_that_fail_are_loaded_in_steps_by_themselves(aluminium, monkeypatch):
    """Those that fail in some steps while others do not are not taken for loaded."""
    motion = aluminium.linkage.motion(np.radians(np.arange(0.0, 360.0, 5.0)), 110.0)
    engine = ReferenceEngine(aluminium)
    found = engine.stressed_links(motion, "equilibrium").displacement
    monkeypatch.setattr(equilibrium, "FIRST_ITERATIONS", 5)
    monkeypatch.setattr(equilibrium, "MAX_ITERATIONS", 6)
    monkeypatch.setattr(equilibrium, "LOAD_STEPS", (1, 2, 3, 25))
    batches, in_steps = [], equilibrium.Equilibrium._in_steps

    def counted(self, problem, steps):
        batches.append(problem.outer.shape[1])
        return in_steps(self, problem, steps)

    monkeypatch.setattr(equilibrium.Equilibrium, "_in_steps", counted)
    other = engine.stressed_links(motion, "equilibrium").displacement
    assert 72 > batches[0] > batches[1] > batches[2] > 0
    for q, exact in zip(other, found, strict=True):
        assert np.abs(q - exact).max() < 1e-12


def test_the_equilibrium_is_that_which_grows_from_the_unloaded_linkage(aluminium):
    """It changes smoothly along the turn: no position has snapped through, or lacks its load."""
    angles = 2 * np.pi / 336 * np.arange(336)
    engine = ReferenceEngine(aluminium)
    for speed in (115.0, 119.0):
        motion = aluminium.linkage.motion(angles, speed)
        for q in engine.stressed_links(motion, "equilibrium").displacement:
            bow = q - (np.roll(q, 1, axis=0) + np.roll(q, -1, axis=0)) / 2
            assert np.abs(bow).max() < 0.02
