"""What a universal file of a modal test holds: points, functions at points, and modes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError

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
        Of its x axis against the global one in rad.
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
        Of a function that was read: why it has no unit.
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
