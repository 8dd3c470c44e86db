"""Links that stretch by the square of their slopes: strains, energy, steps and what they answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexmech import ReferenceEngine, load_mechanism
from flexmech.analyses.response.plan import lowest_axial_frequency
from flexmech.dynamical_systems import LowPass, parabolic_work, step_operators
from flexmech.dynamical_systems.lobatto import MARCH_ON, WEIGHTS
from flexmech.linkages import ConstantSpeed, JointSpring
from flexmech.time_domain import DrivenLinkage, linear_run, static_balance, step_lag
from flexmech.time_domain.integrators import stretch_march as march_module
from flexmech.time_domain.integrators.linear_march import StepTable
from flexmech.time_domain.integrators.position_table import PositionTable
from flexmech.time_domain.integrators.stage_operators import stage_operators


@pytest.fixture(scope="module")
def linkage(aluminium):
    return DrivenLinkage(ReferenceEngine(aluminium), ConstantSpeed(20.0), stretches=True)


def part_of_a_turn(linkage, steps=2880, turns=0.1):
    period, nothing = linkage.drive.revolution_time, np.zeros(linkage.size)
    time = turns * period * np.linspace(0.0, 1.0, 41)
    return linear_run(linkage, nothing, nothing, time, period / steps)


def test_a_link_that_turns_does_not_stretch(aluminium):
    """It comes nearer by (1 - cos) of its angle: what is left is of the fourth order."""
    engine = ReferenceEngine(aluminium)
    link, stretch = engine.links[1], engine.stretches[1]

    def energy(angle):
        q = np.sin(angle) * link.fields.tangential + (np.cos(angle) - 1) * link.fields.centripetal
        linear = stretch.gradient @ q
        return float(stretch.energy(q[None])[0] + linear @ linear / 2)

    straight = float(np.sum((stretch.gradient @ link.fields.centripetal) ** 2)) / 2
    strains = [np.sqrt(energy(angle) / straight) for angle in (0.02, 0.04)]
    assert strains[0] < 0.02**4
    assert np.log2(strains[1] / strains[0]) == pytest.approx(4.0, abs=0.1)


def test_forces_are_the_gradient_of_the_energy(linkage):
    random = np.random.default_rng(0)
    for stretch in linkage.stretch.links:
        size = stretch.gradient.shape[1]
        q = 1e-2 * random.normal(size=(1, size))
        force = stretch.nonlinear_forces(q, 0 * q)[0][0]
        slope = np.imag(stretch.energy(q + 1e-30j * np.eye(size))) / 1e-30
        assert force == pytest.approx(slope, rel=1e-10, abs=1e-10 * np.abs(force).max())


def test_forces_one_by_one_are_those_of_the_links(linkage):
    """In spread coordinates, with damping, as the steps take them."""
    random = np.random.default_rng(1)
    time = np.array([0.01, 0.07])
    motion = linkage.motion(time)
    z, v = 1e-3 * random.normal(size=(2, 2, linkage.size))
    turns = linkage.stretch.pin_rotations(motion)
    parts = linkage.frames.link_motion(motion, z, v, 0 * z)
    forces = [
        sum(stretch.nonlinear_forces(q, rate))
        for stretch, (q, rate, _) in zip(linkage.stretch.links, parts, strict=True)
    ]
    expected = linkage.frames.gather(motion, forces)
    found = linkage.stretch.nonlinear_forces(turns, z, v)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())


def test_work_of_the_shaft_is_energy(linkage):
    """With the fourth order of the step, where what is fast is not shaken from the start."""
    time = 0.1 * linkage.drive.revolution_time * np.linspace(0.0, 1.0, 10)
    equations = linkage.quasi_static_equations(np.zeros(1))
    still = static_balance(linkage, equations.quasi_static()[0])
    pulled, tangent = linkage.stretch.static_force(
        linkage.stretch.pin_rotations(equations.motion), still
    )
    gap = equations.force[0] - equations.stiffness[0] @ still - pulled
    left = np.linalg.solve(equations.stiffness[0] + tangent, gap)
    assert np.abs(left).max() < 1e-12 * np.abs(still).max()
    coarse, fine = (
        linear_run(linkage, still, 0 * still, time, linkage.drive.revolution_time / steps)
        for steps in (720, 1440)
    )
    coarse, fine = coarse.energy_error, fine.energy_error
    assert fine < 1e-6
    assert coarse / fine == pytest.approx(16.0, rel=0.3)


def test_a_free_vibration_lags_by_the_fourth_power_of_the_step():
    """Its step is the diagonal Pade approximation (2, 2) of the exponential function."""
    for angle in (0.2, 0.4, 3.0, 300.0):
        # H^2 z'' = -angle^2 z at both stages of a double step, from both states at its start.
        start = np.array([[1.0, 0.0], [0.0, angle], [-(angle**2), 0.0]])
        by_start, by_stages = MARCH_ON[:, 2, :3], MARCH_ON[:, 2, 3:]
        stages = np.linalg.solve(by_stages + angle**2 * np.eye(2), -by_start @ start)
        end = MARCH_ON[-1] @ np.concatenate([start, stages])
        turned = np.linalg.eigvals(end[:2] / [[1.0], [angle]])
        pade = np.roots([1 / 12, 1 / 2, 1.0]), np.roots([1 / 12, -1 / 2, 1.0])
        expected = np.prod(1j * angle - pade[0]) / np.prod(1j * angle - pade[1])
        assert np.abs(turned) == pytest.approx([1.0, 1.0], abs=1e-9)
        assert np.abs(turned - expected).min() < 1e-9
        if angle < 1:
            lag = 1 - np.abs(np.angle(turned[0])) / angle
            assert lag == pytest.approx(step_lag(angle / 2, stretches=True), rel=0.02)


def test_both_ways_of_solving_a_step_agree(linkage, monkeypatch):
    usual = part_of_a_turn(linkage)
    monkeypatch.setattr(march_module, "PASSES", ())
    newton = part_of_a_turn(linkage)
    for first, second in zip(usual.displacement, newton.displacement, strict=True):
        assert np.abs(first - second).max() < 5e-4 * np.abs(second).max()
    monkeypatch.setattr(march_module, "PASSES", (6,))
    for first, second in zip(
        part_of_a_turn(linkage).displacement, newton.displacement, strict=True
    ):
        assert np.abs(first - second).max() < 1e-6 * np.abs(second).max()


RUN_UP = ConstantSpeed(20.0, run_up_time=0.1)
TIMES = np.array([0.05, 0.0999, 0.1001, 0.13, 0.2, 0.41])


def test_interpolated_stages_are_those_solved_one_by_one(aluminium):
    linkage = DrivenLinkage(ReferenceEngine(aluminium), RUN_UP, stretches=True)
    step = 1e-4

    def solve(time):
        stages = np.column_stack([time - step, time]).ravel()
        rows = stage_operators(linkage.equations(stages), linkage.stretch, 2 * step)
        return [rows.resistance, rows.force, rows.compliance, rows.relaxation, rows.turns.turn]

    table = PositionTable(linkage, solve, reach=step)
    for found, expected in zip(table.at(TIMES), solve(TIMES), strict=True):
        assert np.abs(found - expected).max() < 3e-6 * np.abs(expected).max()


def test_interpolated_steps_are_those_solved_one_by_one(aluminium):
    linkage, time = DrivenLinkage(ReferenceEngine(aluminium), RUN_UP), TIMES
    linear, expansion = StepTable(linkage, 1e-4).rows(time)
    equations = linkage.equations(time)
    direct = step_operators(equations, 1e-4)
    for found, expected in (
        (linear.advance, direct.advance),
        (linear.forced, direct.forced),
        (expansion.matrix, equations.expansion.matrix),
    ):
        # Measured 2e-7; 1.4e-6 of the forces by a stress that is itself a cubic spline.
        assert np.abs(found - expected).max() < 3e-6 * np.abs(expected).max()


def test_lowest_axial_frequency_of_a_clamped_bar(arm_along_itself):
    """A quarter of a wave: sqrt(E / rho) / (4 L)."""
    mechanism, speed_of_sound, length = arm_along_itself
    found = lowest_axial_frequency(ReferenceEngine(mechanism, 32), np.zeros(1))
    assert found == pytest.approx(speed_of_sound / (4 * length), rel=1e-3)


def test_a_bearing_holds_where_links_vibrate_along_themselves(aluminium):
    """Its joint came apart: a truss that nothing held had the frequency zero, and runs failed."""
    sprung = replace(aluminium, joint_springs=(JointSpring("B", radial_stiffness=1e5),))
    turn = np.linspace(0.0, 2 * np.pi, 9)
    found, held = (lowest_axial_frequency(ReferenceEngine(m), turn) for m in (sprung, aluminium))
    assert found == pytest.approx(held, rel=1e-12)


@pytest.fixture
def arm_along_itself(models):
    mechanism = load_mechanism(models / "rotating_arm.toml")
    section = mechanism.sections["arm"]
    length = mechanism.linkage.topology.links[0].length
    return mechanism, np.sqrt(section.axial_stiffness / section.mass_per_length), length


def test_low_pass_keeps_its_band_and_cuts_twice_the_band():
    step, band = 1e-4, 400.0
    time = step * np.arange(4000)
    for frequency, gain in ((20.0, 1.0), (400.0, 1.0), (800.0, 0.0), (3000.0, 0.0)):
        passed = filtered(np.cos(2 * np.pi * frequency * time)[:, None], band, step, 4000)[:, 0]
        expected = gain * np.cos(2 * np.pi * frequency * time)
        inside = slice(100, -100)
        assert np.abs(passed[inside] - expected[inside]).max() < 2.5e-3


def test_powers_are_integrated_as_the_stages_are():
    """Of a cubic up to each end exactly, of a parabola also up to each middle."""
    step, time = 0.1, 0.1 * np.arange(7)
    work = parabolic_work(step, np.stack([time**2, time**3]))
    assert work[0] == pytest.approx(time**3 / 3, abs=1e-12)
    assert work[1, ::2] == pytest.approx(time[::2] ** 4 / 4, abs=1e-12)


def test_what_no_double_step_resolves_does_not_pass_for_slow():
    """A stiff vibration is 1 at the ends and -1/2 in the middles: on the mean of both, 1/4."""
    values = np.where(np.arange(4000) % 2, -0.5, 1.0)[:, None]
    slow = np.cos(2 * np.pi * 150.0 * 1e-4 * np.arange(4000))[:, None]
    inside = slice(100, -100)
    assert np.abs(filtered(values, 400.0, 1e-4, 4000)[inside] - 0.25).max() < 1e-3
    assert np.abs(filtered(values, 400.0, 1e-4, 999, WEIGHTS)[inside]).max() < 1e-3
    assert np.abs(filtered(slow, 400.0, 1e-4, 999, WEIGHTS) - slow)[inside].max() < 2.5e-3


def test_low_pass_takes_a_history_in_pieces():
    values = np.random.default_rng(0).normal(size=(997, 3))
    whole = filtered(values, 300.0, 1e-4, 997)
    assert len(whole) == 997
    for piece in (1, 50, 400):
        assert filtered(values, 300.0, 1e-4, piece) == pytest.approx(whole, abs=1e-12)
    # A step too long for frequencies beyond the band leaves all as it is.
    untouched = LowPass(4000.0, 1e-4)
    assert untouched.add(values) is values
    assert not untouched.finish().size


def filtered(values, band, step, piece, weights=(1.0,)):
    low_pass = LowPass(band, step, weights)
    parts = [low_pass.add(values[i : i + piece]) for i in range(0, len(values), piece)]
    return np.concatenate([*parts, low_pass.finish()])


def test_a_rigid_link_that_is_welded_at_both_ends_turns_once(tmp_path, models):
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
    engine, lowest = ReferenceEngine(load_mechanism(path), 3, "euler"), []
    for each in (engine, engine.unreduced()):
        equations = DrivenLinkage(each, ConstantSpeed(3.0), stretches=True).equations(np.zeros(1))
        values = scipy.linalg.eigh(equations.stiffness[0], equations.mass[0], eigvals_only=True)
        lowest.append(values[:3])
    assert lowest[0] == pytest.approx(lowest[1], rel=1e-4)
