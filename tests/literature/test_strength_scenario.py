"""The scenario on the strength of the aluminium four-bar."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest


def test_strength_of_a_fourbar(
    scenario: Callable[[str], Any],
    expected_number: Callable[[str], Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The rocker breaks first, after many turns; links that stayed straight would bear more."""
    module = scenario("strength_of_a_fourbar")
    turn = np.radians(np.arange(0.0, 361.0, 15.0))
    # The crank angle at which the rocker is worst is among them.
    turn = np.sort(np.append(turn, np.radians(25.0)))
    answer = module.main(tmp_path, speeds=np.array([20.0, 40.0, 80.0]), angles=turn)
    part, kind, speed = answer.first
    assert (part, kind) == ("rocker", "fatigue")
    assert speed == expected_number("strength_of_a_fourbar")
    assert f"rocker fails first, fatigue, at {speed:.1f} rad/s" in capsys.readouterr().out
    rigid = answer.factors.sel(source="rigid", part="link rocker")
    np.testing.assert_allclose(rigid * rigid["speed"] ** 2, rigid[0] * 20.0**2, rtol=1e-9)
    wear = answer.factors.sel(source="rigid", part="pin A")
    np.testing.assert_allclose(wear * wear["speed"] ** 3, wear[0] * 20.0**3, rtol=1e-9)
    elastic = answer.factors.sel(source="quasi-static", part="link rocker")
    assert float(elastic[2]) < 0.6 * float(rigid[2])
    # Where links hardly bend, both are alike.
    assert float(elastic[0]) == pytest.approx(float(rigid[0]), rel=0.05)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["linkage.png", "load_factors.png"]
