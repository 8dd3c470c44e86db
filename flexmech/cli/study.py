"""``flexmech study``: whole campaigns, such as the composite crank-rockers of a paper."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flexmech.cli.arguments import NoPlots, Out
from flexmech.cli.failures import reports_failures
from flexmech.files import check_writable, moved_into

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray as xr
    from matplotlib.figure import Figure

    from flexmech.analyses.studies import Claim
    from flexmech.linear_system import Engine
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "study_app"]

HELP = "Run a whole campaign and set it beside what is published."
TABLES = ("composites.csv", "composite_claims.csv")
PICTURES = (
    "transmission_angle.png",
    "frequencies_by_laminate.png",
    "damping_by_laminate.png",
    "laminate_factors.png",
)
MODELS = "models"

study_app = typer.Typer(help=HELP, no_args_is_help=True, rich_markup_mode=None)


@study_app.callback()
def studies() -> None:
    """Choose a campaign."""


@study_app.command(
    "composites",
    help="Composite crank-rockers of Elamy et al. 2023: six laminates, four linkages, three "
    "positions of the transmission angle.",
)
@reports_failures
def composites(out: Out = Path("results"), no_plots: NoPlots = False) -> None:
    """Compute, save, draw and report the campaign, claim by claim."""
    check_writable(out, (*TABLES, *PICTURES))
    check_writable(out / MODELS, _model_files())

    from flexmech.analyses.studies import composite_claims, study_composites
    from flexmech.cli.progress import progress_bar

    with progress_bar() as progress:
        study = study_composites(_reference, progress)
    claims = composite_claims(study)
    files = _write(study, claims, out, draw=not no_plots)
    _report(study, claims, out, files)


def _reference(mechanism: Mechanism, element: str, elements: int) -> Engine:
    from flexmech.reference import ReferenceEngine

    return ReferenceEngine(mechanism, elements, element)


def _model_files() -> dict[str, str]:
    """Text of every model file, by name."""
    from flexmech.analyses.studies import PLY_MODELS, composite_model_file, model_file_name
    from flexmech.analyses.studies.published import CASES, LAMINATES

    return {
        model_file_name(case, laminate, plies): composite_model_file(case, laminate, plies)
        for plies in PLY_MODELS
        for case in CASES
        for laminate in LAMINATES
    }


def _write(study: xr.Dataset, claims: list[Claim], out: Path, *, draw: bool) -> list[Path]:
    """Write tables, pictures and the model files."""
    from flexmech.cli.pictures import DOTS_PER_INCH
    from flexmech.cli.study_report import claim_frame, frequency_frame

    frames = (frequency_frame(study), claim_frame(claims))
    figures = _figures(study) if draw else {}
    with moved_into(out) as folder:
        for name, frame in zip(TABLES, frames, strict=True):
            frame.to_csv(folder / name, index=False, float_format="%.6g")
        for name, figure in figures.items():
            figure.savefig(folder / name, dpi=DOTS_PER_INCH)
    with moved_into(out / MODELS) as folder:
        for name, text in _model_files().items():
            (folder / name).write_text(text, encoding="utf-8", newline="\n")
    return [out / name for name in (*TABLES, *figures)]


def _figures(study: xr.Dataset) -> Mapping[str, Figure]:
    from flexmech.cli.pictures import without_windows

    without_windows()
    from flexmech import plots
    from flexmech.analyses.studies import laminate_factors

    angle = study["transmission_angle"]
    curves = {f"case {case}": angle.sel(case=case).values for case in study["case"].values}
    published = laminate_factors(study["finite_element"].sel(position=["90", "max"]))
    figures = (
        plots.plot_transmission_angle(study["crank_angle"].values, curves),
        plots.plot_composite_frequencies(study),
        plots.plot_composite_damping(study),
        plots.plot_laminate_factors(laminate_factors(study["frequency"]), published),
    )
    return dict(zip(PICTURES, figures, strict=True))


def _report(study: xr.Dataset, claims: list[Claim], out: Path, files: list[Path]) -> None:
    from flexmech.cli.pictures import file_lines
    from flexmech.cli.report import print_table
    from flexmech.cli.study_report import claim_lines, frequency_tables, summary_lines

    for table in frequency_tables(study):
        print_table(table)
    for line in (
        *claim_lines(claims),
        *summary_lines(claims),
        *file_lines(out, files, PICTURES),
        f"model files, with the size assumed: {out / MODELS}",
    ):
        typer.echo(line)
