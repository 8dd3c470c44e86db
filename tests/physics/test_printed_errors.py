"""The errors that results print are true: of mesh, reduction, steps and peaks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    JointSpring,
    Mechanism,
    PointMass,
    ReferenceEngine,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest

ANGLES = np.radians(np.arange(0, 360, 60))


def printed_and_true(engine: Any, finer: int, speed: float = 0.0, **options: Any) -> Any:
    """Greatest error by the mesh over the angles, as printed and by a finer mesh, (2, modes)."""
    found = moving_frequencies(engine, ANGLES, [speed], **options).dataset.squeeze()
    fine = natural_frequencies(engine.with_(elements=finer), ANGLES, speed, **options)
    true = np.abs(found["frequency"].values / fine - 1).max(axis=0)
    return found["discretisation_error"].values.max(axis=0), true


@pytest.mark.parametrize(
    ("kind", "element", "prestress", "speed"),
    [
        (ReferenceEngine, "euler", "none", 0.0),
        (ReferenceEngine, "euler", "equilibrium", 20.0),
        (ExudynEngine, "ancf", "none", 0.0),
        pytest.param(ReferenceEngine, "euler", "axial", 20.0, marks=pytest.mark.thorough),
        pytest.param(ExudynEngine, "geometrically-exact", "none", 0.0, marks=pytest.mark.thorough),
    ],
)
def test_the_error_by_the_mesh_is_true_within_a_factor_of_two(
    aluminium: Mechanism, kind: Any, element: str, prestress: Any, speed: float
) -> None:
    options = {"modes": 3, "prestress": prestress}
    printed, true = printed_and_true(kind(aluminium, 8, element), 48, speed, **options)
    np.testing.assert_array_less(printed, 2 * true)
    np.testing.assert_array_less(true, 2 * printed)


@pytest.mark.parametrize(
    ("kind", "element"),
    [(ReferenceEngine, "timoshenko"), (ExudynEngine, "ancf")],
)
def test_the_error_of_a_mode_that_stretches_is_true_to_a_quarter(
    unit_arm: Callable[[float], Mechanism], kind: Any, element: str
) -> None:
    """The third one of an arm of slenderness 30: of second order, bars being linear.

    In ANCF of first order, because the point mass makes the stretch jump.
    """
    loaded = replace(unit_arm(30), link_masses=(PointMass("arm", 0.45, 0.2),))
    engine = kind(loaded, 8, element)
    options = {"modes": 3, "prestress": "none", "rotation_terms": False}
    printed, true = printed_and_true(engine, 80, **options)
    assert printed[2] == pytest.approx(true[2], rel=0.25)


@pytest.mark.thorough
def test_the_error_of_links_that_springs_bend_is_that_of_the_mesh(aluminium: Mechanism) -> None:
    """Component modes of straight links are off by more than the mesh: they have no part in it."""
    spring = JointSpring("B", torsional_stiffness=0.05, free_angle=-1.0)
    bent = replace(aluminium, joint_springs=(spring,))
    engine = ExudynEngine(bent, 8, component_modes=False)
    printed, true = printed_and_true(engine, 32, modes=2, rotation_terms=False)
    assert printed == pytest.approx(true, rel=0.35)


@pytest.mark.parametrize(("prestress", "speed"), [("none", 0.0), ("equilibrium", 20.0)])
def test_the_error_by_reduction_is_the_distance_to_the_unreduced_matrices(
    aluminium: Mechanism, prestress: Any, speed: float
) -> None:
    engine, options = ReferenceEngine(aluminium, 8), {"modes": 6, "prestress": prestress}
    found = moving_frequencies(engine, ANGLES, [speed], **options).dataset.squeeze()
    exact = natural_frequencies(engine.unreduced(), ANGLES, speed, **options)
    true = np.abs(found["frequency"].values / exact - 1).max()
    assert true < 2e-5
    assert found["reduction_error"].values.max() == pytest.approx(true, rel=0.3)


def test_the_mesh_is_refined_to_the_tolerance_of_each_engine(aluminium: Mechanism) -> None:
    engines = [ReferenceEngine(aluminium, 2), ExudynEngine(aluminium, 4, "geometrically-exact")]
    angles, options = np.radians([0.0, 120.0]), {"modes": 2, "prestress": "none"}
    kept = moving_frequencies(engines, angles, [0.0], **options).dataset
    assert kept["elements"].values.tolist() == [2, 4]
    assert kept["discretisation_error"].max() > 1e-3
    refined = moving_frequencies(engines, angles, [0.0], tolerance=5e-4, **options).dataset
    assert refined["elements"].values.tolist() == [4, 8]
    assert refined["discretisation_error"].max() < 5e-4


def test_errors_by_steps_are_true_within_a_factor_of_two(aluminium: Mechanism) -> None:
    """Error of the deflection over the greatest one, against a run of a quarter of the step."""
    engine = ReferenceEngine(aluminium, 2)
    found, fine = (
        response(
            engine,
            ResponseRequest(
                ConstantSpeed(20.0), 0.25, 60, step=step, prestress="axial", modes=2, start="rigid"
            ),
        ).dataset.isel(engine=0)
        for step in (5e-4, 1.25e-4)
    )
    printed = found["step_error_of_deflection"].values
    gap = np.abs(found["deflection"] - fine["deflection"]).max("time")
    true = (gap / np.abs(fine["deflection"]).max("time")).values
    np.testing.assert_array_less(printed, 2 * true)
    np.testing.assert_array_less(true, 2 * printed)


def test_the_step_that_a_response_chooses_balances_deeply_bowed_links(models: Any) -> None:
    engine = ReferenceEngine(load_mechanism(models / "rotating_l_beam.toml"), 4, "euler")
    drive = ConstantSpeed(16.0)
    with pytest.raises(ComputationError, match="no balance in a time step"):
        response(
            engine, ResponseRequest(drive, 0.5, step=drive.revolution_time / 90, start="rigid")
        )
    found = response(engine, ResponseRequest(drive, 0.05, start="rigid"))
    assert float(found.dataset["energy_error"].max()) < 1e-6
