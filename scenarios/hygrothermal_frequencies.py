"""How far do heat and moisture pull down the frequencies of composite links, and by what?

The moist composite four-bar at 20 rad/s: over the crank angle, dry and in equilibrium with 85 %
humidity at 80 degC; over the moisture, from dry to saturated; and over the time of exposure, in
which water is still on its way in and one link, wet from one side, is bent. The change is split
into what softening, swelling and the water's mass do, each by leaving the others out of the
model. Both engines are set side by side at a few points.

    python scenarios/hygrothermal_frequencies.py [--out results/hygrothermal_frequencies]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from _common import DOTS_PER_INCH, output_folder
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
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech.analyses import HygrothermalEffect
from flexmech.files import moved_into
from flexmech.hygrothermal import Exposure, HygrothermalState
from flexmech.plots import publication_style
from flexmech.plots.style import (
    MID_GREY,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    series_handle,
    series_style,
)

FloatArray = NDArray[np.float64]

TURN = np.radians(np.arange(0.0, 361.0, 5.0))
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
    effect : HygrothermalEffect
        Over the crank angle.
    by_moisture, by_time : Series
    agreement : list of Agreement
    pictures : list of Path
    """

    effect: HygrothermalEffect
    by_moisture: Series
    by_time: Series
    agreement: list[Agreement]
    pictures: list[Path]


def main(
    out: Path,
    *,
    crank_angles: FloatArray = TURN,
    moistures: FloatArray = MOISTURES,
    times: FloatArray = TIMES,
    positions: FloatArray = POSITIONS,
    elements: int = 8,
    exudyn_elements: int = 32,
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
    percent, roots = 100 * moistures, np.sqrt(times / DAY)
    pictures = {
        "over_crank_angle.png": effect.plot(),
        "by_moisture.png": draw(
            percent, by_moisture, "Moisture of the resin (%)", f"at {RISE:+g} K"
        ),
        "by_time.png": draw(
            roots,
            by_time,
            "Root of the time of exposure (\N{SQUARE ROOT}day)",
            f"at {RISE:+g} K and {100 * HUMIDITY:g} % humidity",
        ),
    }
    with moved_into(out) as folder:
        for name, picture in pictures.items():
            picture.savefig(folder / name, dpi=DOTS_PER_INCH)
        tables = {
            "over_crank_angle.csv": effect.table(),
            "by_moisture.csv": table(by_moisture, "moisture_percent", percent),
            "by_time.csv": table(by_time, "time_day", times / DAY),
        }
        for name, frame in tables.items():
            frame.to_csv(folder / name, index=False, float_format="%.8g")
    answer = Answer(effect, by_moisture, by_time, agreement, [out / name for name in pictures])
    _report(answer)
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
    title = f"Change of the natural frequencies from the dry linkage {where}, mean over the turn"
    with publication_style():
        handles: list[Artist] = [
            series_handle(n, words, marker=series_style(n).marker, markersize=3)
            for n, words in enumerate(PARTS.values())
        ]
        figure = new_figure(2.7 + header_height(handles, title))
        panels = figure.subplots(1, MODES, sharey=True)
        for mode, axes in enumerate(panels):
            axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
            for number, part in enumerate(PARTS):
                style = series_style(number)
                axes.plot(
                    values,
                    100 * series.change[part][:, mode],
                    color=style.color,
                    linestyle=style.linestyle,
                    marker=style.marker,
                    markersize=3,
                )
            axes.set_title(mode_label([mode + 1]))
        panels[0].set_ylabel("Change of frequency (%)")
        plain_numbers(panels[0])
        figure.supxlabel(label, fontsize=9)
        header_legend(figure, handles, title)
    return figure


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
    rows = []
    for number, value in enumerate(values):
        water = dict(zip(("crank", "coupler", "rocker"), series.water[number], strict=True))
        for mode in range(MODES):
            rows.append(
                {
                    name: value,
                    **{f"water_of_{link}_percent": 100 * share for link, share in water.items()},
                    "bend_of_rocker_mm": 1e3 * series.bend[number],
                    "mode": mode + 1,
                    "mean_frequency_Hz": series.frequency[number, mode],
                    **{
                        f"{part}_percent": 100 * change[number, mode]
                        for part, change in series.change.items()
                    },
                }
            )
    return pd.DataFrame(rows)


def _report(answer: Answer) -> None:
    change = 100 * answer.effect.relative_change.isel(engine=0, crank_speed=0)
    print(f"{EVENLY_WET.label}, over the turn:")
    for mode in change["mode"].values:
        one = change.sel(mode=mode)
        print(f"  mode {mode}: {float(one.min()):+.2f} to {float(one.max()):+.2f} %")
    print("last state of each series, mean over the turn: altogether = softening, swelling, mass")
    for series in (answer.by_moisture, answer.by_time):
        print(f"  {series.states[-1].label}")
        for mode in range(MODES):
            parts = [f"{100 * series.change[part][-1, mode]:+.3f}" for part in PARTS]
            print(f"    mode {mode + 1}: {parts[0]} % = {', '.join(parts[1:])} %")
    bend = answer.by_time.bend
    most = int(np.abs(bend).argmax())
    print(f"rocker bent most: {1e3 * bend[most]:+.3f} mm, {answer.by_time.states[most].label}")
    print("engines differ by at most (Exudyn coarse, fine, extrapolated):")
    for gap in answer.agreement:
        print(f"  {gap.state}: {gap.coarse:.1e}, {gap.fine:.1e}, {gap.limit:.1e}")
    print("pictures: " + ", ".join(str(path) for path in answer.pictures))


if __name__ == "__main__":
    main(output_folder(__doc__, "results/hygrothermal_frequencies"))
