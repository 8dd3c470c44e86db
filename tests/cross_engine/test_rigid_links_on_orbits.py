"""Nonlinear orbits of linkages whose rigid links are pinned at both ends."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import ConstantSpeed, ExudynEngine, Mechanism, ReferenceEngine, load_mechanism
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine
from flexmech.time_domain import LinkState, nonlinear_orbit
from flexmech.time_domain.periodic_motion.orbit_equations import OrbitEquations, times

SPEED = 5.0
MODEL = """name = "drawn"
source = "own"
[linkage]
kind = "planar"
drawn_at = "0 deg"
ground = ["O2", "O4"]
[linkage.points]
O2 = ["0 m", "0 m"]
A = ["0.1 m", "0 m"]
B = ["0.33 m", "0.26 m"]
O4 = ["0.3 m", "0 m"]
[materials.aluminium]
youngs_modulus = "69 GPa"
poisson_ratio = 0.3
density = "2700 kg/m^3"
[joints.O2]
kind = "clamp"
[environment]
gravity = ["0 m/s^2", "-9.81 m/s^2"]
[operation]
crank_speeds = ["5 rad/s"]
"""
STRIP = """section = "rectangle"
material = "aluminium"
in_plane_thickness = "2 mm"
out_of_plane_width = "25 mm"
damping_time = "2e-4 s"
"""
RIGID = 'rigid = true\nmass = "0.1 kg"\ninertia = "5e-4 kg m^2"\ncentre = "{} m"\n'
LENGTH = float(np.hypot(0.23, 0.26))


def four_bar(folder: Path, rigid: str, *, turned: bool) -> Mechanism:
    """With a rigid link that is drawn from one of its ends or from the other."""
    text = MODEL
    for name, ends in {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B"}.items():
        points = ends.split()[:: -1 if turned and name == rigid else 1]
        centre = 0.3 * LENGTH
        held = RIGID.format(LENGTH - centre if turned else centre)
        text += f"[links.{name}]\npoints = {points}\n{held if name == rigid else STRIP}"
    path = folder / f"{turned}.toml"
    path.write_text(text.replace("'", '"'))
    return load_mechanism(path)


def orbit_of(engine: Engine) -> dict[str, FloatArray]:
    moved = nonlinear_orbit(engine, SPEED).displacement
    return dict(zip(engine.topology.link_names, moved, strict=True))


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_rigid_coupler_is_the_same_drawn_from_either_end(
    make: type[Engine], tmp_path: Path
) -> None:
    """With its far end linear in the rotation they were 1e-3 (Exudyn) and 4e-6 apart."""
    first, second = (
        orbit_of(make(four_bar(tmp_path, "coupler", turned=turned), 3, component_modes=False))
        for turned in (False, True)
    )
    for name in ("crank", "rocker"):
        scale = np.abs(first[name]).max()
        np.testing.assert_allclose(second[name], first[name], rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("rigid", ["coupler", "rocker"])
def test_a_run_stays_on_the_orbit(rigid: str, tmp_path: Path) -> None:
    """Exudyn's own motion left that of linear ties by 1e-3 and 2e-4 of the displacement."""
    engine = ExudynEngine(four_bar(tmp_path, rigid, turned=False), 3, component_modes=False)
    orbit, drive = nonlinear_orbit(engine, SPEED, samples=96), ConstantSpeed(SPEED)
    start = LinkState([q[0] for q in orbit.displacement], [rate[0] for rate in orbit.rate])
    time = drive.revolution_time / 96 * np.arange(13.0)
    run = engine.simulate(drive, start, time, drive.revolution_time / 4000)
    for found, expected in zip(run.displacement, orbit.displacement, strict=True):
        gap = np.abs(found - expected[: len(time)]).max()
        assert gap < 2e-5 * np.abs(expected).max()


def test_tangents_are_the_derivatives_of_the_residual(tmp_path: Path) -> None:
    """Also by what finite poses change: a soft motion must not stretch a stiff link."""
    engine = ReferenceEngine(four_bar(tmp_path, "coupler", turned=False), 3, component_modes=False)
    equations = OrbitEquations(engine, SPEED, 32)
    rest = engine.stressed_links(equations.motion, "equilibrium").displacement
    assert rest is not None
    z = equations.independent(rest)
    wave = np.cos(3 * equations.motion.crank_angle)[:, None]
    way = 1e-8 * wave * np.random.default_rng(1).standard_normal(z.shape[1])
    tangent = equations.linearized(equations.state(z).stressed)
    expected = times(tangent.mass, equations.second @ way) + times(tangent.stiffness, way)
    expected += times(tangent.damping, equations.first @ way)
    found = (equations.state(z + way).residual - equations.state(z - way).residual) / 2
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5 * np.abs(expected).max())
