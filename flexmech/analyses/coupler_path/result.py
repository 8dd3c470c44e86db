"""The result of coupler paths: their tables, pictures and words."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.analyses.tables import table_over
from flexmech.plots import plot_coupler_angles, plot_coupler_curve

__all__ = ["CouplerPaths"]


class CouplerPaths(Result):
    """Paths of a coupler point, dry and in an environment, with their crunodes and cusps.

    Parameters
    ----------
    dataset : xarray.Dataset
        Over ``state`` and ``crank_angle``: ``position`` of the point, ``pin_position`` of the
        pins A and B, and ``angle`` of coupler and rocker without jumps. Over ``state``:
        ``length`` between the pins of each member, ``coupler_point_distance`` from A and
        ``coupler_point_angle`` from A-B, ``grashof_class``, and ``sextic_residual``, the greatest
        residual of the curve's equation. Of the whole curves: ``double_point_position`` and
        ``double_point_crank_angle`` of both passages over ``double_point``. ``close_up`` of every
        path around the loops of any, and the places that are ``framed`` by it.
    """

    stem = "coupler_curve"
    hallmark = "pin_position"
    files = (
        "coupler_curve.csv",
        "topology.csv",
        "coupler_curve.nc",
        "coupler_curve.png",
        "coupler_angles.png",
    )
    significant_digits = 12
    digits = dict.fromkeys(
        ("theta3_deg", "theta4_deg", "coupler_curve.x_m", "coupler_curve.y_m"), 10
    )

    @property
    def _names(self) -> dict[str, str]:
        """Short names of the states by their labels: the dry linkage comes first."""
        return dict(zip(self.dataset["state"].values.tolist(), ("dry", "wet"), strict=False))

    def _named(self, state: str) -> xr.DataArray:
        return xr.apply_ufunc(self._names.get, self.dataset[state], vectorize=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Path at each crank angle, and the double points of the whole curves."""
        data = self.dataset
        angle, position = np.degrees(data["angle"]), data["position"]
        curve = table_over(
            *("state", "crank_angle"),
            state=self._named("state"),
            crank_angle_deg=np.degrees(data["crank_angle"]).round(9),
            theta3_deg=angle.sel(link="coupler"),
            theta4_deg=angle.sel(link="rocker"),
            x_m=position.sel(component="x"),
            y_m=position.sel(component="y"),
        )
        passage, place = np.degrees(data["double_point_crank_angle"]), data["double_point_position"]
        topology = table_over(
            "double_point",
            state=self._named("double_point_state"),
            kind=data["double_point_kind"],
            crank_angle_1_deg=passage.isel(passage=0),
            crank_angle_2_deg=passage.isel(passage=1),
            x_m=place.sel(component="x"),
            y_m=place.sel(component="y"),
        )
        return {"coupler_curve": curve, "topology": topology}

    def figures(self) -> dict[str, Figure]:
        """Curves with their double points, and the angles of coupler and rocker."""
        return {"coupler_curve": self.plot(), "coupler_angles": plot_coupler_angles(self.dataset)}

    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Draw the curves with their double points, in axes of the user's if they are given."""
        return plot_coupler_curve(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Lengths, double points, changes, and the check by the sextic."""
        names, worst = self._names, float(self.dataset["sextic_residual"].max())
        lines = (
            *self.dataset.attrs["environment_lines"].splitlines(),
            *(self._length_line(label) for label in names),
            *(line for label in names for line in self._topology_lines(label)),
            *(self._change_lines() if len(names) > 1 else ()),
        )
        return Summary(lines, f"check: the curve's sextic equation is met within {worst:.1e}")

    def _length_line(self, label: str) -> str:
        state = self.dataset.sel(state=label)
        lengths = (1e3 * state["length"]).to_series().items()
        distance = 1e3 * float(state["coupler_point_distance"])
        named = ", ".join(f"{member} {length:.6g}" for member, length in lengths)
        return f"{self._names[label]}: {named}, coupler point {distance:.6g} mm from A"

    def _topology_lines(self, label: str) -> list[str]:
        state, name = self.dataset.sel(state=label), self._names[label]
        doubles = self.tables()["topology"].query("state == @name")
        counts = {kind: int((doubles["kind"] == kind).sum()) for kind in ("crunode", "cusp")}
        words = [f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()]
        where = ""
        if not state["crank_turns_fully"]:
            where = f" on the whole circuit, both branches ({state['grashof_class'].item()})"
        return [f"{name}: {' and '.join(words)}{where}"] + [
            f"{name}: {kind} at ({1e3 * x:.6g}, {1e3 * y:.6g}) mm, crank angles {first:.6g} and "
            f"{second:.6g} deg"
            for _, _, kind, first, second, x, y in doubles.itertuples()
        ]

    def _change_lines(self) -> list[str]:
        """Greatest changes from the dry linkage to the wet one."""
        dry, wet = (self.dataset.isel(state=number) for number in (0, 1))
        at = np.degrees(dry["crank_angle"].values)
        lines = []
        for link, symbol in (("coupler", "theta3"), ("rocker", "theta4")):
            turned = (wet["angle"] - dry["angle"]).sel(link=link).values
            change = np.degrees(np.angle(np.exp(1j * turned)))
            low, high = change.argmin(), change.argmax()
            lines.append(
                f"change of {symbol}: {change[low]:+.5f} deg (at {at[low]:g} deg) to "
                f"{change[high]:+.5f} deg (at {at[high]:g} deg)"
            )
        moved = 1e3 * np.hypot(*(wet["position"] - dry["position"]).values.T)
        return [
            *lines,
            f"coupler point: moved by at most {moved.max():.5g} mm, at crank angle "
            f"{at[moved.argmax()]:g} deg",
        ]
