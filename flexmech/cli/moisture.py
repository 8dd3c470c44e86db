"""``flexmech moisture``: how water gets into the links of a mechanism."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import Model, NoPlots, Out
from flexmech.cli.failures import reports_failures
from flexmech.cli.surroundings import parse_percent, parse_time
from flexmech.errors import InputError
from flexmech.files import check_writable, moved_into, write_table
from flexmech.types import FloatArray
from flexmech.units import TEMPERATURE, parse_quantity

if TYPE_CHECKING:
    from flexmech.hygrothermal import LinkUptake
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "moisture"]

HELP = (
    "How water gets into the links. Moisture profiles and uptake in constant humid surroundings, "
    "by diffusion: tables and a picture."
)
PROFILE, UPTAKE, PICTURE = "moisture_profile.csv", "moisture_uptake.csv", "moisture.png"
PROFILE_COLUMNS = ("link", "time_s", "place_m", "moisture_percent")
UPTAKE_COLUMNS = (
    "link",
    "time_s",
    "sqrt_time_sqrt_s",
    "moisture_percent",
    "uptake",
    "short_time_uptake",
    "shen_springer_uptake",
)
# Profiles at these parts of the time, uptake at so many times evenly in its root.
PARTS = (0.01, 0.05, 0.2, 0.5, 1.0)
TIMES = 121
SHARES = (0.5, 0.9, 0.99)
DAY = 86400.0

Humidity = Annotated[
    str, typer.Option(help="Humidity of the surroundings in percent.", metavar="PERCENT")
]
Time = Annotated[str, typer.Option(help='Time of exposure, such as "30 day".', metavar="T")]
Temperature = Annotated[
    str | None,
    typer.Option(
        help="Temperature of surroundings and links: degrees Celsius unless a unit is given. Left "
        "out: the model's reference temperature.",
        metavar="C",
    ),
]
Link = Annotated[str | None, typer.Option(help="One link only; left out: all that take up water.")]


@reports_failures
def moisture(
    model: Model,
    relative_humidity: Humidity,
    time: Time,
    temperature: Temperature = None,
    link: Link = None,
    out: Out = Path("results"),
    no_plots: NoPlots = False,
) -> None:
    """Compute, save, draw and report the moisture of the links over a time of exposure."""
    humidity = parse_percent("--relative-humidity", relative_humidity)
    end = parse_time(time)
    if end == 0:
        raise InputError("--time: must be positive, got 0")

    from flexmech.cli.pictures import file_lines
    from flexmech.hygrothermal import link_uptake
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    kelvin = _temperature(temperature, mechanism.reference_temperature)
    names = _links(mechanism, link)
    check_writable(out, (PROFILE, UPTAKE, PICTURE))
    times, parts = _times(end)
    found = {name: link_uptake(mechanism, name, humidity, kelvin, times) for name in names}
    files = _write(found, parts, mechanism.provenance.name, out, draw=not no_plots)
    for line in (*_lines(mechanism, found), *file_lines(out, files, (PICTURE,))):
        typer.echo(line)


def _temperature(text: str | None, reference: float) -> float:
    if text is None:
        return reference
    try:
        kelvin = parse_quantity(text, TEMPERATURE, default_unit="degC")
    except InputError as error:
        raise InputError(f"--temperature: {error}") from error
    if kelvin <= 0:
        raise InputError(f"--temperature: must be above absolute zero, got {text!r}")
    return kelvin


def _links(mechanism: Mechanism, wanted: str | None) -> tuple[str, ...]:
    from flexmech.hygrothermal import absorbing_links

    known = mechanism.linkage.topology.link_names
    if wanted is not None:
        if wanted not in known:
            raise InputError(f"--link: there is no link {wanted!r}; use one of {', '.join(known)}")
        return (wanted,)
    found = absorbing_links(mechanism)
    if not found:
        raise InputError(
            f"{mechanism.provenance.file}: no link takes up water; add equilibrium_moisture and "
            "diffusivity to a material or a matrix"
        )
    return found


def _times(end: float) -> tuple[FloatArray, list[int]]:
    """Times of the uptake, evenly in their root, and which of them the profiles are of."""
    import numpy as np

    # Rounded, so that a time that is in both lists comes once.
    roots = np.round(np.concatenate([np.linspace(0.0, 1.0, TIMES), np.sqrt(PARTS)]), 12)
    times = end * np.unique(roots) ** 2
    return times, [int(np.abs(times - part * end).argmin()) for part in PARTS]


def _write(
    found: Mapping[str, LinkUptake], parts: list[int], name: str, out: Path, *, draw: bool
) -> list[Path]:
    """Write tables and the picture, all or none."""
    with moved_into(out) as folder:
        write_table(folder / PROFILE, PROFILE_COLUMNS, _profile_rows(found, parts))
        write_table(folder / UPTAKE, UPTAKE_COLUMNS, _uptake_rows(found))
        if draw:
            _draw(found, parts, name, folder / PICTURE)
    return [out / file for file in (PROFILE, UPTAKE, *((PICTURE,) if draw else ()))]


def _profile_rows(found: Mapping[str, LinkUptake], parts: list[int]) -> Iterator[list[str]]:
    for name, link in found.items():
        for number in parts:
            time = f"{link.history.time[number]:.10g}"
            for place, value in zip(link.history.place, link.profile[number], strict=True):
                yield [name, time, f"{place:.8g}", f"{100 * value:.8g}"]


def _uptake_rows(found: Mapping[str, LinkUptake]) -> Iterator[list[str]]:
    import numpy as np

    for name, link in found.items():
        laws = link.laws()
        for number, time in enumerate(link.history.time):
            short = ["", ""] if laws is None else [f"{law[number]:.8g}" for law in laws]
            values = (np.sqrt(time), 100 * link.moisture[number], link.uptake[number])
            yield [name, f"{time:.10g}", *(f"{value:.8g}" for value in values), *short]


def _draw(found: Mapping[str, LinkUptake], parts: list[int], name: str, file: Path) -> None:
    from flexmech.cli.pictures import DOTS_PER_INCH, without_windows

    without_windows()
    from flexmech.plots import DrawnMoisture, plot_moisture

    drawn = {}
    for link, uptake in found.items():
        laws = uptake.laws() or (None, None)
        drawn[link] = DrawnMoisture(
            uptake.history.place,
            uptake.history.time[parts],
            uptake.profile[parts],
            uptake.history.time,
            uptake.uptake,
            laws[0],
            laws[1],
            over_width=uptake.diffusion.width is not None,
        )
    one = next(iter(found.values()))
    title = (
        f"{name}: {100 * one.relative_humidity:.4g} % relative humidity, "
        f"{one.temperature - 273.15:.4g} °C"
    )
    plot_moisture(drawn, title).savefig(file, dpi=DOTS_PER_INCH)


def _lines(mechanism: Mechanism, found: Mapping[str, LinkUptake]) -> list[str]:
    lines: list[str] = []
    for name, link in found.items():
        water = link.history.water[-1] * _width_over_mass(mechanism, name)
        shares = ", ".join(
            f"{100 * share:g} % after {_duration(time)}"
            for share, time in zip(SHARES, link.times_to(SHARES), strict=True)
        )
        lines += [
            f"{name}: {100 * link.moisture[-1]:.4g} % of its resin's dry mass "
            f"({100 * water:.4g} % of its own), {100 * link.uptake[-1]:.4g} % of the equilibrium",
            f"{name}: of the equilibrium, {shares}; mass balance within "
            f"{link.history.mass_balance_error:.1e}",
        ]
    from flexmech.hygrothermal import absorbing_links

    absorbing = absorbing_links(mechanism)
    dry = [n for n in mechanism.linkage.topology.link_names if n not in absorbing]
    if dry:
        lines.append(f"take up no water: {', '.join(dry)}")
    return lines


def _width_over_mass(mechanism: Mechanism, link: str) -> float:
    section = mechanism.sections[link]
    assert section.layers is not None
    return section.layers.width / section.mass_per_length


def _duration(seconds: float) -> str:
    return f"{seconds / DAY:.4g} d" if seconds >= DAY else f"{seconds / 3600:.4g} h"
