"""Cross-sections of a mechanism's links: stiffness, mass and coupling, and what is inside them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.check.sections import (
    COUPLINGS,
    DIRECTIONS,
    PROPERTIES,
    STORED,
    section_dataset,
)
from flexmech.analyses.datasets import Columns, columns_along, origin, table_of
from flexmech.analyses.digits import Quantity, plain
from flexmech.analyses.options import SectionOptions
from flexmech.analyses.requests import asks, environment_of, link_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table, environment_lines
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.materials.laminate import stacking_text
from flexmech.mechanics import checked_mechanism
from flexmech.mechanism import Mechanism

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Columns of the table of sections, and their variables.
_SECTIONS = {
    **{name: name for name in ("link", "coupling")},
    **{one.column: one.name for one in PROPERTIES},
}


@asks(SectionOptions)
def section_profiles(mechanism: Mechanism, asked: SectionOptions) -> SectionProfiles:
    """Properties of the links' sections, and strain and stress in them under unit loads.

    The loads are 1 N along the pins' axis (not the neutral axis: with coupling it bends the
    link), 1 N m that stretches the side of lower y, and 1 N along y on the face towards
    higher x.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.

    Returns
    -------
    SectionProfiles

    Raises
    ------
    InputError
        If there is no such link, or as :func:`flexmech.mechanism_in_state`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    >>> sections = flexmech.section_profiles(mechanism, "coupler").dataset
    >>> sections["bending_stiffness"].values.round(2)
    array([[62.13, 89.8 ]])
    """
    names = checked_mechanism(mechanism).links_with_sections
    link, environment = asked.link, asked.environment
    chosen = names if link is None else [link_of(link, names)]
    if not chosen:
        raise InputError(
            "links: none has a section, all are rigid; give one of them a section, such as "
            'section = "rectangle"'
        )
    words: list[str] = []
    if environment is not None:
        words = environment_lines(mechanism, environment_of(environment))
        mechanism = mechanism_in_state(mechanism, environment)
    dataset = section_dataset({name: mechanism.sections[name] for name in chosen})
    attributes = origin(mechanism) | {"environment_lines": "\n".join(words)}
    return SectionProfiles(SectionProfiles.schema().labelled(dataset).assign_attrs(attributes))


class SectionProfiles(Result):
    """Properties of links' sections, and strain and stress through them under unit loads.

    Parameters
    ----------
    dataset : xarray.Dataset
        Properties over (link, coupling); ``direction_of_layers`` (link), ``through thickness`` or
        ``across width``; ``layer_thickness`` (link, layer), ``place`` (link, layer, point) and
        ``strain``, ``normal_stress``, ``shear_stress`` and ``third_order_shear_stress`` over (link,
        coupling, load, layer, point); ``thermal_expansion`` and ``moisture_expansion`` of the plies
        over (link, layer, direction). Links with fewer layers or places have NaN after them.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "sections"
    subject = "sections"
    hallmark = "reduction"
    files = ("sections.csv", "plies.csv", "section_*.png")

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
        sections = table_of(self.dataset, ("link", "coupling"), _SECTIONS)
        tables = {"sections": sections, **super().tables()}
        if self.links_with_layers:
            known = {
                link: expansions_of_plies(self.profile(link)) for link in self.links_with_layers
            }
            plies = pd.concat(known, names=["link"]).reset_index("link")
            if not plies.empty:
                tables["plies"] = plies
        return tables

    def figures(self, *, details: bool = True) -> dict[str, Figure]:
        """Strain and stress through each laminate.

        In a link of one material they are straight lines and a parabola: a picture adds nothing.
        """
        laminates = (
            link for link in self.links_with_layers if self.profile(link).sizes["layer"] > 1
        )
        return {f"section_{link}": self.plot(link) for link in laminates}

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
        """Stiffness, mass and coupling; then sections and what is inside them, link by link."""
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
        whole = (_composition(self.dataset.sel(link=link)) for link in self.links)
        short = (text.split(", ")[0].removeprefix("rectangle of ") for text in whole)
        made_of = ["as stated" if text == _STATED_ALONE else text for text in short]
        return Summary(
            _answer(self.dataset),
            _links_table(self.dataset, made_of),
            EXACT if self.links_with_layers else STATED,
            (*parts, *self.dataset.attrs["environment_lines"].splitlines()),
            numbers=_numbers(self.dataset),
        )


