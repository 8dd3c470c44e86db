"""The result about cross-sections: their properties, and what is inside under unit loads."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.analyses.requests import link_of
from flexmech.analyses.result import Result
from flexmech.analyses.section_profile.properties import PROPERTIES
from flexmech.analyses.section_profile.tables import LOADS_IN_WORDS, layer_tables, property_table
from flexmech.analyses.summary import Summary, Table
from flexmech.errors import InputError
from flexmech.plots import plot_section

__all__ = ["SectionProfiles"]

PROFILE_COLUMNS = {
    "link": "link",
    "load": "load",
    "coupling": "coupling",
    "layer": "layer",
    "ply": "ply",
    "angle": "angle_deg",
    "place": "y_m",
    "strain": "strain",
    "normal_stress": "normal_stress_Pa",
    "shear_stress": "shear_stress_Pa",
    "third_order_shear_stress": "third_order_shear_stress_Pa",
}


class SectionProfiles(Result):
    """Properties of links' sections, and strain and stress through them under unit loads.

    Parameters
    ----------
    dataset : xarray.Dataset
        Properties over (link, coupling); ``place`` (link, layer, point) and ``strain``,
        ``normal_stress``, ``shear_stress`` and ``third_order_shear_stress`` over (link,
        coupling, load, layer, point). Links with fewer layers or places have NaN after them.
    """

    stem = "sections"
    hallmark = "third_order_shear_stress"
    files = ("sections.csv", "through_thickness.csv", "sections.nc", "section_*.png")

    @property
    def links(self) -> list[str]:
        """Names of the links."""
        return [str(name) for name in self.dataset["link"].values]

    @property
    def links_with_layers(self) -> list[str]:
        """Names of the links of which it is known what is inside."""
        known = self.dataset["place"].notnull().any(["layer", "point"])
        return [name for name in self.links if known.sel(link=name)]

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
        one = self.dataset.sel(link=link).drop_vars([p.name for p in PROPERTIES])
        axes = self.dataset[["neutral_axis", "mass_axis"]].sel(
            link=link, coupling="with", drop=True
        )
        for dimension in ("layer", "point"):
            one = one.dropna(dimension, how="all", subset=["place"])
        return one.merge(axes)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Properties, two rows a link, and profiles, a row for each load, coupling and place."""
        properties = self.dataset[[one.name for one in PROPERTIES]].reset_coords(drop=True)
        frame = properties.to_dataframe(dim_order=["link", "coupling"]).reset_index()
        tables = {"sections": frame.rename(columns={one.name: one.column for one in PROPERTIES})}
        if self.links_with_layers:
            inside = self.dataset.drop_vars([one.name for one in PROPERTIES])
            order = ["link", "load", "coupling", "layer", "point"]
            frame = inside.to_dataframe(dim_order=order).reset_index().dropna(subset="place")
            frame["angle"] = np.round(np.degrees(frame["angle"]), 9)
            chosen = frame[list(PROFILE_COLUMNS)]
            tables["through_thickness"] = chosen.rename(columns=PROFILE_COLUMNS)
        return tables

    def figures(self) -> dict[str, Figure]:
        """Strain and stress through each link whose layers are known."""
        return {f"section_{link}": self.plot(link) for link in self.links_with_layers}

    def plot(self, link: str | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw strain and stress through the thickness of a link.

        Parameters
        ----------
        link : str, optional
            The first one whose layers are known by default.
        ax : matplotlib.axes.Axes, optional
            Not used.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If there is no such link or its layers are not known.
        """
        chosen = link or next(iter(self.links_with_layers), self.links[0])
        return plot_section(self.profile(chosen))

    def summary(self) -> Summary:
        """Sections and what is inside them, link by link, and what the loads are."""
        parts: list[Table | str] = []
        for link in self.links:
            parts.append(property_table(self.dataset.sel(link=link)))
            if link in self.links_with_layers:
                parts += layer_tables(self.profile(link))
        parts += LOADS_IN_WORDS if self.links_with_layers else ()
        parts += [_nothing_known(link) for link in self.links if link not in self.links_with_layers]
        return Summary((*parts, *self.dataset.attrs["environment_lines"].splitlines()))


def _nothing_known(link: str) -> str:
    return (
        f'{link}: section "general" tells its stiffness and mass alone; of strain and stress '
        "through its thickness nothing is known"
    )
