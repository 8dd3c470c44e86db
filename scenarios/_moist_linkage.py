"""The moist composite four-bar in heat and moisture, as a whole and part by part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from _common import MODELS, SPEEDS

from flexmech import (
    ExudynEngine,
    HygrothermalState,
    Mechanism,
    MovingFrequencies,
    ReferenceEngine,
    mechanism_in_state,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.arrays import FloatArray
from flexmech.hygrothermal import Environment
from flexmech.modelfile import mechanism_from_toml

MODEL = MODELS / "moist_composite_fourbar.toml"
SPEED, MODES = 20.0, 3
# Links bent by their moisture need beams with shear; the dry ones get the same.
BEAM, EXUDYN_BEAM = "timoshenko", "geometrically-exact"
RISE, HUMIDITY, GREATEST_MOISTURE = 60.0, 0.85, 0.05
DAY = 86400.0
EVENLY_WET = HygrothermalState(RISE, HUMIDITY * GREATEST_MOISTURE)
COMPARED = np.radians([0.0, 90.0, 200.0])

SOFTENING = ("glass_transition",)
SWELLING = (
    "thermal_expansion",
    "wet_thermal_expansion",
    "moisture_expansion",
    "ground_thermal_expansion",
)
LEFT_OUT: Mapping[str, tuple[str, ...]] = {
    "all": (),
    "softening and mass": SWELLING,
    "swelling and mass": SOFTENING,
    "mass": (*SOFTENING, *SWELLING),
}


@dataclass(frozen=True)
class Series:
    """Relative changes of the frequencies from the dry linkage along a series of states.

    Parameters
    ----------
    states : sequence of HygrothermalState or Exposure
        S of them.
    frequency : ndarray, shape (S, 3)
        Mean over the turn in Hz.
    change : dict of str to ndarray, shape (S, 3)
        By part, mean over the turn. One plus ``"all"`` is the product of one plus each of the
        others, as far as the parts leave each other alone.
    water : ndarray, shape (S, L)
        Mass of water over the dry mass of each link.
    bend : ndarray, shape (S,)
        How far the rocker's middle would leave the line of its pins, unloaded, in m.
    """

    states: Sequence[Environment]
    frequency: FloatArray
    change: dict[str, FloatArray]
    water: FloatArray
    bend: FloatArray


@dataclass(frozen=True)
class Agreement:
    """Both engines in one state.

    Parameters
    ----------
    state : str
    coarse, fine : float
        Greatest relative difference of Exudyn's frequencies with a number of elements, and with
        twice as many.
    """

    state: str
    coarse: float
    fine: float


@lru_cache
def in_state(part: str, state: Environment) -> Mechanism:
    """The linkage in a state, as far as one part of what heat and moisture do goes.

    Parameters
    ----------
    part : str
        A key of ``LEFT_OUT``: those properties of fibre, resin and frame are missing.
    state : HygrothermalState or Exposure

    Returns
    -------
    Mechanism
    """
    return mechanism_in_state(_dry(part), state)


@lru_cache
def _dry(part: str) -> Mechanism:
    lines = MODEL.read_text(encoding="utf-8").splitlines()
    kept = [line for line in lines if line.partition("=")[0].strip() not in LEFT_OUT[part]]
    return mechanism_from_toml("\n".join(kept), MODEL.name)


def over_turn(crank_angles: FloatArray, elements: int) -> MovingFrequencies:
    """Frequencies over the crank angle at ``SPEEDS``, dry and evenly wet."""
    engine = ReferenceEngine(_dry("all"), elements, BEAM)
    return moving_frequencies(engine, crank_angles, SPEEDS, modes=MODES, environment=EVENLY_WET)


def along(states: Sequence[Environment], positions: FloatArray, elements: int) -> Series:
    """Changes of the frequencies along a series of states, and by what.

    Parameters
    ----------
    states : sequence of HygrothermalState or Exposure
    positions : ndarray, shape (P,)
        Crank angles in rad to average over.
    elements : int

    Returns
    -------
    Series
    """
    dry = _frequency(_dry("all"), positions, elements)
    found = {
        part: np.stack([_frequency(in_state(part, state), positions, elements) for state in states])
        for part in LEFT_OUT
    }
    ratios = {
        "all": found["all"] / dry,
        "softening": found["softening and mass"] / found["mass"],
        "swelling": found["swelling and mass"] / found["mass"],
        "mass": found["mass"] / dry,
    }
    every = [in_state("all", state) for state in states]
    masses = np.array([_masses(one) for one in every])
    curvature = np.array([one.sections["rocker"].free_curvature for one in every])
    length = _dry("all").linkage.topology.links[-1].length
    return Series(
        states=states,
        frequency=found["all"].mean(axis=1),
        change={name: ratio.mean(axis=1) - 1 for name, ratio in ratios.items()},
        water=np.round(masses / _masses(_dry("all")) - 1, 12) + 0.0,
        bend=curvature * length**2 / 8,
    )


def _frequency(mechanism: Mechanism, positions: FloatArray, elements: int) -> FloatArray:
    """Frequencies at positions of the turn; shape (P, modes)."""
    engine = ReferenceEngine(mechanism, elements, BEAM)
    return natural_frequencies(engine, positions, SPEED, modes=MODES)


def _masses(mechanism: Mechanism) -> FloatArray:
    links = mechanism.linkage.topology.links
    return np.array([mechanism.sections[k.name].mass_per_length * k.length for k in links])


def compared(state: Environment, elements: int, exudyn_elements: int) -> Agreement:
    """Both engines in a state, Exudyn with a number of elements and with twice as many.

    Parameters
    ----------
    state : HygrothermalState or Exposure
    elements, exudyn_elements : int

    Returns
    -------
    Agreement
    """
    mechanism = in_state("all", state)
    engines = [
        ReferenceEngine(mechanism, elements, BEAM),
        *(ExudynEngine(mechanism, n * exudyn_elements, EXUDYN_BEAM) for n in (1, 2)),
    ]
    reference, coarse, fine = (
        natural_frequencies(engine, COMPARED, SPEED, modes=MODES) for engine in engines
    )
    gaps = [float(np.abs(each / reference - 1).max()) for each in (coarse, fine)]
    return Agreement(state.label, *gaps)
