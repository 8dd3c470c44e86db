"""Runs in time of linkages whose rigid links turn as elastic ones bend, against Exudyn's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import ConstantSpeed, ExudynEngine, ReferenceEngine
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.request import ResponseRequest
from flexmech.linear_system import Engine
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run
from tests.cross_engine.test_exudyn_joints import strips
from tests.cross_engine.test_two_drawings import Body, arm

SPEED, TURNS = 10.0, 0.25
# Of the softest link's deflection: stiffer ones have errors by mesh and step of their own.
BENDS = 0.1


def gap(name: str, elements: int = 8, steps: int = 3000) -> float:
    """Of deflections from a start without vibration, over the peak of each link that bends."""
    mechanism, drive = strips(name), ConstantSpeed(SPEED)
    length = TURNS * drive.revolution_time
    time, step = np.linspace(0.0, length, 101), length / steps
    exudyn = ExudynEngine(mechanism, elements=elements)
    reference = ReferenceEngine(mechanism, elements, "euler")
    linkage = DrivenLinkage(reference, drive, stretches=True)
    nothing = np.zeros(linkage.size)
    first = deflections(exudyn, exudyn.simulate(drive, LinkState.rigid(exudyn.links), time, step))
    second = deflections(reference, linear_run(linkage, nothing, nothing, time, step))
    peak, apart = np.abs(first).max(axis=0), np.abs(first - second).max(axis=0)
    bends = peak > BENDS * peak.max()
    return float((apart[bends] / peak[bends]).max())


@pytest.mark.parametrize(
    "name",
    [
        "rigid leg",
        *(pytest.param(f"rigid {n}coupler", marks=pytest.mark.thorough) for n in ("", "ternary ")),
    ],
)
def test_rigid_links_turn_however_far(name: str) -> None:
    """Linear in their rotation they were 2e-2 and 4e-2 off."""
    assert gap(name) < 2e-3


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_body_runs_as_a_rigid_link_welded_in_its_place(
    make: type[Engine], tmp_path: Path
) -> None:
    """The two drawings were 2e-3 of the peak apart."""
    request = ResponseRequest(ConstantSpeed(10.0), revolutions=0.2, step=1e-4)
    body, weld = (
        response([make(m, 6)], request).dataset["deflection"].values[0, :, 0]
        for m in arm([Body(0.02, 2e-5, (0.02, 0.06))]).both(tmp_path)
    )
    np.testing.assert_allclose(body, weld, rtol=0, atol=1e-6 * np.abs(weld).max())
