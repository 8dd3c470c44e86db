"""Diffusivity, ambient conditions and meshes; what diffusion refuses and how it says so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech.errors import ComputationError, InputError
from flexmech.materials.moisture import (
    Ambient,
    DiffusionLayer,
    Diffusivity,
    MoistureEquilibrium,
    composite_diffusivity_ratio,
    diffuse,
    diffuse_bar,
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation,
)
from flexmech.materials.moisture.cells import graded, layer_mesh
from flexmech.materials.moisture.history import Period

LAYER = DiffusionLayer(2e-3, Diffusivity(1e-12), 60.0, Diffusivity(2e-12))
AIR = Ambient.constant(0.5, 300.0)


# ---- materials -------------------------------------------------------------------------------


def test_diffusivity_by_arrhenius():
    water = Diffusivity(2e-12, 300.0, 50e3)
    assert water.at(300.0) == 2e-12
    expected = 2e-12 * np.exp(50e3 / 8.314462618 * (1 / 300 - 1 / 330))
    np.testing.assert_allclose(water.at([[330.0]]), [[expected]], rtol=1e-9)
    assert np.all(Diffusivity(2e-12).at([250.0, 400.0]) == 2e-12)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ((0.0,), "value of a diffusivity must be positive, got 0.0 m"),
        ((np.inf,), "value of a diffusivity"),
        ((np.nan,), "value of a diffusivity"),
        ((1e-12, 0.0), "reference_temperature of a diffusivity"),
        ((1e-12, 300.0, -1.0), "activation_energy of a diffusivity"),
        ((1e-12, 300.0, np.nan), "activation_energy of a diffusivity"),
    ],
)
def test_a_diffusivity_that_is_none(values, said):
    with pytest.raises(InputError, match=said):
        Diffusivity(*values)


@pytest.mark.parametrize("temperature", [0.0, -20.0, np.nan, [300.0, np.inf]])
def test_no_diffusivity_without_a_temperature(temperature):
    with pytest.raises(InputError, match="must be above 0 K"):
        Diffusivity(1e-12).at(temperature)


def test_moisture_in_equilibrium():
    resin = MoistureEquilibrium(0.07, 2.0)
    np.testing.assert_allclose(resin.moisture([0.0, 0.5, 1.0]), [0.0, 0.0175, 0.07])
    assert MoistureEquilibrium(0.02).moisture(0.5) == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ((0.0,), "equilibrium_moisture must lie between 0 and 100 %, got 0 %"),
        ((7.0,), "got 700 %"),
        ((np.nan,), "equilibrium_moisture"),
        ((0.07, 0.0), "humidity_exponent must be positive"),
        ((0.07, np.inf), "humidity_exponent"),
    ],
)
def test_an_equilibrium_that_is_none(values, said):
    with pytest.raises(InputError, match=said):
        MoistureEquilibrium(*values)


@pytest.mark.parametrize("humidity", [-0.01, 1.01, 50.0, np.nan, [0.5, 2.0]])
def test_humidity_is_a_fraction(humidity):
    with pytest.raises(InputError, match="relative_humidity must lie between 0 and 1"):
        MoistureEquilibrium(0.07).moisture(humidity)


def test_diffusivity_of_a_ply():
    """For 60 percent of fibres Shen & Springer's forms give 0.4 and 0.126."""
    along, across = composite_diffusivity_ratio(0.6)
    assert along == pytest.approx(0.4)
    assert across == pytest.approx(0.1260, abs=5e-5)


@pytest.mark.parametrize("fraction", [0.0, np.pi / 4, 0.9, -0.1, np.nan])
def test_fibres_that_touch_let_no_water_through(fraction):
    with pytest.raises(InputError, match=r"below 0\.7854, where the fibres"):
        composite_diffusivity_ratio(fraction)


# ---- ambient conditions ----------------------------------------------------------------------

STEPPED = Ambient([10.0, 20.0, 20.0, 40.0], [0.2, 0.6, 0.9, 0.1], [290, 300, 320, 320])


