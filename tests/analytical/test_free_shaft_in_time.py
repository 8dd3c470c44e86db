"""Runs of linkages whose shaft is free: it carries the torque of the rigid linkage over time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    InputError,
    Material,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.linear_system import Engine
from flexmech.time_domain import DrivenLinkage, LinkState, Trajectory, linear_run
from flexmech.time_domain.equations_of_motion.reduced_links import can_stretch

SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
SHAFT_INERTIA = 2e-3
SPEED = 30.0


def run(engine: type[Engine], shaft_inertia: float, **asked: Any) -> Response:
    mechanism = load_mechanism("models/aluminium_fourbar.toml")
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=0.05, step=1e-4, **asked)
    heavy = replace(mechanism, shaft_inertia=shaft_inertia)
    return response(engine(heavy, 2, component_modes=False), request)


@pytest.mark.parametrize(
    ("engine", "balance"), [(ReferenceEngine, 1e-5), (ExudynEngine, 1e-6)], ids=["linear", "exudyn"]
)
def test_a_heavy_shaft_turns_as_prescribed(engine: type[Engine], balance: float) -> None:
    """What is left falls as one over its inertia."""
    prescribed = run(engine, 0.0).dataset
    away, apart = [], []
    for inertia in (1.0, 10.0):
        free = run(engine, inertia, shaft="free").dataset
        assert float(free["energy_error"].max()) < balance
        away.append(float(free["peak_shaft_rotation"].item()))
        apart.append(float(abs(free["deflection"] - prescribed["deflection"]).max()))
    peak = float(abs(prescribed["deflection"]).max())
    assert 1e-6 < apart[1] / peak < 1e-4
    assert away[0] / away[1] == pytest.approx(10, rel=0.02)
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.02)


def bent_arm(engine: Engine) -> Trajectory:
    """Run of an arm that is let go with its tip off, on a shaft that turns freely with it."""
    [link] = engine.clamped_links
    tip = np.zeros(link.size)
    tip[link.end_displacement("end")[1]] = 0.5
    held = link.end_displacement("start"), link.end_rotation_of("start")
    moves = np.setdiff1d(np.arange(link.size), np.concatenate(held))
    bent = np.zeros(link.size)
    bent[moves] = np.linalg.solve(link.stiffness[np.ix_(moves, moves)], tip[moves])
    start, samples = LinkState([bent], [0 * bent]), np.arange(0, 0.1, 2e-4)
    if isinstance(engine, ExudynEngine):
        return engine.simulate(ConstantSpeed(SPEED), start, samples, 1e-5)
    linkage = DrivenLinkage(engine, ConstantSpeed(SPEED), stretches=can_stretch(engine))
    return linear_run(linkage, *linkage.coordinates(start), samples, 1e-5)


@pytest.mark.parametrize("hub", [0.0, 0.05])
@pytest.mark.parametrize(
    ("kind", "element", "closes"),
    [(ReferenceEngine, "euler", 3e-5), (ExudynEngine, "ancf", 1e-6)],
    ids=["linear", "exudyn"],
)
def test_an_arm_on_a_free_shaft_keeps_energy_and_angular_momentum_and_rings_as_predicted(
    kind: type[Engine], element: str, closes: float, hub: float
) -> None:
    arm = Mechanism(RotatingArm(0.3, hub_radius=hub), {"arm": SECTION}, shaft_inertia=SHAFT_INERTIA)
    engine = kind(arm, 4, element, shaft="free")
    found = bent_arm(engine)
    [link], shaft = engine.links, found.shaft
    assert shaft is not None
    place = found.displacement[0] + link.fields.centripetal + hub * link.fields.along
    rate = found.rate[0]
    speed = SPEED + shaft.rate
    momentum = speed * np.sum(place * (place @ link.centrifugal_mass), axis=1)
    momentum -= np.sum(place * (rate @ link.gyroscopic.T), axis=1)
    momentum += SHAFT_INERTIA * speed
    assert np.ptp(momentum) < closes * abs(momentum).max()
    assert found.energy_error < closes
    assert np.abs(shaft.rate).max() > 0.01 * SPEED

    predicted = natural_frequencies(engine, 0.0, SPEED, modes=2)

    def left(frequency: float) -> float:
        """What two vibrations and a drift leave of the shaft's rotation."""
        phases = [2 * np.pi * f * found.time for f in (frequency, predicted[1])]
        parts = [np.ones_like(found.time), found.time]
        parts += [part(phase) for phase in phases for part in (np.cos, np.sin)]
        basis = np.stack(parts, axis=1)
        return float(
            np.linalg.norm(shaft.rotation - basis @ np.linalg.lstsq(basis, shaft.rotation)[0])
        )

    near = (0.9 * predicted[0], 1.1 * predicted[0])
    heard = minimize_scalar(left, bounds=near, method="bounded").x
    assert heard == pytest.approx(predicted[0], rel=2e-3)


@pytest.mark.parametrize(("model", "speed"), [("aluminium_fourbar", 20.0), ("slider_crank", 10.0)])
def test_a_turn_of_the_linkage_without_vibration_obeys_hills_equation(
    model: str, speed: float
) -> None:
    """Of a flexible crank and of a rigid one, whose pins pull at it."""
    mechanism = replace(load_mechanism(f"models/{model}.toml"), shaft_inertia=1e-2)
    engine = ReferenceEngine(mechanism, 4, "euler", component_modes=False, shaft="free")
    linkage = DrivenLinkage(engine, ConstantSpeed(speed), "axial")
    assert linkage.shaft is not None
    interval = 1e-3 / speed
    time = 0.4 / speed + interval * np.arange(-2, 3)
    equations = linkage.equations(time)
    turn = linkage.shaft.turn(equations.motion)

    def derivative(values: np.ndarray, order: int) -> np.ndarray:
        """In the middle, of fourth order."""
        weights = ([1, -8, 0, 8, -1], [-1, 16, -30, 16, -1])[order - 1]
        return np.tensordot(weights, values, axes=1) / (12 * interval**order)

    mass, damping, stiffness = (
        values[2] for values in (equations.mass, equations.damping, equations.stiffness)
    )
    still, first, second = turn[2], derivative(turn, 1), derivative(turn, 2)
    inertia = np.einsum("mi,mij,mj->m", turn, equations.mass, turn)
    by_speed = still @ (2 * mass @ first + damping @ still)
    by_angle = still @ (mass @ second + damping @ first + stiffness @ still)
    assert by_speed == pytest.approx(derivative(inertia, 1), rel=1e-4)
    assert by_angle == pytest.approx(derivative(inertia, 2) / 2, rel=1e-3)


def test_what_a_free_shaft_cannot_do() -> None:
    with pytest.raises(InputError, match="a periodic start needs a prescribed shaft"):
        ResponseRequest(ConstantSpeed(20.0), start="periodic", shaft="free")
    engine = ExudynEngine(load_mechanism("models/aluminium_fourbar.toml"), 2, shaft="free")
    with pytest.raises(InputError, match="a periodic start needs a prescribed shaft"):
        response(engine, ResponseRequest(ConstantSpeed(20.0), start="periodic"))
    with pytest.raises(InputError, match="shaft must be"):
        ResponseRequest(ConstantSpeed(20.0), shaft="loose")  # type: ignore[arg-type]
    linear = ReferenceEngine(engine.mechanism, 2)
    without = ResponseRequest(ConstantSpeed(20.0), prestress="none", shaft="free")
    with pytest.raises(InputError, match="a free shaft needs the tension of the links"):
        response(linear, without)
