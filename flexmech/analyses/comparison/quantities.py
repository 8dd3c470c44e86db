"""Computed quantity for a record's column: gauges on links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexmech.analyses.response.measurements import probes, surface_strain
from flexmech.arrays import FloatArray
from flexmech.errors import InputError, suggestion
from flexmech.measured_data import MeasuredQuantity, MeasuredRecord
from flexmech.mechanics import Engine

# Columns that tell where a sample was taken, not what was measured there.
COMPANIONS = ("crank_angle", "crank_speed", "mode", "branch", "coherence", "engine")
# No metal or laminate is strained further before it yields or breaks.
_MOST_STRAIN = 0.1


@dataclass(frozen=True)
class Gauge:
    """Quantity that is read of a running link.

    Parameters
    ----------
    name : str
        As ``flexmech response`` names its columns, without the unit.
    kind : {"strain", "deflection"}
    link : str
    place : {"middle", "tip"}
    """

    name: str
    kind: Literal["strain", "deflection"]
    link: str
    place: str

    @property
    def unit(self) -> str:
        """SI unit; empty for a strain."""
        return "" if self.kind == "strain" else "m"

    @property
    def column(self) -> str:
        """Name of the column in ``response.csv``."""
        return f"{self.name}_{self.unit}" if self.unit else self.name

    def row(self, engine: Engine) -> FloatArray:
        """Reading of the gauge in the unreduced coordinates of its link, (n,).

        Parameters
        ----------
        engine : Engine

        Returns
        -------
        ndarray
        """
        link = engine.links[engine.mechanism.linkage.topology.index(self.link)]
        if self.kind == "strain":
            return surface_strain(engine, link)
        start, middle, end = link.shape[[0, len(link.shape) // 2, -1], 1]
        return np.asarray(end - start if self.place == "tip" else middle - (start + end) / 2)


def gauges(engine: Engine) -> tuple[Gauge, ...]:
    """Gauges with which a record over time can be compared, as ``flexmech response`` names it."""
    gauges = []
    names = engine.mechanism.linkage.topology.link_names
    for link, place in zip(names, probes(engine), strict=True):
        short = "mid" if place == "middle" else "tip"
        gauges.append(Gauge(f"{link}_{short}_deflection", "deflection", link, place))
        if place == "middle":
            gauges.append(Gauge(f"{link}_mid_strain", "strain", link, place))
    return tuple(gauges)


def value_columns(record: MeasuredRecord) -> tuple[MeasuredQuantity, ...]:
    """Quantities of a record that tell what was measured, not where."""
    return tuple(q for q in record.quantities if q.name.lower() not in COMPANIONS)


def matched(
    record: MeasuredRecord, asked: str | None, engine: Engine
) -> tuple[MeasuredQuantity, Gauge]:
    """Pair a record's column with the gauge that computes it.

    Parameters
    ----------
    record : MeasuredRecord
        Over time.
    asked : str, optional
        Column of ``response.csv``. Left out: that of the same name, or the middle of the
        coupler for a plain ``strain`` or ``deflection``.
    engine : Engine

    Returns
    -------
    MeasuredQuantity
    Gauge

    Raises
    ------
    InputError
        If there is no such quantity, no column for it, or more than one.
    """
    measured, gauge = _matched(record, asked, {gauge.name: gauge for gauge in gauges(engine)})
    _check(measured, gauge, record)
    return measured, gauge


def _matched(
    record: MeasuredRecord, asked: str | None, known: dict[str, Gauge]
) -> tuple[MeasuredQuantity, Gauge]:
    if asked is not None:
        gauge = next((g for g in known.values() if asked in (g.name, g.column)), None)
        if gauge is None:
            columns = [g.column for g in known.values()]
            raise InputError(
                f"quantity: {asked!r} cannot be laid beside a record over time; "
                f"{suggestion(asked, columns)}"
            )
        return _column_for(record, gauge), gauge
    named = [q for q in record.quantities if q.name in known]
    for name in known:
        if name in record.unreadable:
            record.quantity(name)
    if len(named) > 1:
        raise InputError(
            f"{record.source}: holds several quantities that are computed: "
            f"{', '.join(q.name for q in named)}; choose one by --quantity"
        )
    if named:
        return named[0], known[named[0].name]
    candidates = value_columns(record)
    if len(candidates) != 1:
        _refuse_none(record, [g.column for g in known.values()])
    return candidates[0], _likely(candidates[0], known, record)


def _refuse_none(record: MeasuredRecord, columns: list[str]) -> None:
    """Say which columns there are, or what is wrong with the only ones."""
    candidates = value_columns(record)
    wrong = [n for n in record.unreadable if n.lower() not in COMPANIONS]
    if not candidates and wrong:
        raise InputError(record.unreadable[wrong[0]])
    if not candidates:
        raise InputError(
            f"{record.source}: holds no measured quantity beside the {record.abscissa}; add a "
            "column such as 'strain (um/m)'"
        )
    raise InputError(
        f"{record.source}: holds {', '.join(q.name for q in candidates)}, and which of them is "
        f"meant is not clear; name the column as the computed one is: {', '.join(columns)}"
    )


def _column_for(record: MeasuredRecord, gauge: Gauge) -> MeasuredQuantity:
    """The record's column for a gauge: of its name, or the only one of its unit."""
    if gauge.name in (*record.names, *record.unreadable):
        return record.quantity(gauge.name)
    candidates = [q for q in value_columns(record) if q.unit == gauge.unit]
    if len(candidates) == 1:
        return candidates[0]
    if not candidates and (every := value_columns(record)):
        return every[0]
    if not candidates:
        _refuse_none(record, [gauge.column])
    raise InputError(
        f"{record.source}: {', '.join(q.name for q in candidates)} may all be {gauge.column}; "
        "give that name to the one which is meant"
    )


