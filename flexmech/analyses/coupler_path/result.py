"""The result of coupler paths: their tables, pictures and words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import ROUND_OFF
from flexmech.linkages import FourBar

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CouplerPaths(Result):
    """Paths of a coupler point, dry and in an environment, with their crunodes and cusps.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: over ``state`` and ``crank_angle`` the ``position`` of the
        point, its link's pins and angle; of a four-bar's coupler also transmission angles, and
        crossings and cusps over ``double_point``; ``close_up`` of every path around the loops of
        any, and the places that are ``framed`` by it.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "coupler_curve"
    subject = "path of a coupler point"
    hallmark = "pin_position"
    significant_digits = 12
    digits = dict.fromkeys(
        ("theta3_deg", "theta4_deg", "coupler_curve.x_m", "coupler_curve.y_m"), 10
    )

    def tabulated(self) -> xr.Dataset:
        """The dataset with each angle and each passage by itself."""
        data = self.dataset
        passages = (data["double_point_crank_angle"].isel(passage=n, drop=True) for n in (0, 1))
        first, second = passages
        found = data.assign(
            first_passage=first,
            second_passage=second,
            name_of_double_point=data["name"]
            .sel(state=data["double_point_state"])
            .drop_vars("state"),
        )
        if not self.is_curve:
            return found.assign(angle_of_link=data["angle"])
        coupler, rocker = (data["angle"].isel(link=n, drop=True) for n in (0, 1))
        return found.assign(theta3=coupler, theta4=rocker)

    @property
    def is_curve(self) -> bool:
        """Whether it is of the coupler of a four-bar, whose double points are known."""
        return "sextic_residual" in self.dataset

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw curves with their double points, in axes of the user's (one a panel) if given."""
        return plots.plot_coupler_curve(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Lengths, double points, changes, and the check by the sextic."""
        data = self.dataset
        topology = self.tables()["topology"]
        lines = data.attrs["environment_lines"].splitlines()
        for number, name in enumerate(data["name"].values):
            lines += _state_lines(data.isel(state=number), topology[topology["state"] == name])
        if data.sizes["state"] > 1:
            lines += _change_lines(*(data.isel(state=number) for number in (0, 1)))
        check = (
            "check: none, crossings are sought of the coupler of a four-bar alone, and not where "
            "its circuits meet in change points"
        )
        if self.is_curve:
            worst = float(data["sextic_residual"].max())
            check = f"check: the curve's sextic equation is met within {worst:.1e}"
        return Summary(
            tuple(_answer(data, self.is_curve)),
            _states_table(data),
            check,
            tuple(lines),
            tuple(filter(None, [data.attrs.get("warning")])),
            tuple(_numbers(data)),
        )


def _answer(data: xr.Dataset, is_curve: bool) -> Iterator[str]:
    """How large the path is, what crosses in it, and how far the point moves in an environment."""
    what = "coupler point" if is_curve else "point"
    for number, state in enumerate(data["state"].values.tolist()):
        size = _size(data.isel(state=number))
        counts = _counted(data, state) if is_curve else {}
        words = [
            f"{count or 'no'} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()
        ]
        who = f"Dry, the {what} runs" if number == 0 else f"At {state} it runs"
        loops = f", with {' and '.join(words)}" if words else ""
        yield f"{who} through {' by '.join(size)} mm{loops}."
    if data.sizes["state"] > 1:
        moved, at = _moved(data)
        yield f"It is moved by at most {moved:.3g} mm, at crank angle {at:.4g} deg."


def _states_table(data: xr.Dataset) -> Table:
    """A row for each state."""
    limits, rows = data.get("transmission_angle_limit"), []
    for number, state in enumerate(data["state"].values.tolist()):
        own = data.isel(state=number)
        x, y = (1e3 * own["extent"]).transpose("component", "bound").values.tolist()
        cells = [_text(value, own) for value in (*x, *y)]
        if limits is not None:
            angles = DEGREES * limits.isel(state=number).values
            counts = _counted(data, state)
            cells += [*map(str, counts.values()), *(f"{angle:.4g}" for angle in angles)]
        rows.append((state, *cells))
    headings = ["state", "least x mm", "greatest x mm", "least y mm", "greatest y mm"]
    if limits is not None:
        headings += ["crunodes", "cusps", "least µ deg", "greatest µ deg"]
    caption = "" if limits is None else "µ: transmission angle over the whole motion"
    return Table(
        f"path: {data.attrs['mechanism']}", tuple(headings), (tuple(rows),), caption=caption
    )


def _counted(data: xr.Dataset, state: str) -> dict[str, int]:
    """Number of crunodes and of cusps in a state."""
    kinds = data["double_point_kind"].values[data["double_point_state"].values == state]
    return {kind: int((kinds == kind).sum()) for kind in ("crunode", "cusp")}


def _size(state: xr.Dataset) -> list[str]:
    """Extents of a path along x and y in mm."""
    extent = 1e3 * state["extent"].transpose("component", "bound").values
    return [_text(high - low, state) for low, high in extent.tolist()]


def _text(value: float, state: xr.Dataset) -> str:
    """A coordinate in mm; what rounding leaves of a zero is none."""
    noise = 1e3 * ROUND_OFF * float(abs(state["position"]).max())
    return "0" if abs(value) <= noise else rounded(value, noise)


def _moved(data: xr.Dataset) -> tuple[float, float]:
    """Greatest displacement of the point in mm, and the crank angle in degrees."""
    dry, wet = (data["position"].isel(state=number) for number in (0, 1))
    apart = 1e3 * np.hypot(*(wet - dry).transpose("component", ...).values)
    place = int(apart.argmax())
    return float(apart[place]), float(DEGREES * data["crank_angle"].values[place])


def _numbers(data: xr.Dataset) -> Iterator[Quantity]:
    """Extents of each state, its double points and transmission angles, and the displacement."""
    for number, state in enumerate(data["state"].values.tolist()):
        own = data.isel(state=number)
        noise = 1e3 * ROUND_OFF * float(abs(own["position"]).max())
        for axis, (low, high) in zip("xy", 1e3 * own["extent"].values, strict=True):
            yield Quantity(f"extent_{axis}", float(high - low), "mm", noise, state)
        if "transmission_angle_limit" in data:
            for kind, count in _counted(data, state).items():
                yield Quantity(f"{kind}s", count, "", 0.0, state)
            for name, value in zip(
                ("least", "greatest"), own["transmission_angle_limit"].values, strict=True
            ):
                angle = float(DEGREES * value)
                yield Quantity(f"{name}_transmission_angle", angle, "deg", ROUND_OFF * angle, state)
    if data.sizes["state"] > 1:
        yield Quantity("greatest_displacement", _moved(data)[0], "mm")


def _state_lines(state: xr.Dataset, topology: pd.DataFrame) -> list[str]:
    """Lengths and double points of one state."""
    name, distance = state["name"].item(), 1e3 * state["coupler_point_distance"].item()
    lengths = (1e3 * state["length"]).to_series().items()
    named = ", ".join(f"{member} {length:.6g}" for member, length in lengths)
    if "sextic_residual" not in state:
        link = state["link"].values[0]
        return [f"{name}: {named}, point {distance:.6g} mm from the start of the {link}"]
    counts = {kind: int((topology["kind"] == kind).sum()) for kind in ("crunode", "cusp")}
    words = [f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()]
    least, greatest = DEGREES * state["transmission_angle_limit"].values
    linkage, where = FourBar(*state["length"].values.tolist()), ""
    if not linkage.crank_turns_fully:
        where = f" on the whole circuit, both branches ({linkage.grashof_class})"
    return [
        f"{name}: {named}, coupler point {distance:.6g} mm from A",
        f"{name}: transmission angle {least:.5g} to {greatest:.5g} deg",
        f"{name}: {' and '.join(words)}{where}",
        *(
            f"{name}: {kind} at ({1e3 * x:.6g}, {1e3 * y:.6g}) mm, crank angles {first:.6g} and "
            f"{second:.6g} deg"
            for _, _, kind, first, second, x, y in topology.itertuples()
        ),
    ]


def _change_lines(dry: xr.Dataset, wet: xr.Dataset) -> list[str]:
    """Greatest changes from the dry linkage to the wet one."""
    at, lines = DEGREES * dry["crank_angle"].values, []
    symbols = {"coupler": "theta3", "rocker": "theta4"}
    for link in dry["link"].values.tolist():
        symbol = symbols[link] if "sextic_residual" in dry else f"the angle of {link}"
        turned = (wet["angle"] - dry["angle"]).sel(link=link).values
        change = np.degrees(np.angle(np.exp(1j * turned)))
        low, high = change.argmin(), change.argmax()
        lines.append(
            f"change of {symbol}: {change[low]:+.5f} deg (at {at[low]:g} deg) to "
            f"{change[high]:+.5f} deg (at {at[high]:g} deg)"
        )
    what = "coupler point" if "sextic_residual" in dry else "point"
    moved = 1e3 * np.hypot(*(wet["position"] - dry["position"]).values.T)
    return [
        *lines,
        f"{what}: moved by at most {moved.max():.5g} mm, at crank angle {at[moved.argmax()]:g} deg",
    ]
