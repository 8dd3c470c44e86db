"""The pin in a joint and the eyes of the links around it: sizes, and what they are allowed."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.errors import InputError
from flexmech.model_text import TomlTable, fields_table, quantity
from flexmech.units import LENGTH, PRESSURE_VELOCITY, STRESS
from flexmech.validation import POSITIVE, check_fields, check_number, checked_tuple

EYE_SIZES = ("thickness", "width", "edge_distance")
"""Fields of an eye that may be stated; in a model file they begin with ``eye_``."""


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

    def described(self) -> str:
        """Joint and diameter, as a list of pins tells them."""
        return f"{self.joint} {1e3 * self.diameter:.6g} mm"
