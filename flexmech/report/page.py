"""From results to one HTML file that needs nothing else: no network, no Python."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmech.analyses import Result, Table
from flexmech.analyses.result import file_attributes
from flexmech.errors import missing_extra
from flexmech.files import given_path, write_whole
from flexmech.mechanism import Mechanism
from flexmech.modelfile import KINDS, template
from flexmech.plots.style import SERIES_STYLES
from flexmech.report.answers import brief_cards, cards, trust
from flexmech.report.moving_linkage import (
    Arrays,
    breakable_markup,
    equation_markup,
    json_text,
    mechanism_of,
    moving_linkage,
    plotly_source,
)
from flexmech.report.panel import Panel, Reading
from flexmech.report.panels import panels_of
from flexmech.report.results import Results
from flexmech.units import ANGULAR_SPEED, parse_quantity

if TYPE_CHECKING:
    from jinja2 import Environment


# What a cell has where there is nothing to tell.
_NOTHING = ("", "-")
_FIXED = "\N{NO-BREAK SPACE}"


def shown_tables(tables: Iterable[Table]) -> list[Table]:
    """Tables that have rows, each as narrow as it can be without loss.

    Parameters
    ----------
    tables : iterable of Table

    Returns
    -------
    list of Table
    """
    return [narrowed(table) for table in tables if any(table.groups)]


def narrowed(table: Table) -> Table:
    """A table whose columns all tell something.

    A column of words that is the same in every row goes into the title, and a column of empty cells
    is left out. A number may be parted from its error, and nowhere else.

    Parameters
    ----------
    table : Table

    Returns
    -------
    Table

    Examples
    --------
    >>> rows = (("dry", "crank", "1 ± 0.1"), ("dry", "rod", "2 ± 0.1"))
    >>> table = Table("Peaks", ("state", "of", "force (N)"), (rows,), text_columns=2)
    >>> narrowed(table).title, narrowed(table).headings
    ('Peaks (state: dry)', ('of', 'force (N)'))
    """
    rows = [row for group in table.groups for row in group]
    words = table.text_columns
    columns = [{row[number] for row in rows} for number in range(len(table.headings))]
    empty = {number for number, cells in enumerate(columns) if cells <= set(_NOTHING)}
    same = {number for number in range(words) if len(rows) > 1 and len(columns[number]) == 1}
    kept = [number for number in range(len(columns)) if number not in empty | same]
    told = [f"{table.headings[n]}: {rows[0][n]}" for n in sorted(same - empty)]
    return replace(
        table,
        title=f"{table.title} ({', '.join(told)})" if told else table.title,
        headings=tuple(table.headings[number] for number in kept),
        groups=tuple(
            tuple(tuple(row[n] if n < words else _unbroken(row[n]) for n in kept) for row in group)
            for group in table.groups
        ),
        text_columns=sum(number < words for number in kept),
    )


def _unbroken(cell: str) -> str:
    """A number that a line breaks before its error alone."""
    return cell.replace(" ", _FIXED).replace(f"{_FIXED}±", " ±")


CHOICES = ("speed", "mode", "engine", "state")
SCRIPTS = ("page.js", "linkage.js", "parts.js", "plots.js", "controls.js")
SETTINGS = (
    "elements",
    "prestress",
    "rotation_terms",
    "crank_speed",
    "revolutions",
    "start",
    "integrator",
    "crank_angles",
)


def check_extra() -> None:
    """Refuse to begin where a package that the page needs is missing.

    Raises
    ------
    InputError
        It says what to install.
    """
    from importlib.util import find_spec

    for package in ("plotly", "jinja2"):
        if not find_spec(package):
            raise missing_extra("a report", package, "report")


def write_report(
    results: Result | Sequence[Result] | Results,
    path: str | Path,
    *,
    brief: bool = False,
    mechanism: Mechanism | None = None,
    command_line: str = "",
) -> Path:
    """Write results of one mechanism into a page that opens in any browser.

    The page holds all that it shows: it needs no network, and a colleague needs no Python. The
    linkage turns by a slider, and a cursor follows on every curve.

    Parameters
    ----------
    results : Result, sequence of Result or Results
        Results of one mechanism: frequencies, Campbell diagram, responses, sections, coupler
        curves, moisture. Each panel takes those that it shows.
    path : str or Path
        Path of the HTML file; replaced if it exists.
    brief : bool
        One screen and one sheet of A4 in place of panels: the moving linkage and the numbers that
        decide.
    mechanism : Mechanism, optional
        What is drawn and turns. Left out: that of the model file whose text the results hold; a
        mechanism built in Python has none, and the page then shows the panels alone.
    command_line : str
        That the page names as what made it; none if left out.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is no result, they are of different model files, the file cannot be written, or
        plotly or jinja2 are not installed (extra ``report``).

    Examples
    --------
    >>> import tempfile
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> check = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = flexmech.write_report(check, f"{folder}/report.html").read_text("utf-8")
    >>> "Transmission angle" in page and page.startswith("<!doctype html>")
    True
    """
    check_extra()
    known = Results.of(results)
    target = given_path(path)
    shown = mechanism if mechanism is not None else mechanism_of(known)
    write_whole(target, _page(known, shown, command_line, brief))
    return target


def _page(results: Results, mechanism: Mechanism | None, command_line: str, brief: bool) -> str:
    """Text of the page; a brief one has no plots, and no plotly."""
    from plotly import __version__ as plotly_version

    arrays, panels = Arrays(), [] if brief else panels_of(results)
    linkage = None if mechanism is None else moving_linkage(mechanism, results, arrays)
    plots = [_plain(plot, arrays) for panel in panels for plot in panel.plots]
    readings = [_plain(each, arrays) for panel in panels for each in panel.readings]
    data = {
        "linkage": linkage,
        "plots": plots,
        "readings": readings,
        "choices": _choices(results, panels, linkage),
        "colours": [style.color for style in SERIES_STYLES],
        "arrays": arrays.encoded,
    }
    return (
        _templates()
        .get_template("page.html")
        .render(
            title=_title(results),
            source=results.attribute("source"),
            brief=brief,
            cards=brief_cards(results) if brief else cards(results),
            trust=trust(results),
            panels=panels,
            choices=data["choices"],
            has_linkage=linkage is not None,
            groups=list(dict.fromkeys(each["group"] for each in readings)),
            data=json_text(data),
            style=_package_text("style.css"),
            script="\n".join(map(_package_text, SCRIPTS)),
            plotly="" if brief else plotly_source(),
            thinned=[line for panel in panels for line in panel.thinned],
            versions=_versions(results) | ({} if brief else {"plotly": plotly_version}),
            settings=_settings(results),
            model_text=results.attribute("model_text"),
            model_file=results.attribute("model_file"),
            model_sha256=results.attribute("model_sha256"),
            date=file_attributes("")["date"][:10],
            command_line=command_line,
        )
    )


def _title(results: Results) -> str:
    """Name of the mechanism as it is dry: results in an environment add that to it.

    In place of a name that a template came with, and that nobody changed, that of the model file.
    """
    name = min(
        (str(each.dataset.attrs.get("mechanism", "")) for each in results.all), key=len, default=""
    )
    if name in {tomllib.loads(template(kind))["name"] for kind in KINDS}:
        name = Path(results.attribute("model_file")).stem or name
    return name[:1].upper() + name[1:] or "Mechanism"


def _templates() -> Environment:
    """Templates that escape what they show."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("flexmech.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["equation"] = equation_markup
    made.filters["breakable"] = breakable_markup
    made.filters["shown"] = shown_tables
    return made


