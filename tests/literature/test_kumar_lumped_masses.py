"""Twelve lumped masses in the place of distributed ones (Kumar & Chandrakar, Figure 1.5).

The steel mechanism at crank angle 0 and 20 rad/s: beyond the middle of the coupler the tension is
3.52 N by the lumped masses; in its middle 3.76 N by the distributed mass.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from typer.testing import CliRunner

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    InputError,
    ReferenceEngine,
    example_model,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from flexmech.beams.elements import BEAM_SHAPES, BeamElements
from flexmech.cli import app
from flexmech.linear_system import element_tensions
from flexmech.linkages import lumped_elements
from tests.support.strategies import arm

STEEL = load_mechanism(example_model("steel_fourbar"))
LUMPED = ReferenceEngine(STEEL, 8, mass="lumped")
SPEED = 20.0


def test_the_paper_has_one_element_of_the_crank_and_four_of_the_others() -> None:
    assert lumped_elements(STEEL.linkage.topology) == (1, 4, 4)
    assert LUMPED.lumped_mass_count == 12
    # An arm leads nothing, and an L-beam is one body.
    assert lumped_elements(arm().linkage.topology) == (4,)
    beam = load_mechanism(example_model("rotating_l_beam"))
    assert lumped_elements(beam.linkage.topology) == (4, 4)


@pytest.mark.parametrize("name", ["rotating_l_beam", "slider_crank", "watt_six_bar"])
def test_linkages_with_welds_sliders_and_rigid_links(name: str) -> None:
    """Lumps change their first two frequencies by less than 3 %, and change them."""
    mechanism = load_mechanism(example_model(name))
    speed = mechanism.operating_speeds[0]
    lumped, distributed = (
        natural_frequencies(ReferenceEngine(mechanism, 8, "euler", mass=mass), 1.0, speed, modes=2)
        for mass in ("lumped", "distributed")
    )
    change = np.abs(lumped / distributed - 1)
    assert change.max() < 0.03
    assert change.max() > 1e-4


def test_tension_in_the_middle_of_the_coupler() -> None:
    motion = STEEL.linkage.motion([0.0], SPEED)
    distributed = STEEL.inverse_dynamics(motion).axial_force(1, 0.1397)
    lumped = STEEL.inverse_dynamics(motion, lumped=(1, 4, 4))
    assert distributed == pytest.approx(3.76, abs=0.01)
    assert lumped.axial_force(1, 0.14) == pytest.approx(3.52, abs=0.005)
    # The engine's elements carry the same, constant between the lumps.
    tensions = element_tensions(STEEL, LUMPED.nodes, motion, lumped)[1][0]
    assert tensions[4:6, 0] == pytest.approx([3.52, 3.52], abs=0.005)
    assert tensions[:, 1:] == pytest.approx(0.0, abs=1e-6)
    # Half a lump's inertia force to both sides of it: neither value is the middle's.
    assert tensions[3:5, 0].mean() == pytest.approx(3.79, abs=0.01)


def test_the_loads_at_nodes_are_those_of_eqs_1_64_and_1_65() -> None:
    motion = STEEL.linkage.motion([0.7], SPEED)
    loads = LUMPED.stressed_links(motion, "axial").loads
    coupler, nodes = loads[1][0].reshape(-1, 3), LUMPED.nodes[1]
    mass = STEEL.link_mass("coupler")
    angle = motion.angle[0, 1]
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    expected = np.zeros_like(coupler)
    for x, lump in mass.lumps(4):
        node = int(np.argmin(np.abs(nodes - x)))
        expected[node, :2] = -lump * axes @ motion.acceleration(1, x)[0]
    assert coupler == pytest.approx(expected, abs=1e-13)


def test_lumped_cantilever_against_its_flexibility() -> None:
    """Massless beam: f(a, b) = a^2 (3 b - a) / (6 EI) between lumps at a <= b."""
    mechanism = arm()
    section, length = mechanism.sections["arm"], 1.0
    place = length * np.arange(1, 5) / 4
    masses = section.mass_per_length * length * np.array([1, 1, 1, 0.5]) / 4
    near, far = np.minimum.outer(place, place), np.maximum.outer(place, place)
    flexibility = near**2 * (3 * far - near) / (6 * section.bending_stiffness)
    dynamic = np.sqrt(masses)[:, None] * flexibility * np.sqrt(masses)
    exact = np.sort(1 / np.sqrt(scipy.linalg.eigvalsh(dynamic))) / (2 * np.pi)
    found = natural_frequencies(ReferenceEngine(mechanism, 8, mass="lumped"), 0.0, modes=4)
    assert found == pytest.approx(exact, rel=1e-9)


def test_four_bar_at_rest_against_an_assembly_of_its_own() -> None:
    """One Hermite element between lumps is exact; pins tie displacements, not rotations."""
    motion = STEEL.linkage.motion(0.0)
    numbers: dict[tuple[str, int], int] = {}

    def coordinate(joint: str, component: int) -> int:
        return numbers.setdefault((joint, component), len(numbers))

    blocks = []
    ends = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    for link, (name, joints) in enumerate(ends.items()):
        mass, count = STEEL.link_mass(name), (1, 4, 4)[link]
        lengths = np.full(count, mass.length / count)
        local = BeamElements(BEAM_SHAPES["euler"], STEEL.sections[name], lengths).stiffness
        c, s = np.cos(motion.angle[link]), np.sin(motion.angle[link])
        turn = scipy.linalg.block_diag(*[np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])] * 2)
        nodes = [joints[0], *(f"{name}{n}" for n in range(1, count)), joints[1]]
        for n in range(count):
            # A pin joins displacements; each link has its own rotation there.
            places = [
                coordinate(node if i < 2 else f"{name} {node}", i)
                for node in nodes[n : n + 2]
                for i in range(3)
            ]
            blocks.append((places, turn.T @ local[n] @ turn))
        for n, (_, lump) in enumerate(mass.lumps(count)):
            places = [coordinate(nodes[n], 0), coordinate(nodes[n], 1)]
            blocks.append((places, lump))
    size = len(numbers)
    stiffness, inertia = np.zeros((size, size)), np.zeros(size)
    for places, value in blocks:
        if np.ndim(value):
            stiffness[np.ix_(places, places)] += value
        else:
            inertia[places] += value
    held = [numbers[key] for key in [("O2", 0), ("O2", 1), ("O4", 0), ("O4", 1), ("crank O2", 2)]]
    free = np.setdiff1d(np.arange(size), held)
    flexibility = np.linalg.inv(stiffness[np.ix_(free, free)])
    root = np.sqrt(inertia[free])
    values = scipy.linalg.eigvalsh(root[:, None] * flexibility * root)[::-1][:4]
    exact = 1 / np.sqrt(values) / (2 * np.pi)
    for elements in (4, 8):
        engine = ReferenceEngine(STEEL, elements, mass="lumped")
        assert natural_frequencies(engine, 0.0, modes=4) == pytest.approx(exact, rel=1e-8)


def test_frequencies_at_rest_and_at_speed() -> None:
    """As the table of docs/theory/prestress.md has it, without rotation terms."""
    rest, running = (
        natural_frequencies(LUMPED, 0.0, speed, modes=3, prestress="axial", rotation_terms=False)
        for speed in (0.0, SPEED)
    )
    assert rest == pytest.approx([60.681, 127.594, 163.679], abs=1e-3)
    assert running == pytest.approx([60.761, 127.773, 163.633], abs=1e-3)


def test_lumps_tend_to_the_distributed_mass() -> None:
    """By twice as many elements, as K's own lumps have them, errors fall by four."""
    exact = natural_frequencies(ReferenceEngine(STEEL, 16, "euler"), 0.0, modes=2)
    motion, errors = STEEL.linkage.motion([0.0], SPEED), []
    for times in (1, 2, 4):
        lumped = STEEL.inverse_dynamics(motion, lumped=[times * n for n in (1, 4, 4)])
        errors.append(lumped.driving_torque - STEEL.inverse_dynamics(motion).driving_torque)
    assert errors[0] == pytest.approx(4 * errors[1], rel=1e-6)
    assert errors[1] == pytest.approx(4 * errors[2], rel=1e-6)
    assert np.all(natural_frequencies(LUMPED, 0.0, modes=2) < exact)