def test_ambient_conditions_run_straight_and_stay():
    humidity, temperature = STEPPED.at([0.0, 10.0, 15.0, 20.0, 30.0, 40.0, 99.0])
    np.testing.assert_allclose(humidity, [0.2, 0.2, 0.4, 0.9, 0.5, 0.1, 0.1])
    np.testing.assert_allclose(temperature, [290, 290, 295, 320, 320, 320, 320])


def test_periods_stop_at_corners_and_before_steps():
    before, rising, falling, after = STEPPED.periods(0.0, 50.0)
    assert before == Period(0.0, 10.0, (0.2, 0.2), (290.0, 290.0))
    assert rising == Period(10.0, 20.0, (0.2, 0.6), (290.0, 300.0))
    assert falling == Period(20.0, 40.0, (0.9, 0.1), (320.0, 320.0))
    assert after == Period(40.0, 50.0, (0.1, 0.1), (320.0, 320.0))
    assert rising.at(15.0) == pytest.approx((0.4, 295.0))


def test_periods_cut_anywhere():
    (part,) = STEPPED.periods(25.0, 30.0)
    assert part.relative_humidity == pytest.approx((0.7, 0.5))
    (up_to,) = STEPPED.periods(15.0, 20.0)
    assert up_to.relative_humidity == pytest.approx((0.4, 0.6))
    (onward,) = STEPPED.periods(20.0, 30.0)
    assert onward.relative_humidity == pytest.approx((0.9, 0.5))
    assert STEPPED.periods(5.0, 5.0) == ()
    (constant,) = AIR.periods(0.0, 7.0)
    assert constant == Period(0.0, 7.0, (0.5, 0.5), (300.0, 300.0))


def test_ambient_conditions_keep_rows_of_their_own():
    time = np.array([0.0, 1.0])
    ambient = Ambient(time, np.array([0.1, 0.2]), np.array([300.0, 300.0]))
    time[0] = 5.0
    assert ambient.time[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        ambient.time[0] = 5.0


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (([], [], []), "as many humidities"),
        (([0.0, 1.0], [0.5], [300.0, 300.0]), r"shapes \(2,\), \(1,\) and \(2,\)"),
        (([[0.0]], [[0.5]], [[300.0]]), "as many humidities"),
        (([1.0, 0.0], [0.5, 0.5], [300, 300]), "ambient times must be numbers"),
        (([0.0, np.nan], [0.5, 0.5], [300, 300]), "ambient times must be numbers"),
        (([1.0] * 3, [0.5] * 3, [300] * 3), "more than twice"),
        (([0.0], [50.0], [300.0]), "relative_humidity must lie between 0 and 1"),
        (([0.0], [np.nan], [300.0]), "relative_humidity"),
        (([0.0], [0.5], [-20.0]), "above 0 K"),
    ],
)
def test_ambient_conditions_that_are_none(rows, said):
    with pytest.raises(InputError, match=said):
        Ambient(*rows)


# ---- series ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: shen_springer_uptake([-1.0], 2e-3, 1e-12), "times must be a row"),
        (lambda: short_time_uptake([np.inf], 2e-3, 1e-12), "times must be a row"),
        (lambda: short_time_uptake([[1.0]], 2e-3, 1e-12), "times must be a row"),
        (lambda: short_time_uptake([1.0], 0.0, 1e-12), "thickness must be positive, got 0.0 m"),
        (lambda: short_time_uptake([1.0], 2e-3, -1e-12), "diffusivity must be positive"),
        (lambda: short_time_uptake([1.0], 2e-3, 1e-12, faces="top"), "faces must be one of both"),
        (lambda: short_time_uptake([1.0], np.nan, 1e-12), "thickness must be positive"),
        (lambda: time_to_saturation(1.0, 2e-3, 1e-12), "takes for ever"),
        (lambda: time_to_saturation(0.0, 2e-3, 1e-12), "fraction of saturation"),
    ],
)
def test_series_of_nothing(call, said):
    with pytest.raises(InputError, match=said):
        call()


# ---- meshes and numbers ----------------------------------------------------------------------


