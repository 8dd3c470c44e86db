"""Shaking force of elastic links: its mean over a turn of periodic motion, and both engines'.

Over a turn of periodic motion momentum comes back to itself, so that the mean force on the frame
is weight and loads, whatever the links and springs to the ground do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech import ExudynEngine, Load, Mechanism, ReferenceEngine, ResponseRequest, Spring
from flexmech.linkages import GROUND, AttachmentPoint
from tests.support.strategies import fourbar

PUSH = (1.0, -2.0)
SPEED = 20.0


def sprung() -> Mechanism:
    """The aluminium four-bar with weight, a load, and a spring and damper to the ground."""
    middle = AttachmentPoint("coupler", 0.14)
    pull = Spring("pull", middle, AttachmentPoint(GROUND, 0.1, 0.5), 100.0, 0.3, damping=1.0)
    load = Load("push", AttachmentPoint("rocker", 0.2), (PUSH,))
    return replace(fourbar(), gravity=(0.0, -9.81), springs=(pull,), loads=(load,))


def test_its_mean_is_weight_and_loads() -> None:
    mechanism = sprung()
    request = ResponseRequest(SPEED, 1.0, samples=360, start="periodic", prestress="axial")
    data = flexmech.response(ReferenceEngine(mechanism), request).dataset.isel(engine=0)
    mass = sum(own.moment(0) for own in mechanism.link_masses_in_order)
    wanted = mass * np.array(mechanism.gravity) + PUSH
    peak = float(np.linalg.norm(data["shaking_force"].values, axis=-1).max())
    mean = data["shaking_force"].values[1:].mean(axis=0)
    rigid = data["rigid_shaking_force"].values[1:].mean(axis=0)
    assert rigid == pytest.approx(wanted, abs=1e-12 * peak)
    # Linear equations are off by the square of the deflections: 5 mm of 280 mm here.
    assert float(abs(data["deflection"]).max()) > 4e-3
    assert mean == pytest.approx(wanted, abs=1e-3 * peak)
    assert float(data["shaking_force_amplitude"].sel(order=0, component="y")) == pytest.approx(
        -mean[1], rel=1e-12
    )


@pytest.mark.thorough
def test_both_engines_agree() -> None:
    mechanism = sprung()
    engines = [ReferenceEngine(mechanism), ExudynEngine(mechanism)]
    # From undeformed links they would ring, faster than Exudyn's steps resolve.
    data = flexmech.response(engines, ResponseRequest(SPEED, 1.0, start="equilibrium")).dataset
    for name in ("shaking_force", "shaking_moment"):
        first, second = data[name].values
        rigid = data[f"rigid_{name}"].values
        # Alike far beyond what elastic links add to rigid ones.
        assert np.abs(first - rigid).max() > 0.01 * np.abs(rigid).max()
        assert first == pytest.approx(second, abs=2e-3 * np.abs(second).max())


def test_the_shaft_of_a_run_up_pushes_back() -> None:
    """While it speeds up the drive turns the shaft too."""
    light, heavy = fourbar(), replace(fourbar(), shaft_inertia=0.05)
    request = ResponseRequest(SPEED, 0.1, samples=90, run_up_time=0.1, prestress="none")
    found = [
        flexmech.response(ReferenceEngine(each), request).dataset.isel(engine=0)
        for each in (light, heavy)
    ]
    time = found[0]["time"].values
    wanted = -0.05 * request.drive.crank_acceleration(time)
    for name in ("shaking_moment", "rigid_shaking_moment"):
        more = (found[1][name] - found[0][name]).values
        np.testing.assert_allclose(more, wanted, atol=1e-9 * np.abs(wanted).max())
    assert "order" not in found[0]
