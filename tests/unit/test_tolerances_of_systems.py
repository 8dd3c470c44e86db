"""Tolerances of linear systems and of what users write: each test fails if its constant is off."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import BeamSection, Material, Mechanism, ReferenceEngine, RotatingArm
from flexmech.arrays import ROUND_OFF
from flexmech.dynamical_systems import (
    ForcedPeriodicSystem,
    FourierSeries,
    HalfSinePulse,
    LowPass,
    SampledPeriodicSystem,
    StatedPeriodicSystem,
    floquet_modes,
    harmonic_response,
    pulse_response,
    sample_intervals,
    state_modes,
)
from flexmech.dynamical_systems.periodic_schur import (
    _groups,
    parted_steps,
    periodic_schur_form,
    short_products,
)
from flexmech.dynamical_systems.periodic_system import matrix_exponentials
from flexmech.errors import ComputationError, FlexmechError, InputError, one_line
from flexmech.files import given_path
from flexmech.linear_system import refuse_large_displacements
from flexmech.model_text import quantity, short_repr
from flexmech.modelfile.csv_files import csv_lines
from flexmech.modelfile.messages import together
from flexmech.quantity_lists import parse_quantities
from flexmech.unit_registry import base_units
from flexmech.units import ANGULAR_SPEED, LENGTH, MASS, STRESS
from flexmech.validation import check_angle

# --- constant systems ---------------------------------------------------------------------------


def test_the_spectrum_of_a_pulse_has_no_gap_at_half_a_period():
    pulse = HalfSinePulse(2.0, 1e-3)
    around = np.abs(pulse.spectrum(500.0 * (1 + np.array([-1e-5, -1e-9, 0.0, 1e-9, 1e-5]))))
    np.testing.assert_allclose(around, pulse.momentum * np.pi / 4, rtol=2e-5)
    near = np.abs(pulse.spectrum(500.0 * (1 + 4e-5)))
    assert near / (pulse.momentum * np.pi / 4) == pytest.approx(1 - 2e-5, abs=2e-7)


def test_what_a_pulse_leaves_decays_to_its_last_digits():
    pole = np.array([-1.0 + 20j, -1.0 - 20j])
    residue = np.array([[0.5 - 1j], [0.5 + 1j]])
    pulse, time = HalfSinePulse(1.0, 0.01), np.array([0.0, 0.01, 10.01, 40.01, 50.01])
    motion = pulse_response(pole, residue, pulse, time)[:, 0]
    first = motion[1] - 0.0
    assert abs(motion[2]) > 1e-6 * abs(first)
    assert 0 < abs(motion[3]) < 1e-14
    assert motion[4] == 0.0


def test_modes_almost_without_stiffness_do_not_blur_the_others():
    """Those of two masses on a spring, and a third one that moves alone."""
    stiffness = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0 + 1e-22, 0.0], [0.0, 0.0, 4.0]])
    stiffness[1, 0] -= 1e-9
    found = state_modes(np.eye(3), np.zeros((3, 3)), stiffness)
    assert np.abs(found.poles[-2:]) == pytest.approx([2.0, 2.0])


# --- periodic systems ---------------------------------------------------------------------------


def test_the_tail_of_a_series_is_its_highest_quarter():
    order = np.arange(17)
    series = FourierSeries((0.5**order).astype(complex))
    assert series.harmonics == 16
    assert series.tail == pytest.approx(0.5**13)


def test_weak_orders_of_a_periodic_system_are_not_lost():
    """The output is read through 1 + 1e-10 cos: so small is the first order."""
    coefficients = np.array([[[-0.5, 1.0], [-1.0, -0.5]], [[0.1, 0.0], [0.0, -0.1]]], dtype=complex)
    system = SampledPeriodicSystem(FourierSeries(coefficients), 3.0)
    force = FourierSeries.constant(np.array([0.0, 1.0]))
    nothing = FourierSeries.constant(np.zeros(()))

    def first_order(reading):
        forced = ForcedPeriodicSystem(system, force, FourierSeries(reading), nothing)
        return harmonic_response(forced, [0.1], [6], 64)[0, 0]

    reading = np.zeros((7, 2), dtype=complex)
    reading[0, 0] = 1.0
    plain = first_order(reading)
    reading[6, 0] = 1e-12
    assert abs(first_order(reading) - plain) == pytest.approx(abs(reading[6, 0]), rel=2.0)


def test_exponentials_of_large_matrices_are_exact():
    turn = np.array([[[0.0, 7.3], [-7.3, 0.0]]])
    exact = np.array([[np.cos(7.3), np.sin(7.3)], [-np.sin(7.3), np.cos(7.3)]])
    np.testing.assert_allclose(matrix_exponentials(turn)[0], exact, atol=2e-15)
    small = 0.7 * turn / 7.3
    exact = np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    np.testing.assert_allclose(matrix_exponentials(small)[0], exact, atol=2e-16)


def test_products_stay_so_short_that_nothing_weak_is_lost():
    exponent = np.tile(np.diag([-40.0, 0.0]) / 64, (64, 1, 1))
    chunks, products = short_products(matrix_exponentials(exponent), 40.0)
    assert len(products) == 8
    assert chunks.shape[1] == 8
    far = np.diag([-20000.0, 0.0])[None]
    assert short_products(matrix_exponentials(far), 20000.0) is None
    split = parted_steps(far / 4)[1]
    assert np.log(np.linalg.cond(split)).max() <= 9.0
    with pytest.raises(ComputationError, match="too far within one"):
        parted_steps(far)


def test_groups_of_multipliers_part_where_they_are_far_apart():
    rates = np.array([0.0, -3.0, -8.0, -9.0, -14.0])
    random = np.random.default_rng(3)
    basis = np.linalg.qr(random.normal(size=(5, 5)))[0]
    step = basis @ np.diag(np.exp(rates / 2)) @ basis.T
    form = periodic_schur_form(np.stack([step, step]))
    assert [group.stop - group.start for group in form.groups] == [2, 2, 1]
    # A group wider than twelve parts at its widest gap, though that is less than four.
    assert [group.stop for group in _groups(-3.9 * np.arange(4.0))] == [4]
    assert [group.stop for group in _groups(np.array([0.0, -3.2, -7.1, -10.0, -13.0]))] == [2, 5]


def test_groups_that_part_slowly_are_waited_for():
    """Neighbours a factor of exp(4.1) apart with a start that is almost the wrong way round."""
    system = StatedPeriodicSystem(
        lambda time: (
            np.tile(np.array([[-4.1, 0.0], [1.0, 0.0]]), (len(time), 1, 1))
            + 1e-3 * np.cos(2 * np.pi * time)[:, None, None]
        ),
        1.0,
    )
    modes = floquet_modes(system, 32)
    assert np.sort(modes.exponent.real) == pytest.approx([-4.1, 0.0], abs=1e-3)


# --- signals ------------------------------------------------------------------------------------


def test_the_filter_passes_its_band_and_stops_twice_of_it():
    step, band = 1e-3, 50.0
    time = step * np.arange(2000)

    def gain(frequency):
        low_pass = LowPass(band, step)
        wave = np.sin(2 * np.pi * frequency * time)[:, None]
        passed = np.concatenate([low_pass.add(wave), low_pass.finish()])
        return np.abs(passed[500:-500]).max()

    assert gain(48.0) == pytest.approx(1.0, abs=2e-3)
    assert 1e-6 < gain(104.0) < 2e-3
    assert LowPass(band, step).half < 60


def test_the_filter_waits_for_a_few_lengths_of_its_kernel():
    low_pass = LowPass(50.0, 1e-3)
    kernel = len(low_pass.kernel)
    assert not len(low_pass.add(np.zeros((3 * kernel, 1))))
    assert len(low_pass.add(np.zeros((kernel, 1))))


def test_weights_count_where_the_step_shows_three_times_the_band():
    weights = (0.5, 1.5)
    for band, counted in ((160.0, True), (170.0, False)):
        low_pass = LowPass(band, 1e-3, weights)
        assert (len(low_pass._weights) == 2) is counted


def test_samples_on_a_step_are_read_off():
    time = np.arange(4.0)
    for apart, read in ((3e-7, True), (3e-6, False)):
        _, fraction = sample_intervals(time, np.array([1.0 + apart]))
        assert bool(fraction[0] == round(fraction[0])) is read


# --- what users write, and what they are told ---------------------------------------------------


def test_a_full_turn_of_degrees_is_an_angle():
    check_angle(2 * np.pi * (1 + 0.1 * ROUND_OFF), "angle")
    with pytest.raises(InputError, match="at most a full turn"):
        check_angle(2 * np.pi * (1 + 10 * ROUND_OFF), "angle")


def test_thirds_of_a_range_end_at_its_end():
    assert parse_quantities("0:1:0.333334", LENGTH, "m").values[-1] == 1.0
    assert len(parse_quantities("0:1:0.3334", LENGTH, "m").values) == 3
    assert parse_quantities("0:1:0.3332", LENGTH, "m").values[-1] == pytest.approx(0.9996)


def test_numbers_are_written_without_exponent_where_they_are_short():
    assert quantity(0.2794, LENGTH) == "279.4 mm"
    assert quantity(2e-6, MASS) == "0.002 g"
    assert quantity(2e-10, MASS) == "2e-10 kg"
    assert quantity(2e9, MASS) == "2000000000.0 kg"
    assert quantity(10 * np.pi, ANGULAR_SPEED) == "300 rpm"
    assert quantity(68.9e9, STRESS) == "68.9 GPa"


def test_texts_are_as_long_as_somebody_reads():
    assert len(short_repr(object(), "x" * 5000)) < 200
    assert len(short_repr(object(), "x" * 120)) > 120
    assert len(one_line("x" * 100_000)) < 4100
    assert one_line("x" * 3000) == "x" * 3000
    with pytest.raises(InputError) as refused:
        given_path("x/" * 5000)
    assert len(str(refused.value)) < 400
    told = str(together("model.toml", [f"key {n}: {'x' * 1000}" for n in range(30)]))
    assert told.count(" | ") == 10
    assert "and 20 more" in told
    assert len(told) < 6000
    assert base_units("m*" * 20 + "m") is not None
    assert base_units("m*" * 40 + "m") is None


def test_fast_shafts_are_told_in_turns_a_minute_too():
    assert str(FlexmechError("at {crank_speed}", crank_speed=99.0)) == "at 99 rad/s"
    assert str(FlexmechError("at {crank_speed}", crank_speed=101.0)).endswith("rpm)")


def test_files_of_loads_have_the_size_of_loads(tmp_path):
    path = tmp_path / "load.csv"
    with path.open("wb") as stream:
        stream.truncate(10_000_001)
    with pytest.raises(InputError, match="is larger than any load"):
        csv_lines(path, "load.csv", "load")
    path.write_text("1,2\n" * 100_000)
    assert len(csv_lines(path, "load.csv", "load")[1]) == 99_999


@pytest.mark.parametrize("part", [0.49, 0.51])
def test_an_equilibrium_is_refused_half_a_length_from_the_rigid_linkage(part: float) -> None:
    strip = BeamSection.rectangle(Material(2e9, 2700.0), 2e-3, 25e-3)
    engine = ReferenceEngine(Mechanism(RotatingArm(0.3), {"arm": strip}), 2)
    [arm], motion = engine.links, engine.mechanism.linkage.motion(np.zeros(1), 0.0)
    moved = np.zeros((1, arm.size))
    moved[0, arm.end[1]] = part * 0.3
    given = (engine.links, motion, [moved])
    if part < 0.5:
        refuse_large_displacements(*given)
        return
    with pytest.raises(ComputationError, match="arm is displaced by 51 % of its length"):
        refuse_large_displacements(*given)
