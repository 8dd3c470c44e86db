"""What a panel of the report is: its drawings, plots, readings, tables and words.

Everything here is plain data. The page's script draws it, moves the cursors and shows readings;
nothing is computed in the browser but the place between two samples.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, wraps
from importlib import resources
from typing import Any

from flexmech.analyses import Summary, Table
from flexmech.arrays import FloatArray
from flexmech.plots.picture import Choice
from flexmech.report.plotted import Plot
from flexmech.report.results import Kind, Results


@dataclass(frozen=True)
class Reading:
    """A number beside the linkage that follows the crank angle.

    Parameters
    ----------
    group, label, unit : str
    angle, value : ndarray, shape (n,)
        Crank angle in degrees and the number there.
    error : float
        Of the number, in its unit; not a number where it is not known.
    when : mapping
    decimals : int
    mode : str
        Number of the mode that it is of, if it is of one; the chosen mode is marked.
    """

    group: str
    label: str
    unit: str
    angle: FloatArray
    value: FloatArray
    error: float
    when: Choice
    decimals: int
    mode: str = ""


@dataclass(frozen=True)
class Panel:
    """A part of the report about one question.

    Parameters
    ----------
    name : str
        Letters, digits and hyphens; unique in the report, and its anchor.
    title : str
    caption : str
        What is shown, in a sentence or two.
    answer : tuple of str
        What the result says first, above everything else.
    equation : str
        What was solved, as text.
    source : str
        Where the equation stands.
    plots : tuple of Plot
    drawings : tuple of (str, str)
        Drawings that do not move: SVG, and what is to be seen in it.
    readings : tuple of Reading
    tables : tuple of Table
        What the answer rests on; the reader sorts them.
    folded : tuple of Table
        Further ones, which the reader unfolds.
    lines : tuple of str
        What else is to be said: errors, checks; the reader unfolds them with the equation.
    warnings : tuple of str
    thinned : tuple of str
        What was left out for the screen.
    """

    name: str
    title: str
    caption: str
    answer: tuple[str, ...] = ()
    equation: str = ""
    source: str = ""
    plots: tuple[Plot, ...] = ()
    drawings: tuple[tuple[str, str], ...] = ()
    readings: tuple[Reading, ...] = ()
    tables: tuple[Table, ...] = ()
    folded: tuple[Table, ...] = ()
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    thinned: tuple[str, ...] = ()

    @property
    def details(self) -> str:
        """What is folded, in words; empty if nothing is."""
        folded = (
            (any(any(table.groups) for table in self.folded), "tables"),
            (self.equation, "equation"),
            (any(self.lines), "errors and checks"),
        )
        return ", ".join(words for part, words in folded if part).capitalize()


PanelMaker = Callable[[Results], Panel | None]


def shows(kind: type[Kind]) -> Callable[[Callable[[Kind, Results], Panel | None]], PanelMaker]:
    """Make a panel's function of the first result of a kind one of all results.

    Parameters
    ----------
    kind : type
        Of the result that the panel shows.

    Returns
    -------
    callable
        Decorator; without such a result there is no panel.
    """

    def of_results(make: Callable[[Kind, Results], Panel | None]) -> PanelMaker:
        @wraps(make)
        def panel(results: Results) -> Panel | None:
            result = results.first(kind)
            return None if result is None else make(result, results)

        return panel

    return of_results


def panel_of(name: str, said: Summary | None = None, variant: str = "", /, **parts: Any) -> Panel:
    """A panel with the words that ``panels.toml`` has for it.

    Keywords are fields of the panel; others fill in the caption.

    Parameters
    ----------
    name : str
        Of the panel, and of its table in the file.
    said : Summary, optional
        Of the result: its answer, table and warnings are the panel's, and all else is folded.
    variant : str
        Which of several tables of words, where the panel has several.

    Returns
    -------
    Panel
    """
    words = _words()[name]
    words = words[variant] if variant else words
    texts = {key: parts.pop(key) for key in set(parts) - set(Panel.__dataclass_fields__)}
    words = words | {"caption": words["caption"].format(**texts)}
    if said is not None:
        own: dict[str, Any] = {
            "answer": said.answer,
            "tables": () if said.table is None else (said.table,),
            "folded": tuple(part for part in said.details if not isinstance(part, str)),
            "lines": further_lines(said),
            "warnings": said.warnings,
        }
        parts = own | parts
    return Panel(name, **(words | parts))


def further_lines(said: Summary) -> tuple[str, ...]:
    """What a result says after its answer: how far it is known, and all else.

    Parameters
    ----------
    said : Summary

    Returns
    -------
    tuple of str
    """
    return tuple(line for line in said.lines if line not in said.answer)


@cache
def _words() -> dict[str, Any]:
    text = resources.files("flexmech.report.panels").joinpath("panels.toml").read_text("utf-8")
    return tomllib.loads(text)
