"""The result that says what is known of a mechanism."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech import plots
from flexmech.analyses.result import Result
from flexmech.analyses.section_profile.properties import PROPERTIES, Property
from flexmech.analyses.summary import Summary, Table
from flexmech.errors import InputError

__all__ = ["LENGTH", "LINK_MASS", "ModelCheck"]

LENGTH = Property("length", "m", "m", "length", "mm", 1e3)
LINK_MASS = Property("link_mass", "kg", "kg", "mass without point masses", "g", 1e3)
ZERO_CELSIUS = 273.15


class ModelCheck(Result):
    """What is known of a mechanism, and its natural frequencies at rest.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``length``, ``link_mass`` and the properties of the sections over (link),
        ``joint_mass`` over (joint), ``frequency`` over (mode) and positions of the links at
        crank angle 0; without the last two where the linkage cannot stand there.
    """

    stem = "check"
    hallmark = "link_mass"
    files = ("check.csv", "check.nc", "check.png")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Every number of a link or mode with its unit, a row for each."""
        rows = [
            (link, one.name, value, one.unit)
            for one in (LENGTH, LINK_MASS, *PROPERTIES)
            for link, value in zip(self._links, self.dataset[one.name].values, strict=True)
        ]
        for mode, frequency in enumerate(self._frequencies, start=1):
            rows.append((f"mode {mode}", "frequency", frequency, "Hz"))
        return {"check": pd.DataFrame(rows, columns=["of", "quantity", "value", "unit"])}

    def figures(self) -> dict[str, Figure]:
        """The linkage at crank angle 0, if it can stand there."""
        return {"check": self.plot()} if "rigid_position" in self.dataset else {}

    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Draw the linkage at crank angle 0.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw in; of a new figure by default.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the linkage cannot stand at crank angle 0.
        """
        if "rigid_position" not in self.dataset:
            raise InputError(f"no picture of the linkage: {self.dataset.attrs['without_frequencies']}")
        return plots.plot_linkage(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Source, geometry, links, masses, operation, heat and moisture, and frequencies."""
        attributes = self.dataset.attrs
        return Summary(
            (
                attributes["mechanism"],
                f"source: {attributes['source']}",
                f"file: {attributes['model_file']}, SHA-256 {attributes['model_sha256']}",
                *attributes["linkage"].splitlines(),
                self._link_table(),
                *self._mass_lines(),
                *self._operation_lines(),
                *self._environment_lines(),
                self._frequency_line(),
            )
        )

    @property
    def _links(self) -> list[str]:
        return [str(name) for name in self.dataset["link"].values]

    @property
    def _frequencies(self) -> list[float]:
        known = "frequency" in self.dataset
        return self.dataset["frequency"].values.tolist() if known else []

    def _link_table(self) -> Table:
        """Properties of the links, a column for each; what no link has is left out."""
        shown = [LENGTH, LINK_MASS]
        shown += [one for one in PROPERTIES if np.nan_to_num(self.dataset[one.name]).any()]
        times = [one for one in PROPERTIES if one.name.startswith("damping_time")]
        of_links = np.array([self.dataset[one.name].values for one in times])
        if np.all(of_links == of_links[0]):
            times = [times[0]._replace(words="damping time")]
        shown = [one for one in shown if not one.name.startswith("damping_time")] + times
        rows = tuple(
            (one.label, *map(one.text, self.dataset[one.name].values.tolist())) for one in shown
        )
        return Table("links", ("property", *self._links), (rows,))

    def _mass_lines(self) -> list[str]:
        known = self.dataset
        joints = zip(known["joint"].values, known["joint_mass"].values, strict=True)
        names = ("point_mass_link", "point_mass", "point_mass_position")
        points = zip(*(known[name].values for name in names), strict=True)
        at_joints = [f"{joint} {_milli(mass)} g" for joint, mass in joints if mass]
        on_links = [f"{link} {_milli(mass)} g at {_milli(x)} mm" for link, mass, x in points]
        total = sum(float(known[name].sum()) for name in ("link_mass", "joint_mass", "point_mass"))
        return [
            f"joint masses: {', '.join(at_joints) or 'none'}",
            f"link point masses: {', '.join(on_links) or 'none'}",
            f"total mass: {_milli(total)} g",
        ]

    def _operation_lines(self) -> list[str]:
        x, y = self.dataset["gravity"].values
        speeds = [
            f"{speed:.6g} rad/s ({speed * 30 / np.pi:.4g} rpm)"
            for speed in self.dataset["operating_speed"].values
        ]
        lines = [
            f"gravity: ({x:g}, {y:g}) m/s^2",
            f"operating speeds: {', '.join(speeds) or 'none stated'}",
        ]
        if "coupler_point_distance" in self.dataset.attrs:
            distance, angle = (
                self.dataset.attrs[f"coupler_point_{name}"] for name in ("distance", "angle")
            )
            lines.append(f"coupler point: {_milli(distance)} mm from A, {np.degrees(angle):.6g} deg")
        return lines

    def _environment_lines(self) -> list[str]:
        """What heat and water do to which links; none where nothing is known."""
        changed, wet = (
            ", ".join(self.dataset["link"].values[self.dataset[name].values])
            for name in ("changed_by_environment", "takes_up_water")
        )
        celsius = self.dataset.attrs["reference_temperature"] - ZERO_CELSIUS
        line = (
            f"heat and moisture change: {changed}; water enters: {wet or 'none'}; reference "
            f"temperature {celsius:.4g} degC"
        )
        return [line] if changed else []

    def _frequency_line(self) -> str:
        attributes = self.dataset.attrs
        title = "natural frequencies at rest, crank angle 0 deg"
        if not self._frequencies:
            return f"{title}: none ({attributes['without_frequencies']})"
        listed = ", ".join(f"{frequency:.4f}" for frequency in self._frequencies)
        engine, elements = attributes["engine"], attributes["elements"]
        return f"{title}: {listed} Hz ({engine} engine, {elements} elements a link)"


def _milli(value: float) -> str:
    """Write a length in mm or a mass in g."""
    return f"{value * 1e3:.6g}"
