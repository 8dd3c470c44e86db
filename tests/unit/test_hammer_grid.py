"""The roving impact, universal files and the stabilisation chart of a hammer test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech import HammerRequest, LinkPoint, hammer_test, plots
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.measurement import grid_points
from flexmech.cli.application import app
from flexmech.errors import InputError
from flexmech.example_models import example_model
from flexmech.measured_data import read_uff, read_uff_record
from flexmech.modal_testing import complexity_factor, identify, mac
from tests.support.figure_checks import check_layout
from tests.support.roved_hammer import (
    ANGLES,
    POINTS_A_LINK,
    damped_engine,
    roved_dataset,
    roved_test,
)

THREE_MODES = slice(0, 3)
LINKS = ["crank", "coupler", "rocker"]


def complex_of(data, name):
    return data[f"{name}_real"].values + 1j * data[f"{name}_imag"].values


def test_first_modes_are_as_near_as_asked_for():
    """Issue: frequencies within 0.1 %, damping within 5 %, without noise."""
    data = roved_dataset().isel(mode=THREE_MODES)
    np.testing.assert_allclose(data["identified_frequency"], data["eigen_frequency"], rtol=1e-3)
    np.testing.assert_allclose(
        data["identified_damping_ratio"], data["eigen_damping_ratio"], rtol=0.05
    )


def test_shapes_are_those_of_the_eigen_model():
    data = roved_dataset().isel(mode=THREE_MODES)
    assert (data["mac"] > 0.9999).all()
    found, eigen = complex_of(data, "shape"), complex_of(data, "eigen_shape")
    assert abs(found - eigen).max() < 2e-3
    np.testing.assert_allclose(abs(found).max(axis=1), 1.0)
    np.testing.assert_allclose(
        data["complexity_factor"], data["eigen_complexity_factor"], rtol=0.1, atol=1e-6
    )
    for angle in range(len(ANGLES)):
        np.testing.assert_allclose(np.diag(mac(found[angle], eigen[angle])), data["mac"][angle])
        np.testing.assert_allclose(
            complexity_factor(found[angle]), data["complexity_factor"][angle]
        )
        # Other modes have other shapes: the criterion tells them apart.
        between = mac(found[angle], eigen[angle])
        assert (between[~np.eye(3, dtype=bool)] < 0.6).all()


def test_shapes_are_what_links_do_at_the_points_of_the_grid():
    """Against a second way: the receptance of each point by an impact of its own."""
    data = roved_dataset()
    place = 4  # middle of the coupler, where the test is hit too
    assert (data["point_link"][place], data["point_fraction"][place]) == ("coupler", 0.5)
    own = complex_of(data, "unwindowed_receptance")
    np.testing.assert_allclose(complex_of(data, "grid_receptance")[:, place], own, rtol=1e-9)
    points = grid_points(damped_engine(), POINTS_A_LINK)
    assert [str(point) for point in points[:3]] == ["crank:0.166667", "crank:0.5", "crank:0.833333"]
    # Against the eigen model's receptance from each point to the middle of the coupler.
    locked = LockedLinkage.at(damped_engine(), float(ANGLES[1]), "none")
    seen = locked.rows([points[place]], "transverse")
    rows, lines = locked.rows(points, "transverse"), data["frequency"].values
    exact = locked.modes.receptance(seen, rows, lines)[:, 0].T
    found = complex_of(data, "grid_receptance")[1]
    assert abs(found - exact).max() < 0.01 * abs(exact).max()
    assert np.all(abs(found - exact).max(axis=1) < 0.01 * abs(exact).max(axis=1))


def test_tables_and_files(tmp_path):
    result = roved_test()
    shapes = result.tables()["shapes"]
    assert list(shapes.columns) == [
        "crank_angle_deg",
        "mode",
        "link",
        "fraction",
        "shape_real",
        "shape_imag",
        "eigen_shape_real",
        "eigen_shape_imag",
        "complexity_factor",
    ]
    first = shapes[(shapes["mode"] == 1) & (shapes["crank_angle_deg"] < 50)]
    assert first["link"].tolist() == [name for name in LINKS for _ in range(POINTS_A_LINK)]
    assert result.identified()["mac"].iloc[0] == pytest.approx(1.0, abs=1e-4)
    files = {path.name for path in result.save(tmp_path)}
    assert files == {"frf.csv", "identified.csv", "shapes.csv", "hammer.nc"}
    again = type(result).load(tmp_path / "hammer.nc")
    assert again.tables()["shapes"].equals(shapes)
    assert again.figures().keys() == result.figures().keys() >= {"stabilisation", "shapes"}


def test_without_a_grid_there_are_no_shapes():
    one = roved_dataset().drop_dims("point").drop_dims("pole")
    result = type(roved_test())(one)
    assert "shapes" not in result.tables()
    with pytest.raises(InputError, match="--grid N"):
        result.shapes()
    with pytest.raises(InputError, match="--grid N"):
        plots.plot_impact_shapes(one)
    with pytest.raises(InputError, match=r"flexmech\[modal-test\]"):
        plots.plot_stabilisation(one)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return roved_test().save_uff(tmp_path_factory.mktemp("uff"))


def test_one_universal_file_a_crank_angle_holds_records_responses_and_modes(files):
    assert [path.name for path in files] == ["hammer_20deg.uff", "hammer_96.9deg.uff"]
    data, read = roved_dataset().isel(crank_angle=1), read_uff(files[1])
    by_name = {function.name: function for function in read.functions}
    for number in (1, 2):
        for name, unit in (("force", "N"), ("response", "m")):
            record = by_name[f"{name}, average {number}"]
            assert record.unit == unit
            np.testing.assert_allclose(
                record.values, data[name].values[number - 1], rtol=1e-11, atol=1e-99
            )
    receptance = by_name["receptance"]
    assert (receptance.unit, receptance.kind) == ("m/N", "frequency response")
    for part in ("real", "imag"):
        np.testing.assert_allclose(
            getattr(receptance.values, part), data[f"unwindowed_receptance_{part}"], rtol=1e-11
        )
    np.testing.assert_allclose(by_name["coherence"].values, data["coherence"], rtol=1e-11)
    assert sum(name.startswith("receptance, impact at") for name in by_name) == 9
    assert len(read.modes) == int(np.isfinite(data["identified_frequency"]).sum())
    for mode in read.modes:
        omega = 2 * np.pi * float(data["identified_frequency"].sel(mode=mode.number))
        ratio = float(data["identified_damping_ratio"].sel(mode=mode.number))
        assert abs(mode.pole) == pytest.approx(omega, rel=1e-5)
        assert -mode.pole.real / abs(mode.pole) == pytest.approx(ratio, rel=1e-5)


def test_nodes_and_shapes_lie_on_the_linkage(files):
    data, read = roved_dataset().isel(crank_angle=1), read_uff(files[1])
    place = dict(zip(read.nodes.label.tolist(), read.nodes.position, strict=True))
    lengths = [length.item() for length in data["link_length"]]
    for link, trace in enumerate(read.traces):
        ends = place[trace.nodes[-1]] - place[trace.nodes[0]]
        assert np.hypot(*ends[:2]) == pytest.approx(lengths[link], rel=1e-5)
        assert trace.name == LINKS[link]
    # The end of the crank is the beginning of the coupler.
    np.testing.assert_allclose(place[read.traces[0].nodes[-1]], place[read.traces[1].nodes[0]])
    angle = data["link_angle"].values
    assert [frame.angle for frame in read.frames] == pytest.approx(angle.tolist(), abs=2e-5)
    shape = complex_of(data, "shape")[:, 0]
    moved = read.modes[0].shape
    across = np.repeat(np.stack([-np.sin(angle), np.cos(angle)], axis=1), 3, axis=0)
    np.testing.assert_allclose(moved[:, :2], shape[:, None] * across, atol=1e-5)
    np.testing.assert_allclose(np.sum(moved[:, :2] * across, axis=1), shape, atol=1e-5)


def test_what_a_window_adds_is_taken_off_what_is_written(tmp_path):
    """From the file alone, without a word on the window, the eigen model's damping is found."""
    length = 0.3 * roved_dataset().attrs["duration"]
    request = HammerRequest(ANGLES[1:], modes=3, duration=length)
    result = hammer_test(damped_engine(), request)
    data = result.dataset.isel(crank_angle=0)
    rate, lines = data.attrs["window_decay_rate"], data["frequency"].values
    eigen = data["eigen_damping_ratio"].values[:2]
    assert rate / (2 * np.pi * data["eigen_frequency"].values[0]) > 0.5 * eigen[0]
    locked = LockedLinkage.at(damped_engine(), float(ANGLES[1]), "none")
    row = locked.rows([LinkPoint("coupler", 0.5)], "transverse")
    exact = locked.modes.receptance(row, row, lines)[:, 0, 0]
    frf = result.frf()
    written = frf["receptance_real_m_N"].to_numpy() + 1j * frf["receptance_imag_m_N"].to_numpy()
    assert abs(written - exact).max() < 0.01 * abs(exact).max()
    assert abs(complex_of(data, "receptance") - exact).max() > 0.2 * abs(exact).max()
    (file,) = result.save_uff(tmp_path)
    receptance = next(each for each in read_uff(file).functions if each.name == "receptance")
    assert receptance.remark == f"H1, exponential window {rate:.6g} 1/s taken off"
    record = read_uff_record(file)
    modes = identify(record.position, record.quantity("receptance").values, count=2)
    np.testing.assert_allclose(modes.damping_ratio, eigen, rtol=0.01)


