"""What a mechanism has besides its linkage and its sections: masses, water, where it is from."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexmech.errors import InputError, is_plain
from flexmech.materials.moisture import Faces
from flexmech.model_text import TomlTable, fields_table, short_repr
from flexmech.units import LENGTH, MASS
from flexmech.validation import NOT_NEGATIVE, check_number, check_pair


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
        check_number(self.position, f"{what}: position", "m", NOT_NEGATIVE)
        check_number(self.mass, f"{what}: mass", "kg", NOT_NEGATIVE)
        check_number(self.inertia, f"{what}: inertia", "kg m^2", NOT_NEGATIVE)
        check_pair(self.offset, f"{what}: offset", "m")
        along, across = self.offset
        object.__setattr__(self, "offset", (along, across))


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
