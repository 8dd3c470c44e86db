"""Element kinds of an engine, their beam theories, and the choice for a mechanism."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.mechanism import Mechanism


class ElementKinds(ABC):
    """Element kinds of an engine and the beam theory of each.

    Attributes
    ----------
    element : str
        The one that is used.
    """

    element_kinds: ClassVar[tuple[str, ...]]
    counterparts: ClassVar[dict[str, str]]
    """Of each element of another engine, this one's of the same beam theory or the nearest."""
    theories: ClassVar[dict[str, str]]
    """Beam theory of each element."""
    finer_elements: ClassVar[dict[str, str]]
    """Of each element that has one, that of the next finer theory."""
    untensioned_elements: ClassVar[tuple[str, ...]] = ()
    """Elements whose straight shape carries no tension, as prestress ``axial`` needs it."""
    restrains_ends: ClassVar[bool] = False
    """Whether links of off-axis plies bend and twist between joints as in three dimensions."""
    element: str

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
    def prepare_comparisons(cls, mechanisms: Sequence[Mechanism], modes: int = MODES) -> None:
        """Find what :meth:`default_element` needs of many mechanisms at once, before it is asked.

        Parameters
        ----------
        mechanisms : sequence of Mechanism
        modes : int
            As there.
        """
        del mechanisms, modes

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


NEGLIGIBLE = 0.01
"""Relative difference of a frequency up to which the simpler theory is taken: less than what the
elastic moduli of most materials are known to."""


COMPRESSED = 0.5
"""Part of the frequency at which soft layers are compressed above which no beam theory is right.

Of 250 random sandwich arms and four-bars with cores of 5e-6 to 0.1 of the faces' modulus, zigzag
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
        Of a theory's name, or :data:`RESTRAINED_ENDS`: its frequencies in Hz at
        some crank angles, (A, modes).
    eccentric : bool
        Whether a neutral axis is off the pins' axis, which asks for a beam that shears.
    compression : callable
        Lowest frequency in Hz at which the layers of a link are compressed; infinite without
        layers.
    """

    frequency: Callable[[str], FloatArray]
    eccentric: bool
    compression: Callable[[], float]

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
        slender = self.difference("euler", "timoshenko").value <= NEGLIGIBLE
        # Zigzag beams are between the two: what shear does not change, warping cannot.
        if slender:
            return "timoshenko" if self.eccentric else "euler"
        warps = self.difference("timoshenko", "zigzag").value > NEGLIGIBLE
        return "zigzag" if warps else "timoshenko"
