"""How much of the effect of crank speed does the classical axial force miss?

Turcic & Midha (as in Kumar & Chandrakar, eq. 1.58) stiffen each element by the axial force of
the rigid motion's inertia forces. The same forces also bend the links, which turns the pinned
neighbours and bows the links themselves; at first order in the load that weighs as much. Both
forms are set side by side, without rotation terms, for the steel and the aluminium four-bar:
against crank speed at two crank angles, and over the turn.

    python scenarios/axial_force_alone.py [--out results/axial_force_alone]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech import ComputationError, ReferenceEngine, natural_frequencies
from flexmech.linear_system import Prestress
from flexmech.plots import publication_style
from flexmech.plots.panels import grid_height, panel_grid
from flexmech.plots.style import (
    MID_GREY,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    series_handle,
    series_style,
    speed_label,
)

FloatArray = NDArray[np.float64]

MODES = 3
LEVELS: tuple[Prestress, Prestress] = ("axial", "equilibrium")
LABELS = {"axial": "axial forces alone", "equilibrium": "equilibrium"}
ANGLES = np.radians([0.0, 60.0])
TURN = np.radians(np.arange(0.0, 361.0))
TURN_SPEEDS = np.array([0.0, 20.0, 40.0])
SPEEDS = np.arange(0.0, 41.0)
MISSED_GREY = "0.85"

# OpenSees, not this project: corotational beams for the equilibrium (64 elements a link,
# Exudyn's ANCF beams agree to 3e-5), P-Delta for the axial forces.
# (mechanism, crank angle in deg, crank speed in rad/s) -> f1, f2, f3 in Hz.
INDEPENDENT: dict[str, dict[tuple[str, int, int], tuple[float, float, float]]] = {
    "equilibrium": {
        ("steel", 0, 20): (62.1859, 127.977, 170.519),
        ("steel", 60, 20): (95.1136, 135.625, 232.711),
        ("aluminium", 0, 20): (45.158, 47.683, 114.499),
        ("aluminium", 60, 20): (45.050, 48.966, 175.244),
    },
    "axial": {
        ("steel", 0, 20): (62.1021, 127.9497, 170.594),
        ("steel", 60, 40): (95.4045, 135.472, 233.434),
        ("aluminium", 0, 20): (44.864, 47.9225, 114.536),
    },
}


@dataclass(frozen=True)
class AxialForceAnswer:
    """Frequencies of one mechanism by both forms, in Hz; nan where no equilibrium was found.

    Parameters
    ----------
    speeds : ndarray, shape (S,)
        rad/s, the first 0.
    by_speed : dict of str to ndarray, shape (2, S, 3)
        ``"axial"`` and ``"equilibrium"``, at the crank angles ``ANGLES``.
    turn : ndarray, shape (A,)
        Crank angles of a full turn, rad.
    over_turn : dict of str to ndarray, shape (3, A, 3)
        At the crank speeds ``TURN_SPEEDS``.
    not_found : list of str
        Where an equilibrium was not found, and why.
    """

    speeds: FloatArray
    by_speed: dict[str, FloatArray]
    turn: FloatArray
    over_turn: dict[str, FloatArray]
    not_found: list[str]

    def at(self, form: str, angle: float, speed: float) -> FloatArray:
        """Frequencies at one of ``ANGLES`` and one of ``speeds``; shape (3,)."""
        position = int(np.argmin(np.abs(ANGLES - angle)))
        values: FloatArray = self.by_speed[form][position, int(np.argmin(abs(self.speeds - speed)))]
        return values

    def caught(self, angle: float, speed: float) -> FloatArray:
        """Part of the equilibrium's effect of speed that axial forces alone give; (3,).

        More than 1 is too much of it, less than 0 a change to the wrong side.
        """
        rest = self.at("axial", angle, 0.0)
        whole = self.at("equilibrium", angle, speed) - rest
        return np.asarray((self.at("axial", angle, speed) - rest) / whole)

    def missed(self) -> FloatArray:
        """Frequency by axial forces alone over that at equilibrium, less 1; (3, A, 3)."""
        return np.asarray(self.over_turn["axial"] / self.over_turn["equilibrium"] - 1)


def main(
    out: Path, *, speeds: FloatArray = SPEEDS, turn: FloatArray = TURN, elements: int = 16
) -> dict[str, AxialForceAnswer]:
    """Compute both forms, print what the classical one misses, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    speeds : ndarray, shape (S,)
        Crank speeds in rad/s, with 0, 20 and 40 among them, 0 first.
    turn : ndarray, shape (A,)
        Crank angles of a full turn, rad.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to AxialForceAnswer
        By ``"steel"`` and ``"aluminium"``.
    """
    answers, figures = {}, {}
    for name in ("steel", "aluminium"):
        answer = compare(ReferenceEngine(four_bar(name), elements), speeds, turn)
        answers[name] = answer
        figures[f"{name}_by_speed.png"] = _draw_by_speed(name, answer)
        figures[f"{name}_over_turn.png"] = _draw_over_turn(name, answer)
        _report(name, answer)
    print("pictures: " + ", ".join(str(path) for path in save_pictures(figures, out)))
    return answers


def compare(engine: ReferenceEngine, speeds: FloatArray, turn: FloatArray) -> AxialForceAnswer:
    """Frequencies of both forms, where an equilibrium exists."""
    by_speed: dict[str, FloatArray] = {}
    over_turn: dict[str, FloatArray] = {}
    not_found: list[str] = []
    for form in LEVELS:
        by_speed[form], lost = _frequencies(engine, ANGLES[:, None], speeds, form)
        over_turn[form], lost_on_turn = _frequencies(engine, turn, TURN_SPEEDS[:, None], form)
        not_found += [*lost, *lost_on_turn]
    return AxialForceAnswer(speeds, by_speed, turn, over_turn, not_found)


def _frequencies(
    engine: ReferenceEngine, angles: FloatArray, speeds: FloatArray, form: Prestress
) -> tuple[FloatArray, list[str]]:
    """Frequencies (..., 3), nan where there is no stable equilibrium, and the reasons."""

    def solve(angle: FloatArray, speed: FloatArray) -> FloatArray:
        return natural_frequencies(
            engine, angle, speed, modes=MODES, prestress=form, rotation_terms=False
        )

    try:
        return solve(angles, speeds), []
    except ComputationError:  # in one position at least: each one apart tells in which
        return _one_by_one(solve, angles, speeds)


def _one_by_one(
    solve: Callable[[FloatArray, FloatArray], FloatArray], angles: FloatArray, speeds: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Solve position by position; nan and the reason where that fails."""
    angle, speed = np.broadcast_arrays(angles, speeds)
    values, lost = np.full((*angle.shape, MODES), np.nan), []
    for place in np.ndindex(*angle.shape):
        try:
            values[place] = solve(angle[place], speed[place])
        except ComputationError as error:
            lost.append(str(error))
    return values, lost


