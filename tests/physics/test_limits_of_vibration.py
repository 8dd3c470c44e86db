"""Limits of small vibration: rigid links, stiff ones, damping, buckling and resonance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
    stability,
)
from flexmech.analyses import ResponseRequest

UnitArm = Callable[[float], Mechanism]
BOTH = pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])


def damped(mechanism: Mechanism, time: float) -> Mechanism:
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def drawn(kind: str, rigid: tuple[str, ...], stiff: tuple[str, ...], factor: float) -> Mechanism:
    """A four-bar or slider-crank of aluminium strips under their weight, some of them stiffer."""
    points = {"O2": (0.0, 0.0), "A": (0.0, 0.102), "B": (0.275, 0.16), "O4": (0.254, 0.0)}
    names = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    joints, ground = [PlanarJoint("O2", "clamp")], ["O2", "O4"]
    if kind == "slider-crank":
        points["B"] = (0.28, -0.02)
        joints.append(PlanarJoint("B", "slider", direction=0.0))
        del points["O4"], names["rocker"], ground[1]
    links = tuple(PlanarLink(name, ends, rigid=name in rigid) for name, ends in names.items())
    linkage = PlanarLinkage(points, links, tuple(ground), tuple(joints))
    sections = {
        name: BeamSection.rectangle(
            Material(68.9e9 * (factor if name in stiff else 1.0), 2923.0), 2.2e-3, 25.4e-3
        )
        for name in names
    }
    return Mechanism(linkage, sections, gravity=(0.0, -9.81))


@pytest.mark.parametrize(
    ("kind", "rigid", "prestress"),
    [
        ("four-bar", ("coupler",), "equilibrium"),
        ("four-bar", ("crank", "rocker"), "axial"),
        ("slider-crank", ("crank",), "equilibrium"),
        ("slider-crank", ("coupler",), "none"),
    ],
)
def test_a_rigid_link_is_the_limit_of_an_ever_stiffer_one(
    kind: str, rigid: tuple[str, ...], prestress: Any
) -> None:
    """The difference falls with the stiffness, by a hundred for a hundred."""

    def frequency(mechanism: Mechanism) -> Any:
        engine = ReferenceEngine(mechanism, 8, "euler", component_modes=False)
        return natural_frequencies(
            engine,
            np.radians([40.0, 170.0]),
            20.0,
            modes=2,
            prestress=prestress,
            rotation_terms=False,
        )

    limit = frequency(drawn(kind, rigid, (), 1.0))
    errors = [
        np.abs(frequency(drawn(kind, (), rigid, factor)) / limit - 1).max() for factor in (1e3, 1e5)
    ]
    assert errors[0] < 1.5e-2
    # The rounding of stiff links does not fall.
    assert errors[1] < 0.03 * errors[0] + 3e-5


def test_kelvin_voigt_damping_ratio_is_half_omega_tau(unit_arm: UnitArm) -> None:
    """The natural frequency is that of the undamped arm; fast modes that creep do not hide it."""
    angles, natural = [0.0], natural_frequencies(ReferenceEngine(unit_arm(70), 8), 0.0, modes=3)
    for tau, modes in ((0.02, 3), (0.06, 2)):
        engine = ReferenceEngine(damped(unit_arm(70), tau), 8)
        found = moving_frequencies(engine, angles, [0.0], modes=modes).dataset.squeeze()
        np.testing.assert_allclose(found["frequency"], natural[:modes], rtol=1e-8)
        np.testing.assert_allclose(found["damping_ratio"], np.pi * natural[:modes] * tau, rtol=1e-7)
    with pytest.raises(ComputationError, match=r"fewer than 3 .*0 deg.*lower the damping"):
        natural_frequencies(engine, 0.0, modes=3)


def test_a_rocker_like_treacle_is_not_passed_over(aluminium: Mechanism) -> None:
    """Its modes creep, and those of the other links would go on swinging."""
    sections = dict(aluminium.sections)
    sections["rocker"] = sections["rocker"].with_damping_time(0.05)
    engine = ReferenceEngine(replace(aluminium, sections=sections), 8)
    with pytest.raises(ComputationError, match=r"fewer than 4 .*ask for no more than 1"):
        natural_frequencies(engine, 2.0, modes=4)


def test_a_standing_arm_buckles_under_its_weight(unit_arm: UnitArm) -> None:
    """Greenhill's column: q L^3 = 7.837 EI."""
    arm = unit_arm(300)
    buckled, safe = (
        ReferenceEngine(replace(arm, gravity=(0.0, -weight)), 16) for weight in (7.9, 7.75)
    )
    with pytest.raises(ComputationError, match="buckles under its loads at crank angle 90"):
        natural_frequencies(buckled, np.pi / 2, modes=1)
    frequency = natural_frequencies(safe, np.pi / 2, modes=1)[0]
    assert 0 < frequency < 0.15 * 3.516 / (2 * np.pi)


