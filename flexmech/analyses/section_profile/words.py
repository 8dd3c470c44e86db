"""What sections say in short: moduli of solid bars as stiff, mass, coupling and damping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, plain
from flexmech.analyses.summary import Table

EXACT = "numbers are exact within the theory of laminated beams; nothing is meshed"
STATED = "stiffness and mass are those that the model file states"
"""What there is to say of errors: sections are integrated over their layers in closed form."""

_SPECIFIC = "specific_damping_bending"
# Of what stands in the table: variable, heading, and factor from the SI unit.
_COLUMNS = (
    ("axial_stiffness", "EA MN", 1e-6),
    ("bending_stiffness", "EI N m²", 1.0),
    ("membrane_modulus", "tension GPa", 1e-9),
    ("flexural_modulus", "bending GPa", 1e-9),
    ("mass_per_length", "kg/m", 1.0),
    ("neutral_axis", "neutral axis mm", 1e3),
    (_SPECIFIC, "damping %", 1e2),
)
# Of metals, whose specific damping is not stated.
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
# Links whose coupling is told of by name; of more, their number.
_MOST_NAMED = 2


def answer_of(data: xr.Dataset) -> tuple[str, ...]:
    """How stiff and heavy the links are, and what the coupling of unsymmetric stacks does.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``SectionProfiles`` result.

    Returns
    -------
    tuple of str
        Sentences.
    """
    own = data.sel(coupling="with")
    links = [str(name) for name in own["link"].values]
    who = f"The {links[0]} is" if len(links) == 1 else "The links are"
    moduli = [_range(own[name], 1e-9) for name in ("membrane_modulus", "flexural_modulus")]
    mass = _range(own["mass_per_length"])
    if all(moduli):
        bar = "a solid bar" if len(links) == 1 else "solid bars"
        tension, bending = moduli
        stiff = f"of {tension} GPa in tension and of {bending} GPa in bending"
        if tension == bending:
            stiff = f"of {tension} GPa in tension and bending"
        first = f"{who} as stiff as {bar} {stiff}, and {_have(links)} {mass} kg/m."
    else:
        tension, bending = _range(own["axial_stiffness"], 1e-6), _range(own["bending_stiffness"])
        first = f"EA is {tension} MN, EI {bending} N m², the mass {mass} kg/m."
    return (first, *_on_coupling(data, links))


def _have(links: Sequence[str]) -> str:
    return "has" if len(links) == 1 else "have"


def _on_coupling(data: xr.Dataset, links: Sequence[str]) -> Iterator[str]:
    """That an unsymmetric stack bends under tension, and what it costs."""
    coupled = [link for link in links if float(data["neutral_axis"].sel(link=link)[0])]
    for link in coupled if len(coupled) <= _MOST_NAMED else ():
        own = data.sel(link=link)
        away = 1e3 * abs(float(own["neutral_axis"].sel(coupling="with")))
        with_it, without = (
            float(own["bending_stiffness"].sel(coupling=c)) for c in ("with", "without")
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


def links_table(data: xr.Dataset, made_of: Sequence[str]) -> Table:
    """A row for each link.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``SectionProfiles`` result.
    made_of : sequence of str
        What each link is made of.

    Returns
    -------
    Table
    """
    own, rows = data.sel(coupling="with"), []
    shown = [column for column in _COLUMNS if _says(own, column[0])]
    if not _says(own, _SPECIFIC) and _says(own, _TIME[0]):
        shown.append(_TIME)
    for number, link in enumerate(own["link"].values.tolist()):
        cells = (_cell(factor * own[name].values[number]) for name, _, factor in shown)
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


def numbers_of(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Stiffness, moduli, mass and neutral axis of each link, as far as they are known.

    Parameters
    ----------
    data : xarray.Dataset
        Of a ``SectionProfiles`` result.

    Returns
    -------
    tuple of Quantity
    """
    own = data.sel(coupling="with")
    found = (
        Quantity(name, factor * float(own[name].sel(link=link)), unit, 0.0, str(link))
        for link in own["link"].values
        for name, unit, factor in _NUMBERS
    )
    return tuple(number for number in found if np.isfinite(number.value))