def _handles() -> list[Artist]:
    # Equilibrium first: the whole effect, of which the other is a part.
    return [series_handle(n, LABELS[form]) for n, form in enumerate(reversed(LEVELS))]


def _draw_by_speed(name: str, answer: AxialForceAnswer) -> Figure:
    """Relative change against crank speed: rows are modes, columns crank angles."""
    title = f"{name.capitalize()} four-bar: change of frequency with crank speed"
    with publication_style():
        independent = Line2D(
            [],
            [],
            linestyle="",
            marker="o",
            markerfacecolor="white",
            markeredgecolor=MID_GREY,
            label="OpenSees",
        )
        handles: list[Artist] = [*_handles(), independent]
        figure = new_figure(5.2 + header_height(handles, title))
        grid = figure.subplots(MODES, len(ANGLES), sharex=True, sharey="row")
        for column, angle in enumerate(ANGLES):
            degrees = round(float(np.degrees(angle)))
            rest = answer.at("axial", angle, 0.0)
            for mode, axes in enumerate(grid[:, column]):
                axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
                for number, form in enumerate(reversed(LEVELS)):
                    change = 100 * (answer.by_speed[form][column, :, mode] / rest[mode] - 1)
                    style = series_style(number)
                    axes.plot(answer.speeds, change, color=style.color, linestyle=style.linestyle)
                    _mark_independent(axes, number, (name, degrees), form, rest, mode)
                axes.set_title(f"{mode_label([mode + 1])}, crank angle {degrees}°")
                axes.set_xlim(0, 1.02 * answer.speeds[-1])
                plain_numbers(axes)
            grid[-1, column].set_xlabel("Crank speed (rad/s)")
        figure.supylabel("Change of frequency (%)", fontsize=9)
        header_legend(figure, handles, title)
    return figure