@pytest.mark.parametrize(("engine", "speed"), [(ReferenceEngine, 5000.0), (ExudynEngine, 3000.0)])
def test_where_no_equilibrium_is_found_angle_speed_and_remedy_are_named(
    steel: Mechanism, engine: Any, speed: float
) -> None:
    with pytest.raises(ComputationError) as caught:
        natural_frequencies(engine(steel, 8), np.radians([0.0, 30.0]), speed)
    message = str(caught.value)
    for part in ("crank angle", f"crank speed {speed:g} rad/s", "lower the crank speed"):
        assert part in message
    assert caught.value.exit_code == 1


@BOTH
def test_an_equilibrium_far_from_the_rigid_linkage_is_refused(
    unit_arm: UnitArm, engine: Any
) -> None:
    """A soft arm hangs down by its own weight: an equilibrium, but no vibration about x."""
    limp = replace(unit_arm(1000), gravity=(0.0, -10.0))
    with pytest.raises(ComputationError, match=r"arm is displaced by \d+.* at crank angle 0 deg"):
        natural_frequencies(engine(limp, 8), 0.0)


def test_an_arm_whose_weight_turns_as_fast_as_it_vibrates_has_no_periodic_motion(
    unit_arm: UnitArm,
) -> None:
    """Critical speed ``3.51602 / sqrt(2)`` without prestress: the answer has a pole there."""
    engine = ReferenceEngine(replace(unit_arm(100.0), gravity=(0.0, -1e-4)), 4, "euler")
    critical = 3.51602 / np.sqrt(2)

    def tip(speed: float) -> float:
        """On the periodic motion, less the straight arm; the steps lag by 2e-6."""
        step = 2 * np.pi / speed / 1440
        request = ResponseRequest(
            ConstantSpeed(speed), 1.0, 36, start="periodic", step=step, prestress="none", modes=1
        )
        return float(response(engine, request).dataset["peak_deflection"].item())

    far, near, nearer = (tip(factor * critical) for factor in (0.5, 0.99, 0.995))
    assert near > 20 * far
    assert nearer / near == pytest.approx(2.0, rel=0.02)


def test_stiff_links_ask_for_the_torque_and_forces_of_rigid_ones(aluminium: Mechanism) -> None:
    sections = {
        k: replace(
            s, bending_stiffness=1e4 * s.bending_stiffness, axial_stiffness=1e4 * s.axial_stiffness
        )
        for k, s in aluminium.sections.items()
    }
    stiff = replace(aluminium, sections=sections, gravity=(0.0, -9.81))
    request = ResponseRequest(
        ConstantSpeed(20.0), 0.25, 60, start="equilibrium", prestress="axial", step=1e-4, modes=2
    )
    data = response(ReferenceEngine(stiff, 4), request).dataset.isel(engine=0)
    for name in ("driving_torque", "joint_force"):
        rigid = data[f"rigid_{name}"]
        gap = np.abs(data[name] - rigid).max()
        assert gap < 2e-3 * np.abs(rigid).max()
    assert float(data["energy_error"]) < 1e-5
    assert np.ptp(data["gravity_energy"].values) > 1e-3


