"""Linkages with welds, lines and rigid links, said by their topology and motion alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech import FourBar, RotatingArm
from flexmech.linkages import Clamp, Link, LinkEnd, Pin, Pivot, RigidMotion, Slider, Topology, Weld
from flexmech.linkages.motion import direction, normal

FloatArray = NDArray[np.float64]


def with_links(motion: RigidMotion, *links: dict[str, FloatArray]) -> RigidMotion:
    """A motion with more links."""
    fields: dict[str, Any] = {"crank_angle": motion.crank_angle, "crank_speed": motion.crank_speed}
    for name in ("angle", "angular_velocity", "angular_acceleration"):
        more = [np.broadcast_to(link[name], motion.crank_angle.shape)[..., None] for link in links]
        fields[name] = np.concatenate([getattr(motion, name), *more], axis=-1)
    for name in ("origin", "origin_velocity", "origin_acceleration"):
        own = getattr(motion, name)
        more = [link[name][..., None, :] for link in links]
        fields[name] = np.concatenate([own, *more], axis=-2)
    return RigidMotion(**fields)


def welded(motion: RigidMotion, link: int, x: float, turn: float) -> dict[str, FloatArray]:
    """Motion of a link welded to a point of another one."""
    return {
        "angle": motion.angle[..., link] + turn,
        "angular_velocity": motion.angular_velocity[..., link],
        "angular_acceleration": motion.angular_acceleration[..., link],
        "origin": motion.position(link, x),
        "origin_velocity": motion.velocity(link, x),
        "origin_acceleration": motion.acceleration(link, x),
    }


class Plain:
    """What a linkage says of itself in words: nothing here."""

    kind: ClassVar[str] = "drawn"

    def resized(self, lengths: Any, ground_growth: float) -> Any:
        raise NotImplementedError

    def described(self) -> list[str]:
        return []

    def to_table(self) -> dict[str, object]:
        return {}


@dataclass(frozen=True)
class LArm(Plain):
    """A rotating arm with a second beam welded to its tip."""

    first: float = 0.25
    second: float = 0.2
    turn: float = np.pi / 2
    rigid: tuple[str, ...] = ()

    @property
    def topology(self) -> Topology:
        return Topology(
            links=(
                Link("arm", self.first, "arm" in self.rigid),
                Link("leg", self.second, "leg" in self.rigid),
            ),
            clamps=(Clamp("O2", LinkEnd("arm", "start")),),
            welds=(Weld("B", LinkEnd("arm", "end"), LinkEnd("leg", "start")),),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        own = RotatingArm(self.first).motion(crank_angle, crank_speed, crank_acceleration)
        return with_links(own, welded(own, 0, self.first, self.turn))


@dataclass(frozen=True)
class Ternary(Plain):
    """A four-bar whose coupler goes on beyond B, welded to it at an angle."""

    fourbar: FourBar
    beyond: float = 0.12
    turn: float = 0.6
    rigid: tuple[str, ...] = ()

    @property
    def topology(self) -> Topology:
        own = self.fourbar.topology
        links = tuple(Link(link.name, link.length, link.name in self.rigid) for link in own.links)
        return Topology(
            links=(*links, Link("beyond", self.beyond, "beyond" in self.rigid)),
            clamps=own.clamps,
            pivots=own.pivots,
            pins=own.pins,
            welds=(Weld("C", LinkEnd("coupler", "end"), LinkEnd("beyond", "start")),),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        own = self.fourbar.motion(crank_angle, crank_speed, crank_acceleration)
        return with_links(own, welded(own, 1, self.fourbar.coupler, self.turn))


@dataclass(frozen=True)
class SliderCrank(Plain):
    """Crank and coupler; the coupler's end slides on a line of the ground through an offset."""

    crank: float = 0.1
    coupler: float = 0.3
    line: float = 0.0
    offset: float = 0.02
    rigid: tuple[str, ...] = ()

    @property
    def topology(self) -> Topology:
        return Topology(
            links=(
                Link("crank", self.crank, "crank" in self.rigid),
                Link("coupler", self.coupler, "coupler" in self.rigid),
            ),
            clamps=(Clamp("O2", LinkEnd("crank", "start")),),
            pins=(Pin("A", LinkEnd("crank", "end"), LinkEnd("coupler", "start")),),
            sliders=(Slider("B", LinkEnd("coupler", "end"), self.line, self.offset),),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        own = RotatingArm(self.crank).motion(crank_angle, crank_speed, crank_acceleration)
        across = normal(np.asarray(self.line))
        at, rate, change = (
            getattr(own, name)(0, self.crank) @ across
            for name in ("position", "velocity", "acceleration")
        )
        # Sine of the coupler's angle against the line, and its derivatives.
        sine = (self.offset - at) / self.coupler
        angle = np.arcsin(sine)
        cosine = np.cos(angle)
        speed = -rate / (self.coupler * cosine)
        turning = (-change / self.coupler + sine * speed**2) / cosine
        coupler = welded(own, 0, self.crank, 0.0)
        coupler |= {
            "angle": angle + self.line,
            "angular_velocity": speed,
            "angular_acceleration": turning,
        }
        return with_links(own, coupler)


@dataclass(frozen=True)
class QuickReturn(Plain):
    """A crank whose end slides on a line of a rigid rocker."""

    crank: float = 0.1
    rocker: float = 0.35
    ground: float = 0.2
    offset: float = 0.02

    @property
    def topology(self) -> Topology:
        return Topology(
            links=(Link("crank", self.crank), Link("rocker", self.rocker, rigid=True)),
            clamps=(Clamp("O2", LinkEnd("crank", "start")),),
            pivots=(Pivot("O4", LinkEnd("rocker", "start")),),
            sliders=(Slider("A", LinkEnd("crank", "end"), 0.0, self.offset, "rocker"),),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        own = RotatingArm(self.crank).motion(crank_angle, crank_speed, crank_acceleration)
        o4 = np.array([0.0, -self.ground])
        arm = own.position(0, self.crank) - o4
        rate, change = own.velocity(0, self.crank), own.acceleration(0, self.crank)
        far = np.sum(arm * arm, axis=-1)
        # normal(angle) . arm = offset, and its derivatives.
        along = np.sqrt(far - self.offset**2)
        angle = np.arctan2(arm[..., 1], arm[..., 0]) - np.arctan2(self.offset, along)
        x, y = direction(angle), normal(angle)

        def dot(first: FloatArray, second: FloatArray) -> FloatArray:
            return np.asarray(np.sum(first * second, axis=-1))

        speed = dot(y, rate) / along
        turning = (dot(y, change) - 2 * speed * dot(x, rate) - speed**2 * self.offset) / along
        still = np.zeros_like(arm)
        rocker = {
            "angle": angle,
            "angular_velocity": speed,
            "angular_acceleration": turning,
            "origin": still + o4,
            "origin_velocity": still,
            "origin_acceleration": still,
        }
        return with_links(own, rocker)


class Ties:
    """Displacements of all links, in their frames, that the joints of one position allow.

    From the joints' own conditions and not by way of independent coordinates.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
        Batch of one.
    links : sequence of LinkModel
    displacement : sequence of ndarray, shape (1, n_link), optional
        Of the links; rigid ones turn, and points of sliders move along their lines.
    """

    def __init__(
        self,
        topology: Topology,
        motion: RigidMotion,
        links: Any,
        displacement: Sequence[FloatArray] | None = None,
    ) -> None:
        self.topology, self.motion, self.links = topology, motion, links
        self.displacement = displacement
        self.first = np.concatenate([[0], np.cumsum([link.size for link in links])])

    @property
    def basis(self) -> FloatArray:
        """Orthogonal basis, (all coordinates, m)."""
        topology, place, turning = self.topology, self._place, self._turning
        rows: list[FloatArray] = []
        for clamp in topology.clamps:
            rows += [place(clamp.link_end), turning(clamp.link_end.link, clamp.link_end.end)]
        rows += [place(pivot.link_end) for pivot in topology.pivots if not pivot.sprung]
        rows += [place(tie.follower) - place(tie.leader) for tie in self._ties]
        for weld in topology.welds:
            ends = weld.follower, weld.leader
            after, before = (turning(end.link, end.end) for end in ends)
            rows.append(after - before)
        for slider in topology.sliders:
            apart, angle = self._on_line(slider)
            rows.append(normal(angle)[None] @ apart)
        _, size, right = np.linalg.svd(np.concatenate(rows))
        rank = int(np.sum(size > 1e-9 * size[0]))
        return np.asarray(right[rank:].T)

    @property
    def _ties(self) -> list[Pin | Weld]:
        return [tie for tie in self.topology.ties if isinstance(tie, Weld) or not tie.sprung]

    @property
    def gaps(self) -> FloatArray:
        """How far the displacements tear or turn each joint, in m and rad."""
        topology, torn = self.topology, []
        for clamp in topology.clamps:
            torn += [self._torn(clamp.link_end), self._angle(clamp.link_end)]
        torn += [self._torn(pivot.link_end) for pivot in topology.pivots if not pivot.sprung]
        torn += [self._at(tie.follower) - self._at(tie.leader) for tie in self._ties]
        for weld in topology.welds:
            torn.append(self._angle(weld.follower) - self._angle(weld.leader))
        for slider in topology.sliders:
            angle, start = np.asarray(slider.direction), np.zeros(2)
            if slider.guide:
                guide = LinkEnd(slider.guide, "start")
                turned = self.motion.angle[0, topology.index(slider.guide)]
                angle, start = angle + turned + self._angle(guide)[0], self._at(guide)
            torn.append((self._at(slider.link_end) - start) @ normal(angle) - [slider.offset])
        return np.concatenate(torn)

    def line_stiffness(self, force: FloatArray) -> FloatArray:
        """Of guides that turn while a point slides on them under a force normal to them.

        Force of each line on the point, (n_sliders,); the stiffness is by all coordinates.
        """
        total = np.zeros((self.first[-1], self.first[-1]))
        for slider, size in zip(self.topology.sliders, force, strict=True):
            if slider.guide:
                apart, angle = self._on_line(slider)
                coupling = size * self._turning(slider.guide).T @ (direction(angle)[None] @ apart)
                total += coupling + coupling.T
        return total

    def _place(self, end: LinkEnd) -> FloatArray:
        """Displacement of a link end in ground axes, (2, all coordinates)."""
        link = self.topology.index(end.link)
        if self.links[link].rigid:
            x = 0.0 if end.end == "start" else self.topology.links[link].length
            return self._body_point(link, x, 0.0)
        row = np.zeros((2, self.first[-1]))
        own = self.first[link] + self.links[link].end_displacement(end.end)
        row[:, own] = self._axes(link)
        return row

    def _at(self, end: LinkEnd) -> FloatArray:
        """Where a link end is, (2,)."""
        link, moved = self.topology.index(end.link), self._moved(self.topology.index(end.link))
        x = 0.0 if end.end == "start" else self.topology.links[link].length
        if not self.links[link].rigid:
            own = moved[self.links[link].end_displacement(end.end)]
            return np.asarray(self.motion.position(link, x)[0] + self._axes(link) @ own)
        angle = self.motion.angle[0, link] + moved[2]
        start = self.motion.origin[0, link] + self._axes(link) @ moved[:2]
        return np.asarray(start + x * direction(angle))

    def _torn(self, end: LinkEnd) -> FloatArray:
        link = self.topology.index(end.link)
        x = 0.0 if end.end == "start" else self.topology.links[link].length
        return np.asarray(self._at(end) - self.motion.position(link, x)[0])

    def _angle(self, end: LinkEnd) -> FloatArray:
        """By how much a link end is turned, (1,)."""
        link = self.topology.index(end.link)
        return np.asarray(self._moved(link)[self.links[link].end_rotation_of(end.end)])

    def _axes(self, link: int) -> FloatArray:
        angle = self.motion.angle[0, link]
        return np.stack([direction(angle), normal(angle)], axis=1)

    def _body_point(self, link: int, x: float, y: float) -> FloatArray:
        """The same of a point of a rigid link that may be turned."""
        row = np.zeros((2, self.first[-1]))
        angle = self.motion.angle[0, link] + self._moved(link)[2]
        own = self.first[link]
        row[:, own : own + 2] = self._axes(link)
        row[:, own + 2] = x * normal(angle) - y * direction(angle)
        return row

    def _turning(self, link: str, end: str = "start") -> FloatArray:
        number = self.topology.index(link)
        row = np.zeros((1, self.first[-1]))
        row[0, self.first[number] + self.links[number].end_rotation_of(end)] = 1.0
        return row

    def _moved(self, link: int) -> FloatArray:
        size = self.links[link].size
        return np.zeros(size) if self.displacement is None else self.displacement[link][0]

    def _on_line(self, slider: Slider) -> tuple[FloatArray, FloatArray]:
        """Displacement of the held point from that of its line, and the line's angle."""
        held, angle = self._place(slider.link_end), np.asarray(slider.direction)
        if not slider.guide:
            return held, angle
        topology, motion = self.topology, self.motion
        guide, link = topology.index(slider.guide), topology.index(slider.link_end.link)
        x = 0.0 if slider.link_end.end == "start" else topology.links[link].length
        own = self._moved(link)[self.links[link].end_displacement(slider.link_end.end)]
        at = motion.position(link, x)[0] + self._axes(link) @ own
        start = motion.origin[0, guide] + self._axes(guide) @ self._moved(guide)[:2]
        turned = motion.angle[0, guide] + self._moved(guide)[2]
        lever = at - start
        row = self._body_point(guide, lever @ direction(turned), lever @ normal(turned))
        return held - row, angle + turned
