"""Equations of motion at the stages of Lobatto's method, solved for links that stretch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems.lobatto import POSITION, RATE, RATE_BY_POSITION, STAGES
from flexmech.time_domain.equations_of_motion.equations import Equations
from flexmech.time_domain.equations_of_motion.linkage_stretch import LinkageStretch, PinRotations


@dataclass(frozen=True)
class StageOperators:
    """Equations of motion at both stages of m double steps, and their solution.

    Parameters
    ----------
    resistance : ndarray, shape (m, 2, n, 2 n)
        Stiffness and, beside it, damping over H, at each stage.
    force : ndarray, shape (m, 2, n)
    compliance : ndarray, shape (m, 2 p, 2 p)
        Displacements of augmented coordinates at the stages by unit forces on them.
    relaxation : ndarray, shape (m, 2 s, 2 s)
        Decrease of the tensions at the stages by unit tensions.
    turns : PinRotations
        Arrays of shape (m, 2, f, k).
    """

    resistance: FloatArray
    force: FloatArray
    compliance: FloatArray
    relaxation: FloatArray
    turns: PinRotations


def stage_operators(equations: Equations, stretch: LinkageStretch, step: float) -> StageOperators:
    """Solve the equations of both stages for all forces at once.

    Parameters
    ----------
    equations : Equations
        At the middle of m double steps, then at their ends, one pair after the other.
    stretch : LinkageStretch
    step : float
        H in s.

    Returns
    -------
    StageOperators
    """
    size, strains = equations.force.shape[-1], len(stretch.gradient)
    mass, damping, stiffness = (
        part.reshape(-1, STAGES, size, size)
        for part in (equations.mass, equations.damping, equations.stiffness)
    )
    count = len(mass)
    effective = _coupled(step * RATE, damping) + _coupled(step**2 * POSITION, stiffness)
    for stage in range(STAGES):
        effective[:, stage, :, stage] += mass[:, stage]
    flat = stretch.pin_rotations(equations.motion)
    turns = PinRotations(*(t.reshape(count, STAGES, *t.shape[1:]) for t in (flat.turn, flat.rate)))
    gathered = np.zeros((count, STAGES, size, STAGES, stretch.size))
    for stage in range(STAGES):
        gathered[:, stage, :, stage] = np.swapaxes(stretch.augmentation(turns.turn[:, stage]), 1, 2)
    total = STAGES * stretch.size
    solved = np.linalg.solve(
        effective.reshape(count, STAGES * size, -1), gathered.reshape(count, STAGES * size, -1)
    ).reshape(count, STAGES, -1)
    moved = (step**2 * POSITION @ solved).reshape(count, STAGES, size, total)
    compliance = stretch.augmented(turns.turn, moved)
    # Strains by unit tensions, which act and are seen by the linear part of the strain.
    pulled = (stretch.gradient @ compliance).reshape(count, STAGES, strains, STAGES, -1)
    strain = pulled @ stretch.gradient.T
    by_rate = np.einsum("ik,mksjt->misjt", RATE_BY_POSITION, strain)
    relaxation = strain + (stretch.damping_time / step)[:, None, None] * by_rate
    return StageOperators(
        np.concatenate([stiffness, damping / step], axis=-1),
        equations.force.reshape(count, STAGES, size),
        compliance.reshape(count, total, total),
        relaxation.reshape(count, STAGES * strains, -1),
        turns,
    )


def _coupled(weights: FloatArray, matrices: FloatArray) -> FloatArray:
    """Blocks ``weights[i, j] * matrices[i]``, (m, 2, n, 2, n)."""
    return np.asarray(weights[:, None, :, None] * matrices[:, :, :, None, :])
