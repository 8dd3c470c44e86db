"""V6: spin-up of a flexible beam (Simo & Vu-Quoc 1986; ANSYS verification manual VM258)."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ComputationError,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
)
from flexmech.linkages import CrankDrive
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run

DRIVE = CrankDrive(6.0, run_up_time=15.0)
TIME = np.linspace(0.0, 20.0, 4001)
STEADY_EXTENSION = 5.142857e-4


@pytest.fixture(scope="module")
def arm() -> Mechanism:
    section = BeamSection(
        axial_stiffness=2.8e7,
        bending_stiffness=1.4e4,
        shear_stiffness=1.0e7,
        mass_per_length=1.2,
        rotary_inertia=6e-4,
        in_plane_thickness=0.1,
    )
    return Mechanism(RotatingArm(10.0), {"arm": section})


def linear(arm, level, engine=None):
    linkage = DrivenLinkage(engine or ReferenceEngine(arm), DRIVE, level)
    nothing = np.zeros(linkage.size)
    return linear_run(linkage, nothing, nothing, TIME, 0.005)


def tip(engine, trajectory):
    return np.einsum("cn,bn->bc", engine.links[0].shape[-1], trajectory.displacement[0])


def test_drive_is_the_published_one():
    t = np.linspace(0.0, 15.0, 301)
    published = 6 / 15 * (t - 15 / (2 * np.pi) * np.sin(2 * np.pi * t / 15))
    assert np.allclose(DRIVE.crank_speed(t), published, rtol=0, atol=1e-12)
    assert DRIVE.crank_speed(17.0) == 6.0


def test_linear_reference_with_geometric_stiffness(arm):
    engine = ReferenceEngine(arm)
    deflection = tip(engine, linear(arm, "axial"))[:, 1]
    assert deflection.min() == pytest.approx(-0.57437, rel=1e-4)
    assert TIME[deflection.argmin()] == pytest.approx(6.760, abs=0.01)


def test_steady_extension(arm):
    engine = ReferenceEngine(arm, component_modes=False)
    extension = tip(engine, linear(arm, "axial", engine))[TIME > 16, 0]
    assert extension.mean() == pytest.approx(STEADY_EXTENSION, rel=5e-4)


def test_without_geometric_stiffness_it_diverges(arm):
    with pytest.raises(ComputationError, match="diverges"):
        linear(arm, "none")


@pytest.mark.parametrize("element", ["ancf", "geometrically-exact"])
def test_exudyn(arm, element):
    elements = {"ancf": 4, "geometrically-exact": 8}[element]
    engine = ExudynEngine(arm, elements=elements, element=element)
    trajectory = engine.simulate(DRIVE, LinkState.rigid(engine.links), TIME, 0.0025)
    deflection = tip(engine, trajectory)
    assert deflection[:, 1].min() == pytest.approx(-0.57437, rel=1e-2)
    assert TIME[deflection[:, 1].argmin()] == pytest.approx(6.760, abs=0.05)
    foreshortening = deflection[TIME > 16, 0].mean()
    assert foreshortening == pytest.approx(STEADY_EXTENSION, rel=2e-2)
