"""Running linkages in the report: links that do not bend take no room."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ReferenceEngine, Response, ResponseRequest, response
from flexmech.modelfile import mechanism_from_toml, template
from flexmech.report.panels.response import response_panel, spectrum_panel
from flexmech.report.results import Results


@pytest.fixture(scope="module")
def run() -> Response:
    """A slider-crank whose crank is rigid."""
    mechanism = mechanism_from_toml(template("slider-crank"))
    assert list(mechanism.sections) == ["rod"]
    request = ResponseRequest(100.0, 1.0, start="periodic", modes=2)
    return response(ReferenceEngine(mechanism, 2), request)


def test_a_rigid_link_has_no_chart_of_its_deflection(run: Response) -> None:
    panel = response_panel(Results.of(run))
    assert panel is not None
    deflection, forces = panel.plots
    assert [axis.title for axis in deflection.axes] == ["rod"]
    (line,) = deflection.traces
    assert line.axis == 0
    most = float(np.abs(run.dataset["deflection"].sel(link="rod")).max())
    assert np.abs(line.y).max() == pytest.approx(1e3 * most, rel=1e-2)
    assert [axis.title.split()[0] for axis in forces.axes] == ["O2", "A", "B", "torque"]
    told = [reading.label for reading in panel.readings if reading.group == "Deflection"]
    assert told == ["rod"]
    (table,) = panel.tables
    (rows,) = table.groups
    assert [row[3] for row in rows] == ["rod", "O2", "A", "B", "shaft"]
    spectrum = spectrum_panel(Results.of(run))
    assert spectrum is not None
    assert {trace.name for trace in spectrum.plots[0].traces} == {"rod"}


def test_a_run_says_its_answer_first_and_once(run: Response) -> None:
    panel = response_panel(Results.of(run))
    assert panel is not None
    assert panel.answer == tuple(f"100 rad/s: {line}" for line in run.summary().answer)
    assert not set(panel.answer) & set(panel.lines)
    assert any(run.summary().trust in line for line in panel.lines)
