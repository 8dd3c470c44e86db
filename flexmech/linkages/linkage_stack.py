"""Rigid linkages of several designs of one mechanism, moved at once."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.linkages.fourbar import FourBar
from flexmech.linkages.fourbar_motion import FourBarDimensions
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import LOCKING_SINE, RigidMotion
from flexmech.linkages.topology import Topology


@dataclass(frozen=True)
class LinkageStack:
    """D linkages whose topologies differ in the lengths of links alone.

    Parameters
    ----------
    linkages : tuple of Linkage
    """

    linkages: tuple[Linkage, ...]

    @property
    def topology(self) -> Topology:
        """Links and connections; lengths are those of the first linkage."""
        return self.linkages[0].topology

    def motion(self, crank_angle: FloatArray, crank_speed: FloatArray) -> RigidMotion:
        """Rigid motion of all linkages, each at as many positions.

        Parameters
        ----------
        crank_angle, crank_speed : ndarray, shape (D * A,)
            In rad and rad/s; first those of the first linkage.

        Returns
        -------
        RigidMotion
            Batch of shape (D * A,), with ``design``.

        Raises
        ------
        InputError
            Where one of them cannot be assembled or locks.
        """
        shape = (len(self.linkages), -1)
        angle, speed = crank_angle.reshape(shape), crank_speed.reshape(shape)
        four_bars = self._four_bars
        if four_bars is None:
            pairs = zip(self.linkages, angle, speed, strict=True)
            return RigidMotion.of_designs([one.motion(*each) for one, *each in pairs])
        cosine = four_bars.cosine_at_b(np.cos(angle))
        fails = (np.abs(cosine) > 1.0 + ROUND_OFF) | (1 - cosine**2 < LOCKING_SINE**2)
        changes = [one.change_points for one in self.linkages if isinstance(one, FourBar)]
        changing = np.array([own.angles.size > 0 for own in changes])
        for number in np.flatnonzero(fails.any(axis=1) | changing).tolist():
            # Says why.
            self.linkages[number].motion(angle[number])
        sides = np.array([own.sides(of) for own, of in zip(changes, angle, strict=True)])
        four_bars = replace(four_bars, side=four_bars.side * sides)
        moving = vars(four_bars.motion(angle, speed, np.zeros_like(angle)))
        every = {
            name: values.reshape(-1, *values.shape[2:])
            for name, values in moving.items()
            if name != "design"
        }
        return RigidMotion(**every, design=np.repeat(np.arange(shape[0]), angle.shape[1]))

    @cached_property
    def _four_bars(self) -> FourBarDimensions | None:
        """Dimensions as arrays (D, 1); None of other linkages."""
        every = [one.dimensions for one in self.linkages if isinstance(one, FourBar)]
        if len(every) < len(self.linkages):
            return None
        columns = (
            np.array([getattr(one, own.name) for one in every])[:, None]
            for own in fields(FourBarDimensions)
        )
        return FourBarDimensions(*columns)


def connections(linkage: Linkage) -> Hashable:
    """What two linkages must have in common to be stacked."""
    topology = linkage.topology
    links = tuple((link.name, link.rigid) for link in topology.links)
    joined = (topology.clamps, topology.pivots, topology.pins, topology.welds, topology.sliders)
    return type(linkage), links, joined
