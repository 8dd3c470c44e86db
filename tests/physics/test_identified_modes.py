"""Modes identified from receptances and impacts whose modes are known in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech import ComputationError, InputError
from flexmech.modal_testing import (
    ExponentialWindow,
    ForceWindow,
    FrfEstimate,
    FrfNoise,
    complexity_factor,
    estimate_frf,
    estimate_harmonics,
    identify,
    mac,
    with_noise,
    without_synchronous_average,
)

METHODS = pytest.mark.parametrize("method", ["lscf", "circle-fit"])
FREQUENCY = np.array([30.0, 75.0, 160.0, 280.0, 430.0, 610.0])
RATIO = 0.005 * FREQUENCY / FREQUENCY[0]  # Kelvin-Voigt damping
POINTS = np.array([0.2, 0.37, 0.6, 0.9])
HIT = 1  # row of the point that is hit
LINES = np.arange(800) * 0.5
BAND = (10.0, 390.0)


def pole_of(frequency: Any, ratio: Any) -> Any:
    omega = 2 * np.pi * frequency
    return omega * (-ratio + 1j * np.sqrt(1 - ratio**2))


def modal_sum(s: np.ndarray, pole: np.ndarray, residue: np.ndarray) -> np.ndarray:
    """Receptance of poles and residues, Ewins, *Modal Testing*, 2nd ed., eq. 2.89."""
    mirrored = residue.conj() @ (1 / (s - pole.conj()[:, None]))
    return residue @ (1 / (s - pole[:, None])) + mirrored


POLES = pole_of(FREQUENCY, RATIO)
SHAPES = np.sin(np.pi * np.outer(POINTS, np.arange(1, FREQUENCY.size + 1)))
RESIDUES = SHAPES * SHAPES[HIT] / (2j * POLES.imag)


def receptance(lines: np.ndarray, added_damping: float = 0.0) -> np.ndarray:
    """Receptance of a pinned beam with the shapes sin(k pi x)."""
    return modal_sum(added_damping + 2j * np.pi * lines, POLES, RESIDUES)


def oscillators(lines: np.ndarray, *poles: complex) -> np.ndarray:
    """Receptance of oscillators of unit mass at one point."""
    known = np.array(poles)
    return modal_sum(2j * np.pi * lines, known, (1 / (2j * known.imag))[None])


@METHODS
@pytest.mark.parametrize("added_damping", [0.0, 3.0])
def test_poles_and_residues_of_four_modes_beside_two_beyond_the_band(method, added_damping):
    """Frequencies to 1e-4, damping ratios and residues to 1e-3, free of the window's damping."""
    modes = identify(
        LINES,
        receptance(LINES, added_damping),
        band=BAND,
        expected=FREQUENCY[:4] * 1.01,
        method=method,
        added_damping=added_damping,
    )
    np.testing.assert_allclose(modes.frequency, FREQUENCY[:4], rtol=1e-4)
    np.testing.assert_allclose(modes.damping_ratio, RATIO[:4], rtol=1e-3)
    np.testing.assert_allclose(modes.residue[:, 0], RESIDUES[:, 0], rtol=1e-3)
    assert modes.misfit < 1e-3
    between = np.array([29.0, 30.0, 80.0, 200.0])
    exact = receptance(between)
    assert np.all(abs(modes.receptance(between) - exact) < 0.02 * abs(exact).max(axis=0))


def test_the_damping_ratio_of_a_heavily_damped_mode_is_the_real_part_over_the_size_of_its_pole():
    """At 30 % the imaginary part is 5 % smaller than the size."""
    modes = identify(LINES[1:], oscillators(LINES[1:], pole_of(100.0, 0.3)), count=1, method="lscf")
    np.testing.assert_allclose(modes.damping_ratio, 0.3, rtol=1e-6)
    np.testing.assert_allclose(modes.frequency, 100.0, rtol=1e-6)


@METHODS
def test_an_expected_mode_that_does_not_answer_is_not_found(method):
    modes = identify(
        LINES, receptance(LINES), band=BAND, expected=[30.0, 50.0, 160.0], method=method
    )
    assert modes.found.tolist() == [True, False, True]
    assert np.isnan(modes.frequency[1])
    assert modes.further_pole.size == 2


