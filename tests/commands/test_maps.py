"""``flexmech campbell`` and ``stability``: speeds to avoid and speeds that shake themselves up."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import flexmech
from tests.support.journeys import Journey, tells

ALUMINIUM = "models/aluminium_fourbar.toml"
ORDERS = ("--speeds", "20:36:4", "--orders", "9,10", "--angles", "0:330:30", "--modes", "2")
BANDS = ("--speeds", "87:89:1", "--prestress", "axial", "--elements", "1", "--modes", "2")


@pytest.fixture(scope="module")
def campbell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campbell") / "out"
    return Journey(folder, "campbell", ALUMINIUM, *ORDERS, "--elements", "2", "--no-plots")


def test_campbell_files_hold_what_was_printed_and_load_back(campbell):
    csv = ["campbell.csv", "critical_speeds.csv"]
    assert campbell.ended.files == ["campbell.csv", "campbell.nc", csv[1], "summary.txt"]
    campbell.result()
    found = campbell.table("campbell")
    assert found["crank_speed_rad_s"].reshape(-1, 2)[:, 0].tolist() == [20, 24, 28, 32, 36]
    low, mean, high = (found[f"{name}_Hz"] for name in ("lowest", "mean", "highest"))
    assert ((low < mean) & (mean < high)).all()


def test_at_the_ends_of_a_critical_range_an_order_meets_the_band(campbell):
    """order omega / 2 pi is the highest frequency of the branch at one end, the lowest at the other

    with frequencies between the speeds of the diagram taken linearly.
    """
    bands, found = campbell.table("campbell"), campbell.table("critical_speeds")
    for order, branch, start, stop in zip(
        *(found[name] for name in ("order", "branch", "from_rad_s", "to_rad_s")), strict=True
    ):
        rows = bands["branch"] == branch
        speed = bands["crank_speed_rad_s"][rows]
        for end, edge in ((start, "lowest_Hz"), (stop, "highest_Hz")):
            met = np.interp(end, speed, bands[edge][rows])
            assert order * end / (2 * math.pi) == pytest.approx(met, rel=5e-3)
        of = f"order {order:g}, branch {branch:g}"
        assert campbell.number("critical_speed_from", of) == pytest.approx(start, rel=1e-9)
        assert campbell.number("critical_speed_to", of) == pytest.approx(stop, rel=1e-9)
        assert any(row[1:3] == [branch, order] and tells(str(row[3]), round(start, 1))
                   for row in campbell.rows)  # fmt: skip
    assert tells(campbell.said["answer"][1], round(found["from_rad_s"].min(), 1))
    # At the operating speed of 20 rad/s the first branch is met by none of them.
    at = {name: bands[name][0] for name in ("lowest_Hz", "highest_Hz")}
    assert tells(campbell.said["answer"][0], float(f"{at['lowest_Hz']:.3g}"))
    assert tells(campbell.said["answer"][0], float(f"{at['highest_Hz']:.3g}"))
    assert campbell.number("lowest_frequency_at_operating_speed", "branch 1") == pytest.approx(
        at["lowest_Hz"]
    )


def test_an_operating_speed_in_a_critical_range_is_told_so(aluminium):
    """The end of a range that the diagram cuts is not its own, and has no error."""
    running = replace(aluminium, operating_speeds=(29.0, 31.5))
    few = {"crank_angles": np.radians(np.arange(0, 360, 30)), "modes": 2}
    engine = flexmech.ReferenceEngine(running, 2)
    speeds = np.linspace(28.8, 32.0, 4)
    said = flexmech.campbell(engine, speeds, orders=[9, 10], **few).summary()
    for sentence, speed in zip(said.answer, (31.5, 29.0), strict=False):
        assert tells(sentence, speed)
        assert "critical" in sentence
    errors = {(one.name, one.of): one.error for one in said.numbers}
    cut = [key for key, error in errors.items() if math.isnan(error)]
    assert ("critical_speed_to", "order 10, branch 2") not in cut
    assert ("critical_speed_from", "order 10, branch 1") in cut
    clear = flexmech.campbell(engine, np.linspace(0.0, 21.0, 4), orders=[1, 2], **few).summary()
    assert not [one for one in clear.numbers if one.name.startswith("critical_speed")]


def test_a_campbell_diagram_is_drawn_and_may_show_the_response(command, rough_pictures):
    words = ("--speeds", "20,21", "--orders", "9", "--angles", "0:330:30", "--modes", "1")
    ended = command("campbell", ALUMINIUM, *words, "--elements", "1")
    assert [name for name in ended.files if name.endswith(".png")] == ["campbell.png"]


# --- stability ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def stability(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stability") / "out"
    return Journey(folder, "stability", ALUMINIUM, *BANDS, "--steps", "128", "--no-plots")


def test_stability_files_hold_what_was_printed_and_load_back(stability):
    csv = ["bands.csv", "multipliers.csv", "stability.csv"]
    assert stability.ended.files == [*csv, "stability.nc", "summary.txt"]
    stability.result()


def test_a_speed_in_a_band_has_a_multiplier_beyond_one(stability):
    """Growth rate = ln |multiplier| / time of a turn."""
    growth, bands = stability.table("stability"), stability.table("bands")
    assert growth["crank_speed_rad_s"].tolist() == [87, 88, 89]
    time = 2 * np.pi / growth["crank_speed_rad_s"]
    rate = np.log(growth["multiplier_modulus"]) / time
    np.testing.assert_allclose(growth["growth_rate_1_s"], rate, atol=1e-6)
    for speed, unstable in zip(growth["crank_speed_rad_s"], growth["unstable"], strict=True):
        inside = ((bands["from_rad_s"] <= speed) & (speed <= bands["to_rad_s"])).any()
        assert (unstable == "yes") == inside
    assert tells(
        stability.said["answer"][0], float(f"{bands['largest_growth_rate_1_s'].max():.3g}")
    )
    assert tells(stability.answer, float(f"{100 * bands['closing_damping_ratio'].max():.3g}"))
    found = stability.table("multipliers")
    for speed in growth["crank_speed_rad_s"]:
        largest = found["modulus"][found["crank_speed_rad_s"] == speed].max()
        at = growth["crank_speed_rad_s"] == speed
        assert growth["multiplier_modulus"][at] == pytest.approx(largest, rel=1e-9)


def test_details_are_a_table_of_errors_by_their_causes(stability):
    """The greatest error of an edge is at least its greatest part, and at most the sum of parts."""
    (table,) = stability.said["details"]["tables"]
    assert table["columns"] == ["quantity", "of", "value", "unit", "error"]
    parts = [row for row in table["rows"] if row[0].startswith("error of edges by ")]
    assert [row[0].rpartition(" by ")[2] for row in parts] == ["steps", "moving modes", "mesh"]
    assert {(row[1], row[3]) for row in parts} == {("reference", "rad/s")}
    values = [row[2] for row in parts]
    greatest = np.nanmax(stability.table("bands")["error_rad_s"])
    assert max(values) <= 1.001 * greatest <= 1.002 * sum(values)


@pytest.mark.thorough
def test_enough_damping_closes_all_bands(command, stability):
    ratio = 1.05 * stability.table("bands")["closing_damping_ratio"].max()
    words = (*BANDS, "--steps", "128", "--no-plots", "--damping-ratio", f"{ratio:.6f}")
    ended = command("stability", ALUMINIUM, *words)
    assert ended.exit_code == 0
    assert len(ended.table("bands")["kind"]) == 0
    assert (ended.table("stability")["multiplier_modulus"] < 1).all()


@pytest.mark.thorough
def test_a_second_parameter_is_mapped(command, rough_pictures):
    words = ("--speeds", "87,88", "--against", "damping-ratio", "0:2%:2", *BANDS[2:])
    ended = command("stability", ALUMINIUM, *words)
    found = ended.table("against")
    assert sorted(set(found["damping_ratio"])) == [0.0, 0.01, 0.02]
    assert len(found["damping_ratio"]) == 6
    rates = found["growth_rate_1_s"].reshape(3, 2)
    assert (np.diff(rates, axis=0) < 0).all() or (np.diff(rates, axis=1) < 0).all()
    assert "stability_against.png" in ended.files
