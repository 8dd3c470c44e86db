"""What the numbers at the top of files about shaking force and balance are for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech import BalanceRequest, ReferenceEngine, ResponseRequest
from flexmech.analyses.balance.compromise import WeighedSum, least_moments
from flexmech.analyses.balance.compute import counterweights
from flexmech.analyses.balance.elastic import elastic_shaking
from flexmech.analyses.shaking import harmonic_variables, harmonics_line, shaking_of
from tests.support.strategies import fourbar

MODELS = Path(__file__).parents[2] / "models"
SPEED = 20.0


def test_steps_of_a_turn_leave_no_alias_in_harmonics() -> None:
    """Of a linkage with sharp peaks, against ten times the steps; in a balance too."""
    linkage = flexmech.FourBar(ground=0.254, crank=0.1325, coupler=0.1525, rocker=0.2667)
    mechanism = fourbar(linkage)
    angles = 2 * np.pi * np.arange(7200) / 7200
    fine = shaking_of(mechanism, mechanism.inverse_dynamics(linkage.motion(angles, SPEED)))
    wanted = harmonic_variables(fine, angles)["shaking_force_order"][1]
    assert wanted[-1] > 1e-2 * wanted[1]
    for found in (
        flexmech.kinematics(mechanism, SPEED).dataset,
        flexmech.balance(mechanism, BalanceRequest(SPEED, elastic=False)).dataset.isel(state=0),
    ):
        np.testing.assert_allclose(found["shaking_force_order"], wanted, rtol=1e-9)


def test_a_turn_behind_a_run_up_has_harmonics_whatever_round_off_does() -> None:
    for speed in (7.0, 13.0, 20.0, 31.0):
        request = ResponseRequest(
            speed, 1.0, samples=16, run_up_time=0.1, prestress="none", step=2e-3
        )
        data = flexmech.response(ReferenceEngine(fourbar(), 1), request).dataset
        assert "order" in data


def test_a_counterweight_that_gains_nothing_is_left_out() -> None:
    """On the crank none lessens the shaking moment about its axis."""
    request = BalanceRequest(SPEED, weights=(0.0, 1.0, 0.0))
    crank, rocker = counterweights(fourbar(), request)[0]
    assert crank.mass == 0.0
    assert rocker.mass > 0.0


def test_counterweights_without_effect_are_left_out() -> None:
    """The first alone makes the sum zero; what the second does to its last bits does not count."""
    form = np.zeros((7, 7))
    form[:2, :2] = [[1.0, 0.7], [0.7, 0.49]]
    form[2, 2] = 1.0
    first, second = least_moments(WeighedSum(form), [1.3 + 0.4j, 0.5 + 0.2j])
    assert first == pytest.approx(-1 / 0.7, rel=1e-6)
    assert second == 0.0


def test_directions_are_along_the_link_or_told() -> None:
    """What round-off turns is along it; the composite's, whose mass is off its axis, is not."""
    for weights in (None, (1.0, 0.0, 0.0)):
        asked = BalanceRequest(SPEED, weights=weights, elastic=False)
        straight = flexmech.balance(fourbar(), asked).dataset
        assert np.all(np.abs(straight["counterweight_angle"].values) == np.pi)
    composite = flexmech.load_mechanism(MODELS / "composite_fourbar.toml")
    told = flexmech.balance(composite, BalanceRequest(SPEED, elastic=False)).summary().answer[0]
    assert "at 179.9 deg to the link" in told


def test_small_orders_are_in_the_table_alone() -> None:
    data = flexmech.kinematics(fourbar(), SPEED).dataset
    sizes = data["shaking_force_order"].values, data["shaking_moment_amplitude"].values
    told = harmonics_line(data)
    for order in data["order"].values.tolist():
        large = any(size[order] > 1e-3 * size.max() for size in sizes)
        assert (f" {order}: " in told) == large
    assert " 0: " not in told


@pytest.mark.parametrize("speed", [SPEED, pytest.param(2.0, marks=pytest.mark.thorough)])
def test_steps_of_elastic_links_are_fine_enough(speed: float) -> None:
    """Chosen ones, and at 140 orders below the first frequency fixed ones, against those halved."""
    mechanism = fourbar()
    found = elastic_shaking(mechanism, speed, None)
    request = ResponseRequest(speed, 1.0, samples=360, start="periodic", prestress="axial")
    data = flexmech.response(ReferenceEngine(mechanism), request).dataset
    size = np.linalg.norm(data["shaking_force"].isel(engine=0).values, axis=-1).max()
    assert np.linalg.norm(found.force, axis=-1).max() == pytest.approx(size, rel=1e-3)
