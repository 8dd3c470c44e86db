"""What a paper claims, and what a study found of it."""

from __future__ import annotations

import numpy as np

from flexmech.analyses import Table
from flexmech.report import panel
from flexmech.report.results import Results
from flexmech.studies import CompositeStudy

# Columns of the table of claims, each with its heading.
COLUMNS = {
    "place": "place",
    "statement": "claim",
    "printed": "printed",
    "from_tables": "its tables",
    "computed": "computed",
    "spread": "uncertainty",
    "other_models": "by model",
    "verdict": "verdict",
    "fails_if": "what would fail it",
    "reason": "why",
}


@panel.shows(CompositeStudy)
def claims_panel(result: CompositeStudy, results: Results) -> panel.Panel:
    """Factors of the laminates, the study's tables and every claim with its verdict."""
    data, said = result.dataset, result.summary()
    names = data["laminate"].values.tolist()
    place = np.arange(1.0, len(names) + 1)
    bent = data["laminate_factor"].sel(beams="converged")
    traces = [
        panel.Trace(f"{plies}, {layers}", place, bent.sel(plies=plies, layers=layers).values, n)
        for n, (plies, layers) in enumerate(
            (plies, layers)
            for plies in ("woven", "unidirectional")
            for layers in data["layers"].values.tolist()
        )
    ]
    table_2 = bent.sel(plies="table 2").isel(layers=0).values
    traces.append(panel.Trace("Table 2", place, table_2, len(traces)))
    published = data["published_laminate_factor"].values
    traces.append(panel.Trace("published", place, published, panel.GREY, "dash", 2.4))
    plot = panel.Plot(
        "claims-factors",
        f"Laminate ({', '.join(f'{n:.0f}: {name}' for n, name in zip(place, names, strict=True))})",
        (panel.YAxis(f"Frequency over that of {names[0]}"),),
        tuple(traces),
        "Frequency of each laminate over that of the first, by model and as published",
        tick=1.0,
    )
    claims = result.claims()
    rows = tuple(tuple(str(getattr(each, name)) for name in COLUMNS) for each in claims)
    table = Table("Claims", tuple(COLUMNS.values()), (rows,), text_columns=len(COLUMNS))
    return panel.panel_of(
        "claims",
        plots=(plot,),
        tables=(*said.tables, table),
        lines=(said.trust,),
        first=names[0],
        source=f"{data.attrs['source']}; bending of linear beams",
    )
