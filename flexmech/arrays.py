"""Types of arrays and of progress reports, each spelt once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["ComplexArray", "FloatArray", "IntArray", "LabelledProgress", "StepProgress", "silent"]

ComplexArray = NDArray[np.complexfloating[Any, Any]]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
"""Of indices."""
StepProgress = Callable[[int, int], None]
"""Called with the steps done and the steps to do."""
LabelledProgress = Callable[[str, int, int], None]
"""Called with what is being done, the steps done and the steps to do."""


def silent(*told: object) -> None:
    """Progress of either kind that is reported to nobody."""
