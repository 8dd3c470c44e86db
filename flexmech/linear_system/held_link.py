"""A link with its joined ends held: what its component modes are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.linear_system.chains import couples
from flexmech.linear_system.flexibility import Flexibility
from flexmech.linear_system.held_modes import HeldModes
from flexmech.linear_system.link_boundary import JoinedEnds, LinkBoundary, link_boundary
from flexmech.linear_system.link_model import LinkModel
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class HeldLink:
    """A link with its joined ends held: static shapes and vibration modes.

    Parameters
    ----------
    link : LinkModel
        Of n coordinates.
    boundary : LinkBoundary
    static : ndarray, shape (n, b)
        What each coordinate that the link keeps at its joints moves statically.
    bending, axial : HeldModes
        Vibration modes, normalized by the mass.
    bending_relief, axial_relief : ndarray, shape (n, r)
        Static answers to the inertia of the static shapes, and to couples at free ends.
    floating_relief : ndarray, shape (n, r)
        That to a motion along the link as a whole.
    layers : ndarray, shape (n, k)
        Static shapes of ends that follow, without the ends: they vanish at the joints.
    flexibility : Flexibility
        Of the coordinates that no joint holds or moves.
    """

    link: LinkModel
    boundary: LinkBoundary
    static: FloatArray
    bending: HeldModes
    axial: HeldModes
    bending_relief: FloatArray
    axial_relief: FloatArray
    floating_relief: FloatArray
    layers: FloatArray
    flexibility: Flexibility

    @property
    def inner(self) -> IntArray:
        """Coordinates that no joint holds or moves, (i,)."""
        return self.flexibility.free


def hold_ends(ends: JoinedEnds, link: LinkModel, couples: FloatArray) -> HeldLink:
    """Static shapes and vibration modes of a flexible link.

    Parameters
    ----------
    ends : JoinedEnds
        Of the linkage.
    link : LinkModel
        Unreduced.
    couples : ndarray, shape (n, k)
        Forces of springs in joints that turn the link's ends.

    Returns
    -------
    HeldLink
    """
    boundary = link_boundary(ends, link)
    inner = np.flatnonzero(~(boundary.fixed | boundary.joined))
    flexibility = Flexibility(link.stiffness, inner)
    static = boundary.unit.copy()
    static[inner] = -flexibility.answers((link.stiffness @ boundary.unit)[inner])
    layers = (static - boundary.unit)[:, boundary.following]
    relief = np.zeros_like(static)
    relief[inner] = flexibility.answers((link.mass @ static)[inner])
    axial_boundary = boundary.unit[link.is_axial].any(axis=0)
    # A link that no end ties to the ground moves along itself as a whole: one axial shape.
    # A held one only stretches: of a slender one far too little for inertia to matter.
    floats = bool(axial_boundary.any()) and not boundary.fixed.any()
    axial_relief = relief[:, axial_boundary]
    floating_relief = axial_relief.sum(axis=1, keepdims=True)
    stretching, turning = inner[link.is_axial[inner]], inner[~link.is_axial[inner]]
    answers = [relief[:, ~axial_boundary], _turning_of_arms(link, flexibility)]
    # Modes of a link whose ends turn freely converge slowly to a spring against that.
    turned = np.zeros_like(couples)
    turned[inner] = flexibility.answers(couples[inner])
    return HeldLink(
        link=link,
        boundary=boundary,
        static=static,
        # Where an axis off the pins couples both, bending goes along without axial force.
        bending=HeldModes(link, turning, stretching),
        axial=HeldModes(link, stretching),
        bending_relief=np.concatenate([*answers, turned], axis=1),
        axial_relief=axial_relief,
        floating_relief=floating_relief if floats else relief[:, :0],
        layers=layers,
        flexibility=flexibility,
    )


def _turning_of_arms(link: LinkModel, flexibility: Flexibility) -> FloatArray:
    """Static answer (n, m) of a link off its pins to couples at its free ends.

    The force of a pin on an arm that turns is a spring against the end's rotation, and modes
    of the link with its ends free to turn converge slowly to that.
    """
    if not (couples(link.stiffness, link.is_axial, ~link.is_axial) or link.first_moment.any()):
        return np.zeros((link.size, 0))
    ends, inner = np.concatenate([link.start_rotation[:1], link.end_rotation[:1]]), flexibility.free
    turned = ends[np.isin(ends, inner)]
    shapes = np.zeros((link.size, len(turned)))
    shapes[turned, np.arange(len(turned))] = 1.0
    shapes[inner] = flexibility.answers(shapes[inner])
    return shapes
