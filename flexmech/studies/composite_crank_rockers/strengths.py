"""First-ply failure of the laminates, and the crank speed at which each linkage breaks.

The paper prints a strength of each stacking and none of its fibres, its resin or its plies: those
of similar plies stand in their place, with as many fibres, in epoxy in place of polyester. What is
found is for comparison alone. Plies are straight, as in Table 2: of a fabric no strength is known.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import xarray as xr

from flexmech.analyses.strength.compute import strength
from flexmech.analyses.strength.judged import judge
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import LabelledProgress, silent
from flexmech.choices import CriterionName
from flexmech.materials import PlyStrength
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers
from flexmech.studies.composite_crank_rockers.linkages import (
    CASES,
    LAMINATES,
    LAYERS,
    THICKNESS,
    WIDTH,
    composite_crank_rocker,
)

SOURCE = (
    "P. D. Soden, M. J. Hinton and A. S. Kaddour, Composites Science and Technology 58 (1998) "
    "1011-1022, plies with 60 % of fibres: carbon AS4 in epoxy 3501-6, E-glass in epoxy MY750"
)
STRENGTHS = {
    "C": PlyStrength(1950e6, 1480e6, 48e6, 200e6, 79e6, source=SOURCE),
    "G": PlyStrength(1280e6, 800e6, 40e6, 145e6, 73e6, source=SOURCE),
}
"""Of the plies of Table 2's stacks, by their letters."""
CRITERION: CriterionName = "max-stress"
"""It says in which way a ply fails; plies along the load bear little else than that."""
SECTION_LOADS = ("tension", "compression", "bending")
# Crank speed in rad/s at which a linkage is judged; loads go with its square, so that any does.
_SPEED = 1.0


def with_strengths(layers: Layers) -> Layers:
    """Layers whose plies have the strengths of :data:`STRENGTHS`, by their names.

    Parameters
    ----------
    layers : LaminateSection or SheetSection

    Returns
    -------
    LaminateSection or SheetSection
    """
    laminate = layers.laminate
    strong = tuple(
        replace(layer, ply=replace(layer.ply, strength=STRENGTHS[layer.ply.name]))
        for layer in laminate.layers
    )
    return layers.resized(replace(laminate, layers=strong), 1.0)


def first_ply_failures(progress: LabelledProgress | None = None) -> xr.Dataset:
    """First-ply failure of every stacking, and of every linkage by its inertia forces.

    Parameters
    ----------
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    xarray.Dataset
        ``first_ply_stress`` in Pa, the mean stress of a section or, in bending in the plane of
        motion, that of its surface if it were of one material, with ``first_ply_mode`` and
        ``first_ply`` over ``section_load``, ``layers`` and ``laminate``; ``failure_speed`` of the
        crank in rad/s, with ``failing_link`` and ``failing_mode`` over ``layers``, ``laminate``
        and ``case``.
    """
    sections = {
        "section_load": list(SECTION_LOADS),
        "layers": list(LAYERS),
        "laminate": list(LAMINATES),
    }
    linkages = {"layers": list(LAYERS), "laminate": list(LAMINATES), "case": list(CASES)}
    found = {
        "first_ply_stress": xr.DataArray(np.nan, sections, list(sections)),
        "failure_speed": xr.DataArray(np.nan, linkages, list(linkages)),
    }
    words = {
        "first_ply_mode": xr.DataArray("", sections, list(sections)).astype(object),
        "first_ply": xr.DataArray("", sections, list(sections)).astype(object),
        "failing_link": xr.DataArray("", linkages, list(linkages)).astype(object),
        "failing_mode": xr.DataArray("", linkages, list(linkages)).astype(object),
    }
    for layers, laminate in product(LAYERS, LAMINATES):
        # Links of all cases have one section.
        section = composite_crank_rocker(1, laminate, "unidirectional", layers).layers_of("crank")
        assert section is not None
        for load, (stress, mode, ply) in zip(SECTION_LOADS, _of_section(section), strict=True):
            at = {"section_load": load, "layers": layers, "laminate": laminate}
            found["first_ply_stress"].loc[at] = stress
            words["first_ply_mode"].loc[at] = mode
            words["first_ply"].loc[at] = ply
    every = list(product(LAYERS, LAMINATES, CASES))
    for done, (layers, laminate, case) in enumerate(every, start=1):
        mechanism = composite_crank_rocker(case, laminate, "unidirectional", layers)
        request = StrengthRequest(crank_speed=_SPEED, criterion=CRITERION, source="rigid")
        margin = strength(strong_mechanism(mechanism), request).dataset.isel(margin=0)
        place = {"layers": layers, "laminate": laminate, "case": case}
        found["failure_speed"].loc[place] = _SPEED * float(margin["margin_speed_factor"])
        words["failing_link"].loc[place] = str(margin["margin_part"].item())
        words["failing_mode"].loc[place] = str(margin["margin_mode"].item())
        (progress or silent)("strength of linkages", done, len(every))
    return xr.Dataset(found | {name: text.astype(str) for name, text in words.items()})


def strong_mechanism(mechanism: Mechanism) -> Mechanism:
    """A linkage of the study, of straight plies with strengths.

    Parameters
    ----------
    mechanism : Mechanism
        Of :func:`flexmech.studies.composite_crank_rocker`.

    Returns
    -------
    Mechanism
    """
    sections = {
        name: replace(section, layers=with_strengths(section.layers))
        for name, section in mechanism.sections.items()
        if section.layers is not None
    }
    return replace(mechanism, sections=sections)


def _of_section(section: Layers) -> list[tuple[float, str, str]]:
    """Nominal stress in Pa, mode and ply of the first failure by each of the section's loads."""
    # A nominal stress of one pascal.
    tension, moment = WIDTH * THICKNESS, WIDTH * THICKNESS**2 / 6
    unit = np.array([[tension, 0.0, 0.0], [-tension, 0.0, 0.0], [0.0, moment, 0.0]])
    strong = with_strengths(section)
    residual = np.zeros((len(section.laminate.layers), 2, 5))
    judged = judge(strong, unit[None], None, residual, CRITERION)
    found = []
    for factor, mode in zip(judged.load_factor, judged.mode, strict=True):
        layer, surface = np.unravel_index(factor.argmin(), factor.shape)
        ply = strong.laminate.layers[layer].ply.name
        found.append((float(factor[layer, surface]), str(mode[layer, surface]), ply))
    return found
