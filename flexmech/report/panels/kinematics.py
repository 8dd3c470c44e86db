"""The rigid linkage: motion, joint forces, drive, balance, coupler curve, transmission angle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import xarray as xr

from flexmech import plots
from flexmech.analyses import Balance, CouplerPaths, Kinematics, ModelCheck
from flexmech.plots.kinematics import (
    MOST_POINTS,
    coupler_picture,
    drawn_points,
    motion_picture,
)
from flexmech.plots.mechanism import transmission_picture
from flexmech.plots.picture import Choice, Picture, joined
from flexmech.plots.shaking import balance_picture
from flexmech.report import panel
from flexmech.report import results as words
from flexmech.report.panel import Plot, plotted
from flexmech.report.results import Results


def kinematics_panel(results: Results) -> panel.Panel | None:
    """Motion of links and points, sizes of joint forces, torque and power.

    Of several speeds those at the one that the reader has chosen.
    """
    found = results.of_kind(Kinematics)
    # Those under a motor have a panel of their own, and stand here where there are no others.
    found = [own for own in found if "motor_torque" not in own.dataset] or found
    if not found:
        return None
    unit = words.speed_unit_of(results)
    names = [words.speed_name(float(one.dataset.attrs["crank_speed"]), unit) for one in found]
    # Under a law of motion all is over time, which has no picture of the page: words tell it.
    shown: list[tuple[Choice, xr.Dataset]] = [
        ({"speed": name} if len(found) > 1 else {}, one.dataset)
        for name, one in zip(names, found, strict=True)
        if "time" not in one.dataset.dims
    ]
    drawn = tuple(_plots(shown)) if shown else ()
    return panel.panel_of("kinematics", panel.told_apart(found, names), plots=drawn)


def _plots(shown: list[tuple[Choice, xr.Dataset]]) -> Iterator[Plot]:
    """Motion of the links and of each point, joint forces and the drive."""

    def plot(name: str, picture: Callable[[xr.Dataset], Picture], title: str) -> Plot:
        return plotted(name, joined([(when, picture(data)) for when, data in shown]), title)

    yield plot("link-motion", plots.plot_kinematics.picture, "Motion of the links")
    for point in drawn_points(shown[-1][1])[:MOST_POINTS]:
        name = f"point-motion-{point}" if point.isalnum() else "point-motion"
        yield plot(name, partial(motion_picture, points=[point]), f"Motion of {point}")
    yield plot("joint-forces", plots.plot_joint_forces.picture, "")
    yield plot("drive", plots.plot_drive.picture, "Driving torque and power")


@panel.shows(CouplerPaths)
def coupler_panel(result: CouplerPaths, results: Results) -> panel.Panel:
    """Coupler curves of each state, with their crunodes and cusps."""
    plot = plotted("coupler", coupler_picture(result.dataset))
    return panel.panel_of("coupler-curve", result.said, plots=(plot,))


@panel.shows(ModelCheck)
def mechanism_panel(result: ModelCheck, results: Results) -> panel.Panel:
    """Links, masses and operation in words and a table, and the transmission angle."""
    data = result.dataset
    if "transmission_angle" not in data:
        return panel.panel_of("mechanism", result.said, "drawn")
    plot = plotted("transmission-angle", transmission_picture(data))
    return panel.panel_of("mechanism", result.said, "transmission_angle", plots=(plot,))


@panel.shows(Balance)
def balance_panel(result: Balance, results: Results) -> panel.Panel:
    """Loads over the crank angle as given and balanced, of elastic links where they were run."""
    plot = plotted("balance", balance_picture(result.dataset))
    return panel.panel_of("balance", result.said, plots=(plot,))
