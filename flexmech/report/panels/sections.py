"""Cross-sections of the links: their layers, and stress through the thickness."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import ModelCheck, SectionProfiles
from flexmech.analyses.section_profile.result import property_table
from flexmech.report.drawing import stack_drawings
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import state_of
from flexmech.types import FloatArray

# Variable, number of the unit load, title of the axis, and its units in a Pa.
LOADS = (
    ("normal_stress", 0, "σ by N (kPa)", 1e-3),
    ("normal_stress", 1, "σ by M (MPa)", 1e-6),
    ("shear_stress", 2, "τ by V (kPa)", 1e-3),
)
# Stresses nearer to each other than this part of the greatest are the same.
SAME = 1e-9


def section_panel(results: Results) -> Panel | None:
    """Stacks to scale, stress through the thickness under unit loads, and properties."""
    result, check = results.first(SectionProfiles), results.first(ModelCheck)
    if result is None:
        return None
    said = result.summary()
    drawings: tuple[tuple[str, str], ...] = ()
    if check is not None and "layer_low" in check.dataset:
        drawings = stack_drawings(check.dataset)
    return Panel(
        name="sections",
        title="Sections with their layers",
        caption=(
            "Each link's section to one scale, its in-plane thickness upward, and stress through "
            "the thickness under unit loads on the pins' axis: N along the link, M that stretches "
            f"the side of lower y, V along y. State: {state_of(result.dataset.attrs)}."
        ),
        equation="N = EA ε₀ + B κ,  M = B ε₀ + EI κ,  V = kGA γ;  τ from equilibrium",
        source=(
            "laminated beam, layers stacked through the in-plane thickness; R. M. Jones, "
            "Mechanics of Composite Materials (1999)"
        ),
        plots=tuple(_plot(result, link, n) for n, link in enumerate(result.links_with_layers)),
        drawings=drawings,
        tables=tuple(property_table(result.dataset.sel(link=link)) for link in result.links),
        lines=said.lines,
        warnings=said.warnings,
        thinned=(
            "sections: stresses of every layer are drawn; their tables are what flexmech section "
            "writes to through_thickness.csv",
        ),
    )


def _plot(result: SectionProfiles, link: str, number: int) -> Plot:
    one = result.profile(link)
    # Without coupling both are the same.
    couplings = ["with"] if _uncoupled(one) else ["with", "without"]
    traces = [
        Trace(
            "with coupling" if coupling == "with" else "without coupling",
            *_along(one, variable, load, str(coupling), factor),
            colour=column,
            look="solid" if coupling == "with" else "dash",
            axis=axis,
            legend=axis == 0 and len(couplings) > 1,
        )
        for axis, (variable, load, _, factor) in enumerate(LOADS)
        for column, coupling in enumerate(couplings)
    ]
    return Plot(
        f"section-{number + 1}",
        "y from the pins' axis (mm)",
        tuple(YAxis(title) for _, _, title, _ in LOADS),
        tuple(traces),
        f"Stress through the thickness of the {link} under unit loads N, M and V",
        height=400,
        title=f"Stress in the {link}",
    )


def _uncoupled(one: xr.Dataset) -> bool:
    """Whether axial force and bending are uncoupled, so that two lines would be one."""
    coupled, alone = (one["normal_stress"].sel(coupling=each) for each in ("with", "without"))
    return bool(abs(coupled - alone).max() <= SAME * abs(coupled).max())


def _along(
    one: xr.Dataset, variable: str, load: int, coupling: str, factor: float
) -> tuple[FloatArray, FloatArray]:
    """Places in mm and stresses from the lowest layer up, with a break between layers."""
    values = one[variable].isel(load=load).sel(coupling=coupling).transpose("layer", "point").values
    places = 1e3 * one["place"].transpose("layer", "point").values
    gap = np.full((len(places), 1), np.nan)
    x, y = (np.concatenate([part, gap], axis=1).ravel() for part in (places, factor * values))
    return x, y
