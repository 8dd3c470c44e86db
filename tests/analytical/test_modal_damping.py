"""Damping by modal strain energy against closed forms, frequencies' sensitivity and decay."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech.analyses import natural_frequencies, solve_modes, strain_energy_damping
from flexmech.linear_system import Engine
from flexmech.linkages import ConstantSpeed, RotatingArm
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, SpecificDamping
from flexmech.time_domain import DrivenLinkage, linear_run
from tests.support.strategies import Running, arm, fourbar, running_mechanisms

FloatArray = NDArray[np.float64]
STIFFNESS = {
    "axial": "axial_stiffness",
    "bending": "bending_stiffness",
    "shear": "shear_stiffness",
}
LOSSES = (
    SpecificDamping(0.02, 0.05, 0.3),
    SpecificDamping(0.1, 0.07, 0.2),
    SpecificDamping(0.0, 0.01, 0.4),
)


def losing(mechanism: Mechanism, *losses: SpecificDamping) -> Mechanism:
    """With the specific damping of each link, in the topology's order."""
    names = mechanism.linkage.topology.link_names
    return replace(
        mechanism,
        sections={
            name: replace(mechanism.sections[name], specific_damping=loss)
            for name, loss in zip(names, losses, strict=True)
        },
    )


def stiffened(section: BeamSection, step: float) -> BeamSection:
    """Each stiffness multiplied by exp(step psi), with its own psi."""
    loss = section.specific_damping
    assert loss is not None
    return replace(
        section,
        **{
            field: np.exp(step * getattr(loss, kind)) * getattr(section, field)
            for kind, field in STIFFNESS.items()
        },
    )


def by_sensitivity(engine: Engine, angle: float, speed: float, **options: Any) -> FloatArray:
    """Damping from how the frequencies answer to the stiffnesses.

    The part of a mode's energy that a stiffness holds is the logarithmic derivative of the
    squared frequency by it, with gyroscopic terms too: no mode shape is needed.
    """
    mechanism, step = engine.mechanism, 1e-2

    def frequencies(step: float) -> FloatArray:
        changed = {k: stiffened(s, step) for k, s in mechanism.sections.items()}
        other = replace(mechanism, sections=changed)
        again = engine.with_(mechanism=other, element=engine.element)
        return np.log(natural_frequencies(again, angle, speed, **options))

    return (frequencies(step) - frequencies(-step)) / step / (4 * np.pi)


@pytest.mark.parametrize("psi", [1e-3, 0.08])
@pytest.mark.parametrize(
    ("make", "element"),
    [
        (ReferenceEngine, "euler"),
        (ReferenceEngine, "timoshenko"),
        (ReferenceEngine, "reddy"),
        (ExudynEngine, "ancf"),
        (ExudynEngine, "geometrically-exact"),
    ],
)
def test_one_material_loses_psi_over_four_pi_in_every_mode(
    make: type[Engine], element: str, psi: float
) -> None:
    engine = make(losing(fourbar(), *[SpecificDamping(psi, psi, psi)] * 3), 3, element)
    ratio = strain_energy_damping(engine, [0.3, 2.0], modes=5)
    assert ratio == pytest.approx(np.full((2, 5), psi / (4 * np.pi)), rel=1e-6)


def test_slender_arm_of_euler_loses_what_bending_loses() -> None:
    engine = ReferenceEngine(losing(arm(), SpecificDamping(0.5, 0.02, 0.9)), 6, "euler")
    ratio = strain_energy_damping(engine, 0.0, modes=4)
    assert ratio == pytest.approx(np.full(4, 0.02 / (4 * np.pi)), rel=1e-9)


def exact_frequencies(section: BeamSection, length: float, near: FloatArray) -> FloatArray:
    """Angular frequencies of a clamped-free Timoshenko beam, without discretisation.

    The state (v, phi, M, V) is carried from end to end by a matrix exponential; the free end
    is free where its forces by those of the clamped end have no determinant.
    """

    def free_end(frequency: float) -> float:
        transfer = np.array(
            [
                [0.0, 1.0, 0.0, 1 / section.shear_stiffness],
                [0.0, 0.0, 1 / section.bending_stiffness, 0.0],
                [0.0, -section.rotary_inertia * frequency**2, 0.0, -1.0],
                [-section.mass_per_length * frequency**2, 0.0, 0.0, 0.0],
            ]
        )
        return float(np.linalg.det(scipy.linalg.expm(length * transfer)[2:, 2:]))

    return np.array([brentq(free_end, 0.99 * w, 1.01 * w, xtol=1e-9, rtol=1e-13) for w in near])


