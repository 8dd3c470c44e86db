"""Slider-cranks of a short stroke at random: do they shake themselves up where Floquet says so?

At about twice its frequency a turn the rod is pressed and pulled by the slider's inertia, the
principal region of Mathieu's equation. The nonlinear simulation starts on the periodic motion, once
alone and once with a small Floquet vector added; once a turn the difference of both is written in
the vector's real and imaginary part.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import floquet_modes
from flexmech.threads import one_thread
from flexmech.time_domain import (
    LinkState,
    SampledTurn,
    counts_of_modes,
    moving_modes,
    nonlinear_orbit,
)
from tests.support.random_mechanisms import log_uniform

SCENARIOS = Path(__file__).parents[2] / "scenarios"
ELEMENTS, STEPS, TURNS = 3, 720, 16
MODES, SAMPLES, PROPAGATED = 3, 64, 512
DAMPING_RATIO = 0.004
# Floquet vector over the greatest displacement of the periodic motion.
SMALL = 1e-3


@dataclass(frozen=True)
class Rod:
    """A slider-crank, and the first frequency of its rod in rad/s."""

    mechanism: Mechanism
    frequency: float


def drawn(seed: int) -> Rod:
    random = np.random.default_rng([seed, 41])
    length = log_uniform(random, 0.1, 0.6)
    crank, offset = length * random.uniform(0.003, 0.008), length * random.uniform(-0.2, 0.2)
    rod = np.sqrt(length**2 - (offset - crank) ** 2)
    linkage = PlanarLinkage(
        {"O2": (0.0, 0.0), "A": (0.0, crank), "B": (float(rod), float(offset))},
        (PlanarLink("crank", ("O2", "A")), PlanarLink("rod", ("A", "B"))),
        ("O2",),
        (PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", direction=0.0)),
    )
    material = Material(log_uniform(random, 20e9, 210e9), random.uniform(1500.0, 8000.0))
    section = BeamSection.rectangle(material, length * log_uniform(random, 1 / 80, 1 / 40), 0.02)
    mass = section.mass_per_length * length * random.uniform(0.15, 0.4)
    thick = BeamSection.rectangle(material, crank, 0.02)
    mechanism = Mechanism(linkage, {"crank": thick, "rod": section}, joint_masses={"B": mass})
    engine = ReferenceEngine(mechanism, ELEMENTS, "euler")
    turn = np.radians(np.arange(0.0, 360.0, 30.0))
    hertz = natural_frequencies(engine, turn, modes=1, prestress="none", rotation_terms=False)
    return Rod(mechanism, float(2 * np.pi * hertz.mean()))


def state(
    engine: ExudynEngine, displacement: list[FloatArray], rate: list[FloatArray]
) -> FloatArray:
    """Displacements and rates (..., 2 s) at stations along all links."""
    return np.concatenate([at_stations(engine, displacement), at_stations(engine, rate)], axis=-1)


def at_stations(engine: ExudynEngine, of_links: list[FloatArray]) -> FloatArray:
    """From coordinates (..., n) of each link to (..., s)."""
    moved = [
        np.einsum("scn,...n->...sc", link.shape, q).reshape(*q.shape[:-1], -1)
        for link, q in zip(engine.links, of_links, strict=True)
    ]
    return np.concatenate(moved, axis=-1)


def plus(first: LinkState, second: LinkState, factor: float) -> LinkState:
    return LinkState(
        [a + factor * b for a, b in zip(first.displacement, second.displacement, strict=True)],
        [a + factor * b for a, b in zip(first.rate, second.rate, strict=True)],
    )


def rates(mechanism: Mechanism, speed: float) -> tuple[float, float]:
    """Growth rates in 1/s: of the Floquet exponent, and of the nonlinear simulation."""
    floquet_state = importlib.import_module("_floquet_state").floquet_state
    engine, drive = ExudynEngine(mechanism, ELEMENTS, "ancf"), ConstantSpeed(speed)
    with one_thread():
        orbit = nonlinear_orbit(engine, speed, SAMPLES)
        angle = 2 * np.pi / SAMPLES * np.arange(SAMPLES)
        motion = mechanism.linkage.motion(angle, np.full(SAMPLES, speed))
        stressed = engine.running_links(motion, list(orbit.displacement))
        turn = SampledTurn.of(engine, motion, stressed, "equilibrium", MODES)
        moving = moving_modes(turn, counts_of_modes(turn, MODES, 1)[0])
        modes = floquet_modes(moving.system(), PROPAGATED)
        start = LinkState([q[0] for q in orbit.displacement], [q[0] for q in orbit.rate])
        vector = floquet_state(moving, modes)
        size = SMALL * float(np.abs(at_stations(engine, list(orbit.displacement))).max())
        time = drive.revolution_time * np.arange(TURNS + 1)
        step = drive.revolution_time / STEPS
        runs = [
            engine.simulate(drive, begun, time, step)
            for begun in (start, plus(start, vector[0], size))
        ]
    # Rates over the crank speed are as large as displacements.
    scaled = [
        state(engine, each.displacement, [q / speed for q in each.rate])
        for each in (*runs, *vector)
    ]
    parts = size * np.stack(scaled[2:])
    difference = scaled[1] - scaled[0]
    share = np.linalg.lstsq(parts.T, difference.T, rcond=1e-6)[0]
    outside = np.linalg.norm(difference - share.T @ parts, axis=1)
    assert (outside < 0.05 * np.linalg.norm(difference, axis=1)).all()
    growth = np.polyfit(time, np.log(np.hypot(*share)), 1)[0]
    return float(modes.exponent[0].real), float(growth)


# Crank speeds over the rod's frequency: below the region, in its middle, and above it.
@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize(("part", "grows"), [(1.7, False), (2.0, True), (2.3, False)])
def test_the_simulation_grows_where_the_multipliers_do(seed: int, part: float, grows: bool) -> None:
    rod = drawn(seed)
    time = 2 * DAMPING_RATIO / rod.frequency
    sections = {name: each.with_damping_time(time) for name, each in rod.mechanism.sections.items()}
    predicted, simulated = rates(replace(rod.mechanism, sections=sections), part * rod.frequency)
    assert (predicted > 0) is grows
    # Of the decay without the slider's inertia; measured 3 %.
    assert simulated == pytest.approx(predicted, abs=0.05 * DAMPING_RATIO * rod.frequency)
