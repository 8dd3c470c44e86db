"""How far do the links of four-bars bend as they run, and is linear theory good enough?

The steel and the aluminium four-bar of Kumar & Chandrakar and a carbon-epoxy four-bar, dry and in
heat and moisture, start undeformed and run two turns at 10 and 20 rad/s. The built-in reference
linearizes about the equilibrium under the inertia forces; Exudyn simulates large displacements.

    python scenarios/02_time_response_at_10_and_20_rad_s.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    HygrothermalState,
    ReferenceEngine,
    example_model,
    load_mechanism,
    mechanism_in_state,
    response,
)

NAMES = ("steel", "aluminium", "moist_composite", "wet_composite")
SPEEDS = (10.0, 20.0)
ELEMENTS, SAMPLES = 8, 720
WET = HygrothermalState(60.0, 0.0425)

peaks, gaps = {}, {}
for name in NAMES:
    mechanism = load_mechanism(example_model(f"{name.replace('wet', 'moist')}_fourbar"))
    if name == "wet_composite":
        mechanism = mechanism_in_state(mechanism, WET)
    engines = [ReferenceEngine(mechanism, ELEMENTS), ExudynEngine(mechanism, ELEMENTS)]
    for speed in SPEEDS:
        # As in the papers a start-up, from undeformed links; left out, the motion is periodic.
        drive = ConstantSpeed(speed)
        run = response(engines, drive, revolutions=2.0, samples=SAMPLES, start="rigid")
        print(run.summary())
        for picture, figure in run.figures().items():
            figure.savefig(f"{name}_{speed:g}_{picture}.png")

        data = run.dataset.sel(engine="exudyn")
        place = abs(data["deflection"].sel(link="coupler")).argmax("time")
        angle = float(np.degrees(data["crank_angle"][place])) % 360
        peaks[name, speed] = float(run.peaks()["deflection"].sel(engine="exudyn", link="coupler"))
        gaps[name, speed] = float(run.agreement().sel(link="coupler"))
        print(
            f"{name.replace('_', ' ')} four-bar at {speed:g} rad/s: the coupler bends by up to "
            f"{1e3 * peaks[name, speed]:.4f} mm, at crank angle {angle:.0f} deg; "
            f"linear theory is off by {100 * gaps[name, speed]:.2f} % of that\n"
        )
for speed in SPEEDS:
    more = peaks["wet_composite", speed] / peaks["moist_composite", speed] - 1
    print(f"composite at {speed:g} rad/s: wet, the coupler bends {100 * more:+.1f} % against dry")
