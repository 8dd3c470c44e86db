"""Do heat and moisture move the frequencies of composite links further than crank speed does?

The moist composite four-bar over the crank angle at rest, 10 and 20 rad/s, dry and in equilibrium
with 85 % humidity at 80 degC, and the change by these speeds in both states. Both engines are set
side by side at a few crank angles.

    python scenarios/22_heat_moisture_and_speed.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

import flexmech
from flexmech import ExudynEngine, HygrothermalState, ReferenceEngine

ELEMENTS = 8
SPEEDS = np.array([0.0, 10.0, 20.0])
TURN = np.radians(np.arange(0.0, 361.0, 2.5))
COMPARED = np.radians([0.0, 90.0, 200.0])  # by both engines
WET = HygrothermalState(60.0, 0.85 * 0.05)

dry = flexmech.load_mechanism(flexmech.example_model("moist_composite_fourbar"))
engine = ReferenceEngine(dry, ELEMENTS, "timoshenko")
effect = flexmech.moving_frequencies(engine, TURN, SPEEDS, modes=3, environment=WET)
print(effect.summary())
effect.plot(speeds=SPEEDS[1:].tolist()).savefig("over_crank_angle.png")

frequency = effect.dataset["frequency"].isel(engine=0, drop=True)
by_speed = frequency.isel(crank_speed=slice(1, None)) / frequency.isel(crank_speed=0) - 1
by_water = abs(effect.relative_change()).isel(crank_speed=-1).min("crank_angle")
water_leads = bool((by_water > abs(by_speed).max(["state", "crank_speed", "crank_angle"])).all())
further = "further" if water_leads else "not everywhere further"
print(f"heat and water move the frequencies {further} than the speed does")

apart = []
for state in (HygrothermalState(), WET):
    wet = flexmech.mechanism_in_state(dry, state)
    engines = [ReferenceEngine(wet, ELEMENTS, "timoshenko")]
    engines += [ExudynEngine(wet, count, "geometrically-exact") for count in (8, 16)]
    ours, *others = (
        flexmech.natural_frequencies(one, COMPARED, SPEEDS[-1], modes=3) for one in engines
    )
    apart.append([np.abs(other / ours - 1).max() for other in others])
    print(
        f"{state.label}: Exudyn differs by up to {apart[-1][0]:.1e} with 8 elements a link, by "
        f"{apart[-1][1]:.1e} with 16"
    )
