"""Commands on a study file: many designs, how uncertain they are, and the best of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option, echo

from flexmech import studies
from flexmech.choices import MOST_SEED, EngineName
from flexmech.cli import options
from flexmech.cli.deliver import deliver, typed_path
from flexmech.cli.reading import Together

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
        Of the samples. Left out: the study's.
    engine
        That computes. Left out: the study's.
    workers
        Processes on this machine.
    cluster : ADDRESS
        Scheduler of a Dask cluster, such as tcp://scheduler:8786.
    resume
        Go on with the designs that an interrupted run has kept in DIR/designs.zarr.
    force
        Begin again where there are some.
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
    """Many designs of a linkage: every combination of a study's values, or a sample.

    Options
    -------
    samples : N
        Designs spread evenly over the ranges. Left out: every combination.
    """
    run(studies.DesignSweep, lambda *a, **k: studies.sweep_study(*a, samples=samples, **k), study)


def uncertainty(study: StudyPath, samples: Samples = None, *, run: Run) -> None:
    """How uncertain a linkage is whose properties are, and which of them makes it so.

    Options
    -------
    samples : N
        A power of two, 1024 if left out; N (D + 2) designs are computed of D inputs.
    """

    def compute(own: studies.Study, **kept: Any) -> studies.Uncertainty:
        echo(studies.runs_line(own, samples), err=True)
        return studies.uncertainty_study(own, samples, **kept)

    run(studies.Uncertainty, compute, study)


def optimize(study: StudyPath, *, run: Run) -> None:
    """The best design of a study by its goals, within its limits, confirmed by both engines."""
    run(studies.Optimum, studies.optimum_study, study)