@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
def test_every_level_of_prestress(prestress: str) -> None:
    found, finer = (
        natural_frequencies(
            ReferenceEngine(STEEL, n, mass="lumped"), [0.0, 1.0], SPEED, prestress=prestress
        )
        for n in (8, 16)
    )
    assert np.all(np.isfinite(found))
    assert found == pytest.approx(finer, rel=1e-4)


def test_the_command_says_so(tmp_path) -> None:
    options = ["--speeds", "0,20", "--angles", "0,60", "--elements", "4", "--out", str(tmp_path)]
    command = ["frequencies", str(example_model("steel_fourbar")), "--mass", "lumped", *options]
    done = CliRunner().invoke(app, [*command, "--engine", "reference", "--no-plots", "--details"])
    assert done.exit_code == 0, done.stderr
    assert "mass: 12 lumped masses in the reference engine" in done.stdout
    refused = CliRunner().invoke(app, [*command, "--engine", "exudyn"])
    assert refused.exit_code == InputError.exit_code
    assert "--mass lumped is a choice of the reference engine" in refused.stderr


def test_distributed_mass_stands_beside_it() -> None:
    engines = [LUMPED, ExudynEngine(STEEL, 8)]
    data = moving_frequencies(engines, [0.0], [0.0], modes=2).dataset
    assert data["element"].values.tolist() == ["euler, lumped masses", "ancf"]
    assert data.attrs["lumped_masses"] == 12
    lumped, distributed = data["frequency"].sel(mode=1).values.ravel()
    assert (lumped, distributed) == pytest.approx((60.681, 62.025), abs=5e-3)


