"""Speed of the frequency maps, model building included, one thread.

The plain loops get the unreduced matrices for nothing; where they would take minutes they
run over every tenth or thirtieth position and are scaled up (`plain_covers`).
"""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from flexmech import ExudynEngine, ReferenceEngine, load_mechanism, moving_frequencies
from flexmech.analyses import FrequencyRequest
from flexmech.analyses.frequencies.frequency_map import frequencies_along, systems_at
from flexmech.mechanics import RotationTerms
from flexmech.solvers import Formulation, solve_frequencies
from flexmech.threads import one_thread

ANGLES = np.radians(np.arange(361.0))
SPEEDS = np.array([0.0, 10.0, 20.0])
MODES = 6


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def state_matrix_frequencies(mass, damping, stiffness):
    """Plain solution of the quadratic eigenproblem at one position."""
    size = len(mass)
    companion = np.block(
        [
            [np.zeros((size, size)), np.eye(size)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)],
        ]
    )
    values = scipy.linalg.eig(companion)[0]
    return np.sort(np.abs(values[values.imag > 0]))[:MODES] / (2 * np.pi)


def frequency_map(engine, request):
    """Frequencies without tracking or error estimates, (S, A, modes)."""
    return [
        frequencies_along(systems_at(engine, request, speed), request.crank_angles, speed)
        for speed in request.crank_speeds.tolist()
    ]


def rest():
    return FrequencyRequest(ANGLES, [0.0], Formulation("none", False, MODES))


def test_rest_against_plain_eigh(aluminium, against):
    system = ReferenceEngine(aluminium, 8).unreduced().linear_system(ANGLES)
    against(
        "rest: 361 frequencies against loop of scipy.linalg.eigh",
        lambda: frequency_map(ReferenceEngine(aluminium, 8), rest()),
        lambda: [
            scipy.linalg.eigh(k, m) for k, m in zip(system.stiffness, system.mass, strict=True)
        ],
    )


def test_rest_against_plain_assembly_and_eigh(aluminium, against):
    engine = ReferenceEngine(aluminium, 8).unreduced()

    def loop():
        for angle in ANGLES[::10]:
            system = engine.linear_system(angle)
            scipy.linalg.eigh(system.stiffness[0], system.mass[0])

    against(
        "rest: the same, matrices assembled one by one in the loop",
        lambda: frequency_map(ReferenceEngine(aluminium, 8), rest()),
        loop,
        plain_covers=len(ANGLES[::10]) / len(ANGLES),
    )


@pytest.mark.parametrize("positions", [361, 1_000, 10_001])
def test_rest_against_reduced_eigvalsh(aluminium, against, positions):
    angles = np.linspace(0.0, 2 * np.pi, positions)
    request = FrequencyRequest(angles, [0.0], Formulation("none", False, MODES))
    system = ReferenceEngine(aluminium, 8).linear_system(angles, modes=MODES, detail=1.0)
    lower = np.linalg.inv(np.linalg.cholesky(system.mass))
    standard = lower @ system.stiffness @ np.swapaxes(lower, 1, 2)
    against(
        f"rest: {positions} frequencies against eigvalsh of the reduced stack",
        lambda: frequency_map(ReferenceEngine(aluminium, 8), request),
        lambda: np.linalg.eigvalsh(standard),
        plain_rounds=7,
    )


def test_rest_tracked_with_errors(aluminium, against):
    system = ReferenceEngine(aluminium, 8).unreduced().linear_system(ANGLES)
    against(
        "rest: tracked, with mode shapes and error estimates",
        lambda: moving_frequencies(ReferenceEngine(aluminium, 8), ANGLES, [0.0], modes=MODES),
        lambda: [
            scipy.linalg.eigh(k, m) for k, m in zip(system.stiffness, system.mass, strict=True)
        ],
    )


@pytest.mark.parametrize("rotation_terms", [False, True])
@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_three_speeds(aluminium, against, prestress, rotation_terms):
    """Against a plain loop that assembles, finds the equilibrium and solves one by one."""
    request = FrequencyRequest(ANGLES, SPEEDS, Formulation(prestress, rotation_terms, MODES))
    plain = ReferenceEngine(aluminium, 8).unreduced()
    every = 30

    def loop():
        for speed in SPEEDS:
            for angle in ANGLES[::every]:
                system = plain.linear_system(
                    angle,
                    speed,
                    prestress=prestress,
                    rotation_terms=RotationTerms.all_or_none(rotation_terms),
                )
                mass, damping, stiffness = (
                    m[0] for m in (system.mass, system.damping, system.stiffness)
                )
                if rotation_terms and speed:
                    state_matrix_frequencies(mass, damping, stiffness)
                else:
                    scipy.linalg.eigh(stiffness, mass)

    against(
        f"{prestress}, {'with' if rotation_terms else 'no'} rotation terms, 3 speeds",
        lambda: frequency_map(ReferenceEngine(aluminium, 8), request),
        loop,
        rounds=3,
        plain_rounds=2,
        plain_covers=len(ANGLES[::every]) / len(ANGLES),
    )