def test_figures_show_the_dataset():
    data = roved_dataset()
    chart = plots.plot_stabilisation(data)
    check_layout(chart)
    first = data.isel(crank_angle=0)
    stable = first["chart_state"].values == "stable"
    dots = next(line for line in chart.axes[0].lines if len(line.get_xdata()) == stable.sum())
    np.testing.assert_array_equal(dots.get_xdata(), first["chart_frequency"].values[stable])
    np.testing.assert_array_equal(dots.get_ydata(), first["chart_order"].values[stable])
    triangles = next(line for line in chart.axes[0].lines if line.get_marker() == "^")
    np.testing.assert_array_equal(triangles.get_xdata(), first["identified_frequency"].values)
    shapes = plots.plot_impact_shapes(data)
    check_layout(shapes)
    drawn = shapes.axes[0].lines[-1]
    np.testing.assert_array_equal(drawn.get_ydata(), first["shape_real"].values[:, 0])
    assert "MAC 1.0000" in shapes.axes[0].get_title("left")


def test_grid_along_the_links():
    """Coupler and rocker of the composite four-bar stretch and bend together."""
    request = HammerRequest(
        ANGLES[1:],
        impact=LinkPoint("crank", 0.5),
        response=LinkPoint("rocker", 0.5),
        direction="axial",
        modes=1,
        grid=2,
    )
    data = hammer_test(damped_engine(), request).dataset
    assert float(data["mac"][0, 0]) > 0.999
    with pytest.raises(InputError, match="grid"):
        replace(request, grid=1)


