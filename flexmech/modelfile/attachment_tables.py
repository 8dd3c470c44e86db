"""Tables of a model file for joints, loads, springs and the shaft."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from flexmech import si
from flexmech.errors import InputError
from flexmech.linkages import JointSpring, Spring
from flexmech.mechanism.parts import EYE_SIZES, JointPin
from flexmech.modelfile import base_table as base


def _one_or_by_link(value: Any) -> str:
    return "by link" if isinstance(value, Mapping) else "one"


# Told apart before they are read: what is wrong of a link's is then reported of it.
OneOrByLink = Annotated[
    Annotated[si.Width, Tag("one")] | Annotated[dict[base.Text, si.Width], Tag("by link")],
    Discriminator(_one_or_by_link),
]
_OR_BY_LINK = "the same for all links that meet there, or by link as in { crank = '12 mm' }"


class JointTable(base.RecordTable, of=(JointSpring, JointPin), required=()):
    """A joint: O2, A, B and O4 of a four-bar; O2 of a rotating arm; a point of a drawing."""

    kind: Literal["pin", "clamp", "weld", "slider"] | None = base.optional(
        "Planar linkages: pin if left out; clamp is the drive, or several hold a still "
        "frame; weld keeps the angle between links; slider keeps the point on a line"
    )
    links: list[base.Text] = Field(
        default_factory=list,
        description="Links that a weld or clamp fixes, where it does not fix all that meet there",
    )
    direction: si.AngleOfTurn | None = base.optional(
        "Angle of a slider's line to the ground's x axis, or to that of the guide"
    )
    offset: si.Distance | None = base.optional(
        "Slider that is not drawn: distance of its line from the shaft's axis, or from the "
        "first point of its guide, to the left of its direction; 0 if left out"
    )
    guide: base.Text | None = base.optional(
        "Rigid link that carries a slider's line; the ground if left out"
    )
    mass: si.Mass = base.optional("Point mass at the joint; of a slider", 0.0, "0 kg")
    inertia: si.Inertia = base.optional(
        "Moment of inertia of a slider about its centre of mass: it rotates with its guide",
        0.0,
        "0 kg m^2",
    )
    eye_thickness: OneOrByLink | None = base.optional(
        "With diameter: length of the hole along the pin; that of the link's section if left out; "
        + _OR_BY_LINK
    )
    eye_width: OneOrByLink | None = base.optional(
        "With diameter: of the link at the hole, across the link in the plane of motion; the "
        "section's if left out; " + _OR_BY_LINK
    )
    eye_edge_distance: OneOrByLink | None = base.optional(
        "With diameter: from the centre of the hole to the link's end; " + _OR_BY_LINK
    )

    @model_validator(mode="after")
    def _states_something(self) -> JointTable:
        given = self.model_fields_set
        if not given:
            raise InputError("mass is missing; add it, or whatever the joint has, or leave it out")
        if "free_angle" in given and "torsional_stiffness" not in given:
            raise InputError("free_angle belongs to a torsional_stiffness; add it")
        if self.diameter is None and (alone := [key for key in PIN_KEYS if getattr(self, key)]):
            raise InputError(f"{alone[0]} belongs to the diameter of a pin; add it")
        if self.bush_length is not None and self.allowable_pv is None:
            raise InputError("bush_length belongs to an allowable_pv; add it")
        return self

    @property
    def has_spring(self) -> bool:
        """Whether a spring or a damper in it is stated."""
        return not self.model_fields_set.isdisjoint(si.quantities(JointSpring))

    def eye_sizes(self, link: str) -> dict[str, float]:
        """What is stated of the eye of a link, or of all links alike."""
        sizes: dict[str, float] = {}
        for name, key in EYE_KEYS.items():
            size = getattr(self, key)
            size_here = size.get(link) if isinstance(size, Mapping) else size
            sizes |= {} if size_here is None else {name: size_here}
        return sizes


EYE_KEYS = {name: f"eye_{name}" for name in EYE_SIZES}
"""Keys of a joint by the fields of an eye."""
PIN_KEYS = (*EYE_KEYS.values(), "bush_length", "allowable_bearing_pressure", "allowable_pv")
"""Keys of a joint that go with its diameter."""


class ShaftTable(base.Table):
    """The shaft that drives the crank."""

    inertia: si.Inertia = base.optional(
        "About its axis; it matters where the shaft is free", 0.0, "0 kg m^2"
    )


class PlaceTable(base.Table):
    """A place on a link."""

    link: base.Text = Field(description="Name of the link, or of a beam of it")
    position: si.LengthOrZero = Field(description="Distance from its first joint")


class LoadTable(base.Table):
    """A force and a torque on a point of a link."""

    point: base.Text | None = base.optional("A point of the linkage or a joint")
    link: base.Text | None = base.optional("With position; or with point, where several links meet")
    position: si.LengthOrZero | None = base.optional(
        "Distance from the link's first joint; with link, for point"
    )
    force: tuple[si.AnyForce, si.AnyForce] | None = base.optional("Along x and y of the axes")
    torque: si.Torque | None = base.optional("Positive to the left")
    axes: Literal["ground", "link"] = base.optional(
        "Whether the force turns with the link", "ground"
    )
    over: Literal["crank_angle", "time"] | None = base.optional(
        "Variable of the load's table or file; a constant load if left out"
    )
    table: list[list[str | float]] | None = base.optional(
        "Rows of crank angle or time, force along x and y and, if there is one, "
        "torque; linear between them"
    )
    file: base.Text | None = base.optional(
        "CSV file of such rows beside the model file, with the columns "
        "crank_angle_deg or time_s, force_x_N, force_y_N and torque_Nm"
    )

    @model_validator(mode="after")
    def _one_way_of_saying_it(self) -> LoadTable:
        if (self.point is None) == (self.position is None):
            raise InputError("give either point, or link and position, where the load acts")
        if self.position is not None and self.link is None:
            raise InputError("position is given without link; name the link")
        rows = [name for name in ("table", "file") if getattr(self, name) is not None]
        constant = self.force is not None or self.torque is not None
        if len(rows) + constant != 1:
            raise InputError("give either force and torque, or a table, or a file")
        if bool(rows) != (self.over is not None):
            raise InputError(
                'over belongs to a table or file; give over = "crank_angle" or "time" with one'
            )
        return self


def _kind_of_place(value: Any) -> str | None:
    if isinstance(value, str):
        return "name"
    if isinstance(value, Mapping | PlaceTable):
        return "place"
    return "ground" if isinstance(value, list | tuple) else None


SpringEnd = Annotated[
    Annotated[base.Text, Tag("name")]
    | Annotated[tuple[si.Distance, si.Distance], Tag("ground")]
    | Annotated[PlaceTable, Tag("place")],
    Discriminator(
        _kind_of_place,
        custom_error_type="no_place",
        custom_error_message=(
            "write the name of a point, coordinates of the ground as in ['10 mm', '0 mm'], or "
            "{{ link = 'coupler', position = '50 mm' }}"
        ),
    ),
]


class SpringTable(base.RecordTable, of=Spring):
    """A straight spring between two points, with a damper beside it."""

    points: tuple[SpringEnd, SpringEnd] = Field(
        description="Its ends: names of points or joints, coordinates of the ground, or "
        "{ link, position }"
    )
