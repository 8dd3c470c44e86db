"""Damping by modal strain energy in closed forms and by sensitivities; loss without a frequency."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import flexmech
from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses import natural_frequencies, strain_energy_damping
from flexmech.linkages import RotatingArm
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.sections import BeamSection, SpecificDamping
from flexmech.solvers import solve_modes
from tests.support.strategies import Running, arm, fourbar, running_mechanisms

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


def by_sensitivity(
    engine: ReferenceEngine, angle: float, speed: float, **options: Any
) -> np.ndarray:
    """Damping from how the frequencies answer to the stiffnesses.

    The part of a mode's energy that a stiffness holds is the logarithmic derivative of the
    squared frequency by it, with gyroscopic terms too: no mode shape is needed.
    """
    mechanism, step = engine.mechanism, 1e-2

    def frequencies(step: float) -> np.ndarray:
        changed = {k: stiffened(s, step) for k, s in mechanism.sections.items()}
        other = replace(mechanism, sections=changed)
        again = engine.with_(mechanism=other, element=engine.element)
        return np.log(natural_frequencies(again, angle, speed, **options))

    return (frequencies(step) - frequencies(-step)) / step / (4 * np.pi)


@pytest.mark.parametrize(
    ("make", "element"),
    [
        (ReferenceEngine, "euler"),
        (ReferenceEngine, "reddy"),
        (ExudynEngine, "geometrically-exact"),
    ],
)
def test_one_material_loses_psi_over_four_pi_in_every_mode(make: Any, element: str) -> None:
    psi = 0.08
    engine = make(losing(fourbar(), *[SpecificDamping(psi, psi, psi)] * 3), 3, element)
    ratio = strain_energy_damping(engine, [0.3, 2.0], modes=5)
    assert ratio == pytest.approx(np.full((2, 5), psi / (4 * np.pi)), rel=1e-6)


def exact_frequencies(section: BeamSection, length: float, near: np.ndarray) -> np.ndarray:
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

    def share(field: str) -> np.ndarray:
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


@settings(max_examples=4)
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


@pytest.mark.parametrize("mode", [0])
def test_kelvin_voigt_equivalent_has_the_same_damping_at_its_frequency(mode: int) -> None:
    """They agree to first order: the gap falls with the square of the damping."""
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


@pytest.mark.parametrize("element", ["timoshenko"])
def test_turning_arm_has_the_damping_of_its_complex_eigenvalues(element: str) -> None:
    mechanism = losing(arm(hub_radius=0.2), SpecificDamping(0.02, 0.01, 0.03))
    speed = 150.0
    engine = ReferenceEngine(mechanism, 4, element, False)
    ratio = strain_energy_damping(engine, 0.0, speed, modes=2)
    for mode, frequency in enumerate(natural_frequencies(engine, 0.0, speed, modes=2)):
        damped = ReferenceEngine(with_times(mechanism, frequency), 4, element, False)
        modes = solve_modes(damped.linear_system(0.0, speed), 2)
        assert modes.damping_ratio[0, mode] == pytest.approx(ratio[mode], rel=1e-6)


ALUMINIUM = flexmech.example_model("aluminium_fourbar")


def lossy(loss: float = 0.06, links: tuple[str, ...] = ("crank", "coupler", "rocker")):
    """Reference engine of the aluminium four-bar, some links with a specific damping."""
    mechanism = flexmech.load_mechanism(ALUMINIUM)
    sections = {
        name: replace(section, specific_damping=SpecificDamping(loss, loss, loss))
        if name in links
        else section
        for name, section in mechanism.sections.items()
    }
    return ReferenceEngine(replace(mechanism, sections=sections), 2, "euler")


def stated(engine: flexmech.ReferenceEngine, hertz: float) -> flexmech.ReferenceEngine:
    """The engine whose links state a damping frequency."""
    mechanism = engine.mechanism
    sections = {n: s.with_damping_frequency(hertz) for n, s in mechanism.sections.items()}
    return engine.with_(mechanism=replace(mechanism, sections=sections))


def told(result) -> str:
    """The warning of a result; empty without one."""
    found = [line for line in result.summary().warnings if "states no damping_frequency" in line]
    assert len(found) <= 1
    return "".join(found)


def test_a_run_counts_the_loss_at_the_first_frequency_and_says_so():
    engine = lossy()
    request = flexmech.analyses.ResponseRequest(
        flexmech.ConstantSpeed(20.0), revolutions=0.05, start="rigid"
    )
    result = flexmech.response(engine, request)
    turn = np.radians(np.arange(0.0, 360.0, 5.0))
    level = engine.prestress_at_rest
    first = flexmech.natural_frequencies(engine, turn, modes=1, prestress=level).mean()
    assert told(result).startswith("crank, coupler, rocker: the model states no damping_frequency")
    assert f'write damping_frequency = "{first:.4g} Hz"' in told(result)
    exact = flexmech.response(stated(engine, float(first)), request)
    assert not told(exact)
    ours, theirs = (each.dataset["deflection"].values for each in (result, exact))
    assert ours == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


@pytest.mark.parametrize(("ratio", "is_told"), [(None, True), (0.0, False)])
def test_a_stability_map_counts_the_loss_unless_a_ratio_is_given(ratio, is_told):
    result = flexmech.stability(
        lossy(), [60.0], prestress="axial", modes=2, steps=128, damping_ratio=ratio
    )
    assert bool(told(result)) == is_told
    assert (float(result.dataset["damping_ratio"].max()) > 1e-3) == is_told


def test_periodic_motions_count_the_loss():
    engine = lossy(0.3)
    assert not told(flexmech.campbell(engine, [20.0], modes=1, prestress="axial"))
    request = flexmech.analyses.ResponseRequest(20.0, 1.0, start="periodic", prestress="axial")
    moving, free = (flexmech.response(each, request) for each in (engine, lossy(0.0)))
    assert told(moving)
    assert not told(free)
    peaks, undamped = (each.peaks()["deflection"].values for each in (moving, free))
    assert np.abs(peaks / undamped - 1).max() > 1e-3


def test_an_exported_system_counts_the_loss():
    engine = flexmech.ExudynEngine(lossy().mechanism, 1)
    request = flexmech.analyses.ResponseRequest(
        flexmech.ConstantSpeed(20.0), 0.01, step=1e-4, start="rigid"
    )
    system = flexmech.exudyn_system(engine, request)
    assert "states no damping_frequency" in "".join(system.remarks)
    assert re.search(r"bendingDamping=[1-9]", system.script)
    assert not flexmech.exudyn_system(stated(engine, 45.0), request).remarks


def test_a_comparison_counts_the_loss_of_links_whose_damping_is_not_fitted():
    engine = lossy()
    frequency = np.linspace(30.0, 60.0, 18)
    column = flexmech.MeasuredQuantity(
        "receptance", "m/N", 1e-5 / (1 - (frequency / 44.0) ** 2 + 0.02j)
    )
    record = flexmech.MeasuredRecord("frequency", frequency, (column,))
    for fit, named in (
        (("gain",), "crank, coupler, rocker"),
        (("damping:coupler", "gain"), "crank, rocker"),
    ):
        line = told(flexmech.compare_with_record(engine, record, angle=0.0, fit=fit))
        assert line.partition(":")[0] == named
        assert "at the locked crank angle" in line


@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_maps_have_the_ratio_beside_each_frequency_whatever_the_reduction(prestress: str) -> None:
    mechanism = losing(fourbar(), *LOSSES)
    angles, options = np.radians([0.0, 120.0]), {"modes": 3, "prestress": prestress}
    mapped = flexmech.moving_frequencies(ReferenceEngine(mechanism, 3), angles, [20.0], **options)
    ratio = mapped.dataset["strain_energy_damping"].values[0, 0]
    whole = ReferenceEngine(mechanism, 3, component_modes=False)
    alone = strain_energy_damping(whole, angles, 20.0, **options)
    assert ratio == pytest.approx(alone, rel=1e-4)
    assert np.ptp(ratio[:, :2], axis=0).min() > 1e-4


@pytest.mark.parametrize(
    ("one", "other", "tolerance"),
    [("euler", "ancf", 1e-4), ("timoshenko", "geometrically-exact", 1e-2)],
)
def test_engines_agree(one: str, other: str, tolerance: float) -> None:
    """Exudyn's linear beam converges in second order, from 7e-3 with 16 elements."""
    mechanism = losing(fourbar(), *LOSSES)
    first = strain_energy_damping(ReferenceEngine(mechanism, 8, one), 0.5, 20.0, modes=3)
    second = strain_energy_damping(ExudynEngine(mechanism, 16, other), 0.5, 20.0, modes=3)
    assert second == pytest.approx(first, rel=tolerance)


