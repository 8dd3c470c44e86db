"""How far do heat and moisture pull down the frequencies of composite links, and by what?

The moist composite four-bar: over the crank angle at 10 and 20 rad/s, dry and in equilibrium with
85 % humidity at 80 degC, and what these speeds add to it at rest in both states; at 20 rad/s over
the moisture, from dry to saturated; and over the time of exposure, in which water is still on its
way in and one link, wet from one side, is bent. The change is split into what softening, swelling
and the water's mass do, each by leaving the others out of the model. Both engines are set side by
side at a few points.

    python scenarios/16_heat_and_moisture.py
"""  # noqa: D400 - a scenario asks a question

from functools import cache

import numpy as np
import pandas as pd

from flexmech import (
    Exposure,
    ExudynEngine,
    HygrothermalState,
    ReferenceEngine,
    example_model,
    mechanism_in_state,
    moving_frequencies,
    natural_frequencies,
    plots,
)
from flexmech.modelfile import mechanism_from_toml

ELEMENTS = 8
SPEEDS, SPEED = np.array([0.0, 10.0, 20.0]), 20.0
TURN = np.radians(np.arange(0.0, 361.0, 2.5))
POSITIONS = np.radians(np.arange(0.0, 360.0, 30.0))  # over which changes are averaged
COMPARED = np.radians([0.0, 90.0, 200.0])  # by both engines
RISE, HUMIDITY, GREATEST_MOISTURE = 60.0, 0.85, 0.05
MOISTURES = np.linspace(0.0, GREATEST_MOISTURE, 11)
DAYS = np.linspace(0.0, 14.0, 15) ** 2
EVENLY_WET = HygrothermalState(RISE, HUMIDITY * GREATEST_MOISTURE)
# Links bent by their moisture need beams with shear; the dry ones get the same.
BEAM, EXUDYN_BEAM = "timoshenko", "geometrically-exact"
SOFTENING = {"glass_transition"}
SWELLING = {"thermal_expansion", "wet_thermal_expansion", "moisture_expansion"}
SWELLING |= {"ground_thermal_expansion"}
LEFT_OUT = {"all": set(), "no swelling": SWELLING, "no softening": SOFTENING}
LEFT_OUT["mass"] = SOFTENING | SWELLING
PARTS = {
    "all": "altogether",
    "softening": "softening alone",
    "swelling": "swelling alone",
    "mass": "mass of the water alone",
}


@cache
def dry(part="all"):
    """The linkage without the properties that ``LEFT_OUT`` names."""
    lines = example_model("moist_composite_fourbar").read_text().splitlines()
    kept = [line for line in lines if line.partition("=")[0].strip() not in LEFT_OUT[part]]
    return mechanism_from_toml("\n".join(kept))


def frequencies(mechanism):
    """Hz at the positions and the crank speed; (positions, modes)."""
    engine = ReferenceEngine(mechanism, ELEMENTS, BEAM)
    return natural_frequencies(engine, POSITIONS, SPEED, modes=3)


def masses(mechanism):
    """Mass of each link in kg."""
    return np.array([mechanism.link_mass(link).moment(0) for link in mechanism.sections])


def along(states, column, values):
    """A row for each state and mode: water, bend, frequency, and its change by each part in %."""
    at_rest, rows = frequencies(dry()), []
    for state, value in zip(states, values, strict=True):
        wet = mechanism_in_state(dry(), state)
        found = {part: frequencies(mechanism_in_state(dry(part), state)) for part in LEFT_OUT}
        ratios = {
            "all": found["all"] / at_rest,
            "softening": found["no swelling"] / found["mass"],
            "swelling": found["no softening"] / found["mass"],
            "mass": found["mass"] / at_rest,
        }
        length = dry().linkage.topology.links[-1].length
        for mode in range(3):
            row = {column: value}
            water = 100 * (masses(wet) / masses(dry()) - 1)
            row |= dict(zip((f"water_of_{n}_percent" for n in wet.sections), water, strict=True))
            row["bend_of_rocker_mm"] = 125 * wet.sections["rocker"].free_curvature * length**2
            row |= {"mode": mode + 1, "mean_frequency_Hz": found["all"][:, mode].mean()}
            row |= {f"{p}_percent": 100 * (r[:, mode].mean() - 1) for p, r in ratios.items()}
            rows.append(row)
    return pd.DataFrame(rows)


