"""The content of a figure can be chosen; files and notebooks hold it with its letters."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from PIL import Image

from flexmech import InputError, plots
from tests.support import results
from tests.support.figure_checks import legend_texts, panels
from tests.support.figures import figure_of


def test_chosen_takes_the_part_of_a_dataset_in_the_order_asked_for() -> None:
    data = results.frequencies().dataset
    one = plots.chosen(data, engine="exudyn", modes=2, speeds=10)
    xr.testing.assert_identical(one, data.isel(engine=[1], mode=[1], crank_speed=[1]))
    several = plots.chosen(data, modes=(4, 1), speeds=np.array([20.0, 0.0]))
    assert several["mode"].values.tolist() == [4, 1]
    assert several["crank_speed"].values.tolist() == [20.0, 0.0]
    assert plots.chosen(results.response().dataset, links="coupler").sizes["link"] == 1
    xr.testing.assert_identical(plots.chosen(data), data)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({"engine": "adams"}, "engine: .* no 'adams'; choose from reference, exudyn"),
        ({"modes": [1, 9]}, "modes: .* no 9; choose from 1, 2, 3, 4"),
        ({"speeds": 15.0}, "speeds: .* no 15.0; choose from 0, 10, 20 rad/s"),
        ({"links": "spring"}, "links: .* no 'spring'; choose from crank, coupler, rocker"),
        ({"speeds": []}, "speeds: nothing is chosen; choose from 0, 10, 20 rad/s"),
        ({"orders": 1}, "orders: this result has none to choose from"),
    ],
)
def test_what_is_not_there_is_refused_with_what_is(choice: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        plots.chosen(results.frequencies().dataset, **choice)  # type: ignore[arg-type]


def test_a_chosen_mode_stands_in_a_panel_among_others_of_the_user() -> None:
    figure = Figure()
    left, right = figure.subplots(1, 2)
    right.plot([1, 2], [3, 4])
    data = results.frequencies().dataset
    assert results.frequencies().plot(modes=3, ax=left) is figure
    assert left.get_title("left") == "Mode 3"
    assert (left.get_xlabel(), left.get_ylabel()) == ("Crank angle (deg)", "Frequency (Hz)")
    np.testing.assert_array_equal(left.lines[0].get_ydata(), data["frequency"][0, 0, :, 2])
    assert len(right.lines) == 1
    with pytest.raises(InputError, match=r"choose one mode \(modes=1\), which leaves one panel"):
        plots.plot_frequencies(data, ax=left)
    with pytest.raises(InputError, match="ax: must be Axes of matplotlib"):
        plots.plot_frequencies(data, ax="left")


def test_letters_in_axes_of_the_user_are_those_of_his_settings() -> None:
    """Letters of the legend and of the second axis too."""
    settings = {"font.family": "DejaVu Serif", "legend.fontsize": 15.0, "xtick.labelsize": 13.0}
    data = results.response().dataset
    with mpl.rc_context(settings):
        axes = list(Figure().subplots(4, 1))
        plots.plot_response(data, ax=axes[:3])
        plots.plot_campbell(results.campbell().dataset, ax=axes[3])
        texts = axes[0].get_legend().get_texts()
        (top,), labels = axes[0].child_axes, axes[3].texts
        ticks = top.get_xticklabels()
    assert labels
    for shown, size in ((texts, 15.0), (ticks, 13.0), (labels, 13.0)):
        assert {text.get_fontsize() for text in shown} == {size}
        assert {text.get_fontname() for text in shown} == {"DejaVu Serif"}


def test_veering_is_marked_where_it_was_flagged() -> None:
    flags = results.frequencies().dataset["veering"].isel(engine=0).any(("crank_speed", "mode"))
    starts = np.diff(flags.values.astype(int), prepend=0) == 1
    figure = figure_of(plots.plot_frequencies)
    assert ("veering" in legend_texts(figure)) == bool(flags.any())
    assert any(axes.patches for axes in panels(figure)) == bool(starts.any())


def test_deflections_too_small_for_millimetres_are_in_a_smaller_unit() -> None:
    data = plots.chosen(results.response().dataset, links="coupler")
    tiny = data.assign(deflection=1e-4 * data["deflection"])
    axes = panels(plots.plot_response(tiny))[0]
    assert axes.get_ylabel() == "Coupler middle\ndeflection (µm)"
    drawn = [np.asarray(line.get_ydata()) for line in axes.lines if len(line.get_xdata()) > 2]
    np.testing.assert_allclose(drawn[0], 1e6 * tiny["deflection"][0, :, 0])


@pytest.mark.parametrize("plot", [plots.plot_response, plots.plot_forces], ids=lambda p: p.__name__)
def test_a_periodic_motion_is_drawn_over_one_turn(plot) -> None:  # type: ignore[no-untyped-def]
    """One of two turns is drawn; other runs are drawn whole."""
    data = results.response().dataset
    for start, turns in (("periodic", 1.0), ("rigid", 2.0)):
        axes = panels(plot(data.assign_attrs(start=start)))[0]
        end = max(float(line.get_xdata()[-1]) for line in axes.lines if len(line.get_xdata()) > 2)
        assert end == pytest.approx(turns * 2 * np.pi / 20.0)
        assert axes.get_xlim() == pytest.approx((0.0, end))


def test_strain_is_on_a_second_axis_of_the_deflection() -> None:
    data = results.response().dataset
    figure = figure_of(plots.plot_response)
    figure.draw_without_rendering()
    axes = panels(figure)[1]
    (right,) = axes.child_axes
    strain = 1e6 * data["strain"].sel(link="coupler")[0].values
    factor = np.ptp(right.get_ylim()) / np.ptp(axes.get_ylim())
    assert any(
        np.allclose(factor * np.asarray(line.get_ydata()), strain)
        for line in axes.lines
        if len(line.get_ydata()) == len(strain)
    )
    assert right.get_ylabel() == "Coupler\nstrain (µm/m)"


def test_forces_stand_above_the_difference_of_both_engines() -> None:
    data = results.response().dataset
    last = panels(figure_of(plots.plot_forces))[-1]
    size = np.hypot(*data["joint_force"].transpose("component", ...).values)
    apart = size[1] - size[0]
    drawn = [np.asarray(line.get_ydata()) for line in last.lines if len(line.get_ydata()) > 2]
    np.testing.assert_allclose(drawn, apart.T, atol=1e-9 * np.abs(size).max())
    assert [text.get_text() for text in last.texts] == sorted(
        data["joint"].values.tolist(),
        key=lambda name: apart[-1, [*data["joint"].values].index(name)],
    )


def test_links_that_do_not_bend_have_no_panel() -> None:
    data = results.response().dataset
    rigid = data.assign(deflection=data["deflection"].where(data["link"] != "crank", 0.0))
    labels = [axes.get_ylabel() for axes in panels(plots.plot_response(rigid))]
    assert not any("Crank" in label for label in labels)


def test_a_vibration_too_fast_to_be_drawn_is_its_envelope() -> None:
    """A vibration of 1 mm at 100 Hz over 40 turns."""
    data = plots.chosen(results.response().dataset, links="coupler", engine="reference")
    time = np.linspace(0.0, 4 * np.pi, 14401)
    fast = 1e-3 * np.sin(2 * np.pi * 100.0 * time) * np.cos(time)
    over = ("engine", "time", "link")
    run = data.drop_dims("time").assign(
        deflection=(over, fast[None, :, None]), strain=(over, 0 * fast[None, :, None])
    )
    run = run.assign_coords(time=time, crank_angle=("time", 20.0 * time))
    figure = plots.plot_response(run)
    assert "envelope of the vibration" in legend_texts(figure)
    corners = panels(figure)[0].collections[0].get_paths()[0].vertices
    upper = corners[corners[:, 1] > 0]
    np.testing.assert_allclose(upper[:, 1], np.abs(np.cos(upper[:, 0])), atol=0.06)


@pytest.mark.parametrize(
    ("plot", "words"),
    [
        (
            lambda: plots.plot_agreement(
                plots.chosen(results.frequencies().dataset, engine="exudyn")
            ),
            "two engines",
        ),
        (lambda: plots.plot_hygrothermal_effect(results.frequencies().dataset), "two states"),
        (
            lambda: plots.plot_speed_effect(
                results.frequencies().dataset.drop_vars("speed_effect")
            ),
            "speed_effect=True",
        ),
        (lambda: plots.plot_impact_shapes(results.hammer().dataset), "--grid N"),
        (lambda: plots.plot_designs(failed_designs()), "no design can be computed"),
        (lambda: plots.page_width(30.0).__enter__(), "between 80 and 400 mm"),
    ],
    ids=["one engine", "one state", "no terms", "no grid", "no design", "width"],
)
def test_what_lacks_for_a_figure_is_named(plot: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        plot()  # type: ignore[operator]


def failed_designs() -> xr.Dataset:
    data = results.sweep().dataset
    return data.assign(status=("design", ["locked"] * data.sizes["design"]))


class TestFiles:
    @staticmethod
    def saved(path: Path) -> bytes:
        plots.save_figure(plots.plot_transmission_angle(results.synthesis().dataset), path, dpi=50)
        return path.read_bytes()

    def test_letters_of_a_pdf_are_embedded_truetype(self, tmp_path: Path) -> None:
        content = self.saved(tmp_path / "a.pdf")
        assert b"/Type3" not in content
        assert b"/CIDFontType2" in content
        assert b"/FontFile2" in content
        assert content == self.saved(tmp_path / "b.pdf"), "the same result gives the same file"

    def test_letters_of_an_svg_are_text(self, tmp_path: Path) -> None:
        assert ">Transmission angle (deg)<" in self.saved(tmp_path / "a.svg").decode()
        assert self.saved(tmp_path / "a.svg") == self.saved(tmp_path / "b.svg")

    def test_a_png_is_as_matplotlib_saves_it(self, tmp_path: Path) -> None:
        """Whatever layout the user has set for figures of his own."""
        figure, other = (plots.plot_search(results.optimum().dataset) for _ in range(2))
        with plots.publication_style():
            other.savefig(tmp_path / "by_matplotlib.png", dpi=70)
        with mpl.rc_context({"figure.constrained_layout.use": True}):
            plots.save_figure(figure, tmp_path / "saved.png", dpi=70)
        assert (tmp_path / "saved.png").read_bytes() == (
            tmp_path / "by_matplotlib.png"
        ).read_bytes()

    def test_a_notebook_shows_a_figure_by_itself(self) -> None:
        figure = plots.plot_transmission_angle(results.synthesis().dataset)
        with Image.open(io.BytesIO(figure._repr_png_())) as picture:  # type: ignore[attr-defined]
            # 180 mm at 150 dots per inch.
            assert abs(picture.width - 180 / 25.4 * 150) < 1
        assert plots.figure_html(figure).startswith('<img src="data:image/png;base64,iVBOR')