def _mark_independent(
    axes: Axes, number: int, place: tuple[str, int], form: str, rest: FloatArray, mode: int
) -> None:
    for (name, degrees, speed), frequencies in INDEPENDENT[form].items():
        if (name, degrees) == place:
            axes.plot(
                speed,
                100 * (frequencies[mode] / rest[mode] - 1),
                linestyle="",
                marker="o",
                markersize=4.5,
                markerfacecolor="white",
                markeredgecolor=series_style(number).color,
                zorder=3,
            )


def _draw_over_turn(name: str, answer: AxialForceAnswer) -> Figure:
    """Relative change from rest to 20 rad/s against crank angle, one panel a mode."""
    speed = 1
    title = (
        f"{name.capitalize()} four-bar: change of frequency from rest to "
        f"{speed_label(TURN_SPEEDS[speed])}"
    )
    angles = np.round(np.degrees(answer.turn), 9).astype(float)
    with publication_style():
        handles = [*_handles(), Patch(color=MISSED_GREY, label="missed by axial forces alone")]
        sizes = [1] * MODES
        figure = new_figure(grid_height(sizes) + header_height(handles, title))
        for mode, axes in enumerate(panel_grid(figure, sizes, angles, "Change of frequency (%)")):
            axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
            changes = []
            for number, form in enumerate(reversed(LEVELS)):
                values = answer.over_turn[form][..., mode]
                changes.append(100 * (values[speed] / values[0] - 1))
                style = series_style(number)
                axes.plot(angles, changes[-1], color=style.color, linestyle=style.linestyle)
            axes.fill_between(angles, *changes, color=MISSED_GREY, lw=0, zorder=0.5)
            axes.set_title(mode_label([mode + 1]))
            plain_numbers(axes)
        header_legend(figure, handles, title)
    return figure


def _report(name: str, answer: AxialForceAnswer) -> None:
    print(f"{name} four-bar, no rotation terms (Hz; in brackets OpenSees)")
    for angle in ANGLES:
        degrees = round(float(np.degrees(angle)))
        print(f"  crank angle {degrees} deg, at rest: {_numbers(answer.at('axial', angle, 0.0))}")
        for speed in (20, 40):
            for form in LEVELS:
                known = INDEPENDENT[form].get((name, degrees, speed))
                beside = f"  [{', '.join(f'{value:.7g}' for value in known)}]" if known else ""
                values = _numbers(answer.at(form, angle, speed))
                print(f"    {speed} rad/s, {LABELS[form]:18s}: {values}{beside}")
            caught = answer.caught(angle, speed)
            print(
                f"    {speed} rad/s, part of the effect caught by axial forces alone: "
                + ", ".join(f"{part:.2f}" for part in caught)
            )
    for number, speed in enumerate(TURN_SPEEDS[1:], start=1):
        for mode in range(MODES):
            missed = answer.missed()[number, :, mode]
            worst = int(np.nanargmax(np.abs(missed)))
            effect = answer.over_turn["equilibrium"][[0, number], :, mode]
            weight = np.nanmean(missed**2) / np.nanmean((effect[1] / effect[0] - 1) ** 2)
            print(
                f"  over the turn, {speed:g} rad/s, mode {mode + 1}: axial forces alone are off "
                f"by up to {100 * missed[worst]:+.2f} %, at {np.degrees(answer.turn[worst]):.0f} "
                f"deg; root mean square {np.sqrt(weight):.2f} of the whole effect of speed"
            )
    print(
        "  no equilibrium found: " + "; ".join(answer.not_found)
        if answer.not_found
        else "  an equilibrium was found in every position and at every speed"
    )


def _numbers(values: FloatArray) -> str:
    return ", ".join(f"{value:.4f}" for value in values)


if __name__ == "__main__":
    main(output_folder(__doc__, "results/axial_force_alone"))
