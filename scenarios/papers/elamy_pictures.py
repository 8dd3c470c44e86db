"""Pictures of the campaign of Elamy et al. 2023: its Figures 7 to 9, laminates, and motion."""

from __future__ import annotations

import numpy as np
import xarray as xr
from elamy_linkages import FLAT, LAYERS, POSITIONS
from elamy_study import CONVERGED, THIRD_ORDER
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech import plots

# From dark to light, so that the order shows without colour as well.
SHADES = ("#08306b", "#08519c", "#2171b5", "#4292c6", "#9ecae1", "#deebf7")
# A fifth of the distance between two groups is left free, so that groups stand apart.
WIDTH = 0.8 / len(SHADES)
EDGE = {"edgecolor": "black", "linewidth": 0.4}
MARK = {"ls": "", "ms": 3.8, "mew": 0.9}
DIAMOND = MARK | {"marker": "D", "color": plots.series_style(1).color}
DASH = MARK | {"marker": "_", "color": "black"}
RING = MARK | {"marker": "o", "color": "black", "mfc": "white"}
BAND = {"color": plots.series_style(0).color, "alpha": 0.15, "linewidth": 0.0}
# The model that the claims are held against.
FIRST = {"plies": "woven", "layers": FLAT}
STACKED = next(layers for layers in LAYERS if layers != FLAT)


def pictures_of(study: xr.Dataset) -> dict[str, Figure]:
    """Transmission angles, frequencies, damping, laminates, and the linkages in motion."""
    names = [f"case {case}" for case in study["case"].values]
    angles = study[["transmission_angle"]].rename(case="linkage").assign_coords(linkage=names)
    bent = study["frequency"].sel(FIRST | {"beams": CONVERGED})
    damping = study["strain_energy_damping"].sel(FIRST)
    return {
        "transmission_angle": plots.plot_transmission_angle(angles),
        "frequencies_by_laminate": _bars(
            bent,
            {
                "rigid joints": (study["rigid_joints_frequency"], RING),
                "FE, published": (study["finite_element"], DIAMOND),
                "measured": (study["measured"], DASH),
            },
            "C1",
            "Frequency over that of C1, case 1, least transmission angle (bars: computed, hinged)",
            "Ratio of frequencies (-)",
        ),
        "damping_by_laminate": _bars(
            damping.sel(beams=CONVERGED),
            {
                "third order": (damping.sel(beams=THIRD_ORDER), RING),
                "measured": (study["damping"], DIAMOND),
            },
            "C6",
            "Damping over that of C6, case 1, least transmission angle (bars: computed, bending)",
            "Ratio of damping (-)",
        ),
        "laminate_factors": _laminate_factors(study),
        "running_against_steel": _running_against_steel(study),
    }


def _bars(
    computed: xr.DataArray,
    marks: dict[str, tuple[xr.DataArray, dict[str, object]]],
    unit: str,
    title: str,
    label: str,
) -> Figure:
    """One panel a position, one group of bars a case; ``unit`` is the laminate that has 1."""

    def ratio(values: xr.DataArray, position: str) -> np.ndarray:
        one = values.sel(laminate=unit, case=1, position="min")
        return (values.sel(position=position) / one).transpose("laminate", "case").values

    cases = np.arange(computed.sizes["case"])
    places = cases + (np.arange(len(SHADES))[:, None] - (len(SHADES) - 1) / 2) * WIDTH
    with plots.sheet(plots.grid(3, 1, 5.9, sharex=True, sharey=True)) as drawn:
        laminates = zip(SHADES, computed["laminate"].values, strict=True)
        handles = [Patch(facecolor=shade, label=name, **EDGE) for shade, name in laminates]
        handles += [plots.line_handle(name, **look) for name, (_, look) in marks.items()]
        drawn.header(handles, title)
        for axes, (position, words) in zip(drawn.panels, POSITIONS.items(), strict=True):
            for place, height, shade in zip(places, ratio(computed, position), SHADES, strict=True):
                axes.bar(place, height, WIDTH, color=shade, **EDGE)
            for values, look in marks.values():
                axes.plot(places.ravel(), ratio(values, position).ravel(), **look)
            axes.set_title(words[0].upper() + words[1:])
            axes.set_xticks(cases, [f"case {case}" for case in computed["case"].values])
            plots.plain_numbers(axes)
        # Only now: the panels share the axis, and a limit ends its fitting to what is drawn.
        drawn.panels[0].set_ylim(bottom=0.0)
        drawn.label_x("Proportions of the linkage")
        drawn.label_y(label)
    return drawn.figure