def test_a_rotating_arm_under_its_weight_answers_as_in_closed_form() -> None:
    """In the arm's frame the weight turns: the first mode answers with its amplification.

    A slender arm without prestress: ``1 / (1 - (W^2 + W^2) / w^2)``, since centripetal terms
    soften it, of what its weight bends statically.
    """
    section = BeamSection.rectangle(Material(70e9, 2700.0), 4e-3, 25e-3)
    length, weight = 0.4, 1e-2
    arm = Mechanism(RotatingArm(length), {"arm": section}, gravity=(0.0, -weight))
    engine = ReferenceEngine(arm, 4, "euler", component_modes=False)
    natural = 2 * np.pi * natural_frequencies(engine, 0.0, modes=1, prestress="none")[0]
    static = section.mass_per_length * weight * length**4 / (8 * section.bending_stiffness)
    for part in (0.2, 0.5):
        speed = part * natural
        request = ResponseRequest(
            ConstantSpeed(speed),
            1.0,
            60,
            start="periodic",
            prestress="none",
            modes=1,
            step=2 * np.pi / speed / 720,
        )
        data = response(engine, request).dataset.isel(engine=0, link=0)
        bent = data["deflection"].values
        cosine = 2 * np.mean(bent[:-1] * np.cos(data["crank_angle"].values[:-1]))
        amplified = 1 / (1 - 2 * part**2)
        # Higher modes, which are not amplified, make 1.5 % of the static shape.
        assert -cosine / static == pytest.approx(amplified, rel=0.02 * amplified)


def test_a_running_arm_decays_as_its_constant_system_does(unit_arm: UnitArm) -> None:
    """Kelvin-Voigt damping in the turning frame, growth rate by the eigenvalues with speed."""
    engine = ReferenceEngine(damped(unit_arm(100.0), 0.02), 4, "euler")
    found = stability(engine, [1.0], prestress="axial", modes=1).dataset
    frozen = moving_frequencies(engine, [0.3], [1.0], modes=1, prestress="axial").dataset
    frequency, ratio = (frozen[name].values.item() for name in ("frequency", "damping_ratio"))
    assert found["growth_rate"].item() == pytest.approx(-ratio * 2 * np.pi * frequency, rel=1e-6)


def test_two_welds_of_a_rigid_link_let_it_turn_once(models: Any, tmp_path: Any) -> None:
    """Its rotation was among the component modes once for each end: a hinge between them."""
    drawn = (models / "rotating_l_beam.toml").read_text()
    first, second = drawn.index("[links.short]"), drawn.index("[joints.O2]")
    short, point = drawn[first:second], 'B = ["2000 mm", "400 mm"]'
    beyond = short.replace("links.short", "links.beyond").replace('["A", "B"]', '["B", "C"]')
    rigid = '[links.short]\npoints = ["A", "B"]\nrigid = true\nmass = "0.2 kg"\n'
    rigid += 'centre = "0.2 m"\n\n'
    drawn = drawn.replace(short, rigid + beyond)
    drawn = drawn.replace(point, f'{point}\nC = ["2400 mm", "400 mm"]')
    path = tmp_path / "welded.toml"
    path.write_text(drawn.replace("[joints.A]", '[joints.B]\nkind = "weld"\n\n[joints.A]'))
    engine = ReferenceEngine(load_mechanism(path), 3, "euler")
    request = ResponseRequest(ConstantSpeed(1.0), 0.02, 360, step=2e-3, modes=2, start="rigid")
    found, whole = (
        response(one, request).dataset["deflection"].values for one in (engine, engine.unreduced())
    )
    assert found == pytest.approx(whole, abs=2e-3 * np.abs(whole).max())
    # Its point mass has no rotary inertia, which the start on the periodic motion does not need.
    settled, whole = (
        response(one, ResponseRequest(ConstantSpeed(1.0), 0.02, 360)).dataset["deflection"].values
        for one in (engine, engine.unreduced())
    )
    assert settled == pytest.approx(whole, abs=3e-3 * np.abs(whole).max())