def test_a_hammer_finds_the_loss_of_the_first_mode_at_each_angle() -> None:
    """By the modes' own strain energy, which knows no frequency."""
    engine, angle = lossy(0.3, ("crank",)), np.radians([0.0, 60.0])
    result = flexmech.hammer_test(engine, flexmech.analyses.HammerRequest(angle, modes=1))
    expected = strain_energy_damping(engine, angle, modes=1)[:, 0]
    ratio = result.dataset["eigen_damping_ratio"].values[:, 0]
    assert ratio == pytest.approx(expected, rel=1e-2)
    assert expected[1] < 0.6 * expected[0]
    first = natural_frequencies(engine, angle, modes=1)[:, 0]
    assert f"counts at {first.min():.4g} to {first.max():.4g} Hz" in told(result)


@pytest.mark.parametrize("said", ['damping_time = "0 s"', 'damping_frequency = "60 Hz"'])
def test_what_a_model_states_of_its_damping_is_left_alone(said: str) -> None:
    text = lossy().mechanism.to_toml()
    heads = [
        line for line in text.splitlines() if line.startswith("[links.") and line.count(".") == 1
    ]
    for head in heads:
        text = text.replace(head, f"{head}\n{said}")
    engine = flexmech.ReferenceEngine(mechanism_from_toml(text), 2)
    request = flexmech.analyses.ResponseRequest(
        flexmech.ConstantSpeed(20.0), revolutions=0.02, start="rigid"
    )
    assert not told(flexmech.response(engine, request))


def test_damping_of_maps_is_refused_where_no_section_tells_a_loss() -> None:
    engine = ReferenceEngine(fourbar(damping_time=1e-6), 2)
    found = flexmech.moving_frequencies(engine, [0.0], [0.0])
    assert "strain_energy_damping" not in found.dataset
    with pytest.raises(flexmech.InputError, match="no section of this mechanism has specific"):
        strain_energy_damping(engine, 0.0)
