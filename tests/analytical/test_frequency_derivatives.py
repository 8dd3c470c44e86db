"""Derivatives of natural frequencies against closed forms and against central differences."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    frequency_derivatives,
    load_mechanism,
    natural_frequencies,
)
from flexmech.analyses.frequencies.derivatives import _derivative
from flexmech.errors import InputError
from flexmech.modelfile import mechanism_with

MODELS = Path(__file__).parents[2] / "models"
THICKNESS, LENGTH = "links.coupler.in_plane_thickness", "linkage.coupler"


def engine_of(mechanism: Mechanism) -> ReferenceEngine:
    return ReferenceEngine(mechanism, 4, "euler", component_modes=False)


def differences(mechanism, key, value, angles, speed, step=2e-4, **options):
    """Central differences of frequencies, extrapolated from two steps (Richardson)."""

    def at(factor):
        changed = mechanism_with(mechanism, key, factor * value)
        return natural_frequencies(engine_of(changed), angles, speed, modes=3, **options)

    coarse, fine = ((at(1 + h) - at(1 - h)) / (2 * h * value) for h in (2 * step, step))
    return (4 * fine - coarse) / 3


@pytest.mark.parametrize(
    ("prestress", "speed"), [("none", 0.0), ("none", 20.0), ("axial", 20.0), ("equilibrium", 20.0)]
)
@pytest.mark.parametrize(("key", "value"), [(THICKNESS, 1.6e-3), (LENGTH, 0.2794)])
def test_they_are_what_central_differences_tend_to(prestress, speed, key, value):
    mechanism = mechanism_with(load_mechanism(MODELS / "aluminium_fourbar.toml"), THICKNESS, 1.6e-3)
    angles = np.radians([10.0, 130.0])
    (found,) = frequency_derivatives(
        engine_of(mechanism), [key], angles, speed, modes=3, prestress=prestress
    )
    expected = differences(mechanism, key, value, angles, speed, prestress=prestress)
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())


def test_through_a_veering():
    """Where two frequencies come near and part again their slopes change places."""
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    thicknesses = np.linspace(1.6e-3, 3.2e-3, 9)
    slopes = []
    for value in thicknesses:
        changed = mechanism_with(mechanism, THICKNESS, value)
        (found,) = frequency_derivatives(
            engine_of(changed), [THICKNESS], 0.3, modes=3, prestress="none"
        )
        expected = differences(changed, THICKNESS, value, 0.3, 0.0, prestress="none")
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-6 * np.abs(expected).max())
        slopes.append(found)
    first, second = np.array(slopes)[:, :2].T
    assert first[0] > second[0]
    assert first[-1] < second[-1]


def test_a_bar_vibrates_in_proportion_to_its_thickness():
    """f of a slender clamped arm: proportional to h, to the root of E, to 1 / L^2."""
    material = Material(70e9, 2700.0)
    section = BeamSection.rectangle(material, 2e-3, 20e-3)
    arm = Mechanism(RotatingArm(0.3), {"arm": section})
    engine = engine_of(arm)
    frequency = natural_frequencies(engine, 0.0, modes=2, prestress="none")
    keys = ("links.arm.in_plane_thickness", "materials.material.youngs_modulus", "linkage.length")
    values, powers = (2e-3, 70e9, 0.3), (1.0, 0.5, -2.0)
    found = frequency_derivatives(engine, keys, 0.0, modes=2, prestress="none")
    for slope, value, power in zip(found, values, powers, strict=True):
        # Rotary inertia of the sections is what is left: (h / L)^2.
        assert value * slope / frequency == pytest.approx(power, rel=2e-3)


def test_what_is_not_stated_is_refused():
    engine = engine_of(load_mechanism(MODELS / "aluminium_fourbar.toml"))
    with pytest.raises(InputError, match=r"linkage\.coupler"):
        frequency_derivatives(engine, ["linkage.copler"], 0.0)
    with pytest.raises(InputError, match="moisture is zero here"):
        frequency_derivatives(engine, ["moisture"], 0.0)


def test_repeated_modes_part_as_their_subspace_says():
    """Of K + p S with M = 1: slopes of w^2 are the eigenvalues of S in the subspace."""
    rng = np.random.default_rng(3)
    vectors = np.linalg.qr(rng.standard_normal((4, 4)))[0]
    stiffness = vectors @ np.diag([4.0, 4.0, 9.0, 25.0]) @ vectors.T
    change = rng.standard_normal((4, 4))
    change = change + change.T
    zero = np.zeros((1, 4, 4))
    engine = engine_of(load_mechanism(MODELS / "aluminium_fourbar.toml"))
    some = engine.linear_system(0.0, prestress="none")
    system = replace(
        some, mass=np.eye(4)[None], damping=zero, stiffness=stiffness[None], unit_mass_from=None
    )
    (found,) = _derivative(system, 3, zero, zero, change[None])
    pair = vectors[:, :2]
    slopes = np.append(
        np.linalg.eigvalsh(pair.T @ change @ pair), vectors[:, 2] @ change @ vectors[:, 2]
    )
    assert found == pytest.approx(slopes / (2 * np.array([2.0, 2.0, 3.0])) / (2 * np.pi), rel=1e-9)
