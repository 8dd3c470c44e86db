"""How far do heat and moisture pull down the frequencies of composite links, and by what?

The moist composite four-bar: over the crank angle at 10 and 20 rad/s, dry and in equilibrium with
85 % humidity at 80 degC, and what these speeds add to it at rest in both states; at 20 rad/s over
the moisture, from dry to saturated; and over the time of exposure, in which water is still on its
way in and one link, wet from one side, is bent. The change is split
into what softening, swelling and the water's mass do, each by leaving the others out of the
model. Both engines are set side by side at a few points.

    python scenarios/hygrothermal_frequencies.py [--out results/hygrothermal_frequencies]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from _common import SPEEDS, mean_over_turn, output_folder, save_pictures
from _moist_linkage import (
    DAY,
    EVENLY_WET,
    GREATEST_MOISTURE,
    HUMIDITY,
    MODES,
    RISE,
    Agreement,
    Series,
    along,
    compared,
    over_turn,
)
from matplotlib.figure import Figure

from flexmech import Exposure, HygrothermalState, MovingFrequencies, plots
from flexmech.arrays import FloatArray

TURN = np.radians(np.arange(0.0, 361.0, 2.5))
MOISTURES = np.linspace(0.0, GREATEST_MOISTURE, 11)
TIMES = DAY * np.linspace(0.0, 14.0, 15) ** 2
# Crank angles over which the changes are averaged.
POSITIONS = np.radians(np.arange(0.0, 360.0, 30.0))

PARTS = {
    "all": "altogether",
    "softening": "softening alone",
    "swelling": "swelling alone",
    "mass": "mass of the water alone",
}


@dataclass(frozen=True)
class Answer:
    """What was found.

    Parameters
    ----------
    effect : MovingFrequencies
        Over the crank angle at rest, 10 and 20 rad/s, dry and wet.
    by_moisture, by_time : Series
    agreement : list of Agreement
    """

    effect: MovingFrequencies
    by_moisture: Series
    by_time: Series
    agreement: list[Agreement]

    @property
    def by_speed(self) -> xr.DataArray:
        """Relative change of the frequencies from rest, over state, crank_speed, angle and mode."""
        frequency = self.effect.dataset["frequency"].isel(engine=0, drop=True)
        return frequency.isel(crank_speed=slice(1, None)) / frequency.isel(crank_speed=0) - 1

    @property
    def wet_to_dry(self) -> FloatArray:
        """Change by the greatest speed, wet over dry, root mean square over the turn; (3,)."""
        change = self.by_speed.isel(crank_speed=-1).transpose("state", "crank_angle", "mode")
        dry, wet = (mean_over_turn(each) for each in change.values)
        return wet / dry

    @property
    def water_leads(self) -> bool:
        """Whether heat and water move each frequency further than the speed does, everywhere."""
        water = abs(self.effect.relative_change()).isel(crank_speed=-1).min("crank_angle")
        speed = abs(self.by_speed).max(["state", "crank_speed", "crank_angle"])
        return bool((water > speed).all())


def main(
    out: Path,
    *,
    crank_angles: FloatArray = TURN,
    moistures: FloatArray = MOISTURES,
    times: FloatArray = TIMES,
    positions: FloatArray = POSITIONS,
    elements: int = 8,
    exudyn_elements: int = 8,
) -> Answer:
    """Compute, print, draw and write.

    Parameters
    ----------
    out : Path
        Folder for pictures and tables.
    crank_angles : ndarray, shape (A,)
        Of the first picture in rad.
    moistures : ndarray, shape (M,)
        Of the second.
    times : ndarray, shape (T,)
        Of the third in s.
    positions : ndarray, shape (P,)
        Crank angles in rad over which the changes are averaged.
    elements, exudyn_elements : int
        Elements a link of the built-in model, and the fewer ones of Exudyn's.

    Returns
    -------
    Answer
    """
    effect = over_turn(crank_angles, elements)
    evenly = [HygrothermalState(RISE, float(moisture)) for moisture in moistures]
    exposed = [Exposure(RISE, HUMIDITY, float(time)) for time in times]
    by_moisture, by_time = (along(states, positions, elements) for states in (evenly, exposed))
    states = (HygrothermalState(), EVENLY_WET, exposed[len(times) // 2])
    agreement = [compared(state, elements, exudyn_elements) for state in states]
    answer = Answer(effect, by_moisture, by_time, agreement)
    _report(answer)
    where, days = f"at {RISE:+g} K", times / DAY
    along_time = f"{where} and {100 * HUMIDITY:g} % humidity"
    root = "Root of the time of exposure (\N{SQUARE ROOT}day)"
    pictures = {
        "over_crank_angle": effect.plot(speeds=SPEEDS[1:].tolist()),
        "by_speed": _draw_by_speed(answer),
        "by_moisture": draw(100 * moistures, by_moisture, "Moisture of the resin (%)", where),
        "by_time": draw(np.sqrt(days), by_time, root, along_time),
    }
    save_pictures(pictures, out)
    tables = {
        "over_crank_angle": effect.tables()["hygrothermal_effect"],
        "by_moisture": table(by_moisture, "moisture_percent", 100 * moistures),
        "by_time": table(by_time, "time_day", days),
    }
    for name, frame in tables.items():
        frame.to_csv(out / f"{name}.csv", index=False, float_format="%.8g")
    return answer


def draw(values: FloatArray, series: Series, label: str, where: str) -> Figure:
    """Changes along a series, altogether and by part, one panel a mode.

    Parameters
    ----------
    values : ndarray, shape (S,)
        Along the x axis.
    series : Series
    label : str
        Of the x axis.
    where : str
        For the title.

    Returns
    -------
    Figure
    """
    marks = [{"marker": plots.series_style(n).marker, "markersize": 3} for n in range(len(PARTS))]
    with plots.sheet(plots.grid(1, MODES, 2.7, sharey=True)) as drawn:
        for mode, axes in enumerate(drawn.panels):
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            for number, part in enumerate(PARTS):
                change = 100 * series.change[part][:, mode]
                axes.plot(values, change, **(plots.series_line(number) | marks[number]))
            axes.set_title(plots.mode_label([mode + 1]))
        drawn.panels[0].set_ylabel("Change of frequency (%)")
        plots.plain_numbers(drawn.panels[0])
        drawn.figure.supxlabel(label, fontsize=9)
        drawn.header(
            [plots.series_handle(n, words, **marks[n]) for n, words in enumerate(PARTS.values())],
            f"Change of the natural frequencies from the dry linkage {where}, mean over the turn",
        )
    return drawn.figure


def _draw_by_speed(answer: Answer) -> Figure:
    """Change from rest in percent against crank angle, one panel a mode."""
    change = 100 * answer.by_speed
    degrees = np.round(np.degrees(change["crank_angle"].values), 9)
    lines = {"linestyle": "-", "linewidth": 1.2}, {"linestyle": "--", "linewidth": 1.5}
    states = dict(zip(change["state"].values, lines, strict=True))
    speeds = change["crank_speed"].values
    with plots.sheet(plots.grid(MODES, 1, 4.8, sharex=True)) as drawn:
        for mode, axes in enumerate(drawn.panels):
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            for number, speed in enumerate(speeds):
                for state, look in states.items():
                    values = change.sel(state=state, crank_speed=speed).isel(mode=mode)
                    axes.plot(degrees, values, **(plots.series_line(number) | look))
            axes.set_title(plots.mode_label([mode + 1]))
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], degrees)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (%)")
        of_state = [plots.line_handle(n, color=plots.MID_GREY, **k) for n, k in states.items()]
        of_speed = [
            plots.line_handle(plots.speed_label(speed), color=plots.series_style(n).color)
            for n, speed in enumerate(speeds)
        ]
        drawn.header(
            [*of_state, *of_speed], "Moist composite four-bar: change of frequency from rest"
        )
    return drawn.figure


def table(series: Series, name: str, values: FloatArray) -> pd.DataFrame:
    """One row for each state and mode.

    Parameters
    ----------
    series : Series
    name : str
        Of the first column.
    values : ndarray, shape (S,)
        In it.

    Returns
    -------
    DataFrame
    """
    links = ("crank", "coupler", "rocker")
    rows = [
        {
            name: value,
            **{
                f"water_of_{link}_percent": 100 * share
                for link, share in zip(links, series.water[number], strict=True)
            },
            "bend_of_rocker_mm": 1e3 * series.bend[number],
            "mode": mode + 1,
            "mean_frequency_Hz": series.frequency[number, mode],
            **{f"{part}_percent": 100 * series.change[part][number, mode] for part in PARTS},
        }
        for number, value in enumerate(values)
        for mode in range(MODES)
    ]
    return pd.DataFrame(rows)


def _report(answer: Answer) -> None:
    print(answer.effect.summary())
    speed = plots.speed_label(SPEEDS[-1])
    ratios = ", ".join(f"{ratio:.2f}" for ratio in answer.wet_to_dry)
    print(f"change from rest to {speed}, wet over dry (modes 1 to 3, rms over the turn): {ratios}")
    leads = "further" if answer.water_leads else "not everywhere further"
    print(f"heat and water move the frequencies {leads} than the speed does")
    print("last state of each series, mean over the turn: altogether = softening, swelling, mass")
    for series in (answer.by_moisture, answer.by_time):
        print(f"  {series.states[-1].label}")
        for mode in range(MODES):
            parts = [f"{100 * series.change[part][-1, mode]:+.3f}" for part in PARTS]
            print(f"    mode {mode + 1}: {parts[0]} % = {', '.join(parts[1:])} %")
    bend = answer.by_time.bend
    most = int(np.abs(bend).argmax())
    print(f"rocker bent most: {1e3 * bend[most]:+.3f} mm, {answer.by_time.states[most].label}")
    print("engines differ by at most (Exudyn coarse, fine):")
    for gap in answer.agreement:
        print(f"  {gap.state}: {gap.coarse:.1e}, {gap.fine:.1e}")


if __name__ == "__main__":
    main(output_folder(__doc__, "results/hygrothermal_frequencies"))
