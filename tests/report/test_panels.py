"""Plots of the report hold the numbers of the datasets, each in the unit of its axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr

import flexmech
from tests.report.conftest import OF_THE_FOURBAR, Write
from tests.support import results
from tests.support.report_page import Page

# The page of all results takes twenty seconds.
pytestmark = pytest.mark.thorough

Values = Callable[[xr.Dataset], xr.DataArray]
REFERENCE, EXUDYN = {"engine": "reference"}, {"engine": "exudyn"}


class Shown(NamedTuple):
    """A trace of a plot, and the values of a dataset that it must hold."""

    plot: str
    axis: str
    trace: str
    values: Values
    when: dict[str, str] = {}  # noqa: RUF012


def size(name: str, **place: object) -> Values:
    """Magnitude of a vector."""
    return lambda d: np.hypot(*(d[name].sel(component=c, **place) for c in ("x", "y")))


def worst_station(data: xr.Dataset, link: str) -> int:
    """Number of the place of a link that its margin is of."""
    [place] = data["margin_position"].values[data["margin_part"].values == link]
    return int(np.nanargmin(np.abs(data["position"].sel(link=link).values - place)))


def last_turn(values: Values) -> Values:
    """Values of the last of two turns; where it begins, at 0 degrees, the page shows its end."""
    return lambda d: values(d).isel(time=slice(d.sizes["time"] // 2 + 1, None))


def receptance(data: xr.Dataset) -> xr.DataArray:
    return np.hypot(data["receptance_real"], data["receptance_imag"])[1]


SHOWN: dict[Callable[[], flexmech.Result], list[Shown]] = {
    results.check: [
        Shown(
            "transmission-angle",
            "Transmission angle (deg)",
            "",
            lambda d: np.degrees(d["transmission_angle"]),
        )
    ],
    results.frequencies: [
        Shown("frequency", "Mode 3", "20 rad/s", lambda d: d["frequency"][0, 2, :, 2], REFERENCE),
        Shown("frequency", "Mode 1", "0 rad/s", lambda d: d["frequency"][1, 0, :, 0], EXUDYN),
        Shown(
            "damping-ratio",
            "10 rad/s",
            "mode 2",
            lambda d: 100 * d["damping_ratio"][0, 1, :, 1],
            REFERENCE,
        ),
    ],
    results.campbell: [
        Shown("campbell", "Natural frequency (Hz)", "", lambda d: d["lowest_frequency"][0, :, 1]),
        Shown(
            "campbell", "Natural frequency (Hz)", "branch 2", lambda d: d["mean_frequency"][0, :, 1]
        ),
        Shown("campbell", "Natural frequency (Hz)", "", lambda d: d["highest_frequency"][0, :, 1]),
    ],
    results.response: [
        Shown(
            "deflection",
            "Coupler middle<br>deflection (mm)",
            "exudyn",
            last_turn(lambda d: 1e3 * d["deflection"].sel(link="coupler", engine="exudyn")),
            EXUDYN | {"speed": "20 rad/s"},
        ),
        Shown(
            "forces",
            "Force<br>at A (N)",
            "reference",
            last_turn(size("joint_force", joint="A", engine="reference")),
            REFERENCE | {"speed": "20 rad/s"},
        ),
        Shown(
            "forces",
            "Driving<br>torque (N m)",
            "rigid links",
            last_turn(lambda d: d["rigid_driving_torque"]),
            REFERENCE | {"speed": "20 rad/s"},
        ),
    ],
    results.response_to_a_law: [
        Shown(
            "residual",
            "Coupler middle<br>deflection (mm)",
            "reference",
            lambda d: 1e3 * d["deflection"][0].sel(link="coupler")[d["time"] >= results.LAW.time],
        ),
        Shown(
            "shaped",
            "Coupler middle<br>deflection (mm)",
            "ZV shaper",
            lambda d: 1e3 * d["shaped_deflection"][0].sel(link="coupler"),
        ),
    ],
    results.response_under_a_motor: [
        Shown("motor", "Motor<br>current (A)", "reference", lambda d: d["motor_current"][0]),
        Shown(
            "motor",
            "Crank<br>speed (rad/s)",
            "reference",
            lambda d: d["crank_speed_over_time"] + d["crank_speed_fluctuation"][0],
        ),
    ],
    results.hammer: [
        Shown("hammer-frf", "Receptance (m/N)", "measured (H1), 96.9 deg", receptance),
        Shown("hammer-frf", "Coherence", "", lambda d: d["coherence"][1]),
    ],
    results.running_hammer: [
        Shown(
            "harmonic-response",
            "|H₊₁| (m/N)",
            "running linkage",
            lambda d: np.hypot(d["receptance_real"], d["receptance_imag"]).sel(order=1),
        )
    ],
    results.comparison: [
        Shown(
            "comparison", "Natural frequency<br>(Hz)", "mode 1, measured", lambda d: d["measured"]
        ),
        Shown("comparison", "Residual (Hz)", "", lambda d: d["residual"]),
    ],
    results.kinematics: [
        Shown(
            "link-motion",
            "Angular acceleration<br>(rad/s²)",
            "rocker",
            lambda d: d["angular_acceleration"].sel(link="rocker"),
        ),
        Shown(
            "point-motion-B",
            "Position (mm)",
            "along y",
            lambda d: 1e3 * d["point_position"].sel(point="B", component="y"),
        ),
        Shown("joint-forces", "B", "magnitude", size("joint_force", joint="B")),
        Shown(
            "joint-forces",
            "B",
            "12 lumped masses",
            lambda d: d["lumped_joint_force"].sel(joint="B", component="x"),
        ),
        Shown("drive", "Torque (N m)", "", lambda d: d["driving_torque"]),
    ],
    results.balance: [
        Shown("balance", "Shaking force (N)", "balanced", size("shaking_force", state="balanced")),
        Shown(
            "balance",
            "Shaking force (N)",
            "as given, elastic links",
            size("elastic_shaking_force", state="as given"),
        ),
        Shown(
            "balance",
            "Shaking moment about<br>(0, 0) mm (N m)",
            "balanced",
            lambda d: d["shaking_moment"].sel(state="balanced"),
        ),
    ],
    results.sweep: [
        Shown("designs-1", "f1 (Hz)", "keeps every limit", lambda d: d["f1"][d["within"].values]),
        Shown("designs-2", "mass (kg)", "beyond a limit", lambda d: d["mass"][~d["within"].values]),
    ],
    results.uncertainty: [
        Shown(
            "frequency-bands",
            "Mode 2",
            "median",
            lambda d: d["frequency_percentile"].sel(percentile=50.0, mode=2),
        ),
    ],
    results.optimum: [
        Shown("pareto", "f1 (Hz), max", "design", lambda d: d.sortby("mass")["f1"]),
    ],
    results.strength: [
        Shown(
            "internal-forces",
            "Bending moment M<br>(N m)",
            "crank, 0 mm",
            lambda d: d["bending_moment"].sel(link="crank")[0, :, 0],
        ),
        Shown(
            "internal-forces",
            "Axial force N (N)",
            "coupler",
            lambda d: d["axial_force"].sel(link="coupler")[0, :, worst_station(d, "coupler")],
        ),
    ],
    results.sections: [
        Shown(
            "section-2",
            "σ by M (MPa)",  # noqa: RUF001
            "without coupling",
            lambda d: (
                1e-6
                * results.sections()
                .profile("coupler")["normal_stress"]
                .sel(load="bending_moment", coupling="without")
                .stack(all=("layer", "point"))
            ),
        )
    ],
    results.moisture: [
        Shown("uptake", "Coupler: uptake", "finite volumes", lambda d: d["uptake"][0]),
        Shown("profiles", "Coupler: through", "30 d", lambda d: 100 * d["profile"][0, -1]),
    ],
    results.coupler_paths: [
        Shown("coupler", "y (mm)", "dry", lambda d: 1e3 * d["position"][0, :, 1]),
    ],
    results.frequencies_in_two_states: [
        Shown(
            "frequency",
            "Mode 2",
            "0 rad/s",
            lambda d: d["frequency"][1, 0, 0, :, 1],
            {"state": "+60 K, 4 % moisture"},
        )
    ],
}


@pytest.fixture(scope="session")
def pages(fourbar: Page, write: Write) -> Callable[[Callable[[], flexmech.Result]], Page]:
    """The page that shows a result."""

    def page_of(make: Callable[[], flexmech.Result]) -> Page:
        return fourbar if make in OF_THE_FOURBAR else write(make())

    return page_of


@pytest.mark.parametrize("make", SHOWN, ids=lambda make: make.__name__)
def test_traces_are_the_numbers_of_the_dataset(make: Callable[[], flexmech.Result], pages) -> None:
    page, data = pages(make), make().dataset
    for plot, axis, name, values, when in SHOWN[make]:
        wanted = values(data).values
        traces = [
            trace
            for trace in page.traces(plot)
            if trace.axis.startswith(axis) and trace.name.startswith(name)
            if when.items() <= trace.when.items()
        ]
        assert traces, (plot, axis, name)
        # Numbers of the page have 4 bytes; between layers of a section there are none.
        shown = [trace.y[np.isfinite(trace.y)][-len(wanted) :] for trace in traces]
        close = [
            0 <= len(trace.y) - len(y) <= 8
            and len(y) == len(wanted)
            and np.allclose(y, wanted, rtol=1e-6)
            for trace, y in zip(traces, shown, strict=True)
        ]
        assert any(close), (plot, axis, name)


def test_growth_and_bands_are_those_of_the_map(fourbar: Page) -> None:
    data, traces = results.stability().dataset, fourbar.traces("stability")
    for number, engine in enumerate(data["engine"].values):
        rate, modulus = [trace for trace in traces if trace.name.startswith(engine)]
        rates = dict(zip(rate.x.round(3), rate.y, strict=True))
        sizes = dict(zip(modulus.x.round(3), modulus.y, strict=True))
        growth = float(data["growth_rate"][number, 1])
        assert rates[88.0] == pytest.approx(growth, rel=1e-6)
        assert sizes[88.0] == pytest.approx(np.exp(growth * 2 * np.pi / 88.0), rel=1e-6)
    band, _ = [trace for trace in traces if trace.name == "twice a frequency"]
    assert (band.x.min(), band.x.max()) == pytest.approx(
        (float(data["band_lower"][0]), float(data["band_upper"][0]))
    )


def test_what_strength_uses_is_the_inverse_of_its_load_factor(pages) -> None:
    data = results.strength().dataset
    worst = {trace.name: trace.y.max() for trace in pages(results.strength).traces("strength-used")}
    assert worst.pop("fails") == 100.0
    for part, factor in zip(data["margin_part"].values, data["margin_load_factor"], strict=True):
        assert worst.pop(str(part)) == pytest.approx(100 / float(factor), rel=1e-6)
    assert not worst


def test_distributions_have_unit_area_and_intervals_lie_about_the_shares(fourbar: Page) -> None:
    data = results.uncertainty().dataset
    *lines, _, bars = fourbar.traces("distribution-f1")
    assert np.trapezoid(bars.y, bars.x) == pytest.approx(1.0, rel=1e-5)
    ends = float(data["f1"].min()), float(data["f1"].max())
    assert (bars.x.min(), bars.x.max()) == pytest.approx(ends)
    places = {(trace.name, float(trace.x[0])) for trace in lines}
    median = np.float32(data["p50"].sel(output="f1"))
    assert {("limit", 44.0), ("median", float(median))} <= places
    shares = [t for t in fourbar.traces("sensitivity") if t.axis == "Share in f1"]
    (total,) = [t.x for t in shares if t.name == "total"]
    np.testing.assert_allclose(total, data["total"].sel(output="f1"), rtol=1e-6)
    _, interval = [t.x.reshape(2, 3) for t in shares if len(t.x) == 6]
    ends = data[["total_low", "total_high"]].sel(output="f1").to_dataarray().values
    np.testing.assert_allclose(interval[:, :2], ends.T, rtol=1e-6)


def test_readings_are_the_numbers_of_the_maps_and_runs(fourbar: Page) -> None:
    """Readings beside the linkage at a crank angle."""
    data = results.frequencies().dataset
    chosen = {"engine": "exudyn", "state": "dry", "speed": "20 rad/s"}
    readings = {
        (one["group"], one["label"]): one
        for one in fourbar.content["readings"]
        if one["when"] == chosen
    }
    mode = readings["Natural frequency", "mode 2"]
    np.testing.assert_allclose(
        fourbar.array(mode["value"]), data["frequency"][1, 2, :, 1], rtol=1e-6
    )
    np.testing.assert_allclose(
        fourbar.array(mode["angle"]), np.degrees(data["crank_angle"]), atol=1e-4
    )
    assert mode["unit"] == "Hz"
    worst = float(
        data["discretisation_error"][1, 2, :, 1].max() * data["frequency"][1, 2, :, 1].max()
    )
    assert 0.3 * worst < mode["error"] < 3 * worst
    force = readings["Joint force", "A"]
    run = size("joint_force", joint="A", engine="exudyn")(results.response().dataset)
    assert fourbar.array(force["value"]).max() == pytest.approx(float(run[120:].max()), rel=1e-6)


def test_the_linkage_turns_by_its_rigid_motion_and_shapes_are_of_unit_size(fourbar: Page) -> None:
    drawn = fourbar.content["linkage"]
    turn = fourbar.array(drawn["links"][0]["turn"])
    origin = fourbar.array(drawn["links"][1]["origin"]).reshape(-1, 2)
    along = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    np.testing.assert_allclose(origin, 0.102 * along, atol=1e-6)
    shape = drawn["shapes"][0]
    angle = fourbar.array(shape["angle"])
    values = fourbar.array(shape["values"]).reshape(len(angle), 3, shape["stations"], 2)
    assert angle[[0, -1]].tolist() == [0.0, 360.0]
    assert np.hypot(*np.moveaxis(values, -1, 0)).max() == pytest.approx(1.0, rel=1e-6)
    assert np.abs(values[:, 0, 0]).max() < 1e-6, "the crank is clamped"
    follows = np.sum(values[1:] * values[:-1], axis=(1, 2, 3))
    assert np.all(follows > 0), "no shape turns its sign from angle to angle"


def test_each_panel_says_what_it_shows_and_from_where(fourbar: Page) -> None:
    """All of them, in the order of the page."""
    assert fourbar.panels == [
        "frequencies",
        "damping",
        "campbell",
        "stability",
        "running-hammer",
        "response",
        "spectrum",
        "residual",
        "motor",
        "hammer",
        "comparison",
        "kinematics",
        "balance",
        "mechanism",
        "optimum",
        "designs",
        "uncertainty",
        "provenance",
    ]
    for make in (results.campbell, results.stability, results.kinematics, results.hammer):
        for line in make().summary().answer:
            assert line[:30] in fourbar.text, line
    for plot in fourbar.content["plots"]:
        assert plot["text"], plot["name"]
        for trace in fourbar.traces(plot["name"]):
            assert len(trace.x) == len(trace.y) > 0
