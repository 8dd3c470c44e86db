"""At which crank speeds the linkage shakes itself up: the stability map."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import StabilityMap
from flexmech.report.panel import Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import engine_names, speed_unit_of
from flexmech.units import from_si

SHADE = {"principal": "0,114,178", "sum": "213,94,0", "difference": "0,158,115"}
OTHER_SHADE = "110,110,110"
NAMES = {
    "principal": "band: twice a frequency",
    "sum": "band: sum of two frequencies",
    "difference": "band: difference of two",
}


def stability_panel(results: Results) -> Panel | None:
    """Growth rates and moduli over crank speed, with the unstable bands."""
    result = results.first(StabilityMap)
    if result is None:
        return None
    data, unit = result.dataset, speed_unit_of(results)
    said = result.summary()
    plot = Plot(
        name="stability",
        x_title=f"Crank speed ({unit})",
        axes=(YAxis("Growth rate (1/s)"), YAxis("Largest modulus")),
        traces=(*_bands(data, unit), *_curves(data, unit)),
        text=(
            "Growth rate and largest modulus of a Floquet multiplier against crank speed; shaded "
            "are the unstable bands"
        ),
        cursor="speed",
        speed_scale=from_si(1.0, unit),
        height=440,
    )
    return Panel(
        name="stability",
        title="At which crank speeds the linkage shakes itself up",
        caption=(
            f"Stability about the motion of prestress {data.attrs['prestress']}, damping "
            f"{data.attrs['damping']}. Where the growth rate is above zero a vibration grows with "
            "every turn although no load excites it; between the crank speeds asked for the curve "
            "runs through the edges and the fastest speed of each band."
        ),
        equation="z' = A(t) z, A(t + T) = A(t): multiplier = exp(λ T), growth rate = Re λ",
        source="G. Floquet, Annales scientifiques de l'École normale supérieure 12 (1883)",
        plots=(plot,),
        tables=said.tables,
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
    )


def _curves(data: xr.Dataset, unit: str) -> list[Trace]:
    """Growth and modulus of every engine."""
    traces = []
    scale = from_si(1.0, unit)
    for number, engine in enumerate(engine_names(data)):
        speed, rate = _with_bands(data, engine)
        modulus = np.exp(rate * 2 * np.pi / np.abs(speed))
        for axis, values in enumerate((rate, modulus)):
            traces.append(
                Trace(
                    name=engine,
                    x=scale * speed,
                    y=values,
                    colour=number,
                    axis=axis,
                    followed={} if number == 0 else None,
                    legend=axis == 0,
                )
            )
    return traces


def _with_bands(data: xr.Dataset, engine: str) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and growth rates, with closed edges and fastest speeds of the bands."""
    own, bands = data.sel(engine=engine), _of(data, engine)
    speeds, rates = [own["crank_speed"].values], [own["growth_rate"].values]
    for edge in ("lower", "upper"):
        closed = ~bands[f"band_{edge}_open"].values
        speeds.append(bands[f"band_{edge}"].values[closed])
        rates.append(np.zeros(int(closed.sum())))
    speed = np.concatenate([*speeds, bands["band_fastest_speed"].values])
    rate = np.concatenate([*rates, bands["band_largest_growth_rate"].values])
    order = np.argsort(speed, kind="stable")
    return speed[order], rate[order]


def _bands(data: xr.Dataset, unit: str) -> list[Trace]:
    """Unstable bands of the first engine, filled up to their greatest growth rate."""
    traces, named = [], set()
    bands, scale = _of(data, engine_names(data)[0]), from_si(1.0, unit)
    for place in range(bands.sizes["band"]):
        band = bands.isel(band=place)
        kind = str(band["band_kind"].item())
        low, high = (scale * float(band[f"band_{edge}"]) for edge in ("lower", "upper"))
        top = float(band["band_largest_growth_rate"])
        name = NAMES.get(kind, "band without a name")
        traces.append(
            Trace(
                name=name,
                x=np.array([low, low, high, high, low]),
                y=np.array([0.0, top, top, 0.0, 0.0]),
                colour=f"rgba({SHADE.get(kind, OTHER_SHADE)},0.3)",
                width=0.8,
                fill="itself",
                legend=name not in named,
            )
        )
        named.add(name)
    return traces


def _of(data: xr.Dataset, engine: str) -> xr.Dataset:
    return data.isel(band=np.flatnonzero(data["band_engine"].values == engine))
