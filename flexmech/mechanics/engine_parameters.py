"""Parameters of the engines, values that are refused, and the beam theory that they choose.

The rotation of a free shaft is one more coordinate of the linkage. The frames of the links go on
turning with the prescribed, mean motion. Against it the shaft turns by a small angle, which is the
rotation of the clamped end: on a hub that end moves with it. The shaft's inertia stands in the mass
matrix by that coordinate. Its weight is on its axis.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import (
    MODES,
    MOST_ELEMENTS,
    MOST_MODES,
    SHAFTS,
    MassChoice,
    ShaftChoice,
)
from flexmech.errors import InputError
from flexmech.linkages import Clamp, Topology, picture_crank_angle
from flexmech.mechanics.links.component_modes import (
    ComponentModes,
)
from flexmech.mechanics.links.link_model import LinkModel, with_entries
from flexmech.mechanism import Mechanism
from flexmech.validation import (
    check_choice,
    check_count,
    check_flag,
)

# Part of the shaft's speed by which that of the clamped link may be off: what the kinematics of any
# linkage leave, 1e-12 or less; a link that is geared is off by more than this.
TURNS_ALIKE = 1e-9


@dataclass(frozen=True)
class FreeShaft:
    """The shaft of a mechanism, whose rotation is a coordinate.

    Parameters
    ----------
    topology : Topology
        Topology of the linkage, with the one clamp that it drives.
    inertia : float
        About the axis, in kg m^2.
    """

    topology: Topology
    inertia: float

    @classmethod
    def of(cls, mechanism: Mechanism) -> Self:
        """The shaft of a mechanism.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        FreeShaft

        Raises
        ------
        InputError
            If nothing or more than one link is clamped, or the clamped link does not turn with
            the shaft or is rigid and ends at it.
        """
        topology = mechanism.linkage.topology
        if len(topology.clamps) != 1:
            raise InputError(
                f"shaft 'free' needs one clamp, which the shaft drives; this linkage has "
                f"{len(topology.clamps)}: use shaft 'prescribed'"
            )
        clamp = topology.clamps[0]
        link = topology.index(clamp.link_end.link)
        motion = mechanism.linkage.motion(picture_crank_angle(mechanism.linkage), 1.0)
        if abs(float(motion.angular_velocity[link]) - 1.0) > TURNS_ALIKE:
            raise InputError(
                f"shaft 'free' needs a link that turns with the shaft, and the "
                f"{clamp.link_end.link} does not: use shaft 'prescribed'"
            )
        if topology.links[link].rigid and clamp.link_end.end == "end":
            raise InputError(
                f"shaft 'free' needs a rigid link that starts at the shaft, and the "
                f"{clamp.link_end.link} ends there: give its points in the other order"
            )
        return cls(topology.with_free_shaft(), mechanism.shaft_inertia)

    @property
    def clamp(self) -> Clamp:
        """The connection that it drives."""
        return self.topology.clamps[0]

    @cached_property
    def link(self) -> int:
        """Number of the clamped link."""
        return self.topology.index(self.clamp.link_end.link)

    @property
    def is_stiff(self) -> bool:
        """Whether there are rigid links or a hub: a turn of these meets no tension of their own."""
        return bool(self.clamp.hub) or any(link.rigid for link in self.topology.links)

    def rotation(self, link: LinkModel) -> int:
        """Number of the clamped link's coordinate, reduced or not, that is the shaft's rotation."""
        return int(link.end_rotation_of(self.clamp.link_end.end)[0])

    def links(self, links: tuple[LinkModel, ...]) -> tuple[LinkModel, ...]:
        """Unreduced links, of which the clamped one has the shaft's inertia.

        That link turns with the shaft as a rigid body, and so has the rotary inertia of its
        sections whatever its elements. It is on the mean rotation weighted by mass, to which
        all its vibration is orthogonal.
        """
        turn, clamped_link = np.array([self.rotation(links[self.link])]), links[self.link]
        mass = with_entries(clamped_link.mass, turn, turn, np.array([self.inertia]))
        if clamped_link.uncounted_rotary_inertia:
            length = clamped_link.readings.nodes[-1]
            start = self.clamp.hub - (length if self.clamp.link_end.end == "end" else 0.0)
            rigid = clamped_link.fields.tangential + start * clamped_link.fields.across
            rotary = float(clamped_link.uncounted_rotary_inertia) * length
            mean = (momentum := mass @ rigid) / (rigid @ momentum)
            mass = mass + rotary * np.outer(mean, mean)
        clamped = replace(clamped_link, mass=mass, uncounted_rotary_inertia=0.0)
        return tuple(clamped if link is clamped_link else link for link in links)


class EngineParameters(ABC):
    """Parameters of an engine: a mechanism, its mesh and its elements.

    It is a value: it does not change, and two that compute the same are equal.
    Parameters as for :class:`flexmech.mechanics.Engine`.
    """

    name: ClassVar[str]
    simulates: ClassVar[bool] = False
    solves_connectors: ClassVar[bool] = False
    masses: ClassVar[tuple[MassChoice, ...]] = ("distributed",)
    element_kinds: ClassVar[tuple[str, ...]]
    counterparts: ClassVar[dict[str, str]]
    """This engine's element for each one of another engine, of the same beam theory or the
    nearest."""
    theories: ClassVar[dict[str, str]]
    """Beam theory of each element."""
    finer_elements: ClassVar[dict[str, str]]
    """Element of the next finer theory, for each element that has one."""
    untensioned_elements: ClassVar[tuple[str, ...]] = ()
    """Elements whose straight shape carries no tension, as prestress ``axial`` needs it."""
    restrains_ends: ClassVar[bool] = False
    """Whether links of off-axis plies bend and twist between joints as in three dimensions."""

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int = 8,
        element: str | None = None,
        component_modes: bool = True,
        modes: int = MODES,
        shaft: ShaftChoice = "prescribed",
        mass: MassChoice = "distributed",
    ) -> None:
        self.mechanism = checked_mechanism(mechanism)
        self.elements = checked_elements(elements)
        check_count(modes, "modes", most=MOST_MODES)
        self.modes = modes
        if element is not None:
            check_choice(element, self.element_kinds, f"element of the {self.name} engine")
        check_flag(component_modes, "component_modes")
        self.element = self.default_element(mechanism, modes) if element is None else element
        check_choice(mass, self.masses, f"mass of the {self.name} engine")
        self.mass = mass
        self.component_modes = component_modes and mass == "distributed"
        self._component_modes_asked = component_modes
        check_choice(shaft, SHAFTS, "shaft")
        self.shaft = shaft
        self.free_shaft = FreeShaft.of(mechanism) if shaft == "free" else None
        self._element_asked = element
        self._reductions: dict[Hashable, ComponentModes] = {}

    def with_(
        self,
        *,
        mechanism: Mechanism | None = None,
        elements: int | None = None,
        element: str | None = None,
        component_modes: bool | None = None,
        modes: int | None = None,
        shaft: ShaftChoice | None = None,
        mass: MassChoice | None = None,
    ) -> Self:
        """Make a copy of the engine with some parameters changed.

        Parameters
        ----------
        mechanism : Mechanism, optional
            An element that was not asked for is chosen anew for it.
        elements : int, optional
        element : str, optional
        component_modes : bool, optional
        modes : int, optional
            An element that was not asked for is chosen anew for them.
        shaft : {"prescribed", "free"}, optional
        mass : {"distributed", "lumped"}, optional

        Returns
        -------
        Engine

        Raises
        ------
        InputError
            As of a new engine.
        """
        return type(self)(
            self.mechanism if mechanism is None else mechanism,
            self.elements if elements is None else elements,
            self._element_asked if element is None else element,
            self._component_modes_asked if component_modes is None else component_modes,
            self.modes if modes is None else modes,
            self.shaft if shaft is None else shaft,
            self.mass if mass is None else mass,
        )

    def unreduced(self) -> Self:
        """Make a copy without component modes that shares the link models."""
        other = copy(self)
        vars(other).update(component_modes=False, _component_modes_asked=False, _reductions={})
        return other

    def __repr__(self) -> str:
        modes = "" if self.component_modes else ", without component modes"
        if self.shaft == "free":
            modes += ", shaft free"
        if self.mass == "lumped":
            modes = modes.replace("without component modes", "lumped masses")
        name, plural = self.mechanism.provenance.name, "s" if self.elements > 1 else ""
        beams = f"{self.elements} {self.element} element{plural} a link"
        return f"{type(self).__name__}({name}, {beams}{modes})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EngineParameters) or type(self) is not type(other):
            return NotImplemented
        return self._computes == other._computes and self.mechanism == other.mechanism

    def __hash__(self) -> int:
        # A mechanism has none, because its sections are in a dictionary.
        return hash((type(self), self._computes, self.mechanism.provenance))

    def __setattr__(self, name: str, value: object) -> None:
        # What has been computed from an attribute would not follow it.
        if name in vars(self):
            raise AttributeError(f"an engine does not change; make another by with_({name}=...)")
        super().__setattr__(name, value)

    @property
    def _computes(self) -> tuple[int, str, bool, str, str]:
        """Parameters that determine the results, besides the mechanism."""
        return self.elements, self.element, self.component_modes, self.shaft, self.mass

    def fit_for(self, modes: int) -> Self:
        """The engine with an element fit for so many natural frequencies, if none was asked for."""
        # What shear does not change in more modes it does not in fewer.
        simplest = modes < self.modes and self.element == self.element_like("euler")
        if modes == self.modes or simplest or not self.chooses_element:
            return self
        other = self.with_(modes=modes)
        return self if other.element == self.element else other

    @property
    def chooses_element(self) -> bool:
        """Whether no element was asked for, so that the mechanism decides."""
        return self._element_asked is None

    @property
    def theory(self) -> str:
        """Beam theory of the element, by its name in the reference engine."""
        return self.theories[self.element]

    @classmethod
    @abstractmethod
    def compare_theories(cls, mechanism: Mechanism, modes: int) -> TheoryComparison:
        """Compare beam theories on a mechanism at rest.

        Parameters
        ----------
        mechanism : Mechanism
        modes : int
            How many of the lowest natural frequencies count.

        Returns
        -------
        TheoryComparison
        """

    @classmethod
    def default_element(cls, mechanism: Mechanism, modes: int = MODES) -> str:
        """Kind of element if none is asked for: the simplest whose beam theory is fit.

        One that shears, where that changes one of the lowest natural frequencies by more than
        a hundredth or a link's neutral axis or centre of mass is off the pins' axis; one whose
        cross-sections warp where that does, if the engine has it. Where all links are rigid, the
        simplest of all.

        Parameters
        ----------
        mechanism : Mechanism
        modes : int
            How many of the lowest natural frequencies count.

        Returns
        -------
        str
        """
        if all(link.rigid for link in mechanism.linkage.topology.links):
            return cls.element_like("euler")
        return cls.element_like(cls.compare_theories(mechanism, modes).suitable)

    @classmethod
    def element_like(cls, element: str) -> str:
        """Kind of element of the beam theory of an element, its own or another engine's.

        Parameters
        ----------
        element : str

        Returns
        -------
        str

        Raises
        ------
        KeyError
            If no engine has the element.
        """
        return element if element in cls.element_kinds else cls.counterparts[element]

    def check_runs(self) -> None:
        """Refuse models that are for natural frequencies alone.

        Raises
        ------
        InputError
            If masses are lumped: between them nothing would move in time; or if all links are
            rigid.
        """
        check_elastic(self.mechanism)
        if self.mass == "lumped":
            raise InputError(
                "lumped masses are for natural frequencies; for motion in time make the engine "
                'with mass="distributed"'
            )

    def require_prescribed_shaft(self, what: str = "this computation") -> None:
        """Refuse a free shaft where the crank's motion is prescribed.

        Parameters
        ----------
        what : str
            Computation in which it is.

        Raises
        ------
        InputError
            If the shaft is free.
        """
        if self.free_shaft is not None:
            raise InputError(
                f"{what} turns the shaft as prescribed, and that of this engine is free; "
                "use shaft 'prescribed'"
            )


def checked_mechanism(mechanism: object) -> Mechanism:
    """Return a mechanism; refuse what is none: a path, a linkage, another engine."""
    if isinstance(mechanism, Mechanism):
        return mechanism
    given = f"an object of type {type(mechanism).__name__}"
    remedy = "read one by flexmech.load_mechanism(path)"
    if hasattr(mechanism, "__fspath__") or isinstance(mechanism, str):
        given = f"the path {str(mechanism)!r}"
        remedy = f"read the file first: flexmech.load_mechanism({str(mechanism)!r})"
    elif hasattr(mechanism, "mechanism"):
        remedy = "give its attribute mechanism"
    elif hasattr(mechanism, "topology"):
        remedy = "a linkage needs a section for each link: flexmech.Mechanism(linkage, sections)"
    raise InputError(f"mechanism must be a flexmech.Mechanism, got {given}; {remedy}")


def check_elastic(mechanism: Mechanism) -> None:
    """Refuse a mechanism whose links are all rigid: what engines compute is of elastic links."""
    if not all(link.rigid for link in mechanism.linkage.topology.links):
        return
    # Rigid links vibrate too where springs hold them; engines compute it beside one stiff link.
    stiff = ""
    if mechanism.springs or mechanism.joint_springs or mechanism.shaft_inertia:
        stiff = "as stiff as you like where springs, bearings or the shaft alone shall yield, "
    raise InputError(
        "links: every link is rigid, and this command computes the vibration of elastic "
        f"links; leave out rigid = true for one of them and give it a section, {stiff}or ask for "
        "the rigid motion and its forces by 'flexmech kinematics'"
    )


def checked_elements(count: object) -> int:
    """Return a number of elements a link; refuse fractions, truth values, text and too many."""
    if (
        isinstance(count, int | np.integer)
        and not isinstance(count, bool)
        and 1 <= count <= MOST_ELEMENTS
    ):
        return int(count)
    raise InputError(
        f"elements must be a whole number from 1 to {MOST_ELEMENTS} (the matrices of more do not "
        f"fit into memory), such as 8; got {count!r}"
    )


NEGLIGIBLE = 0.01
"""Relative difference of a frequency up to which the simpler theory is taken: less than what the
elastic moduli of most materials are known to."""
SURELY = 0.5
"""Part of it up to which what shear changes is known well enough to the first order."""
COMPRESSED = 0.5
"""Part of the frequency at which soft layers are compressed above which no beam theory is right.

