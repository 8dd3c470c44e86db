"""A hammer test as universal files, one a crank angle, for the programs of a laboratory.

A point that is hit or looked at is a node, in the frame of its link: x runs along the link. Its
label is 1000 times the link's number and the point's place on the link, counted from 1 at the first
joint. Frequency responses and records are those of the test. Modes are the identified ones at the
points of the grid, or at the response point alone where no grid was roved.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.schema import Values
from flexmech.arrays import ComplexArray, FloatArray
from flexmech.measured_data import (
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffMode,
    UffNodes,
)
from flexmech.mechanics import Engine, LinkPoint

# Room for the points of a link: labels of neighbouring links never meet.
_NODES_A_LINK = 1000
# Axes of a frame by their numbers in universal files: x runs along the link.
_AXES = {"axial": 1, "transverse": 2}


def link_places(engine: Engine, angles: FloatArray) -> Values:
    """Where the links are at crank angles.

    Parameters
    ----------
    engine : Engine
    angles : ndarray, shape (A,)
        Angles of the crank in rad.

    Returns
    -------
    dict of str to ndarray
        ``link_x``, ``link_y`` and ``link_angle`` of each link's frame, (A, n_links), and
        ``link_length``, (n_links,).
    """
    linkage = engine.mechanism.linkage
    motion = linkage.motion(angles)
    return {
        "link_x": motion.origin[..., 0],
        "link_y": motion.origin[..., 1],
        "link_angle": motion.angle,
        "link_length": [link.length for link in linkage.topology.links],
    }


def uff_contents(dataset: xr.Dataset) -> dict[str, UffFile]:
    """Contents of the universal files of a hammer test, by their names.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``HammerTest``.

    Returns
    -------
    dict of str to UffFile
    """
    files = {}
    for number, angle in enumerate(dataset["crank_angle"].values):
        degrees = f"{DEGREES * float(angle):.6g}"
        files[f"hammer_{degrees}deg.uff"] = _one_angle(dataset.isel(crank_angle=number), degrees)
    return files


class _Nodes:
    """Nodes of one crank angle: the joints, and the points of the test."""

    def __init__(self, one: xr.Dataset, points: Iterable[LinkPoint]) -> None:
        self.names = [str(name) for name in one["link"].values]
        self.direction = str(one.attrs["direction"])
        self.length = one["link_length"].values
        self.angle = one["link_angle"].values
        self.origin = np.column_stack([one["link_x"].values, one["link_y"].values])
        fractions: dict[str, set[float]] = {name: {0.0, 1.0} for name in self.names}
        for point in points:
            fractions[point.link].add(point.fraction)
        self.fractions = {name: sorted(places) for name, places in fractions.items()}

    def label(self, point: LinkPoint) -> int:
        place = self.fractions[point.link].index(point.fraction)
        return _NODES_A_LINK * (self.names.index(point.link) + 1) + place + 1

    def frames(self) -> tuple[UffFrame, ...]:
        return tuple(
            UffFrame(number, name, (float(x), float(y)), float(angle))
            for number, (name, (x, y), angle) in enumerate(
                zip(self.names, self.origin, self.angle, strict=True), 1
            )
        )

    def nodes(self) -> UffNodes:
        label, position, frame = [], [], []
        for link, name in enumerate(self.names):
            along = np.array([np.cos(self.angle[link]), np.sin(self.angle[link])])
            for fraction in self.fractions[name]:
                label.append(self.label(LinkPoint(name, fraction)))
                position.append([*(self.origin[link] + fraction * self.length[link] * along), 0.0])
                frame.append(link + 1)
        return UffNodes(np.array(label), np.array(position), np.array(frame))

    def towards(self, point: LinkPoint) -> FloatArray:
        """The test's direction at a point, along the global axes, (3,)."""
        angle = self.angle[self.names.index(point.link)]
        along, across = (np.cos(angle), np.sin(angle), 0.0), (-np.sin(angle), np.cos(angle), 0.0)
        return np.array(along if self.direction == "axial" else across)

    def degree_of_freedom(self, point: LinkPoint) -> UffDegreeOfFreedom:
        return UffDegreeOfFreedom(self.label(point), _AXES[self.direction], point.link)


