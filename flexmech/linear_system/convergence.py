"""How fast the frequencies of an engine converge with the mesh."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ConvergenceOrders"]


@dataclass(frozen=True)
class ConvergenceOrders:
    """Order in the element length of each part of a natural frequency's error.

    Estimates of the elastic part take the order that they observe, between those of stretching
    and of bending.

    Parameters
    ----------
    elastic : int
        Of the unloaded linkage at rest, of modes that bend.
    prestress : int
        Of the change by prestress.
    rotation : int
        Of the change by rotation terms. A pin's displacement turns with the leader's
        frame, the rest of the link with its own: a layer one element wide, so first order.
    stretching : int
        Of modes at rest that stretch links.
    """

    elastic: int
    prestress: int
    rotation: int = 1
    stretching: int = 2