def test_what_lumped_masses_are_not_for_is_refused() -> None:
    with pytest.raises(InputError, match="lumped masses are for natural frequencies"):
        response(LUMPED, ResponseRequest(ConstantSpeed(SPEED), revolutions=0.1))
    with pytest.raises(InputError, match="mass of the exudyn engine must be one of distributed"):
        ExudynEngine(STEEL, mass="lumped")
    with pytest.raises(InputError, match="9 were asked for, the model has 8"):
        natural_frequencies(ReferenceEngine(arm(), mass="lumped"), 0.0, modes=9)


def test_an_engine_of_lumped_masses_is_another_one() -> None:
    assert ReferenceEngine(STEEL, 8) != LUMPED
    assert "lumped masses" in repr(LUMPED)
    again = LUMPED.with_(mass="distributed")
    assert again == ReferenceEngine(STEEL, 8)
    assert again.lumped_mass_count == 0


def test_the_error_of_lumped_masses_is_that_against_distributed_ones() -> None:
    """A finer mesh does not move these frequencies: the distributed mass says what they miss."""
    engine = ReferenceEngine(STEEL, 4, mass="lumped")
    data = moving_frequencies(engine, np.radians([0.0, 60.0]), [0.0, SPEED], modes=3).dataset
    assert data["discretisation_error"].max() < 1e-6
    lumped = data["frequency"].sel(engine="reference").values
    exact = [
        natural_frequencies(
            ReferenceEngine(STEEL, 16, component_modes=False), data["crank_angle"], speed, modes=3
        )
        for speed in (0.0, SPEED)
    ]
    missed = np.abs(np.array(exact) / lumped - 1)
    told = data["lumping_error"].sel(engine="reference").values
    assert told == pytest.approx(missed, rel=1e-3, abs=1e-6)
    # Table of docs/theory/prestress.md: 2 % of the first and 4 % of the third at crank angle 0.
    assert told[0, 0] == pytest.approx([0.0221, 0.0015, 0.0425], abs=1e-4)
    # 200.6 Hz where Exudyn finds 232.7.
    assert told[1, 1, 2] == pytest.approx(0.160, abs=1e-3)


def test_the_engine_to_trust_is_the_one_whose_mass_is_distributed() -> None:
    engines = [ReferenceEngine(STEEL, 8, mass="lumped"), ExudynEngine(STEEL, 8)]
    said = moving_frequencies(engines, np.radians([0.0, 60.0]), [SPEED], modes=3).summary()
    assert "differ by at most 1.60e-01 of the frequency" in said.details[-1]
    assert "within their estimated errors (1.6e-01 of reference and " in said.details[-1]
    assert said.details[-1].endswith("; trust exudyn: the masses of reference are lumped")
    line = "error of lumped masses: at most 1.6e-01 of the frequency, reference at 20 rad/s, 60 deg"
    assert any(each.startswith(line) for each in said.lines)


def test_no_error_of_lumped_masses_is_told_of_distributed_ones() -> None:
    result = moving_frequencies(ReferenceEngine(STEEL, 4), [0.0], [0.0], modes=2)
    assert "lumping_error" not in result.dataset
    assert not any("lumped" in line for line in result.summary().lines)