def _likely(measured: MeasuredQuantity, known: dict[str, Gauge], record: MeasuredRecord) -> Gauge:
    """Gauge that a plain column is of: of the link that it names, or the coupler's."""
    candidates = [g for g in known.values() if g.unit == measured.unit]
    if not candidates:
        units = sorted({g.unit or "1" for g in known.values()})
        raise InputError(
            f"{record.source}: {measured.header or measured.name!r} is in {measured.unit or '1'}, "
            f"and the computed quantities are in {' or '.join(units)}: "
            f"{', '.join(g.column for g in known.values())}; give a record of one of these"
        )
    words = measured.name.lower().split("_")
    for wanted in ([g for g in candidates if g.link.lower() in words], candidates):
        for gauge in wanted:
            if gauge.link == "coupler" or len(wanted) == 1:
                return gauge
    raise InputError(
        f"{record.source}: {measured.name!r} may be any of "
        f"{', '.join(g.column for g in candidates)}; choose one by --quantity"
    )


def _check(measured: MeasuredQuantity, gauge: Gauge, record: MeasuredRecord) -> None:
    """Refuse another dimension, and strains that can only be in other units."""
    if measured.unit != gauge.unit:
        raise InputError(
            f"{record.source}: {measured.header or measured.name!r} is in {measured.unit or '1'}, "
            f"and {gauge.column} in {gauge.unit or '1 (a strain)'}; give a column of that kind, or "
            "choose another --quantity"
        )
    most = float(np.abs(measured.values).max())
    if gauge.kind == "strain" and most > _MOST_STRAIN:
        raise InputError(
            f"{record.source}: {measured.header or measured.name!r} reaches a strain of "
            f"{most:.4g}, which no link survives; name its unit, as in 'strain (um/m)'"
        )
    if not np.ptp(measured.values) > 0:
        raise InputError(
            f"{record.source}: {measured.header or measured.name!r} is the same at all samples; "
            "give a record of a motion"
        )
