"""V12 of the validation numbers: slider-crank with a free shaft; V13: rotating planar L-beam."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech import BeamSection, Material, Mechanism, ReferenceEngine
from flexmech.analyses import solve_modes
from flexmech.beams.link_matrices import assemble_chain
from flexmech.linear_system import (
    RotationTerms,
    element_tensions,
    inertia_loads,
    straight_forces,
)
from flexmech.linkages import LinkEnd, Pivot, Topology
from flexmech.mechanism import AttachedBody
from flexmech.sections import DampingTimes
from tests.cross_engine.joined_linkages import LArm, SliderCrank

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class FreeSliderCrank(SliderCrank):
    """Its crank is pivoted where the shaft would clamp it."""

    @property
    def topology(self) -> Topology:
        pivot = Pivot("O2", LinkEnd("crank", "start"))
        return replace(super().topology, clamps=(), pivots=(pivot,))


def slider_crank(damping: DampingTimes | None = None) -> Mechanism:
    """Manzl et al., arXiv 2409.18272: rigid crank, flexible rod, slider."""
    rod = BeamSection.rectangle(Material(1.035e9, 4.0 / 0.02**2), 0.02, 0.02)
    if damping is not None:
        rod = replace(rod, damping=damping)
    return Mechanism(
        FreeSliderCrank(0.5, 1.0, 0.0, 0.0, rigid=("crank",)),
        {"coupler": rod},
        joint_masses={"B": 1.0},
        bodies=(AttachedBody("crank", 0.25, 2.0, 2.0 * 0.5**2 / 12),),
    )


def exponents(mechanism: Mechanism, angle: float, elements: int) -> NDArray[np.complex128]:
    """Eigenvalues at rest, all coordinates."""
    engine = ReferenceEngine(mechanism, elements, "euler", component_modes=False)
    system = engine.linear_system(angle, 0.0)
    mass, damping, stiffness = (m[0] for m in (system.mass, system.damping, system.stiffness))
    lower = np.linalg.inv(np.linalg.cholesky(mass))
    damping, stiffness = (lower @ m @ lower.T for m in (damping, stiffness))
    n = len(mass)
    state = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])
    return np.asarray(scipy.linalg.eigvals(state))


@pytest.mark.parametrize(
    ("angle", "expected"), [(0.0, (3.76694, 12.8244, 27.571)), (60.0, (2.94941, 11.7310, 26.285))]
)
@pytest.mark.parametrize("elements", [16, 40])
def test_v12_frequencies(angle: float, expected: tuple[float, ...], elements: int) -> None:
    engine = ReferenceEngine(slider_crank(), elements, "euler", component_modes=False)
    system = engine.linear_system(np.radians(angle), 0.0)
    squares = scipy.linalg.eigh(system.stiffness[0], system.mass[0], eigvals_only=True)
    found = np.sqrt(np.abs(squares[:4])) / (2 * np.pi)
    assert found[0] < 1e-3  # the shaft turns freely
    np.testing.assert_allclose(found[1:], expected, rtol=1e-4)


def test_v12_decay_rates_over_half_a_turn() -> None:
    mechanism = slider_crank(DampingTimes(axial=0.01, bending=0.015, shear=0.015))
    slow, fast = [], []
    for angle in np.radians(np.arange(0.0, 181.0, 2.0)):
        found = exponents(mechanism, angle, 16)
        swinging = found[found.imag > 1.0]
        first, second = swinging[np.argsort(np.abs(swinging))[:2]]
        slow.append(-first.real)
        fast.append(-second.real)
    # Stated with three decimals, four, and two.
    assert min(slow) == pytest.approx(2.520, abs=5e-4)
    assert max(slow) == pytest.approx(4.2015, rel=1e-4)
    assert (min(fast), max(fast)) == pytest.approx((40.28, 48.70), rel=1.2e-4)


@pytest.fixture(scope="module")
def l_beam() -> Mechanism:
    """Wallrapp & Schwertassek 1998."""
    return Mechanism(
        LArm(2.0, 0.4),
        {
            "arm": BeamSection.rectangle(Material(7e10, 3000.0), 9e-3, 9e-3),
            "leg": BeamSection.rectangle(Material(21e10, 7895.0), 9.5e-3, 9e-3),
        },
    )


PUBLISHED = {0.0: (0.9614, 7.037, 16.67), 6.0: (1.044, 7.478, 17.09)}


@pytest.mark.parametrize("speed", [0.0, 6.0])
@pytest.mark.parametrize("reduced", [False, True])
def test_v13_with_the_tension_of_the_straight_arms(
    l_beam: Mechanism, speed: float, reduced: bool
) -> None:
    engine = ReferenceEngine(l_beam, 28, "euler", component_modes=reduced)
    found = solve_modes(engine.linear_system(0.3, speed, prestress="axial"), 3).frequency[0]
    np.testing.assert_allclose(found, PUBLISHED[speed], rtol=0.01)
    stated = {0.0: (0.9614, 7.0364, 16.757), 6.0: (1.0383, 7.5100, 17.117)}[speed]
    np.testing.assert_allclose(found, stated, rtol=2e-3 if speed else 3e-5)


def test_v13_tension_of_the_arms_displaced_by_linear_theory(l_beam: Mechanism) -> None:
    """The stated Hermite values: k_G with the tension of a linear preload that is iterated."""
    engine = ReferenceEngine(l_beam, 28, "euler", component_modes=False)
    motion = l_beam.linkage.motion(np.array([0.3]), 6.0)
    frames = engine.equilibrium.frames
    loads = inertia_loads(engine.links, motion, (0.0, 0.0))
    straight = straight_forces(l_beam, frames, motion, loads)
    tensions = element_tensions(l_beam, engine.nodes, motion, straight.links)
    for _ in range(30):
        tangent = [
            chain.model.stiffness
            + assemble_chain(chain.elements.geometric_stiffness(tensions[number]))
            for number, chain in engine.chains.items()
        ]
        matrices = frames.assemble(motion, tangent, RotationTerms())
        moved = np.linalg.solve(matrices.stiffness, frames.gather(motion, loads)[..., None])
        change = 0.0
        for number, q in enumerate(frames.link_coordinates(motion, moved)):
            elements = engine.chains[number].elements
            along = np.diff(q[0, ::3, 0]) / elements.length
            mean = elements.section.axial_stiffness * along
            change = max(change, np.abs(mean - tensions[number][0, :, 0]).max())
            tensions[number][0, :, 0] = mean
    assert change < 1e-6
    system = engine.linear_system(0.3, 6.0, prestress="none")
    iterated = replace(system, stiffness=matrices.stiffness)
    found = solve_modes(iterated, 3).frequency[0]
    np.testing.assert_allclose(found, (1.0383, 7.5100, 17.117), rtol=2e-4)
