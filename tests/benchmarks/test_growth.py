"""How time and memory grow with crank angles and elements."""

import time
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from flexmech import ReferenceEngine, campbell, load_mechanism, moving_frequencies
from flexmech.threads import one_thread

CASES = [("none", 0.0), ("equilibrium", 20.0)]


def measure(aluminium, angles, elements, prestress, speed):
    """Seconds, and peak megabytes above the start, of one tracked map."""
    with one_thread():
        tracemalloc.start()
        moving_frequencies(
            ReferenceEngine(aluminium, elements), angles, [speed], prestress=prestress
        )
        peak = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
        start = time.perf_counter()
        moving_frequencies(
            ReferenceEngine(aluminium, elements), angles, [speed], prestress=prestress
        )
        return time.perf_counter() - start, peak


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[0])
@pytest.mark.parametrize("count", [1, 10, 100, 1000, 10000])
def test_crank_angles(aluminium, note, count, case):
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)
    seconds, peak = measure(aluminium, angles, 8, *case)
    note(f"{case[0]}: {count} angles, 8 elements", seconds, peak)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case[0])
@pytest.mark.parametrize("elements", [2, 4, 8, 16, 32, 64, 128])
def test_elements(aluminium, note, elements, case):
    angles = np.linspace(0, 2 * np.pi, 73)
    seconds, peak = measure(aluminium, angles, elements, *case)
    note(f"{case[0]}: 73 angles, {elements} elements", seconds, peak)
    # Matrices are whole, and there is a mesh twice as fine: the square of the elements.
    assert peak < max(50, 0.055 * elements**2)


@pytest.mark.parametrize("elements", [8, 64])
def test_damped_links_at_speed(aluminium, note, elements):
    """Rotation terms and Kelvin-Voigt damping: quadratic eigenproblems in component modes."""
    sections = {n: s.with_damping_time(1e-4) for n, s in aluminium.sections.items()}
    mechanism = replace(aluminium, sections=sections)
    seconds, peak = measure(mechanism, np.linspace(0, 2 * np.pi, 73), elements, "equilibrium", 20.0)
    note(f"damped, equilibrium: 73 angles, {elements} elements", seconds, peak)


@pytest.mark.parametrize("name", ["aluminium", "composite"])
def test_campbell_of_two_hundred_speeds(note, models, name):
    """By a fit in speed: all speeds one by one would take three times as long."""
    engine = ReferenceEngine(load_mechanism(models / f"{name}_fourbar.toml"))
    speeds = np.linspace(0.0, 900.0 * np.pi / 30, 200)
    start = time.process_time()
    campbell(engine, speeds)
    note(f"campbell: {name}, 200 speeds to 900 rpm (CPU)", time.process_time() - start, np.nan)
