"""The numerical diffusion against series, a Laplace inversion, and what holds for any layers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flexmech.materials.moisture import Ambient, DiffusionLayer, Diffusivity, diffuse, diffuse_bar
from flexmech.materials.moisture.cells import side_waves
from tests.analytical.slab_series import bar_profile, bar_uptake, slab_profile, slab_uptake
from tests.support.strategies import numbers

few = settings(max_examples=8)
every_face = pytest.mark.parametrize("faces", ["both", "lower", "upper"])

THICKNESS, DIFFUSIVITY = 2e-3, 1e-12
UNIT = THICKNESS**2 / DIFFUSIVITY
SLAB = DiffusionLayer(THICKNESS, Diffusivity(DIFFUSIVITY), 60.0)
WATER = Ambient.constant(1.0, 293.15)


# ---- the method itself -----------------------------------------------------------------------


def test_waves_are_those_of_a_slab():
    """Rates ``((2 n + 1) pi / w)^2``, and means of the cosines."""
    half = 3e-3
    waves = side_waves(half * np.linspace(0, 1, 401))
    order = np.argsort(waves.rate)[:4]
    wave_number = (2 * np.arange(4) + 1) * np.pi / (2 * half)
    np.testing.assert_allclose(waves.rate[order], wave_number**2, rtol=1e-4)
    np.testing.assert_allclose(waves.mean[order] ** 2, 2 / (wave_number * half) ** 2, rtol=1e-4)


# ---- one layer -------------------------------------------------------------------------------


@every_face
def test_a_slab_against_the_series(faces):
    """Within 1e-6 from 0.01 h^2/D after the step on; before, the first cells are too few.

    The uptake is within 1e-6 from the start on.
    """
    times = np.array([1e-4, 1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 10.0]) * UNIT
    history = diffuse([SLAB], WATER, times, faces=faces)
    exact = slab_profile(history.place, times, THICKNESS, DIFFUSIVITY, faces=faces)
    error = np.abs(history.saturation - exact).max(axis=1)
    assert error[2:].max() < 1e-6
    assert error[1] < 1.5e-6
    assert error[0] < 1e-5
    uptake = slab_uptake(times, THICKNESS, DIFFUSIVITY, faces=faces)
    np.testing.assert_allclose(history.uptake, uptake, atol=1e-6)
    assert history.mass_balance_error < 1e-12


def test_drying_and_the_amount_of_water():
    times = np.array([0.0, 0.02, 0.2, 50.0]) * UNIT
    dry = Ambient.constant(0.2, 293.15)
    history = diffuse([SLAB], dry, times, initial=0.9, cells=800)
    exact = slab_profile(history.place, times, THICKNESS, DIFFUSIVITY, initial=0.9, surface=0.2)
    np.testing.assert_allclose(history.saturation[1:], exact[1:], atol=3e-6)
    assert np.all(history.saturation[0] == 0.9)
    water = 60.0 * THICKNESS * np.array([0.9, 0.2])
    np.testing.assert_allclose(history.water[[0, -1]], water, rtol=1e-10)
    assert history.influx[-1] == pytest.approx(water[1] - water[0], rel=1e-10)


@every_face
def test_cells_converge_by_their_square(faces):
    times = np.array([0.02, 0.2]) * UNIT

    def error(cells: int) -> float:
        history = diffuse([SLAB], WATER, times, faces=faces, cells=cells)
        exact = slab_profile(history.place, times, THICKNESS, DIFFUSIVITY, faces=faces)
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


# ---- changing ambient conditions -------------------------------------------------------------


def periodic_triangle(place: np.ndarray, time: float, period: float) -> np.ndarray:
    """Settled saturation under a humidity that rises 0 to 1 and falls again in each period.

    Each harmonic has the profile ``cosh(k y)/cosh(k h/2)`` with ``k^2 = i omega/D`` (Carslaw &
    Jaeger, *Conduction of Heat in Solids*, section 3.6).
    """
    n = np.arange(1, 40001, 2)[:, None]
    k = np.sqrt(2j * np.pi * n / period / DIFFUSIVITY)
    # The quotient of the two without overflow.
    wave = np.exp(k * (np.abs(place) - THICKNESS / 2)) * (1 + np.exp(-2 * k * np.abs(place)))
    wave = wave / (1 + np.exp(-k * THICKNESS))
    turned = np.exp(2j * np.pi * n * time / period) * wave
    return 0.5 - np.sum(4 / (np.pi * n) ** 2 * turned.real, axis=0)


def test_cycles_of_humidity_settle_into_the_periodic_solution():
    period, cycles = 0.25 * UNIT, 6
    corners = np.arange(2 * cycles + 3) * period / 2
    humidity = np.arange(2 * cycles + 3) % 2
    ambient = Ambient(corners, humidity, np.full(corners.size, 293.15))
    shares = np.array([0.0, 0.3, 0.5])
    times = (cycles + shares) * period
    history = diffuse([SLAB], ambient, times, initial=0.5, cells=300, tolerance=1e-6)
    some = slice(0, None, 13)
    for share, saturation in zip(shares, history.saturation, strict=True):
        settled = periodic_triangle(history.place[some], share * period, period)
        np.testing.assert_allclose(saturation[some], settled, atol=2e-5)
    assert history.mass_balance_error < 1e-12


def test_rising_humidity_by_superposed_steps():
    """Duhamel's integral of the series, for a saturation that is the square of the humidity."""
    rise, time = 0.1 * UNIT, 0.15 * UNIT
    ambient = Ambient([0.0, rise], [0.0, 0.8], [293.15, 293.15])
    history = diffuse([SLAB], ambient, [time], humidity_exponent=2.0, cells=800)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    moment = rise * (nodes + 1) / 2
    steps = weights * rise / 2 * 2 * 0.8**2 * moment / rise**2
    expected = steps @ slab_uptake(time - moment, THICKNESS, DIFFUSIVITY)
    assert history.uptake[0] == pytest.approx(expected, abs=2e-6)


