"""Runs of linkages whose shaft is free: it carries the torque of the rigid linkage over time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from flexmech import (
    BeamSection,
    CrankDrive,
    ExudynEngine,
    InputError,
    Material,
    Mechanism,
    Response,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.time_domain import LinkState, Trajectory

SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
SHAFT_INERTIA = 2e-3
SPEED = 30.0


def run(shaft_inertia: float, **asked: str | float) -> Response:
    mechanism = load_mechanism("models/aluminium_fourbar.toml")
    engine = ExudynEngine(replace(mechanism, shaft_inertia=shaft_inertia), 2)
    request = ResponseRequest(CrankDrive(20.0), revolutions=0.05, step=1e-4, **asked)
    return response(engine, request)


def test_a_heavy_shaft_turns_as_prescribed() -> None:
    """What is left falls as one over its inertia."""
    prescribed = run(0.0).dataset
    away, apart = [], []
    for inertia in (1.0, 10.0):
        free = run(inertia, shaft="free").dataset
        assert float(free["energy_error"].max()) < 1e-6
        away.append(float(free["peak_shaft_rotation"].item()))
        apart.append(float(abs(free["deflection"] - prescribed["deflection"]).max()))
    peak = float(abs(prescribed["deflection"]).max())
    assert 1e-6 < apart[1] / peak < 1e-4
    assert away[0] / away[1] == pytest.approx(10, rel=0.02)
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.02)


def bent_arm() -> tuple[ExudynEngine, Trajectory]:
    """An arm that is let go with its tip off, on a shaft that turns freely with it."""
    arm = Mechanism(RotatingArm(0.3), {"arm": SECTION}, shaft_inertia=SHAFT_INERTIA)
    engine = ExudynEngine(arm, 4, shaft="free")
    [link] = engine.held_links
    tip = np.zeros(link.size)
    tip[link.end_displacement("end")[1]] = 0.5
    held = link.end_displacement("start"), link.end_rotation_of("start")
    moves = np.setdiff1d(np.arange(link.size), np.concatenate(held))
    bent = np.zeros(link.size)
    bent[moves] = np.linalg.solve(link.stiffness[np.ix_(moves, moves)], tip[moves])
    start = LinkState([bent], [0 * bent])
    return engine, engine.simulate(CrankDrive(SPEED), start, np.arange(0, 0.1, 2e-4), 1e-5)


def test_an_arm_on_a_free_shaft_keeps_energy_and_angular_momentum_and_rings_as_predicted() -> None:
    engine, found = bent_arm()
    [link], shaft = engine.links, found.shaft
    assert shaft is not None
    place, rate = found.displacement[0] + link.fields.centripetal, found.rate[0]
    speed = SPEED + shaft.rate
    momentum = speed * np.sum(place * (place @ link.translational_mass), axis=1)
    momentum -= np.sum(place * (rate @ link.gyroscopic.T), axis=1)
    momentum += SHAFT_INERTIA * speed
    assert np.ptp(momentum) < 1e-6 * abs(momentum).max()
    assert found.energy_error < 1e-6
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


def test_what_a_free_shaft_cannot_do() -> None:
    with pytest.raises(InputError, match="a periodic start needs a prescribed shaft"):
        ResponseRequest(CrankDrive(20.0), start="periodic", shaft="free")
    engine = ExudynEngine(load_mechanism("models/aluminium_fourbar.toml"), 2, shaft="free")
    with pytest.raises(InputError, match="a periodic start needs a prescribed shaft"):
        response(engine, ResponseRequest(CrankDrive(20.0), start="periodic"))
    with pytest.raises(InputError, match="shaft must be"):
        ResponseRequest(CrankDrive(20.0), shaft="loose")  # type: ignore[arg-type]
