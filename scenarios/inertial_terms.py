"""What does each inertial term of the running linkage do to its frequencies, alone?

Turcic & Midha's equation (as in Kumar & Chandrakar, eq. 1.57) has four terms by the crank's speed:
the geometric stiffness of the axial forces, Coriolis, centripetal and tangential terms. Each is
counted alone at 20 rad/s, for the steel, the aluminium and a dry composite four-bar: how far it
moves the first three frequencies, at which crank angle most, and whether the single changes add up
to what all terms do together. The links are straight here; what their bending adds is told by
`axial_force_alone`. Both engines, on one mesh; one of twice the elements tells what of it is known.

    python scenarios/inertial_terms.py [--out results/inertial_terms]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from _common import FOUR_BARS, four_bar, mean_over_turn, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import ExudynEngine, ReferenceEngine, RotationTerms, natural_frequencies, plots
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine, Prestress

MODES, SPEED = 3, 20.0
TURN = np.radians(np.arange(0.0, 361.0))
# Crank angles in rad at which Exudyn is asked.
MARKS = np.radians(np.arange(0.0, 361.0, 30.0))

LABELS = {
    "geometric": "Geometric stiffness alone",
    "coriolis": "Coriolis terms alone",
    "centripetal": "Centripetal terms alone",
    "tangential": "Tangential terms alone",
    "together": "All together (rings: sum of the four single changes)",
}
SINGLE = tuple(LABELS)[:-1]
# Of the greatest change by all terms together: up to here single changes are said to add up.
ADDS_UP = 0.02
# Of a term's greatest change: beyond, the mesh decides more of it than the term.
RESOLVED = 0.1
UNRESOLVED = {"markerfacecolor": "white"}


@dataclass(frozen=True)
class TermsAnswer:
    """Changes of the frequencies of one four-bar by single terms, in Hz.

    Parameters
    ----------
    rest : DataArray
        Frequencies with none of the terms, over ``angle`` in rad and ``mode``.
    change : DataArray
        Over ``term`` (a key of ``LABELS``), ``angle`` and ``mode``, at 20 rad/s.
    power : DataArray
        By which power of the speed the change grows from half of it, root mean square over the
        turn; over ``term`` and ``mode``.
    marks : DataArray
        As ``change``, by Exudyn at ``MARKS``.
    engines_differ : DataArray
        Greatest difference of the engines at ``MARKS``, over ``term`` and ``mode``.
    mesh : DataArray
        Greatest difference to a mesh of twice the elements at ``MARKS``, over ``term``, ``mode``.
    """

    rest: xr.DataArray
    change: xr.DataArray
    power: xr.DataArray
    marks: xr.DataArray
    engines_differ: xr.DataArray
    mesh: xr.DataArray

    @property
    def greatest(self) -> xr.DataArray:
        """Greatest absolute change over the turn in Hz, over ``term`` and ``mode``."""
        return abs(self.change).max("angle")

    @property
    def greatest_angle(self) -> xr.DataArray:
        """Crank angle in rad at which it is greatest."""
        return abs(self.change.isel(angle=slice(None, -1))).idxmax("angle")

    @property
    def single_sum(self) -> xr.DataArray:
        """Sum of the single changes, over ``angle`` and ``mode``."""
        return self.change.sel(term=list(SINGLE)).sum("term")

    @property
    def gap(self) -> xr.DataArray:
        """Difference of the sum from all together, over the latter's greatest change.

        Over ``angle`` and ``mode``.
        """
        together = self.change.sel(term="together", drop=True)
        return abs(self.single_sum - together) / abs(together).max("angle")

    @property
    def adds_up(self) -> bool:
        """Whether the single changes add up to that by all terms together."""
        return bool((self.gap < ADDS_UP).all())

    @property
    def resolved(self) -> xr.DataArray:
        """Whether the mesh leaves a term's greatest change known, over ``term`` and ``mode``."""
        return self.mesh < RESOLVED * self.greatest

    @property
    def geometric_leads(self) -> bool:
        """Whether no rotation term moves any frequency as far as the geometric stiffness does."""
        rotation = self.greatest.sel(term=list(SINGLE[1:])).max("term")
        return bool((rotation < self.greatest.sel(term="geometric", drop=True)).all())


