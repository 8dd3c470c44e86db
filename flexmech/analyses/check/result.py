"""The result that says what is known of a mechanism."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from flexmech import plots
from flexmech.analyses.frequencies.words import known_digits
from flexmech.analyses.result import Result
from flexmech.analyses.section_profile.properties import LINK_PROPERTIES, PROPERTIES
from flexmech.analyses.summary import Summary, Table
from flexmech.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


ROWS = (*LINK_PROPERTIES, *PROPERTIES)


class ModelCheck(Result):
    """What is known of a mechanism, and its natural frequencies at rest.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``length``, ``link_mass`` and the properties of the sections over (link); ``frequency`` and
        ``discretisation_error`` (mode) at ``frequency_angle``, if the linkage can stand there; and
        what the picture shows, if it can stand somewhere: at ``posture_angle`` ``rigid_position``
        (link, station, component), ``joint_position`` (joint, component) and masses, over the turn
        ``path`` and ``transmission_angle``, and the layers of the sections.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "check"
    subject = "check"
    hallmark = "link_mass"
    files = ("check.csv", "check.nc", "check.png")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Every number of a link or mode with its unit, a row for each."""
        known = self.dataset
        rows = [
            (link, one.name, float(known[one.name].sel(link=link)), one.unit)
            for one in ROWS
            for link in known["link"].values
        ]
        for name, unit in (("frequency", "Hz"), ("discretisation_error", "1")):
            values = known[name].values if name in known else ()
            rows += [(f"mode {n}", name, float(one), unit) for n, one in enumerate(values, start=1)]
        return {"check": pd.DataFrame(rows, columns=["of", "quantity", "value", "unit"])}

    @property
    def remarks(self) -> tuple[str, ...]:
        """What an engineer would remark on: numbers that can be, and hardly are."""
        return tuple(str(self.dataset.attrs.get("remarks", "")).splitlines())

    def figures(self) -> dict[str, Figure]:
        """The mechanism, if it can be assembled at any crank angle."""
        return {"check": self.plot()} if "rigid_position" in self.dataset else {}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the mechanism: posture and paths, sections to scale, and transmission angle.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Three, or two for an arm, which has no transmission angle; of a new figure by default.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the linkage can be assembled at no crank angle, or the axes are too few or too many.
        """
        if "rigid_position" not in self.dataset:
            reason = self.dataset.attrs["without_frequencies"]
            raise InputError(f"no picture of the linkage: {reason}")
        return plots.plot_mechanism(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Source, geometry, links, masses, operation, heat and moisture, frequencies, remarks."""
        attributes = self.dataset.attrs
        return Summary(
            (
                attributes["mechanism"],
                f"source: {attributes['source']}",
                f"file: {attributes['model_file']}, SHA-256 {attributes['model_sha256']}",
                *attributes["linkage"].splitlines(),
                self._link_table(),
                *attributes["mechanism_lines"].splitlines(),
                self._frequency_line(),
            ),
            warnings=self.remarks,
        )

    def _link_table(self) -> Table:
        """Properties of the links, a column for each; what no link has is left out."""
        rows = []
        without = np.isnan(self.dataset["axial_stiffness"].values)
        for one in ROWS:
            values = self.dataset[one.name].values
            if np.nan_to_num(values).any() or one.name.startswith("damping"):
                words, *numbers = one.row(values)
                if one in PROPERTIES:
                    numbers = [
                        "rigid" if rigid else number
                        for rigid, number in zip(without, numbers, strict=True)
                    ]
                rows.append((words, *numbers))
        return Table("links", ("property", *self.dataset["link"].values), (tuple(rows),))

    def _frequency_line(self) -> str:
        attributes = self.dataset.attrs
        angle = np.degrees(self.dataset["frequency_angle"].item())
        title = f"natural frequencies at rest, crank angle {angle:.6g} deg"
        if "frequency" not in self.dataset:
            return f"{title}: none ({attributes['without_frequencies']})"
        engine, elements = attributes["engine"], attributes["elements"]
        made = f"{engine} engine, {elements} elements a link"
        frequency = self.dataset["frequency"].values.tolist()
        if "discretisation_error" not in self.dataset:
            # A file of an earlier version.
            return f"{title}: {', '.join(f'{hz:.4f}' for hz in frequency)} Hz ({made})"
        errors = self.dataset["discretisation_error"].values.tolist()
        listed = ", ".join(map(known_digits, frequency, errors))
        return (
            f"{title}: {listed} Hz ({made}; discretisation error (estimated) at most "
            f"{max(errors):.1e} of the frequency)"
        )
