"""Twelve lumped masses in the place of distributed ones (Kumar & Chandrakar, Figure 1.5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    FourBar,
    InputError,
    PointMass,
    ReferenceEngine,
    example_model,
    kinematics,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
)
from flexmech.analyses import KinematicsRequest, ResponseRequest
from tests.support.strategies import arm, fourbar

STEEL = load_mechanism(example_model("steel_fourbar"))
LUMPED = ReferenceEngine(STEEL, 8, mass="lumped")
SPEED = 20.0
TURN = np.radians(np.arange(0, 360, 15.0))
R2, R3, R4 = 0.1, 0.2794, 0.2667
MASS = 7800.0 * 6.1e-3 * 4.25e-3 * np.array([R2, R3, R4])


@pytest.mark.parametrize("alpha2", [0.0, -150.0])
def test_the_twelve_masses_and_their_forces_are_the_papers(alpha2: float) -> None:
    """Places d4 to d11; eqs. 1.64 and 1.65; joint forces are what they ask for, and the torque."""
    asked = KinematicsRequest(SPEED, crank_angles=TURN, lumped=(1, 4, 4), crank_acceleration=alpha2)
    data = kinematics(STEEL, asked).dataset
    places = [0, R2, 0, 69.85e-3, 139.7e-3, 209.55e-3, R3, 0, 66.675e-3, 133.35e-3, 200.025e-3, R4]
    assert data["lump_position"].values == pytest.approx(places)
    halves = np.array([0.5, 0.5, *[1 / 8, 1 / 4, 1 / 4, 1 / 4, 1 / 8] * 2])
    masses = halves * np.repeat(MASS, [2, 5, 5])
    assert data["lump_mass"].values == pytest.approx(masses, rel=1e-12)
    motion = STEEL.linkage.motion(TURN, SPEED, alpha2)
    links = np.repeat([0, 1, 2], [2, 5, 5])
    power, total = np.zeros(len(TURN)), np.zeros((len(TURN), 2))
    for number, (link, x) in enumerate(zip(links, places, strict=True)):
        force = -masses[number] * motion.acceleration(link, x)
        of_lump = data["lump_inertia_force"].isel(lump=number).transpose("crank_angle", ...)
        assert of_lump.values == pytest.approx(force, abs=1e-11)
        power -= np.sum(force * motion.velocity(link, x), axis=-1)
        total += force
    ground = data["lumped_joint_force"].sel(joint=["O2", "O4"]).sum("joint")
    assert ground.values == pytest.approx(-total, abs=1e-10)
    assert data["lumped_driving_power"].values == pytest.approx(power, abs=1e-10)


def test_lumps_tend_to_the_distributed_mass_with_the_square_of_their_number() -> None:
    """Joint forces and torque; point masses of the model stay where they are.

    Points have no rotary inertia, which is next to nothing in these sections.
    """
    mechanism = fourbar(joint_masses={"B": 0.3}, link_masses=(PointMass("rocker", 0.1, 0.2),))
    lines = {
        name: replace(section, rotary_inertia=1e-18, layers=None)
        for name, section in mechanism.sections.items()
    }
    mechanism = replace(mechanism, sections=lines)
    errors = []
    for times in (1, 2, 4):
        lumps = tuple(times * n for n in (2, 4, 4))
        data = kinematics(mechanism, SPEED, crank_angles=TURN, lumped=lumps).dataset
        errors.append(
            np.concatenate(
                [
                    (data[f"lumped_{name}"] - data[name]).values.ravel()
                    for name in ("joint_force", "driving_torque")
                ]
            )
        )
    assert np.abs(errors[0]).max() > 1e-3
    assert errors[0] == pytest.approx(4 * errors[1], abs=1e-5 * np.abs(errors[0]).max())
    assert errors[1] == pytest.approx(4 * errors[2], abs=1e-5 * np.abs(errors[0]).max())


def test_tension_in_the_middle_of_the_coupler() -> None:
    """At crank angle 0: 3.52 N beyond its middle by lumps, 3.76 N by the distributed mass."""
    motion = STEEL.linkage.motion([0.0], SPEED)
    distributed = STEEL.inverse_dynamics(motion).axial_force(1, 0.1397)
    lumped = STEEL.inverse_dynamics(motion, lumped=(1, 4, 4)).axial_force(1, 0.14)
    assert (distributed.item(), lumped.item()) == pytest.approx((3.76, 3.52), abs=0.01)


def test_frequencies_of_a_lumped_cantilever_are_those_of_its_flexibility() -> None:
    """Massless beam: f(a, b) = a^2 (3 b - a) / (6 EI) between lumps at a <= b."""
    mechanism = arm()
    section = mechanism.sections["arm"]
    place = np.arange(1, 5) / 4
    masses = section.mass_per_length * np.array([1, 1, 1, 0.5]) / 4
    near, far = np.minimum.outer(place, place), np.maximum.outer(place, place)
    flexibility = near**2 * (3 * far - near) / (6 * section.bending_stiffness)
    dynamic = np.sqrt(masses)[:, None] * flexibility * np.sqrt(masses)
    exact = np.sort(1 / np.sqrt(scipy.linalg.eigvalsh(dynamic))) / (2 * np.pi)
    engine = ReferenceEngine(mechanism, 8, mass="lumped")
    assert natural_frequencies(engine, 0.0, modes=4) == pytest.approx(exact, rel=1e-9)
    with pytest.raises(InputError, match="9 were asked for, the model has 8"):
        natural_frequencies(ReferenceEngine(mechanism, mass="lumped"), 0.0, modes=9)


def hermite(stiffness: float, axial: float, length: float) -> np.ndarray:
    """Stiffness of one element of (u, v, phi) at both ends."""
    el, b = length, 12 * stiffness / length**3
    bend = b * np.array(
        [
            [1, el / 2, -1, el / 2],
            [el / 2, el**2 / 3, -el / 2, el**2 / 6],
            [-1, -el / 2, 1, -el / 2],
            [el / 2, el**2 / 6, -el / 2, el**2 / 3],
        ]
    )
    found = np.zeros((6, 6))
    found[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bend
    found[np.ix_([0, 3], [0, 3])] = axial / length * np.array([[1, -1], [-1, 1]])
    return found


def test_a_lumped_four_bar_at_rest_is_an_assembly_by_hand() -> None:
    """One Hermite element between lumps is exact; pins tie displacements, not rotations."""
    linkage = STEEL.linkage
    assert isinstance(linkage, FourBar)
    angles, numbers = linkage.motion(0.0).angle, {}
    blocks: list[tuple[list[int], np.ndarray]] = []
    lumps: list[tuple[list[int], float]] = []

    def coordinate(*of: object) -> int:
        return numbers.setdefault(of, len(numbers))

    ends = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    for link, (name, (first, last)) in enumerate(ends.items()):
        count, total = (1, 4, 4)[link], STEEL.link_mass(name).moment(0)
        section, length = STEEL.sections[name], linkage.lengths[name] / count
        local = hermite(section.bending_stiffness, section.axial_stiffness, length)
        c, s = np.cos(angles[link]), np.sin(angles[link])
        turn = scipy.linalg.block_diag(*[np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])] * 2)
        nodes = [first, *(f"{name}{n}" for n in range(1, count)), last]
        at = [[coordinate(node, 0), coordinate(node, 1)] for node in nodes]
        spin = [coordinate(name, node) for node in nodes]
        for n in range(count):
            places = [*at[n], spin[n], *at[n + 1], spin[n + 1]]
            blocks.append((places, turn.T @ local @ turn))
        shares = np.array([0.5, *[1.0] * (count - 1), 0.5]) / count
        lumps += [(place, total * share) for place, share in zip(at, shares, strict=True)]
    stiffness, inertia = np.zeros((len(numbers),) * 2), np.zeros(len(numbers))
    for places, block in blocks:
        stiffness[np.ix_(places, places)] += block
    for places, lump in lumps:
        inertia[places] += lump
    held = [numbers[key] for key in (("O2", 0), ("O2", 1), ("O4", 0), ("O4", 1), ("crank", "O2"))]
    free = np.setdiff1d(np.arange(len(numbers)), held)
    root = np.sqrt(inertia[free])
    flexibility = root[:, None] * np.linalg.inv(stiffness[np.ix_(free, free)]) * root
    exact = 1 / np.sqrt(scipy.linalg.eigvalsh(flexibility)[::-1][:4]) / (2 * np.pi)
    assert natural_frequencies(LUMPED, 0.0, modes=4) == pytest.approx(exact, rel=1e-8)


def test_frequencies_at_rest_and_at_speed_are_those_of_the_manual() -> None:
    """Without rotation terms, under axial forces, at crank angle 0; in Hz."""
    rest, running = (
        natural_frequencies(LUMPED, 0.0, speed, modes=3, prestress="axial", rotation_terms=False)
        for speed in (0.0, SPEED)
    )
    assert rest == pytest.approx([60.681, 127.594, 163.679], abs=1e-3)
    assert running == pytest.approx([60.761, 127.773, 163.633], abs=1e-3)


def test_the_stated_error_of_lumped_masses_is_that_against_distributed_ones() -> None:
    """2 % of the first and 4 % of the third frequency at crank angle 0."""
    engine = ReferenceEngine(STEEL, 4, mass="lumped")
    result = moving_frequencies(engine, np.radians([0.0, 60.0]), [0.0, SPEED], modes=3)
    data = result.dataset
    assert data["discretisation_error"].max() < 1e-6
    fine = ReferenceEngine(STEEL, 16, component_modes=False)
    exact = [natural_frequencies(fine, data["crank_angle"], v, modes=3) for v in (0.0, SPEED)]
    missed = np.abs(np.array(exact) / data["frequency"].sel(engine="reference").values - 1)
    told = data["lumping_error"].sel(engine="reference").values
    assert told == pytest.approx(missed, rel=1e-3, abs=1e-6)
    assert told[0, 0] == pytest.approx([0.0221, 0.0015, 0.0425], abs=1e-4)
    plain = moving_frequencies(engine.with_(mass="distributed"), [0.0], [0.0], modes=2)
    assert "lumping_error" not in plain.dataset


def test_lumps_of_a_link_beside_its_pins_move_as_they_lie() -> None:
    """Their accelerations are second differences of their places, here those of an offset link."""
    mechanism = load_mechanism(example_model("composite_fourbar"))
    offset = mechanism.link_mass("coupler").offset
    assert abs(offset) > 1e-5
    step = 1e-4
    angles = 0.7 + step * np.arange(-2, 3)
    data = kinematics(mechanism, SPEED, crank_angles=angles, lumped=(2, 2, 2)).dataset
    motion = mechanism.linkage.motion(angles)
    number = int(np.flatnonzero(data["lump_link"].values == "coupler")[1])
    place = motion.position(1, float(data["lump_position"][number]), offset)
    second = np.array([-1, 16, -30, 16, -1]) / 12 * (SPEED / step) ** 2 @ place
    lump = data["lump_acceleration"].isel(lump=number).transpose("crank_angle", ...)
    assert lump.values[2] == pytest.approx(second, rel=1e-5)


def test_lumped_masses_are_for_frequencies_of_the_reference_engine_alone() -> None:
    with pytest.raises(InputError, match="lumped masses are for natural frequencies"):
        response(LUMPED, ResponseRequest(ConstantSpeed(SPEED), revolutions=0.1, start="rigid"))
    with pytest.raises(InputError, match="mass of the exudyn engine"):
        ExudynEngine(STEEL, mass="lumped")
