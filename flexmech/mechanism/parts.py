"""Parts of a mechanism besides linkage and sections: masses, pins, water, and its source.

A machine's frame on springs is one of its parts: three coordinates under the linkage.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError, is_plain
from flexmech.linkages.motion import cross, quarter_turn, turned
from flexmech.materials.moisture import Faces
from flexmech.model_text import TomlTable, quantity, short_repr
from flexmech.units import LENGTH, MASS
from flexmech.validation import (
    checked_tuple,
)

EYE_SIZES = ("thickness", "width", "edge_distance")
"""Fields of an eye that may be stated; in a model file they begin with ``eye_``."""


@dataclass(frozen=True)
class PointMass:
    """A point mass on a link.

    Parameters
    ----------
    link : str
    position : float
        Distance from the link's first joint in m.
    mass : float
        Mass of the point in kg.

    Examples
    --------
    >>> section = flexmech.BeamSection.rectangle(flexmech.Material(70e9, 2700.0), 3e-3, 25e-3)
    >>> arm = flexmech.RotatingArm(length=0.3)
    >>> tip = flexmech.PointMass("arm", position=0.3, mass=0.01)
    >>> mechanism = flexmech.Mechanism(arm, {"arm": section}, link_masses=(tip,))
    >>> round(mechanism.link_mass("arm").moment(0), 6)  # with the arm itself, in kg
    0.07075
    """

    link: str
    position: si.LengthOrZero
    mass: si.Mass

    def to_table(self) -> TomlTable:
        """Entry of ``point_masses`` of its link in a model file."""
        return si.table(self)


@dataclass(frozen=True)
class AttachedBody:
    """A rigid body that is fixed to the section of a link: a hub, a piston, a counterweight.

    Parameters
    ----------
    link : str
    position : float
        Distance from the link's first joint of the section that it is fixed to, in m.
    mass : float
        Its mass in kg.
    inertia : float
        About its centre of mass in kg m^2.
    offset : tuple of float
        From the axis of the link at the position to its centre of mass in m, along and across the
        link, to the left positive.
    outline : tuple of tuple of float
        Corners in m, along and across the link from its first joint, that pictures show. Nothing
        is computed from them, and model files that are written leave them out.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> flexmech.AttachedBody("crank", 0.0, mass=0.2, offset=(-0.03, 0.0)).inertia
    0.0
    """

    link: str
    position: si.LengthOrZero
    mass: si.Mass = 0.0
    inertia: si.Inertia = 0.0
    offset: tuple[si.Distance, si.Distance] = (0.0, 0.0)
    outline: tuple[tuple[float, float], ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        si.check(self, f"body on the {self.link}: {{}}")
        along, across = self.offset
        object.__setattr__(self, "offset", (along, across))

    def to_table(self) -> TomlTable:
        """Entry of ``bodies`` of its link in a model file."""
        # A file states one of mass and inertia at least.
        mass = {} if self.mass or self.inertia else {"mass": quantity(self.mass, MASS)}
        return si.table(self) | mass


@dataclass(frozen=True)
class Wetting:
    """Where water can enter a link.

    Parameters
    ----------
    faces : {"both", "lower", "upper"}
        Faces that look to the sides of the link in the linkage's plane; lower is that of the
        lowest y of the link's frame.
    sides : bool
        Whether water enters across the joint axes too.
    """

    faces: Faces = "both"
    sides: bool = False

    def to_table(self) -> TomlTable:
        """Keys of a link in a model file; empty where both faces are wet and no sides."""
        faces = {} if self.faces == "both" else {"exposed_faces": self.faces}
        return {**faces, "exposed_sides": True} if self.sides else faces


@dataclass(frozen=True)
class Provenance:
    """Where a mechanism came from.

    Parameters
    ----------
    name : str
        Short name, used in titles.
    source : str
        Publication or drawing.
    file : str
        Model file's name, empty when built in Python. Does not count in comparisons.
    sha256 : str
        Hash of the model file's bytes, empty when built in Python. Does not count either.
    text : str
        The model file's text, empty when built in Python. Does not count either.

    Raises
    ------
    InputError
        If the name is empty, or a text holds control characters.
    """

    name: str = "mechanism"
    source: str = ""
    file: str = field(default="", compare=False)
    sha256: str = field(default="", compare=False)
    text: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name.strip() and "\n" not in self.name):
            raise InputError(
                "name of a mechanism must be one line of text that is not empty, got "
                f"{self.name!r}; it stands in titles"
            )
        for text in (self.name, self.source, self.file):
            if not (isinstance(text, str) and is_plain(text)):
                raise InputError(f"name, source and file must be plain text, got {text!r}")

    def __repr__(self) -> str:
        return short_repr(self, self.name, self.file or "made in Python")


@dataclass(frozen=True)
class PinEye:
    """End of a link around the hole of a pin.

    Parameters
    ----------
    link : str
    thickness : float, optional
        Length of the hole along the pin in m; as of the link's section if left out.
    width : float, optional
        Width of the eye across the link, in the plane of motion, in m; as of the link's section if
        left out.
    edge_distance : float, optional
        From the centre of the hole to the end of the link in m.

    Raises
    ------
    InputError
        If a size is not positive.

    Examples
    --------
    >>> flexmech.PinEye("coupler", thickness=6e-3, width=20e-3).edge_distance is None
    True
    """

    link: str
    thickness: si.Width | None = None
    width: si.Width | None = None
    edge_distance: si.Width | None = None

    def __post_init__(self) -> None:
        si.check(self, f"{{}} of the eye of the {self.link}")


@dataclass(frozen=True)
class JointPin:
    """Pin of a joint.

    Parameters
    ----------
    joint : str
    diameter : float
        Diameter of the pin in m, of a pin or pivot, or in a slider's block; strength judges the
        pins that have one.
    eyes : tuple of PinEye
        Eyes of links that meet there; one without any sizes may be left out.
    bush_length : float, optional
        Length of the bush in which the pin turns in m; the shortest hole around it if left
        out.
    allowable_bearing_pressure : float, optional
        Allowable bearing pressure of pin and holes in Pa: force over diameter and length of the
        hole.
    allowable_pv : float, optional
        Allowable pv of the bush: greatest bearing pressure times sliding velocity. In Pa m/s.

    Raises
    ------
    InputError
        If a size is not positive, an eye is there twice, or an eye is no larger than its hole.

    Examples
    --------
    >>> eye = flexmech.PinEye("coupler", thickness=6e-3, width=20e-3, edge_distance=15e-3)
    >>> flexmech.JointPin("A", diameter=8e-3, eyes=(eye,), allowable_pv=1.8e6).eye("coupler").width
    0.02
    """

    joint: str
    diameter: si.Width
    eyes: tuple[PinEye, ...] = ()
    bush_length: si.Width | None = None
    allowable_bearing_pressure: si.Stress | None = None
    allowable_pv: si.PressureVelocity | None = None

    def __post_init__(self) -> None:
        what = f"pin of joint {self.joint}"
        si.check(self, f"{{}} of the {what}")
        remedy = "give PinEye(link, thickness, width, edge_distance) in a tuple"
        eyes = checked_tuple(self.eyes, PinEye, f"{what}: eyes", remedy)
        links = [eye.link for eye in eyes]
        # Equivalent entries are kept in one form, so that equal pins compare equal.
        known = sorted((eye for eye in eyes if eye != PinEye(eye.link)), key=lambda eye: eye.link)
        object.__setattr__(self, "eyes", tuple(known))
        for eye in eyes:
            if links.count(eye.link) > 1:
                raise InputError(f"{what}: the {eye.link} has two eyes; give one")
            for name, least in (("width", self.diameter), ("edge_distance", self.diameter / 2)):
                size = getattr(eye, name)
                if size is not None and size <= least:
                    raise InputError(
                        f"{what}: {name} of the eye of the {eye.link} must be greater than "
                        f"{least:g} m, which the hole takes of it, got {size:g} m"
                    )

    def eye(self, link: str) -> PinEye:
        """Eye of a link; of no stated sizes where none is stated."""
        return next((eye for eye in self.eyes if eye.link == link), PinEye(link))

    def to_table(self) -> TomlTable:
        """Keys of the joint in a model file."""
        table = si.table(self)
        for name in EYE_SIZES:
            stated = {
                eye.link: quantity(size, LENGTH)
                for eye in self.eyes
                if (size := getattr(eye, name)) is not None
            }
            if stated:
                table[f"eye_{name}"] = stated
        return table


# Least eigenvalue of the stiffness, with rotations in units of the springs' extent, over the
# greatest: below it a motion of the frame meets no spring but for round-off.
_LOOSE = 1e-12


@dataclass(frozen=True)
class FrameSpring:
    """A spring between the frame and the floor, with a damper beside it.

    It is linear in the displacement of its point along x and y, as a rubber mount or a cushion is,
    and without force where the frame is drawn.

    Parameters
    ----------
    point : tuple of float
        Point of the frame in m, in the axes of the ground as the frame is drawn.
    stiffness : tuple of float
        Along x and y in N/m; it is without force where the frame is drawn.
    damping : tuple of float
        Along x and y in N s/m.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> flexmech.FrameSpring((0.0, -0.1), (2e5, 4e5)).damping
    (0.0, 0.0)
    """

    point: tuple[si.Distance, si.Distance]
    stiffness: tuple[si.SpringStiffness, si.SpringStiffness]
    damping: tuple[si.Damping, si.Damping] = (0.0, 0.0)

    def __post_init__(self) -> None:
        si.check(self, "spring of the frame: {}")
        for name in si.quantities(FrameSpring):
            object.__setattr__(self, name, tuple(map(float, getattr(self, name))))

    def to_table(self) -> TomlTable:
        """Entry of ``frame.springs`` of a model file."""
        return si.table(self)


@dataclass(frozen=True)
class SprungFrame:
    """The rigid frame that carries the linkage, on springs.

    All that is on the ground of the linkage is on this frame: pivots, the shaft with its drive,
    lines of sliders, and the ends of springs that are on the ground. Its coordinates are the
    displacement of its centre of mass along x and y, and its rotation.

    Parameters
    ----------
    mass : float
        Mass without the linkage in kg.
    inertia : float
        About the centre of mass in kg m^2.
    centre : tuple of float
        Its centre of mass in m, in the axes of the ground.
    springs : tuple of FrameSpring

    Raises
    ------
    InputError
        If a number is out of its range, or the springs let the frame move without force.

    Examples
    --------
    >>> springs = [flexmech.FrameSpring((x, -0.1), (2e5, 4e5)) for x in (-0.1, 0.3)]
    >>> frame = flexmech.SprungFrame(12.0, 0.4, (0.1, 0.0), tuple(springs))
    >>> frame.natural_frequencies.round(1)
    array([26.6, 41.1, 49.2])
    """

    mass: si.BodyMass
    inertia: si.BodyInertia
    centre: tuple[si.Distance, si.Distance]
    springs: tuple[FrameSpring, ...]

    def __post_init__(self) -> None:
        si.check(self, "{} of the frame")
        object.__setattr__(self, "centre", tuple(float(value) for value in self.centre))
        remedy = "give FrameSpring((m, m), (N/m, N/m)) in a tuple"
        springs = checked_tuple(self.springs, FrameSpring, "springs of the frame", remedy)
        object.__setattr__(self, "springs", springs)
        self._refuse_loose()

    def _refuse_loose(self) -> None:
        """Refuse springs that let the frame move."""
        extent = max((np.hypot(*self._arm(spring)) for spring in self.springs), default=0.0) or 1.0
        scale = np.array([1.0, 1.0, 1.0 / extent])
        values, ways = np.linalg.eigh(scale[:, None] * self.stiffness * scale)
        if values[0] > _LOOSE * values[-1]:
            return
        free = ("move along x", "move along y", "turn")[int(np.abs(ways[:, 0]).argmax())]
        raise InputError(
            f"the springs of the frame let it {free} without force; add one, or give each a "
            "stiffness along x and y"
        )

    def _arm(self, spring: FrameSpring) -> tuple[float, float]:
        """From the centre to a spring in m."""
        return spring.point[0] - self.centre[0], spring.point[1] - self.centre[1]

    @cached_property
    def inertia_matrix(self) -> FloatArray:
        """Mass matrix of the frame alone, (3, 3)."""
        return np.diag([self.mass, self.mass, self.inertia])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix of its springs, (3, 3)."""
        return self._summed(lambda spring: spring.stiffness)

    @cached_property
    def damping(self) -> FloatArray:
        """Damping matrix of the dampers beside its springs, (3, 3)."""
        return self._summed(lambda spring: spring.damping)

    def _summed(self, of: Callable[[FrameSpring], tuple[float, float]]) -> FloatArray:
        total = np.zeros((3, 3))
        for spring in self.springs:
            x, y = self._arm(spring)
            moved = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
            total += moved.T @ np.diag(of(spring)) @ moved
        return total

    def point_motion(
        self, point: tuple[float, float], place: FloatArray, rate: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Displacement (m, 2) of a point, by its place as it is drawn, and the rate of that.

        Parameters
        ----------
        point : tuple of float
            In ground axes in m.
        place, rate : ndarray, shape (m, 3)
            Displacement and rotation of the frame, of any size, and their time derivatives.
        """
        lever = np.tile(np.subtract(point, self.centre), (len(place), 1))
        arm = turned(lever, place[:, 2])
        return place[:, :2] + arm - lever, rate[:, :2] + rate[:, 2, None] * quarter_turn(arm)

    def spring_forces(self, place: FloatArray, rate: FloatArray) -> FloatArray:
        """Forces and moment (m, 3) of springs and dampers against the motion of the frame.

        Parameters
        ----------
        place, rate : ndarray, shape (m, 3)
            As of :meth:`point_motion`.
        """
        total = np.zeros_like(place)
        for spring in self.springs:
            moved, speed = self.point_motion(spring.point, place, rate)
            force = moved * spring.stiffness + speed * spring.damping
            arm = moved - place[:, :2] + np.subtract(spring.point, self.centre)
            total += np.column_stack([force, cross(arm, force)])
        return total

    @property
    def natural_frequencies(self) -> FloatArray:
        """Natural frequencies of the frame alone on its springs in Hz, ascending, (3,)."""
        half = 1 / np.sqrt(np.diag(self.inertia_matrix))
        squares = np.linalg.eigvalsh(half[:, None] * self.stiffness * half)
        return np.asarray(np.sqrt(squares) / (2 * np.pi), dtype=float)

    @property
    def undamped(self) -> SprungFrame:
        """The same without dampers."""
        springs = tuple(replace(spring, damping=(0.0, 0.0)) for spring in self.springs)
        return replace(self, springs=springs)

    @property
    def words(self) -> str:
        """Its mass, its springs, and its natural frequencies without the linkage."""
        alone = ", ".join(f"{value:.4g}" for value in self.natural_frequencies)
        count = f"{len(self.springs)} spring{'s' if len(self.springs) > 1 else ''}"
        return f"{self.mass:.6g} kg on {count}, alone at {alone} Hz"

    def to_table(self) -> TomlTable:
        """Table ``[frame]`` of a model file."""
        return {**si.table(self), "springs": [spring.to_table() for spring in self.springs]}
