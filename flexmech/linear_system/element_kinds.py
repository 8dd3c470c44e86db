"""The kinds of element that an engine has, their beam theories, and which a mechanism needs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from flexmech.choices import MODES
from flexmech.linear_system.theory_comparison import TheoryComparison
from flexmech.mechanism import Mechanism


class ElementKinds(ABC):
    """What an engine's elements are to beam theory.

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
    holds_ends: ClassVar[bool] = False
    """Whether links of off-axis plies bend and twist between joints as in three dimensions."""
    element: str

    @property
    def theory(self) -> str:
        """Beam theory of the element, by its name in the reference engine."""
        return self.theories[self.element]

    @classmethod
    @abstractmethod
    def compare_theories(cls, mechanism: Mechanism, modes: int) -> TheoryComparison:
        """Hold beam theories against each other on a mechanism at rest.

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
