"""Diffusion of water in layers and bars against series, a Laplace inversion, and what always holds.

Crank, *The Mathematics of Diffusion*; Shen & Springer 1976; Carslaw & Jaeger, *Conduction of Heat
in Solids*. Fourier numbers are by the thickness: the unit of time is ``h^2 / D``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech import InputError
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
from tests.support.slab_series import bar_profile, bar_uptake, slab_profile, slab_uptake
from tests.support.strategies import numbers

few = settings(max_examples=8)
THICKNESS, DIFFUSIVITY = 2e-3, 1e-12
WIDTH, ACROSS = 6e-3, 4e-12
SIZES = (THICKNESS, WIDTH, DIFFUSIVITY, ACROSS)
UNIT = THICKNESS**2 / DIFFUSIVITY
SLAB = DiffusionLayer(THICKNESS, Diffusivity(DIFFUSIVITY), 60.0)
WATER = Ambient.constant(1.0, 293.15)


@pytest.mark.parametrize("faces", ["both", "lower"])
def test_a_slab_against_the_series(faces):
    """Within 1e-6 from 0.01 h^2/D after the step on; before, the first cells are too few.

    The uptake is within 1e-6 from the start on.
    """
    times = np.array([1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0]) * UNIT
    history = diffuse([SLAB], WATER, times, faces=faces)
    exact = slab_profile(history.place, times, *SIZES[::2], faces=faces)
    error = np.abs(history.saturation - exact).max(axis=1)
    assert error[2:].max() < 1e-6
    assert error[1] < 1.5e-6
    assert error[0] < 1e-5
    uptake = slab_uptake(times, *SIZES[::2], faces=faces)
    np.testing.assert_allclose(history.uptake, uptake, atol=1e-6)
    assert history.mass_balance_error < 1e-12


@pytest.mark.parametrize("faces", ["both", "lower"])
def test_cells_converge_by_their_square(faces):
    times = np.array([0.02, 0.2]) * UNIT

    def error(cells: int) -> float:
        history = diffuse([SLAB], WATER, times, faces=faces, cells=cells)
        exact = slab_profile(history.place, times, *SIZES[::2], faces=faces)
        return float(np.abs(history.saturation - exact).max())

    errors = np.array([error(cells) for cells in (25, 50, 100)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 2.0, atol=0.1)


def test_steps_converge_with_the_tolerance():
    """The error is of the size of the tolerance."""
    times = np.array([0.01, 0.1, 0.5]) * UNIT

    def profile(tolerance: float) -> np.ndarray:
        return diffuse([SLAB], WATER, times, cells=60, tolerance=tolerance).saturation

    best = profile(1e-9)
    for tolerance in (1e-4, 1e-5, 1e-6):
        error = np.abs(profile(tolerance) - best).max()
        assert 0.01 * tolerance < error < 10 * tolerance


def test_a_humidity_that_jumps_at_a_repeated_time():
    jump, time = 0.05 * UNIT, 0.12 * UNIT
    ambient = Ambient([0.0, jump, jump], [1.0, 1.0, 0.25], [293.15] * 3)
    history = diffuse([SLAB], ambient, [jump, time], cells=800)
    steps = slab_uptake([jump, time, time - jump], *SIZES[::2])
    expected = [steps[0], steps[1] - 0.75 * steps[2]]
    np.testing.assert_allclose(history.uptake, expected, atol=3e-6)


def test_changing_temperature_is_a_clock_that_runs_faster():
    """With one diffusivity the time is ``integral D dt / D_0`` (Weitsman 1976)."""
    warm = Diffusivity(DIFFUSIVITY, 300.0, 50e3)
    end, time = 0.02 * UNIT, 0.03 * UNIT
    ambient = Ambient([0.0, end], [1.0, 1.0], [290.0, 350.0])
    layer = DiffusionLayer(THICKNESS, warm, 60.0)
    history = diffuse([layer], ambient, [time], cells=800)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    ramp = weights @ warm.at(320.0 + 30.0 * nodes) / 2 * end
    clock = (ramp + warm.at(350.0) * (time - end)) / DIFFUSIVITY
    exact = slab_profile(history.place, [clock], *SIZES[::2])
    np.testing.assert_allclose(history.saturation, exact, atol=3e-6)
    assert history.mass_balance_error < 1e-12


def talbot(transform: Callable[[complex], np.ndarray], time: float) -> np.ndarray:
    """Inverse Laplace transform by Talbot's contour, with the constants of Weideman (2006)."""
    count = 28
    total = 0.0
    for angle in (2 * np.arange(count // 2) + 1) * np.pi / count:
        sine, cosine = np.sin(0.6407 * angle), np.cos(0.6407 * angle)
        z = count * (0.5017 * angle * cosine / sine - 0.6122 + 0.2645j * angle)
        slope = 0.5017 * cosine / sine - 0.5017 * 0.6407 * angle / sine**2 + 0.2645j
        total = total + (np.exp(z) * transform(z / time) * slope).imag
    return np.asarray(2 * total / time)


def two_layers(
    place: np.ndarray, p: complex, layers: tuple[DiffusionLayer, DiffusionLayer], sealed: bool
) -> np.ndarray:
    """Transformed saturation of two dry layers whose upper face, and lower if not sealed, is wet.

    ``place`` runs from the interface. In each layer the saturation is a sum of the hyperbolic
    functions that solve ``p s = D s''``; saturation and flow go on across the interface.
    """
    lower, upper = layers
    k = [np.sqrt(p / layer.diffusivity.value) for layer in layers]
    flow = [
        layer.capacity * layer.diffusivity.value * q for layer, q in zip(layers, k, strict=True)
    ]
    a, b = k[0] * lower.thickness, k[1] * upper.thickness
    # s = m cosh(k y) + n sinh(k y) / flow in both, so that both conditions at y = 0 hold.
    rows = [[np.cosh(a), -np.sinh(a) / flow[0]], [np.cosh(b), np.sinh(b) / flow[1]]]
    ends = [1 / p, 1 / p]
    if sealed:
        rows[0], ends[0] = [-flow[0] * np.sinh(a), np.cosh(a)], 0.0
    m, n = np.linalg.solve(rows, ends)
    which = (place > 0).astype(int)
    wave, stream = np.array(k)[which], np.array(flow)[which]
    return m * np.cosh(wave * place) + n * np.sinh(wave * place) / stream


TWO = (
    DiffusionLayer(0.8e-3, Diffusivity(3e-13), 80.0),
    DiffusionLayer(1.5e-3, Diffusivity(2e-12), 25.0),
)


@pytest.mark.parametrize("faces", ["both", "upper"])
def test_two_layers_against_a_laplace_inversion(faces):
    times = np.array([0.02, 0.1, 0.5, 2.0]) * UNIT
    history = diffuse(TWO, WATER, times, faces=faces)
    interface = history.boundaries[0] + TWO[0].thickness
    for time, saturation in zip(times, history.saturation, strict=True):
        exact = talbot(
            lambda p: two_layers(history.place - interface, p, TWO, faces == "upper"), time
        )
        np.testing.assert_allclose(saturation, exact, atol=3e-6)
    assert history.mass_balance_error < 1e-12


@st.composite
def laminates(draw: st.DrawFn) -> list[DiffusionLayer]:
    return [
        DiffusionLayer(
            draw(numbers(0.1e-3, 2e-3)),
            Diffusivity(10 ** draw(numbers(-14.0, -11.0)), 300.0, draw(numbers(0.0, 6e4))),
            draw(numbers(1.0, 100.0)),
            Diffusivity(10 ** draw(numbers(-14.0, -11.0))),
        )
        for _ in range(draw(st.integers(1, 4)))
    ]


@st.composite
def climates(draw: st.DrawFn) -> Ambient:
    count = draw(st.integers(1, 4))
    gaps = [
        draw(st.sampled_from([0.0, 1e4, 1e6]) if i % 2 else numbers(1e4, 1e6)) for i in range(count)
    ]
    humidity = [draw(numbers(0.0, 1.0)) for _ in range(count)]
    temperature = [draw(numbers(280.0, 360.0)) for _ in range(count)]
    return Ambient(np.cumsum(gaps), humidity, temperature)


@few
@given(laminates(), climates(), numbers(0.0, 1.0), st.sampled_from(["both", "lower", "upper"]))
def test_no_water_is_lost_and_none_goes_uphill(layers, ambient, initial, faces):
    times = np.array([0.0, 1e5, 1e6, 3e6])
    history = diffuse(
        layers, ambient, times, faces=faces, initial=initial, cells=30, tolerance=1e-4
    )
    assert history.mass_balance_error < 1e-12
    humidity = ambient.relative_humidity
    assert history.saturation.min() >= min(initial, humidity.min()) - 1e-3
    assert history.saturation.max() <= max(initial, humidity.max()) + 1e-3


BAR = DiffusionLayer(THICKNESS, Diffusivity(DIFFUSIVITY), 60.0, Diffusivity(ACROSS))


def bar_error(cells: tuple[int, int], faces: str, times: np.ndarray) -> float:
    history = diffuse_bar([BAR], WIDTH, WATER, times, faces=faces, cells=cells)
    assert history.mass_balance_error < 1e-12
    z = (history.across[1:] + history.across[:-1]) / 2
    exact = bar_profile(history.place, z, times, *SIZES, faces=faces)
    np.testing.assert_allclose(
        history.uptake, bar_uptake(times, *SIZES, faces=faces), atol=8 / min(cells) ** 2
    )
    return float(np.abs(history.field - exact).max())


@pytest.mark.parametrize("faces", ["both", "lower"])
def test_a_bar_against_the_product_of_series(faces):
    times = np.array([0.02, 0.1, 0.5]) * UNIT
    errors = [bar_error(cells, faces, times) for cells in ((30, 20), (60, 40))]
    assert errors[1] < 1.6e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


def test_the_middle_of_a_wide_bar_of_layers_is_a_slab():
    layers = [
        DiffusionLayer(layer.thickness, layer.diffusivity, layer.capacity, Diffusivity(1e-12))
        for layer in TWO
    ]
    times = np.array([0.05, 0.3]) * UNIT
    ambient = Ambient([0.0, 1e6], [0.2, 0.9], [293.15, 293.15])
    bar = diffuse_bar(layers, 60e-3, ambient, times, cells=(40, 24), initial=0.4)
    slab = diffuse(layers, ambient, times, cells=40, initial=0.4)
    np.testing.assert_allclose(bar.field[:, :, 11], slab.saturation, atol=5e-6)
    np.testing.assert_allclose(bar.field[:, :, ::-1], bar.field, atol=1e-15)


@few
@given(numbers(1e-3, 1 - 1e-9), st.sampled_from(["both", "lower", "upper"]))
def test_time_to_saturation_is_the_uptake_reversed(fraction, faces):
    time = time_to_saturation(fraction, THICKNESS, DIFFUSIVITY, faces=faces)
    uptake = slab_uptake([time], THICKNESS, DIFFUSIVITY, faces=faces)[0]
    assert uptake == pytest.approx(fraction, rel=1e-12)
    assert 1 - uptake == pytest.approx(1 - fraction, rel=1e-6)


def test_time_to_full_saturation():
    """Shen & Springer 1976 print 0.67 s^2/D for 99.9 percent; the series has 0.6786."""
    assert time_to_saturation(0.999, 1.0, 1.0) == pytest.approx(0.67, rel=0.014)
    slowest_alone = np.log(8 / np.pi**2 / 0.001) / np.pi**2
    assert time_to_saturation(0.999, 1.0, 1.0) == pytest.approx(slowest_alone, rel=1e-12)


@pytest.mark.parametrize("faces", ["both", "lower"])
def test_short_time_law(faces):
    """Below half saturation within 0.1 percent, at a quarter of it exact in 12 digits."""
    times = np.array([time_to_saturation(f, 1.0, 1.0, faces=faces) for f in (0.5, 0.25)])
    law = short_time_uptake(times, 1.0, 1.0, faces=faces)
    exact = slab_uptake(times, 1.0, 1.0, faces=faces)
    error = law / exact - 1
    assert 4e-4 < error[0] < 1e-3
    assert 0 <= error[1] < 1e-8


def test_shen_springer_within_its_known_error():
    """The fit is off by up to 3.6 % of saturation, at D t/s^2 = 0.065 and the other way before.

    Its exponent of 0.75 is not the 0.5 of the first instants, where it misses most of the water.
    """
    fourier = np.geomspace(1e-4, 1.0, 1500)
    error = shen_springer_uptake(fourier, 1.0, 1.0) - slab_uptake(fourier, 1.0, 1.0)
    assert error.max() == pytest.approx(0.03631, abs=1e-5)
    assert fourier[error.argmax()] == pytest.approx(0.0650, abs=5e-4)
    assert error.min() == pytest.approx(-0.03446, abs=1e-5)
    first = shen_springer_uptake([1e-6], 1.0, 1.0) / slab_uptake([1e-6], 1.0, 1.0)
    assert first[0] == pytest.approx(0.10, abs=0.01)


LAYER = DiffusionLayer(2e-3, Diffusivity(1e-12), 60.0, Diffusivity(2e-12))
AIR = Ambient.constant(0.5, 300.0)


def test_diffusivity_by_arrhenius():
    water = Diffusivity(2e-12, 300.0, 50e3)
    assert water.at(300.0) == 2e-12
    expected = 2e-12 * np.exp(50e3 / 8.314462618 * (1 / 300 - 1 / 330))
    np.testing.assert_allclose(water.at([[330.0]]), [[expected]], rtol=1e-9)
    assert np.all(Diffusivity(2e-12).at([250.0, 400.0]) == 2e-12)


def test_diffusivity_of_a_ply():
    """For 60 percent of fibres Shen & Springer's forms give 0.4 and 0.126."""
    along, across = composite_diffusivity_ratio(0.6)
    assert along == pytest.approx(0.4)
    assert across == pytest.approx(0.1260, abs=5e-5)


def test_thin_layers_through_long_histories():
    """Steps after a jump of humidity are shorter than the digits of the time."""
    ambient = Ambient([1e9, 1e9], [1.0, 0.2], [300.0, 300.0])
    foil = DiffusionLayer(1e-6, Diffusivity(1e-12), 50.0)
    result = diffuse([foil], ambient, [1e9, 1e9 + 10.0], cells=50, tolerance=1e-5)
    np.testing.assert_allclose(result.uptake, [1.0, 0.2], atol=1e-4)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Diffusivity(0.0), "value of a diffusivity"),
        (lambda: Diffusivity(1e-12).at(-20.0), "above 0 K"),
        (lambda: MoistureEquilibrium(7.0), "equilibrium_moisture .* got 700 %"),
        (lambda: MoistureEquilibrium(0.07).moisture(50.0), "relative_humidity"),
        (lambda: composite_diffusivity_ratio(0.9), r"below 0\.7854, where the fibres"),
        (lambda: Ambient([1.0, 0.0], [0.5, 0.5], [300, 300]), "ambient times"),
        (lambda: Ambient([0.0], [0.5], [-20.0]), "above 0 K"),
        (lambda: short_time_uptake([1.0], 2e-3, 1e-12, faces="top"), "faces must be one of both"),
        (lambda: time_to_saturation(1.0, 2e-3, 1e-12), "takes for ever"),
        (lambda: DiffusionLayer(2e-3, Diffusivity(1e-12), 0.0), "capacity of a layer"),
        (lambda: diffuse([], AIR, [1.0]), "one layer or more"),
        (lambda: diffuse([LAYER], AIR, [2.0, 1.0]), "times must rise from zero"),
        (lambda: diffuse([LAYER], AIR, [1.0], initial=1.5), "initial saturation"),
        (lambda: diffuse([LAYER], AIR, [1.0], cells=3), "need 4 cells or more"),
        (lambda: diffuse_bar([SLAB], 5e-3, AIR, [1.0]), "diffusivity_across of each"),
        (lambda: diffuse_bar([LAYER], 5e-3, AIR, [1.0], cells=(20, 7)), "must be even"),
    ],
)
def test_what_cannot_diffuse_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