def test_thick_timoshenko_arm_weighs_bending_and_shear_by_their_energies() -> None:
    section = BeamSection.rectangle(Material(40e9, 1800.0, 0.3), 0.2, 0.02)
    section = replace(section, shear_stiffness=section.shear_stiffness / 5)
    loss = SpecificDamping(0.5, 0.03, 0.2)
    mechanism = losing(Mechanism(RotatingArm(1.0), {"arm": section}), loss)
    engine = ReferenceEngine(mechanism, 32, "timoshenko", component_modes=False)
    system = engine.linear_system(0.0)
    modes = solve_modes(system, 6)
    # The arm's own vibrations along it are no solutions of the bending beam.
    sideways = np.abs(system.displacements(modes.vectors)[0, ..., 1]).max(axis=(1, 2))
    across = np.flatnonzero(sideways > 1e-6)[:3]
    near = 2 * np.pi * modes.frequency[0, across]

    def share(field: str) -> FloatArray:
        step, size = 1e-4, getattr(section, field)
        high, low = (
            np.log(exact_frequencies(replace(section, **{field: f * size}), 1.0, near))
            for f in (np.exp(step), np.exp(-step))
        )
        return (high - low) / step

    bending, shear = share("bending_stiffness"), share("shear_stiffness")
    assert bending + shear == pytest.approx(np.ones(3), abs=1e-6)
    assert (shear > 0.05).all()
    ratio = strain_energy_damping(engine, 0.0, modes=6)[across]
    expected = (loss.bending * bending + loss.shear * shear) / (4 * np.pi)
    assert ratio == pytest.approx(expected, rel=1e-5)


@settings(max_examples=10)
@given(running_mechanisms(), st.sampled_from([(False, 2e-4), (True, 5e-3)]))
def test_each_link_counts_by_its_part_of_the_energy(
    running: Running, terms: tuple[bool, float]
) -> None:
    """At speed, with tension, three links of different loss; see by_sensitivity.

    The frames' angular accelerations make the stiffness unsymmetric, which moves the
    sensitivity, not the energy, by another order of the speed.
    """
    rotation_terms, tolerance = terms
    options: dict[str, Any] = {"prestress": "axial", "rotation_terms": rotation_terms}
    engine = ReferenceEngine(losing(running.mechanism, *LOSSES), 2, "euler", False)
    place = running.crank_angle, running.crank_speed
    frequency = natural_frequencies(engine, *place, modes=4, **options)
    gap = np.diff(frequency) / frequency[:-1]
    apart = np.minimum(gap, np.append(np.inf, gap[:-1])) > 0.05
    ratio = strain_energy_damping(engine, *place, modes=3, **options)
    expected = by_sensitivity(engine, *place, modes=3, **options)
    assert ratio[apart] == pytest.approx(expected[apart], rel=tolerance)
    assert (ratio <= 0.1 / (4 * np.pi)).all()


@pytest.mark.parametrize("rotation_terms", [False, True])
def test_tension_and_turning_frames_store_energy_without_loss(rotation_terms: bool) -> None:
    mechanism = losing(arm(hub_radius=0.2), SpecificDamping(0.04, 0.04, 0.04))
    section = replace(mechanism.sections["arm"], neutral_axis=2e-3)
    engine = ReferenceEngine(replace(mechanism, sections={"arm": section}), 5, "timoshenko", False)
    options: dict[str, Any] = {
        "modes": 3, "prestress": "axial", "rotation_terms": rotation_terms,
    }  # fmt: skip
    at_rest, at_speed = (strain_energy_damping(engine, 0.0, s, **options) for s in (0.0, 150.0))
    assert at_rest == pytest.approx(np.full(3, 0.01 / np.pi), rel=1e-8)
    assert (at_speed < 0.99 * at_rest).all()
    assert at_speed[0] < 0.5 * at_rest[0]
    assert at_speed == pytest.approx(by_sensitivity(engine, 0.0, 150.0, **options), rel=1e-5)


