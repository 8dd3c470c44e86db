"""Runs in time of links whose centres of mass or neutral axis are off the pins' axis.

Both turn with their sections. What tells a strip from its mirror image is of the first order in the
rotation: it is held against Exudyn's run, a chain of bodies and the equilibrium.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    FourBar,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
)
from flexmech.analyses.response.measurements import deflections
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine, whole
from flexmech.materials import Material
from flexmech.sections import BeamSection
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run, static_balance
from flexmech.time_domain.equations_of_motion import turning_sections
from tests.support.thick_links import UNSYMMETRIC, fourbar
from tests.cross_engine.test_two_drawings import heavy_strip

SPEED, OFF = 6.0, 1.9e-3
DRIVE = ConstantSpeed(SPEED)
TIME = np.linspace(0.0, DRIVE.revolution_time / 4, 51)


def strip(neutral: float, mass: float) -> BeamSection:
    plain = BeamSection.rectangle(Material(2e9, 2700.0), 4e-3, 25e-3)
    return replace(plain, neutral_axis=neutral, mass_axis=mass, layers=None)


def arm(neutral: float, mass: float) -> Mechanism:
    return Mechanism(RotatingArm(0.3), {"arm": strip(neutral, mass)}, gravity=(0.0, -8.0))


def ran(engine: Engine, steps: int = 500) -> FloatArray:
    """Deflections (N, links) from a start without vibration."""
    if isinstance(engine, ExudynEngine):
        start, step = LinkState.rigid(engine.links), TIME[-1] / (3 * steps)
        return deflections(engine, engine.simulate(DRIVE, start, TIME, step))
    linkage = DrivenLinkage(engine, DRIVE, stretches=True)
    nothing = np.zeros(linkage.size)
    run = linear_run(linkage, nothing, nothing, TIME, TIME[-1] / steps)
    assert run.energy_error < 1e-5
    return deflections(engine, run)


@pytest.mark.parametrize("axes", [(0.0, OFF), (OFF, 0.0)], ids=["mass", "neutral axis"])
def test_arms_turn_as_they_do_in_the_other_engine(axes: tuple[float, float]) -> None:
    """They tell mirror images apart by 1.5e-2 of the peak; straight arms were 4.4e-3 off."""
    apart = []
    for kind, element in ((ReferenceEngine, "timoshenko"), (ExudynEngine, "geometrically-exact")):
        above, below = (ran(kind(arm(s * axes[0], s * axes[1]), 8, element)) for s in (1, -1))
        apart.append((above - below) / np.abs(above).max())
    assert np.abs(apart[1]).max() > 1e-2
    assert np.abs(apart[0] - apart[1]).max() < 5e-4


def small_motions(engine: Engine, speed: float) -> FloatArray:
    """Three frequencies of a run about where it could rest."""
    linkage = DrivenLinkage(engine, ConstantSpeed(speed), stretches=True)
    assert linkage.stretch is not None
    rest, now = static_balance(linkage, np.zeros(linkage.size)), linkage.equations(np.zeros(1))
    _, tangent = linkage.stretch.static_force(linkage.stretch.pin_rotations(now.motion), rest)
    mass, still = now.mass[0], np.zeros_like(now.mass[0])
    first = np.block([[np.eye(len(mass)), still], [still, mass]])
    second = np.block([[still, np.eye(len(mass))], [-now.stiffness[0] - tangent, -now.damping[0]]])
    found = scipy.linalg.eigvals(second, first).imag
    return np.asarray(np.sort(found[found > 0])[:3] / (2 * np.pi))


@pytest.mark.parametrize(
    ("axes", "tolerance"), [((0.0, OFF), 0.15), ((OFF, 0.0), 0.1), ((OFF, OFF), 0.15)]
)
def test_small_motions_have_the_mass_matrix_of_the_equilibrium(
    axes: tuple[float, float], tolerance: float
) -> None:
    """What tells the lowest frequencies of mirror images apart, 9e-4 of them.

    It had the opposite sign. Of a strip that is off the pins as a whole there is no difference but
    by the mesh of the equilibrium, where the mass that turns is at nodes.
    """
    apart = []
    for found in (small_motions, lambda e, speed: natural_frequencies(e, 0.0, speed, modes=3)):
        above, below = (
            found(
                ReferenceEngine(
                    arm(s * axes[0], s * axes[1]), 16, "timoshenko", component_modes=False
                ),
                4.0,
            )
            for s in (1, -1)
        )
        apart.append((above / below - 1)[:2])
    np.testing.assert_allclose(*apart, rtol=0, atol=tolerance * 7e-4)


def test_arms_of_links_that_hardly_bend_are_rigid() -> None:
    """Frequencies at rest of links eight times as long as high."""
    engine = ReferenceEngine(fourbar(UNSYMMETRIC), 8, "timoshenko", component_modes=False)
    still = natural_frequencies(engine, 0.0, modes=3)
    np.testing.assert_allclose(small_motions(engine, 1e-3), still, rtol=3e-6)


def test_symmetric_sections_have_no_arms(models: Path) -> None:
    """The two arms of a third-order section add to round-off, on which no mass stands."""
    engine = ReferenceEngine(load_mechanism(models / "composite_fourbar.toml"), 4, "reddy")
    linkage = DrivenLinkage(engine, DRIVE, stretches=True)
    for name, link in zip(engine.topology.link_names, linkage.links, strict=True):
        engines_own = engine.links[engine.topology.index(name)].size
        more = len(linkage.unreduced[engine.topology.index(name)].mass) - engines_own
        assert (more > 0) == (name == "coupler")
        assert np.linalg.eigvalsh(whole(link.mass))[0] > 0


def test_a_heavy_side_runs_as_a_chain_of_bodies() -> None:
    """They come together with the square of the mesh; straight arms left 1.1e-2 on any."""

    def told_apart(elements: int, *, of_bodies: bool) -> FloatArray:
        strips = (heavy_strip(axis, elements, of_bodies=of_bodies) for axis in (OFF, -OFF))
        above, below = (ran(ReferenceEngine(strip, elements, "timoshenko")) for strip in strips)
        return (above - below) / np.abs(above).max()

    gaps = [
        np.abs(told_apart(n, of_bodies=True) - told_apart(n, of_bodies=False)).max()
        for n in (8, 16)
    ]
    assert gaps[1] < 1e-3
    assert gaps[1] < 0.4 * gaps[0]


def test_few_shapes_lift_an_eccentric_link(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a linkage that is off its pins as a whole: five polynomials are 3e-6 off, three 4e-5."""
    sections = {name: strip(OFF, OFF) for name in ("crank", "coupler", "rocker")}
    linkage = Mechanism(FourBar(0.35, 0.12, 0.3, 0.25), sections, gravity=(0.0, -9.81))
    engine, found = ReferenceEngine(linkage, 12), []
    for shapes in (turning_sections.SMOOTH_SHAPES, 12):
        monkeypatch.setattr(turning_sections, "SMOOTH_SHAPES", shapes)
        found.append(ran(engine, 1500))
    peak = np.abs(found[1]).max(axis=0)
    assert np.all(np.abs(found[0] - found[1]).max(axis=0) < 1e-5 * peak)