def test_a_humidity_that_jumps_at_a_repeated_time():
    jump, time = 0.05 * UNIT, 0.12 * UNIT
    ambient = Ambient([0.0, jump, jump], [1.0, 1.0, 0.25], [293.15] * 3)
    history = diffuse([SLAB], ambient, [jump, time], cells=800)
    steps = slab_uptake([jump, time, time - jump], THICKNESS, DIFFUSIVITY)
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
    exact = slab_profile(history.place, [clock], THICKNESS, DIFFUSIVITY)
    np.testing.assert_allclose(history.saturation, exact, atol=3e-6)
    assert history.mass_balance_error < 1e-12


def test_a_step_of_temperature():
    warm = Diffusivity(DIFFUSIVITY, 300.0, 40e3)
    step, time = 0.05 * UNIT, 0.08 * UNIT
    ambient = Ambient([step, step], [1.0, 1.0], [300.0, 330.0])
    history = diffuse([DiffusionLayer(THICKNESS, warm, 60.0)], ambient, [time], cells=800)
    clock = step + (time - step) * warm.at(330.0) / DIFFUSIVITY
    exact = slab_uptake([clock], THICKNESS, DIFFUSIVITY)
    np.testing.assert_allclose(history.uptake, exact, atol=3e-6)


# ---- layers ----------------------------------------------------------------------------------


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


def test_layers_turned_over():
    times = np.array([0.01, 0.2]) * UNIT
    upright = diffuse(TWO, WATER, times, faces="lower", cells=200)
    turned = diffuse(TWO[::-1], WATER, times, faces="upper", cells=200)
    np.testing.assert_allclose(upright.saturation, turned.saturation[:, ::-1], atol=1e-9)


def test_plies_of_one_material_are_one_layer():
    plies = [DiffusionLayer(THICKNESS / 8, SLAB.diffusivity, SLAB.capacity)] * 8
    times = np.array([0.02, 0.2]) * UNIT
    whole = diffuse([SLAB], WATER, times, cells=100)
    cut = diffuse(plies, WATER, times, cells=100)
    np.testing.assert_allclose(cut.saturation, whole.saturation, atol=1e-12)


