"""Pictures of sections show the numbers of the dataset, with units, inside their frame."""

from __future__ import annotations

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.analyses.section_profile.compute import section_profiles
from flexmech.linkages import RotatingArm
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.mechanism import Mechanism
from flexmech.plots import plot_section
from flexmech.plots.style import TIMES
from flexmech.sections import BeamSection, LaminateSection, SheetSection
from tests.support.figure_checks import check_texts, legend_texts

CARBON = Ply(172.7e9, 7.2e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, name="C")
GLASS = Ply(37.8e9, 10.9e9, 4.91e9, 4.91e9, 3.89e9, 0.29, 1813.9, name="G")
FOAM = Ply.isotropic(Material(0.1e9, 80.0, 0.3))
LONG = Ply(135e9, 10e9, 5e9, 5e9, 3.9e9, 0.3, 1600, name="T300 carbon in 5208 epoxy, woven")
BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"


def profile(layers: list[Layer], reduction: str = "narrow") -> xr.Dataset:
    section = LaminateSection(Laminate(tuple(layers)), 0.02, reduction)  # type: ignore[arg-type]
    return of_arm(BeamSection.of_laminate(section))


def sheet(layers: list[Layer]) -> xr.Dataset:
    return of_arm(BeamSection.of_laminate(SheetSection(Laminate(tuple(layers)), 0.02)))


def rectangle() -> xr.Dataset:
    return of_arm(BeamSection.rectangle(Material(70e9, 2700, 0.33), 4e-3, 25e-3))


def of_arm(section: BeamSection) -> xr.Dataset:
    return section_profiles(Mechanism(RotatingArm(0.5), {"arm": section})).profile("arm")


def angles(*degrees: float) -> list[Layer]:
    return [Layer(CARBON, 2e-4, float(np.radians(angle))) for angle in degrees]


UNSYMMETRIC = [Layer(CARBON, 1e-3)] * 4 + [Layer(GLASS, 1e-3)] * 4
SYMMETRIC = [Layer(CARBON, 1e-3), Layer(GLASS, 2e-3), Layer(CARBON, 1e-3)]
TO_LAY_OUT = {
    "many layers": lambda: profile(angles(*[45, -45, 0, 90] * 5)),
    "thin faces with long names": lambda: profile(
        [
            *[Layer(LONG, 1e-4, -0.4)] * 12,
            *angles(0, 45),
            Layer(FOAM, 2e-2),
            *angles(-45, 45),
            Layer(LONG, 1e-4, 0.8),
        ],
        "wide",
    ),
}


@pytest.fixture(scope="module")
def unsymmetric() -> xr.Dataset:
    return profile(UNSYMMETRIC)


def drawn(axes: Axes, color: str) -> tuple[np.ndarray, np.ndarray]:
    (line,) = [line for line in axes.lines if line.get_color() == color]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def panel(figure: Figure, title: str) -> Axes:
    (axes,) = [axes for axes in figure.axes if axes.get_title(loc="left") == title]
    return axes


def test_lines_are_the_dataset_s(unsymmetric: xr.Dataset) -> None:
    dataset = unsymmetric
    figure = plot_section(dataset)
    place = 1e3 * dataset["place"].values.ravel()
    for title, name, load, label, factor in (
        ("Strain, N = 1 N", "strain", "axial_force", "Strain ($10^{-9}$)", 1e9),
        ("Strain, M = 1 N m", "strain", "bending_moment", "Strain ($10^{-6}$)", 1e6),
        ("Normal stress, N = 1 N", "normal_stress", "axial_force", "Normal stress (kPa)", 1e-3),
        (
            "Normal stress, M = 1 N m",
            "normal_stress",
            "bending_moment",
            "Normal stress (MPa)",
            1e-6,
        ),
        ("Shear stress, V = 1 N", "shear_stress", "shear_force", "Shear stress (kPa)", 1e-3),
    ):
        axes = panel(figure, title)
        assert axes.get_xlabel() == label
        for coupling, color in (("with", BLUE), ("without", ORANGE)):
            x, y = drawn(axes, color)
            wanted = dataset[name].sel(load=load, coupling=coupling).values.ravel()
            np.testing.assert_allclose(x, factor * wanted, rtol=1e-12)
            np.testing.assert_allclose(y, place)
            low, high = axes.get_xlim()
            assert low <= x.min() <= x.max() <= high
    x, _ = drawn(panel(figure, "Shear stress, V = 1 N"), GREEN)
    third = dataset["third_order_shear_stress"].sel(load="shear_force", coupling="with")
    np.testing.assert_allclose(x, 1e-3 * third.values.ravel(), rtol=1e-12)
    assert panel(figure, "Strain, N = 1 N").get_ylim() == pytest.approx((-4, 4))


