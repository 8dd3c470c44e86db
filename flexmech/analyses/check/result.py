"""The result that says what is known of a mechanism."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from flexmech import plots
from flexmech.analyses.check.sections import LINK_PROPERTIES, PROPERTIES
from flexmech.analyses.digits import Quantity, plain, rounded
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.analyses.trust import trust_line
from flexmech.arrays import ROUND_OFF
from flexmech.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


ROWS = (*LINK_PROPERTIES, *PROPERTIES)

# What stands in the table of links: variable, heading, and factor from the SI unit.
IN_SHORT = (
    ("length", "length mm", 1e3),
    ("link_mass", "mass g", 1e3),
    ("in_plane_thickness", "thick mm", 1e3),
    ("out_of_plane_width", "wide mm", 1e3),
    ("axial_stiffness", "EA MN", 1e-6),
    ("bending_stiffness", "EI N m²", 1.0),
    ("damping_time_bending", "damping µs", 1e6),
)
_OF_ANY_LINK = ("length", "link_mass")


def _cell(value: float, rigid: bool) -> str:
    """A number of four digits; what is not known of a rigid link is rigid."""
    if np.isnan(value):
        return "rigid" if rigid else "-"
    return plain(value)


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
        """The linkage, its frequencies and links; source, all properties and masses; remarks."""
        attributes = self.dataset.attrs
        return Summary(
            self._answer(),
            self._links_in_short(),
            self._trust(),
            (
                attributes["mechanism"],
                f"source: {attributes['source']}",
                f"file: {attributes['model_file']}, SHA-256 {attributes['model_sha256']}",
                *attributes["linkage"].splitlines(),
                self._link_table(),
                *attributes["mechanism_lines"].splitlines(),
                self._frequency_line(),
            ),
            self.remarks,
            self._numbers(),
        )

    def _answer(self) -> tuple[str, ...]:
        attributes = self.dataset.attrs
        said = (
            attributes.get("flutter", ""),
            attributes.get("linkage_in_short", ""),
            self._vibration(),
            self._undamped(),
        )
        return tuple(filter(None, said))

    def _vibration(self) -> str:
        """Natural frequencies at rest in a sentence."""
        angle = f"crank angle {np.degrees(self.dataset['frequency_angle'].item()):.6g} deg"
        texts = [str(number).removesuffix(" Hz") for number in self._frequencies()]
        if not texts:
            return (
                f"No natural frequencies at {angle}: {self.dataset.attrs['without_frequencies']}."
            )
        listed = ", ".join(texts[:-1]) + (" and " if len(texts) > 1 else "") + texts[-1]
        many = "frequencies are" if len(texts) > 1 else "frequency is"
        return f"The first natural {many} {listed} Hz, at rest and {angle}."

    def _undamped(self) -> str:
        """That no link damps, where none does."""
        times = self.dataset["damping_time_bending"].values
        if not np.isfinite(times).any() or np.nanmax(times) > 0:
            return ""
        return "No link is damped: what rings in it has no bound until damping is stated."

    def _frequencies(self) -> list[Quantity]:
        known = self.dataset
        if "frequency" not in known:
            return []
        frequency = known["frequency"].values
        error = known["discretisation_error"].values * frequency
        pairs = enumerate(zip(frequency.tolist(), error.tolist(), strict=True), start=1)
        name, unit = "natural_frequency", "Hz"
        return [Quantity(name, hz, unit, own, f"mode {mode}") for mode, (hz, own) in pairs]

    def _numbers(self) -> tuple[Quantity, ...]:
        numbers = self._frequencies()
        if "transmission_angle_limit" in self.dataset:
            limits = np.degrees(self.dataset["transmission_angle_limit"].values).tolist()
            for name, value in zip(("least", "greatest"), limits, strict=True):
                numbers.append(
                    Quantity(f"{name}_transmission_angle", value, "deg", ROUND_OFF * value)
                )
        return tuple(numbers)

    def _trust(self) -> str:
        """How far the frequencies are known; there is nothing to doubt in what was read."""
        numbers = self._frequencies()
        if not numbers:
            return ""
        error = max(number.error / number.value if number.value else 0.0 for number in numbers)
        return trust_line([str(self.dataset.attrs["engine"])], error)

    def _links_in_short(self) -> Table:
        """A row for each link with what a designer chooses: size, mass, stiffness, damping."""
        known, rows = self.dataset, []
        without = np.isnan(known["axial_stiffness"].values)
        for number, link in enumerate(known["link"].values.tolist()):
            own = known.isel(link=number)
            cells = [
                _cell(float(own[name]) * scale, bool(without[number]) and name not in _OF_ANY_LINK)
                for name, _, scale in IN_SHORT
            ]
            rows.append((link, *cells))
        headings = ("link", *(heading for _, heading, _ in IN_SHORT))
        return Table(f"links: {known.attrs['mechanism']}", headings, (tuple(rows),))

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
        errors = self.dataset["discretisation_error"].values.tolist()
        listed = ", ".join(
            rounded(hz, hz * error) for hz, error in zip(frequency, errors, strict=True)
        )
        return (
            f"{title}: {listed} Hz ({made}; discretisation error (estimated) at most "
            f"{max(errors):.1e} of the frequency)"
        )
