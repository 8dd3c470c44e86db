"""Commands that compute much: studies of many designs, the report, the verification."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option, echo

from flexmech import studies, verification
from flexmech.analyses.options import ReportOptions
from flexmech.analyses.typed import Together
from flexmech.choices import MOST_SEED, EngineName
from flexmech.cli import options
from flexmech.cli.asking import given_speeds, naming_options
from flexmech.cli.deliver import command_line, deliver, mechanism_of, progress_bar, say, typed_path
from flexmech.cli.failures import telling
from flexmech.crank_values import Speeds
from flexmech.errors import ComputationError, InputError, naming, one_line
from flexmech.files import check_writable, given_path

# What a folder of results cannot be asked.
_COMPUTED = ("include", "crank_speeds", "campbell_speeds", "environment")
Samples = Annotated[int | None, Option(min=1)]
StudyPath = Annotated[Path, Argument(help="Study file.", metavar="STUDY", parser=typed_path)]


def asked_campaign(
    seed: Annotated[int | None, Option(min=0, max=MOST_SEED)] = None,
    engine: EngineName | None = None,
    workers: Annotated[int, Option(min=1, max=1024)] = 1,
    cluster: str | None = None,
    resume: Annotated[bool, Option("--resume")] = False,
    force: Annotated[bool, Option("--force")] = False,
    *,
    output: options.AskedOutput,
) -> Callable[..., None]:
    """Seed, engine and workers, and what becomes of designs of an earlier run.

    Options
    -------
    seed
        Seed of the samples. Left out: the study's.
    engine
        Engine that computes. Left out: the study's.
    workers
        Processes on this machine.
    cluster : ADDRESS
        Scheduler of a Dask cluster, such as tcp://scheduler:8786.
    resume
        Go on with the designs that an interrupted run has kept in DIR/designs.zarr.
    force
        Begin again where an earlier run kept designs.
    """

    def run(kind: type[Any], compute: Callable[..., Any], file: Path) -> None:
        study = studies.load_study(file).with_(seed, engine)
        folder = studies.folder_of_designs(output.folder, resume=resume, force=force)
        with studies.workers(workers, cluster) as executor:
            work = partial(compute, study, executor=executor, folder=folder, resume=resume)
            deliver(kind, lambda bar: work(progress=bar), output, model=file, in_lines=True)

    return run


Run = Annotated[Callable[..., None], Together(asked_campaign)]


def sweep(study: StudyPath, samples: Samples = None, *, run: Run) -> None:
    """Designs of a study: all combinations, or a sample.

    Options
    -------
    samples : N
        Designs spread evenly over the ranges. Left out: every combination.
    """
    run(studies.DesignSweep, lambda *a, **k: studies.sweep_study(*a, samples=samples, **k), study)


def uncertainty(study: StudyPath, samples: Samples = None, *, run: Run) -> None:
    """Uncertainty of a linkage by that of its properties.

    With the share of each property in it.

    Options
    -------
    samples : N
        Number N of samples, a power of two, 1024 if left out; N (D + 2) designs are computed
        for D inputs.
    """

    def compute(own: studies.Study, **kept: Any) -> studies.Uncertainty:
        echo(studies.runs_line(own, samples), err=True)
        return studies.uncertainty_study(own, samples, **kept)

    run(studies.Uncertainty, compute, study)


def optimize(study: StudyPath, *, run: Run) -> None:
    """Best design of a study by its goals, within its limits.

    Both engines confirm it.
    """
    run(studies.Optimum, studies.optimum_study, study)


def report(
    model: options.GivenPath,
    keywords: Annotated[dict[str, Any], Together(ReportOptions, {"engine": "both"})],
    out: options.TypedPath = Path("report.html"),
    *,
    printing: options.AskedPrinting,
) -> None:
    """Report: one HTML page in which the linkage turns.

    The page needs no other file. From a model file: frequencies, Campbell diagram, deflection,
    sections, each with its error, equation and source. From a folder of results: what the other
    commands wrote there.

    Options
    -------
    model : MODEL|RESULTS
        Model file, or folder of results of other commands.
    out : FILE
        HTML file to write.
    """
    from flexmech.analyses.crank_speeds import in_unit, rad_per_s
    from flexmech.analyses.result import reported_as_damaged
    from flexmech.report import (
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
    source, speeds, brief = given_path(model), Speeds(()), keywords["brief"]
    with progress_bar() as progress, telling(model, (keywords["crank_speeds"] or speeds).unit):
        if source.is_dir():
            if any(keywords[name] is not None for name in _COMPUTED):
                raise InputError(
                    "--include, --speeds, --campbell-speeds and heat and moisture say what to "
                    "compute; a folder of results is shown as it is, leave them out"
                )
            results = stored_results(source)
        else:
            mechanism, over = mechanism_of(model), keywords.pop("campbell_speeds")
            given, typed = given_speeds(ReportOptions, keywords, mechanism)
            speeds = typed or speeds
            if over is not None:
                over = in_unit(rad_per_s(over.numbers, over.unit), speeds.unit)
            with naming_options(ReportOptions):
                results = report_results(
                    mechanism, **given, campbell_speeds=over, progress=progress
                )
        with (
            reported_as_damaged(source) if source.is_dir() else telling(None, speeds.unit),
            naming("--out"),
        ):
            write_report(results, out, brief=brief, command_line=command_line())
    size = f"{out.stat().st_size / 1e6:.1f} MB"
    lines = [f"file: {one_line(str(out))} ({size}), open it in a browser"]
    say(report_summary(results, brief=brief), [out], lines, [speeds.remark], printing)


def verify(
    thorough: Annotated[bool, Option("--thorough")] = False, *, output: options.AskedOptionalOutput
) -> None:
    """Verify this installation against published numbers.

    Closed forms and other programs are references too. Each case prints the number that is farthest
    off, with its source and tolerance; exit code 1 where one fails.

    Options
    -------
    thorough
        With the cases that take longer.
    """
    result = deliver(
        verification.Verification,
        lambda progress: verification.verify(thorough=thorough, progress=progress),
        output,
    )
    if result.failed:
        count = len(result.failed)
        raise ComputationError(
            f"{count} case{'s' * (count > 1)} of the verification failed: "
            f"{'; '.join(result.failed)}; flexmech is not to be trusted there on this machine"
        )