def test_without_coupling_is_drawn_where_it_differs(unsymmetric: xr.Dataset) -> None:
    assert legend_texts(plot_section(unsymmetric)) == [
        "with coupling",
        "neutral axis",
        "without coupling",
        "centre of mass",
        "shear stress by third-order theory",
    ]
    symmetric = plot_section(profile(SYMMETRIC))
    assert not [
        line for axes in symmetric.axes for line in axes.lines if line.get_color() == ORANGE
    ]
    assert "neutral axis and centre of mass" in legend_texts(symmetric)
    # The third-order shear stress of one material is that of equilibrium.
    assert legend_texts(plot_section(rectangle())) == [
        "classical theory, shear by equilibrium",
        "neutral axis and centre of mass",
    ]


def test_layers_are_named_and_shaded_by_ply(unsymmetric: xr.Dataset) -> None:
    figure = plot_section(unsymmetric)
    stack = panel(figure, "Layers")
    assert [text.get_text() for text in stack.texts] == ["C × 4", "G × 4"]  # noqa: RUF001
    for axes in figure.axes:
        shades = [patch.get_facecolor()[0] for patch in axes.patches]
        faces = [(p.get_y(), p.get_y() + p.get_height()) for p in axes.patches]  # type: ignore[attr-defined]
        assert shades == pytest.approx([0.96, 0.80])
        assert np.ravel(faces) == pytest.approx([-4, 0, 0, 4])
    axes_drawn = {tuple(np.round(line.get_ydata(), 6)) for line in stack.lines}
    for name in ("neutral_axis", "mass_axis"):
        assert (round(1e3 * float(unsymmetric[name]), 6),) * 2 in axes_drawn
    turned = plot_section(profile(angles(45, 45, -45)))
    assert [t.get_text() for t in panel(turned, "Layers").texts] == [
        "C 45° × 2",  # noqa: RUF001
        "C \N{MINUS SIGN}45°",
    ]
    long = plot_section(profile([Layer(LONG, 1e-3, -0.5)] * 12))
    (text,) = [t.get_text() for t in panel(long, "Layers").texts]
    assert text.startswith("T300 carbo")
    assert text.endswith("… \N{MINUS SIGN}28.65° × 12")  # noqa: RUF001
    assert len(text) == 24


def test_layers_too_many_to_name_are_in_the_legend() -> None:
    figure = plot_section(profile([Layer(p, 2e-4) for p in (CARBON, GLASS)] * 15))
    assert not panel(figure, "Layers").texts
    assert {"C", "G"} <= set(legend_texts(figure))


def test_names_of_plies_are_no_formulas() -> None:
    plies = (replace(CARBON, name="C$x^$"), GLASS)
    named = plot_section(profile([Layer(ply, 2e-4) for ply in plies]))
    # Between two dollar signs matplotlib would read a formula, here a broken one.
    named.draw_without_rendering()
    assert [t.get_text() for t in panel(named, "Layers").texts] == [r"C\$x^\$", "G"]
    in_legend = plot_section(profile([Layer(ply, 2e-4) for ply in plies] * 15))
    assert r"C\$x^\$" in legend_texts(in_legend)


@pytest.mark.thorough
@pytest.mark.parametrize("name", TO_LAY_OUT)
def test_texts_stay_inside_and_apart(name: str) -> None:
    figure = plot_section(TO_LAY_OUT[name]())
    assert plt.get_fignums() == []
    check_texts(figure)
    stack = panel(figure, "Layers")
    for text in stack.texts:
        box = text.get_window_extent()
        assert stack.bbox.y0 - 1 <= box.y0
        assert box.y1 <= stack.bbox.y1 + 1
    assert all(axes.bbox.height > 200 and axes.bbox.width > 220 for axes in figure.axes)


def test_layers_across_the_width_have_a_line_for_each_ply() -> None:
    dataset = sheet([Layer(ply, 1e-3) for ply in (CARBON, GLASS, GLASS, CARBON)])
    figure = plot_section(dataset)
    assert legend_texts(figure)[:2] == ["C", "G"]
    stress = figure.axes[1]
    carbon, glass = (line.get_xdata() for line in stress.lines[:2])
    np.testing.assert_allclose(np.divide(carbon, glass), 172.7 / 37.8, rtol=5e-3)
    np.testing.assert_allclose(figure.axes[0].get_ylim(), (-10.0, 10.0))
    names = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert any(name.endswith(f"C\nG {TIMES} 2\nC") for name in names)
    check_texts(figure)


def test_one_kind_of_layer_across_the_width_has_one_line() -> None:
    figure = plot_section(sheet([Layer(GLASS, 1e-3)] * 2))
    assert legend_texts(figure)[0] == "classical theory, shear by equilibrium"
