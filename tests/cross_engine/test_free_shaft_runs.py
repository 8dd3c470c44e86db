"""A shaft that is free in time: the reference's equations beside Exudyn's simulation."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    response,
)


def both(model: str, shaft_inertia: float, elements: int, request: ResponseRequest) -> Response:
    mechanism = replace(load_mechanism(f"models/{model}.toml"), shaft_inertia=shaft_inertia)
    engines = [ReferenceEngine(mechanism, elements, "euler")]
    return response([*engines, ExudynEngine(mechanism, elements, "ancf")], request)


def apart(run: Response, name: str) -> float:
    """Greatest difference over the peak of the second engine."""
    first, second = (run.dataset[name].isel(engine=i, drop=True) for i in (0, 1))
    return float(abs(first - second).max() / abs(second).max())


@pytest.mark.thorough
def test_a_four_bar_with_a_flywheel() -> None:
    """At this step the crank's deflection differs by Exudyn's step, the rotation by the mesh.

    Half the step leaves a quarter of the one, twice the elements a quarter of the other.
    """
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=0.25, step=2.5e-5, shaft="free")
    run = both("aluminium_fourbar", 1e-2, 4, request)
    agreement = run.agreement()
    assert agreement is not None
    assert float(agreement.max()) < 5e-3
    assert apart(run, "crank_speed_fluctuation") < 6e-3
    assert apart(run, "shaft_rotation") < 1.5e-2
    assert apart(run, "displacement") < 5e-3
    assert "shaft: free" in str(run.summary())


@pytest.mark.thorough
def test_loads_and_springs_are_in_the_torque() -> None:
    """Where the shaft hardly turns, what is linear in its rotation is all."""
    request = ResponseRequest(
        ConstantSpeed(5.0), 0.05, start="equilibrium", step=2e-4, modes=2, shaft="free"
    )
    run = both("carton_pusher", 1.0, 2, request)
    agreement = run.agreement()
    assert agreement is not None
    assert float(agreement.max()) < 2e-3
    assert apart(run, "shaft_rotation") < 1e-3
    assert apart(run, "crank_speed_fluctuation") < 1e-2


@pytest.mark.parametrize(
    "start", ["rigid", pytest.param("equilibrium", marks=pytest.mark.thorough)]
)
def test_a_slider_crank_whose_rod_bows_by_a_twentieth_of_its_length(start: str) -> None:
    """Half a turn, in which the shaft leaves its prescribed angle by almost 5 degrees.

    Equations that were linear in its rotation had it off by 3.3 %, and its speed by 6.7 %.
    """
    request = ResponseRequest(
        ConstantSpeed(6.0), 0.5, start=start, step=2e-3, modes=2, shaft="free"
    )
    run = both("slider_crank_free_shaft", 0.0, 8, request)
    agreement, peak = run.agreement(), run.dataset["peak_shaft_rotation"]
    assert agreement is not None
    assert float(agreement.sel(link="rod")) < 1e-2
    assert (peak > 0.07).all()
    assert (run.dataset["energy_error"] < 3e-4).all()
    assert apart(run, "shaft_rotation") < 1e-2
    assert apart(run, "crank_speed_fluctuation") < 1.5e-2


def test_an_arm_on_a_hub_swings_under_its_weight() -> None:
    """The clamped end moves on a circle, and what pulls at it there is a spring."""
    section = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
    arm = RotatingArm(0.3, hub_radius=0.05)
    mechanism = Mechanism(arm, {"arm": section}, gravity=(0.0, -9.81), shaft_inertia=2e-3)
    engines = [ReferenceEngine(mechanism, 2, "euler"), ExudynEngine(mechanism, 2, "ancf")]
    request = ResponseRequest(ConstantSpeed(20.0), 0.25, step=2e-4, modes=2, shaft="free")
    assert apart(response(engines, request), "shaft_rotation") < 1e-2
