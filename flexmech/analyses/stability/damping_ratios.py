"""Links with one Kelvin-Voigt time, from a damping ratio of the linkage at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.analyses.frequencies import Formulation
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.linear_system import Engine

__all__ = ["lowest_frequency", "with_damping_time"]

TURN = np.radians(np.arange(0.0, 360.0, 5.0))


def lowest_frequency(engine: Engine) -> float:
    """First natural frequency at rest, averaged over a turn, in rad/s."""
    systems = Systems(engine, Formulation(engine.prestress_at_rest, rotation_terms=False, modes=1))
    return float(2 * np.pi * frequencies_along(systems, TURN, 0.0).mean())


def with_damping_time(engine: Engine, damping_time: float) -> Engine:
    """The engine with one Kelvin-Voigt time in s for all links."""
    mechanism = engine.mechanism
    sections = {
        name: section.with_damping_time(damping_time)
        for name, section in mechanism.sections.items()
    }
    return engine.with_(mechanism=replace(mechanism, sections=sections))