@pytest.mark.parametrize("fine", [(True, True), (True, False), (False, True), (False, False)])
def test_cells_are_small_where_they_should_be(fine):
    boundaries = graded(30, fine)
    sizes = np.diff(boundaries)
    assert (boundaries[0], boundaries[-1]) == (0.0, 1.0)
    assert np.all(sizes > 0)
    assert (sizes[0] < 0.2 * sizes.max()) == fine[0]
    assert (sizes[-1] < 0.2 * sizes.max()) == fine[1]
    assert np.all(sizes[1:] / sizes[:-1] < 1.35)


def test_a_mesh_of_layers():
    other = replace(LAYER, diffusivity=Diffusivity(1e-14), thickness=1e-3)
    mesh = layer_mesh([LAYER, LAYER, other], "lower", 60)
    assert len(mesh.materials) == 2
    assert mesh.sizes.size == 60
    assert mesh.boundaries[[0, -1]] == pytest.approx([-2.5e-3, 2.5e-3])
    assert np.abs(mesh.boundaries - 1.5e-3).min() < 1e-15
    assert mesh.capacity.sum() == pytest.approx(5e-3 * 60.0)
    # Slow layers get the finer cells; the sealed upper face gets none.
    assert np.sum(mesh.material == 1) > 40
    assert mesh.sizes[-1] == mesh.sizes[mesh.material == 1].max()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"thickness": 0.0}, "thickness of a layer that takes up water"),
        ({"capacity": 0.0}, "capacity of a layer that takes up water must be positive"),
        ({"capacity": np.nan}, "capacity of a layer"),
    ],
)
def test_a_layer_that_is_none(change, said):
    with pytest.raises(InputError, match=said):
        replace(LAYER, **change)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"layers": []}, "one layer or more"),
        ({"times": []}, "one or more"),
        ({"times": [[1.0]]}, "times must be a row"),
        ({"times": [-1.0]}, "times must rise from zero"),
        ({"times": [2.0, 1.0]}, "times must rise from zero"),
        ({"times": [np.nan]}, "times must be a row"),
        ({"faces": "none"}, "faces must be one of"),
        ({"initial": 1.5}, "initial saturation must lie between 0 and 1"),
        ({"initial": np.nan}, "initial saturation"),
        ({"humidity_exponent": 0.0}, "humidity_exponent must be positive"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"cells": 3}, "1 different layers need 4 cells or more, got 3"),
    ],
)
def test_diffusion_of_nothing(change, said):
    arguments: dict[str, Any] = {"layers": [LAYER], "ambient": AIR, "times": [1.0]}
    with pytest.raises(InputError, match=said):
        diffuse(**(arguments | change))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"width": 0.0}, "width must be positive"),
        ({"layers": [replace(LAYER, diffusivity_across=None)]}, "diffusivity_across of each"),
        ({"cells": (20, 7)}, "must be even"),
        ({"cells": (20, 2)}, "must be even"),
        ({"initial": -0.1}, "initial saturation"),
    ],
)
def test_bars_of_nothing(change, said):
    arguments: dict[str, Any] = {
        "layers": [LAYER],
        "width": 5e-3,
        "ambient": AIR,
        "times": [1.0],
    }
    with pytest.raises(InputError, match=said):
        diffuse_bar(**(arguments | change))


def test_numbers_that_overflow_are_named():
    layer = DiffusionLayer(1e-3, Diffusivity(1e300), 1e200)
    with pytest.raises(ComputationError, match="check the"), np.errstate(all="ignore"):
        diffuse([layer], AIR, [1.0], cells=10)


def test_times_that_repeat_and_a_part_that_is_at_rest():
    result = diffuse([LAYER], AIR, [0.0, 0.0, 5.0, 5.0], initial=0.5, cells=20)
    assert result.saturation.shape == (4, 20)
    assert np.all(result.saturation == 0.5)
    assert np.all(result.influx == 0)


def test_thin_layers_through_long_histories():
    """Steps after a jump of humidity are shorter than the digits of the time."""
    ambient = Ambient([1e9, 1e9], [1.0, 0.2], [300.0, 300.0])
    foil = DiffusionLayer(1e-6, Diffusivity(1e-12), 50.0)
    result = diffuse([foil], ambient, [1e9, 1e9 + 10.0], cells=50, tolerance=1e-5)
    np.testing.assert_allclose(result.uptake, [1.0, 0.2], atol=1e-4)