def test_each_layer_has_its_own_activation_energy():
    hot = 340.0
    energies = (30e3, 60e3)
    layers = [
        DiffusionLayer(
            layer.thickness, Diffusivity(layer.diffusivity.value, 300.0, q), layer.capacity
        )
        for layer, q in zip(TWO, energies, strict=True)
    ]
    same = [
        DiffusionLayer(
            layer.thickness, Diffusivity(float(layer.diffusivity.at(hot))), layer.capacity
        )
        for layer in layers
    ]
    times = np.array([0.01, 0.05]) * UNIT
    # The number of cells in each layer goes by the diffusivities as stated.
    one = diffuse(layers, Ambient.constant(0.7, hot), times, cells=600)
    other = diffuse(same, Ambient.constant(0.7, 293.15), times, cells=600)
    np.testing.assert_allclose(one.uptake, other.uptake, atol=5e-6)


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


# ---- bars ------------------------------------------------------------------------------------

WIDTH, ACROSS = 6e-3, 4e-12
BAR = DiffusionLayer(THICKNESS, Diffusivity(DIFFUSIVITY), 60.0, Diffusivity(ACROSS))


def bar_error(cells: tuple[int, int], faces: str, times: np.ndarray) -> float:
    history = diffuse_bar([BAR], WIDTH, WATER, times, faces=faces, cells=cells)
    assert history.mass_balance_error < 1e-12
    z = (history.across[1:] + history.across[:-1]) / 2
    sizes = (THICKNESS, WIDTH, DIFFUSIVITY, ACROSS)
    exact = bar_profile(history.place, z, times, *sizes, faces=faces)
    np.testing.assert_allclose(
        history.uptake, bar_uptake(times, *sizes, faces=faces), atol=8 / min(cells) ** 2
    )
    return float(np.abs(history.field - exact).max())


@every_face
def test_a_bar_against_the_product_of_series(faces):
    times = np.array([0.02, 0.1, 0.5]) * UNIT
    errors = [bar_error(cells, faces, times) for cells in ((30, 20), (60, 40))]
    assert errors[1] < 1.6e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("faces", ["both", pytest.param("lower", marks=pytest.mark.thorough)])
def test_the_uptake_of_a_bar_tends_to_the_series(faces):
    """Extrapolated by h^2 and h^4 from three meshes; the finest alone is off by 6e-4."""
    times = np.array([0.02, 0.1, 0.5]) * UNIT
    sizes = (THICKNESS, WIDTH, DIFFUSIVITY, ACROSS)
    parts = np.array([1, 2, 3])
    found = [
        diffuse_bar(
            [BAR], WIDTH, WATER, times, faces=faces, cells=(24 * n, 12 * n), tolerance=1e-8
        ).uptake
        for n in parts
    ]
    to_nothing = np.polyfit(1.0 / parts**2, found, 2)[-1]
    exact = bar_uptake(times, *sizes, faces=faces)
    assert np.abs(found[-1] - exact).max() > 1e-4
    np.testing.assert_allclose(to_nothing, exact, atol=1e-6)


def test_a_bar_of_layers_turned_by_a_quarter():
    """Two layers side by side are nothing that this can say; one layer either way round is."""
    times = np.array([0.02, 0.2]) * UNIT
    through, across = BAR.diffusivity, BAR.diffusivity_across
    upright = diffuse_bar([BAR], WIDTH, WATER, times, cells=(32, 32), tolerance=1e-7)
    turned = DiffusionLayer(WIDTH, across, 60.0, through)
    lying = diffuse_bar([turned], THICKNESS, WATER, times, cells=(32, 32), tolerance=1e-7)
    field = lying.field.transpose(0, 2, 1)
    np.testing.assert_allclose(upright.field, field, atol=1e-6)


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


@settings(max_examples=4)
@given(laminates(), climates(), numbers(0.0, 1.0), numbers(1e-3, 2e-2))
def test_no_water_is_lost_in_bars(layers, ambient, initial, width):
    history = diffuse_bar(
        layers, width, ambient, [1e5, 3e6], initial=initial, cells=(30, 16), tolerance=1e-4
    )
    assert history.mass_balance_error < 1e-12
    weights = np.diff(history.across) / width
    np.testing.assert_allclose(history.field @ weights, history.saturation, atol=1e-12)
