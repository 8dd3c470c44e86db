"""Where do heat and moisture move the unstable bands of a composite four-bar?

Water and heat soften the epoxy of the moist composite four-bar and make it heavier: its natural
frequencies fall. Unstable bands lie where sums of frequencies are multiples of the crank's, so they
move to lower crank speeds. Growth rates over crank speed about the quasi-static equilibrium, dry
and in three states, with light Kelvin-Voigt damping; how far the lower edge of one band moves is
held against how far the first frequency at rest moves. Names of bands do not tell which is which:
so close to the natural frequencies bands touch, and what meets in them is uncertain. If all
frequencies moved as the first one does, every edge would; the band nearest to there is the one that
is followed.

    python scenarios/11_moisture_and_stability.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import (
    HygrothermalState,
    ReferenceEngine,
    example_model,
    load_mechanism,
    mechanism_in_state,
    natural_frequencies,
    plots,
    stability,
)

STATES = [HygrothermalState(rise, moisture) for moisture in (0.0, 0.04) for rise in (0.0, 60.0)]
SPEEDS = np.arange(152.0, 180.1, 0.25)
# rad/s, in the band that is followed in the first state: twice the first frequency is six times
# the crank's there.
WITHIN = 176.0

dry = load_mechanism(example_model("moist_composite_fourbar"))
turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
edges, first_frequencies, growth = [], [], {}
for state in STATES:
    engine = ReferenceEngine(mechanism_in_state(dry, state), 4)
    found = stability(engine, SPEEDS, prestress="equilibrium", modes=4, damping_ratio=0.002)
    frequency = natural_frequencies(engine, turn, modes=1, prestress="equilibrium").mean()
    begin, end = found.bands()[["from_rad_s", "to_rad_s"]].to_numpy(dtype=float).T
    if not edges:
        edge = begin[(begin < WITHIN) & (end > WITHIN)].item()
    else:
        expected = edges[0] * frequency / first_frequencies[0]
        edge = begin[np.abs(begin - expected).argmin()]
    edges.append(edge)
    first_frequencies.append(frequency)
    growth[state.label] = found.growth()
    print(
        f"{state.label}: band from {edge:.2f} rad/s, {100 * (edge / edges[0] - 1):+.2f} %; first "
        f"frequency at rest {frequency:.2f} Hz, "
        f"{100 * (frequency / first_frequencies[0] - 1):+.2f} %"
    )

with plots.sheet(plots.grid(1, 1, 3.4)) as drawn:
    for number, table in enumerate(growth.values()):
        rates = table["crank_speed_rad_s"], table["growth_rate_1_s"]
        drawn.panels[0].plot(*rates, **plots.series_line(number))
    drawn.panels[0].axhline(0.0, color=plots.MID_GREY, lw=0.6)
    drawn.label_x("Crank speed (rad/s)")
    drawn.label_y("Growth rate (1/s)")
    drawn.header([plots.series_handle(number, label) for number, label in enumerate(growth)])
drawn.figure.savefig("moisture_and_stability.png")
