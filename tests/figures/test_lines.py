"""Lines of figures are the numbers of the dataset, in the unit that stands beside them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech import plots
from tests.support.figure_checks import panels
from tests.support.figures import Plot, data_of, figure_of
from tests.support.results import LAW

Values = Callable[[xr.Dataset], xr.DataArray]
# Coordinate of a dimension, and its factor from the SI unit; of shares of a link none is drawn.
ABSCISSAE = {
    "crank_angle": ("crank_angle", 180 / np.pi),
    "elastic_angle": ("elastic_angle", 180 / np.pi),
    "time": ("time", 1.0),
    "shaped_time": ("shaped_time", 1.0),
    "window_time": ("window_time", 1.0),
    "crank_speed": ("crank_speed", 1.0),
    "moving_speed": ("moving_speed", 1.0),
    "frequency": ("frequency", 1.0),
    "spectrum_frequency": ("spectrum_frequency", 1.0),
    "step": ("evaluations", 1.0),
    "sample": ("crank_angle", 180 / np.pi),
}


class Row(NamedTuple):
    """Lines of a panel: its number, what stands beside it, and the values in that unit."""

    panel: int
    label: str
    values: Values


def size(name: str, **place: object) -> Values:
    """Magnitude of a vector."""
    return lambda d: np.hypot(*(d[name].sel(component=c, **place) for c in ("x", "y")))


def along(force: xr.DataArray) -> xr.DataArray:
    """An internal force at the places of its link: another link may have more."""
    return force.dropna("station")


def receptance(data: xr.Dataset, which: str = "receptance") -> xr.DataArray:
    """Receptance at the first crank angle."""
    return (data[f"{which}_real"] + 1j * data[f"{which}_imag"]).isel(crank_angle=0)


def harmonic(data: xr.Dataset, order: int) -> xr.DataArray:
    found = [data[f"{name}_real"] + 1j * data[f"{name}_imag"] for name in ("receptance", "frozen")]
    return xr.concat(found, "found").sel(order=order)


DRAWN: dict[Plot, list[Row]] = {
    plots.plot_agreement: [
        Row(
            1,
            "Relative difference (-)",
            lambda d: abs(d["frequency"][1] / d["frequency"][0] - 1)[..., 1],
        )
    ],
    plots.plot_balance: [
        Row(1, "Shaking force (N)", size("shaking_force")),
        Row(1, "Shaking force (N)", size("elastic_shaking_force")),
        Row(2, "Shaking moment about (0, 0) mm (N m)", lambda d: d["shaking_moment"]),
        Row(3, "Driving torque (N m)", lambda d: d["driving_torque"]),
    ],
    plots.plot_comparison: [
        Row(0, "Natural frequency (Hz)", lambda d: d["measured"]),
        Row(0, "Natural frequency (Hz)", lambda d: d["computed"]),
        Row(1, "Residual (Hz)", lambda d: d["measured"] - d["computed"]),
    ],
    plots.plot_campbell: [
        Row(0, "Natural frequency (Hz)", lambda d: d["lowest_frequency"][0]),
        Row(0, "Natural frequency (Hz)", lambda d: d["mean_frequency"][0]),
        Row(0, "Natural frequency (Hz)", lambda d: d["highest_frequency"][0]),
    ],
    plots.plot_drive: [
        Row(0, "Torque (N m)", lambda d: d["driving_torque"]),
        Row(0, "Torque (N m)", lambda d: d["lumped_driving_torque"]),
        Row(1, "Transmission angle (deg)", lambda d: np.degrees(d["transmission_angle"])),
    ],
    plots.plot_floquet_frequencies: [Row(0, "Frequency (Hz)", lambda d: d["mean_frequency"])],
    plots.plot_forces: [
        Row(0, "Driving torque (N m)", lambda d: d["driving_torque"]),
        Row(0, "Driving torque (N m)", lambda d: d["rigid_driving_torque"]),
        Row(2, "Force at A (N)", size("joint_force", joint="A")),
        Row(4, "Force at O4 (N)", size("joint_force", joint="O4")),
        Row(4, "Force at O4 (N)", size("rigid_joint_force", joint="O4")),
    ],
    plots.plot_frame_motion: [
        Row(0, "Frame along x (mm)", lambda d: 1e3 * d["frame_displacement"].sel(component="x")),
        Row(2, "Frame rotation (deg)", lambda d: np.degrees(d["frame_rotation"])),
        Row(4, "Force on the floor along y (N)", lambda d: d["floor_force"].sel(component="y")),
    ],
    plots.plot_frequencies: [
        Row(0, "Frequency (Hz)", lambda d: d["frequency"][0, ..., 0]),
        Row(3, "Frequency (Hz)", lambda d: d["frequency"][0, ..., 3]),
    ],
    plots.plot_frequency_bands: [
        Row(1, "Frequency (Hz)", lambda d: d["frequency_percentile"].sel(percentile=50.0, mode=2))
    ],
    plots.plot_frf: [
        Row(0, "Receptance amplitude (m/N)", lambda d: abs(receptance(d))),
        Row(0, "Receptance amplitude (m/N)", lambda d: abs(receptance(d, "exact_receptance"))),
        Row(
            1,
            "Phase (deg)",
            lambda d: np.degrees(np.arctan2(receptance(d).imag, receptance(d).real)),
        ),
    ],
    plots.plot_hammer: [Row(2, "Coherence", lambda d: d["coherence"][0])],
    plots.plot_harmonic_frf: [
        Row(0, "|H₋₁| (m/N)", lambda d: abs(harmonic(d, -1))),
        Row(4, "|H₊₁| (m/N)", lambda d: abs(harmonic(d, 1))),
    ],
    plots.plot_hygrothermal_effect: [
        Row(1, "Natural frequency (Hz)", lambda d: d["frequency"][:, 0, 0, :, 1]),
    ],
    plots.plot_internal_forces: [
        Row(
            2,
            "Bending moment M (N m)",
            lambda d: along(d["bending_moment"][0, 0]).max("crank_angle"),
        ),
        Row(6, "Axial force N (N)", lambda d: along(d["axial_force"][0, 2]).min("crank_angle")),
    ],
    plots.plot_joint_forces: [
        Row(2, "Force (N)", lambda d: d["joint_force"].sel(joint="B")),
        Row(2, "Force (N)", lambda d: d["lumped_joint_force"].sel(joint="B")),
        Row(2, "Force (N)", size("joint_force", joint="B")),
    ],
    plots.plot_kinematics: [
        Row(0, "Angle (deg)", lambda d: np.degrees(d["angle"][:, 1:])),
        Row(1, "Angular velocity (rad/s)", lambda d: d["angular_velocity"][:, 1:]),
        Row(2, "Angular acceleration (rad/s²)", lambda d: d["angular_acceleration"][:, 1:]),
    ],
    plots.plot_law: [
        Row(0, "Angle (deg)", lambda d: np.degrees(d["crank_angle"])),
        Row(1, "Speed (rad/s)", lambda d: d["crank_speed_over_time"]),
        Row(2, "Acceleration (rad/s²)", lambda d: d["crank_acceleration"]),
    ],
    plots.plot_mechanism: [
        Row(2, "Transmission angle (deg)", lambda d: np.degrees(d["transmission_angle"])),
    ],
    plots.plot_damping: [
        Row(1, "Damping ratio (%)", lambda d: 100 * d["strain_energy_damping"][0, 1]),
    ],
    plots.plot_moisture: [
        Row(0, "Moisture of the resin (%)", lambda d: 100 * d["profile"].sel(link="coupler")),
        Row(1, "Share of equilibrium", lambda d: d["uptake"].sel(link="coupler").rename(time="t")),
    ],
    plots.plot_motion: [
        Row(0, "Position (mm)", lambda d: 1e3 * d["point_position"].sel(point="B")),
        Row(1, "Velocity (m/s)", lambda d: d["point_velocity"].sel(point="B")),
        Row(2, "Acceleration (m/s²)", lambda d: d["point_acceleration"].sel(point="B")),
    ],
    plots.plot_motor: [
        Row(
            0,
            "Crank speed (rad/s)",
            lambda d: d["crank_speed_over_time"] + d["crank_speed_fluctuation"],
        ),
        Row(1, "Motor torque (N m)", lambda d: d["motor_torque"]),
        Row(3, "Motor current (A)", lambda d: d["motor_current"]),
    ],
    plots.plot_residual: [
        Row(
            1,
            "Coupler middle deflection (mm)",
            lambda d: (
                1e3 * d["deflection"].sel(link="coupler").where(d["time"] >= LAW.time, drop=True)
            ),
        ),
        *(
            Row(
                1,
                "Coupler middle deflection (mm)",
                lambda d, side=side: (
                    1e3
                    * (d["residual_middle"] + side * d["residual_envelope"])
                    .isel(engine=0)
                    .sel(link="coupler")
                    .dropna("time")
                ),
            )
            for side in (-1.0, 1.0)
        ),
    ],
    plots.plot_response: [
        Row(0, "Crank tip deflection (mm)", lambda d: 1e3 * d["deflection"].sel(link="crank")),
        Row(2, "Rocker middle deflection (mm)", lambda d: 1e3 * d["deflection"].sel(link="rocker")),
    ],
    plots.plot_running_shaking_force: [
        Row(1, "Force along y (N)", lambda d: d["shaking_force"].sel(component="y")),
        Row(1, "Force along y (N)", lambda d: d["rigid_shaking_force"].sel(component="y")),
        Row(2, "Moment about (0, 0) mm (N m)", lambda d: d["shaking_moment"]),
    ],
    plots.plot_search: [
        Row(0, "mass (kg), min", lambda d: d["mass"]),
        Row(3, "f1 (Hz), max", lambda d: d["f1"]),
    ],
    plots.plot_shaking_force: [
        Row(0, "Force (N)", lambda d: d["shaking_force"]),
        Row(0, "Force (N)", size("shaking_force")),
        Row(1, "Moment about (0, 0) mm (N m)", lambda d: d["shaking_moment"]),
    ],
    plots.plot_shaped: [
        Row(0, "Crank speed (rad/s)", lambda d: d["shaped_crank_speed_over_time"]),
        Row(
            2, "Coupler middle deflection (mm)", lambda d: 1e3 * d["deflection"].sel(link="coupler")
        ),
        Row(
            2,
            "Coupler middle deflection (mm)",
            lambda d: 1e3 * d["shaped_deflection"].sel(link="coupler"),
        ),
    ],
    plots.plot_spectrum: [
        Row(
            1,
            "Coupler middle amplitude (mm)",
            lambda d: (
                1e3
                * d["spectrum"]
                .sel(link="coupler")
                .where(
                    d["spectrum_frequency"] <= 1.3 * d["highest_natural_frequency"].max(), drop=True
                )
            ),
        ),
    ],
    plots.plot_transmission_angle: [
        Row(0, "Transmission angle (deg)", lambda d: np.degrees(d["transmission_angle"])),
    ],
    plots.plot_vibration_effect: [
        Row(
            0,
            "Difference (%)",
            lambda d: (
                100
                * (d["frequency"] / d["quasi_static_frequency"] - 1)
                .isel(crank_speed=0)
                .sel(engine="exudyn")
            ),
        ),
    ],
}


def labels_of(figure: Figure, axes: Axes, number: int, columns: int) -> set[str]:
    """Labels beside a panel, above it and above its column, and beside all panels."""
    above = panels(figure)[number % columns].get_title("left")
    texts = (axes.get_ylabel(), above, figure.get_supylabel())
    return {text.replace("\n", " ") for text in texts}


@pytest.mark.parametrize("plot", DRAWN, ids=lambda plot: plot.__name__)
def test_lines_are_the_numbers_of_the_dataset(plot: Plot) -> None:
    figure, data = figure_of(plot), data_of(plot)
    for number, label, values in DRAWN[plot]:
        axes = panels(figure)[number]
        assert label in labels_of(figure, axes, number, 3)
        wanted = values(data)
        along = next((d for d in reversed(wanted.dims) if d in ABSCISSAE), wanted.dims[-1])
        abscissa = None
        if along in ABSCISSAE:
            name, factor = ABSCISSAE[along]
            abscissa = factor * wanted[name].values if name in wanted.coords else None
        rows = wanted.transpose(..., along).values.reshape(-1, wanted.sizes[along])
        lines = [np.asarray(line.get_xydata(), dtype=float) for line in axes.lines]
        for row in rows:
            found = [line for line in lines if is_drawn(line[:, 1], row, "phase" in label.lower())]
            assert found, f"{label}: not drawn"
            if abscissa is not None:
                assert any(np.allclose(line[:, 0], abscissa, rtol=1e-9) for line in found), label


def test_lines_of_the_speed_effect_have_no_corners_and_pass_through_what_is_computed() -> None:
    effect = data_of(plots.plot_speed_effect)["speed_effect"][:, 2, :, 1]
    drawn = [line.get_ydata() for line in panels(figure_of(plots.plot_speed_effect))[1].lines]
    smooth = [line for line in drawn if len(line) > effect.sizes["crank_angle"]]
    for row in (*effect.values, effect.sum("term").values):
        found = [line for line in smooth if np.allclose(line[::4], row, atol=1e-12)]
        assert any(np.ptp(line) == pytest.approx(np.ptp(row)) for line in found)


def is_drawn(line: np.ndarray, row: np.ndarray, jumps: bool) -> bool:
    """Whether a line holds these values; of a phase what jumps is left out."""
    if len(line) != len(row):
        return False
    shown = np.isfinite(line) if jumps else np.ones(len(row), dtype=bool)
    close = np.allclose(
        line[shown], row[shown], rtol=1e-7, atol=1e-12 * np.nanmax(np.abs(row)), equal_nan=True
    )
    return bool(shown.mean() > 0.5 and close)
