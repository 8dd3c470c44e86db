"""``flexmech report``: one page that shows what was found, and moves."""

from __future__ import annotations

from pathlib import Path

from flexmech.choices import ELEMENTS_A_LINK, REPORT_PARTS, TOLERANCE, ReportPart
from flexmech.cli import file_options, options
from flexmech.cli.arguments import parse_angles, parse_speeds, speed_remark
from flexmech.cli.command_line import command_line
from flexmech.cli.engines import make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import naming, telling
from flexmech.cli.printing import Report
from flexmech.cli.progress import progress_bar
from flexmech.errors import InputError, one_line
from flexmech.files import check_writable, given_path


def report(
    model: file_options.ModelOrResults,
    out: file_options.ReportFile = Path("report.html"),
    include: options.Include = None,
    speeds: options.Speeds = None,
    angles: options.Angles = "0:360:5",
    campbell_speeds: options.FurtherCampbellSpeeds = None,
    modes: options.Modes = None,
    engine: options.Engine = "both",
    element: options.Element = None,
    elements: options.PinnedElements = None,
    tolerance: options.Tolerance = TOLERANCE,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
) -> None:
    """One self-contained page in which the linkage turns, for a colleague without Python.

    Of a model file: frequencies, Campbell diagram, deflection, sections, each with its error,
    equation and source. Of a folder of results: what the other commands wrote there.
    """
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)
    given = None if speeds is None else parse_speeds(speeds)
    degrees, parts = parse_angles(angles), _parts(include)
    diagram = None if campbell_speeds is None else _campbell_speeds(campbell_speeds)

    import numpy as np

    from flexmech.analyses.netcdf import told_as_damaged
    from flexmech.modelfile import load_mechanism
    from flexmech.report import (
        ReportRequest,
        check_extra,
        report_results,
        report_summary,
        stored_results,
        write_report,
    )

    check_extra()
    with naming("--out"):
        out = given_path(out)
        if not out.parent.is_dir():
            raise InputError(f"{out}: there is no folder {out.parent}; make it first")
        check_writable(out.parent, [out.name])
    source, remark, unit = given_path(model), "", "rad/s" if given is None else given.unit
    with progress_bar() as progress, telling(model, unit):
        if source.is_dir():
            _refuse_computing(include, speeds, campbell_speeds, environment)
            results = stored_results(source)
        else:
            mechanism = load_mechanism(model)
            request = ReportRequest(
                None if given is None else np.array(given.values),
                np.radians(degrees),
                parts,
                None if diagram is None else np.array(diagram),
                modes,
                environment,
                unit,
                tolerance if elements is None else None,
            )
            engines = make_engines(mechanism, engine, element, elements or ELEMENTS_A_LINK)
            results = report_results(engines, request, progress)
            remark = "" if given is None else speed_remark("--speeds", str(speeds), given.values)
        with told_as_damaged(source) if source.is_dir() else telling(None, unit), naming("--out"):
            write_report(results.all, out, command_line=command_line())
    size = f"{out.stat().st_size / 1e6:.1f} MB"
    lines = (f"file: {one_line(str(out))} ({size}), open it in a browser",)
    Report(report_summary(results), (out,), lines, remark).print()


def _parts(include: str | None) -> tuple[ReportPart, ...] | None:
    """Parts of ``--include``; None where it was left out."""
    if include is None:
        return None
    asked = [each.strip().lower() for each in include.split(",")]
    for each in asked:
        if each not in REPORT_PARTS:
            raise InputError(
                f"--include: got {include!r}, in which {each!r} is no part of a report; choose "
                f"from {', '.join(REPORT_PARTS)}"
            )
    return tuple(part for part in REPORT_PARTS if part in asked)


def _campbell_speeds(text: str) -> tuple[float, ...]:
    try:
        return parse_speeds(text).values
    except InputError as error:
        raise InputError(str(error).replace("--speeds", "--campbell-speeds")) from error


def _refuse_computing(*asked: object) -> None:
    """Stored results are shown as they are."""
    if any(each is not None for each in asked):
        raise InputError(
            "--include, --speeds, --campbell-speeds and heat and moisture say what to compute; a "
            "folder of results is shown as it is, leave them out"
        )
