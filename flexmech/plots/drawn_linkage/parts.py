"""Joints, masses, bodies, springs and loads of a linkage, placed in one of its postures."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.arrays import FloatArray

# Places closer than this part of the linkage's extent are the same place: far above round-off, far
# below what a picture shows.
SAME_PLACE = 1e-6

Part = dict[str, Any]
"""One part as the attribute ``drawing`` of a dataset tells it."""


def extent_of(links: FloatArray) -> float:
    """Diagonal of the box around the ends of links; shape (..., link, station, 2)."""
    ends = links[..., [0, -1], :].reshape(*links.shape[:-3], -1, 2)
    return float(np.hypot(*np.ptp(ends, axis=-2).T).max())


@dataclass(frozen=True)
class LinkageParts:
    """What belongs to a linkage besides its links.

    Parameters
    ----------
    rigid : ndarray of bool, shape (link,)
        Which links do not bend.
    joints, masses, bodies, springs, joint_springs, loads : list of dict
        As ``flexmech.mechanism.drawn_parts`` gives them.
    hub : float
        Distance of the driven link's end from the axis of the shaft, in m.
    shaft : ndarray of shape (2,), optional
        Axis of the driven shaft in m; by its clamp if left out.
    gravity : tuple of float
        Along x and y in m/s^2.
    """

    rigid: NDArray[np.bool_]
    joints: list[Part] = field(default_factory=list)
    masses: list[Part] = field(default_factory=list)
    bodies: list[Part] = field(default_factory=list)
    springs: list[Part] = field(default_factory=list)
    joint_springs: list[Part] = field(default_factory=list)
    loads: list[Part] = field(default_factory=list)
    hub: float = 0.0
    shaft: FloatArray | None = None
    gravity: tuple[float, float] = (0.0, 0.0)

    def of_kind(self, *kinds: str) -> list[Part]:
        """Joints of some kinds."""
        return [joint for joint in self.joints if joint["kind"] in kinds]

    def springs_with(self, what: str) -> list[Part]:
        """Springs between points and in joints of which a word holds.

        Parameters
        ----------
        what : str
            ``"stiff"`` or ``"damped"`` of springs between points, ``"torsional"``, ``"radial"``,
            ``"torsion_damped"`` or ``"radially_damped"`` of those in joints. Files of earlier
            versions tell nothing of dampers, and every spring between points in them is stiff.

        Returns
        -------
        list of dict
        """
        known = [{"stiff": True} | spring for spring in self.springs]
        return [one for one in (*known, *self.joint_springs) if one.get(what)]


def parts_of(dataset: xr.Dataset, positions: FloatArray, held: NDArray[np.bool_]) -> LinkageParts:
    """Parts by the attribute ``drawing`` of a dataset, else by where ends of links are together.

    Parameters
    ----------
    dataset : Dataset
        Files of earlier versions have no such attribute.
    positions : ndarray, shape (configuration, link, station, 2)
        Of the rigid linkage in m.
    held : ndarray of bool, shape (link, 2)
        Whether the start and the end of each link stay in place.

    Returns
    -------
    LinkageParts
    """
    if "drawing" not in dataset.attrs:
        return _by_places(positions, held)
    return _told(json.loads(dataset.attrs["drawing"]))


def drawn_posture(dataset: xr.Dataset) -> tuple[FloatArray, LinkageParts, float] | None:
    """Links, parts and crank angle of the posture that the attribute ``drawing`` holds.

    Parameters
    ----------
    dataset : Dataset

    Returns
    -------
    ndarray, shape (link, 2, 2), LinkageParts, float
        In m and rad; None where the attribute holds no posture.
    """
    told = json.loads(dataset.attrs.get("drawing", "{}"))
    if "posture" not in told:
        return None
    posture = told["posture"]
    return np.array(posture["ends"]), _told(told), float(posture["crank_angle"])


def _told(told: Part) -> LinkageParts:
    rigid = np.array([link["rigid"] for link in told["links"]], dtype=bool)
    others = {name: part for name, part in told.items() if name not in ("links", "posture")}
    if "gravity" in others:
        others["gravity"] = tuple(others["gravity"])
    return LinkageParts(rigid, **others)


def _by_places(positions: FloatArray, held: NDArray[np.bool_]) -> LinkageParts:
    """Ends that stay are held by the ground, ends that are together in each posture are pinned."""
    near = SAME_PLACE * extent_of(positions)
    ends = [(link, station) for link in range(positions.shape[1]) for station in (0, -1)]
    joints: list[Part] = []
    for end in ends:
        place = positions[:, *end]
        together = [other for other in ends if np.abs(positions[:, *other] - place).max() <= near]
        at = [end[0], float(end[1] == -1)]
        if end == together[0] and held[end]:
            # The first link is the driven one.
            joints.append({"name": "", "kind": "pivot" if any(end) else "clamp", "at": at})
        elif end == together[0] and len(together) > 1:
            joints.append({"name": "", "kind": "pin", "at": at})
    starts = positions[:, 0, 0]
    stays = len(starts) > 1 and np.ptp(starts, axis=0).max() <= near
    shaft = starts[0] if stays else np.zeros(2)
    return LinkageParts(np.zeros(positions.shape[1], dtype=bool), joints, shaft=shaft)


@dataclass(frozen=True)
class Posture:
    """Links in one posture, straight or bent, and what belongs to them.

    Parameters
    ----------
    links : ndarray, shape (link, station, 2)
        Evenly spaced stations along each link, in m.
    parts : LinkageParts
    """

    links: FloatArray
    parts: LinkageParts

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the ends of the links, in m."""
        return extent_of(self.links)

    def place(self, at: list[float]) -> FloatArray:
        """Where a point is: number of a link, and how far along it from 0 to 1."""
        link = self.links[int(at[0])]
        along = np.linspace(0.0, 1.0, len(link))
        return np.array([np.interp(at[1], along, component) for component in link.T])

    def turned(self, link: int) -> FloatArray:
        """Axes of the frame of a link as columns, x from its start to its end."""
        along = self.links[link, -1] - self.links[link, 0]
        x, y = along / np.hypot(*along)
        return np.array([[x, -y], [y, x]])

    def line(self, slider: Part) -> float:
        """Angle of the line of a slider to the ground's x axis in rad."""
        guide = slider["guide"]
        frame = np.eye(2) if guide is None else self.turned(int(guide))
        return float(slider["direction"] + np.arctan2(frame[1, 0], frame[0, 0]))

    def spring_end(self, end: Part) -> FloatArray:
        """Where an end of a spring is."""
        return np.array(end["ground"], dtype=float) if "ground" in end else self.place(end["at"])

    def centre(self, body: Part) -> FloatArray:
        """Where the centre of mass of an attached body is."""
        frame = self.turned(int(body["at"][0]))
        return np.asarray(self.place(body["at"]) + frame @ np.array(body["offset"]))

    def force(self, load: Part) -> FloatArray:
        """Force of a load in ground axes."""
        frame = self.turned(int(load["at"][0])) if load["axes"] == "link" else np.eye(2)
        return np.asarray(frame @ np.array(load["force"]))
