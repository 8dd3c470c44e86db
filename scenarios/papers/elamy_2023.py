"""Which claims of Elamy et al. 2023 on composite crank-rockers hold?

Six laminates of carbon and glass, four linkages, three positions of the transmission angle: their
fundamental frequencies, damping, motion and strength, by every model of plies, beams and joints
that the paper leaves open, beside what its tables print. Each of its claims is put to the test,
with the uncertainty that the printed spreads of fibres and resin leave, what would have made it
fail, and the reason where it does. The paper prints no link size, so that only ratios compare.

Beside the pictures stand `composites.csv`, with a row for each plies, layers, beams,
supports, position, laminate and case; `composite_properties.csv`, the laminates by the rule of
mixtures beside Table 2; `composite_running.csv`, torque, power, joint force and deflection of the
linkages in motion, and of the same links of steel; `composite_strength.csv`, the nominal stress at
which each stacking's first ply fails, and the crank speed at which inertia breaks each linkage;
`composite_claims.csv`, every claim with its verdict; all numbers in `composites.nc`; and the model
files of the 120 linkages in `models`.

    python scenarios/papers/elamy_2023.py
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import xarray as xr
from elamy_claims import composite_claims
from elamy_linkages import GROUND, MODELS, THICKNESS, WIDTH, crank_rocker_files, stored
from elamy_pictures import pictures_of
from elamy_study import study_composites
from elamy_tables import (
    frequency_table,
    printed_tables,
    property_table,
    running_table,
    strength_table,
    weakest,
)
from paper_claims import (
    REPRODUCED_WITHIN,
    SPREADS,
    Claim,
    claim_lines,
    claim_table,
    verdict_sentences,
)

from flexmech.studies import workers

PROCESSES = 1


@dataclass(frozen=True)
class ElamyAnswer:
    """The study, the paper's claims with their verdicts, and the tables by names of their files."""

    study: xr.Dataset
    claims: list[Claim]
    tables: dict[str, pd.DataFrame]


def answer_of(study: xr.Dataset) -> ElamyAnswer:
    """Claims and tables of a study."""
    claims = composite_claims(study)
    tables = {
        "composites": frequency_table(study),
        "composite_claims": pd.DataFrame(claims),
        "composite_properties": property_table(study),
        "composite_running": running_table(study),
        "composite_strength": strength_table(study),
    }
    return ElamyAnswer(study, claims, tables)


if __name__ == "__main__":
    with workers(PROCESSES) as executor:
        answer = answer_of(study_composites(executor))
    answer.study.to_netcdf("composites.nc", engine="h5netcdf")
    for name, table in answer.tables.items():
        table.to_csv(f"{name}.csv", index=False, float_format="%.6g")
    Path("models").mkdir(exist_ok=True)
    for name, text in crank_rocker_files().items():
        Path("models", name).write_text(text, encoding="utf-8")
    for name, figure in pictures_of(answer.study).items():
        figure.savefig(f"{name}.png")

    conclusions = stored("elamy_2023_claims")["conclusions"]
    print(*verdict_sentences("Elamy et al. 2023", answer.claims, conclusions), sep="\n")
    print(
        f"frequencies here: {MODELS[0][0]} plies, {MODELS[0][1]}; sizes are assumed (GROUND, "
        f"THICKNESS, WIDTH of elamy_linkages.py): ground {1e3 * GROUND:g} mm, links "
        f"{1e3 * THICKNESS:g} mm by {1e3 * WIDTH:g} mm"
    )
    print(f"\n{claim_table(answer.claims).to_string()}")
    for words, table in printed_tables(answer.tables).items():
        print(f"\n{words}\n{table.to_string()}")
    print(f"\n{weakest(answer.tables)}", *claim_lines(answer.claims), sep="\n")
    print(
        f"a number is reproduced if ours is within {100 * REPRODUCED_WITHIN:g} % of the one "
        f"printed, or within {SPREADS:g} uncertainties of ours by Table 1 where that is more, and "
        "undecidable if that band is not narrower than the effect"
    )