Among 250 random sandwich arms and four-bars with cores of 5e-6 to 0.1 of the faces' modulus, zigzag
beams were within 1 % of two-dimensional elasticity in all modes below it, and up to 360 % too high
above."""

RESTRAINED_ENDS = "held ends"
"""In the place of a theory: Timoshenko's, and links of off-axis plies between joints as in three
dimensions."""


@dataclass(frozen=True)
class TheoryDifference:
    """Greatest relative difference of two theories' frequencies.

    Parameters
    ----------
    value : float
        ``|f / f_finer - 1|``.
    mode : int
        Where it is, counted from 1.
    """

    value: float
    mode: int


@dataclass(frozen=True)
class TheoryComparison:
    """Natural frequencies of a linkage at rest by several beam theories on one mesh.

    Parameters
    ----------
    frequency : callable
        Frequency of a theory's name, or :data:`RESTRAINED_ENDS`: its frequencies in Hz at
        some crank angles, (A, modes).
    eccentric : bool
        Whether a neutral axis is off the pins' axis, which asks for a beam that shears.
    compression : callable
        Lowest frequency in Hz at which the layers of a link are compressed; infinite without
        layers.
    softening : callable
        Relative change of a frequency of Euler-Bernoulli beams by shear and rotary inertia, to
        first order; infinite where it is not known.
    """

    frequency: Callable[[str], FloatArray]
    eccentric: bool
    compression: Callable[[], float]
    softening: Callable[[], float]

    def difference(self, theory: str, finer: str) -> TheoryDifference:
        """Greatest relative difference of a theory from a finer one over angles and modes."""
        by_mode = np.abs(self.frequency(theory) / self.frequency(finer) - 1).max(axis=0)
        mode = int(by_mode.argmax())
        return TheoryDifference(float(by_mode[mode]), mode + 1)

    @property
    def compressed_from(self) -> int:
        """First mode, from 1, near the compression of soft layers; 0 where there is none."""
        highest = self.frequency("zigzag").max(axis=0)
        near = np.flatnonzero(highest > COMPRESSED * self.compression())
        return 1 + int(near[0]) if near.size else 0

    @property
    def suitable(self) -> str:
        """The simplest theory whose frequencies a finer one changes negligibly."""
        # To first order, where that is far enough from the limit, in half the time.
        slender = self.softening() <= SURELY * NEGLIGIBLE
        slender = slender or self.difference("euler", "timoshenko").value <= NEGLIGIBLE
        # Zigzag beams are between the two: what shear does not change, warping cannot.
        if slender:
            return "timoshenko" if self.eccentric else "euler"
        warps = self.difference("timoshenko", "zigzag").value > NEGLIGIBLE
        return "zigzag" if warps else "timoshenko"
