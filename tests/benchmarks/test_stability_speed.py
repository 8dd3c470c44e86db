"""Speed of Floquet multipliers against a general integrator on the unreduced equations."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
import scipy.linalg

from flexmech import ReferenceEngine
from flexmech.dynamical_systems import floquet_modes
from flexmech.solvers import SampledTurn, counts_of_modes, moving_modes
from flexmech.threads import one_thread

SPEED = 60.0
STEPS = 320
ACCURACY = 1e-6
# Part of a turn that the integrator runs, for one solution of the 144 that span all.
PART = 0.05


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def multipliers(engine, steps=STEPS):
    """Floquet multipliers of all moving modes, from the engine on."""
    angle = 2 * np.pi / 128 * np.arange(128)
    motion = engine.mechanism.linkage.motion(angle, SPEED)
    turn = SampledTurn.of(engine, motion, engine.stressed_links(motion, "axial"), "axial", 6)
    moving = moving_modes(turn, counts_of_modes(turn, 6, 1)[0])
    modes = floquet_modes(moving.system(), steps)
    return np.exp(modes.exponent * modes.period)


def unreduced(engine):
    """Matrix of the first-order system as a function of time, and a start in the first mode."""
    angle = np.linspace(0, 2 * np.pi, 721)
    system = engine.unreduced().linear_system(angle, SPEED, prestress="axial")
    size = system.size
    matrix = np.zeros((len(angle), 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size] = -np.linalg.solve(system.mass, system.stiffness)
    matrix[:, size:, size:] = -np.linalg.solve(system.mass, system.damping)
    matrix[-1] = matrix[0]
    _, modes = scipy.linalg.eigh(system.stiffness[0], system.mass[0])
    start = np.concatenate([modes[:, 0] / np.abs(modes[:, 0]).max(), np.zeros(size)])
    return scipy.interpolate.CubicSpline(angle / SPEED, matrix, bc_type="periodic"), start


def test_multipliers_against_solve_ivp(aluminium, against):
    """A stiff code of the same relative tolerance, for one solution alone."""
    sections = {k: s.with_damping_time(2e-5) for k, s in aluminium.sections.items()}
    engine = ReferenceEngine(replace(aluminium, sections=sections), elements=8)
    gaps = np.abs(multipliers(engine)[:, None] - multipliers(engine, 2 * STEPS))
    assert gaps.min(axis=1).max() < ACCURACY
    matrix, start = unreduced(engine)

    def integrated():
        return scipy.integrate.solve_ivp(
            lambda t, x: matrix(t) @ x,
            (0, PART * 2 * np.pi / SPEED),
            start,
            method="Radau",
            jac=lambda t, x: matrix(t),
            rtol=ACCURACY,
            atol=1e-9,
        )

    assert integrated().success
    ratio = against(
        "Floquet multipliers, 8 elements, axial: against solve_ivp, one solution of 144",
        lambda: multipliers(engine),
        integrated,
        plain_rounds=1,
        plain_covers=PART,
    )
    assert ratio > 50
