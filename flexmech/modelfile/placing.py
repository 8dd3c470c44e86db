"""Points that lengths of links place where a drawing leaves them out."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from flexmech.arrays import SAME_PLACE
from flexmech.errors import InputError
from flexmech.modelfile.attachment_tables import JointTable
from flexmech.modelfile.document import ModelFile
from flexmech.modelfile.link_tables import LinkTable
from flexmech.modelfile.linkage_tables import PlanarTable
from flexmech.modelfile.messages import Findings

# Part of a length: coordinates of a drawing have six digits as a rule, of which the last is
# rounded.
AS_DRAWN = 1e-5


@dataclass(frozen=True)
class TwoPlaces:
    """A point that lengths place in two ways, of which one was taken.

    Parameters
    ----------
    point : str
    by : str
        What places it, in words.
    taken, other : complex
        Coordinates in m.
    """

    point: str
    by: str
    taken: complex
    other: complex

    def __str__(self) -> str:
        x, y = (f'"{_mm(along)}"' for along in (self.other.real, self.other.imag))
        return (
            f"{self.point} is at ({_mm(self.taken.real)}, {_mm(self.taken.imag)}), where {self.by} "
            f"places it; for the other place write {self.point} = [{x}, {y}] in [linkage.near]"
        )


@dataclass(frozen=True)
class Placed:
    """All points of a drawing, and those that could stand elsewhere.

    Parameters
    ----------
    points : dict of str to tuple of float
        Coordinates in m.
    twofold : tuple of TwoPlaces
    """

    points: dict[str, tuple[float, float]]
    twofold: tuple[TwoPlaces, ...]


def placed_points(tables: ModelFile, table: PlanarTable, findings: Findings) -> Placed:
    """Points of a drawing, those left out placed by lengths of links.

    A link with its length and its angle places its other end; a link with its length and a slider
    on a line, or two links with their lengths, place the point where they meet. Of two such places
    the one nearer to the rough one of ``[linkage.near]`` is taken, else the upper one, else, of
    equally high ones, the right one.

    Parameters
    ----------
    tables : ModelFile
    table : PlanarTable
        Its linkage.
    findings : Findings
        Lengths that disagree with what is drawn, or cannot meet.

    Returns
    -------
    Placed
        Without points that no length speaks of and that are not drawn: names of none, most likely.
    """
    placing = _Placing(tables, table, findings)
    placing.run()
    return Placed(
        {name: (place.real, place.imag) for name, place in placing.places.items()},
        tuple(placing.twofold),
    )


class _Length(NamedTuple):
    """A link with its length, from its known end."""

    link: str
    length: float
    known: str


class _Line(NamedTuple):
    """Line of a slider: a point on it, and its direction."""

    through: complex
    along: complex


class _Placing:
    """Places known so far, which grow until nothing more follows.

    Parameters
    ----------
    tables : ModelFile
    table : PlanarTable
    findings : Findings
    """

    def __init__(self, tables: ModelFile, table: PlanarTable, findings: Findings) -> None:
        self.tables, self.table, self.findings = tables, table, findings
        self.places = {name: complex(*pair) for name, pair in table.points.items()}
        self.twofold: list[TwoPlaces] = []
        self.links: dict[str, tuple[str, str]] = {}

    def run(self) -> None:
        """Place all that can be placed, and check what is stated of it."""
        for name, link in self.tables.links.items():
            with self.findings.at(f"links.{name}"):
                self._check_keys(link)
                if link.points is not None and len(link.points) == 2 and link.length is not None:
                    self.links[name] = link.points[0], link.points[1]
        before = len(self.findings.found)
        waiting = list(dict.fromkeys(end for ends in self.links.values() for end in ends))
        while len(self.findings.found) == before:
            waiting = [point for point in waiting if point not in self.places]
            if sum(map(self._place, waiting)) == 0:
                break
        if self.links:
            self._refuse_unplaced()
        if len(self.findings.found) == before:
            self._check_drawn()
        for point in self.table.near:
            with self.findings.at(f"linkage.near.{point}"):
                if point not in [two_places.point for two_places in self.twofold]:
                    raise InputError(
                        "no lengths place this point in two ways; leave it out, or draw it in "
                        "[linkage.points] alone"
                    )

    def _check_keys(self, link: LinkTable) -> None:
        """Refuse a length of what has several, and an angle alone."""
        if link.length is None and link.angle is None:
            return
        if link.points is None or len(link.points) != 2:
            raise InputError(
                "length and angle are of a link with two points; draw the points of a chain in "
                "[linkage.points]"
            )
        if link.length is None:
            raise InputError("angle is given without length; add it, or leave the angle out")

    def _angle(self, name: str) -> float | None:
        """Angle of a link from its first point to its second; of the crank that of the drawing."""
        angle = self.tables.links[name].angle
        if angle is not None or self.table.drawn_at is None:
            return angle
        for end in self.links[name]:
            joint = self.tables.joints.get(end)
            clamped = joint is not None and joint.kind == "clamp"
            if clamped and joint is not None and name in (joint.links or [name]):
                return self.table.drawn_at
        return None

    def _place(self, point: str) -> bool:
        """Whether a point could be placed."""
        lengths = list(self._lengths_to(point))
        for side in lengths:
            if (angle := self._angle(side.link)) is not None:
                forward = self.links[side.link][1] == point
                step = cmath.rect(side.length if forward else -side.length, angle)
                self.places[point] = self.places[side.known] + step
                return True
        joint = self.tables.joints.get(point)
        line = None if joint is None or joint.kind != "slider" else self._line(joint)
        if lengths and line is not None:
            with self.findings.at(f"links.{lengths[0].link}.length"):
                self._choose(
                    point, f"the {lengths[0].link}", self._on_line(point, lengths[0], line)
                )
        elif len(lengths) > 1:
            first, second = lengths[:2]
            with self.findings.at(f"links.{first.link}.length"):
                by = f"{first.link} and {second.link}"
                self._choose(point, f"the meeting of {by}", self._meeting(first, second))
        return point in self.places

    def _lengths_to(self, point: str) -> Iterator[_Length]:
        for name, ends in self.links.items():
            length = self.tables.links[name].length
            other = ends[0] if ends[1] == point else ends[1]
            if point in ends and other in self.places and length is not None:
                yield _Length(name, length, other)

    def _line(self, joint: JointTable) -> _Line | None:
        """Line of a slider; None while it is not known."""
        if joint.guide:
            guide = self.tables.links.get(joint.guide)
            names = list(guide.points or ())[:2] if guide is not None else []
            if len(names) < 2 or not all(name in self.places for name in names):
                return None
            start, end = (self.places[name] for name in names)
            turn = cmath.phase(end - start)
        else:
            clamps = [name for name, own in self.tables.joints.items() if own.kind == "clamp"]
            if not clamps or clamps[0] not in self.places:
                return None
            start, turn = self.places[clamps[0]], 0.0
        along = cmath.rect(1.0, turn + (joint.direction or 0.0))
        return _Line(start + 1j * along * (joint.offset or 0.0), along)

    def _on_line(self, point: str, side: _Length, line: _Line) -> tuple[complex, complex]:
        """Both points of a line at a length from the known end of a link."""
        across = (self.places[side.known] - line.through) / line.along
        foot, reach = line.through + across.real * line.along, _leg(side.length, across.imag)
        if reach is None:
            raise InputError(
                f"got {_mm(side.length)}, but the line of slider {point} is "
                f"{_mm(abs(across.imag))} from {side.known}; lengthen the {side.link}, or change "
                "offset or drawn_at"
            )
        return foot + reach * line.along, foot - reach * line.along

    def _meeting(self, first: _Length, second: _Length) -> tuple[complex, complex]:
        """Both points at two lengths from the known ends of two links."""
        apart = self.places[second.known] - self.places[first.known]
        distance = abs(apart)
        foot = (distance**2 + first.length**2 - second.length**2) / (2 * distance or math.inf)
        reach = _leg(first.length, foot)
        if reach is None or not distance:
            raise InputError(
                f"got {_mm(first.length)}, which does not meet the {second.link} of "
                f"{_mm(second.length)}: {first.known} and {second.known} are {_mm(distance)} "
                "apart; change a length, or drawn_at"
            )
        along = apart / distance
        base = self.places[first.known] + foot * along
        return base + 1j * reach * along, base - 1j * reach * along

    def _choose(self, point: str, by: str, two: tuple[complex, complex]) -> None:
        """Take one of two places."""
        size = abs(two[0] - two[1])
        if point in self.table.near:
            rough = complex(*self.table.near[point])
            taken = min(two, key=lambda place: abs(place - rough))
        else:
            level = abs(two[0].imag - two[1].imag) <= SAME_PLACE * size
            taken = max(two, key=lambda place: place.real if level else place.imag)
        self.places[point] = taken
        self.twofold.append(TwoPlaces(point, by, taken, two[0] if taken == two[1] else two[1]))

    def _refuse_unplaced(self) -> None:
        # Of another point that is not drawn the name is most likely wrong.
        meant = {end for ends in self.links.values() for end in ends} | set(self.tables.joints)
        named = (point for link in self.tables.links.values() for point in link.points or ())
        for point in dict.fromkeys(named):
            if point in self.places or point not in meant or self.findings.found:
                continue
            self.findings.found.append(
                f"linkage.points.{point}: it is not drawn, and no lengths place it; draw it, or "
                "give a link that leads to it length and angle, two links that meet there their "
                "lengths, or one that leads to a slider its length"
            )

    def _check_drawn(self) -> None:
        """Refuse lengths, angles and offsets that disagree with the places of points."""
        for name, ends in self.links.items():
            if not all(point in self.places for point in ends):
                continue
            link, (start, end) = self.tables.links[name], (self.places[point] for point in ends)
            length, apart = link.length or 0.0, end - start
            drawn = next(
                (point for point in reversed(ends) if point not in self.table.ground), ends[1]
            )
            remedy = f"leave {drawn} out of [linkage.points], or this key out here"
            with self.findings.at(f"links.{name}.length"):
                if abs(abs(apart) - length) > AS_DRAWN * length:
                    raise InputError(
                        f"got {_mm(length)}, but {ends[0]} and {ends[1]} are {_mm(abs(apart))} "
                        f"apart; {remedy}"
                    )
            with self.findings.at(f"links.{name}.angle"):
                if link.angle is None:
                    continue
                if abs(apart - cmath.rect(length, link.angle)) > 2 * AS_DRAWN * length:
                    raise InputError(
                        f"got {math.degrees(link.angle):.6g} deg, but from {ends[0]} to {ends[1]} "
                        f"it is {math.degrees(cmath.phase(apart)):.6g} deg; {remedy}"
                    )
        for name, joint in self.tables.joints.items():
            if joint.offset is None or joint.kind != "slider" or name not in self.places:
                continue
            if (line := self._line(joint)) is None:
                continue
            across = ((self.places[name] - line.through) / line.along).imag
            if abs(across) > AS_DRAWN * max(abs(self.places[name] - line.through), SAME_PLACE):
                self.findings.found.append(
                    f"joints.{name}.offset: got {_mm(joint.offset)}, but {name} is drawn "
                    f"{_mm(joint.offset + across)} from there; leave {name} out of "
                    "[linkage.points], or this key out here"
                )


def _leg(hypotenuse: float, leg: float) -> float | None:
    """Other leg of a right triangle; None where the hypotenuse is too short for it."""
    square = (hypotenuse - leg) * (hypotenuse + leg)
    if square < -SAME_PLACE * hypotenuse**2:
        return None
    return math.sqrt(max(square, 0.0))


def _mm(metres: float) -> str:
    return f"{1e3 * metres + 0.0:.6g} mm"
