"""An Exudyn system with a list of its items, and the one import of exudyn.

It is imported quiet, without range checks, and with its log kept in.

Every item is described once, by its type, its name and its values: the system gets it, and the
list keeps it, from which a script can be written that makes the same system.
"""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from itertools import count
from types import ModuleType
from typing import Any, Literal, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Integrator
from flexmech.errors import InputError

ROUND_OFF = 8 * float(np.finfo(float).eps)
"""Round-off of a sum of cancelling forces between nodes, relative to these forces.

Four forces meet at a node, each of a product and a sum.
"""

ItemKind = Literal["node", "object", "marker", "load", "sensor"]
_KINDS: tuple[ItemKind, ...] = ("node", "marker", "load", "sensor")


def check_exudyn() -> None:
    """Refuse the engine where exudyn is not installed; it is not imported for that.

    Raises
    ------
    InputError
        With what to do.
    """
    if "exudyn" in sys.modules:
        installed = sys.modules["exudyn"] is not None
    else:
        installed = find_spec("exudyn") is not None
    if not installed:
        raise InputError(
            "the exudyn engine needs exudyn, which is not installed: pip install exudyn, or choose "
            "the reference engine (--engine reference, flexmech.ReferenceEngine)"
        )


def load_exudyn() -> ModuleType:
    """Exudyn's module.

    The core without range checks is about a third faster; it must be asked for before the
    first import, which announces the choice on the standard output: a library stays quiet.

    Raises
    ------
    InputError
        If it is not installed.
    """
    check_exudyn()
    if "exudyn" not in sys.modules:
        sys.exudynFast = True  # type: ignore[attr-defined]  # exudyn's own switch
    with contextlib.redirect_stdout(io.StringIO()):
        import exudyn
        import exudyn.itemInterface

    return exudyn


class ItemNumber(int):
    """Exudyn's number of an item, with the item's kind and name.

    Parameters
    ----------
    number : int
    kind : {"node", "object", "marker", "load", "sensor"}
    name : str
    """

    kind: ItemKind
    name: str

    def __new__(cls, number: int, kind: ItemKind, name: str) -> Self:
        """Make the number."""
        made = super().__new__(cls, number)
        made.kind, made.name = kind, name
        return made


@dataclass(frozen=True)
class Choice:
    """A value of an enumeration of Exudyn, such as ``OutputVariableType.Position``.

    Parameters
    ----------
    enumeration, name : str
    """

    enumeration: str
    name: str

    def chosen(self) -> Any:
        """The enumeration's value in Exudyn."""
        return getattr(getattr(load_exudyn(), self.enumeration), self.name)


