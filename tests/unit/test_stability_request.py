"""What a stability map refuses to be asked."""

import numpy as np
import pytest

from flexmech import InputError
from flexmech.analyses.stability.request import StabilityRequest


def test_speeds_are_kept_from_slow_to_fast_in_either_direction():
    assert StabilityRequest([20.0, 5.0]).crank_speeds.tolist() == [5.0, 20.0]
    assert StabilityRequest([-20.0, -5.0]).crank_speeds.tolist() == [-5.0, -20.0]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"crank_speeds": [0.0, 5.0]}, "holds zero"),
        ({"crank_speeds": [-5.0, 5.0]}, "turn both ways"),
        ({"crank_speeds": [5.0, 5.0]}, "repeats a speed"),
        ({"crank_speeds": []}, "one value or more"),
        ({"crank_speeds": [np.nan]}, "crank_speeds"),
        ({"prestress": "much"}, "prestress"),
        ({"frame": "ground"}, "frame"),
        ({"modes": 0}, "modes"),
        ({"steps": 100}, "the nearest above is 112"),
        ({"steps": 16}, "the nearest above is 32"),
        ({"steps": 64.0}, "steps"),
        ({"damping_ratio": -0.1}, "damping_ratio"),
        ({"damping_ratio": 1.0}, "damping_ratio"),
    ],
)
def test_what_makes_no_sense_is_refused_with_the_name_of_the_value(changed, message):
    with pytest.raises(InputError, match=message):
        StabilityRequest(**{"crank_speeds": [5.0]} | changed)
