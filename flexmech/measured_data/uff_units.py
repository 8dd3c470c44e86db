"""Quantities of a universal file of a modal test, and their units.

Points, functions at points, and modes; units by data set 164 and the codes of data set 58.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.measured_data.headers import read_header

UffFunctionKind = Literal[
    "general",
    "time response",
    "auto spectrum",
    "cross spectrum",
    "frequency response",
    "coherence",
]
UffQuantity = Literal[
    "none", "strain", "displacement", "velocity", "acceleration", "force", "other"
]


@dataclass(frozen=True)
class UffFrame:
    """A frame in the plane in which some nodes' directions count (data set 18).

    Parameters
    ----------
    label : int
        Above 0; 0 is the global frame.
    name : str
    origin : tuple of float
        x and y in m.
    angle : float
        Angle of its x axis against the global one in rad.
    """

    label: int
    name: str
    origin: tuple[float, float]
    angle: float


@dataclass(frozen=True, eq=False)
class UffNodes:
    """Points of a test (data set 15).

    Parameters
    ----------
    label : ndarray of int, shape (n,)
    position : ndarray, shape (n, 3)
        In m, in the global frame.
    frame : ndarray of int, shape (n,)
        Labels of the frames of their directions; 0 is the global one.
    """

    label: NDArray[np.intp]
    position: FloatArray
    frame: NDArray[np.intp]


@dataclass(frozen=True)
class UffDegreeOfFreedom:
    """A node and a direction.

    Parameters
    ----------
    node : int
        0 where none is known.
    direction : int
        1 to 3 along x, y and z of the node's frame, 4 to 6 about them, negative against them; 0
        for a scalar.
    entity : str
        What the node is part of; ten characters are written.
    """

    node: int
    direction: int
    entity: str = "NONE"


@dataclass(frozen=True, eq=False)
class UffFunction:
    """A function at a point (data set 58).

    Parameters
    ----------
    kind : str
        Such as ``"time response"`` or ``"frequency response"``.
    abscissa : {"time", "frequency", "other"}
    position : ndarray, shape (N,)
        Values of the abscissa in s or Hz.
    values : ndarray, shape (N,)
        Real or complex, in SI units; as they stand in the file if ``unit`` is None.
    quantity : str
        What the values are, or their numerator: displacement, velocity, acceleration, force,
        strain, none or other.
    over : str
        The denominator's quantity, ``"none"`` without one.
    response, reference : UffDegreeOfFreedom
        Where it was measured, and where it was hit.
    name : str
        First line of its text.
    remark : str
        Second line.
    unit : str, optional
        SI unit, empty for a ratio. None where the file tells none. What is written follows from
        the quantities.
    problem : str
        Problem of a function that was read: why it has no unit.
    """

    kind: UffFunctionKind
    abscissa: Literal["time", "frequency", "other"]
    position: FloatArray
    values: FloatArray | ComplexArray
    quantity: UffQuantity
    over: UffQuantity
    response: UffDegreeOfFreedom
    reference: UffDegreeOfFreedom
    name: str
    remark: str = ""
    unit: str | None = None
    problem: str = ""

    def __post_init__(self) -> None:
        if self.position.ndim != 1 or self.position.shape != self.values.shape:
            raise InputError(
                f"{self.name}: {self.values.shape} values over {self.position.shape} of the "
                f"{self.abscissa}; give one for each"
            )
        if self.position.size < 2:
            raise InputError(f"{self.name}: {self.position.size} values; a function has 2 or more")


@dataclass(frozen=True, eq=False)
class UffMode:
    """A complex mode (data set 55, complex eigenvalue).

    Parameters
    ----------
    number : int
        From 1.
    pole : complex
        In 1/s.
    nodes : ndarray of int, shape (n,)
    shape : ndarray of complex, shape (n, 3)
        Displacement along the global x, y and z.
    modal_a : complex
        Scale of the mode; 0 where none is known.
    name : str
    """

    number: int
    pole: complex
    nodes: NDArray[np.intp]
    shape: ComplexArray
    modal_a: complex = 0j
    name: str = "NONE"


@dataclass(frozen=True, eq=False)
class UffFile:
    """Contents of a universal file.

    Parameters
    ----------
    model : str
        Name of what was tested.
    description : str
    program : str
        That wrote it.
    nodes : UffNodes, optional
    frames : tuple of UffFrame
    functions : tuple of UffFunction
    modes : tuple of UffMode
    others : tuple of int
        Numbers of the data sets that were read over.
    """

    model: str = ""
    description: str = ""
    program: str = ""
    nodes: UffNodes | None = None
    frames: tuple[UffFrame, ...] = ()
    functions: tuple[UffFunction, ...] = ()
    modes: tuple[UffMode, ...] = ()
    others: tuple[int, ...] = ()


class _Quantity(NamedTuple):
    """Specific data type of data set 58, SI unit, alone and over a force, and exponents in that.

    Time is in seconds in every universal file; of a ratio that has no data type no unit is known.
    """

    code: int
    unit: str
    over_force: str | None = None
    length: int = 0
    force: int = 0


# What functions of universal files are of; a force is one of excitation.
QUANTITIES: dict[UffQuantity, _Quantity] = {
    "none": _Quantity(0, ""),
    "strain": _Quantity(3, "", "1/N"),
    "displacement": _Quantity(8, "m", "m/N", length=1),
    "velocity": _Quantity(11, "m/s", "m/(N s)", length=1),
    "acceleration": _Quantity(12, "m/s^2", "m/(N s^2)", length=1),
    "force": _Quantity(13, "N", force=1),
}
# The other kind of force in the format: what is measured of a support is as good.
REACTION_FORCE = 9


class UffUnits(NamedTuple):
    """Numbers of a file's own units in an SI unit (data set 164).

    Parameters
    ----------
    length : float
        In one metre.
    force : float
        In one newton.
    """

    length: float
    force: float


SI = UffUnits(1.0, 1.0)


def quantity_of(code: int) -> UffQuantity:
    """Quantity of a specific data type of data set 58.

    Parameters
    ----------
    code : int

    Returns
    -------
    str
        ``"other"`` for one that has no place here.

    Examples
    --------
    >>> quantity_of(12)
    'acceleration'
    """
    if code == REACTION_FORCE:
        return "force"
    return next((name for name, known in QUANTITIES.items() if known.code == code), "other")


def si_unit(quantity: UffQuantity, over: UffQuantity = "none") -> str:
    """SI unit of a quantity, or of one over another.

    Parameters
    ----------
    quantity, over : str

    Returns
    -------
    str
        Empty for a ratio.

    Raises
    ------
    InputError
        If no such ratio can be written.
    """
    unit = _unit(quantity, over)
    if unit is None:
        raise InputError(
            f"{quantity} over {over} has no data type in a universal file; give displacement, "
            "velocity, acceleration or strain, alone or over force"
        )
    return unit


def _unit(quantity: UffQuantity, over: UffQuantity) -> str | None:
    if quantity == over:
        return ""
    known = QUANTITIES.get(quantity)
    if known is None or over not in ("none", "force"):
        return None
    return known.unit if over == "none" else known.over_force


class FunctionUnit(NamedTuple):
    """Unit of a function that was read.

    Parameters
    ----------
    unit : str or None
        SI unit, empty for a ratio; None where none is known.
    factor : float
        SI value of one of the file's units.
    problem : str
        Why there is no unit, and the remedy; empty where there is one.
    """

    unit: str | None
    factor: float = 1.0
    problem: str = ""


_UNKNOWN = FunctionUnit(
    None, problem="has no unit; export it with data set 164, or with the units of its axes"
)
# Relative: units of data set 164 and of a label that differ by less are one unit, whose factor was
# rounded.
_SAME = 1e-3
# Codes of data set 58 of what a function is over, and their SI units.
_ABSCISSA_UNITS = {17: "s", 18: "Hz"}


def function_unit(dataset: Mapping[str, Any], units: UffUnits | None) -> FunctionUnit:
    """SI unit of a function that was read, and the SI value of one of the file's units.

    The codes of the data types and data set 164 tell it; without data set 164 the labels of the
    axes do, where they are units. A label that contradicts the codes or data set 164 leaves the
    function without a unit: no one knows which of the two is right.

    Parameters
    ----------
    dataset : mapping
        Data set 58 as pyuff gives it.
    units : UffUnits, optional
        None where the file has no data set 164.

    Returns
    -------
    FunctionUnit
    """
    over = _ABSCISSA_UNITS.get(int(dataset["abscissa_spec_data_type"]))
    axis = _label(dataset, "abscissa", "none")
    if over is not None and axis is not None and not _alike(axis, over, 1.0):
        return FunctionUnit(
            None,
            problem=f"has an axis in {axis.text}, and universal files count in {over}; export it "
            f"with an axis in {over}",
        )
    quantity = quantity_of(int(dataset["ordinate_spec_data_type"]))
    below = quantity_of(int(dataset["orddenom_spec_data_type"]))
    if int(dataset["func_type"]) == 6:  # a coherence has no unit, whatever its axes are called
        return FunctionUnit("")
    above, under = _label(dataset, "ordinate", quantity), _label(dataset, "orddenom", below)
    if below == "none" and under is not None and under.unit == QUANTITIES["force"].unit:
        below = "force"
    unit = None if "other" in (quantity, below) else _unit(quantity, below)
    if unit is None or quantity == "none":
        return _by_labels(dataset)
    terms: list[tuple[_Label | None, str, float, int]]
    if above is not None and above.unit == unit != QUANTITIES[quantity].unit:
        # The label of the numerator holds the whole ratio.
        terms = [(above, unit, _size(quantity, units) / _size(below, units), 1)]
    else:
        terms = [
            (above, QUANTITIES[quantity].unit, _size(quantity, units), 1),
            (under, QUANTITIES[below].unit, _size(below, units), -1),
        ]
    factor = 1.0
    for label, expected, size, power in terms:
        # For a ratio, such as a strain, data set 164 has no unit.
        is_scaled = units is not None and expected != ""
        if label is not None and label.unit != expected:
            problem = f"by its data type it is in {expected or 'no unit'}; correct one of the two"
            return FunctionUnit(None, problem=f"is labelled in {label.text}, and {problem}")
        if is_scaled and label is not None and not _alike(label, expected, size):
            return FunctionUnit(None, problem=_contradiction(label, expected, size))
        if is_scaled:
            factor *= size**power
        elif label is not None:
            factor *= label.factor**power
        elif expected:
            return _UNKNOWN
    return FunctionUnit(unit, factor)


def _contradiction(label: _Label, unit: str, size: float) -> str:
    """Message where a label and data set 164 are of different units."""
    ratio = label.factor / size
    said = unit if size == 1 else f"{size:.6g} {unit}"
    return (
        f"is labelled in {label.text}, and data set 164 says {said}, a factor of "
        f"{max(ratio, 1 / ratio):.6g}; correct one of the two, or export it without data set 164 "
        "if the label is right"
    )


def _by_labels(dataset: Mapping[str, Any]) -> FunctionUnit:
    """Unit of a function whose data types tell none, by the labels of its axes."""
    texts = [_text(dataset, axis) for axis in ("ordinate", "orddenom")]
    if texts[0] is None:
        return _UNKNOWN
    text = texts[0] if texts[1] is None else f"({texts[0]})/({texts[1]})"
    axis = str(dataset.get("ordinate_axis_lab", "")).strip()
    try:
        header = read_header(f"{dataset['id1'] or 'function'} {axis} [{text}]")
    except InputError:
        return _UNKNOWN
    return FunctionUnit(header.unit, header.factor)


def _size(quantity: UffQuantity, units: UffUnits | None) -> float:
    """SI value of one of the file's units of a quantity, by data set 164."""
    of, by = QUANTITIES[quantity], units or SI
    return float(by.length**-of.length * by.force**-of.force)


