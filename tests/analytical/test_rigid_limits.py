"""A rigid link is the limit of an ever stiffer elastic one, at every level of prestress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from flexmech import BeamSection, FourBar, Material, Mechanism, ReferenceEngine
from flexmech.analyses import solve_modes
from flexmech.linear_system import Prestress
from flexmech.linkages import Link, RigidMotion, Topology
from tests.cross_engine.joined_linkages import Plain, SliderCrank, Ternary

FloatArray = NDArray[np.float64]
FOUR_BAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
ANGLES = np.radians([40.0, 170.0])


@dataclass(frozen=True)
class PartlyRigid(Plain):
    """A four-bar some of whose links are rigid."""

    rigid: tuple[str, ...] = ()

    @property
    def topology(self) -> Topology:
        own = FOUR_BAR.topology
        links = tuple(Link(x.name, x.length, x.name in self.rigid) for x in own.links)
        return replace(own, links=links)

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        return FOUR_BAR.motion(crank_angle, crank_speed, crank_acceleration)


def mechanism(linkage: Plain, stiff: Sequence[str] = (), factor: float = 1.0) -> Mechanism:
    """Aluminium strips under their weight, some of them stiffer."""
    sections = {
        name: BeamSection.rectangle(
            Material(68.9e9 * (factor if name in stiff else 1.0), 2923.0), 2.2e-3, 25.4e-3
        )
        for name in linkage.topology.link_names
    }
    return Mechanism(linkage, sections, gravity=(0.0, -9.81))


CASES = [
    (PartlyRigid, ("coupler",)),
    (PartlyRigid, ("crank", "coupler")),
    (PartlyRigid, ("coupler", "rocker")),
    (PartlyRigid, ("crank", "rocker")),
    (SliderCrank, ("crank",)),
    (SliderCrank, ("coupler",)),
    (lambda rigid=(): Ternary(FOUR_BAR, rigid=rigid), ("coupler", "beyond")),
]


@pytest.mark.parametrize(("kind", "rigid"), CASES)
@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
@pytest.mark.parametrize("reduced", [False, True])
def test_rate(kind: type, rigid: tuple[str, ...], prestress: Prestress, reduced: bool) -> None:
    """What is left falls with the stiffness, by a hundred for a hundred."""

    def frequency(case: Mechanism) -> FloatArray:
        engine = ReferenceEngine(case, 8, "euler", component_modes=reduced)
        system = engine.linear_system(
            ANGLES, 20.0, prestress=prestress, rotation_terms=False, modes=3, detail=4.0
        )
        return solve_modes(system, 2).frequency

    limit = frequency(mechanism(kind(rigid=rigid)))
    errors = [
        np.abs(frequency(mechanism(kind(), rigid, factor)) / limit - 1).max()
        for factor in (1e3, 1e5)
    ]
    assert errors[0] < 1.5e-2
    # What component modes leave out, and the rounding of stiff links, does not fall.
    assert errors[1] < 0.03 * errors[0] + 3e-5
