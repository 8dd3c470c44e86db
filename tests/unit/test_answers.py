"""What commands print first: sentences whose numbers are those of the result."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses import CampbellDiagram, Response
from flexmech.analyses.campbell.answer import band_at, critical_ranges
from flexmech.analyses.trust import EngineDifference, trust_line
from flexmech.report import Results
from flexmech.report.answers import cards

MECHANISM = flexmech.load_mechanism("models/aluminium_fourbar.toml")
SLOW = {"crank_angles": np.radians(np.arange(0, 360, 30)), "modes": 2}


@pytest.fixture(scope="module")
def clear() -> CampbellDiagram:
    """No order of the crank up to the third meets a frequency there."""
    return flexmech.campbell(MECHANISM, np.linspace(0.0, 21.0, 8), orders=[1, 2, 3], **SLOW)


@pytest.fixture(scope="module")
def response() -> Response:
    engine = flexmech.ReferenceEngine(MECHANISM, 2)
    request = flexmech.ResponseRequest(20.0, 1.0, start="periodic", modes=2)
    return flexmech.response(engine, request)


def test_a_campbell_diagram_says_what_an_operating_speed_is_clear_of(clear: CampbellDiagram):
    said = clear.summary()
    assert said.answer[0].startswith("20 rad/s is clear of orders 1 to 3; f1 is ")
    assert said.answer[-1].startswith("No speed from 0 to 21 rad/s is critical: ")
    assert_passes_the_band(
        clear, 20.0, r"the lowest order that meets f1 there is (\d+), at (\S+) to (\S+) rad/s"
    )
    assert said.table is not None
    assert said.table.title.startswith("natural frequencies at 20 rad/s")


def assert_passes_the_band(found: CampbellDiagram, speed: float, words: str) -> None:
    """At the speeds that the first sentence tells the order has the frequencies of the band."""
    order, low, high = map(float, re.search(words, found.summary().answer[0]).groups())
    bands, _ = band_at(found.dataset, speed, 0)
    for told, end in ((low, bands[0]), (high, bands[2])):
        assert order * told / (2 * math.pi) == pytest.approx(end, rel=0.02)


def test_where_no_order_meets_the_branch_the_nearest_is_named():
    running = replace(MECHANISM, operating_speeds=(36.6,))
    found = flexmech.campbell(running, np.linspace(30.0, 45.0, 6), orders=[1, 2, 3], **SLOW)
    words = r"the nearest is order (\d+), which meets f1 at (\S+) to (\S+) rad/s"
    assert_passes_the_band(found, 36.6, words)


def test_an_operating_speed_in_a_critical_range_is_told_so():
    running = replace(MECHANISM, operating_speeds=(28.0,))
    found = flexmech.campbell(running, np.linspace(20.0, 36.0, 5), orders=[9, 10], **SLOW)
    first, avoid = found.summary().answer
    assert first.startswith("28 rad/s is critical: order 10 meets f1 at ")
    assert avoid.startswith("Avoid ")


def test_the_lowest_of_several_orders_that_meet_a_branch_is_named(clear: CampbellDiagram):
    """At a slow speed orders lie closer to each other than the band is broad."""
    slow = clear.dataset.assign_attrs(operating_speeds="0.5")
    bands, _ = band_at(slow, 0.5, 0)
    met = [order for order in range(1, 2000) if bands[0] <= order * 0.5 / (2 * math.pi) <= bands[2]]
    assert len(met) > 1
    (first, _) = CampbellDiagram(slow).summary().answer
    assert f"; the lowest order that meets f1 there is {met[0]}, at " in first


def test_ranges_that_the_diagram_cuts_have_no_error_and_say_so():
    running = replace(MECHANISM, operating_speeds=(28.0, 29.0, 31.5))
    found = flexmech.campbell(running, np.linspace(28.8, 32.0, 4), orders=[9, 10], **SLOW)
    said = found.summary()
    cut = [one for one in critical_ranges(found.dataset) if any(one.is_cut)]
    assert len(cut) == 2
    for one in cut:
        of = f"order {one.order}, branch {one.branch}"
        errors = [number.error for number in said.numbers if number.of == of]
        assert [math.isnan(error) for error in errors] == list(one.is_cut)
    # 28 rad/s is not in the diagram.
    critical, also, avoid = said.answer
    assert " to 32 or more rad/s; order 10 meets f2 " in critical
    assert also.startswith("29 rad/s is critical: order 10 meets f1 at 28.8 or less to ")
    assert avoid.startswith("Avoid 28.8 or less to ")
    assert " to 32 or more rad/s: there orders 9 and 10 of the crank meet " in avoid


def test_speeds_to_avoid_say_which_range_is_clear():
    running = replace(MECHANISM, operating_speeds=(1.0, 28.5, 31.5))
    found = flexmech.campbell(running, np.linspace(0.0, 33.0, 6), orders=[9, 10], **SLOW)
    _, others, avoid = found.summary().answer
    assert others == "Of the other operating speeds 28.5 rad/s is critical; 1 rad/s is clear."
    lowest = min(one.start for one in critical_ranges(found.dataset))
    clear = re.search(r"widest range that is clear is 0 to (\S+) rad/s", avoid)
    assert float(clear.group(1)) == pytest.approx(lowest, abs=0.01)
    # All speeds of this diagram are in one range.
    short = flexmech.campbell(MECHANISM, np.linspace(28.5, 29.0, 4), orders=[10], **SLOW)
    assert short.summary().answer == (
        "Avoid 28.5 or less to 29 or more rad/s: there order 10 of the crank meets a frequency; no "
        "speed of the diagram is clear.",
    )


def test_a_run_tells_what_it_holds(response: Response):
    said = response.summary()
    numbers = {(one.name, one.of): one for one in said.numbers}
    peaks = response.peaks().isel(engine=0)
    bent = str(peaks["deflection"].idxmax("link").item())
    number = numbers["peak_deflection", bent]
    assert number.value == 1e3 * float(peaks["deflection"].max())
    assert 0 < number.error < 0.01 * number.value
    assert said.answer[0].startswith(f"The {bent} bends by at most {number}, at ")
    stress = float(peaks["stress"].sel(link="coupler"))
    assert stress == pytest.approx(68.9e9 * float(peaks["strain"].sel(link="coupler")), rel=0.05)
    (told,) = re.findall(r"the greatest normal stress is (\S+) MPa, in the (\S+),", said.answer[0])
    assert told == (str(numbers["peak_stress", "rocker"]).split()[0], "rocker")
    # At its clamp the crank is bent by the driving torque: T h / (2 I).
    section = MECHANISM.sections["crank"]
    torque = float(peaks["driving_torque"])
    by_hand = torque * 4.24e-3 / 2 / (section.bending_stiffness / 68.9e9)
    assert float(peaks["stress"].sel(link="crank")) == pytest.approx(by_hand, rel=0.02)
    assert "reference engine alone ran" in said.trust


def test_cards_have_the_numbers_of_the_results(clear: CampbellDiagram, response: Response):
    critical, bending, force, torque = cards(Results.of([clear, response]))
    assert (critical.question, critical.value) == ("Critical speeds", "none")
    assert critical.lines[0] == clear.summary().answer[0]
    numbers = {(one.name, one.of): one for one in response.summary().numbers}
    assert torque.value == str(numbers["peak_driving_torque", ""])
    assert torque.lines == ("At 20 rad/s, the greatest operating speed.",)
    assert bending.value in {str(one) for key, one in numbers.items() if "deflection" in key[0]}
    assert force.value in {str(one) for key, one in numbers.items() if "force" in key[0]}


def test_a_card_without_a_result_names_the_command(response: Response):
    critical, *_ = cards(Results.of(response))
    assert critical.value == "-"
    assert "flexmech campbell" in critical.lines[-1]


def test_only_differences_that_matter_are_warned_of():
    assert not EngineDifference(1.8e-5, 1e-6).worth_a_warning
    assert not EngineDifference(0.5, 0.6).worth_a_warning
    assert EngineDifference(0.02, 0.01).worth_a_warning
    assert EngineDifference(math.nan, math.nan).worth_a_warning
    names = ["reference", "exudyn"]
    small = EngineDifference(1.8e-5, 1e-6)
    assert trust_line(names, 1e-6, small).startswith("numbers are known to 0.0018 %")


def test_a_difference_that_errors_explain_hides_none_that_they_do_not(response: Response):
    """A coupler that hardly bends may differ by 2 %, within its error, and the torque by less."""
    data = xr.concat([response.dataset] * 2, "engine", data_vars="minimal")
    data = data.assign_coords(engine=["reference", "exudyn"]).copy(deep=True)
    for name in data:
        if "_error_of_" in str(name):
            data[name][:] = 1e-5
    data["deflection"][0] *= 1.02
    data["step_error_of_deflection"][:] = 0.03
    data["peak_driving_torque"][0] *= 1.0004
    said = Response(data).summary()
    assert said.trust.endswith(
        "reference and exudyn differ by 0.04 % in the peak driving torque, more than their errors "
        "of 0.004 % explain"
    )
    assert not said.warnings
    data["peak_driving_torque"][0] *= 1.05
    (warned,) = Response(data).summary().warnings
    assert warned.startswith("engines: peaks of these joint forces differ by ")
