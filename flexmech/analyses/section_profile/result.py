"""The result about cross-sections: their properties, and what is inside under unit loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import DEGREES, table_over
from flexmech.analyses.requests import link_of
from flexmech.analyses.result import Result
from flexmech.analyses.section_profile.properties import PROPERTIES, STORED
from flexmech.analyses.section_profile.tables import (
    expansion_table,
    expansions_of_plies,
    layer_tables,
    property_table,
)
from flexmech.analyses.summary import Summary, Table
from flexmech.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure


QUANTITIES = ("strain", "normal_stress", "shear_stress", "third_order_shear_stress")


class SectionProfiles(Result):
    """Properties of links' sections, and strain and stress through them under unit loads.

    Parameters
    ----------
    dataset : xarray.Dataset
        Properties over (link, coupling); ``place`` (link, layer, point) and ``strain``,
        ``normal_stress``, ``shear_stress`` and ``third_order_shear_stress`` over (link,
        coupling, load, layer, point); ``thermal_expansion`` and ``moisture_expansion`` of the plies
        over (link, layer, direction). Links with fewer layers or places have NaN after them.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "sections"
    subject = "sections"
    hallmark = "reduction"
    files = ("sections.csv", "through_thickness.csv", "plies.csv", "sections.nc", "section_*.png")

    @property
    def links(self) -> list[str]:
        """Names of the links."""
        return [str(name) for name in self.dataset["link"].values]

    @property
    def links_with_layers(self) -> list[str]:
        """Names of the links of which it is known what is inside."""
        return [name for name in self.links if self.dataset["reduction"].sel(link=name)]

    def profile(self, link: str) -> xr.Dataset:
        """Strain and stress through the thickness of one link.

        Parameters
        ----------
        link : str

        Returns
        -------
        xarray.Dataset
            Over (coupling, load, layer, point), with the places of the neutral axis and the
            centre of mass.

        Raises
        ------
        InputError
            If there is no such link or its layers are not known.
        """
        if link_of(link, self.links) not in self.links_with_layers:
            raise InputError(f"link: {_nothing_known(link)}; choose another link")
        one = self.dataset.sel(link=link)
        for dimension in ("layer", "point"):
            one = one.dropna(dimension, how="all", subset=["place"])
        axes = one[["neutral_axis", "mass_axis"]].sel(coupling="with", drop=True)
        return one.assign(axes)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Properties, two rows a link, profiles, a row for each place, and what plies swell by."""
        data, dims = self.dataset, ("link", "coupling")
        properties = {one.column: data[one.name] for one in PROPERTIES}
        tables = {"sections": table_over(*dims, **{dim: data[dim] for dim in dims}, **properties)}
        if self.links_with_layers:
            profiles = table_over(
                *("link", "load", "coupling", "layer", "point"),
                **{name: data[name] for name in ("link", "load", "coupling", "layer", "ply")},
                angle_deg=(DEGREES * data["angle"]).round(9),
                y_m=data["place"],
                strain=data["strain"],
                **{f"{stress}_Pa": data[stress] for stress in QUANTITIES[1:]},
            )
            tables["through_thickness"] = profiles.dropna(subset="y_m")
            known = {
                link: expansions_of_plies(self.profile(link)) for link in self.links_with_layers
            }
            plies = pd.concat(known, names=["link"]).reset_index("link")
            if not plies.empty:
                tables["plies"] = plies
        return tables

    def figures(self) -> dict[str, Figure]:
        """Strain and stress through each link whose layers are known."""
        return {f"section_{link}": self.plot(link) for link in self.links_with_layers}

    def plot(self, link: str | None = None, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw strain and stress through the thickness of a link.

        Parameters
        ----------
        link : str, optional
            The first one whose layers are known by default.
        ax : sequence of matplotlib.axes.Axes, optional
            Six axes to draw in; of a new figure by default.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If there is no such link or its layers are not known.
        """
        chosen = link or next(iter(self.links_with_layers), self.links[0])
        return plots.plot_section(self.profile(chosen), ax=ax)

    def summary(self) -> Summary:
        """Sections and what is inside them, link by link, and what the loads are."""
        parts: list[Table | str] = []
        for link in self.links:
            parts.append(property_table(self.dataset.sel(link=link)))
            if link in self.links_with_layers:
                parts += layer_tables(self.profile(link)) + expansion_table(self.profile(link))
        if self.links_with_layers:
            parts.append(STORED["unit_loads"])
            if np.nan_to_num(self.dataset["neutral_axis"].values).any():
                parts.append(STORED["without_coupling"])
        parts += [_nothing_known(link) for link in self.links if link not in self.links_with_layers]
        return Summary((*parts, *self.dataset.attrs["environment_lines"].splitlines()))


def _nothing_known(link: str) -> str:
    return (
        f'{link}: section "general" tells its stiffness and mass alone; of strain and stress '
        "through its thickness nothing is known"
    )
