"""Is the damping of a running linkage found back from the record of a strain gauge?

The aluminium four-bar with a Kelvin-Voigt time that damps its first mode by 0.5 %, at 20 rad/s.
Exudyn's nonlinear simulation starts from undeformed links, and rings. The strains in the middle of
coupler and rocker are taken as if they were measured: with white noise of 3 % of the signal, from a
crank angle that nobody has written down, as a CSV file in micrometres per metre. The model that is
fitted knows nothing of damping, and its linear equations are those of the reference engine.

    python scenarios/17_damping_found_back.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace
from pathlib import Path

import numpy as np

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    ReferenceEngine,
    compare_with_record,
    example_model,
    load_mechanism,
    response,
)

SPEED, ELEMENTS = 20.0, 8
RATIO, FREQUENCY = 0.005, 44.66  # damping ratio, and Hz at which it holds
FIRST = 137  # the record begins so many samples after the start, at a crank angle of 137 deg
NOISE, SEED = 0.03, 17

plain = load_mechanism(example_model("aluminium_fourbar"))
damped = {
    name: section.with_damping_ratio(RATIO, FREQUENCY) for name, section in plain.sections.items()
}
simulation = ExudynEngine(replace(plain, sections=damped), ELEMENTS)
settings = {"revolutions": 4.0, "samples": 360, "step": 1e-4, "start": "rigid"}
run = response(simulation, ConstantSpeed(SPEED), **settings)
data = run.dataset.isel(engine=0, time=slice(FIRST, None))

comparisons, held = {}, {}
for number, link in enumerate(("coupler", "rocker")):
    strain = data["strain"].sel(link=link).values
    random = np.random.default_rng([SEED, number])
    measured = 1e6 * (strain + NOISE * strain.std() * random.standard_normal(strain.size))
    time = data["time"].values - data["time"].values[0]
    rows = (f"{t:.7f},{e:.4f}" for t, e in zip(time, measured, strict=True))
    record = Path(f"{link}_strain.csv")
    record.write_text("\n".join(["time [s],strain (um/m)", *rows]) + "\n")

    engine, quantity = ReferenceEngine(plain, ELEMENTS), f"{link}_mid_strain"
    comparison = compare_with_record(engine, record, SPEED, quantity=quantity)
    comparisons[link] = comparison
    comparison.plot().savefig(f"{link}.png")

    fitted, angle = comparison.fitted("damping"), comparison.fitted("start_angle")
    true = damped[link].damping.bending
    held[link] = fitted.lower <= true <= fitted.upper
    print(
        f"{link}: damping time {1e6 * fitted.value:.2f} us, 95 % interval {1e6 * fitted.lower:.2f} "
        f"to {1e6 * fitted.upper:.2f} us, which {'holds' if held[link] else 'does not hold'} the "
        f"true {1e6 * true:.2f} us; crank angle at the start {angle.value:.2f} deg, true {FIRST} "
        f"deg; {100 * comparison.unexplained:.3f} % unexplained, of which noise "
        f"{100 * NOISE**2 / (1 + NOISE**2):.3f} %"
    )
