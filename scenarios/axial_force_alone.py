"""How much of the effect of crank speed does the classical axial force miss?

Turcic & Midha (as in Kumar & Chandrakar, eq. 1.58) stiffen each element by the axial force of
the rigid motion's inertia forces. The same forces also bend the links, which turns the pinned
neighbours and bows the links themselves; at first order in the load that weighs as much. Both
forms are set side by side, without rotation terms, for the steel and the aluminium four-bar:
against crank speed at two crank angles, and over the turn.

    python scenarios/axial_force_alone.py [--out results/axial_force_alone]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from _common import four_bar, output_folder, save_pictures
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech import ComputationError, ReferenceEngine, natural_frequencies, plots
from flexmech.arrays import FloatArray
from flexmech.mechanics import Prestress
from flexmech.verification import verification_cases

MODES = 3
# Equilibrium first: the whole effect, of which the other is a part.
LABELS: dict[Prestress, str] = {"equilibrium": "equilibrium", "axial": "axial forces alone"}
ANGLES = np.radians([0.0, 60.0])
TURN = np.radians(np.arange(0.0, 361.0))
TURN_SPEEDS = np.array([0.0, 20.0, 40.0])
SPEEDS = np.arange(0.0, 41.0)
MISSED_GREY = "0.85"

# OpenSees, not this project, as the verification has it: corotational beams for the equilibrium (64
# elements a link, Exudyn's ANCF beams agree to 3e-5), P-Delta for the axial forces.
SUBJECTS = {
    "equilibrium": "Four-bars at equilibrium under their inertia forces",
    "axial": "Four-bars with axial forces alone",
}


def independent(form: str) -> dict[tuple[str, int, int], tuple[float, ...]]:
    """(mechanism, crank angle in deg, crank speed in rad/s) -> f1, f2, f3 in Hz."""
    found = {}
    for case in verification_cases():
        if case.subject == SUBJECTS[form]:
            mechanism, angle, speed, _ = case.name.split(", ")
            key = (mechanism, int(angle.split()[0]), int(speed.split()[0]))
            found[key] = tuple(case.expected_values().tolist())
    return found


INDEPENDENT = {form: independent(form) for form in SUBJECTS}


@dataclass(frozen=True)
class AxialForceAnswer:
    """Frequencies of one mechanism by both forms, in Hz; nan where no equilibrium was found.

    Parameters
    ----------
    by_speed : DataArray
        Over ``form`` (axial, equilibrium), ``speed`` in rad/s (the first 0), ``angle`` in rad
        (``ANGLES``) and ``mode``.
    over_turn : DataArray
        The same at the speeds ``TURN_SPEEDS`` and all angles of a full turn.
    not_found : list of str
        Where an equilibrium was not found, and why.
    """

    by_speed: xr.DataArray
    over_turn: xr.DataArray
    not_found: list[str]

    def at(self, form: str, angle: float, speed: float) -> FloatArray:
        """Frequencies at one of ``ANGLES`` and one of the speeds; shape (3,)."""
        place = self.by_speed.sel(angle=angle, speed=speed, method="nearest")
        return np.asarray(place.sel(form=form))

    def caught(self, angle: float, speed: float) -> FloatArray:
        """Part of the equilibrium's effect of speed that axial forces alone give; (3,).

        More than 1 is too much of it, less than 0 a change to the wrong side.
        """
        rest = self.at("axial", angle, 0.0)
        whole = self.at("equilibrium", angle, speed) - rest
        return np.asarray((self.at("axial", angle, speed) - rest) / whole)

    def missed(self) -> xr.DataArray:
        """Frequency by axial forces alone over that at equilibrium, less 1, over the turn."""
        return self.over_turn.sel(form="axial") / self.over_turn.sel(form="equilibrium") - 1


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
        answer = answers[name] = compare(ReferenceEngine(four_bar(name), elements), speeds, turn)
        figures[f"{name}_by_speed"] = _draw_by_speed(name, answer)
        figures[f"{name}_over_turn"] = _draw_over_turn(name, answer)
        _report(name, answer)
    save_pictures(figures, out)
    return answers


def compare(engine: ReferenceEngine, speeds: FloatArray, turn: FloatArray) -> AxialForceAnswer:
    """Frequencies of both forms, where an equilibrium exists."""
    not_found: list[str] = []
    by_speed = _both_forms(engine, ANGLES, speeds, not_found)
    over_turn = _both_forms(engine, turn, TURN_SPEEDS, not_found)
    return AxialForceAnswer(by_speed, over_turn, not_found)


def _both_forms(
    engine: ReferenceEngine, angles: FloatArray, speeds: FloatArray, not_found: list[str]
) -> xr.DataArray:
    """Frequencies over form, speed, angle and mode; nan where there is no stable equilibrium."""
    values = np.full((len(LABELS), len(speeds), len(angles), MODES), np.nan)
    for number, form in enumerate(LABELS):

        def solve(angle: FloatArray, speed: FloatArray, form: Prestress = form) -> FloatArray:
            return natural_frequencies(
                engine, angle, speed, modes=MODES, prestress=form, rotation_terms=False
            )

        try:
            values[number] = solve(angles, speeds[:, None])
        except ComputationError:  # in one position at least: each one apart tells in which
            for s, a in np.ndindex(len(speeds), len(angles)):
                try:
                    values[number, s, a] = solve(angles[a], speeds[s])
                except ComputationError as error:
                    not_found.append(str(error))
    places = {"form": list(LABELS), "speed": speeds, "angle": angles}
    return xr.DataArray(values, places, dims=("form", "speed", "angle", "mode"))


def _header(drawn: plots.Sheet, name: str, words: str, last: Artist) -> None:
    forms = [plots.series_handle(number, label) for number, label in enumerate(LABELS.values())]
    title = f"{name.capitalize()} four-bar: change of frequency {words}"
    drawn.header([*forms, last], title)


def _draw_by_speed(name: str, answer: AxialForceAnswer) -> Figure:
    """Relative change against crank speed: rows are modes, columns crank angles."""
    mark: Any = {"linestyle": "", "marker": "o", "markersize": 4.5, "markerfacecolor": "white"}
    with plots.sheet(plots.grid(MODES, len(ANGLES), 5.2, sharex=True, sharey="row")) as drawn:
        for place, axes in enumerate(drawn.panels):
            mode, column = divmod(place, len(ANGLES))
            degrees = round(float(np.degrees(ANGLES[column])))
            rest = answer.at("axial", ANGLES[column], 0.0)[mode]
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            for number, form in enumerate(LABELS):
                frequency = answer.by_speed.sel(form=form).isel(angle=column, mode=mode)
                change, edge = 100 * (frequency / rest - 1), plots.series_style(number).color
                axes.plot(change["speed"], change, **plots.series_line(number))
                for (model, angle, speed), known in INDEPENDENT[form].items():
                    if (model, angle) == (name, degrees):
                        beside = 100 * (known[mode] / rest - 1)
                        axes.plot(speed, beside, **mark, markeredgecolor=edge, zorder=3)
            axes.set_title(f"{plots.mode_label([mode + 1])}, crank angle {degrees}°")
            axes.set_xlim(0, 1.02 * float(answer.by_speed["speed"][-1]))
            plots.plain_numbers(axes)
        drawn.label_x("Crank speed (rad/s)")
        drawn.label_y("Change of frequency (%)")
        last = plots.line_handle("OpenSees", **mark, markeredgecolor=plots.MID_GREY)
        _header(drawn, name, "with crank speed", last)
    return drawn.figure


def _draw_over_turn(name: str, answer: AxialForceAnswer) -> Figure:
    """Relative change from rest to 20 rad/s against crank angle, one panel a mode."""
    angles = np.round(np.degrees(answer.over_turn["angle"].values), 9)
    change = 100 * (answer.over_turn.isel(speed=1) / answer.over_turn.isel(speed=0) - 1)
    with plots.sheet(plots.grid(MODES, 1, 4.7, sharex=True)) as drawn:
        for mode, axes in enumerate(drawn.panels):
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            forms = change.isel(mode=mode).values
            for number, values in enumerate(forms):
                axes.plot(angles, values, **plots.series_line(number))
            axes.fill_between(angles, *forms, color=MISSED_GREY, lw=0, zorder=0.5)
            axes.set_title(plots.mode_label([mode + 1]))
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], angles)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (%)")
        missed = Patch(color=MISSED_GREY, label="missed by axial forces alone")
        _header(drawn, name, f"from rest to {plots.speed_label(TURN_SPEEDS[1])}", missed)
    return drawn.figure


def _report(name: str, answer: AxialForceAnswer) -> None:
    print(f"{name} four-bar, no rotation terms (Hz; in brackets OpenSees)")
    for angle in ANGLES:
        degrees = round(float(np.degrees(angle)))
        print(f"  crank angle {degrees} deg, at rest: {_numbers(answer.at('axial', angle, 0.0))}")
        for speed in (20, 40):
            for form in reversed(LABELS):
                known = INDEPENDENT[form].get((name, degrees, speed))
                beside = (
                    f"  [{', '.join(f'{value:.7g}' for value in known)}]"
                    if known is not None
                    else ""
                )
                values = _numbers(answer.at(form, angle, speed))
                print(f"    {speed} rad/s, {LABELS[form]:18s}: {values}{beside}")
            caught = ", ".join(f"{part:.2f}" for part in answer.caught(angle, speed))
            print(f"    {speed} rad/s, part of the effect caught by axial forces alone: {caught}")
    whole = answer.over_turn.sel(form="equilibrium")
    effect = whole.isel(speed=slice(1, None)) / whole.isel(speed=0) - 1
    weight = (answer.missed() ** 2).mean("angle") / (effect**2).mean("angle")
    for speed, mode in product(TURN_SPEEDS[1:], range(MODES)):
        missed = answer.missed().sel(speed=speed).isel(mode=mode)
        worst = missed[int(np.nanargmax(np.abs(missed)))]
        part = float(weight.sel(speed=speed)[mode]) ** 0.5
        print(
            f"  over the turn, {speed:g} rad/s, mode {mode + 1}: axial forces alone are off "
            f"by up to {100 * float(worst):+.2f} %, at {np.degrees(float(worst['angle'])):.0f} "
            f"deg; root mean square {part:.2f} of the whole effect of speed"
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