def test_a_mode_at_the_end_of_the_band_is_identified_by_lscf():
    """The band's end is half the sampling rate of LSCF, where it is blind."""
    pole = pole_of(np.array([76.54, 95.94]), 9e-5)
    lines = np.arange(1, 6401) * 0.015
    value = modal_sum(0.095 + 2j * np.pi * lines, pole, (1 / (2j * pole.imag))[None])
    modes = identify(lines, value, expected=[76.54, 95.94], added_damping=0.095, method="lscf")
    np.testing.assert_allclose(modes.pole, pole, rtol=1e-6)


def test_two_modes_four_widths_apart_are_told_apart_by_circles():
    lines = np.arange(1, 401) * 0.25
    pair = pole_of(np.array([50.0, 52.0]), 0.01)
    modes = identify(lines, oscillators(lines, *pair), count=2, method="circle-fit")
    np.testing.assert_allclose(modes.pole, pair, rtol=1e-6)


def test_twelve_modes_are_identified_from_a_hundred_lines():
    frequency = np.linspace(8.0, 92.0, 12)
    lines = np.arange(1, 101) * 1.0
    value = oscillators(lines, *pole_of(frequency, 0.3 / frequency))
    modes = identify(lines, value, count=12, method="lscf")
    np.testing.assert_allclose(modes.frequency, frequency, rtol=0.01)


def test_noise_pulls_the_damping_of_lscf_to_neither_side():
    """Poles of LSCF alone are 15 % short of damping here."""
    exact = receptance(LINES)
    size = 0.005 * np.sqrt(np.mean(abs(exact) ** 2))
    apart = []
    for seed in range(12):
        real, imaginary = np.random.default_rng(seed).standard_normal((2, *exact.shape)) * size
        noisy = exact + real + 1j * imaginary
        modes = identify(LINES, noisy, band=BAND, expected=FREQUENCY[:3])
        apart.append(modes.damping_ratio / RATIO[:3] - 1)
    scatter, bias = np.std(apart, axis=0), np.mean(apart, axis=0)
    assert np.all(abs(bias) < 3 * scatter / np.sqrt(12)), (bias, scatter)
    assert np.all(scatter < [1e-3, 1e-2, 0.1])


def test_the_misfit_is_the_part_of_noise_in_the_receptances():
    """White noise of 5 %: a fit to so many lines leaves nearly all of it."""
    lines, noise = np.arange(10.0, 391.0), 0.05
    exact = receptance(lines)
    real, imaginary = np.random.default_rng(5).standard_normal((2, *exact.shape))
    measured = exact + noise * np.sqrt(np.mean(abs(exact) ** 2) / 2) * (real + 1j * imaginary)
    modes = identify(lines, measured, expected=FREQUENCY[:3], method="circle-fit")
    misfit = np.linalg.norm(measured - modes.receptance(lines)) / np.linalg.norm(measured)
    np.testing.assert_allclose(modes.misfit, misfit, rtol=1e-9)
    assert 0.9 * noise < modes.misfit < 1.1 * noise


def test_the_nyquist_circle_of_a_mode_passes_through_its_resonance():
    modes = identify(LINES, receptance(LINES), band=BAND, expected=FREQUENCY[:3])
    centre, radius = modes.circle(0, point=2)
    near = receptance(np.linspace(29.5, 30.5, 21))[2]
    np.testing.assert_allclose(abs(near - centre), radius, rtol=2e-2)


# --- records, windows and averages --------------------------------------------------------------


def impact_records(
    window: ExponentialWindow | None = None, averages: int = 1, noise: float = 0.0
) -> FrfEstimate:
    """A push of one sample and the response in closed form, over two seconds."""
    rate, length = 2048.0, 4096
    time = np.arange(length) / rate
    force = np.zeros(length)
    force[64] = rate  # of unit momentum, some time after the record's begin
    since = np.maximum(time - time[64], 0.0)
    response = 2 * (RESIDUES[0] @ np.exp(POLES[:, None] * since)).real * (since > 0)
    generator = np.random.default_rng(1)
    forces = with_noise(np.tile(force, (averages, 1)), noise, generator)
    responses = with_noise(np.tile(response, (averages, 1)), noise, generator)
    return estimate_frf(
        forces, responses, rate, force_window=ForceWindow(0.04), exponential_window=window
    )


