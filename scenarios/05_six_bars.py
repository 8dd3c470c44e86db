"""How do the frequencies of a Watt and a Stephenson six-bar move with crank angle and crank speed?

Both example models drive a second dyad: from the rocker (Watt) and from the coupler (Stephenson).
Natural frequencies over the turn at rest and at 20 rad/s by both engines on one mesh, at the
equilibrium under the inertia forces with rotation terms: how much each mode swings over the turn,
what speed changes of it, its shapes, and whether the engines agree.

    python scenarios/05_six_bars.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    example_model,
    load_mechanism,
    moving_frequencies,
)

TURN = np.radians(np.arange(0, 361, 10))
SPEEDS = (0.0, 20.0)
ELEMENTS = 8

swing, apart = {}, {}
for name in ("watt", "stephenson"):
    mechanism = load_mechanism(example_model(f"{name}_six_bar"))
    engines = [ReferenceEngine(mechanism, ELEMENTS), ExudynEngine(mechanism, ELEMENTS)]
    result = moving_frequencies(engines, TURN, SPEEDS, modes=4, speed_effect="fastest")
    print(result.summary())
    for picture in ("frequencies", "mode_shapes", "speed_effect"):
        result.figures()[picture].savefig(f"{name}_{picture}.png")

    frequency = result.dataset["frequency"].sel(engine="reference", drop=True)
    exudyn = result.dataset["frequency"].sel(engine="exudyn", drop=True)
    apart[name] = abs(exudyn / frequency - 1).max(["crank_angle", "mode"]).values
    rest = frequency.sel(crank_speed=0.0)
    swing[name] = (rest.max("crank_angle") / rest.min("crank_angle") - 1).values
    change = frequency.isel(crank_speed=-1) / rest - 1
    for mode, swings in enumerate(swing[name], start=1):
        of_mode = change.sel(mode=mode)
        worst = of_mode[int(abs(of_mode).argmax("crank_angle"))]
        print(
            f"{name} six-bar, mode {mode}: swings by {100 * swings:.2f} % over the turn at rest; "
            f"speed changes it by at most {100 * float(worst):+.2f} %, at "
            f"{np.degrees(float(worst['crank_angle'])):.0f} deg"
        )
    print(
        f"{name} six-bar: the engines differ by {apart[name][0]:.1e} at rest and by "
        f"{apart[name][1]:.1e} at {SPEEDS[-1]:g} rad/s on one mesh"
    )
