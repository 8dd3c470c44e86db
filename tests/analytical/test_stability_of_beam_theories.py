"""What the beam theory changes of Floquet multipliers is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import ReferenceEngine, load_mechanism, stability

DATA = Path(__file__).parents[1] / "data"


def test_a_finer_theory_changes_the_largest_multiplier_by_what_is_told() -> None:
    """A strip of 250 by 1.6 mm: shear and rotary inertia change frequencies by less than 1e-3.

    At 44 rad/s the largest modulus is 0.6676 of Euler's beams and 0.6645 of Timoshenko's; which are
    taken depends on how many modes are asked for.
    """
    mechanism = load_mechanism(DATA / "sprung_slider_crank.toml")
    euler, timoshenko = (
        stability(
            ReferenceEngine(mechanism, 4, element), [44.0], prestress="axial", modes=3
        ).dataset
        for element in ("euler", "timoshenko")
    )
    changed = float(np.log(euler["multiplier_modulus"] / timoshenko["multiplier_modulus"])[0, 0])
    assert 3e-3 < changed < float(euler["check_growth"].max())
    # Zigzag beams are Timoshenko's here; the rest is by the mesh, which both share.
    assert float(timoshenko["check_theory"].max()) < 0.1 * float(euler["check_theory"].max())
    by_mesh = [float(each["check_growth"].max()) for each in (euler, timoshenko)]
    assert by_mesh[0] - by_mesh[1] == pytest.approx(changed, rel=0.5)
