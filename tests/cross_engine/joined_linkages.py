"""Linkages with welds, lines and rigid links, said by their topology and motion alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech import FourBar, RotatingArm
from flexmech.linkages import Clamp, Link, LinkEnd, Pin, RigidMotion, Slider, Topology, Weld
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


def tie_basis(topology: Topology, motion: RigidMotion, links: Any) -> FloatArray:
    """Displacements of all links, in their frames, that the joints of one position allow.

    Columns of an orthogonal basis, (all coordinates, m), from the joints' own conditions and not
    by way of independent coordinates.
    """
    sizes = [link.size for link in links]
    first = np.concatenate([[0], np.cumsum(sizes)])
    rows: list[FloatArray] = []

    def place(end: LinkEnd) -> FloatArray:
        number = topology.index(end.link)
        row = np.zeros((2, first[-1]))
        angle = motion.angle[0, number]
        turn = np.stack([direction(angle), normal(angle)], axis=1)
        row[:, first[number] + links[number].end_displacement(end.end)] = turn
        return row

    def turning(end: LinkEnd) -> FloatArray:
        number = topology.index(end.link)
        row = np.zeros((1, first[-1]))
        row[0, first[number] + links[number].end_rotation_of(end.end)] = 1.0
        return row

    for clamp in topology.clamps:
        rows += [place(clamp.held), turning(clamp.held)]
    rows += [place(pivot.held) for pivot in topology.pivots]
    rows += [place(tie.follower) - place(tie.leader) for tie in topology.ties]
    rows += [turning(weld.follower) - turning(weld.leader) for weld in topology.welds]
    for slider in topology.sliders:
        rows.append(normal(np.asarray(slider.direction))[None] @ place(slider.held))
    conditions = np.concatenate(rows)
    _, size, right = np.linalg.svd(conditions)
    rank = int(np.sum(size > 1e-9 * size[0]))
    return np.asarray(right[rank:].T)
