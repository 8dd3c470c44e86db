"""Links with other Kelvin-Voigt times: from a damping ratio, or from the loss of their plies.

A model that tells the specific damping of plies or of their resin, but neither a damping frequency
nor other damping, leaves open how it counts in motion over time, where damping is viscous. It
counts at the first natural frequency at rest then, and the result says so.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.summary import CHOSEN_DAMPING
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine
from flexmech.sections import BeamSection
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.validation import Bounds

# What a damping ratio of the linkage can be.
DAMPING_RATIO = Bounds(least=0.0, below=1.0)
# Evenly spaced over a turn, where a mean converges beyond all powers of the step.
TURN = np.radians(np.arange(0.0, 360.0, 5.0))


def lowest_frequency(engine: Engine, angle: FloatArray = TURN) -> float:
    """First natural frequency at rest in rad/s, averaged over crank angles in rad: over a turn."""
    systems = Systems(engine, Formulation(engine.prestress_at_rest, rotation_terms=False, modes=1))
    return float(2 * np.pi * frequencies_along(systems, angle, 0.0).mean())


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


@dataclass(frozen=True)
class CountedLoss:
    """Specific damping that counts in motion over time at a frequency that no model states.

    Parameters
    ----------
    links : tuple of str
        With a known loss whose model states neither a damping frequency nor other damping.
    frequencies : tuple of float
        At which their loss counts, in Hz: one, or one for each crank angle at which the crank is
        locked.
    locked : bool
        Whether the crank is locked.
    """

    links: tuple[str, ...]
    frequencies: tuple[float, ...]
    locked: bool

    @classmethod
    def of(
        cls,
        engine: Engine,
        locked_angles: Iterable[float] = (),
        fitted: Collection[str] = (),
    ) -> Self:
        """Choose the first natural frequency at rest.

        Parameters
        ----------
        engine : Engine
        locked_angles : iterable of float
            At each of which the crank is locked, in rad. None: the crank turns, and the mean over
            the turn is taken.
        fitted : collection of str
            Links that get other damping.

        Returns
        -------
        CountedLoss
            Without links and frequencies where the model leaves nothing open.
        """
        sections = engine.mechanism.sections
        elastic = (one.name for one in engine.mechanism.linkage.topology.links if not one.rigid)
        links = tuple(name for name in elastic if name not in fitted and _is_open(sections[name]))
        locked = [np.array([angle]) for angle in locked_angles]
        over = locked or [TURN] if links else []
        found = (lowest_frequency(engine, angles) / (2 * np.pi) for angles in over)
        return cls(links, tuple(found), bool(locked))

    def engine(self, engine: Engine, place: int = 0) -> Engine:
        """An engine in which the loss counts.

        Parameters
        ----------
        engine : Engine
            Engine of the same mechanism.
        place : int
            Place of the crank angle among the locked ones.

        Returns
        -------
        Engine
        """
        if not self.links:
            return engine
        mechanism, frequency = engine.mechanism, self.frequencies[place]
        sections = {
            name: section.with_damping_frequency(frequency) if name in self.links else section
            for name, section in mechanism.sections.items()
        }
        return engine.with_(mechanism=replace(mechanism, sections=sections))

    @property
    def attributes(self) -> dict[str, str]:
        """Attribute of a result that says so; nothing where the model leaves nothing open."""
        if not self.links:
            return {}
        low, high = (f"{one:.4g}" for one in (min(self.frequencies), max(self.frequencies)))
        at = low if low == high else f"{low} to {high}"
        where = "at the locked crank angle" if self.locked else "averaged over a turn"
        return {
            CHOSEN_DAMPING: f"{', '.join(self.links)}: the model states no damping_frequency, so "
            f"that the specific damping counts at {at} Hz, the first natural frequency at rest "
            f"{where}, and damps modes above it more than the plies do; write damping_frequency = "
            f'"{low} Hz" into the tables of these links to state it, or damping_time = "0 s" to '
            "leave them undamped"
        }


def _is_open(section: BeamSection) -> bool:
    """Whether a section tells a loss, and neither a damping frequency nor other damping."""
    loss = section.specific_damping
    said = section.damping.stated or section.damping_frequency is not None
    return loss is not None and loss.times(angular_frequency=1.0).any and not said