class _Label(NamedTuple):
    """Unit in a label of an axis: as it is written, in SI, and the SI value of one of it."""

    text: str
    unit: str
    factor: float


def _label(dataset: Mapping[str, Any], axis: str, quantity: UffQuantity) -> _Label | None:
    """The label of an axis, where it is a unit."""
    text = _text(dataset, axis)
    if text is None:
        return None
    if quantity in ("force", "none"):
        text = _POUND.sub("lbf", text)
    try:
        # The name before a "g" decides whether it is gram or gravity.
        header = read_header(f"{quantity} [{text}]")
    except InputError:
        return None
    return None if header.unit is None else _Label(text, header.unit, header.factor)


# Labels that name no unit; "engineering units" are those of whatever was calibrated.
_NO_UNIT = frozenset({"", "NONE", "EU"})
# As American laboratories write a pound of force.
_POUND = re.compile(r"(?<![\w.])lbs?(?!\w)")


def _text(dataset: Mapping[str, Any], axis: str) -> str | None:
    text = str(dataset.get(f"{axis}_axis_units_lab", "")).strip()
    return text if text.upper() not in _NO_UNIT else None


def _alike(label: _Label, unit: str, size: float) -> bool:
    return label.unit == unit and abs(label.factor / size - 1) <= _SAME
