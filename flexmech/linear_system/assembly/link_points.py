"""Points of links where a hammer hits or a vibrometer looks, and their displacement.

The displacement of a point is that of its link's shape functions, so that a point need not be a
node: ``u = row @ q`` with the coordinates q of the link, and ``row @ z`` with those of the linear
system. A force on the point in the same direction does the work ``f u``, so the transposed row is
its consistent load.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import LINK_DIRECTIONS, LinkDirection
from flexmech.errors import InputError, suggestion
from flexmech.linear_system.assembly.system import LinearSystem
from flexmech.linear_system.joints.carried_linkage import COORDINATES
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import Topology
from flexmech.validation import Bounds, check_choice, check_instance, check_number

ON_THE_LINK = Bounds(least=0.0, most=1.0)
EXAMPLE = "write LINK:FRACTION, such as coupler:0.5 for the middle of the coupler"


@dataclass(frozen=True)
class LinkPoint:
    """A point on a link's axis.

    Parameters
    ----------
    link : str
    fraction : float
        Of the link's length from its first joint, from 0 to 1.

    Raises
    ------
    InputError
        If the fraction is off the link.

    Examples
    --------
    >>> flexmech.LinkPoint.parse("coupler:0.5")
    LinkPoint(link='coupler', fraction=0.5)
    """

    link: str
    fraction: float

    def __post_init__(self) -> None:
        check_instance(self.link, str, "link of a point", EXAMPLE)
        check_number(self.fraction, f"the point's fraction of link {self.link!r}")
        if not ON_THE_LINK.hold(self.fraction):
            raise InputError(
                f"the point {self.link}:{self.fraction:g} is off its link; give a fraction of the "
                "link's length from 0, its first joint, to 1, its other end"
            )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read ``LINK:FRACTION``.

        Parameters
        ----------
        text : str

        Returns
        -------
        LinkPoint

        Raises
        ------
        InputError
            If it is no such text, or the point is off its link.
        """
        link, colon, fraction = text.strip().rpartition(":")
        try:
            number = float(fraction)
        except ValueError:
            colon = ""
        if not (colon and link.strip()):
            raise InputError(f"got {text!r}, which is no point of a link; {EXAMPLE}")
        return cls(link.strip(), number)

    def __str__(self) -> str:
        return f"{self.link}:{self.fraction:g}"

    def index(self, topology: Topology) -> int:
        """Number of its link.

        Parameters
        ----------
        topology : Topology

        Returns
        -------
        int

        Raises
        ------
        InputError
            If there is no such link; lists those that there are.
        """
        names = topology.link_names
        if self.link not in names:
            raise InputError(
                f"the point {self} is on no link of this linkage; {suggestion(self.link, names)}"
            )
        return topology.index(self.link)


def displacement_row(link: LinkModel, fraction: float, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in its link's coordinates.

    Parameters
    ----------
    link : LinkModel
        Reduced or not.
    fraction : float
        Of the link's length, from 0 to 1.
    direction : {"transverse", "axial"}
        Across the link's frame or along it.

    Returns
    -------
    ndarray, shape (n_link,)
        In m for coordinates in m and rad.

    Raises
    ------
    InputError
        If the direction is neither.
    """
    check_choice(direction, LINK_DIRECTIONS, "direction")
    shapes = link.readings.displacement_at(np.array([fraction]))
    return np.asarray(shapes[0, 0 if direction == "axial" else 1])


def point_rows(system: LinearSystem, point: LinkPoint, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in the coordinates of a linear system.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions.
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across its link's frame or along it.

    Returns
    -------
    ndarray, shape (B, n)
        ``rows[b] @ z`` is the displacement in m in position b, against the ground where a frame on
        springs carries the linkage. A unit force there in that direction is the generalized force
        ``rows[b]``.

    Raises
    ------
    InputError
        If the linkage has no such link, or the direction is neither.
    """
    frames = system.frames
    number = point.index(frames.topology)
    row = displacement_row(frames.links[number], point.fraction, direction)
    unit = np.broadcast_to(np.eye(system.size), (len(system.mass), system.size, system.size))
    rows = np.asarray(row @ system.link_coordinates(unit)[number])
    if (carried := system.carried) is not None:
        place = point.fraction * frames.topology.links[number].length
        unit = np.array([1.0, 0.0, 0.0] if direction == "axial" else [0.0, 1.0, place])
        rows[:, -COORDINATES:] += unit @ carried.fields(system.motion)[number]
    return rows
