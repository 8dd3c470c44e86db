"""What ``flexmech section`` prints of each link: its section, and what is inside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexmech.cli.section_data import in_runs, section_values, uncoupled, unit_load_profile
from flexmech.modelfile.stacking import stacking_text

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from flexmech.sections import BeamSection, LaminateSection

__all__ = ["layer_tables", "load_line", "section_table", "stack_of", "without_layers_lines"]

# Label, name among the values of a section, and factor to the label's unit.
_ROWS = (
    ("in-plane thickness (mm)", "in_plane_thickness_m", 1e3),
    ("out-of-plane width (mm)", "out_of_plane_width_m", 1e3),
    ("EA (N)", "axial_stiffness_N", 1.0),
    ("EI about the neutral axis (N m^2)", "bending_stiffness_Nm2", 1.0),
    ("coupling B about the pins' axis (N m)", "coupling_stiffness_Nm", 1.0),
    ("neutral axis y (mm)", "neutral_axis_m", 1e3),
    ("kGA (N)", "shear_stiffness_N", 1.0),
    ("shear correction k", "shear_correction", 1.0),
    ("EA / (b h) (GPa)", "membrane_modulus_Pa", 1e-9),
    ("12 EI / (b h^3) (GPa)", "flexural_modulus_Pa", 1e-9),
    ("density (kg/m^3)", "density_kg_m3", 1.0),
    ("rho A (kg/m)", "mass_per_length_kg_m", 1.0),
    ("rho I about the mass axis (kg m)", "rotary_inertia_kg_m", 1.0),
    ("mass axis y (mm)", "mass_axis_m", 1e3),
    ("specific damping (%), axial", "specific_damping_axial", 100.0),
    ("specific damping (%), bending", "specific_damping_bending", 100.0),
    ("specific damping (%), shear", "specific_damping_shear", 100.0),
    ("damping time (s), axial", "damping_time_axial_s", 1.0),
    ("damping time (s), bending", "damping_time_bending_s", 1.0),
    ("damping time (s), shear", "damping_time_shear_s", 1.0),
)
# What rounding leaves of a zero, over the largest value of its column.
_ZERO = 1e-9


def section_table(link: str, section: BeamSection) -> Table:
    """Tabulate a section, and beside it without its axial-bending coupling if it has any.

    Parameters
    ----------
    link : str
    section : BeamSection

    Returns
    -------
    rich.table.Table
    """
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(f"{link}: {stack_of(section)}"))
    table.add_column("property")
    shown = [section_values(section)]
    if section.neutral_axis:
        shown.append(section_values(uncoupled(section)))
        for heading in ("with coupling", "without coupling", "change"):
            table.add_column(heading, justify="right")
    else:
        table.add_column("value", justify="right")
    for label, name, factor in _ROWS:
        values = [column[name] for column in shown]
        texts = ["not known" if v is None else f"{v * factor:.6g}" for v in values]
        if len(values) == 2:
            texts.append(_change(*values))
        table.add_row(label, *texts)
    return table


def stack_of(section: BeamSection) -> str:
    """Say in one line what a section is made of, from its lowest y up."""
    layers = section.layers
    if layers is None:
        return "by its stiffness and mass"
    stack = [(x.ply.name, round(float(np.degrees(x.angle)), 6)) for x in layers.laminate.layers]
    if stack == [("", 0.0)]:
        return "rectangle of one material"
    reduction = "" if layers.reduction == "narrow" else f", {layers.reduction}"
    return f"{stacking_text(stack)}, {len(stack)} layers{reduction}"


def layer_tables(link: str, section: BeamSection, layers: LaminateSection) -> list[Table]:
    """Tabulate strain and stress in each layer under unit loads, with and without coupling.

    Parameters
    ----------
    link : str
    section : BeamSection
    layers : LaminateSection
        What it is made of.

    Returns
    -------
    list of rich.table.Table
        One, or two if the section is unsymmetric.
    """
    # Normal stress is linear and shear stress quadratic in a run of equal layers: its two
    # faces and its middle say it all.
    profile = unit_load_profile(link, section, in_runs(layers), per_layer=3)
    if not section.neutral_axis:
        return [_layer_table(profile.sel(coupling="with"), f"{link} under unit loads")]
    return [
        _layer_table(profile.sel(coupling=c), f"{link} under unit loads, {c} coupling")
        for c in profile["coupling"].values
    ]


def load_line() -> str:
    """Say what the unit loads are and where y points."""
    return (
        "unit loads: N = 1 N along the pins' axis (y = 0), M = 1 N m that stretches the side of "
        "lower y, V = 1 N along y; y points to the left of a link when looking from its first "
        "joint along it\nwhat stands without coupling does not balance the loads: it shows what "
        "the coupling does, kGA and damping are those of the section with it"
    )


def without_layers_lines(link: str, section: BeamSection) -> list[str]:
    """Say that nothing is known through the thickness, where that is so."""
    if section.layers is not None:
        return []
    return [
        f'{link}: section "general" tells its stiffness and mass alone; of strain and stress '
        "through its thickness nothing is known"
    ]


def _layer_table(profile: xr.Dataset, title: str) -> Table:
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title))
    # A cut name would lose the angle behind it.
    table.add_column("layer", overflow="fold")
    columns = {
        "y (mm)": profile["place"].values * 1e3,
        "N: strain": profile["strain"].sel(load="axial_force").values,
        "N: stress (Pa)": profile["normal_stress"].sel(load="axial_force").values,
        "M: strain": profile["strain"].sel(load="bending_moment").values,
        "M: stress (Pa)": profile["normal_stress"].sel(load="bending_moment").values,
        "V: shear (Pa)": profile["shear_stress"].sel(load="shear_force").values,
    }
    for heading in columns:
        table.add_column(heading, justify="right")
    # The highest layer stands at the top, as in the link.
    for layer in reversed(range(profile.sizes["layer"])):
        place = profile.isel(layer=layer)
        degrees = round(float(np.degrees(place["angle"])), 6)
        label = stacking_text([(str(place["ply"].item()), degrees)])[1:-1]
        for point in reversed(range(profile.sizes["point"])):
            texts = [_number(values, layer, point) for values in columns.values()]
            table.add_row(escape(label if point == 1 else ""), *texts)
        table.add_section()
    return table


def _number(values: np.ndarray, layer: int, point: int) -> str:
    value = values[layer, point]
    return f"{0.0 if abs(value) < _ZERO * np.abs(values).max() else value:.4g}"


def _change(first: float | None, second: float | None) -> str:
    """Relative change in percent; nothing to say where there is none, or from or to zero."""
    if not first or not second or first == second:
        return ""
    return f"{100 * (second / first - 1):+.4g} %"
