"""Interface of a kind of beam element of Exudyn."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import RigidFields
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.strains import Strain
from flexmech.sections import BeamSection


class BeamKind(ABC):
    """Interface to build a chain of beam elements and to read its coordinates.

    Attributes
    ----------
    per_node : int
        Coordinates a node.
    vectors : tuple of tuple of int
        Pairs of a node's coordinates that turn as a vector with the link.
    clamped : int
        The node's coordinate that a clamp holds besides the position: slope or rotation.
    deflection : int or None
        The node's coordinate across the link if its slope follows from it (no shear).
    turns_arms : bool
        Whether a node's section is rigid and turns what sits off the neutral axis.
    carries_mass : bool
        Whether the elements carry the link's mass; if not, bodies at the nodes do.
    has_rotary_inertia : bool
        Whether vibration has the rotary inertia of the sections; the rigid motion always has it.
    """

    per_node: int
    vectors: tuple[tuple[int, int], ...]
    clamped: int
    deflection: int | None
    turns_arms: bool
    carries_mass: bool
    has_rotary_inertia: bool

    @abstractmethod
    def add_node(self, items: SystemItems, name: str, x: float, y: float) -> ItemNumber:
        """Node of a link along the global x axis; returns its number.

        Parameters
        ----------
        items : SystemItems
        name : str
        x, y : float
            Place along the link and distance of the neutral axis from the pins' axis in m.

        Returns
        -------
        ItemNumber
        """

    @abstractmethod
    def add_element(
        self,
        items: SystemItems,
        name: str,
        nodes: list[ItemNumber],
        length: float,
        section: BeamSection,
    ) -> ItemNumber:
        """Beam element between two nodes.

        Parameters
        ----------
        items : SystemItems
        name : str
        nodes : list of ItemNumber
            Of its two nodes.
        length : float
            In m.
        section : BeamSection

        Returns
        -------
        ItemNumber
        """

    @abstractmethod
    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Displacement inside elements, (s, 2, 2 per_node) for places (s,)."""

    @abstractmethod
    def rigid_fields(self, nodes: FloatArray) -> RigidFields:
        """Coordinates of a rigid link's accelerations."""

    @abstractmethod
    def pose(self, nodes: FloatArray, origin: FloatArray, angle: float) -> FloatArray:
        """Coordinates, less the reference ones, of a straight link at a place and angle.

        Parameters
        ----------
        nodes : ndarray, shape (k,)
            Node positions along the link in m.
        origin : ndarray, shape (2,)
            Its start in m.
        angle : float
            In rad.

        Returns
        -------
        ndarray, shape (k * per_node,)
        """

    @abstractmethod
    def add_axis_marker(
        self,
        items: SystemItems,
        name: str,
        node: ItemNumber,
        element: ItemNumber,
        x: float,
        angle: float = 0.0,
    ) -> ItemNumber:
        """Marker that turns with the beam's axis (its section if it shears) at a node.

        Parameters
        ----------
        items : SystemItems
        name : str
        node, element : ItemNumber
            Of the node and of the element that ends there.
        x : float
            The node's distance from the element's start in m.
        angle : float
            By which the marker is turned against the axis, in rad; of a cable alone.

        Returns
        -------
        ItemNumber
        """

    @abstractmethod
    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """The strains by which Exudyn's element stores energy, at its integration points.

        Parameters
        ----------
        displacement, rate : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link along x, and their
            time derivatives, in axes that may turn with the link.
        length : ndarray, shape (k - 1,)
            Of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        list of Strain
        """

    def swell(self, mbs: Any, element: int, section: BeamSection, part: float) -> None:
        """Give an element a part of its section's free curvature and strain.

        Parameters
        ----------
        mbs : exudyn.MainSystem
        element : int
            Exudyn's number.
        section : BeamSection
        part : float
            1 for all of it.
        """
        mbs.SetObjectParameter(element, "referenceCurvature", part * section.free_curvature)

    def internal_force(
        self, displacement: FloatArray, length: FloatArray, section: BeamSection
    ) -> FloatArray:
        """Elastic forces on the nodes, the derivative of the strain energy.

        Parameters
        ----------
        displacement : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link.
        length : ndarray, shape (k - 1,)
            Of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        ndarray, shape (m, k * per_node)
        """
        size = displacement.shape[1]
        unit_rates = np.tile(np.eye(size), (len(displacement), 1))
        strains = self.strains(np.repeat(displacement, size, axis=0), unit_rates, length, section)
        return np.asarray(sum(strain.power for strain in strains)).reshape(displacement.shape)

    def is_axial(self, count: int) -> NDArray[np.bool_]:
        """Whether coordinates of a chain of ``count`` nodes are displacements along its axis."""
        axial = np.zeros(self.per_node, dtype=bool)
        axial[[x for x, _ in self.vectors]] = True
        return np.tile(axial, count)

    def vector_pairs(self, count: int) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in a chain of ``count`` nodes."""
        base = self.per_node * np.arange(count)[:, None]
        pairs = np.array(self.vectors)
        return (base + pairs[:, 0]).ravel(), (base + pairs[:, 1]).ravel()