def with_times(mechanism: Mechanism, frequency: float) -> Mechanism:
    return replace(
        mechanism,
        sections={k: s.with_damping_frequency(frequency) for k, s in mechanism.sections.items()},
    )


@pytest.mark.parametrize("mode", [0, 2])
def test_kelvin_voigt_equivalent_has_the_same_damping_at_its_frequency(mode: int) -> None:
    """To first order: the gap falls with the square of the damping."""
    gaps = []
    for scale in (1.0, 0.5):
        losses = [
            SpecificDamping(scale * a.axial, scale * a.bending, scale * a.shear) for a in LOSSES
        ]
        mechanism = losing(fourbar(), *losses)
        engine = ReferenceEngine(mechanism, 4, "timoshenko", False)
        ratio = strain_energy_damping(engine, 0.7, modes=3)[mode]
        frequency = natural_frequencies(engine, 0.7, modes=3)[mode]
        damped = ReferenceEngine(with_times(mechanism, frequency), 4, "timoshenko", False)
        modes = solve_modes(damped.linear_system(0.7), 3)
        gaps.append(modes.damping_ratio[0, mode] / ratio - 1)
    assert abs(gaps[0]) < 1e-3
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("element", ["euler", "timoshenko"])
def test_turning_arm_has_the_damping_of_its_complex_eigenvalues(element: str) -> None:
    mechanism = losing(arm(hub_radius=0.2), SpecificDamping(0.02, 0.01, 0.03))
    speed = 150.0
    engine = ReferenceEngine(mechanism, 4, element, False)
    ratio = strain_energy_damping(engine, 0.0, speed, modes=2)
    for mode, frequency in enumerate(natural_frequencies(engine, 0.0, speed, modes=2)):
        damped = ReferenceEngine(with_times(mechanism, frequency), 4, element, False)
        modes = solve_modes(damped.linear_system(0.0, speed), 2)
        assert modes.damping_ratio[0, mode] == pytest.approx(ratio[mode], rel=1e-6)


def test_running_four_bar_has_what_damping_adds_to_its_frozen_eigenvalues() -> None:
    """Turning frames alone give an undamped linkage some frozen damping; not counted here."""
    mechanism, place = losing(fourbar(), *LOSSES), (1.0, 20.0)
    engine = ReferenceEngine(mechanism, 4, component_modes=False)
    ratio = strain_energy_damping(engine, *place, modes=3)
    undamped = solve_modes(engine.linear_system(*place), 3).damping_ratio[0]
    for mode, frequency in enumerate(natural_frequencies(engine, *place, modes=3)):
        damped = ReferenceEngine(with_times(mechanism, frequency), 4, component_modes=False)
        added = solve_modes(damped.linear_system(*place), 3).damping_ratio[0] - undamped
        assert added[mode] == pytest.approx(ratio[mode], rel=5e-4)
    assert np.abs(undamped).max() > 1e-5


def test_free_decay_has_the_logarithmic_decrement() -> None:
    """Ten periods of a slowly turning arm let go in its first mode."""
    mechanism = losing(arm(), SpecificDamping(0.03, 0.03, 0.03))
    engine, speed = ReferenceEngine(mechanism, 4), 0.5
    frequency = float(natural_frequencies(engine, 0.0, speed, modes=1)[0])
    ratio = float(strain_energy_damping(engine, 0.0, speed, modes=1)[0])
    damped = ReferenceEngine(with_times(mechanism, frequency), 4)
    linkage = DrivenLinkage(damped, ConstantSpeed(speed), modes=1)
    start = linkage.equations(np.zeros(1))
    shape = scipy.linalg.eigh(start.stiffness[0], start.mass[0])[1][:, 0]
    step = 1 / (200 * frequency)
    time = step * np.arange(10 * 200 + 1)
    loaded, still = (
        linear_run(linkage, position, np.zeros(linkage.size), time, step)
        for position in (shape, 0.0 * shape)
    )
    last = engine.links[0].end[1]
    decay = loaded.displacement[0][:, last] - still.displacement[0][:, last]
    decrement = np.log(decay[0] / decay[-1]) / 10
    assert decrement == pytest.approx(2 * np.pi * ratio, rel=5e-4)
