"""The state of the links in one Floquet mode, against the unreduced equations of motion."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate

from flexmech import ReferenceEngine
from flexmech.dynamical_systems import floquet_modes
from flexmech.errors import InputError
from flexmech.time_domain import SampledTurn, moving_modes

SPEED, SAMPLES, STEPS = 30.0, 256, 2048
SCENARIOS = Path(__file__).parents[2] / "scenarios"


@pytest.fixture(scope="module")
def floquet_state():
    """The function of the scenarios."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(SCENARIOS))
        return importlib.import_module("_floquet_state").floquet_state


@pytest.fixture(scope="module")
def engine(aluminium):
    """A stocky linkage whose axial modes are slow enough to integrate, lightly damped."""
    sections = {
        name: replace(
            section,
            axial_stiffness=section.axial_stiffness / 400,
            bending_stiffness=section.bending_stiffness / 4,
        ).with_damping_time(1e-4)
        for name, section in aluminium.sections.items()
    }
    stocky = replace(aluminium, sections=sections)
    return ReferenceEngine(stocky, elements=1, component_modes=False)


@pytest.fixture(scope="module")
def moving(engine):
    motion = engine.mechanism.linkage.motion(2 * np.pi / SAMPLES * np.arange(SAMPLES), SPEED)
    turn = SampledTurn.of(engine, motion, engine.stressed_links(motion, "axial"), "axial", 6)
    return moving_modes(turn, turn.frames.size)


def after_a_turn(engine, start):
    """Independent coordinates and rates (2 n, k) after a turn of the unreduced equations."""
    count, size = 2880, len(start) // 2
    angle = 2 * np.pi / count * np.arange(count + 1)
    system = engine.unreduced().linear_system(angle, SPEED, prestress="axial")
    matrix = np.zeros((count + 1, 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size] = -np.linalg.solve(system.mass, system.stiffness)
    matrix[:, size:, size:] = -np.linalg.solve(system.mass, system.damping)
    matrix[-1] = matrix[0]
    spline = scipy.interpolate.CubicSpline(angle / SPEED, matrix, bc_type="periodic")
    run = scipy.integrate.solve_ivp(
        lambda t, x: (spline(t) @ x.reshape(start.shape)).ravel(),
        (0, 2 * np.pi / SPEED),
        start.ravel(),
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
    )
    return run.y[:, -1].reshape(start.shape)


def flat(state):
    return np.concatenate([*state.displacement, *state.rate])


def link_states(engine):
    """From independent coordinates and rates at crank angle zero to the links' states."""
    system = engine.unreduced().linear_system([0.0], SPEED, prestress="axial")
    frames, size = system.frames, system.size
    columns = []
    for unit in np.eye(2 * size):
        moved = frames.link_motion(
            system.motion, unit[None, :size], unit[None, size:], 0 * unit[None, :size]
        )
        columns.append(np.concatenate([*(q[0] for q, _, _ in moved), *(r[0] for _, r, _ in moved)]))
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("number", [0, pytest.param(4, marks=pytest.mark.thorough)])
def test_returns_after_a_turn_times_its_multiplier(engine, moving, floquet_state, number):
    modes = floquet_modes(moving.system(), STEPS)
    v, w = (flat(part) for part in floquet_state(moving, modes, number))
    state, to_links = np.stack([v, w], axis=1), link_states(engine)
    start = np.linalg.lstsq(to_links, state)[0]
    # Joints hold, in displacements and in rates.
    size = np.abs(state).max()
    assert np.abs(to_links @ start - state).max() < 1e-9 * size
    end = to_links @ after_a_turn(engine, start)
    multiplier = np.exp(modes.exponent[number] * modes.period)
    expected = multiplier * (v + 1j * w)
    assert np.abs(end[:, 0] + 1j * end[:, 1] - expected).max() < 1e-6 * abs(multiplier) * size


def test_greatest_displacement_is_real_and_one(engine, moving, floquet_state):
    v, w = floquet_state(moving, floquet_modes(moving.system(), STEPS))
    moved = [
        (link.shape @ (a + 1j * b)).ravel()
        for link, a, b in zip(engine.links, v.displacement, w.displacement, strict=True)
    ]
    moved = np.concatenate(moved)
    assert moved[np.abs(moved).argmax()] == pytest.approx(1.0, abs=1e-12)


def test_steps_that_miss_the_samples_are_refused(moving, floquet_state):
    modes = floquet_modes(moving.system(), 3 * SAMPLES // 2)
    with pytest.raises(InputError, match="multiple of 256 steps"):
        floquet_state(moving, modes)
