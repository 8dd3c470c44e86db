"""Links with other Kelvin-Voigt times, or one from a damping ratio of the linkage at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.linear_system import Engine
from flexmech.validation import Bounds

# What a damping ratio of the linkage can be.
DAMPING_RATIO = Bounds(least=0.0, below=1.0)
# Evenly spaced over a turn, where a mean converges beyond all powers of the step.
TURN = np.radians(np.arange(0.0, 360.0, 5.0))


def lowest_frequency(engine: Engine) -> float:
    """First natural frequency at rest, averaged over a turn, in rad/s."""
    systems = Systems(engine, Formulation(engine.prestress_at_rest, rotation_terms=False, modes=1))
    return float(2 * np.pi * frequencies_along(systems, TURN, 0.0).mean())


def with_damping_time(engine: Engine, damping_time: float) -> Engine:
    """The engine with one Kelvin-Voigt time in s for all links."""
    return with_damping_times(engine, dict.fromkeys(engine.mechanism.sections, damping_time))


def with_damping_times(engine: Engine, times: Mapping[str, float]) -> Engine:
    """The engine with one Kelvin-Voigt time in s for each of some links; the others keep theirs."""
    mechanism = engine.mechanism
    sections = {
        name: section.with_damping_time(times[name]) if name in times else section
        for name, section in mechanism.sections.items()
    }
    return engine.with_(mechanism=replace(mechanism, sections=sections))


def with_damping_ratio(engine: Engine, ratio: float) -> Engine:
    """The engine with one Kelvin-Voigt time ``2 Z/omega_1`` for all links, at a ratio Z."""
    return with_damping_time(engine, 2 * ratio / lowest_frequency(engine))