def _nothing_known(link: str) -> str:
    return (
        f'{link}: section "general" tells its stiffness and mass alone; of strain and stress '
        "through its thickness nothing is known"
    )


_STRAIN = ((1e-6, "1e-6"),)
_STRESSES = ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
# Construction of a section that is stated by its numbers.
_STATED_ALONE = "by its stiffness and mass"
# What rounding leaves of a zero, over the largest value of its column.
_ZERO = 1e-9


def property_table(section: xr.Dataset) -> Table:
    """Tabulate a section, and beside it without its axial-bending coupling if it has any.

    Parameters
    ----------
    section : xarray.Dataset
        Section of one link.

    Returns
    -------
    Table
    """
    title = f"{section['link'].item()}: {_composition(section)}"
    if not section["neutral_axis"].any():
        alone = section.sel(coupling=["with"])
        rows = tuple(one.row(alone[one.name].values) for one in PROPERTIES)
        return Table(title, ("property", "value"), (rows,))
    values = [(one, section[one.name].values) for one in PROPERTIES]
    rows = tuple((*one.row(both), _change(*both)) for one, both in values)
    return Table(title, ("property", "with coupling", "without coupling", "change"), (rows,))


def layer_tables(profile: xr.Dataset) -> list[Table]:
    """Tabulate strain and stress under unit loads, with and without coupling if there is any.

    Parameters
    ----------
    profile : xarray.Dataset
        Profile of one link whose layers are known.

    Returns
    -------
    list of Table
    """
    title = f"{profile['link'].item()} under unit loads"
    if not profile["neutral_axis"]:
        return [_layer_table(profile.sel(coupling="with"), title)]
    return [_layer_table(profile.sel(coupling=c), f"{title}, {c} coupling") for c in COUPLINGS]


def _layer_table(profile: xr.Dataset, title: str) -> Table:
    headings, columns = ["layer", "y (mm)"], [_without_noise(1e3 * profile["place"].values)]
    for heading, name, load in STORED["inside"]:
        values = _without_noise(profile[name].sel(load=load).values)
        factor, unit = _readable_unit(values, _STRAIN if name == "strain" else _STRESSES)
        headings.append(f"{heading} ({unit})")
        columns.append(values / factor)
    stack, runs = _stack(profile), profile["run"].values
    groups = []
    # The highest layer stands at the top, as in the link.
    for run in np.unique(runs)[::-1]:
        ply, angle = stack[(runs == run).argmax()]
        label = stacking_text([(ply, angle)])[1:-1] if ply else "one material"
        # Normal stress is linear and shear stress quadratic in a run of equal layers: its two
        # faces and its middle say it all.
        inside = np.array([values[runs == run].ravel() for values in columns])
        middle = np.abs(inside[0] - inside[0, [0, -1]].mean()).argmin()
        cells = inside[:, [-1, middle, 0]].T
        groups.append(
            tuple(
                (word, *(f"{value:.4g}" for value in row))
                for word, row in zip(("", label, ""), cells, strict=True)
            )
        )
    return Table(title, tuple(headings), tuple(groups))


def _readable_unit(values: FloatArray, units: Sequence[tuple[float, str]]) -> tuple[float, str]:
    """The greatest unit in which the largest value is one at least, or the least of them."""
    largest = np.abs(values).max()
    return next(((factor, name) for factor, name in units if largest >= factor), units[-1])


def _without_noise(values: FloatArray) -> FloatArray:
    return np.where(np.abs(values) < _ZERO * np.abs(values).max(), 0.0, values)


def _composition(section: xr.Dataset) -> str:
    """Say in one line what a section is made of, from its lowest y up."""
    reduction = section["reduction"].item()
    if not reduction:
        return _STATED_ALONE
    stack = _stack(section.isel(layer=section["run"].values > 0))
    if stack == [("", 0.0)]:
        return "rectangle of one material"
    tail = "" if reduction == "narrow" else f", {reduction}"
    if section["direction_of_layers"] == "across width":
        tail = " across the width"
    return f"{stacking_text(stack)}, {len(stack)} layers{tail}"


