"""V6: spin-up of a flexible beam (Simo & Vu-Quoc 1986; ANSYS verification manual VM258).

The cases of the verification hold the deflection, its time and the steady extension.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ComputationError, ExudynEngine, ReferenceEngine, example_model, load_mechanism
from flexmech.time_domain import DrivenLinkage, linear_run
from flexmech.verification import verification_case
from flexmech.verification.methods.running import SPIN_UP, SPIN_UP_TIME, spin_up_trajectory


@pytest.fixture(scope="module")
def arm():
    return load_mechanism(example_model("spin_up_beam"))


def test_drive_is_the_published_one():
    t = np.linspace(0.0, 15.0, 301)
    published = 6 / 15 * (t - 15 / (2 * np.pi) * np.sin(2 * np.pi * t / 15))
    assert np.allclose(SPIN_UP.crank_speed(t), published, rtol=0, atol=1e-12)
    assert SPIN_UP.crank_speed(17.0) == 6.0


def test_without_geometric_stiffness_it_diverges(arm):
    linkage = DrivenLinkage(ReferenceEngine(arm), SPIN_UP, "none")
    nothing = np.zeros(linkage.size)
    with pytest.raises(ComputationError, match="diverges"):
        linear_run(linkage, nothing, nothing, SPIN_UP_TIME, 0.005)


@pytest.mark.parametrize(
    "element", ["ancf", pytest.param("geometrically-exact", marks=pytest.mark.thorough)]
)
def test_exudyn(arm, element):
    elements = {"ancf": 4, "geometrically-exact": 8}[element]
    engine = ExudynEngine(arm, elements=elements, element=element)
    run = spin_up_trajectory(engine, 0.0025)
    tip = np.einsum("cn,bn->bc", engine.links[0].shape[-1], run.displacement[0])
    least, extension = tip[:, 1].min(), tip[SPIN_UP_TIME > 16, 0].mean()
    least_case, time_case = (
        verification_case(f"Spin-up of a flexible beam, {what}: geometrically nonlinear, exudyn")
        for what in ("least deflection of the tip", "time of the least deflection")
    )
    (steady,) = verification_case(
        "Steady rotation of a flexible beam: 6 rad/s, reference"
    ).expected_values()
    assert least == pytest.approx(least_case.expected_values()[0], rel=least_case.tolerance)
    time = SPIN_UP_TIME[tip[:, 1].argmin()]
    assert time == pytest.approx(time_case.expected_values()[0], abs=time_case.tolerance)
    assert extension == pytest.approx(steady, rel=2e-2)
