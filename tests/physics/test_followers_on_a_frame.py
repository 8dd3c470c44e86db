"""Follower forces on the links of a linkage whose frame is on springs: they rotate with it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigvals, expm
from scipy.optimize import newton

import flexmech
from flexmech.linkages import AttachmentPoint
from tests.support.sprung_frame_data import framed_file, on_springs, sprung, stiffened

ENGINES = flexmech.ReferenceEngine, flexmech.ExudynEngine
TURN = 2 * np.pi / 20.0
FOLLOWER = flexmech.Load(
    "f", AttachmentPoint("coupler", 0.14), ((2.0, -1.0),), (0.02,), axes="link"
)


@pytest.fixture
def pushed(aluminium: flexmech.Mechanism) -> flexmech.Mechanism:
    sections = {k: one.with_damping_time(2e-4) for k, one in aluminium.sections.items()}
    return replace(aluminium, sections=sections, shaft_inertia=2e-3, loads=(FOLLOWER,))


def run(mechanism: flexmech.Mechanism, kinds: Any = ENGINES, **asked: Any) -> Any:
    engines = [kind(mechanism, 2, shaft=asked.get("shaft", "prescribed")) for kind in kinds]
    settings = {"revolutions": 0.2, "samples": 90, "start": "equilibrium", "modes": 3}
    request = flexmech.analyses.ResponseRequest(20.0, **settings | {"step": 2e-4} | asked)
    return flexmech.response(engines, request).dataset


def off(data: Any, wanted: Any, name: str) -> float:
    """Greatest difference of a quantity over its greatest size."""
    return float(abs(data[name].values - wanted[name].values).max() / abs(wanted[name]).max())


def test_a_follower_on_stiff_links_pushes_their_frame_as_it_rotates(
    aluminium: flexmech.Mechanism,
) -> None:
    """The force rotates by phi J F and its moment about the centre does not change."""
    springs = tuple(flexmech.FrameSpring((x, -0.3), (2e3, 5e3)) for x in (0.027, 0.227))
    frame = flexmech.SprungFrame(1e4, 3e3, (0.127, -0.02), springs)
    stiff, angle = on_springs(stiffened(aluminium, 1e6), frame), np.radians(60.0)
    load = replace(FOLLOWER, force=((30.0, -20.0),), torque=(0.0,))
    squares = []
    for loads in ((), (load,)):
        engine = flexmech.ReferenceEngine(replace(stiff, loads=loads), 2, "euler")
        modes = flexmech.natural_frequencies(engine, [angle], modes=3, prestress="none")
        squares.append((2 * np.pi * modes[0]) ** 2)
    turned = aluminium.linkage.motion(np.array([angle])).angle[0, 1]
    x, y = (
        np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        @ (load.force[0])
    )
    by_rotation = np.zeros((3, 3))
    by_rotation[:2, 2] = y, -x
    bare, wanted = (
        np.sort(eigvals(frame.stiffness + more, frame.inertia_matrix).real)
        for more in (np.zeros((3, 3)), by_rotation)
    )
    change = wanted - bare
    assert squares[1] - squares[0] == pytest.approx(change, abs=5e-3 * np.abs(change).max())


@pytest.mark.parametrize("part", [1.0, 4.0])
def test_becks_column_on_a_light_frame_vibrates_as_its_closed_form(part: float) -> None:
    """A column under P along its end's tangent, clamped in a body that moves and rotates.

    ``EI w'''' + P w'' = m W^2 w`` with w'' = w''' = 0 at the tip; the transverse force
    ``-EI w''' - P w'`` and the moment ``EI w''`` at the clamp act on the body (Bolotin, sec. 2.7,
    for the column).
    """
    length, body, inertia, lever, spring = 0.3, 0.1, 2e-4, 0.1, 2e4
    section = flexmech.BeamSection.rectangle(flexmech.Material(70e9, 2700.0), 3e-3, 25e-3)
    stiffness, per_length = section.bending_stiffness, section.mass_per_length
    push = part * stiffness / length**2
    springs = tuple(flexmech.FrameSpring((x, 0.0), (1e9, spring)) for x in (-lever, lever))
    load = flexmech.Load("f", AttachmentPoint("arm", length), ((-push, 0.0),), axes="link")
    column = flexmech.Mechanism(
        flexmech.RotatingArm(length),
        {"arm": section},
        loads=(load,),
        frame=flexmech.SprungFrame(body, inertia, (0.0, 0.0), springs),
    )

    def determinant(w: float) -> float:
        """Conditions at clamp and tip of ``cosh ax, sinh ax, cos bx, sin bx``."""
        root = np.sqrt(push**2 + 4 * stiffness * per_length * w**2)
        a, b = np.sqrt((root + np.array([-push, push])) / (2 * stiffness))
        rates, signs = np.array([a, a, 1j * b, 1j * b]), np.array([1, -1, 1, -1])

        def derivative(order: int, x: float) -> np.ndarray:
            grow, fall = rates**order * np.exp(rates * x), (-rates) ** order * np.exp(-rates * x)
            return np.real((grow + signs * fall) / np.array([2, 2, 2, 2j]))

        w0, w1, w2, w3 = (derivative(order, 0.0) for order in range(4))
        rows = [
            (2 * spring - body * w**2) * w0 + stiffness * w3 + push * w1,
            (2 * spring * lever**2 - inertia * w**2) * w1 - stiffness * w2,
            derivative(2, length),
            derivative(3, length),
        ]
        return float(np.linalg.det(np.array([row / np.linalg.norm(row) for row in rows])))

    engine = flexmech.ReferenceEngine(column, 12, "euler")
    found = flexmech.natural_frequencies(engine, [0.0], modes=2, prestress="axial")[0]
    exact = [newton(determinant, 2 * np.pi * each, tol=1e-10) / (2 * np.pi) for each in found]
    assert found == pytest.approx(exact, rel=1e-5)


def test_multipliers_under_a_follower_are_those_of_the_linear_equations(models: Path) -> None:
    """Exponentials of the linear system's matrices from step to step over a turn."""
    arm = flexmech.load_mechanism(models / "rotating_arm.toml")
    tip = AttachmentPoint("arm", arm.linkage.topology.links[0].length)
    load = flexmech.Load("f", tip, ((-3.0, 5.0),), axes="link")
    arm = replace(stiffened(arm, 10.0), gravity=(0.0, 0.0), loads=(load,))
    springs = tuple(flexmech.FrameSpring((x, -0.05), (4e3, 9e3), (3.0, 5.0)) for x in (-0.1, 0.1))
    engine = flexmech.ReferenceEngine(
        on_springs(arm, flexmech.SprungFrame(1.5, 0.05, (0.0, 0.0), springs)), 1
    )
    data = flexmech.stability(engine, [20.0], modes=3).dataset.isel(engine=0, crank_speed=0)
    steps = 360
    angles = 2 * np.pi / steps * (np.arange(steps) + 0.5)
    system = engine.linear_system(angles, 20.0, prestress="equilibrium")
    size, whole = system.size, np.eye(2 * system.size)
    matrix = np.eye(2 * size, k=size)
    for mass, drag, stiffness in zip(system.mass, system.damping, system.stiffness, strict=True):
        matrix[size:] = -np.linalg.solve(mass, np.hstack([stiffness, drag]))
        whole = expm(TURN / steps * matrix) @ whole
    moduli = np.log(np.abs(np.linalg.eigvals(whole)))
    found = data["log_modulus"].values.ravel()
    gaps = np.abs(found[:, None] - moduli).min(axis=1)
    assert (gaps < 1e-3 * np.abs(found)).all()


@pytest.mark.parametrize("shaft", ["prescribed", "free"])
def test_a_follower_on_a_frame_moves_it_alike_in_both_engines(
    pushed: flexmech.Mechanism, shaft: str
) -> None:
    """Its work is in the energy of both; the reference's is off by the rotation of the frame."""
    data = run(on_springs(pushed, sprung((2e3, 4e3))), shaft=shaft)
    one, other = (data.isel(engine=number) for number in (0, 1))
    for name in ("frame_displacement", "frame_rotation", "floor_force", "shaking_force"):
        assert off(one, other, name) < 4e-3
    assert (data["energy_error"].values < 1.5e-4).all()


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "near"), [(ENGINES[0], 1e-2), (ENGINES[1], 3e-5)])
def test_a_run_under_a_follower_on_a_frame_ends_as_it_begins(
    pushed: flexmech.Mechanism, kind: Any, near: float
) -> None:
    """From the periodic motion; of the reference but for the square of the frame's rotation."""
    springs = tuple(flexmech.FrameSpring((x, -0.08), (2e3, 4e3), (30.0, 30.0)) for x in (0, 0.25))
    mechanism = on_springs(pushed, flexmech.SprungFrame(2.0, 0.03, (0.127, -0.02), springs))
    asked = {"start": "periodic", "revolutions": 1.0, "step": TURN / 1440}
    data = run(mechanism, [kind], **asked).isel(engine=0)
    assert float(data["peak_frame_rotation"]) > 0.01
    for name in ("deflection", "frame_displacement", "frame_rotation"):
        values = data[name].transpose("time", ...).values
        assert np.abs(values[-1] - values[0]).max() < near * np.abs(values).max()
    assert float(data["energy_error"]) < 2e-5


@pytest.mark.thorough
@pytest.mark.parametrize("start", ["equilibrium", "periodic"])
def test_followers_on_a_stiff_frame_are_those_on_the_ground(
    pushed: flexmech.Mechanism, start: str
) -> None:
    stiff = on_springs(pushed, sprung((1e9, 1e9)))
    data, wanted = (run(one, start=start, revolutions=0.1) for one in (stiff, pushed))
    for name in ("deflection", "driving_torque"):
        assert off(data, wanted, name) < 2e-5


@pytest.mark.parametrize(
    "prestress", ["none", pytest.param("equilibrium", marks=pytest.mark.thorough)]
)
def test_a_hammer_hits_the_modes_of_a_frame_under_a_follower(
    pushed: flexmech.Mechanism, models: Path, tmp_path: Path, prestress: Any
) -> None:
    """Exudyn's nonlinear transient beside the linear modes, whether they bear the load or not."""
    file = framed_file(tmp_path, models / "aluminium_fourbar.toml")
    mechanism = replace(pushed, frame=flexmech.load_mechanism(file).frame, shaft_inertia=0.0)
    request = flexmech.analyses.HammerRequest(np.radians([100.0]), modes=3, prestress=prestress)
    found = flexmech.hammer_test(flexmech.ExudynEngine(mechanism, 2), request).dataset
    assert float(found["simulation_error"][0]) < 6e-3
