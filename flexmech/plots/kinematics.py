"""Motion of the rigid links, transmission angles, joint forces, and what drives the linkage."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.arrays import FloatArray
from flexmech.plots import angle_panels, reading, scales, style
from flexmech.plots.layout import AxesLike, grid, sheet

POWER: reading.Units = ((1.0, "W"), (1e3, "mW"), (1e6, "µW"))
# Motion of a link: variable, what it is, factor from the SI unit, and unit.
MOTIONS = (
    ("angle", "Angle", np.degrees(1.0), "deg"),
    ("angular_velocity", "Angular velocity", 1.0, "rad/s"),
    ("angular_acceleration", "Angular acceleration", 1.0, "rad/s²"),
)
# Beyond the number of styles, lines are wider at each further round.
STYLES, WIDTHS = 6, (1.1, 2.2, 3.3)
# Around forces by distributed masses, which they hardly leave.
LUMPED: style.Look = {"color": "0.25", "linestyle": (0.0, (1.0, 1.4)), "lw": 1.3}

TITLE = "Transmission angle over a turn of the crank"


def plot_kinematics(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw angle, angular velocity and angular acceleration of each link.

    Parameters
    ----------
    dataset : Dataset
        With ``angle``, ``angular_velocity`` and ``angular_acceleration`` (crank_angle, link) in
        SI units; the attributes ``crank_speed`` and ``mechanism``.
    ax : sequence of Axes, optional
        Three of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    angles, links = reading.degrees(dataset["crank_angle"]), reading.names_of(dataset, "link")
    with sheet(grid(3, 1, 5.4, sharex=True), ax=ax) as drawn:
        handles = [style.line_handle(name, **_link_line(n)) for n, name in enumerate(links)]
        drawn.header(handles, f"Motion of the links at {reading.speed_text(dataset)}", of=dataset)
        for axes, (name, words, factor, unit) in zip(drawn.panels, MOTIONS, strict=True):
            values = dataset[name].transpose("link", "crank_angle").values
            scales.zero_line(axes)
            for number, line in enumerate(values):
                axes.plot(angles, factor * line, **_link_line(number, angles))
            scales.plain_numbers(axes)
            axes.set_ylabel(f"{words}\n({unit})")
        angle_panels.label_angles(drawn, angles)
    return drawn.figure


def plot_joint_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw both components of the force at each joint, by lumped masses too where there are.

    Parameters
    ----------
    dataset : Dataset
        With ``joint_force`` (crank_angle, joint, component) in N, and ``lumped_joint_force`` if
        masses are lumped too; the attributes ``crank_speed`` and ``mechanism``.
    ax : sequence of Axes, optional
        The user's, one a joint. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    angles, joints = reading.degrees(dataset["crank_angle"]), reading.names_of(dataset, "joint")
    components = reading.names_of(dataset, "component")
    factor, unit = reading.fitting_unit(dataset["joint_force"].values, reading.FORCE_UNITS)
    with sheet(angle_panels.angle_layout([1] * len(joints)), ax=ax) as drawn:
        handles = style.series_handles(f"along {name}" for name in components)
        title = f"Joint forces at {reading.speed_text(dataset)}"
        drawn.header([*handles, *_lumped_handle(dataset)], title, of=dataset)
        for axes, joint in zip(drawn.panels, joints, strict=True):
            axes.set_title(f"{joint} ({dataset['joint_kind'].sel(joint=joint).item()})")
            scales.zero_line(axes)
            for number, component in enumerate(components):
                there = dataset.sel(joint=joint, component=component)
                angle_panels.draw_line(axes, angles, factor * there["joint_force"].values, number)
                if "lumped_joint_force" in there:
                    axes.plot(angles, factor * there["lumped_joint_force"].values, **LUMPED)
            scales.plain_numbers(axes)
        angle_panels.label_angles(drawn, angles, f"Force ({unit})")
    return drawn.figure


def plot_drive(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw driving torque and power, and the transmission angles of a four-bar.

    Parameters
    ----------
    dataset : Dataset
        With ``driving_torque`` in N m and ``driving_power`` in W over crank_angle; those by
        lumped masses (``lumped_driving_torque``, ``lumped_driving_power``) and
        ``transmission_angle`` and ``reversed_transmission_angle`` in rad where there are any.
    ax : sequence of Axes, optional
        Two of the user's, three with transmission angles. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    angles = reading.degrees(dataset["crank_angle"])
    both = "transmission_angle" in dataset
    rows = 3 if both else 2
    with sheet(grid(rows, 1, 1.7 * rows + 0.3, sharex=True), ax=ax) as drawn:
        title = f"Drive at {reading.speed_text(dataset)}"
        handles = style.series_handles(("crank drives", "rocker drives") if both else ())
        drawn.header([*handles, *_lumped_handle(dataset)], title, of=dataset)
        shown = (
            ("driving_torque", "Torque", reading.TORQUE_UNITS),
            ("driving_power", "Power", POWER),
        )
        for axes, (name, words, units) in zip(drawn.panels, shown, strict=False):
            factor, unit = reading.fitting_unit(dataset[name].values, units)
            scales.zero_line(axes)
            angle_panels.draw_line(axes, angles, factor * dataset[name].values, 0)
            if f"lumped_{name}" in dataset:
                axes.plot(angles, factor * dataset[f"lumped_{name}"].values, **LUMPED)
            scales.plain_numbers(axes)
            axes.set_ylabel(f"{words} ({unit})")
        if both:
            last = drawn.panels[-1]
            last.axhline(90.0, color=style.LIGHT_GREY, lw=0.6, zorder=0)
            for number, name in enumerate(("transmission_angle", "reversed_transmission_angle")):
                angle_panels.draw_line(last, angles, np.degrees(dataset[name].values), number)
            last.set_ylim(0.0, 180.0)
            last.set_yticks([0, 45, 90, 135, 180])
            last.set_ylabel("Transmission\nangle (deg)")
        angle_panels.label_angles(drawn, angles)
    return drawn.figure


def _link_line(number: int, points: FloatArray | None = None) -> style.Look:
    """Line of a link: a style of its own, wider for those beyond the styles."""
    width = WIDTHS[min(number // STYLES, len(WIDTHS) - 1)]
    return style.series_line(number, points) | {
        "lw": width,
        "color": style.series_style(number).color,
    }


def _lumped_handle(dataset: xr.Dataset) -> list[Artist]:
    if "lumped_joint_force" not in dataset:
        return []
    return [style.line_handle(f"{dataset.sizes['lump']} lumped masses", **LUMPED)]


def plot_transmission_angle(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw transmission angles of linkages over the crank's turn.

    As Elamy et al. 2023, Figure 7.

    Parameters
    ----------
    dataset : Dataset
        With ``transmission_angle`` (linkage, crank_angle) in rad; the names along ``linkage``
        are those of the legend. The attributes ``wanted_least`` and ``wanted_greatest`` in rad
        shade a range, which the legend calls ``wanted_label``; ``title`` is the heading.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no linkages, or more than there are styles to tell them apart.
    """
    names = style.told_apart(reading.names_of(dataset, "linkage"))
    curves = np.degrees(reading.values_of(dataset["transmission_angle"], "linkage", "crank_angle"))
    angles, attrs = reading.degrees(dataset["crank_angle"]), dataset.attrs
    with sheet(grid(1, 1, 3.2), ax=ax) as drawn:
        (axes,) = drawn.panels
        handles = style.series_handles(names)
        if "wanted_least" in attrs:
            wanted = np.degrees([attrs["wanted_least"], attrs["wanted_greatest"]])
            axes.axhspan(*wanted, color=style.LIGHT_GREY, zorder=0)
            words = attrs.get("wanted_label", "wanted range")
            handles.append(Patch(color=style.LIGHT_GREY, label=words))
        drawn.header(handles, str(attrs.get("title", TITLE)), of=dataset)
        axes.axhline(90.0, color=style.MID_GREY, lw=0.6, zorder=1)
        for number, values in enumerate(curves):
            axes.plot(angles, values, **style.series_line(number))
        angle_panels.label_angles(drawn, angles, "Transmission angle (deg)")
    return drawn.figure
