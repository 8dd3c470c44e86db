"""At which crank speeds does a four-bar ring?

The steel and the aluminium four-bar of Kumar & Chandrakar against crank speed. Loads repeat with
every turn, so the linkage rings where a natural frequency divided by a whole number is the turning
frequency; these critical speeds are ranges, over which the frequency moves. The peak deflection of
the periodic motion shows which of them count. The paper's links have no damping; 1 % in the first
mode is assumed. At a few speeds Exudyn finds the periodic motion too.

    python scenarios/04_critical_speeds.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    campbell,
    example_model,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.analyses import deflections
from flexmech.solvers import nonlinear_orbit

NAMES = ("steel", "aluminium")
SPEEDS = np.linspace(8.0, 30.0, 45)
COMPARED = (10.0, 15.0, 20.0, 25.0)
DAMPING_RATIO = 0.01
ELEMENTS = 8


def damped(mechanism):
    """The mechanism with the damping ratio at its lowest natural frequency."""
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    lowest = natural_frequencies(ReferenceEngine(mechanism), turn, modes=1).min()
    sections = {
        name: section.with_damping_ratio(DAMPING_RATIO, lowest)
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def peaks(engine, speed):
    """Greatest deflection of each link in m, over a turn of the periodic motion."""
    run = response(engine, speed, revolutions=1.0, start="periodic")
    return np.abs(run.peaks()["deflection"].isel(engine=0).values)


def nonlinear_peaks(engine, speed):
    """The same of the nonlinear periodic motion."""
    displacement, _ = nonlinear_orbit(engine, speed).at(np.radians(np.arange(0.0, 360.0, 0.5)))
    return np.abs(deflections(engine, displacement)).max(axis=0)


diagrams, gaps = {}, {}
for name in NAMES:
    mechanism = damped(load_mechanism(example_model(f"{name}_fourbar")))
    engine, exudyn = ReferenceEngine(mechanism, ELEMENTS), ExudynEngine(mechanism, ELEMENTS)
    diagrams[name] = campbell(engine, SPEEDS, modes=2, orders=np.arange(1, 25))
    print(diagrams[name].summary())
    diagrams[name].plot().savefig(f"{name}_critical_speeds.png")

    # The coupler of a stiff linkage would bend with the square of the speed.
    coupler = np.array([peaks(engine, speed)[1] for speed in SPEEDS])
    ringing = SPEEDS[np.argmax(coupler / SPEEDS**2)]
    ratios = [peaks(engine, speed)[1:] / nonlinear_peaks(exudyn, speed)[1:] for speed in COMPARED]
    gaps[name] = np.abs(np.array(ratios) - 1).max()
    print(
        f"{name} four-bar: rings most at {ringing:.4g} rad/s; peaks by Exudyn differ from those of "
        f"the reference by at most {100 * gaps[name]:.2f} %"
    )
