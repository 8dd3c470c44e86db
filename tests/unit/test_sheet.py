"""Figures in the user's axes, of a part of a dataset, in the user's unit, and in notebooks."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image
from tests.support.strength_data import strength_dataset

from flexmech import plots
from flexmech.errors import InputError
from flexmech.plots import chosen
from tests.support.balance_data import balance_dataset
from tests.support.comparison_data import drawn_dataset
from tests.support.design_data import optimum_dataset, sweep_designs, uncertainty_dataset
from tests.support.driven_data import driven_dataset, shaped_dataset
from tests.support.figure_checks import (
    check_layout,
    check_texts,
    heading,
    legend_texts,
    panels,
    shown_texts,
)
from tests.support.hammer_data import hammer_dataset
from tests.support.kinematics_data import kinematics_dataset
from tests.support.motor_data import motor_dataset
from tests.support.plot_data import (
    campbell_dataset,
    coupler_dataset,
    frequency_dataset,
    linkage_dataset,
    mechanism_dataset,
    moisture_dataset,
    response_dataset,
    sweep_dataset,
    transmission_dataset,
    verification_dataset,
    vibration_dataset,
)
from tests.support.roved_hammer import roved_dataset
from tests.support.running_hammer_data import running_hammer_dataset
from tests.support.shaking_data import framed_dataset, running_shaking_dataset
from tests.support.stability_data import stability_dataset

Plot = Callable[..., Figure]


def damped() -> xr.Dataset:
    dataset = frequency_dataset()
    return dataset.assign(strain_energy_damping=1e-5 * dataset["frequency"])


def in_two_states() -> xr.Dataset:
    dataset = frequency_dataset()
    both = xr.concat([dataset["frequency"], 0.9 * dataset["frequency"]], "state")
    return both.to_dataset(name="frequency").assign_coords(state=["dry", "+60 K"])


def composite_study() -> xr.Dataset:
    """Numbers that fall from laminate to laminate and rise from case to case."""
    values = np.linspace(1.0, 0.5, 6)[:, None, None] * np.linspace(1.0, 1.2, 4)[:, None]
    values = values * np.array([1.0, 0.9, 1.1])
    place = ("laminate", "case", "position")
    models = np.broadcast_to(values, (3, 2, 2, *values.shape))
    peaks = np.broadcast_to(np.linspace(1.0, 9.0, 7)[:, None] * np.arange(1.0, 5.0), (2, 7, 4))
    return xr.Dataset(
        {
            "frequency": (("plies", "layers", "beams", *place), models),
            "strain_energy_damping": (("plies", "layers", "beams", *place), models),
            "finite_element": (place, values),
            "measured": (place, values),
            "damping": (place, values),
            "rigid_joints_frequency": (place, values),
            "laminate_factor": (("plies", "layers", "beams", "laminate"), models[..., 0, 0]),
            "laminate_factor_spread": ("laminate", 0.1 * values[:, 0, 0]),
            "peak_torque": (("running_plies", "material", "case"), peaks),
            "peak_deflection": (("running_plies", "material", "case"), 1e-3 * peaks),
            "published_laminate_factor": ("laminate", values[:, 0, 0]),
        },
        coords={
            "plies": ["woven", "unidirectional", "table 2"],
            "layers": ["across width", "through thickness"],
            "beams": ["converged", "third order"],
            "running_plies": ["woven", "table 2"],
            "material": [*(f"C{n}" for n in range(1, 7)), "steel"],
            "laminate": [f"C{n}" for n in range(1, 7)],
            "case": [1, 2, 3, 4],
            "position": ["min", "90", "max"],
        },
    )


def section() -> xr.Dataset:
    """One layer under three loads; the second layer is padding."""
    place = np.array([np.linspace(-2e-3, 2e-3, 9), np.full(9, np.nan)])
    values = np.stack([[1e6 * place, 2e6 * place, 3e6 * place]] * 2)
    names = ("strain", "normal_stress", "shear_stress", "third_order_shear_stress")
    over = ("coupling", "load", "layer", "point")
    return xr.Dataset(
        {"place": (("layer", "point"), place), **dict.fromkeys(names, (over, values))},
        coords={
            "link": "coupler",
            "coupling": ["with", "without"],
            "load": ["axial_force", "bending_moment", "shear_force"],
            "ply": ("layer", ["C", ""]),
            "angle": ("layer", [0.0, np.nan]),
            "neutral_axis": 0.0,
            "mass_axis": 0.0,
            "direction_of_layers": "through thickness",
            "layer_thickness": ("layer", [4e-3, np.nan]),
        },
    )


# What every figure is drawn from, and how many panels it has.
FIGURES: dict[Plot, tuple[Callable[[], xr.Dataset], int]] = {
    plots.plot_agreement: (frequency_dataset, 4),
    plots.plot_balance: (balance_dataset, 4),
    plots.plot_comparison: (drawn_dataset, 3),
    plots.plot_composite_damping: (composite_study, 3),
    plots.plot_composite_frequencies: (composite_study, 3),
    plots.plot_campbell: (campbell_dataset, 2),
    plots.plot_coupler_angles: (coupler_dataset, 2),
    plots.plot_coupler_curve: (coupler_dataset, 3),
    plots.plot_designs: (sweep_designs, 2),
    plots.plot_distributions: (uncertainty_dataset, 2),
    plots.plot_drive: (kinematics_dataset, 3),
    plots.plot_floquet_frequencies: (stability_dataset, 1),
    plots.plot_floquet_harmonics: (stability_dataset, 4),
    plots.plot_forces: (response_dataset, 7),
    plots.plot_frame_motion: (framed_dataset, 5),
    plots.plot_frequencies: (frequency_dataset, 4),
    plots.plot_frequency_bands: (uncertainty_dataset, 2),
    plots.plot_frf: (hammer_dataset, 6),
    plots.plot_frf_parts: (hammer_dataset, 6),
    plots.plot_hammer: (hammer_dataset, 3),
    plots.plot_harmonic_frf: (running_hammer_dataset, 6),
    plots.plot_hygrothermal_effect: (in_two_states, 4),
    plots.plot_impact_shapes: (roved_dataset, 3),
    plots.plot_internal_forces: (strength_dataset, 9),
    plots.plot_joint_forces: (kinematics_dataset, 4),
    plots.plot_kinematics: (kinematics_dataset, 3),
    plots.plot_motion: (kinematics_dataset, 3),
    plots.plot_laminate_factors: (composite_study, 1),
    plots.plot_law: (driven_dataset, 4),
    plots.plot_linkage: (linkage_dataset, 1),
    plots.plot_mechanism: (mechanism_dataset, 3),
    plots.plot_damping_ratio: (frequency_dataset, 3),
    plots.plot_modal_damping: (damped, 3),
    plots.plot_mode_shapes: (frequency_dataset, 4),
    plots.plot_moisture: (moisture_dataset, 4),
    plots.plot_motor: (motor_dataset, 4),
    plots.plot_move_times: (shaped_dataset, 3),
    plots.plot_nyquist: (hammer_dataset, 2),
    plots.plot_pareto: (optimum_dataset, 1),
    plots.plot_residual: (driven_dataset, 3),
    plots.plot_response: (response_dataset, 5),
    plots.plot_running_against_steel: (composite_study, 2),
    plots.plot_running_shaking_force: (running_shaking_dataset, 3),
    plots.plot_search: (optimum_dataset, 2),
    plots.plot_section: (section, 6),
    plots.plot_sensitivity: (uncertainty_dataset, 2),
    plots.plot_shaped: (shaped_dataset, 4),
    plots.plot_shaking_force: (kinematics_dataset, 2),
    plots.plot_shaking_orders: (running_shaking_dataset, 2),
    plots.plot_spectrogram: (response_dataset, 3),
    plots.plot_spectrum: (response_dataset, 3),
    plots.plot_speed_effect: (frequency_dataset, 4),
    plots.plot_speed_sweep: (sweep_dataset, 3),
    plots.plot_stabilisation: (roved_dataset, 1),
    plots.plot_stability: (stability_dataset, 2),
    plots.plot_stability_against: (stability_dataset, 1),
    plots.plot_strength: (strength_dataset, 1),
    plots.plot_transmission_angle: (transmission_dataset, 1),
    plots.plot_vibration_effect: (vibration_dataset, 5),
    plots.plot_verification: (verification_dataset, 1),
}


OF_SEVERAL_MECHANISMS = {
    plots.plot_composite_damping,
    plots.plot_composite_frequencies,
    plots.plot_laminate_factors,
    plots.plot_running_against_steel,
    plots.plot_verification,
}


@cache
def _made(make: Callable[[], xr.Dataset]) -> xr.Dataset:
    return make()


def data_of(plot: Plot) -> xr.Dataset:
    """What a figure is drawn from, made once."""
    return _made(FIGURES[plot][0]).copy(deep=True)


def check_same_lines(axes: Axes, other: Axes) -> None:
    for line, wanted in zip(axes.lines, other.lines, strict=True):
        np.testing.assert_array_equal(line.get_xdata(), wanted.get_xdata())
        np.testing.assert_array_equal(line.get_ydata(), wanted.get_ydata())


def users_axes(count: int) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(8, 4 * count), layout="constrained")
    return figure, figure.subplots(count, 1, squeeze=False)[:, 0]


class TestAxesOfTheUser:
    def test_every_figure_can_be_drawn_in_them(self) -> None:
        names = {name for name in plots.__all__ if name.startswith("plot_")}
        assert {plot.__name__ for plot in FIGURES} == names

    @pytest.mark.parametrize("plot", FIGURES, ids=lambda plot: plot.__name__)
    def test_same_content_without_a_header(self, plot: Plot) -> None:
        count, dataset = FIGURES[plot][1], data_of(plot)
        figure, given = users_axes(count)
        height = figure.get_figheight()
        assert plot(dataset, ax=given if count > 1 else given[0]) is figure
        new = plot(dataset)
        # The strip of names above a speed sweep is no panel.
        wanted = panels(new)[-count:]
        for axes, other in zip(given, wanted, strict=True):
            check_same_lines(axes, other)
            assert axes.get_title("left") == other.get_title("left")
            assert axes.lines or axes.patches or axes.collections
        assert not figure.legends
        assert figure.get_figheight() == height
        if new.legends:
            legend = given[0].get_legend()
            assert {text.get_text() for text in legend.get_texts()} == set(legend_texts(new))
            assert not any(axes.get_legend() for axes in given[1:])

    @pytest.mark.parametrize(
        "plot",
        [
            pytest.param(plot, marks=[] if number % 8 == 4 else pytest.mark.thorough)
            for number, plot in enumerate(FIGURES)
        ],
        ids=lambda plot: plot.__name__,
    )
    def test_texts_stand_apart_in_them(self, plot: Plot) -> None:
        count = FIGURES[plot][1]
        figure, given = users_axes(count)
        plot(data_of(plot), ax=given if count > 1 else given[0])
        check_texts(figure)

    @pytest.mark.parametrize("plot", FIGURES, ids=lambda plot: plot.__name__)
    def test_wrong_number_is_refused(self, plot: Plot) -> None:
        count = FIGURES[plot][1]
        _, given = users_axes(count + 1)
        words = rf"^ax: .* {count} panels? .*{count + 1} Axes"
        with pytest.raises(InputError, match=words):
            plot(data_of(plot), ax=given)

    def test_message_names_the_choice_that_leaves_one_panel(self) -> None:
        _, (axes,) = users_axes(1)
        choices = {
            plots.plot_frequencies: r"choose one mode \(modes=1\), which leaves one panel",
            plots.plot_modal_damping: r"choose one speed \(speeds=\.\.\.\)",
            plots.plot_spectrum: r"choose one link \(links=\.\.\.\)",
        }
        for plot, words in choices.items():
            with pytest.raises(InputError, match=words):
                plot(data_of(plot), ax=axes)
        for wrong in ("left", [axes, 3]):
            with pytest.raises(InputError, match="ax: must be Axes of matplotlib"):
                plots.plot_frequencies(frequency_dataset(), ax=wrong)

    def test_one_mode_in_one_panel_among_others(self) -> None:
        figure, (mine, other) = users_axes(2)
        other.plot([1, 2], [3, 4])
        dataset = frequency_dataset()
        plots.plot_frequencies(chosen(dataset, modes=3), ax=mine)
        assert mine.get_title("left") == "Mode 3"
        assert (mine.get_xlabel(), mine.get_ylabel()) == ("Crank angle (deg)", "Frequency (Hz)")
        at_rest = dataset["frequency"].sel(mode=3).isel(engine=0, crank_speed=0)
        np.testing.assert_array_equal(mine.lines[0].get_ydata(), at_rest)
        assert len(other.lines) == 1
        assert figure.axes == [mine, other]

    def test_nested_axes_and_subfigures_are_taken(self) -> None:
        figure = Figure()
        left, _ = figure.subfigures(1, 2)
        assert plots.plot_frequencies(frequency_dataset(), ax=left.subplots(2, 2)) is figure


class TestPageWidth:
    @pytest.mark.parametrize(
        "plot",
        [
            pytest.param(plot, marks=[] if number % 8 == 0 else pytest.mark.thorough)
            for number, plot in enumerate(FIGURES)
        ],
        ids=lambda plot: plot.__name__,
    )
    def test_every_figure_can_be_read_in_one_column(self, plot: Plot) -> None:
        """And names its mechanism, whatever the name is."""
        count = FIGURES[plot][1]
        with plots.page_width(88):
            figure = plot(data_of(plot).assign_attrs(mechanism="weaver's $1 loom"))
        assert figure.get_figwidth() * 25.4 == pytest.approx(88)
        # A page of a journal is about 240 mm high.
        assert figure.get_figheight() * 25.4 < 240
        assert len(panels(figure)) >= count
        check_layout(figure)
        smallest = min(text.get_fontsize() for text in shown_texts(figure))
        assert smallest >= 6.5
        named = any(r"Weaver's \$1 loom" in text.get_text() for text in shown_texts(figure))
        assert named is (plot not in OF_SEVERAL_MECHANISMS)

    def test_the_width_ends_with_its_context(self) -> None:
        with plots.page_width(88):
            pass
        figure = plots.plot_linkage(linkage_dataset())
        assert figure.get_figwidth() * 25.4 == pytest.approx(180)

    @pytest.mark.parametrize("wrong", [0.0, 30.0, 1e4, float("nan")])
    def test_other_widths_are_refused(self, wrong: float) -> None:
        with pytest.raises(InputError, match="page width: must lie between 80 and 400 mm"):
            plots.page_width(wrong).__enter__()


class TestFiles:
    @staticmethod
    def saved(path: Path) -> bytes:
        figure = plots.plot_transmission_angle(transmission_dataset().assign_attrs(mechanism="a"))
        plots.save_figure(figure, path, dpi=50)
        return path.read_bytes()

    def test_letters_of_a_pdf_are_embedded_truetype(self, tmp_path: Path) -> None:
        content = self.saved(tmp_path / "a.pdf")
        assert b"/Type3" not in content
        assert b"/CIDFontType2" in content
        assert b"/FontFile2" in content

    def test_letters_of_an_svg_are_text(self, tmp_path: Path) -> None:
        assert ">Transmission angle (deg)<" in self.saved(tmp_path / "a.svg").decode()

    @pytest.mark.parametrize("kind", ["pdf", "svg"])
    def test_the_same_result_gives_the_same_file(self, kind: str, tmp_path: Path) -> None:
        assert self.saved(tmp_path / f"a.{kind}") == self.saved(tmp_path / f"b.{kind}")


class TestChosen:
    def test_single_values_and_lists(self) -> None:
        dataset = frequency_dataset()
        one = chosen(dataset, engine="exudyn", modes=2, speeds=10)
        assert one["engine"].values.tolist() == ["exudyn"]
        assert one["mode"].values.tolist() == [2]
        assert one["crank_speed"].values.tolist() == [10.0]
        xr.testing.assert_identical(one, dataset.isel(engine=[1], mode=[1], crank_speed=[1]))
        several = chosen(dataset, modes=(4, 1), speeds=np.array([20.0, 0.0]))
        assert several["mode"].values.tolist() == [4, 1]
        assert several["crank_speed"].values.tolist() == [20.0, 0.0]
        links = chosen(response_dataset(), links=["coupler"])
        assert links["deflection"].sizes["link"] == 1
        assert chosen(dataset) is not dataset
        xr.testing.assert_identical(chosen(dataset), dataset)

    def test_speeds_are_the_same_within_round_off(self) -> None:
        speed = 50 * np.pi / 30
        dataset = frequency_dataset(speeds=(0.0, speed))
        assert chosen(dataset, speeds=speed * (1 + 5e-10)).sizes["crank_speed"] == 1
        with pytest.raises(InputError):
            chosen(dataset, speeds=speed * (1 + 5e-9))

    @pytest.mark.parametrize(
        ("choice", "message"),
        [
            ({"engine": "adams"}, "engine: .* no 'adams'; choose from reference, exudyn"),
            ({"modes": [1, 9]}, "modes: .* no 9; choose from 1, 2, 3, 4"),
            ({"modes": "1"}, "modes: .* no '1'; choose from 1"),
            ({"speeds": 15.0}, "speeds: .* no 15.0; choose from 0, 10, 20 rad/s"),
            ({"links": "spring"}, "links: .* no 'spring'; choose from crank, coupler, rocker"),
            ({"speeds": []}, "speeds: nothing is chosen; choose from 0, 10, 20 rad/s"),
        ],
    )
    def test_what_is_not_there_is_refused(self, choice: dict[str, object], message: str) -> None:
        with pytest.raises(InputError, match=message):
            chosen(frequency_dataset(), **choice)  # type: ignore[arg-type]

    def test_a_result_without_such_a_dimension(self) -> None:
        with pytest.raises(InputError, match="modes: this result has none to choose from"):
            chosen(coupler_dataset(), modes=1)


def test_speeds_are_in_the_unit_of_the_user() -> None:
    rpm = np.pi / 30
    dataset = frequency_dataset(speeds=(0.0, 300 * rpm))
    dataset = dataset.assign(strain_energy_damping=1e-5 * dataset["frequency"])
    dataset.attrs["speed_unit"] = "rpm"
    for plot in (plots.plot_frequencies, plots.plot_agreement, plots.plot_mode_shapes):
        assert legend_texts(plot(dataset))[:2] == ["0 rpm", "300 rpm"]
    assert "from rest to 300 rpm" in heading(plots.plot_speed_effect(dataset))
    titles = [axes.get_title("left") for axes in plots.plot_modal_damping(dataset).axes]
    assert titles == ["0 rpm", "300 rpm"]
    vibrating = vibration_dataset().assign_attrs(speed_unit="rpm")
    assert "at \N{MINUS SIGN}191 rpm" in heading(plots.plot_vibration_effect(vibrating))
    run = response_dataset(speed=300 * rpm).assign_attrs(speed_unit="rpm")
    for plot in (plots.plot_response, plots.plot_forces, plots.plot_spectrum):
        assert heading(plot(run)).startswith("Aluminium four-bar\nResponse at 300 rpm")
    both = in_two_states().assign_attrs(speed_unit="rpm")
    assert "95.49 rpm" in legend_texts(plots.plot_hygrothermal_effect(both))


def test_effect_of_a_state_needs_two_states() -> None:
    for wrong in (frequency_dataset(), in_two_states().isel(state=[0])):
        with pytest.raises(InputError, match="two states"):
            plots.plot_hygrothermal_effect(wrong)


def test_lines_of_both_states_are_the_dataset_s() -> None:
    dataset = in_two_states()
    figure = plots.plot_hygrothermal_effect(dataset)
    assert legend_texts(figure)[:2] == ["dry", "+60 K"]
    for mode, axes in enumerate(figure.axes):
        wanted = dataset["frequency"].isel(engine=0, mode=mode)
        wanted = wanted.transpose("crank_speed", "state", "crank_angle")
        lines = [line.get_ydata() for line in axes.lines]
        np.testing.assert_array_equal(lines, wanted.values.reshape(6, -1))


def test_figures_show_themselves_in_a_notebook() -> None:
    figure = plots.plot_transmission_angle(transmission_dataset())
    png = figure._repr_png_()  # type: ignore[attr-defined]
    with Image.open(io.BytesIO(png)) as picture:
        assert picture.format == "PNG"
        # 180 mm at 150 dots per inch.
        assert abs(picture.width - 180 / 25.4 * 150) < 1
    assert plots.figure_html(figure).startswith('<img src="data:image/png;base64,iVBOR')


def test_a_saved_figure_is_as_matplotlib_saves_it_and_stays_as_it_was(tmp_path: Path) -> None:
    """Whatever layout the user has set for figures of his own."""
    figure, other = (plots.plot_stability(stability_dataset()) for _ in range(2))
    layout, resolution = figure.get_layout_engine(), figure.dpi
    with plots.publication_style():
        other.savefig(tmp_path / "by_matplotlib.png", dpi=70)
    with mpl.rc_context({"figure.constrained_layout.use": True}):
        plots.save_figure(figure, tmp_path / "saved.png", dpi=70)
    saved, expected = (tmp_path / name for name in ("saved.png", "by_matplotlib.png"))
    assert saved.read_bytes() == expected.read_bytes()
    assert figure.get_layout_engine() is layout
    assert figure.dpi == resolution


def test_padding_of_a_section_is_left_out() -> None:
    figure = plots.plot_section(section())
    first = figure.axes[0]
    assert first.get_ylim() == pytest.approx((-2.0, 2.0))
    assert len(first.patches) == 1
    assert "Coupler" in heading(figure)


def test_columns_of_an_odd_number_of_panels_end_at_one_height() -> None:
    figure = plots.plot_frequencies(frequency_dataset(modes=5))
    figure.draw_without_rendering()
    boxes = [axes.get_position() for axes in panels(figure)]
    assert boxes[2].y0 == pytest.approx(boxes[4].y0, abs=1e-3)
    assert boxes[0].y1 == pytest.approx(boxes[3].y1, abs=1e-3)
    assert boxes[3].height > 1.2 * boxes[0].height


@pytest.mark.parametrize("plot", [plots.plot_mode_shapes, plots.plot_impact_shapes])
def test_a_last_row_that_is_not_full_stands_in_the_middle(plot: Plot) -> None:
    dataset = frequency_dataset(modes=5) if plot is plots.plot_mode_shapes else roved_dataset()
    figure = plot(dataset)
    figure.draw_without_rendering()
    middles = [(box.x0 + box.x1) / 2 for box in (axes.get_position() for axes in panels(figure))]
    columns = len(middles) // 2 + 1
    whole = (middles[0] + middles[columns - 1]) / 2
    assert np.mean(middles[columns:]) == pytest.approx(whole, abs=0.02)
    check_texts(figure)