def _package_text(name: str) -> str:
    return resources.files("flexmech.report").joinpath("templates", name).read_text("utf-8")


def _plain(item: Any, arrays: Arrays) -> Any:
    """What a panel is made of as JSON has it: fields by name, arrays by their numbers."""
    if isinstance(item, np.ndarray):
        return arrays.add(item)
    if isinstance(item, Reading):
        item = vars(item)
    if isinstance(item, Mapping):
        return {name: _plain(value, arrays) for name, value in item.items()}
    if isinstance(item, list | tuple):
        return [_plain(each, arrays) for each in item]
    return None if isinstance(item, float) and not np.isfinite(item) else item


def _choices(
    results: Results, panels: Iterable[Panel], linkage: dict[str, Any] | None
) -> dict[str, list[dict[str, Any]]]:
    """What the reader can choose from, in order: what anything in the page asks for."""
    asked: list[dict[str, Any]] = []
    for panel in panels:
        asked += [dict(each.when) for each in panel.readings]
        for plot in panel.plots:
            asked += [{**one["when"], **(one["followed"] or {})} for one in plot["traces"]]
    for part in ("shapes", "runs"):
        asked += [] if linkage is None else [each["when"] for each in linkage[part]]
    choices = {}
    for key in CHOICES:
        names = list(dict.fromkeys(each[key] for each in asked if key in each))
        choices[key] = [{"name": name} for name in names]
    for each in choices["speed"]:
        each["value"] = parse_quantity(each["name"], ANGULAR_SPEED)
    choices["speed"].sort(key=lambda each: each["value"])
    return choices


def _versions(results: Results) -> dict[str, str]:
    """Versions of flexmech and of what it computed with."""
    ending = "_version"
    found = {
        str(name).removesuffix(ending): str(value)
        for each in results.all
        for name, value in each.dataset.attrs.items()
        if str(name).endswith(ending)
    }
    return dict(sorted(found.items(), key=lambda pair: (pair[0] != "flexmech", pair[0])))


def _settings(results: Results) -> list[tuple[str, str]]:
    """What was asked of each result: its command line or its own settings."""
    rows = []
    for each in results.all:
        attributes = each.dataset.attrs
        told = each.stored_as.get("command_line", "")
        known = (name for name in SETTINGS if name in attributes)
        settings = ", ".join(f"{name.replace('_', ' ')} {attributes[name]}" for name in known)
        rows.append((each.title, told or settings or "no settings"))
    return rows