@pytest.mark.parametrize("detail", [1.0, 4.0, None], ids=["usual", "fine", "unreduced"])
def test_exudyn_against_its_own_eigenvalues(aluminium, against, detail):
    """Positions at rest of the moved model against mbs.ComputeODE2Eigenvalues, one by one.

    With the fine reduction the first six frequencies are equal to 1e-8, as they are
    without any (tests/engines/test_exudyn_by_itself.py).
    """
    engine = ExudynEngine(aluminium, 8, component_modes=detail is not None)
    angles = ANGLES[::5]
    against(
        f"Exudyn at rest, component modes {detail or 'off'}, against its own",
        lambda: solve_frequencies(
            engine.linear_system(angles, modes=MODES, detail=detail or 1.0), MODES
        ),
        engine.model.assembly.mbs.ComputeODE2Eigenvalues,
        plain_covers=1 / len(angles),
    )


def test_exudyn_equilibrium(aluminium, against):
    """Moving, static solution, linearization, link frames and eigenvalues of a position."""
    engine = ExudynEngine(aluminium, 8)
    angles = ANGLES[::10]
    against(
        "Exudyn at equilibrium, 20 rad/s, against its own at rest",
        lambda: solve_frequencies(
            engine.linear_system(angles, 20.0, modes=MODES, detail=1.0), MODES
        ),
        engine.model.assembly.mbs.ComputeODE2Eigenvalues,
        plain_covers=1 / len(angles),
    )


@pytest.mark.parametrize("elements", [8, 32])
def test_damped_composite_at_rest(against, models, elements):
    """Plies of several damping times, in component modes and in all coordinates."""
    engine = ReferenceEngine(load_mechanism(models / "composite_fourbar.toml"), elements)
    angles = ANGLES[::60]
    against(
        f"damped composite at rest, {elements} elements, against unreduced",
        lambda: moving_frequencies(engine, angles, [0.0]),
        lambda: moving_frequencies(engine.unreduced(), angles, [0.0]),
        rounds=1,
        plain_rounds=1,
    )


def test_damped_map_against_undamped(aluminium, against):
    """Damping asks for the general eigenproblem at rest too, and for the errors of the ratios."""
    sections = {n: s.with_damping_time(1e-4) for n, s in aluminium.sections.items()}
    damped = ReferenceEngine(replace(aluminium, sections=sections), 8)
    against(
        "damped map, 3 speeds, against undamped",
        lambda: moving_frequencies(damped, ANGLES[::5], SPEEDS),
        lambda: moving_frequencies(ReferenceEngine(aluminium, 8), ANGLES[::5], SPEEDS),
        rounds=3,
    )


@pytest.mark.parametrize("elements", [8, 16])
def test_deep_bow(aluminium, against, elements):
    """Damped and so fast that the links bow deeply: sections turn against the axis."""
    sections = {n: s.with_damping_time(3e-4) for n, s in aluminium.sections.items()}
    engine = ReferenceEngine(replace(aluminium, sections=sections), elements)
    against(
        f"damped, deeply bowed at 45 rad/s, {elements} elements, against unreduced",
        lambda: moving_frequencies(engine, ANGLES[::5], [45.0]),
        lambda: moving_frequencies(engine.unreduced(), ANGLES[::5], [45.0]),
        rounds=1,
        plain_rounds=1,
    )


def test_split_of_the_drawn_speed(aluminium, against):
    """The effect of speed by term, at the greatest speed against at all three."""
    engine = ReferenceEngine(aluminium, 8)
    against(
        "effect of speed by term: the drawn speed against every speed",
        lambda: moving_frequencies(engine, ANGLES[::5], SPEEDS, speed_effect="fastest"),
        lambda: moving_frequencies(engine, ANGLES[::5], SPEEDS, speed_effect=True),
        rounds=3,
    )
