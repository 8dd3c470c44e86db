"""Properties of the six laminates from Table 1, with its printed uncertainties, beside Table 2.

In bending one laminate has one factor of frequency, the root of E I over rho A, in every linkage
and position: frequency = s(laminate) q(case, position). So what the spread of a constituent does
to a ratio of frequencies follows from sections alone.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.materials import (
    Fibre,
    Laminate,
    Matrix,
    ply_from_constituents,
    published_constituents,
    uncertainty_parts,
    woven_ply,
)
from flexmech.sections import LaminateSection, LayerDirection, SheetSection
from flexmech.studies.composite_crank_rockers.linkages import (
    LAMINATES,
    LAYERS,
    PLY_MODELS,
    THICKNESS,
    WIDTH,
    PlyModel,
)

# Constituents of Table 1 by the letters of Table 2's stacks, and the resin.
FIBRES = {"C": "carbon", "G": "E-glass"}
RESIN = "polyester"
_SHARE, _COUNT = 0.6, 5
# What is computed of a laminate, each with its own row.
_NUMBERS = ("modulus", "poisson_ratio", "density")


def laminate_properties() -> xr.Dataset:
    """Modulus, Poisson's ratio and density by Table 1, their changes by it, and Table 2.

    Returns
    -------
    xarray.Dataset
        ``modulus`` in bending in the plane of motion in Pa, ``poisson_ratio`` and ``density`` in
        kg/m^3 over ``mixed_plies``, ``layers`` and ``laminate``; ``modulus_change`` and so on,
        what one printed uncertainty of a property of a constituent adds, also over ``source``;
        ``printed_modulus`` and so on of Table 2, and ``printed_strength`` in Pa.
    """
    mixed: list[PlyModel] = [plies for plies in PLY_MODELS if plies != "table 2"]
    known = published_constituents()
    parts = [known[name] for name in (*FIBRES.values(), RESIN)]
    values, changes = [], []
    for plies in mixed:
        for layers in LAYERS:

            def numbers(
                *constituents: Fibre | Matrix,
                plies: PlyModel = plies,
                layers: LayerDirection = layers,
            ) -> FloatArray:
                return _numbers_of(constituents, plies, layers)

            values.append(numbers(*parts))
            changes.append(uncertainty_parts(numbers, parts))
    shape = (len(mixed), len(LAYERS))
    sources = [f"{name} {what.replace('_', ' ')}" for name, what in changes[0]]
    value = np.array(values).reshape(*shape, len(_NUMBERS), len(LAMINATES))
    change = np.array([list(each.values()) for each in changes])
    change = change.reshape(*shape, len(sources), *value.shape[2:])
    over = ("mixed_plies", "layers")
    found: dict[str, tuple[tuple[str, ...], FloatArray]] = {}
    for row, name in enumerate(_NUMBERS):
        found[name] = ((*over, "laminate"), value[:, :, row])
        found[f"{name}_change"] = ((*over, "source", "laminate"), change[:, :, :, row])
    units = {"modulus": 1e9, "poisson_ratio": 1.0, "density": 1.0, "strength": 1e6}
    printed = {
        f"printed_{name}": ("laminate", [unit * row[name] for row in LAMINATES.values()])
        for name, unit in units.items()
    }
    coordinates = {
        "mixed_plies": mixed,
        "layers": list(LAYERS),
        "source": sources,
        "laminate": list(LAMINATES),
    }
    return xr.Dataset(found | printed, coordinates)


def spread_of(change: xr.DataArray) -> xr.DataArray:
    """Standard uncertainty from the changes by each source: the root of their squares' sum.

    Parameters
    ----------
    change : DataArray
        Over ``source`` and others.

    Returns
    -------
    DataArray
        Over the others.
    """
    return (change**2).sum("source") ** 0.5


def relative_change(properties: xr.Dataset, power: float, density_power: float) -> xr.DataArray:
    """Relative change of modulus to one power times density to another, by each source.

    Parameters
    ----------
    properties : Dataset
        Of :func:`laminate_properties`, or a study that has its variables.
    power, density_power : float
        1/2 and -1/2 for the frequency in bending.

    Returns
    -------
    DataArray
        Over ``mixed_plies``, ``layers``, ``source`` and ``laminate``.
    """
    stiffer = properties["modulus_change"] / properties["modulus"]
    heavier = properties["density_change"] / properties["density"]
    change: xr.DataArray = power * stiffer + density_power * heavier
    return change


def factor_uncertainty(properties: xr.Dataset) -> xr.DataArray:
    """Relative uncertainty of each laminate's frequency in bending over that of C1.

    Parameters
    ----------
    properties : Dataset
        Of :func:`laminate_properties`, or a study that has its variables.

    Returns
    -------
    DataArray
        Over ``mixed_plies``, ``layers`` and ``laminate``.
    """
    change = relative_change(properties, 0.5, -0.5)
    return spread_of(change - change.sel(laminate="C1"))


def _numbers_of(
    constituents: tuple[Fibre | Matrix, ...], plies: PlyModel, layers: LayerDirection
) -> FloatArray:
    """Modulus, Poisson's ratio and density of all laminates, (3, 6)."""
    rows = []
    for section in laminate_sections(constituents, plies, layers):
        flexible = np.linalg.inv(section.laminate.stiffness_moment(0))
        rows.append(
            (
                12 * section.bending_stiffness / (WIDTH * THICKNESS**3),
                -flexible[0, 1] / flexible[0, 0],
                section.mass_per_length / (WIDTH * THICKNESS),
            )
        )
    return np.array(rows).T


def laminate_sections(
    constituents: tuple[Fibre | Matrix, ...], plies: PlyModel, layers: LayerDirection
) -> list[SheetSection | LaminateSection]:
    """Sections of all laminates, of the size that the model files have.

    Parameters
    ----------
    constituents : tuple of Fibre or Matrix
        Carbon, glass and resin.
    plies : {"woven", "unidirectional"}
    layers : {"across width", "through thickness"}

    Returns
    -------
    list of SheetSection or LaminateSection
    """
    *fibres, resin = constituents
    assert isinstance(resin, Matrix)
    mixed = {}
    for letter, fibre in zip(FIBRES, fibres, strict=True):
        assert isinstance(fibre, Fibre)
        ply = ply_from_constituents(fibre, resin, _SHARE, "rule-of-mixtures")
        mixed[letter] = woven_ply(ply) if plies == "woven" else ply
    across = layers == "across width"
    sections: list[SheetSection | LaminateSection] = []
    for row in LAMINATES.values():
        stack = [mixed[letter] for letter in row["stack"] if letter in mixed]
        size = (WIDTH if across else THICKNESS) / _COUNT
        laminate = Laminate.stacked(stack, size, [0.0] * len(stack))
        sections.append(
            SheetSection(laminate, THICKNESS) if across else LaminateSection(laminate, WIDTH)
        )
    return sections
