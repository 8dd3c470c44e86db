"""Meshes and tolerances of water in links: each test fails if its constant is another one."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.hygrothermal import link_moisture
from flexmech.hygrothermal.link_moisture import LinkDiffusion
from flexmech.materials.moisture import Ambient, DiffusionLayer, Diffusivity, diffuse
from flexmech.materials.moisture.slab import early_uptake
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from tests.analytical.slab_series import slab_profile

THICKNESS, DIFFUSIVITY = 6e-3, 6e-13
# A Fourier number of one, by the whole thickness, in s.
UNIT = THICKNESS**2 / DIFFUSIVITY
SLAB = DiffusionLayer(THICKNESS, Diffusivity(DIFFUSIVITY), 60.0)
WET = Ambient.constant(1.0, 300.0)


def link(layers, faces="both"):
    return LinkDiffusion(layers, (0.07,) * len(layers), 1.0, faces, None)


def profile_error(fourier):
    """Greatest error of the saturation through a link with both faces wet."""
    times = UNIT * np.array([0.0, fourier])
    history = link((SLAB,)).history(WET, times)
    exact = slab_profile(history.place, times[1:], THICKNESS, DIFFUSIVITY)
    return np.abs(history.saturation[1:] - exact).max()


def test_water_in_a_link_is_computed_to_a_hundred_thousandth_of_the_saturation():
    """Where the profile is steep its cells decide; as many as three times fewer would show."""
    assert 3e-6 < profile_error(0.03) < 3e-5


def test_a_link_that_is_nearly_saturated_is_exact_to_the_tolerance_in_time():
    """There the profile is flat, and the cells have no error of their own."""
    assert 1e-7 < profile_error(1.0) < 1e-6


def test_slices_of_a_link_keep_the_moment_of_its_water_to_a_thousandth():
    """The moment of the moisture bends a link with one wet face; the slices keep its mean."""
    own = link((SLAB,), "upper")
    history = own.history(WET, UNIT * np.array([0.0, 0.05]))
    moisture = np.array(own.sliced(history, 1)[0]) / 0.07
    faces = THICKNESS * np.linspace(-0.5, 0.5, len(moisture) + 1)
    moment, exact = (
        values @ np.diff(ends**2)
        for values, ends in ((moisture, faces), (history.saturation[1], history.boundaries))
    )
    assert moisture.mean() == pytest.approx(history.uptake[1], rel=1e-9)
    assert 4e-4 < 1 - moment / exact < 4e-3


def test_links_of_many_layers_have_cells_enough_for_each(monkeypatch):
    """The mean moisture of each of forty layers is good to a ten thousandth."""
    fast = DiffusionLayer(1e-4, Diffusivity(DIFFUSIVITY), 60.0)
    slow = DiffusionLayer(1e-4, Diffusivity(DIFFUSIVITY / 4), 20.0)
    own = link((fast, slow) * 20)
    times = 4e-3**2 / DIFFUSIVITY * np.array([0.0, 0.003])

    def layer_means():
        return np.array(own.sliced(own.history(WET, times), 1)) / 0.07

    usual = layer_means()
    monkeypatch.setattr(link_moisture, "CELLS", 4800)
    assert 3e-5 < np.abs(usual - layer_means()).max() < 2e-4


def test_a_slight_uptake_is_followed_to_less_than_the_tolerance_of_all():
    """In air of 1 % humidity the cells at the faces still hold the difference of two fluxes."""
    air, times = Ambient.constant(0.01, 300.0), UNIT * np.array([0.0, 0.001, 0.01, 0.1, 1.0, 5.0])
    usual, exact = (
        diffuse([SLAB], air, times, cells=200, tolerance=tolerance).saturation
        for tolerance in (1e-5, 1e-10)
    )
    assert 0.015e-5 < np.abs(usual - exact).max() < 0.3e-5


def test_the_first_instant_of_uptake_needs_no_division_by_zero():
    """What stands for a root of zero is small to any time, and its inverse has a square."""
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        assert early_uptake(np.zeros(1))[0] == 0.0
        for fourier in (1e-180, 1e-30, 1e-10):
            expected = 2 * np.sqrt(fourier / np.pi)
            found = early_uptake(np.array([fourier]))[0]
            assert found == pytest.approx(expected, rel=1e-14, abs=0)


def resin_strip(keys):
    section = """
section = "rectangle"
material = "resin"
in_plane_thickness = "6 mm"
out_of_plane_width = "10 mm"
"""
    links = "".join(f"[links.{name}]{section}" for name in ("crank", "coupler", "rocker"))
    return mechanism_from_toml(f"""
name = "test linkage"
source = "invented"
[linkage]
kind = "four-bar"
ground = "200 mm"
crank = "100 mm"
coupler = "160 mm"
rocker = "160 mm"
[materials.resin]
youngs_modulus = "3.9 GPa"
density = "1280 kg/m^3"
poisson_ratio = 0.37
moisture_expansion = "3.02e-3 1/percent"
equilibrium_moisture = "7 percent"
diffusivity = "6e-13 m^2/s"
activation_energy = "45 kJ/mol"
{keys}
{links}
""")


def test_diffusivities_without_a_temperature_are_those_of_a_room():
    """Twenty degrees Celsius, as that of the linkage is where a model states none."""
    by_default, stated = resin_strip(""), resin_strip('diffusivity_temperature = "20 degC"')
    assert isinstance(by_default, Mechanism)
    assert by_default.reference_temperature == pytest.approx(273.15 + 20, rel=1e-12)
    for mechanism in (by_default, stated):
        (layer,) = link_moisture.link_diffusion(mechanism, "coupler").layers
        assert layer.diffusivity.at(293.15) / 6e-13 == pytest.approx(1.0, rel=1e-12)