def _laminate_factors(study: xr.Dataset) -> Figure:
    """How the frequency changes with the laminate, by model of plies and the way they lie."""
    factor = study["laminate_factor"]
    bent = factor.sel(beams=CONVERGED)
    curves = {
        "woven, plies in the plane": bent.sel(FIRST),
        "woven, stacked": bent.sel(plies="woven", layers=STACKED),
        "straight, plies in the plane": bent.sel(plies="unidirectional", layers=FLAT),
        "straight, stacked": bent.sel(plies="unidirectional", layers=STACKED),
        "one modulus a laminate, Table 2": bent.sel(plies="table 2", layers=FLAT),
        "published, Tables 5 and 6": study["published_laminate_factor"],
    }
    with plots.sheet(plots.grid(1, 1, 3.0)) as drawn:
        (axes,) = drawn.panels
        names, first = study["laminate"].values, bent.sel(FIRST)
        spread, handles = 2 * study["laminate_factor_spread"], []
        axes.fill_between(names, (first - spread).values, (first + spread).values, **BAND)
        for number, (label, values) in enumerate(curves.items()):
            marker = plots.series_style(number).marker
            line = plots.series_line(number) | {"marker": marker, "markersize": 4}
            axes.plot(names, values.values, **line)
            handles.append(plots.series_handle(number, label, **line))
        axes.plot(names, factor.sel(FIRST | {"beams": THIRD_ORDER}).values, **RING)
        handles.append(plots.line_handle("woven, plies in the plane, third order", **RING))
        handles.append(Patch(label="twice the uncertainty by Table 1", **BAND))
        drawn.header(handles, "Frequency of each laminate over that of C1")
        axes.set(ylim=(0.0, 1.05), xlabel="Laminate", ylabel="Ratio of frequencies (-)")
    return drawn.figure


def _running_against_steel(study: xr.Dataset) -> Figure:
    """Greatest driving torque and deflection of each laminate and of steel, by case."""
    quantities = {
        "peak_torque": ("Greatest driving torque of rigid links", "Torque (N m)", 1.0),
        "peak_deflection": ("Greatest deflection", "Deflection (mm)", 1e3),
    }
    handles = []
    with plots.sheet(plots.grid(2, 1, 5.0, sharex=True)) as drawn:
        for number, case in enumerate(study["case"].values):
            marker = {"marker": plots.series_style(number).marker}
            look = plots.series_line(number) | marker
            handles.append(plots.series_handle(number, f"case {case}", **marker))
            for axes, (name, (*_, unit)) in zip(drawn.panels, quantities.items(), strict=True):
                peaks = unit * study[name].sel(case=case)
                woven, printed = (peaks.sel(running_plies=one) for one in ("woven", "table 2"))
                axes.plot(study["material"].values, woven, **(look | {"markersize": 4}))
                ring = look | {"linestyle": "", "mfc": "none", "markersize": 6}
                axes.plot(study["material"].values, printed, **ring)
        for axes, (title, label, _) in zip(drawn.panels, quantities.values(), strict=True):
            axes.set(yscale="log", title=title, ylabel=label)
        handles.append(plots.line_handle("woven plies", **(RING | {"mfc": "black"})))
        handles.append(plots.line_handle("as one material, Table 2", **RING))
        drawn.header(handles, "Composite crank-rockers in motion, and the same links of steel")
        drawn.label_x("Links of")
    return drawn.figure
