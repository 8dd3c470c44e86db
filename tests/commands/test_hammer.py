"""``flexmech hammer``, locked and ``--running``: files, request and refusals."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from flexmech import ComputationError, InputError, LinkPoint, hammer_test, running_hammer_test
from flexmech.analyses import HammerRequest
from flexmech.measured_data import read_uff
from tests.support.gauge_record import ALUMINIUM as FOUR_BAR
from tests.support.gauge_record import ENGINE, damped
from tests.support.journeys import Journey

ALUMINIUM = "models/aluminium_fourbar.toml"
COARSE = ("--engine", "reference", "--elements", "2", "--no-plots")


@pytest.fixture(scope="module")
def journey(tmp_path_factory):
    return Journey(
        tmp_path_factory.mktemp("hammer") / "out",
        *("hammer", "models/composite_fourbar.toml", "--angle", "30,96.9", "--grid", "2", "--uff"),
        *("--impact", "coupler:0.4", "--response", "rocker:0.3", "--bandwidth", "900 Hz"),
        *("--damping-ratio", "2%", "--noise", "1%", "--seed", "3", *COARSE),
    )


def test_the_tables_of_a_locked_linkage(journey):
    frf = journey.table("frf")
    assert ",".join(frf) == (
        "crank_angle_deg,frequency_Hz,receptance_real_m_N,receptance_imag_m_N,coherence"
    )
    assert frf["frequency_Hz"].max() == pytest.approx(900.0)
    assert 0.9 < frf["coherence"].max() <= 1.0
    modes = journey.table("identified")
    assert ",".join(modes) == (
        "crank_angle_deg,mode,frequency_Hz,damping_ratio,frequency_error_Hz,damping_ratio_error,"
        "eigen_frequency_Hz,eigen_damping_ratio,mac"
    )
    assert sorted(set(modes["crank_angle_deg"])) == [30.0, 96.9]
    first = modes["mode"] == 1
    for column, within in (("frequency_Hz", 0.01), ("damping_ratio", 0.1)):
        found, eigen = modes[column][first], modes[f"eigen_{column}"][first]
        np.testing.assert_allclose(found, eigen, rtol=within)
        stem, unit, _ = column.partition("_Hz")
        error = modes[f"{stem}_error{unit}"][first]
        assert ((error > 0) & (error < within * eigen / 3)).all()
    assert (modes["mac"][first] > 0.99).all()
    # The damping ratio asked for is that of the first mode, on average over the turn.
    assert modes["eigen_damping_ratio"][first] == pytest.approx(0.02, rel=0.1)


def test_standard_errors_by_noise_are_printed_beside_what_is_identified(command):
    """With one crank angle the answer has twice as much to either side: a 95 % interval."""
    model = ("hammer", "models/composite_fourbar.toml", "--angle", "96.9", "--no-plots", *COARSE)
    ended = command(*model, "--damping-ratio", "2%", "--noise", "1%", "--json")
    told = json.loads(ended.stdout)
    numbers = {one["name"]: one["value"] for one in told["numbers"] if one["of"] == "mode 1"}
    found = re.search(r"mode 1 at ([0-9.]+) ± ([0-9.]+) Hz", " ".join(told["answer"]))
    value, reach = map(float, found.groups())
    assert value == pytest.approx(numbers["identified_frequency"], abs=reach)
    assert reach == pytest.approx(2 * numbers["identified_frequency_error"], rel=0.5)


def test_shapes_stand_at_the_points_of_the_grid(journey):
    shapes = journey.table("shapes")
    one = (shapes["mode"] == 1) & (shapes["crank_angle_deg"] == 30)
    assert shapes["link"][one].tolist() == [n for n in ("crank", "coupler", "rocker") for _ in "12"]
    assert shapes["fraction"][one] == pytest.approx([0.25, 0.75] * 3)
    size = np.hypot(shapes["shape_real"], shapes["shape_imag"])[one]
    assert size.max() == pytest.approx(1.0, abs=1e-9)


def test_a_universal_file_stands_beside_each_angle_and_the_result_loads_back(journey):
    assert [f for f in journey.ended.files if f.endswith(".uff")] == [
        "hammer_30deg.uff",
        "hammer_96.9deg.uff",
    ]
    assert len(read_uff(journey.ended.folder / "hammer_30deg.uff").frames) == 3
    attributes = journey.result().dataset.attrs
    assert (attributes["impact"], attributes["response_point"]) == ("coupler:0.4", "rocker:0.3")
    assert (attributes["noise"], attributes["seed"]) == (0.01, 3)


def test_a_running_linkage_is_hit_at_the_speed_asked_for(tmp_path):
    points = ("--impact", "arm:0.7", "--response", "arm:1", "--direction", "transverse")
    journey = Journey(
        tmp_path / "out",
        *("hammer", "models/rotating_arm.toml", "--running", "600 rpm", "--damping-ratio", "20%"),
        *(*points, "--prestress", "axial", *COARSE),
    )
    table = journey.table("harmonic_frf")
    assert ",".join(table) == (
        "order,frequency_Hz,receptance_real_m_N,receptance_imag_m_N,frozen_real_m_N,frozen_imag_m_N"
    )
    result = journey.result()
    attributes = result.dataset.attrs
    assert attributes["crank_speed"] == pytest.approx(20 * np.pi)
    assert (attributes["prestress"], attributes["impact_point"]) == ("axial", "arm:0.7")
    peaks = result.peaks().set_index("order")
    assert peaks.loc[[-2, -1, 1, 2], "peak_m_N"].tolist() == [0.0] * 4
    of_order_0 = np.hypot(table["receptance_real_m_N"], table["receptance_imag_m_N"])
    assert peaks.loc[0, "peak_m_N"] == pytest.approx(of_order_0.max(), rel=1e-9)


DAMPED = ("--damping-ratio", "2%")
OPTIONS = {
    "no damping": ((), "--damping-ratio"),
    "no damping, running": (("--running", "20"), "--damping-ratio"),
    "no point": ((*DAMPED, "--impact", "coupler"), "--impact: got 'coupler'"),
    "a point on no link": ((*DAMPED, "--response", "arm:0.5"), "--response: the point arm:0.5"),
    "a point off its link": ((*DAMPED, "--impact", "coupler:1.5"), "--impact: the point"),
    "no band": ((*DAMPED, "--bandwidth", "0"), "--bandwidth"),
    "noise that is no number": ((*DAMPED, "--noise", "loud"), "--noise"),
    "angles that fall": ((*DAMPED, "--angle", "90,30"), "--angle"),
    "an angle of a running crank": (
        (*DAMPED, "--running", "20", "--angle", "90"),
        "--angle does not go with --running",
    ),
    "a grid of a running linkage": (
        (*DAMPED, "--running", "20", "--grid", "3"),
        "--grid does not go with --running",
    ),
    "files of a running linkage": (
        (*DAMPED, "--running", "20", "--uff"),
        "--uff does not go with --running",
    ),
    "noise of a running linkage": (
        (*DAMPED, "--running", "20", "--noise", "1%"),
        "--noise does not go with --running",
    ),
    "Exudyn's running linkage": (
        (*DAMPED, "--running", "20", "--engine", "exudyn"),
        "--engine reference",
    ),
    "a crank that stands": ((*DAMPED, "--running", "0"), "--running: got '0'"),
    "no speed": ((*DAMPED, "--running", "fast"), "--running"),
}


@pytest.mark.parametrize("wrong", OPTIONS)
def test_options_that_make_no_sense_are_refused_in_one_line(command, wrong):
    options, words = OPTIONS[wrong]
    ended = command("hammer", ALUMINIUM, *COARSE, *options)
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert words in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not ended.files


ANGLE = np.radians([96.9])
DAMPED_ENGINE = ENGINE.with_(mechanism=damped(FOUR_BAR, every=1.4e-4))
REQUESTS = {
    "a pulse longer than the record": ({"pulse": 0.5, "duration": 0.2}, "shorter pulse"),
    "a band beyond the elements": ({"bandwidth": 1e6}, "more elements"),
    "a pulse too soft for the band": ({"bandwidth": 60.0, "pulse": 0.05}, "26 Hz"),
    "too few samples": ({"bandwidth": 60.0, "duration": 0.1}, "samples"),
    "too many steps": ({"duration": 1e6}, "shorter duration"),
    "a band below the first mode": ({"bandwidth": 20.0}, "44.89 Hz"),
    "a pulse below the first mode": ({"pulse": 0.1}, "shorter pulse"),
    "no direction": ({"direction": "upward"}, "direction must be one of"),
    "a grid of one point": ({"grid": 1}, "grid must be 2 or more"),
    "a point that the shaft holds": ({"impact": LinkPoint("crank", 0.0)}, "crank:0.5"),
    "a link that is none": ({"impact": LinkPoint("couple", 0.5)}, "did you mean 'coupler'"),
}


@pytest.mark.parametrize("wrong", REQUESTS)
def test_records_that_cannot_be_taken_are_refused_with_the_remedy(wrong):
    asked, words = REQUESTS[wrong]
    with pytest.raises(InputError) as raised:
        hammer_test(DAMPED_ENGINE, HammerRequest(ANGLE, **({"modes": 2} | asked)))
    assert words in str(raised.value)


def test_a_pulse_alone_sets_the_band_to_its_inverse():
    """A short record reaches 1.25 to 1.4 times the highest of the modes asked for."""
    asked = {"modes": 2, "method": "circle-fit"}
    soft = hammer_test(DAMPED_ENGINE, HammerRequest(ANGLE, pulse=0.02, **asked)).dataset
    assert soft.attrs["bandwidth"] == pytest.approx(50.0)
    free = hammer_test(DAMPED_ENGINE, HammerRequest(ANGLE, **asked)).dataset
    highest = float(free["eigen_frequency"].isel(mode=1).max())
    assert 1.25 * highest <= free.attrs["bandwidth"] < 1.4 * highest


POINTS = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
RUNNING = {
    "a crank that stands": ({"speed": 0.0}, "--running"),
    "no speed": ({"speed": np.nan}, "speed"),
    "too much damping": ({"damping_ratio": 1.0}, "damping_ratio"),
    "no orders": ({"orders": 0}, "orders"),
    "a point on no link": ({"impact": LinkPoint("shaft", 0.5)}, "on no link"),
    "no damping": ({"damping_ratio": None}, "--damping-ratio"),
    "too many frequencies": ({"duration": 1e6}, "--duration"),
    "a band without a frequency": ({"bandwidth": 1.0, "duration": 0.1}, "longer --duration"),
    # At 87.3 rad/s vibrations of the aluminium linkage grow.
    "a linkage that shakes itself up": (
        {"speed": 87.3, "damping_ratio": 0.0005, "prestress": "axial"},
        "87.3 rad/s",
    ),
}


@pytest.mark.parametrize("wrong", RUNNING)
def test_running_tests_that_make_no_sense_are_refused(wrong):
    asked, words = RUNNING[wrong]
    known = {"speed": 20.0, "damping_ratio": 0.1, "bandwidth": 60.0, "orders": 1}
    known |= {"impact": POINTS[0], "response": POINTS[1]}
    with pytest.raises((InputError, ComputationError)) as raised:
        running_hammer_test(ENGINE, **(known | asked))
    assert words in str(raised.value)
