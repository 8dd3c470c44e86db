"""The scenario on the frame of the aluminium four-bar."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest


@pytest.mark.thorough
def test_soft_frame(
    scenario: Callable[[str], Any],
    expected_number: Callable[[str], Any],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A frame far below the crank's frequency spares the floor, a stiff one passes all on."""
    module = scenario("soft_frame")
    soft = module.main(tmp_path, frequencies=np.array([1.0, 3.2, 60.0]), elements=2)
    assert float(soft.transmitted[0]) == expected_number("soft_frame")
    assert soft.transmitted[1] > 5.0
    assert soft.transmitted[2] == pytest.approx(1.0, abs=0.02)
    assert "passes on 0.070 of what a stiff one does" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["floor.png"]