def test_an_exponential_window_shifts_the_poles_by_its_rate():
    """The function is that at s + rate; damping comes back to 0.5 % once the rate is taken off."""
    window = ExponentialWindow.ending_at(2.0, 1e-3)
    estimate = impact_records(window)
    near = (estimate.frequency > 20.0) & (estimate.frequency < 200.0)
    exact = receptance(estimate.frequency[near], window.decay_rate)[0]
    assert abs(estimate.h1[near] - exact).max() < 3e-3 * abs(exact).max()
    modes = identify(
        estimate.frequency,
        estimate.h1[None],
        band=BAND,
        expected=FREQUENCY[:3],
        added_damping=estimate.added_damping,
        method="circle-fit",
    )
    np.testing.assert_allclose(modes.frequency, FREQUENCY[:3], rtol=1e-4)
    np.testing.assert_allclose(modes.damping_ratio, RATIO[:3], rtol=5e-3)
    shifted = POLES - window.decay_rate
    added = -shifted.real / abs(shifted) - RATIO
    np.testing.assert_allclose(window.added_damping_ratio(FREQUENCY[:3]), added[:3], rtol=0.02)
    assert np.all(added[:2] > 0.3 * RATIO[:2])


def test_a_force_window_falls_over_its_taper_by_a_cosine():
    window = ForceWindow(0.02, taper=0.008)
    quarter = 0.5 * (1 + np.sqrt(0.5))
    time = np.array([0.0, 0.012, 0.02, 0.022, 0.024, 0.026, 0.028, 0.1])
    expected = [1.0, 1.0, 1.0, quarter, 0.5, 1 - quarter, 0.0, 0.0]
    np.testing.assert_allclose(window.values(time), expected, atol=1e-12)


def test_one_record_is_coherent_and_noise_lowers_the_coherence():
    """By signal and noise: (1 + n / s)^-1 of force times that of response, of many averages."""
    calm = impact_records()
    assert calm.coherence == pytest.approx(np.ones(calm.frequency.size))
    np.testing.assert_allclose(calm.h1, calm.h2, rtol=1e-9)
    noisy = impact_records(averages=4, noise=0.2)
    resonance, far = np.argmin(abs(noisy.frequency - 30.0)), noisy.frequency > 700.0
    assert noisy.coherence[resonance] > 0.99
    assert noisy.coherence[far].mean() < 0.7
    np.testing.assert_allclose(
        noisy.coherence, (noisy.h1 / noisy.h2).real, rtol=1e-9, err_msg="coherence is H1 over H2"
    )


RATE, SAMPLES, RUNG = 512.0, 1024, 20.0
"""Sampling of records in which a mode of 20 Hz rings, damped by half a percent."""


def rung(seed: int, decay_rate: float, noise: float = 0.05, of_force: float = 0.01) -> FrfEstimate:
    """Three averages of a half-sine of three samples, five times weaker at the band's end."""
    time = np.arange(SAMPLES) / RATE
    force = np.zeros(SAMPLES)
    force[16:19] = np.sin(np.pi * np.array([1, 3, 5]) / 6)
    pole = pole_of(RUNG, 0.005)
    answer = (np.exp(pole * time) / (2j * pole.imag)).real * 2
    response = np.convolve(force, answer)[:SAMPLES] / RATE
    generator = np.random.default_rng(seed)
    records = (
        with_noise(np.tile(signal, (3, 1)), part, generator)
        for signal, part in ((force, of_force), (response, noise))
    )
    windows = {
        "force_window": ForceWindow(0.06, 0.02),
        "exponential_window": ExponentialWindow(decay_rate),
    }
    estimate = estimate_frf(*records, RATE, **windows)
    return estimate.at((estimate.frequency > 0) & (estimate.frequency <= 200.0))


