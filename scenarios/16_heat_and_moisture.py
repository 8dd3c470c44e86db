"""How far do heat and moisture pull down the frequencies of composite links, and by what?

The moist composite four-bar at 20 rad/s: over the moisture of its resin, from dry to saturated; and
over the time of exposure to 85 % humidity at 80 degC, in which water is still on its way in and one
link, wet from one side, is bent. The change is split into the effects of softening, swelling and
the water's mass, each by leaving the others out of the model.

    python scenarios/16_heat_and_moisture.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import pandas as pd

import flexmech
from flexmech import Exposure, HygrothermalState, mechanism_in_state, plots
from flexmech.modelfile import mechanism_from_toml

ELEMENTS, SPEED = 8, 20.0
POSITIONS = np.radians(np.arange(0.0, 360.0, 30.0))  # over which changes are averaged
RISE, HUMIDITY = 60.0, 0.85
MOISTURES = np.linspace(0.0, 0.05, 11)
DAYS = np.linspace(0.0, 14.0, 15) ** 2
SOFTENING = {"glass_transition"}
SWELLING = {"thermal_expansion", "wet_thermal_expansion", "moisture_expansion"}
SWELLING |= {"ground_thermal_expansion"}


def linkage(*left_out):
    """The dry linkage without some of its properties."""
    lines = flexmech.example_model("moist_composite_fourbar").read_text().splitlines()
    names = set().union(*left_out)
    kept = [line for line in lines if line.partition("=")[0].strip() not in names]
    return mechanism_from_toml("\n".join(kept))


def frequencies(mechanism):
    """Hz at the positions and the crank speed; (positions, modes)."""
    # Links bent by their moisture need beams with shear; the dry ones get the same.
    engine = flexmech.ReferenceEngine(mechanism, ELEMENTS, "timoshenko")
    return flexmech.natural_frequencies(engine, POSITIONS, SPEED, modes=3)


def along(states, column, values):
    """A row for each state and mode: water, bend, and the change of frequency by each part in %."""
    dry, rows = linkage(), []
    models = dry, linkage(SWELLING), linkage(SOFTENING), linkage(SOFTENING, SWELLING)
    length, mass = dry.linkage.topology.links[-1].length, dry.link_mass("crank").moment(0)
    for state, value in zip(states, values, strict=True):
        wet = mechanism_in_state(dry, state)
        whole, soft, swollen, heavy = (frequencies(mechanism_in_state(m, state)) for m in models)
        rest = frequencies(dry)
        parts = {"all": whole / rest, "softening": soft / heavy, "swelling": swollen / heavy}
        for mode in range(3):
            row = {column: value, "mode": mode + 1}
            row["water_of_crank_percent"] = 100 * (wet.link_mass("crank").moment(0) / mass - 1)
            row["bend_of_rocker_mm"] = 125 * wet.sections["rocker"].free_curvature * length**2
            for part, ratio in {**parts, "mass": heavy / rest}.items():
                row[f"{part}_percent"] = 100 * (ratio[:, mode].mean() - 1)
            rows.append(row)
    table = pd.DataFrame(rows)
    table.to_csv(f"by_{column}.csv", index=False, float_format="%.8g")
    print(
        f"last state, mean over the turn: {states[-1].label}\n{table.tail(3).round(3).to_string()}"
    )
    return table


by_moisture = along([HygrothermalState(RISE, float(m)) for m in MOISTURES], "moisture", MOISTURES)
by_time = along([Exposure(RISE, HUMIDITY, 86400.0 * float(day)) for day in DAYS], "days", DAYS)
with plots.sheet(plots.grid(1, 2, 2.9, sharey=True)) as drawn:
    first = [table[table["mode"] == 1] for table in (by_moisture, by_time)]
    along_x = (100 * first[0]["moisture"], first[1]["days"] ** 0.5)
    labels = ("Moisture of the resin (%)", "Root of the exposure (√day)")
    for axes, rows, x, label in zip(drawn.panels, first, along_x, labels, strict=True):
        for number, part in enumerate(("all", "softening", "swelling", "mass")):
            look = plots.series_line(number) | {"marker": plots.series_style(number).marker}
            axes.plot(x, rows[f"{part}_percent"], **(look | {"markersize": 3, "label": part}))
        axes.set_xlabel(label)
    drawn.panels[0].set_ylabel("Change of the first frequency (%)")
    drawn.header(drawn.panels[0].lines, f"Change from the dry linkage at +{RISE:g} K, mean of turn")
drawn.figure.savefig("parts.png")