def main(
    out: Path,
    *,
    names: tuple[str, ...] = tuple(FOUR_BARS),
    turn: FloatArray = TURN,
    marks: FloatArray = MARKS,
    elements: int = 16,
) -> dict[str, TermsAnswer]:
    """Count each term alone, print how far it moves the frequencies, and draw it.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which four-bars.
    turn, marks : ndarray, shape (A,), (M,)
        Crank angles in rad over a full turn, and those of Exudyn and of the finer mesh.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to TermsAnswer
        By name of the four-bar.
    """
    answers, figures = {}, {}
    for name in names:
        answer = answers[name] = count_terms(name, turn, marks, elements)
        figures[name] = _draw(name, answer)
        _report(name, answer)
    figures["greatest_change"] = _draw_greatest(answers)
    save_pictures(figures, out)
    return answers


def count_terms(name: str, turn: FloatArray, marks: FloatArray, elements: int) -> TermsAnswer:
    """Count each term alone for one four-bar; parameters as for :func:`main`."""
    mechanism = four_bar(name)
    engine = ReferenceEngine(mechanism, elements)
    rest, change = changes(engine, turn, SPEED)
    _, half = changes(engine, turn, SPEED / 2)
    root_mean = [
        xr.apply_ufunc(_over_turn, each, input_core_dims=[["angle"]]) for each in (change, half)
    ]
    (_, own), (_, finer), (_, exudyn) = (
        changes(each, marks, SPEED)
        for each in (
            engine,
            ReferenceEngine(mechanism, 2 * elements),
            ExudynEngine(mechanism, elements),
        )
    )
    return TermsAnswer(
        rest=rest,
        change=change,
        power=np.log2(root_mean[0] / root_mean[1]),
        marks=exudyn,
        engines_differ=abs(exudyn - own).max("angle"),
        mesh=abs(finer - own).max("angle"),
    )


def _over_turn(values: FloatArray) -> FloatArray:
    """Root mean square along the last axis, a closed turn."""
    return mean_over_turn(np.moveaxis(values, -1, 0))


def changes(engine: Engine, angles: FloatArray, speed: float) -> tuple[xr.DataArray, xr.DataArray]:
    """Frequencies without any of the terms, and what each alone and all together add, in Hz.

    Parameters
    ----------
    engine : Engine
    angles : ndarray, shape (A,)
        Crank angles in rad.
    speed : float
        In rad/s.

    Returns
    -------
    tuple of DataArray
        Over ``angle`` and ``mode``, and over ``term`` besides.
    """

    def frequencies(prestress: Prestress, terms: str) -> FloatArray:
        counted = RotationTerms.parse(terms)
        return natural_frequencies(
            engine, angles, speed, modes=MODES, prestress=prestress, rotation_terms=counted
        )

    rest = frequencies("none", "none")
    found = {"geometric": frequencies("axial", "none")}
    found |= {term: frequencies("none", term) for term in SINGLE[1:]}
    found["together"] = frequencies("axial", "all")
    places = {"angle": angles, "mode": np.arange(1, MODES + 1)}
    values = np.stack([found[term] - rest for term in LABELS])
    return (
        xr.DataArray(rest, places, dims=("angle", "mode")),
        xr.DataArray(values, {"term": list(LABELS)} | places, dims=("term", "angle", "mode")),
    )


def _draw(name: str, answer: TermsAnswer) -> Figure:
    """Change in mHz against crank angle, one panel a term with an axis of its own."""
    degrees = np.round(np.degrees(answer.change["angle"].values), 9)
    at_marks = np.degrees(answer.marks["angle"].values)
    look: dict[str, Any] = {"linestyle": "", "markerfacecolor": "white", "zorder": 3}
    exudyn, ring = (
        look | {"marker": "s", "markersize": 3.5},
        look | {"marker": "o", "markersize": 4.5},
    )
    every = max(1, len(degrees) // 24)
    with plots.sheet(plots.grid(len(LABELS), 1, 7.6, sharex=True)) as drawn:
        for axes, (term, label) in zip(drawn.panels, LABELS.items(), strict=True):
            axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
            for mode in range(MODES):
                of_mode, colour = {"mode": mode + 1}, plots.series_style(mode).color
                change = 1e3 * answer.change.sel(term=term, **of_mode)
                axes.plot(degrees, change, **plots.series_line(mode))
                if term == "together":
                    total = 1e3 * answer.single_sum.sel(of_mode)
                    axes.plot(degrees[::every], total[::every], **ring, markeredgecolor=colour)
                else:
                    beside = 1e3 * answer.marks.sel(term=term, **of_mode)
                    axes.plot(at_marks, beside, **exudyn, markeredgecolor=colour)
            axes.set_title(label)
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], degrees)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (mHz)")
        modes = [plots.series_handle(mode, f"mode {mode + 1}") for mode in range(MODES)]
        mark = plots.line_handle("Exudyn, same elements", **exudyn, markeredgecolor=plots.MID_GREY)
        title = f"{FOUR_BARS[name]}: change of frequency by each term at {plots.speed_label(SPEED)}"
        drawn.header([*modes, mark], title)
    return drawn.figure