MODEL = str(example_model("composite_fourbar"))
COMMAND = [
    *("hammer", MODEL, "--angle", "96.9", "--damping-ratio", "5%"),
    *("--engine", "reference", "--elements", "1", "--no-plots"),
]


def test_the_command_writes_shapes_and_universal_files(tmp_path):
    ran = CliRunner().invoke(
        app, [*COMMAND, "--grid", "2", "--uff", "--out", str(tmp_path / "results")]
    )
    assert ran.exit_code == 0, ran.output
    names = {path.name for path in (tmp_path / "results").iterdir()}
    assert names == {
        "frf.csv",
        "identified.csv",
        "shapes.csv",
        "hammer.nc",
        "hammer_96.9deg.uff",
        "summary.txt",
    }
    assert len(read_uff(tmp_path / "results" / "hammer_96.9deg.uff").traces) == 3


def test_without_pyuff_nothing_is_computed(monkeypatch, tmp_path):
    monkeypatch.setattr("flexmech.measured_data.uff_files.find_spec", lambda name: None)
    ran = CliRunner().invoke(app, [*COMMAND, "--uff", "--out", str(tmp_path / "results")])
    assert ran.exit_code == 2
    assert not (tmp_path / "results").exists()
    message = " ".join(ran.output.split())
    assert "--uff: a universal file needs pyuff" in message
    assert 'pip install "flexmech[modal-test]"' in message