@pytest.mark.parametrize(("noise", "of_force"), [(0.05, 0.0), (0.0, 0.01)])
def test_the_noise_of_h1_has_the_covariance_of_windows_and_pulse(noise, of_force):
    """In 300 draws a window makes neighbours alike, and 140 Hz twice as noisy as 20 Hz."""
    exact, lines = rung(0, 4.0, 0.0, 0.0).h1, [39, 40, 120, 280, 281]
    draws = [rung(seed, 4.0, noise, of_force) for seed in range(300)]
    apart = np.stack([(draw.h1 - exact)[lines] for draw in draws])
    measured = np.cov(np.concatenate([apart.real, apart.imag], axis=1).T)
    rows = np.zeros((2 * len(lines), 2 * exact.size))
    places = [*lines, *(exact.size + np.array(lines))]
    rows[np.arange(len(places)), places] = 1.0
    one = draws[0]
    known = one.noise.covariance(rows, exact, 1.0 if noise else 0.0)
    # The noise of the response is a part of its root mean square, not repeated here.
    known *= np.trace(measured) / np.trace(known) if noise else 1.0
    size = np.sqrt(np.diag(known))
    np.testing.assert_allclose(
        measured / np.outer(size, size), known / np.outer(size, size), atol=0.2
    )
    assert abs(known[0, 1]) > 0.5 * known[0, 0]
    if noise:
        assert size[3] > 2 * size[0]


@pytest.mark.parametrize("decay_rate", [4.0, pytest.param(6.0, marks=pytest.mark.thorough)])
def test_what_is_identified_scatters_as_its_standard_errors_say(decay_rate):
    """The standard deviation of ten records is 0.5 to 1.7 times the true one (98 %).

    Were the noise of all lines independent and equal, the errors would be 2.2 to 2.6 times as wide.
    """
    found = []
    for seed in range(10):
        estimate = rung(seed, decay_rate)
        found.append(
            identify(
                estimate.frequency,
                estimate.h1,
                expected=[RUNG, 60.0, 100.0, 150.0],
                added_damping=decay_rate,
                noise=estimate.noise,
                method="lscf",
            )
        )
    assert [modes.found.tolist() for modes in found] == 10 * [[True, False, False, False]]
    for name, true in (("frequency", RUNG), ("damping_ratio", 0.005)):
        values = np.array([getattr(modes, name)[0] for modes in found])
        errors = np.array([getattr(modes, f"{name}_error")[0] for modes in found])
        assert 0.5 < values.std(ddof=1) / errors.mean() < 1.7
        assert abs(values.mean() - true) < 3.5 * errors.mean() / np.sqrt(10)


# --- shapes -------------------------------------------------------------------------------------


def test_the_modal_assurance_criterion_by_hand():
    shapes = np.array([[1.0, 2.0], [1j, 1.0], [0.0, -1.0]])
    np.testing.assert_allclose(np.diag(mac(shapes, shapes * (2 - 3j))), 1.0)
    assert mac(np.array([1.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])) == pytest.approx(0.5)
    # |2 - i|^2 / (2 * 6)
    assert mac(shapes[:, 0], shapes[:, 1]) == pytest.approx(5 / 12)


def test_the_complexity_factor_by_sums_of_squares():
    """Imregun and Ewins 1995: 0 where all points are in phase."""
    x, y = np.random.default_rng(3).standard_normal((2, 5))
    assert complexity_factor(x * np.exp(0.7j)) == pytest.approx(0.0, abs=1e-14)
    expected = 1 - ((x @ x - y @ y) ** 2 + 4 * (x @ y) ** 2) / (x @ x + y @ y) ** 2
    assert complexity_factor(x + 1j * y)[0] == pytest.approx(expected)


# --- running machines ---------------------------------------------------------------------------

ORDER, SHIFT, BINS, COUNT = 2, 4, 30, 64


def harmonic_functions(highest: int) -> np.ndarray:
    """H_n at the bins -COUNT to COUNT, with H_-n(-f) the conjugate of H_n(f)."""
    real, imaginary = np.random.default_rng(1).normal(size=(2, 2 * highest + 1, 2 * COUNT + 1))
    values = real + 1j * imaginary
    return (values + values[::-1, ::-1].conj()) / 2


