"""Links in a state of a run: their tangents are derivatives of their forces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import AttachedBody, ExudynEngine, Mechanism, ReferenceEngine
from flexmech.solvers import nonlinear_orbit
from tests.support.mechanisms import case, drawn, strip

# Two elastic pieces that a rigid bar joins at an angle, with a body beside the last.
BENT_ARM = Mechanism(
    drawn(
        {"O2": (0.0, 0.0), "A": (0.15, 0.0), "M": (0.18, 0.06), "T": (0.33, 0.06)},
        {"first": ("O2", "A"), "bar": ("A", "M"), "last": ("M", "T")},
        {"O2": "clamp", "A": "weld", "M": "weld"},
        (),
        ["bar"],
    ),
    dict.fromkeys(["first", "last"], strip(2e-3, 1e-5)),
    bodies=(
        AttachedBody("bar", 0.03, 0.02, 1e-5, (0.0, 0.01)),
        AttachedBody("last", 0.15, 0.05, 1e-5, (0.0, 0.02)),
    ),
)


@pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("name", ["aluminium four-bar", "unsymmetric laminates"])
def test_tangents_are_the_derivatives_of_the_internal_forces(name: str, make: Any) -> None:
    """About displacements drawn at random, of a hundredth of the links."""
    mechanism = case(name).mechanism
    engine = make(mechanism, elements=3)
    motion = mechanism.linkage.motion(np.array([0.4]), np.array([30.0]))
    random = np.random.default_rng(4)
    state = [2e-3 * random.standard_normal((1, link.size)) for link in engine.links]
    way = [random.standard_normal((1, link.size)) for link in engine.links]
    step = 1e-7
    ahead, behind = (
        engine.running_links(motion, [q + s * step * w for q, w in zip(state, way, strict=True)])
        for s in (1, -1)
    )
    stressed = engine.running_links(motion, state)
    for number, w in enumerate(way):
        slope = (ahead.internal_force[number] - behind.internal_force[number]) / (2 * step)
        expected = stressed.tangent[number] @ w[0]
        assert np.abs(slope - expected).max() < 1e-5 * np.abs(expected).max()


@pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("name", ["aluminium four-bar", "unsymmetric laminates", "bent arm"])
def test_tangents_at_a_rate_have_the_derivative_of_the_damping_forces(name: str, make: Any) -> None:
    """At a rate drawn at random: a link that stretches faster is damped otherwise when it bends."""
    mechanism = BENT_ARM if name == "bent arm" else case(name).mechanism
    damped = {k: s.with_damping_time(1e-4) for k, s in mechanism.sections.items()}
    engine = make(replace(mechanism, sections=damped), elements=2)
    motion = mechanism.linkage.motion(np.array([0.4]), np.array([30.0]))
    random = np.random.default_rng(5)
    state, rate, way = (
        [scale * random.standard_normal((1, link.size)) for link in engine.links]
        for scale in (2e-3, 1.0, 1.0)
    )
    step = 1e-6

    def force(sign: float) -> list[Any]:
        places = [q + sign * step * w for q, w in zip(state, way, strict=True)]
        damping = engine.running_links(motion, places).damping
        return [matrix[0] @ v[0] for matrix, v in zip(damping, rate, strict=True)]

    slope = np.concatenate([(a - b) / (2 * step) for a, b in zip(force(1), force(-1), strict=True)])
    still, moving = (engine.running_links(motion, state, v).tangent for v in (None, rate))
    matrices = [whole - elastic for whole, elastic in zip(moving, still, strict=True)]
    expected = np.concatenate([matrix[0] @ w[0] for matrix, w in zip(matrices, way, strict=True)])
    np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_an_arm_at_constant_speed_vibrates_about_its_equilibrium() -> None:
    """Its periodic motion is the equilibrium: both have the same frequencies."""
    engine = ReferenceEngine(BENT_ARM, 2, component_modes=False)
    about = nonlinear_orbit(engine, 20.0).stressed_links(engine, [0.0])
    systems = (
        engine.linear_system(0.0, 20.0, stressed=about),
        engine.linear_system(0.0, 20.0, prestress="equilibrium"),
    )
    running, still = (
        np.sort(np.linalg.eigvals(np.linalg.solve(system.mass[0], system.stiffness[0])).real)
        for system in systems
    )
    np.testing.assert_allclose(running, still, rtol=2e-6)
