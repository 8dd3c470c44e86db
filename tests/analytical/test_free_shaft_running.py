"""Stability of linkages whose shaft is free: the shaft's own motion is Hill's equation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmech import (
    BeamSection,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    stability,
)
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.linear_system import Engine
from flexmech.linkages import inverse_dynamics

SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("hub_radius", [0.0, 0.05])
def test_an_arm_on_a_free_shaft_neither_grows_nor_decays(
    engine: type[Engine], hub_radius: float
) -> None:
    arm = RotatingArm(0.3, hub_radius=hub_radius)
    mechanism = Mechanism(arm, {"arm": SECTION}, shaft_inertia=2e-4)
    found = stability(engine(mechanism, 4, shaft="free"), [60.0], modes=3)
    assert found.dataset["unstable"].values.tolist() == [["no"]]
    assert np.abs(found.dataset["shaft_growth_rate"]).max() < 1e-3
    assert (found.dataset["frequency"] > 40).all()
    table = found.tables()["stability"]
    assert table["shaft_growth_rate_1_s"].notna().all()
    assert "its own motion against the mean one does not grow" in str(found.summary())


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
    topology = mechanism.linkage.topology
    forces = inverse_dynamics(topology, motion, mechanism.link_masses_in_order)
    inertia = np.fft.rfft(forces.driving_torque + mechanism.shaft_inertia) / 256
    order = np.arange(len(inertia))

    def series(angle: float, derivative: int) -> float:
        terms = inertia * (1j * order) ** derivative * np.exp(1j * order * angle)
        return float(terms[0].real + 2 * terms[1:].real.sum())

    def rate(angle: float, state: np.ndarray) -> np.ndarray:
        j, first, second = (series(angle, n) for n in range(3))
        turned, speed = state.reshape(2, 2)
        return np.concatenate([speed, -(first * speed + second / 2 * turned) / j])

    end = solve_ivp(rate, (0, 2 * np.pi), np.eye(2).ravel(), rtol=1e-9, atol=1e-12).y[:, -1]
    expected = np.linalg.eigvals(end.reshape(2, 2))
    solver = LinkageSolver(
        ReferenceEngine(mechanism, 2, "euler", shaft="free"), "axial", 2, damping=0.0
    )
    found = solver.solve(solver.moving(10.0))
    multipliers = np.exp(found.rigid * found.period)
    assert np.sort_complex(multipliers) == pytest.approx(np.sort_complex(expected), abs=3e-4)
