"""``flexmech study``: whole campaigns, such as the composite crank-rockers of a paper."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flexmech.cli.failures import reports_failures
from flexmech.files import check_writable, moved_into

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from flexmech.analyses.studies import Claim

__all__ = ["HELP", "study_app"]

HELP = "Run a whole campaign and set it beside what is published."
TABLES = ("frequencies.csv", "claims.csv")
PICTURES = (
    "transmission_angle.png",
    "frequencies_by_laminate.png",
    "damping_by_laminate.png",
    "laminate_factors.png",
)
COLUMNS = (
    "position",
    "crank_angle_deg",
    "laminate",
    "case",
    "plies",
    "mesh",
    "frequency_Hz",
    "ratio",
    "published_finite_element_Hz",
    "published_finite_element_ratio",
    "published_measured_Hz",
    "published_measured_ratio",
    "strain_energy_damping",
    "published_damping",
)
ONE: dict[str, Any] = {"laminate": "C1", "case": 1, "position": "min"}

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
def composites(
    out: Annotated[Path, typer.Option(help="Folder for results.")] = Path("results"),
    no_plots: Annotated[bool, typer.Option("--no-plots", help="Draw no pictures.")] = False,
) -> None:
    """Compute, save, draw and report the campaign, claim by claim."""
    check_writable(out, (*TABLES, *PICTURES))

    from flexmech.analyses.studies import composite_claims, study_composites
    from flexmech.cli.progress import progress_bar
    from flexmech.cli.report import print_table
    from flexmech.reference import ReferenceEngine
    from flexmech.threads import one_thread

    with progress_bar() as progress, one_thread():
        study = study_composites(
            lambda mechanism, elements: ReferenceEngine(mechanism, elements), progress
        )
    claims = composite_claims(study)
    _write(study, claims, out, draw=not no_plots)
    for table in _frequency_tables(study):
        print_table(table)
    for line in _claim_lines(claims):
        typer.echo(line)
    held = sum(claim.verdict == "reproduced" for claim in claims)
    typer.echo(
        f"{held} of {len(claims)} claims are reproduced; the paper prints no link size, so that "
        f"only ratios compare (the size assumed is in {out / 'models'})"
    )
    names = TABLES if no_plots else (*TABLES, *PICTURES)
    typer.echo(f"files: {', '.join(str(out / name) for name in names)}")


def _write(study: xr.Dataset, claims: list[Claim], out: Path, *, draw: bool) -> None:
    from flexmech.analyses.studies import composite_model_file

    with moved_into(out / "models") as folder:
        for case in study["case"].values.tolist():
            for laminate in study["laminate"].values.tolist():
                text = composite_model_file(case, laminate)
                (folder / f"case_{case}_{laminate}.toml").write_text(text, encoding="utf-8")
    with moved_into(out) as folder:
        _write_csv(folder / TABLES[0], COLUMNS, _rows(study))
        fields = ("place", "statement", "printed", "from_tables", "computed", "verdict")
        _write_csv(folder / TABLES[1], fields, ([getattr(c, f) for f in fields] for c in claims))
        if draw:
            _draw(study, folder)


def _draw(study: xr.Dataset, folder: Path) -> None:
    from flexmech.analyses.studies import laminate_factors
    from flexmech.plots import (
        plot_composite_damping,
        plot_composite_frequencies,
        plot_laminate_factors,
        plot_transmission_angle,
    )

    angle = study["transmission_angle"]
    curves = {f"case {case}": angle.sel(case=case).values for case in study["case"].values}
    computed = laminate_factors(study["frequency"].isel(mesh=0)).transpose("plies", "laminate")
    published = laminate_factors(study["finite_element"].sel(position=["90", "max"]))
    figures = (
        plot_transmission_angle(study["crank_angle"].values, curves),
        plot_composite_frequencies(study),
        plot_composite_damping(study),
        plot_laminate_factors(computed, published),
    )
    for name, figure in zip(PICTURES, figures, strict=True):
        figure.savefig(folder / name)


def _write_csv(path: Path, header: tuple[str, ...], rows: Iterator[list[Any]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(header)
        table.writerows(rows)


def _rows(study: xr.Dataset) -> Iterator[list[Any]]:
    import numpy as np

    from flexmech.analyses.studies import position_angles, published_case

    dims = ("plies", "mesh", "position", "laminate", "case")
    plies, meshes, positions, laminates, cases = (study[name].values.tolist() for name in dims)
    angles = np.degrees([position_angles(published_case(case)) for case in cases])
    frequency = study["frequency"].transpose(*dims)
    ratio = (frequency / frequency.sel(ONE)).values
    published = {
        name: (study[name].values, (study[name] / study[name].sel(ONE)).values)
        for name in ("finite_element", "measured")
    }
    for place in np.ndindex(frequency.shape):
        p, e, *where = place
        at = tuple(where)
        row: list[Any] = [positions[at[0]], f"{angles[at[2], at[0]]:.6g}"]
        row += [laminates[at[1]], cases[at[2]], plies[p], meshes[e]]
        row += [f"{frequency.values[place]:.6g}", f"{ratio[place]:.5f}"]
        for values, relative in published.values():
            row += [f"{values[at]:g}", f"{relative[at]:.5f}"]
        row += [f"{study['strain_energy_damping'].values[at]:.6g}"]
        row += [f"{study['damping'].values[at]:g}"]
        yield row


def _frequency_tables(study: xr.Dataset) -> Iterator[Table]:
    from rich.table import Table

    ours = study["frequency"].sel(plies="unidirectional").isel(mesh=0)
    relative = [v / v.sel(ONE) for v in (ours, study["finite_element"], study["measured"])]
    words = {"min": "least", "90": "90 deg", "max": "greatest"}
    for position, word in words.items():
        table = Table(
            title=f"frequency over that of C1, case 1, least transmission angle: computed / "
            f"finite elements / measured; transmission angle {word}"
        )
        table.add_column("laminate")
        for case in ours["case"].values.tolist():
            table.add_column(f"case {case}", justify="right")
        for laminate in ours["laminate"].values.tolist():
            cells = []
            for case in ours["case"].values.tolist():
                at = {"position": position, "laminate": laminate, "case": case}
                cells.append(" / ".join(f"{float(v.sel(at)):.3f}" for v in relative))
            table.add_row(laminate, *cells)
        yield table


def _claim_lines(claims: list[Claim]) -> Iterator[str]:
    for verdict in ("reproduced", "not reproduced"):
        yield f"{verdict}:"
        for claim in claims:
            if claim.verdict == verdict:
                yield (
                    f"  {claim.place}, {claim.statement}: printed {claim.printed}, from its tables "
                    f"{claim.from_tables}, computed {claim.computed}"
                )