def struck(phase: np.ndarray, highest: int = ORDER) -> tuple[np.ndarray, np.ndarray]:
    """Force and response at the bins from 0 of impacts at these places of the period."""
    response, number = harmonic_functions(highest), np.arange(COUNT)
    delay = np.exp(-2j * np.pi * phase[:, None] * number / SHIFT)
    force = np.exp(-((number / 40) ** 2)) * delay
    both = np.concatenate([force[:, :0:-1].conj(), force], axis=1)
    total = np.zeros(force.shape, dtype=complex)
    for row, order in enumerate(range(-highest, highest + 1)):
        entering = number - SHIFT * order
        inside = np.abs(entering) < COUNT
        pushed = both[:, np.clip(entering + COUNT - 1, 0, 2 * COUNT - 2)] * inside
        total += response[row, np.clip(entering + COUNT, 0, 2 * COUNT)] * pushed
    return force, total


def spread(count: int) -> np.ndarray:
    jitter = 0.2 * np.random.default_rng(0).uniform(-1, 1, count)
    return (np.arange(count) + 0.5 + jitter) / count


ASKED = {"highest_order": ORDER, "shift": SHIFT, "bins": BINS}


@pytest.mark.parametrize("count", [5, 9])
def test_harmonic_transfer_functions_are_found_from_impacts_over_the_period(count):
    found = estimate_harmonics(*struck(spread(count)), **ASKED)
    exact = harmonic_functions(ORDER)[:, COUNT : COUNT + BINS]
    np.testing.assert_allclose(found.response, exact, rtol=1e-9)
    assert 1 <= found.condition < 3
    assert found.misfit < 1e-12
    assert estimate_harmonics(*struck(spread(9), highest=3), **ASKED).misfit > 0.05


TURN, TURNS = 32, 12


def ringing(start: int) -> np.ndarray:
    since = np.maximum(np.arange(TURN * TURNS) - start, 0.0)
    return np.exp(-0.02 * since) * np.sin(0.7 * since)


@given(start=st.integers(TURN, 4 * TURN))
def test_the_synchronous_average_leaves_an_impact_alone(start):
    phase = 2 * np.pi * np.arange(TURN * TURNS) / TURN
    running = 3.0 + np.cos(phase) - 0.4 * np.sin(5 * phase)
    both = np.stack([running + ringing(start), 2 * running + ringing(start + 9)])
    left = without_synchronous_average(both, TURN, np.arange(both.shape[1]) <= start)
    np.testing.assert_allclose(left, np.stack([ringing(start), ringing(start + 9)]), atol=1e-12)


# --- refusals -----------------------------------------------------------------------------------

ONES = np.ones(4)
REFUSED = {
    "wider band": lambda: identify(LINES, receptance(LINES), band=(10.0, 12.0)),
    "circle-fit": lambda: identify(LINES, receptance(LINES), method="guess"),
    "evenly spaced": lambda: identify(LINES**1.1, receptance(LINES)),
    "not finite": lambda: identify(LINES, np.full(800, np.nan)),
    "(points, F)": lambda: identify(LINES, np.zeros(7)),
    "above 0 s": lambda: ForceWindow(0.0),
    "0 or more": lambda: ExponentialWindow(-1.0),
    "as many of each": lambda: estimate_frf(ONES, np.ones(5), 1.0),
    "begin with the impact": lambda: estimate_frf(0 * ONES, ONES, 1.0),
    "the same frequencies": lambda: identify(
        LINES, receptance(LINES), noise=FrfNoise.of_lines(LINES[1:], 0.0)
    ),
    "same points": lambda: mac(ONES, np.ones(3)),
    "spread them over": lambda: estimate_harmonics(
        *struck(np.full(7, 0.3) + 1e-6 * np.arange(7)), **ASKED
    ),
    "sample them more often": lambda: estimate_harmonics(
        *struck(spread(5)), **(ASKED | {"bins": COUNT - 2 * ORDER * SHIFT + 1})
    ),
    "no quiet": lambda: without_synchronous_average(ringing(0), TURN, np.arange(TURN * TURNS) < 20),
}


@pytest.mark.parametrize("remedy", REFUSED)
def test_records_that_cannot_be_identified_are_refused_with_the_remedy(remedy):
    with pytest.raises(InputError) as raised:
        REFUSED[remedy]()
    assert remedy in str(raised.value)


def test_a_spring_without_mass_has_no_unique_fit():
    with pytest.raises(ComputationError, match="fewer orders"):
        identify(LINES[1:], np.ones(799, dtype=complex), count=1, method="lscf")
