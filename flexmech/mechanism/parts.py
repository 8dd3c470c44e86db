"""What a mechanism has besides linkage and sections: masses, pins, water, where it is from."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexmech.errors import InputError, is_plain
from flexmech.materials.moisture import Faces
from flexmech.model_text import TomlTable, fields_table, quantity, short_repr
from flexmech.units import INERTIA, LENGTH, MASS, PRESSURE_VELOCITY, STRESS
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_fields,
    check_number,
    check_pair,
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
        Distance from the link's start in m.
    mass : float
        In kg.

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
    position: float
    mass: float

    def to_table(self) -> TomlTable:
        """Entry of ``point_masses`` of its link in a model file."""
        return fields_table(self, {"position": LENGTH, "mass": MASS})


@dataclass(frozen=True)
class AttachedBody:
    """A rigid body that is fixed to the section of a link: a hub, a piston, a counterweight.

    Parameters
    ----------
    link : str
    position : float
        Distance from the link's start of the section that it is fixed to, in m.
    mass : float
        In kg.
    inertia : float
        About its own centre of mass, in kg m^2.
    offset : tuple of float
        From the axis of the link at ``position`` to its centre of mass, along and across the
        link's frame, in m.

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
    position: float
    mass: float = 0.0
    inertia: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        what = f"body on the {self.link}"
        for name, unit in (("position", "m"), ("mass", "kg"), ("inertia", "kg m^2")):
            check_number(getattr(self, name), f"{what}: {name}", unit, NOT_NEGATIVE)
        check_pair(self.offset, f"{what}: offset", "m")
        along, across = self.offset
        object.__setattr__(self, "offset", (along, across))

    def to_table(self) -> TomlTable:
        """Entry of ``bodies`` of its link in a model file."""
        # A file states one of mass and inertia at least.
        mass = {} if self.inertia else {"mass": quantity(self.mass, MASS)}
        keys = fields_table(self, {"mass": MASS, "inertia": INERTIA, "offset": LENGTH})
        return {"position": quantity(self.position, LENGTH), **mass, **keys}


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
        Of the eye across the link, in the plane of motion, in m; as of the link's section if left
        out.
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
    thickness: float | None = None
    width: float | None = None
    edge_distance: float | None = None

    def __post_init__(self) -> None:
        of = f"of the eye of the {self.link}"
        check_fields(self, dict.fromkeys(EYE_SIZES, "m"), POSITIVE, of, optional=True)


@dataclass(frozen=True)
class JointPin:
    """Pin of a joint.

    Parameters
    ----------
    joint : str
    diameter : float
        In m.
    eyes : tuple of PinEye
        Of links that meet there; one without any sizes may be left out.
    bush_length : float, optional
        Of the bush in which the pin turns in m; the shortest hole around it if left out.
    allowable_bearing_pressure : float, optional
        Of pin and holes in Pa.
    allowable_pv : float, optional
        Of the bush: greatest product of bearing pressure and sliding velocity in Pa m/s.

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
    diameter: float
    eyes: tuple[PinEye, ...] = ()
    bush_length: float | None = None
    allowable_bearing_pressure: float | None = None
    allowable_pv: float | None = None

    def __post_init__(self) -> None:
        what = f"pin of joint {self.joint}"
        check_number(self.diameter, f"{what}: diameter", "m", POSITIVE)
        units = {"bush_length": "m", "allowable_bearing_pressure": "Pa", "allowable_pv": "Pa m/s"}
        check_fields(self, units, POSITIVE, f"of the {what}", optional=True)
        remedy = "give PinEye(link, thickness, width, edge_distance) in a tuple"
        eyes = checked_tuple(self.eyes, PinEye, f"{what}: eyes", remedy)
        links = [eye.link for eye in eyes]
        # What can be said in several ways is kept in one, so that equal pins compare so.
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
        dimensions = {
            "bush_length": LENGTH,
            "allowable_bearing_pressure": STRESS,
            "allowable_pv": PRESSURE_VELOCITY,
        }
        table: TomlTable = {"diameter": quantity(self.diameter, LENGTH)}
        for name in EYE_SIZES:
            stated = {
                eye.link: quantity(size, LENGTH)
                for eye in self.eyes
                if (size := getattr(eye, name)) is not None
            }
            if stated:
                table[f"eye_{name}"] = stated
        return table | fields_table(self, dimensions)