def _stack(section: xr.Dataset) -> list[tuple[str, float]]:
    """Ply and angle in degrees of each layer."""
    degrees = np.round(np.degrees(section["angle"].values), 6)
    return list(zip(section["ply"].values.tolist(), degrees.tolist(), strict=True))


def _change(first: float, other: float) -> str:
    """Relative change in percent; nothing where there is none, or from or to zero."""
    ratio = other / first if first else np.nan
    return "" if np.isnan(ratio) or ratio in (0.0, 1.0) else f"{100 * (ratio - 1):+.4g} %"


# Printed in the units in which tables of resins have them.
_MICROSTRAIN, _MILLISTRAIN = 1e6, 1e3
_CAPTION = (
    "free strain along and across the fibres; % is mass of water over the dry mass of the resin "
    "(Schapery; Singh & Sanyal 2022, eqs. 7 and 8, corrected)"
)


def expansions_of_plies(profile: xr.Dataset) -> pd.DataFrame:
    """Expansion coefficients of the different plies of one link.

    Parameters
    ----------
    profile : xarray.Dataset
        Profile of one link whose layers are known, with ``thermal_expansion`` in 1/K and
        ``moisture_expansion`` per unit of moisture over (layer, direction).

    Returns
    -------
    pandas.DataFrame
        One row a ply, none if nothing is stated of any; per K and per percent of moisture.
    """
    heat, water = profile["thermal_expansion"], profile["moisture_expansion"]
    columns: Columns = {
        "ply": "ply",
        **columns_along("thermal_expansion_{}_per_K", heat, "direction"),
        **columns_along("moisture_expansion_{}_per_percent", water / 100, "direction"),
    }
    rows = table_of(profile, ("layer",), columns).drop_duplicates(ignore_index=True)
    return rows if rows.drop(columns="ply").to_numpy().any() else rows[:0]


def expansion_table(profile: xr.Dataset) -> list[Table]:
    """Tabulate the expansion of a link's plies; no table where nothing is stated of any.

    Parameters
    ----------
    profile : xarray.Dataset
        As of :func:`expansions_of_plies`.

    Returns
    -------
    list of Table
    """
    rows = expansions_of_plies(profile)
    if rows.empty:
        return []
    headings = (
        "ply",
        *(f"heat, {name} (1e-6/K)" for name in DIRECTIONS),
        *(f"water, {name} (1e-3/%)" for name in DIRECTIONS),
    )
    cells = tuple(
        (
            str(ply) or "one material",
            *(f"{_MICROSTRAIN * value:.5g}" for value in values[:2]),
            *(f"{_MILLISTRAIN * value:.5g}" for value in values[2:]),
        )
        for ply, *values in rows.itertuples(index=False)
    )
    title = f"{profile['link'].item()}: swelling of its plies"
    return [Table(title, headings, (cells,), caption=_CAPTION)]


EXACT = "numbers are exact within the theory of laminated beams; nothing is meshed"
STATED = "stiffness and mass are those that the model file states"
"""Sentence on errors: sections are integrated over their layers in closed form."""

_SPECIFIC = "specific_damping_bending"
# Columns of the table: variable, heading, and factor from the SI unit.
_COLUMNS = (
    ("axial_stiffness", "EA MN", 1e-6),
    ("bending_stiffness", "EI N m²", 1.0),
    ("membrane_modulus", "tension GPa", 1e-9),
    ("flexural_modulus", "bending GPa", 1e-9),
    ("mass_per_length", "kg/m", 1.0),
    ("neutral_axis", "neutral axis mm", 1e3),
    (_SPECIFIC, "damping %", 1e2),
)
# The column of metals, whose specific damping is not stated.
_TIME = ("damping_time_bending", "damping µs", 1e6)
_NUMBERS = (
    ("axial_stiffness", "N", 1.0),
    ("bending_stiffness", "N m^2", 1.0),
    ("membrane_modulus", "GPa", 1e-9),
    ("flexural_modulus", "GPa", 1e-9),
    ("mass_per_length", "kg/m", 1.0),
    ("neutral_axis", "mm", 1e3),
)
# Letters of a stack in the table: a third of a page of 80; the whole stack stands in the details.
_LONGEST_STACK = 24
# So many links with coupling are named; of more the answer gives the number.
_MOST_NAMED = 2


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """How stiff and heavy the links are, and what the coupling of unsymmetric stacks does.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``SectionProfiles`` result.

    Returns
    -------
    tuple of str
        Sentences.
    """
    with_coupling = data.sel(coupling="with")
    links = [str(name) for name in with_coupling["link"].values]
    who = f"The {links[0]} is" if len(links) == 1 else "The links are"
    moduli = [
        _range(with_coupling[name], 1e-9) for name in ("membrane_modulus", "flexural_modulus")
    ]
    mass = _range(with_coupling["mass_per_length"])
    if all(moduli):
        bar = "a solid bar" if len(links) == 1 else "solid bars"
        tension, bending = moduli
        stiff = f"of {tension} GPa in tension and of {bending} GPa in bending"
        if tension == bending:
            stiff = f"of {tension} GPa in tension and bending"
        whose = "its" if len(links) == 1 else "their"
        first = f"{who} as stiff as {bar} {stiff}; {whose} mass is {mass} kg/m."
    else:
        tension, bending = (
            _range(with_coupling["axial_stiffness"], 1e-6),
            _range(with_coupling["bending_stiffness"]),
        )
        first = f"EA is {tension} MN, EI {bending} N m², the mass {mass} kg/m."
    return (first, *_on_coupling(data, links))


