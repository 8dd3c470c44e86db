"""Internal forces and margins of elastic links: both engines, and against rigid links."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses.strength.compute import strength
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.errors import InputError
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.modelfile import load_mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection

MODELS = Path(__file__).parents[2] / "models"
FORCES = ("axial_force", "bending_moment", "shear_force")


def aluminium() -> Mechanism:
    """The paper's four-bar, of a material whose yield strength is stated."""
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    material = Material(68.9e9, 2923.0, 0.3, yield_strength=240e6)
    sections = {
        name: BeamSection.rectangle(material, own.in_plane_thickness, 25.4e-3)
        for name, own in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def largest_gaps(first: xr.DataArray, second: xr.DataArray) -> np.ndarray:
    """Of each link, over its greatest value."""
    one, other = (each.transpose("link", ...).values for each in (first, second))
    gaps = np.abs(one - other).max(axis=(1, 2))
    return np.asarray(gaps / np.abs(one).max(axis=(1, 2)))


def test_both_engines_at_the_periodic_motion() -> None:
    """One by linear equations in link frames, one by simulation in absolute coordinates."""
    mechanism = aluminium()
    engines = [ReferenceEngine(mechanism, 8), ExudynEngine(mechanism, 8)]
    found = strength(
        engines, StrengthRequest(crank_speed=15.0, source="periodic", search_speed=False)
    ).dataset
    assert found["engine"].values.tolist() == ["reference", "exudyn"]
    for name in FORCES:
        assert largest_gaps(*found[name]).max() < 1e-3
    reference, exudyn = found["load_factor"].min(["station", "layer", "surface"])
    np.testing.assert_allclose(exudyn, reference, rtol=1e-3)


@pytest.mark.parametrize(("speed", "gap"), [(5.0, 6e-3), (10.0, 2.4e-2)])
def test_slow_links_bear_what_rigid_ones_do(speed: float, gap: float) -> None:
    """Vibration adds in proportion to the square of the speed: four times at twice the speed."""
    mechanism = aluminium()
    rigid = strength(mechanism, StrengthRequest(crank_speed=speed)).dataset
    request = StrengthRequest(crank_speed=speed, source="periodic", search_speed=False)
    running = strength(mechanism, request).dataset
    at_angles = running.interp(crank_angle=rigid["crank_angle"].values)
    for name in FORCES:
        gaps = largest_gaps(rigid[name][0], at_angles[name][0])
        assert gaps.max() < gap
    factors = (each["margin_load_factor"].values.min() for each in (rigid, running))
    assert next(factors) == pytest.approx(next(factors), rel=gap)


def test_a_run_from_straight_links_is_worse() -> None:
    """A start that is not the motion's own lets links ring beyond it."""
    mechanism = aluminium()
    request = StrengthRequest(
        crank_speed=15.0, source="periodic", revolutions=0.25, search_speed=False
    )
    steady = strength(mechanism, request).dataset
    rung = strength(mechanism, replace(request, source="transient")).dataset
    assert rung["margin_load_factor"].values[0] < 0.8 * steady["margin_load_factor"].values[0]
    assert np.isnan(rung["margin_speed_factor"]).all()


def test_no_revolution_is_refused() -> None:
    with pytest.raises(InputError, match="revolutions"):
        StrengthRequest(revolutions=0.0)
    with pytest.raises(InputError, match="source"):
        StrengthRequest(source="static")  # type: ignore[arg-type]


@pytest.mark.thorough
def test_speed_is_searched_through_a_resonance() -> None:
    """Undamped links break near a resonance, long before inertia alone would break them."""
    found = strength(aluminium(), StrengthRequest(crank_speed=52.0, source="periodic"))
    data = found.dataset
    by_inertia = float(np.sqrt(data["margin_load_factor"][0]))
    factors = data["margin_speed_factor"].values
    assert 1 < np.nanmin(factors) < 0.9 * by_inertia
    beyond = data["searched_speed_factor"] >= np.nanmin(factors)
    assert np.all(data["searched_load_factor"][~beyond] > 1)
    assert any("runs by speed" in line for line in found.summary().lines)
