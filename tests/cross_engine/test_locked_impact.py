"""Exudyn's nonlinear transient at a locked crank against the exact answer to a pulse."""

from __future__ import annotations

import numpy as np
import pytest

import flexmech
from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.dynamical_systems import HalfSinePulse, pulse_response, state_modes
from flexmech.linear_system import LinkPoint, displacement_row, point_rows
from flexmech.linkages import LockedCrank
from flexmech.time_domain import Impact, LinkState

ANGLE = np.radians(96.9)


@pytest.mark.parametrize(
    ("model", "link", "direction"),
    [
        ("aluminium_fourbar", "coupler", "transverse"),
        ("aluminium_fourbar", "crank", "axial"),
        ("composite_fourbar", "coupler", "transverse"),  # eccentric: forces on the pins' axis
        ("composite_fourbar", "crank", "transverse"),
    ],
)
def test_the_transient_converges_to_the_exact_one(model, link, direction):
    """At points that are no nodes; the trapezoidal rule's error falls with the square."""
    engine = flexmech.ExudynEngine(flexmech.load_mechanism(flexmech.example_model(model)), 4)
    if model.startswith("aluminium"):
        engine = with_damping_ratio(engine, 0.01)  # undamped fast modes would ring along
    system = engine.unreduced().linear_system(ANGLE, prestress="none")
    modes = state_modes(system.mass[0], system.damping[0], system.stiffness[0])
    hit = point_rows(system, LinkPoint(link, 0.4), direction)
    seen = point_rows(system, LinkPoint("rocker", 0.3), "transverse")
    residues = modes.residues(seen, hit)[:, :, 0]
    pulse = HalfSinePulse(1.0, 1 / 250, start=1 / 500)
    if model.startswith("composite"):
        pulse = HalfSinePulse(1.0, 1 / 4000, start=1 / 8000)
    time = np.linspace(0.0, 10 * pulse.duration, 401)
    exact = pulse_response(modes.poles, residues, pulse, time)[:, 0]
    # A link that bends draws its end along by the square of that: so small it does not count.
    force = 1e-8 / np.abs(exact).max()
    gap = []
    for step in (time[1], time[1] / 2):
        impact = Impact(
            LinkPoint(link, 0.4), direction, HalfSinePulse(force, pulse.duration, pulse.start)
        )
        start = LinkState.rigid(engine.links)
        run = engine.simulate(LockedCrank(ANGLE), start, time, step, impacts=[impact])
        moved = run.displacement[2] @ displacement_row(engine.links[2], 0.3, "transverse")
        gap.append(np.abs(moved / force - exact).max() / np.abs(exact).max())
    assert gap[0] < 0.03
    assert gap[0] / gap[1] == pytest.approx(4.0, rel=0.15)
    assert np.isnan(run.energy_error)