def _on_coupling(data: xr.Dataset, links: Sequence[str]) -> Iterator[str]:
    """Sentence on an unsymmetric stack that bends under tension, and its cost."""
    coupled = [link for link in links if float(data["neutral_axis"].sel(link=link)[0])]
    for link in coupled if len(coupled) <= _MOST_NAMED else ():
        of_link = data.sel(link=link)
        away = 1e3 * abs(float(of_link["neutral_axis"].sel(coupling="with")))
        with_it, without = (
            float(of_link["bending_stiffness"].sel(coupling=c)) for c in ("with", "without")
        )
        yield (
            f"Tension bends the {link}: its neutral axis is {away:.4g} mm off the pins' axis, and "
            f"the coupling leaves {100 * with_it / without:.3g} % of EI."
        )
    if len(coupled) > _MOST_NAMED:
        yield f"Tension bends {len(coupled)} links, whose neutral axes are off the pins' axis."


def _range(values: xr.DataArray, factor: float = 1.0) -> str:
    """Least and greatest of several links; empty where one of them is not known."""
    numbers = factor * values.values.astype(float)
    if not np.isfinite(numbers).all():
        return ""
    return " to ".join(dict.fromkeys(plain(one) for one in (numbers.min(), numbers.max())))


def _links_table(data: xr.Dataset, made_of: Sequence[str]) -> Table:
    """A row for each link.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``SectionProfiles`` result.
    made_of : sequence of str
        What each link is made of.

    Returns
    -------
    Table
    """
    with_coupling, rows = data.sel(coupling="with"), []
    shown = [column for column in _COLUMNS if _says(with_coupling, column[0])]
    if not _says(with_coupling, _SPECIFIC) and _says(with_coupling, _TIME[0]):
        shown.append(_TIME)
    for number, link in enumerate(with_coupling["link"].values.tolist()):
        cells = (_cell(factor * with_coupling[name].values[number]) for name, _, factor in shown)
        text = made_of[number]
        cut = text if len(text) <= _LONGEST_STACK else f"{text[: _LONGEST_STACK - 1]}…"
        rows.append((str(link), cut, *cells))
    headings = ("link", "made of", *(heading for _, heading, _ in shown))
    return Table(f"sections: {data.attrs['mechanism']}", headings, (tuple(rows),), text_columns=2)


def _says(section: xr.Dataset, name: str) -> bool:
    """Whether a property is known of a link, and not zero of all."""
    return bool(np.nan_to_num(section[name].values).any())


def _cell(value: float) -> str:
    return plain(value) if np.isfinite(value) else "-"


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Stiffness, moduli, mass and neutral axis of each link, as far as they are known.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``SectionProfiles`` result.

    Returns
    -------
    tuple of Quantity
    """
    with_coupling = data.sel(coupling="with")
    quantities = (
        Quantity(name, factor * float(with_coupling[name].sel(link=link)), unit, 0.0, str(link))
        for link in with_coupling["link"].values
        for name, unit, factor in _NUMBERS
    )
    return tuple(number for number in quantities if np.isfinite(number.value))
