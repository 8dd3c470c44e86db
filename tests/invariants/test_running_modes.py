"""Floquet multipliers of running linkages: reciprocal, whatever the frame, sense and steps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.integrate
import scipy.interpolate
from numpy.typing import NDArray

from flexmech import (
    ExudynEngine,
    JointSpring,
    Load,
    Mechanism,
    ReferenceEngine,
    Spring,
    load_mechanism,
    stability,
)
from flexmech.linkages import GROUND, AttachmentPoint
from tests.support.results import FRAME
from tests.support.running_modes import (
    distance,
    exponents,
    forward,
    frozen_eigenvalues,
    multipliers,
)

ComplexArray = NDArray[np.complex128]


def damped(mechanism: Mechanism, time: float) -> Mechanism:
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "kind", "speed", "prestress"),
    [
        ("aluminium", ReferenceEngine, 60.0, "axial"),
        ("steel", ReferenceEngine, -20.0, "equilibrium"),
        ("aluminium", ExudynEngine, 20.0, "axial"),
    ],
)
def test_moduli_of_an_undamped_linkage_are_one_whatever_the_steps(
    mechanisms: dict[str, Mechanism], name: str, kind: Any, speed: float, prestress: Any
) -> None:
    """Its monodromy matrix is symplectic, and the trace of the system vanishes."""
    engine = kind(mechanisms[name], 4)
    for steps in (None, 1024):
        data = stability(engine, [speed], modes=4, prestress=prestress, steps=steps).dataset
        assert np.abs(data["log_modulus"].values).max() < 1e-8
        assert data["liouville_defect"].item() < 1e-10
        # Each pair of a mode has signatures of both signs.
        signature = data["krein_signature"].values.reshape(-1, 2)
        assert signature.sum(axis=1) == pytest.approx(np.zeros(4), abs=1e-6)


@pytest.mark.thorough
def test_moduli_inside_a_band_are_reciprocal(aluminium: Mechanism) -> None:
    """Where the aluminium linkage grows, near 87 rad/s with axial forces."""
    found = stability(ReferenceEngine(aluminium, 4), [87.0], modes=4, prestress="axial").dataset
    log = np.sort(found["log_modulus"].values.ravel())
    assert log[-1] > 0.1
    assert log == pytest.approx(-log[::-1], abs=1e-9)
    assert found["unstable"].item() == "yes"


@pytest.mark.parametrize(
    ("kind", "prestress", "time"),
    [
        (ExudynEngine, "axial", 0.0),
        pytest.param(ReferenceEngine, "axial", 2e-5, marks=pytest.mark.thorough),
        pytest.param(ReferenceEngine, "equilibrium", 0.0, marks=pytest.mark.thorough),
    ],
)
def test_multipliers_are_those_of_ground_axes(
    aluminium: Mechanism, kind: Any, prestress: Any, time: float
) -> None:
    """Frozen eigenvalues depend on the frame, those of a whole turn do not."""
    engine = kind(damped(aluminium, time), 4)
    link, ground = (
        multipliers(engine, -60.0, 2, prestress=prestress, frame=frame)
        for frame in ("link", "inertial")
    )
    assert distance(ground, link) < 1e-7


@pytest.mark.thorough
@pytest.mark.parametrize("time", [0.0, 2e-5])
def test_a_mirrored_linkage_that_runs_backwards_is_the_same(
    aluminium: Mechanism, time: float
) -> None:
    """A linkage that runs backwards has the adjoint equations in reversed time."""
    plain = damped(aluminium, time)
    mirrored = replace(plain, linkage=replace(plain.linkage, branch="crossed"))
    first, *others = (
        multipliers(ReferenceEngine(mechanism, 4), speed, 3, prestress="axial")
        for mechanism, speed in ((plain, 40.0), (mirrored, -40.0), (plain, -40.0))
    )
    for other in others:
        assert distance(first, other) < 1e-7


@pytest.mark.parametrize(("speed", "time"), [(30.0, 2e-4), (-30.0, 0.0)])
def test_a_rotating_arm_has_the_eigenvalues_of_its_constant_system(
    models: Any, speed: float, time: float
) -> None:
    engine = ReferenceEngine(damped(load_mechanism(models / "rotating_arm.toml"), time), 4)
    found = exponents(engine, speed, 3)
    expected = forward(frozen_eigenvalues(engine, speed), 3)
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-6)


def soft(mechanism: Mechanism, time: float) -> Mechanism:
    """A stocky linkage whose axial modes are slow enough to integrate: EA / 400, EI / 4."""
    sections = {
        k: replace(
            s, axial_stiffness=s.axial_stiffness / 400, bending_stiffness=s.bending_stiffness / 4
        )
        for k, s in mechanism.sections.items()
    }
    return damped(replace(mechanism, sections=sections), time)


def with_connectors(mechanism: Mechanism) -> Mechanism:
    """A force that turns with the rocker, a spring with a damper, a damper and a sprung pin."""
    rocker, ground = AttachmentPoint("rocker", 0.2667), AttachmentPoint(GROUND, 0.5, 0.1)
    return replace(
        mechanism,
        loads=(Load("turns", rocker, ((-0.3, 0.2),), (0.002,), axes="link"),),
        springs=(
            Spring("back", rocker, ground, 50.0, 0.1, 0.2),
            Spring("between", AttachmentPoint("crank", 0.0), rocker, 0.0, 0.2, 0.3),
        ),
        joint_springs=(JointSpring("B", 0.05, 2e-3, 1.0),),
    )


def integrated_multipliers(engine: Any, speed: float, prestress: Any) -> ComplexArray:
    """Multipliers of a turn of ``M z'' + C z' + K z = 0`` by an explicit Runge-Kutta code.

    In all coordinates of the link frames, with all rotation terms; the matrices between the
    crank angles by periodic cubic splines.
    """
    count = 1440
    angle = 2 * np.pi / count * np.arange(count + 1)
    system = engine.unreduced().linear_system(angle, speed, prestress=prestress)
    size = system.mass.shape[-1]
    matrix = np.zeros((count + 1, 2 * size, 2 * size))
    matrix[:, :size, size:] = np.eye(size)
    matrix[:, size:, :size] = -np.linalg.solve(system.mass, system.stiffness)
    matrix[:, size:, size:] = -np.linalg.solve(system.mass, system.damping)
    matrix[-1] = matrix[0]
    spline = scipy.interpolate.CubicSpline(angle / speed, matrix, bc_type="periodic")

    def rate(t: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
        return (spline(t) @ x.reshape(2 * size, -1)).ravel()

    run = scipy.integrate.solve_ivp(
        rate, (0, 2 * np.pi / speed), np.eye(2 * size).ravel(), method="DOP853", rtol=1e-9
    )
    return np.asarray(np.linalg.eigvals(run.y[:, -1].reshape(2 * size, -1)))


@pytest.mark.parametrize(
    ("time", "prestress", "connected"),
    [
        pytest.param(5e-5, "axial", False, marks=pytest.mark.thorough),
        pytest.param(0.0, "equilibrium", False, marks=pytest.mark.thorough),
        pytest.param(0.0, "axial", True, marks=pytest.mark.thorough),
        pytest.param(5e-5, "equilibrium", "frame", marks=pytest.mark.thorough),
    ],
)
def test_multipliers_are_those_of_the_second_order_equations_in_time(
    aluminium: Mechanism, time: float, prestress: Any, *, connected: bool | str
) -> None:
    """Canonical form, Fourier series and Magnus expansion against rotation terms written out."""
    mechanism = soft(aluminium, time)
    if connected == "frame":
        mechanism = replace(mechanism, frame=FRAME, gravity=(0.0, -9.81))
    elif connected:
        mechanism = with_connectors(mechanism)
    engine = ReferenceEngine(mechanism, elements=1, component_modes=False)
    found = multipliers(engine, 30.0, 12 if mechanism.frame else 9, prestress=prestress)
    expected = integrated_multipliers(engine, 30.0, prestress)
    assert len(found) == len(expected)
    assert distance(found, expected) < 1e-5
    if time:
        # Far from where they would be without damping, so that its terms count.
        assert np.abs(found).max() < 0.9


@pytest.mark.thorough
def test_engines_agree_on_a_running_linkage_with_dampers_and_a_force_that_follows(
    aluminium: Mechanism,
) -> None:
    mechanism = with_connectors(aluminium)
    first, second = (
        exponents(engine, 40.0, 3, "equilibrium")
        for engine in (
            ReferenceEngine(mechanism, 6, "euler"),
            ExudynEngine(mechanism, 6, "ancf"),
        )
    )
    gap = first - second
    turned = gap.imag - 40.0 * np.round(gap.imag / 40.0)
    assert (np.hypot(gap.real, turned) / np.abs(first)).max() < 1e-4
    assert (first.real < -1.0).any()


@pytest.mark.thorough
def test_the_periodic_motion_is_the_same_whichever_way_the_shaft_turns(
    aluminium: Mechanism,
) -> None:
    """Without damping; its distance from the equilibrium, and its residual."""
    data = [
        stability(ReferenceEngine(aluminium, 2), [speed], prestress="trajectory", modes=2).dataset
        for speed in (20.0, -20.0)
    ]
    there, back = (each["orbit_distance"].item() for each in data)
    assert there == pytest.approx(back, rel=1e-6)
    assert 0.01 < there < 0.2
    assert max(each["orbit_residual"].item() for each in data) < 1e-8


@pytest.mark.thorough
def test_a_band_is_named_by_the_modes_that_meet_and_their_signatures_differ(
    aluminium: Mechanism,
) -> None:
    """A principal one: twice the frequency of mode 2 is 7 times the crank's."""
    engine = ReferenceEngine(aluminium, 2)
    found = stability(engine, [84.0, 87.0, 90.0], modes=2, prestress="axial")
    bands = found.dataset.isel(band=0)
    names = bands["band_kind"].item(), bands["band_branches"].item(), int(bands["band_order"])
    assert names == ("principal", "2", 7)
    signs = np.sign([bands["band_first_signature"].item(), bands["band_second_signature"].item()])
    assert sorted(signs.tolist()) == [-1.0, 1.0]
    assert found.growth().set_index("crank_speed_rad_s")["unstable"].tolist() == [
        *("no", "yes", "no")
    ]
