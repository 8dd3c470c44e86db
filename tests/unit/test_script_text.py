"""Values of an exported script: evaluated again, its text gives what was written."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexmech.multibody.items import Made
from flexmech.multibody.running.script_text import Brackets, expression, quoted, statement
from flexmech.multibody.running.user_functions import Shaft, difference_mass, turned_frame


def evaluated(value: Any) -> Any:
    """The value of the text of an expression."""
    text = expression(value)
    known = {"np": np, "Shaft": Shaft, "turned_frame": turned_frame}
    return eval(text.line if isinstance(text, Brackets) else text, known)


@pytest.mark.parametrize(
    "value",
    [
        1 / 3,
        -2.5e-17,
        np.float64(0.1) * 3,
        np.int64(7),
        True,
        (1.0,),
        [1.0 / 7, (2, "x")],
        'a "name"',
        "it's a \\ name\n",
        Shaft(0.1 / 3, 20.0, ((0.0, 0.05, (0.1, 1 / 3), (0.0, 0.0, 0.7)),)),
    ],
)
def test_the_text_of_a_value_is_the_value_to_the_last_digit(value: Any) -> None:
    found = evaluated(value)
    assert found == value
    assert isinstance(found, tuple) == isinstance(value, tuple)


@pytest.mark.parametrize(
    "matrix",
    [
        np.array([0.1, 1 / 3]),
        np.diag([0.1, 0.2, 0.0]),
        np.array([[1.0, 2.0 / 3], [0.0, 4.0]]),
        difference_mass(-0.3, 1e-5),
    ],
)
def test_the_text_of_an_array_is_the_array(matrix: np.ndarray) -> None:
    np.testing.assert_array_equal(evaluated(matrix), matrix)


def test_what_functions_make_is_made_again() -> None:
    frame = turned_frame(0.1, -0.2, 1 / 3)
    np.testing.assert_array_equal(evaluated(Made(turned_frame, (0.1, -0.2, 1 / 3))), frame)


def test_names_are_in_double_quotes_where_they_can_be() -> None:
    assert quoted("crank") == '"crank"'
    assert quoted('a "name"') == "'a \"name\"'"


def test_long_statements_are_folded_and_stay_the_same() -> None:
    value = [n / 7 for n in range(12)]
    lines = statement("found = ", expression(value), depth=1)
    assert len(lines) > 2
    assert all(line.startswith("    ") for line in lines)
    folded: dict[str, Any] = {}
    exec("\n".join(line.removeprefix("    ") for line in lines), folded)
    assert folded["found"] == value
