"""Energies of runs: what the shaft, the loads and the damping do is what the links have.

And orders of convergence with the time step, reversal and periodic motion of runs.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    RotatingArm,
    response,
)
from flexmech.analyses import ResponseRequest

STRIP = BeamSection.rectangle(Material(68.9e9, 2923.0), 3e-3, 25.4e-3)


def damped(mechanism: Mechanism, time: float) -> Mechanism:
    sections = {k: s.with_damping_time(time) for k, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def run(mechanism: Mechanism, step: float, turns: float = 0.5, **asked: Any) -> Any:
    """Results of the reference with two elements a link at 20 rad/s."""
    settings = {"samples": 120, "start": "equilibrium", "modes": 2} | asked
    drive = settings.pop("drive", ConstantSpeed(20.0))
    request = ResponseRequest(drive, turns, step=step, **settings)
    return response(ReferenceEngine(mechanism, 2), request).dataset.isel(engine=0)


def work(data: Any) -> float:
    """Range of the work of the shaft over the greatest kinetic energy."""
    return float(np.ptp(data["drive_work"].values) / data["kinetic_energy"].max())


@pytest.mark.parametrize("prestress", ["none", "axial"])
def test_energies_of_linear_runs_balance_in_second_order_of_the_step(
    aluminium: Mechanism, prestress: str
) -> None:
    coarse, fine = (run(aluminium, step, prestress=prestress) for step in (4e-4, 2e-4))
    errors = [float(data["energy_error"]) for data in (coarse, fine)]
    assert errors[1] < 2e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert work(fine) > 0.1  # the balance is no identity


def test_energies_of_links_that_stretch_balance_in_fourth_order_of_the_step(
    aluminium: Mechanism,
) -> None:
    """Where what is fast is not shaken from the start."""
    coarse, fine = (
        float(run(aluminium, step, 0.1, prestress="equilibrium")["energy_error"])
        for step in (4e-4, 2e-4)
    )
    assert fine < 1e-6
    assert coarse / fine == pytest.approx(16.0, rel=0.3)


@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_damping_takes_what_the_shaft_gives_and_the_links_lose(
    aluminium: Mechanism, prestress: str
) -> None:
    data = run(damped(aluminium, 3e-4), 2e-4, prestress=prestress, start="rigid")
    assert float(data["dissipated_energy"][-1]) > 1e-3 * float(data["kinetic_energy"].max())
    assert float(data["energy_error"]) < 2e-5


@pytest.mark.parametrize(
    ("kind", "prestress"), [(ReferenceEngine, "axial"), (ExudynEngine, "equilibrium")]
)
def test_the_energy_error_is_the_greatest_imbalance_of_the_energies_beside_it(
    aluminium: Mechanism, kind: Any, prestress: Any
) -> None:
    """A damped run: at its own step, and in the limit of vanishing steps."""
    request = ResponseRequest(
        ConstantSpeed(20.0), 0.1, samples=60, start="rigid", prestress=prestress, modes=2
    )
    data = response(kind(damped(aluminium, 3e-4), 2), request).dataset.isel(engine=0)
    stored = sum(data[f"{name}_energy"].values for name in ("kinetic", "strain", "gravity"))
    lost = data["dissipated_energy"].values
    balance = stored - stored[0] + lost - (data["drive_work"] + data["prestress_work"]).values
    peak = data["kinetic_energy"].values.max()
    assert lost[-1] > 1e-3 * peak
    assert float(data["energy_error"]) == pytest.approx(np.abs(balance).max() / peak, rel=1e-6)
    assert float(data["energy_error"]) < 2e-6


def test_a_bowed_arm_loses_what_its_damping_takes() -> None:
    """Its damping changes along the turn, in which its weight turns round it."""
    section = replace(STRIP.with_damping_time(2e-4))
    arm = Mechanism(RotatingArm(0.4), {"arm": section}, gravity=(0.0, -9.81))
    data = run(arm, 1e-4, 0.1, start="rigid", drive=ConstantSpeed(10.0))
    assert float(data["dissipated_energy"][-1]) > 1e-6 * float(data["kinetic_energy"].max())
    assert float(data["energy_error"]) < 1e-5


def test_over_a_periodic_turn_damping_takes_what_the_shaft_gives(aluminium: Mechanism) -> None:
    turn = 2 * np.pi / 20.0
    data = run(
        damped(aluminium, 1e-4), turn / 1440, 1.0, samples=8, start="periodic", prestress="axial"
    )
    kinetic, lost = data["kinetic_energy"].values, data["dissipated_energy"].values
    given = data["drive_work"].values + data["prestress_work"].values
    assert kinetic[-1] == pytest.approx(kinetic[0], rel=1e-9)
    assert lost[-1] - lost[0] > 1e-5
    assert given[-1] - given[0] == pytest.approx(lost[-1] - lost[0], rel=5e-3)


@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
@pytest.mark.parametrize("rigid", [False, True])
def test_energies_balance_in_a_run_up_with_a_body_off_the_axis_of_its_link(
    prestress: str, *, rigid: bool
) -> None:
    """The frames of the links turn ever faster."""
    linkage = PlanarLinkage(
        {"O2": (0.0, 0.0), "A": (0.0, 0.102), "B": (0.275, 0.16), "O4": (0.254, 0.0)},
        (
            PlanarLink("crank", ("O2", "A")),
            PlanarLink("coupler", ("A", "B"), rigid=rigid),
            PlanarLink("rocker", ("O4", "B")),
        ),
        ("O2", "O4"),
        (PlanarJoint("O2", "clamp"),),
    )
    body = AttachedBody("coupler", 0.1, 0.1, 2e-4, (0.02, 0.05))
    mechanism = Mechanism(
        linkage,
        dict.fromkeys(("crank", "coupler", "rocker"), STRIP),
        gravity=(0.0, -9.81),
        bodies=(body,),
    )
    drive = ConstantSpeed(20.0, run_up_time=0.05)
    data = run(mechanism, 1e-4, 0.05, prestress=prestress, drive=drive)
    assert work(data) > 0.1
    assert float(data["energy_error"]) < 2e-5


def test_energies_balance_where_a_link_slides_on_a_moving_one() -> None:
    """The forces between the point and its guide do work at the shaft."""
    linkage = PlanarLinkage(
        {"O2": (0.0, 0.0), "A": (0.1, 0.0), "O4": (0.0, -0.2), "E": (0.3, 0.4)},
        (PlanarLink("crank", ("O2", "A")), PlanarLink("rocker", ("O4", "E"), rigid=True)),
        ("O2", "O4"),
        (PlanarJoint("O2", "clamp"), PlanarJoint("A", "slider", direction=0.0, guide="rocker")),
    )
    sections = {name: STRIP.with_damping_time(2e-4) for name in ("crank", "rocker")}
    mechanism = Mechanism(linkage, sections, gravity=(0.0, -9.81))
    data = run(mechanism, 2e-4, 0.1, start="rigid", drive=ConstantSpeed(10.0))
    assert work(data) > 0.01
    assert float(data["energy_error"]) < 1e-5


@pytest.mark.thorough
def test_periodic_motion_converges_in_second_order_of_the_step(aluminium: Mechanism) -> None:
    mechanism, turn = damped(aluminium, 1e-4), 2 * np.pi / 20.0
    curves = [
        run(mechanism, turn / steps, 0.1, prestress="axial", start="periodic")["deflection"].values
        for steps in (1440, 2880, 5760)
    ]
    first, second = np.abs(np.diff(curves, axis=0)).max(axis=1)
    assert np.log2(first / second) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    ("prestress", "most"),
    [("axial", 5e-5), pytest.param("equilibrium", 3e-4, marks=pytest.mark.thorough)],
)
def test_a_damped_run_ends_in_the_periodic_motion(
    aluminium: Mechanism, prestress: str, most: float
) -> None:
    """The error follows from other steps than those of the run."""
    step, mechanism = 2 * np.pi / 20.0 / 720, damped(aluminium, 1e-3)
    settings = {"samples": 20, "prestress": prestress}
    settled = run(mechanism, step, 3.0, start="rigid", **settings)["deflection"].values
    orbit = run(mechanism, step, 1.0, start="periodic", **settings)["deflection"].values
    assert np.abs(settled[-21:] - orbit[-21:]).max() < most * np.abs(orbit).max()
