"""What scripts give by mistake: every public door refuses it with a message of its own."""

from __future__ import annotations

import numpy as np
import pytest

import flexmech
from flexmech.errors import InputError
from flexmech.materials import Fibre, Matrix, PlyComposition, published_constituents
from flexmech.materials.laminate import Laminate
from flexmech.reference import ReferenceEngine
from tests.strategies import fourbar

MECHANISM = fourbar()
ENGINE = ReferenceEngine(MECHANISM, 2)
PUBLISHED = published_constituents().values()
FIBRE = next(one for one in PUBLISHED if isinstance(one, Fibre))
MATRIX = next(one for one in PUBLISHED if isinstance(one, Matrix))
PLY = flexmech.ply_from_constituents(FIBRE, MATRIX, 0.5)
MASKED = np.ma.masked_array([0.0, 1.0], [False, True])
TURN = np.linspace(0.0, 6.0, 100_000)

WRONG = {
    "elements": lambda: ReferenceEngine(MECHANISM, elements=1.5),
    "elements from 1 to 500": lambda: ReferenceEngine(MECHANISM, elements=30_000),
    "modes": lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], modes=2.5),
    "modes must be": lambda: ENGINE.linear_system([0.0], modes=2.5),
    "detail": lambda: ENGINE.linear_system([0.0], detail=float("nan")),
    "fastest": lambda: ENGINE.linear_system([0.0], fastest="a"),
    "rotation_terms": lambda: ENGINE.linear_system([0.0], 1.0, rotation_terms="off"),
    "crank_angle": lambda: ENGINE.linear_system(MASKED),
    "crank_angles must be": lambda: flexmech.moving_frequencies(ENGINE, MASKED, [0.0]),
    "crank_speeds": lambda: flexmech.moving_frequencies(ENGINE, [0.0], [float("nan")]),
    "fit into memory": lambda: flexmech.FrequencyRequest(TURN, np.arange(1000.0)),
    "fibre": lambda: flexmech.ply_from_constituents(MATRIX, FIBRE, 0.5),
    "fibre must be": lambda: PlyComposition(MATRIX, FIBRE, 0.5, "chamis"),
    "angles": lambda: Laminate.stacked([PLY] * 5, 1e-3, [0.0] * 4),
    "path": lambda: flexmech.load_mechanism(None),
    "cannot be reached": lambda: flexmech.load_mechanism("a" * 5000),
    "nested too deeply": lambda: flexmech.modelfile.mechanism_from_toml(f"[{'a.' * 9000}b]"),
    "path must": lambda: flexmech.MovingFrequencies.load(3),
}


@pytest.mark.parametrize("word", WRONG)
def test_a_slip_of_a_script_is_refused_by_name(word: str) -> None:
    with pytest.raises(InputError, match=word.split(" from")[0]):
        WRONG[word]()