def _one_angle(one: xr.Dataset, degrees: str) -> UffFile:
    of = one.attrs
    impact, response = LinkPoint.parse(of["impact"]), LinkPoint.parse(of["response_point"])
    grid = _grid(one)
    nodes = _Nodes(one, [impact, response, *grid])
    return UffFile(
        model=str(of.get("mechanism", "")),
        description=f"hammer test, crank locked at {degrees} deg, engine {of['engine']}",
        program=f"flexmech {of.get('flexmech_version', '')}".strip(),
        nodes=nodes.nodes(),
        frames=nodes.frames(),
        functions=tuple(_functions(one, nodes, impact, response, grid)),
        modes=tuple(_modes(one, nodes, response, grid)),
    )


def _grid(one: xr.Dataset) -> list[LinkPoint]:
    if "point" not in one.dims:
        return []
    places = zip(one["point_link"].values, one["point_fraction"].values, strict=True)
    return [LinkPoint(str(link), float(fraction)) for link, fraction in places]


def _functions(
    one: xr.Dataset, nodes: _Nodes, impact: LinkPoint, response: LinkPoint, grid: list[LinkPoint]
) -> Iterator[UffFunction]:
    """Records of every average, frequency responses and coherence."""
    hit, seen = nodes.degree_of_freedom(impact), nodes.degree_of_freedom(response)
    record = partial(
        UffFunction,
        kind="time response",
        abscissa="time",
        position=one["time"].values,
        over="none",
        reference=hit,
    )
    for number, average in enumerate(one["average"].values):
        for name, where in (("force", hit), ("response", seen)):
            yield record(
                values=one[name].values[number],
                quantity="force" if name == "force" else "displacement",
                response=where,
                name=f"{name}, average {int(average)}",
            )
    rate = float(one.attrs["window_decay_rate"])
    window = f"exponential window {rate:.6g} 1/s taken off" if rate else "no exponential window"
    spectrum = partial(
        UffFunction, abscissa="frequency", position=one["frequency"].values, response=seen
    )
    receptance = partial(
        spectrum,
        kind="frequency response",
        quantity="displacement",
        over="force",
        remark=f"H1, {window}",
    )
    receptances = _complex(one, "unwindowed_receptance")
    yield receptance(values=receptances, reference=hit, name="receptance")
    yield spectrum(
        kind="coherence",
        values=one["coherence"].values,
        quantity="none",
        over="none",
        reference=hit,
        name="coherence",
    )
    for number, point in enumerate(grid):
        values, where = _complex(one, "grid_receptance")[number], nodes.degree_of_freedom(point)
        yield receptance(values=values, reference=where, name=f"receptance, impact at {point}")


def _modes(
    one: xr.Dataset, nodes: _Nodes, response: LinkPoint, grid: list[LinkPoint]
) -> Iterator[UffMode]:
    frequency, ratio = (one[f"identified_{name}"].values for name in ("frequency", "damping_ratio"))
    points = grid or [response]
    shapes = _complex(one, "shape") if grid else np.ones((1, frequency.size), dtype=complex)
    towards = np.array([nodes.towards(point) for point in points])
    labels = np.array([nodes.label(point) for point in points])
    for column, number in enumerate(one["mode"].values):
        if not np.isfinite(frequency[column]):
            continue
        omega, zeta = 2 * np.pi * frequency[column], ratio[column]
        yield UffMode(
            number=int(number),
            pole=complex(-zeta * omega, omega * np.sqrt(1 - zeta**2)),
            nodes=labels,
            shape=shapes[:, column, None] * towards,
            name=f"mode {int(number)}, {frequency[column]:.6g} Hz, damping ratio {zeta:.4g}",
        )


def _complex(one: xr.Dataset, name: str) -> ComplexArray:
    return np.asarray(one[f"{name}_real"].values + 1j * one[f"{name}_imag"].values)
