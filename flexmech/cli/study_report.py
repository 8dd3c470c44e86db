"""Tables of ``flexmech study composites``: on the terminal and in its CSV files."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import pandas as pd

from flexmech.analyses.studies import REPRODUCED_WITHIN, Claim, position_angles, published_case
from flexmech.analyses.studies.claim import Verdict, all_models

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

__all__ = ["claim_frame", "claim_lines", "frequency_frame", "frequency_tables", "summary_lines"]

# What every column of frequencies is divided by.
ONE: dict[str, Any] = {"laminate": "C1", "case": 1, "position": "min"}
SECOND = "90, second crank angle"
_POSITIONS = {
    "min": "least transmission angle, crank at 0 deg",
    "90": "transmission angle 90 deg, first of two crank angles",
    "max": "greatest transmission angle, crank at 180 deg",
}


def frequency_frame(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the study: one row for each model of plies and beams, position and linkage.

    Ratios are to C1, case 1, at the least transmission angle, each column to its own. The
    second crank angle with a right transmission angle stands beside the published values of
    that position too: the paper does not say which one it means. Of it there is no damping.

    Parameters
    ----------
    study : Dataset
        Of :func:`flexmech.analyses.studies.study_composites`.

    Returns
    -------
    pandas.DataFrame
    """
    dims = ("plies", "beams", "position", "laminate", "case")
    first = study[["frequency", "strain_energy_damping", "finite_element", "measured", "damping"]]
    second = first.sel(position=["90"]).assign(
        frequency=study["other_posture"].expand_dims(position=["90"]),
        strain_energy_damping=first["strain_energy_damping"].sel(position=["90"]) * np.nan,
    )
    second = second.assign_coords(position=[SECOND])
    frames = [part.to_dataframe(dim_order=dims).reset_index() for part in (first, second)]
    angle = {c: np.degrees(position_angles(published_case(c))) for c in study["case"].values}
    number = {name: n for n, name in enumerate([*study["position"].values, SECOND])}
    frame = pd.concat(frames, ignore_index=True)
    crank = [angle[c][number[p]] for c, p in zip(frame["case"], frame["position"], strict=True)]
    reference = study["frequency"].sel(ONE)
    models = zip(frame["plies"], frame["beams"], strict=True)
    own = [float(reference.sel(plies=plies, beams=beams)) for plies, beams in models]
    columns: dict[str, Any] = {
        "position": frame["position"],
        "crank_angle_deg": crank,
        "laminate": frame["laminate"],
        "case": frame["case"],
        "plies": frame["plies"],
        "beams": frame["beams"],
        "frequency_Hz": frame["frequency"],
        "ratio": frame["frequency"] / own,
    }
    for name in ("finite_element", "measured"):
        columns[f"published_{name}_Hz"] = frame[name]
        columns[f"published_{name}_ratio"] = frame[name] / float(study[name].sel(ONE))
    columns["strain_energy_damping"] = frame["strain_energy_damping"]
    columns["published_damping"] = frame["damping"]
    return pd.DataFrame(columns)


def claim_frame(claims: Sequence[Claim]) -> pd.DataFrame:
    """Tabulate claims: one row each, a column for each of their fields."""
    return pd.DataFrame([dataclasses.asdict(claim) for claim in claims])


def frequency_tables(study: xr.Dataset) -> Iterator[Table]:
    """One table a position, as Tables 4 to 6 of the paper, of ratios.

    Parameters
    ----------
    study : Dataset

    Yields
    ------
    rich.table.Table
        Computed, published finite-element and measured frequency over those of C1, case 1,
        at the least transmission angle.
    """
    from rich.table import Table

    parts = (all_models(study)[0], study["finite_element"], study["measured"])
    relative = [values / values.sel(ONE) for values in parts]
    cases, laminates = study["case"].values.tolist(), study["laminate"].values.tolist()
    for position, words in _POSITIONS.items():
        table = Table(title=words, caption="ratios: computed / finite elements / measured")
        table.add_column("laminate")
        for case in cases:
            table.add_column(f"case {case}", justify="right")
        for laminate in laminates:
            row = [v.sel(position=position, laminate=laminate) for v in relative]
            cells = (" / ".join(f"{float(v.sel(case=case)):.2f}" for v in row) for case in cases)
            table.add_row(laminate, *cells)
        yield table


def claim_lines(claims: Sequence[Claim]) -> Iterator[str]:
    """Word every claim under its verdict: numbers, then the reason.

    Parameters
    ----------
    claims : sequence of Claim

    Yields
    ------
    str
    """
    for verdict in get_args(Verdict):
        yield f"{verdict}:"
        last = ""
        for claim in claims:
            if claim.verdict == verdict:
                yield f"  {claim.place}, {claim.statement}: {_numbers(claim)}"
                if claim.reason and claim.reason != last:
                    yield f"    {claim.reason}"
                last = claim.reason


def _numbers(claim: Claim) -> str:
    parts = (
        ("printed", claim.printed),
        ("from its tables", claim.from_tables),
        ("computed", claim.computed),
        ("by model", claim.other_models),
    )
    return ", ".join(f"{word} {value}" for word, value in parts if value)


def summary_lines(claims: Sequence[Claim]) -> list[str]:
    """Count the verdicts, and say what they rest on."""
    counts = {v: sum(claim.verdict == v for claim in claims) for v in get_args(Verdict)}
    return [
        f"{len(claims)} claims: " + ", ".join(f"{n} {verdict}" for verdict, n in counts.items()),
        f"a number is reproduced if ours is within {100 * REPRODUCED_WITHIN:g} % of the tables'; "
        "the paper prints no link size, so that only ratios compare",
    ]
