"""A free shaft: pinned beams with an inertia at the pin, motions that deform nothing, runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Load,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
    stability,
)
from flexmech.analyses import ResponseRequest
from flexmech.linkages import AttachmentPoint, inverse_dynamics

FloatArray = NDArray[np.float64]
LENGTH, INERTIA = 0.3, 2e-4
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
ENGINES: list[Any] = [ReferenceEngine, ExudynEngine]
TURN = np.radians(np.arange(0, 360, 45))


def arm_on_shaft(hub_radius: float = 0.0, inertia: float = INERTIA) -> Mechanism:
    arm = RotatingArm(LENGTH, hub_radius=hub_radius)
    return Mechanism(arm, {"arm": SECTION}, shaft_inertia=inertia)


def fourbar_on_shaft(inertia: float) -> Mechanism:
    return replace(load_mechanism("models/aluminium_fourbar.toml"), shaft_inertia=inertia)


def pinned_beam_with_inertia(hub_radius: float, count: int) -> FloatArray:
    """Frequencies in Hz of an Euler beam whose root a rigid hub on a free shaft holds.

    The shaft turns by phi: the root moves by ``hub_radius phi`` and turns by phi, and the beam's
    moment and shear force at the root turn the shaft: ``J phi'' = EI (w'' - hub_radius w''')``.
    """
    stiffness, mass = SECTION.bending_stiffness, SECTION.mass_per_length

    def determinant(wave: float) -> float:
        square = stiffness / mass * wave**4
        c, s = np.cos(wave * LENGTH), np.sin(wave * LENGTH)
        ch, sh = np.cosh(wave * LENGTH), np.sinh(wave * LENGTH)
        bending, shear = stiffness * wave**2, hub_radius * stiffness * wave**3
        rows = [
            [1, 0, 1, 0, -hub_radius],
            [0, wave, 0, wave, -1],
            [-c, -s, ch, sh, 0],
            [s, -c, sh, ch, 0],
            [-bending, shear, bending, -shear, INERTIA * square],
        ]
        return float(np.linalg.det(np.array(rows)))

    waves = np.linspace(0.5, 12, 600) / LENGTH
    values = [determinant(wave) for wave in waves]
    roots = [
        brentq(determinant, low, high, xtol=1e-13)
        for low, high, a, b in zip(waves, waves[1:], values, values[1:], strict=False)
        if a * b < 0
    ]
    return np.sqrt(stiffness / mass) * np.array(roots[:count]) ** 2 / (2 * np.pi)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("hub_radius", [0.0, 0.05])
def test_an_arm_on_a_free_shaft_is_a_pinned_beam_with_an_inertia(
    engine: Any, hub_radius: float
) -> None:
    """With the fourth order of the mesh."""
    exact = pinned_beam_with_inertia(hub_radius, 3)
    coarse, fine = (
        natural_frequencies(engine(arm_on_shaft(hub_radius), n, shaft="free"), 0.3, modes=3)
        for n in (16, 32)
    )
    assert fine[:2] == pytest.approx(exact[:2], rel=1e-6)
    order = np.log2((coarse / exact - 1) / (fine / exact - 1))
    assert order[1:] == pytest.approx(4, abs=0.1)


@pytest.mark.parametrize(
    ("engine", "element"),
    [(ReferenceEngine, "euler"), (ReferenceEngine, "reddy"), (ExudynEngine, "ancf")],
)
def test_a_free_arm_turns_at_zero_frequency_at_any_speed(engine: Any, element: str) -> None:
    free = engine(arm_on_shaft(0.05), 6, element, shaft="free")
    levels = ("equilibrium",) if element == "ancf" else ("axial", "equilibrium")
    for prestress in levels:
        found = moving_frequencies(free, [0.3], [0.0, -60.0], modes=2, prestress=prestress)
        table = found.tables()["shaft"]
        assert table["frequency_Hz"].max() < 1e-3
        assert (found.dataset["frequency"] > 40).all()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_heavy_shaft_turns_as_prescribed(engine: Any) -> None:
    heavy = engine(fourbar_on_shaft(1e9), 4, shaft="free")
    held = engine(load_mechanism("models/aluminium_fourbar.toml"), 4)
    for speed in (0.0, 20.0):
        found, expected = (natural_frequencies(e, TURN, speed) for e in (heavy, held))
        assert found == pytest.approx(expected, rel=1e-7)


def test_engines_agree_on_a_four_bar_with_a_free_shaft_and_reduction_changes_little() -> None:
    reference, exudyn = (engine(fourbar_on_shaft(1e-3), 8, shaft="free") for engine in ENGINES)
    for speed, tolerance in ((0.0, 1e-5), (20.0, 1e-4)):
        found = natural_frequencies(reference, TURN, speed)
        assert natural_frequencies(exudyn, TURN, speed) == pytest.approx(found, rel=tolerance)
        whole = natural_frequencies(reference.unreduced(), TURN, speed)
        assert found == pytest.approx(whole, rel=2e-5)


def test_damped_modes_beside_the_rigid_one_have_half_of_omega_tau() -> None:
    """``lambda^2 + tau w^2 lambda + w^2 = 0`` of one Kelvin-Voigt time."""
    time = 2e-5
    plain = ReferenceEngine(arm_on_shaft(), 8, "euler", shaft="free")
    damped = replace(plain.mechanism, sections={"arm": SECTION.with_damping_time(time)})
    found = moving_frequencies(plain.with_(mechanism=damped), [0.0], [0.0], modes=3)
    undamped = natural_frequencies(plain, 0.0, modes=3)
    assert found.dataset["frequency"].values[0, 0, 0] == pytest.approx(undamped, rel=1e-7)
    ratio = found.dataset["damping_ratio"].values[0, 0, 0]
    assert ratio == pytest.approx(np.pi * undamped * time, rel=1e-7)


def run(engine: Any, shaft_inertia: float, **asked: Any) -> Any:
    request = ResponseRequest(
        ConstantSpeed(20.0), revolutions=0.05, step=1e-4, start="rigid", **asked
    )
    return response(
        engine(fourbar_on_shaft(shaft_inertia), 2, component_modes=False), request
    ).dataset


@pytest.mark.thorough
@pytest.mark.parametrize(("engine", "balance"), [(ReferenceEngine, 1e-5), (ExudynEngine, 1e-6)])
def test_in_a_run_what_a_heavy_shaft_leaves_falls_as_one_over_its_inertia(
    engine: Any, balance: float
) -> None:
    prescribed = run(engine, 0.0)
    away, apart = [], []
    for inertia in (1.0, 10.0):
        free = run(engine, inertia, shaft="free")
        assert float(free["energy_error"].max()) < balance
        away.append(float(free["peak_shaft_rotation"].item()))
        apart.append(float(abs(free["deflection"] - prescribed["deflection"]).max()))
    peak = float(abs(prescribed["deflection"]).max())
    assert 1e-6 < apart[1] / peak < 1e-4
    assert away[0] / away[1] == pytest.approx(10, rel=0.02)
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.02)


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "element"), [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")])
def test_a_struck_arm_on_a_free_shaft_keeps_its_energy_and_rings_as_predicted(
    kind: Any, element: str
) -> None:
    """The shaft's rotation is two vibrations and a drift once a force to and fro has gone."""
    pushes = ((0.0, 0.0), (0.0, 0.2), (0.0, -0.2), (0.0, 0.0))
    load = Load(
        "push",
        AttachmentPoint("arm", LENGTH),
        pushes,
        4 * (0.0,),
        axes="link",
        over="time",
        at=(0.0, 1e-3, 3e-3, 4e-3),
    )
    mechanism = replace(arm_on_shaft(0.05, 2e-3), loads=(load,))
    engine = kind(mechanism, 4, element, shaft="free")
    request = ResponseRequest(
        ConstantSpeed(30.0),
        0.3,
        samples=1047,
        step=1e-4,
        start="equilibrium",
        shaft="free",
        modes=2,
    )
    data = response(engine, request).dataset.isel(engine=0)
    assert float(data["energy_error"]) < 3e-5
    turned = cumulative_trapezoid(data["crank_speed_fluctuation"], data["time"], initial=0.0)
    assert turned == pytest.approx(data["shaft_rotation"].values, abs=1e-4)
    after = data["time"].values > 5e-3
    time, rotation = data["time"].values[after], data["shaft_rotation"].values[after]
    predicted = natural_frequencies(engine, 0.0, 30.0, modes=2)

    def left(frequency: float) -> float:
        phases = [2 * np.pi * f * time for f in (frequency, predicted[1])]
        parts = [np.ones_like(time), time]
        parts += [wave(phase) for phase in phases for wave in (np.cos, np.sin)]
        basis = np.stack(parts, axis=1)
        return float(np.linalg.norm(rotation - basis @ np.linalg.lstsq(basis, rotation)[0]))

    near = (0.9 * predicted[0], 1.1 * predicted[0])
    heard = minimize_scalar(left, bounds=near, method="bounded").x
    assert heard == pytest.approx(predicted[0], rel=1e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_running_arm_on_a_free_shaft_neither_grows_nor_decays(engine: Any) -> None:
    found = stability(engine(arm_on_shaft(0.05), 4, shaft="free"), [60.0], modes=3)
    assert found.dataset["unstable"].values.tolist() == [["no"]]
    assert np.abs(found.dataset["shaft_growth_rate"]).max() < 1e-3
    assert (found.dataset["frequency"] > 40).all()


@pytest.mark.thorough
def test_the_shaft_of_nearly_rigid_links_follows_hills_equation() -> None:
    """``J p'' + J' p' + J'' p / 2 = 0`` over the crank angle: torque follows the time."""
    aluminium = load_mechanism("models/aluminium_fourbar.toml")
    stiff = {
        name: replace(
            section,
            axial_stiffness=100 * section.axial_stiffness,
            bending_stiffness=100 * section.bending_stiffness,
        )
        for name, section in aluminium.sections.items()
    }
    mechanism = replace(aluminium, sections=stiff, shaft_inertia=1e-2)
    angles = 2 * np.pi / 256 * np.arange(256)
    motion = mechanism.linkage.motion(angles, 0.0, 1.0)
    masses = mechanism.link_masses_in_order
    forces = inverse_dynamics(mechanism.linkage.topology, motion, masses)
    inertia = np.fft.rfft(forces.driving_torque + mechanism.shaft_inertia) / 256
    order = np.arange(len(inertia))

    def series(angle: float, derivative: int) -> float:
        terms = inertia * (1j * order) ** derivative * np.exp(1j * order * angle)
        return float(terms[0].real + 2 * terms[1:].real.sum())

    def rate(angle: float, state: FloatArray) -> FloatArray:
        j, first, second = (series(angle, n) for n in range(3))
        turned, speed = state.reshape(2, 2)
        return np.concatenate([speed, -(first * speed + second / 2 * turned) / j])

    end = solve_ivp(rate, (0, 2 * np.pi), np.eye(2).ravel(), rtol=1e-9, atol=1e-12).y[:, -1]
    expected = np.log(np.abs(np.linalg.eigvals(end.reshape(2, 2))).max())
    engine = ReferenceEngine(mechanism, 2, "euler", shaft="free")
    found = stability(engine, [10.0], prestress="axial", modes=2).dataset["shaft_growth_rate"]
    assert float(found.item()) * 2 * np.pi / 10 == pytest.approx(expected, abs=3e-4)
