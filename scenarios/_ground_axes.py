"""Frozen eigenvalues of the running linkage, written in link frames or in ground axes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import MovingFrame, Prestress
from flexmech.mechanics import Engine, LinearSystem
from flexmech.solvers import solve_modes

__all__ = ["frozen_eigenvalues", "in_ground_axes"]


def frozen_eigenvalues(
    engine: Engine,
    crank_angle: ArrayLike,
    crank_speed: ArrayLike,
    *,
    prestress: Prestress = "equilibrium",
    frame: MovingFrame = "link",
    modes: int,
) -> NDArray[np.complex128]:
    """Eigenvalues of the linkage at a fixed crank angle, in all its coordinates.

    They depend on the frame in which the nodes' displacements are written, Floquet multipliers
    do not: what a damping ratio of one position tells is a matter of the frame.

    Parameters
    ----------
    engine : Engine
    crank_angle, crank_speed : array_like
        In rad and rad/s; broadcast against each other and flattened to a batch of B.
    prestress : {"none", "axial", "equilibrium"}
    frame : {"link", "inertial"}
        Axes of the displacements: those of the links, or of the ground.
    modes : int
        Number of modes.

    Returns
    -------
    ndarray of complex, shape (B, modes)
        In rad/s, imaginary parts positive, by the natural frequencies of their shapes.
    """
    system = engine.unreduced().linear_system(crank_angle, crank_speed, prestress=prestress)
    if frame == "inertial":
        system = in_ground_axes(system)
    return solve_modes(system, modes).eigenvalues


def in_ground_axes(system: LinearSystem) -> LinearSystem:
    """The system of ``d = T(t) z``, T the turn of each node's vectors by its link's angle.

    With ``W = T'``: ``T M W``, ``T (2 M W. + C W)`` and ``T (M W.. + C W. + K W)``. A vector of
    which one component is fixed is the other component's number in any axes and stays.

    Parameters
    ----------
    system : LinearSystem
        Unreduced, in link frames.

    Returns
    -------
    LinearSystem
        Its coordinates d are displacements in ground axes.
    """
    motion, size = system.motion, system.size
    batch = len(motion.crank_angle)
    quarter, is_vector = np.zeros((size, size)), np.zeros(size, dtype=bool)
    angle, speed, change = np.zeros((3, batch, size))
    for number, (x, y) in enumerate(_free_vectors(system)):
        quarter[x, y], quarter[y, x] = -1.0, 1.0
        for own in (x, y):
            is_vector[own] = True
            angle[:, own] = motion.angle[:, number, None]
            speed[:, own] = motion.angular_velocity[:, number, None]
            change[:, own] = motion.angular_acceleration[:, number, None]
    still = np.diag((~is_vector).astype(float))
    back = still + _rows(np.cos(angle) * is_vector, np.eye(size)) - _rows(np.sin(angle), quarter)
    rate = -_rows(speed, quarter) @ back
    twice = -(_rows(change, quarter) + _rows(speed**2, np.eye(size))) @ back
    turn = np.swapaxes(back, 1, 2)
    mass, damping, stiffness = system.mass, system.damping, system.stiffness
    return replace(
        system,
        mass=turn @ mass @ back,
        damping=turn @ (2 * mass @ rate + damping @ back),
        stiffness=turn @ (mass @ twice + damping @ rate + stiffness @ back),
    )


def _rows(factors: FloatArray, matrix: FloatArray) -> FloatArray:
    """A matrix (n, n) whose rows are multiplied by factors (B, n)."""
    return np.asarray(factors[:, :, None] * matrix)


def _free_vectors(system: LinearSystem) -> list[IntArray]:
    """Numbers (2, k) of the coordinates of each link's own vectors of which both are free."""
    pairs = []
    for number, link in enumerate(system.frames.links):
        target = system.frames.targets[number].copy()
        target[system.frames.dependent_coordinates(number)] = -1
        both = target[link.vectors]
        pairs.append(both[:, (both >= 0).all(axis=0)])
    return pairs