def _draw_greatest(answers: dict[str, TermsAnswer]) -> Figure:
    """Greatest change over the turn by term, relative, one panel a mode."""
    names = [label.partition(" ")[0] for label in LABELS.values()]
    with plots.sheet(plots.grid(1, MODES, 2.9, sharey=True)) as drawn:
        for mode, axes in enumerate(drawn.panels):
            for number, answer in enumerate(answers.values()):
                relative = abs(answer.change / answer.rest).max("angle").isel(mode=mode)
                place = np.arange(len(LABELS)) + 0.16 * (number - (len(answers) - 1) / 2)
                for known, look in ((True, {}), (False, UNRESOLVED)):
                    shown = relative.where(answer.resolved.isel(mode=mode) == known)
                    axes.plot(place, 100 * shown, **(_marker(number) | look))
            axes.set_yscale("log")
            axes.set_xticks(np.arange(len(LABELS)), names, rotation=35, ha="right")
            axes.set_title(plots.mode_label([mode + 1]))
            axes.grid(axis="y", color=plots.LIGHT_GREY, lw=0.6)
        drawn.panels[0].set_ylabel("Greatest change of frequency (%)")
        handles = [
            plots.line_handle(FOUR_BARS[name], **_marker(number))
            for number, name in enumerate(answers)
        ]
        grey = {"color": plots.MID_GREY, "marker": "o", "linestyle": "", "markersize": 5}
        handles.append(plots.line_handle("not resolved by the mesh", **(grey | UNRESOLVED)))
        title = f"Greatest change over the turn by each term at {plots.speed_label(SPEED)}"
        drawn.header(handles, title)
    return drawn.figure


def _marker(number: int) -> dict[str, Any]:
    """Look of a four-bar's points."""
    style = plots.series_style(number)
    return {"marker": style.marker, "color": style.color, "linestyle": "", "markersize": 5}


def _report(name: str, answer: TermsAnswer) -> None:
    print(f"{FOUR_BARS[name]} at {SPEED:g} rad/s, straight links, each term alone")
    print(
        "  term         mode  greatest mHz  at deg         %  power of speed  mesh mHz  engines mHz"
    )
    for term in LABELS:
        for mode in answer.change["mode"].values:
            at = {"term": term, "mode": mode}
            angle = float(answer.greatest_angle.sel(at))
            change = float(answer.change.sel(at | {"angle": angle}))
            percent = 100 * change / float(answer.rest.sel(mode=mode, angle=angle))
            unknown = "" if answer.resolved.sel(at) else "  not resolved by this mesh"
            print(
                f"  {term:11s}  {mode:4d}  {1e3 * change:+12.4f}  {np.degrees(angle):6.0f}  "
                f"{percent:+8.2g}  {float(answer.power.sel(at)):14.2f}  "
                f"{1e3 * float(answer.mesh.sel(at)):8.4f}  "
                f"{1e3 * float(answer.engines_differ.sel(at)):11.4f}{unknown}"
            )
    for line in told(answer):
        print(f"  {line}")


def told(answer: TermsAnswer) -> list[str]:
    """Verdicts on one four-bar, computed."""
    sums = "add up to" if answer.adds_up else "do not add up to"
    leads = "weighs most" if answer.geometric_leads else "does not weigh most"
    place, mode = np.unravel_index(int(answer.gap.values.argmax()), answer.gap.shape)
    worst, angle = 100 * answer.gap.values.max(), np.degrees(answer.gap["angle"].values[place])
    below, above = answer.rest.values[place, :2]
    return [
        f"the single changes {sums} that of all terms within {100 * ADDS_UP:g} % of its greatest "
        f"value: at most {worst:.2f} % apart, at {angle:.0f} deg in mode {mode + 1}, where modes 1 "
        f"and 2 are {above - below:.2f} Hz from each other",
        f"of the four the geometric stiffness {leads} in every mode",
    ]


if __name__ == "__main__":
    main(output_folder(__doc__, "results/inertial_terms"))
