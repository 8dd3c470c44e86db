"""A link that is clamped to a hub, and the same linkage with the hub drawn as a rigid link."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from flexmech import (
    BeamSection,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
)
from flexmech.analyses import solve_modes
from flexmech.choices import Prestress
from flexmech.linear_system import Engine
from flexmech.linkages import FourBar, RigidMotion, Topology
from flexmech.linkages.motion import direction, normal

HUB = 0.03
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
DRAWN = """
name = "four-bar with a rigid hub"
source = "drawn here"

[linkage]
kind = "planar"
ground = ["O2", "O4"]

[linkage.points]
O2 = ["0 m", "0 m"]
H = ["{hub!r} m", "0 m"]
A = {A}
B = {B}
O4 = {O4}

[materials.aluminium]
youngs_modulus = "70 GPa"
density = "2700 kg/m^3"
poisson_ratio = 0.3

[links.hub]
points = ["O2", "H"]
rigid = true
mass = "0 kg"
inertia = "0 kg m^2"
{links}
[joints.O2]
kind = "clamp"

[joints.H]
kind = "weld"
"""
LINK = """
[links.{name}]
points = ["{first}", "{second}"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"
out_of_plane_width = "25 mm"
"""


@dataclass(frozen=True)
class FourBarOnHub(FourBar):
    """Four-bar whose crank is elastic from its hub on."""

    @property
    def topology(self) -> Topology:
        drawn = super().topology
        crank, *others = drawn.links
        shorter = replace(crank, length=crank.length - HUB)
        [clamp] = drawn.clamps
        return replace(drawn, links=(shorter, *others), clamps=(replace(clamp, hub=HUB),))

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        found = super().motion(crank_angle, crank_speed, crank_acceleration)
        along, across = HUB * direction(found.angle[..., 0]), HUB * normal(found.angle[..., 0])
        speed = found.angular_velocity[..., 0, None]
        change = found.angular_acceleration[..., 0, None]
        own = (found.origin, found.origin_velocity, found.origin_acceleration)
        place, velocity, acceleration = (each.copy() for each in own)
        place[..., 0, :] += along
        velocity[..., 0, :] += speed * across
        acceleration[..., 0, :] += change * across - speed**2 * along
        return replace(
            found, origin=place, origin_velocity=velocity, origin_acceleration=acceleration
        )


def both(mechanism: Mechanism, folder: Path) -> tuple[Mechanism, Mechanism]:
    """A four-bar on a hub, and the same with that as a rigid link."""
    bars = mechanism.linkage
    assert isinstance(bars, FourBar)
    on_hub = FourBarOnHub(bars.ground, bars.crank, bars.coupler, bars.rocker, bars.branch)
    motion, lengths = bars.motion(0.0), [link.length for link in bars.topology.links]
    places = {
        "A": motion.position(0, lengths[0]),
        "B": motion.position(1, lengths[1]),
        "O4": motion.position(2, 0.0),
    }
    points = {
        name: f'["{float(place[0])!r} m", "{float(place[1])!r} m"]'
        for name, place in places.items()
    }
    ends = {"crank": ("H", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    links = (LINK.format(name=n, first=a, second=b) for n, (a, b) in ends.items())
    path = folder / "drawn.toml"
    path.write_text(DRAWN.format(hub=HUB, links="".join(links), **points))
    drawn = replace(load_mechanism(path), sections=dict(mechanism.sections), shaft_inertia=1e-3)
    return replace(mechanism, linkage=on_hub, shaft_inertia=1e-3), drawn


@pytest.mark.parametrize("level", ["none", "axial", "equilibrium"])
@pytest.mark.parametrize(
    ("make", "element", "close"), [(ReferenceEngine, "euler", 1e-10), (ExudynEngine, "ancf", 1e-6)]
)
def test_a_hub_on_a_free_shaft_is_a_rigid_link(
    make: type[Engine],
    element: str,
    close: float,
    level: Prestress,
    aluminium: Mechanism,
    tmp_path: Path,
) -> None:
    """The force of the clamp is a spring against the shaft's rotation, whatever hangs on the link.

    By the loads of one body alone the shaft's own mode was 6e-3 off.
    """
    found = []
    for mechanism in both(aluminium, tmp_path):
        engine = make(mechanism, 4, element, shaft="free")
        modes = solve_modes(engine.linear_system([0.3, 2.0, 4.0], 20.0, prestress=level), 3)
        found.append((modes.frequency, np.sort(np.abs(modes.rigid), axis=1)))
    for hub, drawn in zip(*found, strict=True):
        np.testing.assert_allclose(hub, drawn, rtol=close * 100, atol=1e-3)
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=close)


@pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
def test_a_hub_is_as_stiff_in_a_running_state_as_at_the_equilibrium(make: type[Engine]) -> None:
    arm = Mechanism(RotatingArm(0.3, hub_radius=0.05), {"arm": SECTION}, shaft_inertia=2e-3)
    engine, motion = make(arm, 8, shaft="free"), arm.linkage.motion(np.array([0.3]), 40.0)
    state = engine.stressed_links(motion, "equilibrium")
    assert state.displacement is not None
    running = engine.running_links(motion, state.displacement)
    turn = int(engine.links[0].start_rotation[0])
    at_rest, in_run = (np.asarray(each.tangent[0])[0, turn, turn] for each in (state, running))
    tension = SECTION.mass_per_length * 0.3 * 40.0**2 * (0.05 + 0.15)
    assert in_run == pytest.approx(at_rest, abs=1e-3 * 0.05 * tension)


def test_a_hub_moves_a_mass_at_its_end() -> None:
    """The rotation of a shaft without inertia of its own is no coordinate without mass."""
    arm = Mechanism(RotatingArm(0.3, hub_radius=0.05), {"arm": SECTION})
    without, nearly = (
        natural_frequencies(
            ReferenceEngine(mechanism, 4, "euler", shaft="free", mass="lumped"), 0.3, 20.0, modes=2
        )
        for mechanism in (arm, replace(arm, shaft_inertia=1e-12))
    )
    np.testing.assert_allclose(without, nearly, rtol=1e-6)