@dataclass(frozen=True)
class Made:
    """Result of a function of plain numbers, which a script calls as well.

    Parameters
    ----------
    function : callable
        One of :data:`flexmech.multibody.running.script.SHARED`.
    arguments : tuple
        Numbers, text, lists of them, or records that a script holds.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]


@dataclass(frozen=True)
class Item:
    """One item of an Exudyn system.

    Parameters
    ----------
    kind : {"node", "object", "marker", "load", "sensor"}
    type : str
        Name of its class in ``exudyn.itemInterface``.
    name : str
    number : int
        Among the items of its kind.
    values : mapping
        What the class is given, besides the name.
    subject : str
        What it belongs to, such as ``"coupler: nodes"``.
    """

    kind: ItemKind
    type: str
    name: str
    number: int
    values: Mapping[str, Any]
    subject: str


@dataclass(frozen=True)
class SystemBody:
    """A rigid body at a node with an angle: at a node of exact beams, attached, or a rigid link.

    Parameters
    ----------
    number, node : ItemNumber
        Numbers of the body and its node.
    first : int
        First coordinate of its node among Exudyn's of links and attached bodies.
    mass : float
        In kg.
    centre : tuple of float
        Its centre of mass from the node, along and across the link, in m.
    inertia : float
        About the node in kg m^2.
    """

    number: ItemNumber
    node: ItemNumber
    first: int
    mass: float
    centre: tuple[float, float]
    inertia: float


class SystemItems:
    """An Exudyn system that grows item by item.

    Attributes
    ----------
    container : exudyn.SystemContainer
    mbs : exudyn.MainSystem
    listed : list of Item
        In the order in which they were added.
    bodies : list of SystemBody
        All rigid bodies of links and on them.
    masses : list of tuple of int and ndarray
        Mass matrices between nodes of links, each with its first coordinate.
    """

    def __init__(self) -> None:
        self.container: Any = load_exudyn().SystemContainer()
        self.mbs: Any = self.container.AddSystem()
        self.listed: list[Item] = []
        self.bodies: list[SystemBody] = []
        self.masses: list[tuple[int, FloatArray]] = []
        self._subject = ""
        # Looked up at each of thousands of items.
        self._taken: set[tuple[ItemKind, str]] = set()

    def begin(self, subject: str) -> None:
        """Set the subject of the next items."""
        self._subject = subject

    def add(self, type_: str, name: str, **values: Any) -> ItemNumber:
        """Add an item; all further arguments are what its class is given.

        Parameters
        ----------
        type_ : str
            Name of its class in ``exudyn.itemInterface``.
        name : str
            Where an item of the same kind has it, as the shaft's hub beside a link named "hub",
            a number is added: Exudyn takes each name once.

        Returns
        -------
        ItemNumber
        """
        kind = _kind_of(type_)
        if (kind, name) in self._taken:
            further = (f"{name}_{number}" for number in count(2))
            name = next(new for new in further if (kind, new) not in self._taken)
        self._taken.add((kind, name))
        make = getattr(load_exudyn().itemInterface, type_)
        add = getattr(self.mbs, f"Add{kind.capitalize()}")
        given = {key: _plain(value) for key, value in values.items()}
        number = int(add(make(name=name, **given)))
        self.listed.append(Item(kind, type_, name, number, values, self._subject))
        return ItemNumber(number, kind, name)

    def add_body(
        self,
        name: str,
        node: ItemNumber,
        first: int,
        mass: float,
        centre: tuple[float, float],
        inertia: float,
    ) -> SystemBody:
        """Add a rigid body.

        Parameters
        ----------
        name : str
        node : ItemNumber
        first, mass, centre, inertia
            As of :class:`SystemBody`.

        Returns
        -------
        SystemBody
        """
        given = {"mass": mass, "inertia": inertia, "centerOfMass": list(centre)}
        number = self.add("ObjectRigidBody2D", name, nodeNumber=node, **given)
        self.bodies.append(SystemBody(number, node, first, mass, centre, inertia))
        return self.bodies[-1]

    def add_mass(self, name: str, nodes: list[ItemNumber], first: int, matrix: Made) -> None:
        """Add a mass matrix by the velocities of nodes.

        Parameters
        ----------
        name : str
        nodes : list of ItemNumber
            Whose coordinates follow on each other.
        first : int
            First one of their coordinates.
        matrix : Made
        """
        self.add("ObjectGenericODE2", name, nodeNumbers=nodes, massMatrix=matrix)
        self.masses.append((first, _plain(matrix)))

    def keep_angle(self, name: str, markers: list[ItemNumber]) -> ItemNumber:
        """Keep two markers from turning against each other.

        Parameters
        ----------
        name : str
        markers : list of ItemNumber
        """
        axes = [0, 0, 0, 0, 0, 1]
        return self.add("GenericJoint", name, markerNumbers=markers, constrainedAxes=axes)

    def mark_place(self, name: str, body: ItemNumber, x: float = 0.0, y: float = 0.0) -> ItemNumber:
        """Add a marker at a place of a body, which turns with it.

        Parameters
        ----------
        name : str
        body : ItemNumber
        x, y : float
            In m.
        """
        return self.add("MarkerBodyRigid", name, bodyNumber=body, localPosition=[x, y, 0.0])

    def mark_coordinate(self, name: str, node: ItemNumber, coordinate: int) -> ItemNumber:
        """Add a marker of one of a node's coordinates.

        Parameters
        ----------
        name : str
        node : ItemNumber
        coordinate : int
            Which of them.
        """
        return self.add("MarkerNodeCoordinate", name, nodeNumber=node, coordinate=coordinate)

    def add_force(
        self, name: str, marker: ItemNumber, x: float = 0.0, y: float = 0.0, **given: Any
    ) -> ItemNumber:
        """Add a force at a marker; further arguments are what the load's class is given.

        Parameters
        ----------
        name : str
        marker : ItemNumber
        x, y : float
            In N.
        """
        vector = [float(x), float(y), 0.0]
        return self.add("LoadForceVector", name, markerNumber=marker, loadVector=vector, **given)


def _kind_of(type_: str) -> ItemKind:
    """Kind of an item by the name of its class; joints and constraints are objects."""
    return next((kind for kind in _KINDS if type_.lower().startswith(kind)), "object")


def _plain(value: Any) -> Any:
    """A value as Exudyn takes it."""
    if isinstance(value, Made):
        return value.function(*value.arguments)
    if isinstance(value, Choice):
        return value.chosen()
    if isinstance(value, ItemNumber):
        return int(value)
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    return value.copy() if isinstance(value, np.ndarray) else value


# Generalized-alpha's damping of vibration infinitely faster than the step: 1 none, 0 at once. A
# tenth of that goes with each step, of ten radians a step 2 % and of half a radian nothing: axial
# modes die away while bending modes keep their energy.
SPECTRAL_RADIUS = 0.9

# Out-of-balance force at which Newton's method stops, relative to that at the step's start.
# Ten times more moves joint forces by 2e-6 of their peak, the energy error in its fifth digit.
STEP_RESIDUAL = 1e-8
# The tangent is kept from step to step until an iteration gains less than this factor. Speed alone.
CONTRACTIVITY = 0.25


Setting = bool | int | float | Choice


def solver_settings(
    step: float, steps: int, integrator: Integrator, force_scale: float
) -> dict[str, Setting]:
    """Settings of a run.

    Parameters
    ----------
    step : float
        In s.
    steps : int
    integrator : {"trapezoidal", "generalized-alpha"}
    force_scale : float
        Force between neighbouring nodes in N, to whose round-off Newton's method goes.

    Returns
    -------
    dict of str to Setting
        By paths such as ``"timeIntegration.numberOfSteps"``.
    """
    settings: dict[str, Setting] = {
        "solution.file.write": False,
        "solution.sensors.active": False,
        "linearSolver.solverType": Choice("LinearSolverType", "EigenSparse"),
        "timeIntegration.adaptiveStep": False,
        "timeIntegration.automaticStepSize": False,
        "timeIntegration.verboseMode": 0,
        "timeIntegration.numberOfSteps": steps,
        "timeIntegration.endTime": steps * step,
        "timeIntegration.newton.useModifiedNewton": True,
        "timeIntegration.newton.modifiedNewtonContractivity": CONTRACTIVITY,
        "timeIntegration.newton.relativeTolerance": STEP_RESIDUAL,
        "timeIntegration.newton.absoluteTolerance": float(ROUND_OFF * force_scale),
        # A first iteration may meet forces a million times those of the step.
        "timeIntegration.newton.adaptInitialResidual": False,
    }
    if integrator == "trapezoidal":
        settings["timeIntegration.generalizedAlpha.useNewmark"] = True
        settings["timeIntegration.generalizedAlpha.useIndex2Constraints"] = True
    else:
        settings["timeIntegration.generalizedAlpha.spectralRadius"] = SPECTRAL_RADIUS
    return settings


def applied(settings: dict[str, Setting]) -> Any:
    """Exudyn's object with these settings.

    Parameters
    ----------
    settings : dict of str to Setting

    Returns
    -------
    exudyn.SimulationSettings
    """
    made = load_exudyn().SimulationSettings()
    for path, value in settings.items():
        *parts, name = path.split(".")
        owner = made
        for attribute in parts:
            owner = getattr(owner, attribute)
        setattr(owner, name, value.chosen() if isinstance(value, Choice) else value)
    return made
