"""Reference against Exudyn on one mesh: sliders, welds, rigid links, bodies, six-bars."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    load_mechanism,
    natural_frequencies,
)
from tests.cross_engine.test_exudyn_joints import BODIES, LINKAGES, strips

MODELS = Path(__file__).parents[2] / "models"
TURN = np.radians(np.arange(0, 360, 45))
DRAWN = ("slider_crank", "watt_six_bar", "stephenson_six_bar", "rotating_l_beam", "carton_pusher")


def model(name: str) -> Mechanism:
    """A model file without what acts on its links from outside."""
    found = load_mechanism(MODELS / f"{name}.toml")
    return replace(found, loads=(), springs=(), joint_springs=())


def difference(mechanism: Mechanism, elements: int, speed: float, **options: Any) -> float:
    """Greatest relative difference in the first modes."""
    count = 2 if any(slider.guide for slider in mechanism.linkage.topology.sliders) else 3
    first, second = (
        natural_frequencies(
            engine(mechanism, elements, element), TURN, speed, modes=count, **options
        )
        for engine, element in ((ReferenceEngine, "euler"), (ExudynEngine, "ancf"))
    )
    return float(np.abs(second / first - 1).max())


@pytest.mark.parametrize("name", DRAWN)
def test_model_files_at_rest(name: str) -> None:
    assert difference(model(name), 8, 0.0) < 1e-5


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize(
    "options",
    [
        {},
        pytest.param({"rotation_terms": False}, marks=pytest.mark.thorough),
        pytest.param({"prestress": "axial"}, marks=pytest.mark.thorough),
    ],
    ids=str,
)
def test_model_files_at_speed(name: str, options: Any) -> None:
    mechanism = model(name)
    speed = max(mechanism.operating_speeds)
    # Of tension Exudyn's straight cable takes the mean of each element: second order.
    elements = 24 if (name, options) == ("rotating_l_beam", {"prestress": "axial"}) else 12
    assert difference(mechanism, elements, speed, **options) < 1e-4
    still = natural_frequencies(ReferenceEngine(mechanism, 8, "euler"), TURN, 0.0, modes=2)
    moving = natural_frequencies(ReferenceEngine(mechanism, 8, "euler"), TURN, speed, modes=2)
    # The agreement means something: speed moves the frequencies far more.
    assert np.abs(moving / still - 1).max() > 5e-4


CASES = [*((name, False) for name in LINKAGES), *((name, True) for name in BODIES)]


@pytest.mark.parametrize(("name", "bodies"), CASES)
def test_joints_and_bodies_at_rest(name: str, bodies: bool) -> None:
    assert difference(strips(name, 4e-3, bodies), 12, 0.0, prestress="none") < 1e-5


@pytest.mark.parametrize(("name", "bodies"), CASES)
@pytest.mark.parametrize(
    "prestress", ["equilibrium", pytest.param("axial", marks=pytest.mark.thorough)]
)
def test_joints_and_bodies_at_speed(name: str, bodies: bool, prestress: Any) -> None:
    assert difference(strips(name, 4e-3, bodies), 12, 20.0, prestress=prestress) < 1e-4


@pytest.mark.parametrize(
    "name", [pytest.param("L-arm", marks=pytest.mark.thorough), "slider-crank"]
)
def test_exact_beams_tend_to_the_same_frequencies(name: str) -> None:
    """With stress, of second order."""
    mechanism, error = strips(name, 4e-3, bodies=True), []
    exact = natural_frequencies(ReferenceEngine(mechanism, 32, "timoshenko"), TURN, 20.0, modes=2)
    for elements in (8, 16):
        engine = ExudynEngine(mechanism, elements, "geometrically-exact")
        error.append(np.abs(natural_frequencies(engine, TURN, 20.0, modes=2) / exact - 1).max())
    assert error[1] < 1e-3
    assert np.log2(error[0] / error[1]) > 1.6


def test_the_round_off_of_a_solver_ends_the_search_of_an_equilibrium() -> None:
    """At some positions Exudyn's solver leaves more than 1e-10 of the forces, which stays."""
    arm = load_mechanism(MODELS / "rotating_arm.toml")
    section = BeamSection.rectangle(Material(7e10, 2700.0), 0.0030265249957012116, 0.03)
    linkage = replace(arm.linkage, length=0.3215669089348102, hub_radius=0.0)
    arm = replace(arm, linkage=linkage, sections={"arm": section}, gravity=(0.0, -9.81))
    first, second = (
        natural_frequencies(
            engine(arm, 8, element), np.linspace(0.0, 6.0, 25), 39.43751524448937, modes=3
        )
        for engine, element in ((ReferenceEngine, "euler"), (ExudynEngine, "ancf"))
    )
    np.testing.assert_allclose(second, first, rtol=1e-6)