effect = moving_frequencies(
    ReferenceEngine(dry(), ELEMENTS, BEAM), TURN, SPEEDS, modes=3, environment=EVENLY_WET
)
print(effect.summary())
effect.plot(speeds=SPEEDS[1:].tolist()).savefig("over_crank_angle.png")
frequency = effect.dataset["frequency"].isel(engine=0, drop=True)
by_speed = frequency.isel(crank_speed=slice(1, None)) / frequency.isel(crank_speed=0) - 1
square = (by_speed.isel(crank_speed=-1, crank_angle=slice(-1)) ** 2).mean("crank_angle") ** 0.5
ratios = (square.isel(state=1) / square.isel(state=0)).values
print(
    f"change from rest to {SPEEDS[-1]:g} rad/s, wet over dry (modes 1 to 3, rms over the turn): "
    + ", ".join(f"{ratio:.2f}" for ratio in ratios)
)
by_water = abs(effect.relative_change()).isel(crank_speed=-1).min("crank_angle")
water_leads = bool((by_water > abs(by_speed).max(["state", "crank_speed", "crank_angle"])).all())
further = "further" if water_leads else "not everywhere further"
print(f"heat and water move the frequencies {further} than the speed does")

exposures = [Exposure(RISE, HUMIDITY, 86400.0 * float(day)) for day in DAYS]
evenly = [HygrothermalState(RISE, float(moisture)) for moisture in MOISTURES]
by_moisture = along(evenly, "moisture_percent", 100 * MOISTURES)
by_time = along(exposures, "time_day", DAYS)
print("last state of each series, mean over the turn: altogether = softening, swelling, mass")
for state, table in ((evenly[-1], by_moisture), (exposures[-1], by_time)):
    print(f"  {state.label}")
    for row in table.tail(3).to_dict("records"):
        whole, *parts = (f"{row[f'{part}_percent']:+.3f}" for part in PARTS)
        print(f"    mode {row['mode']}: {whole} % = {', '.join(parts)} %")
bent = by_time.loc[by_time["bend_of_rocker_mm"].abs().idxmax()]
print(f"rocker bent most: {bent['bend_of_rocker_mm']:+.3f} mm, after {bent['time_day']:g} days")

apart = []
print("engines differ by at most (Exudyn with as many elements, with twice as many):")
for state in (HygrothermalState(), EVENLY_WET, exposures[len(DAYS) // 2]):
    wet = mechanism_in_state(dry(), state)
    engines = [ReferenceEngine(wet, ELEMENTS, BEAM)]
    engines += [ExudynEngine(wet, elements, EXUDYN_BEAM) for elements in (8, 16)]
    ours, *others = (natural_frequencies(one, COMPARED, SPEED, modes=3) for one in engines)
    apart.append([np.abs(other / ours - 1).max() for other in others])
    print(f"  {state.label}: {apart[-1][0]:.1e}, {apart[-1][1]:.1e}")

with plots.sheet(plots.grid(3, 1, 4.8, sharex=True)) as drawn:
    degrees = np.degrees(by_speed["crank_angle"].values)
    for mode, axes in enumerate(drawn.panels):
        for number, of_speed in enumerate(SPEEDS[1:]):
            for style, state in zip(("-", "--"), by_speed["state"].values, strict=True):
                change = by_speed.sel(crank_speed=of_speed, state=state).isel(mode=mode)
                look = plots.series_line(number) | {"linestyle": style}
                axes.plot(degrees, 100 * change, **look, label=f"{of_speed:g} rad/s, {state}")
        axes.set_title(plots.mode_label([mode + 1]))
        plots.plain_numbers(axes)
    plots.crank_angle_axis(drawn.panels[-1], degrees)
    drawn.label_x("Crank angle (deg)")
    drawn.label_y("Change of frequency (%)")
    drawn.header(drawn.panels[0].lines, "Moist composite four-bar: change of frequency from rest")
drawn.figure.savefig("by_speed.png")

labels = {"by_moisture": "Moisture of the resin (%)", "by_time": "Root of the exposure (√day)"}
for name, table in {"by_moisture": by_moisture, "by_time": by_time}.items():
    with plots.sheet(plots.grid(1, 3, 2.7, sharey=True)) as drawn:
        for mode, axes in enumerate(drawn.panels, start=1):
            rows = table[table["mode"] == mode]
            along_x = rows.iloc[:, 0] if name == "by_moisture" else rows["time_day"] ** 0.5
            for number, (part, words) in enumerate(PARTS.items()):
                look = plots.series_line(number) | {"label": words}
                look |= {"marker": plots.series_style(number).marker, "markersize": 3}
                axes.plot(along_x, rows[f"{part}_percent"], **look)
            axes.set_title(plots.mode_label([mode]))
        drawn.panels[0].set_ylabel("Change of frequency (%)")
        drawn.label_x(labels[name])
        title = f"Change of the frequencies from the dry linkage at +{RISE:g} K, mean over the turn"
        drawn.header(drawn.panels[0].lines, title)
    drawn.figure.savefig(f"{name}.png")

tables = {"by_moisture": by_moisture, "by_time": by_time}
tables["over_crank_angle"] = effect.tables()["hygrothermal_effect"]
for name, table in tables.items():
    table.to_csv(f"{name}.csv", index=False, float_format="%.8g")
