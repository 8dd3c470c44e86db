"""How far a computed frequency can be trusted: the error of the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses.frequencies.eigenproblem import solve_damping_ratios, solve_frequencies
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.linear_system import Engine
from flexmech.mesh import pieces
from flexmech.types import FloatArray, IntArray

__all__ = [
    "check_angle_indices",
    "damping_ratio_discretisation_error",
    "discretisation_error",
]


CHECK_ANGLES = 12
# Damping ratios are compared with those of a finer mesh: four times the elements if that is no
# more than this, else twice.
FINE_MESH = 64
# Of the damping ratios in turning frames; measured on random crank-rockers. At rest they converge
# faster, which a mesh four times as fine hardly notices.
RATIO_ORDER = 2
# Component modes of the two meshes: the difference must be of the meshes alone.
RATIO_DETAIL = 4.0
# Order in which linear elements stretch.
STRETCHING = 2


def check_angle_indices(crank_angles: FloatArray, full_turn: bool) -> IntArray:
    """About a dozen of the crank angles, evenly spread, the first among them."""
    count = len(crank_angles)
    closed = full_turn and np.isclose(crank_angles[-1] - crank_angles[0], 2 * np.pi)
    places = np.linspace(0, count - 1, CHECK_ANGLES + 1 if closed else CHECK_ANGLES)
    chosen = np.unique(np.round(places[:-1] if closed else places).astype(np.intp))
    return chosen[chosen < count]


def discretisation_error(
    systems: Systems, crank_angles: FloatArray, crank_speed: float
) -> FloatArray:
    """Estimated relative error of the frequencies by the mesh (Richardson).

    The same mechanism on coarser meshes; elastic part, change by prestress and change by
    rotation terms are extrapolated apart, each with its own powers of the element length.

    Parameters
    ----------
    systems : Systems
        As in the map. Running states are left out: the mesh acts as about the equilibrium.
    crank_angles : ndarray, shape (A,)
    crank_speed : float

    Returns
    -------
    ndarray, shape (A, modes)
        Positive.
    """
    engine, formulation = systems.engine, systems.formulation.quasi_static
    order = engine.convergence(formulation.quasi_static_prestress)
    at_rest = replace(formulation, prestress=engine.prestress_at_rest, rotation_terms=False)
    levels, powers = [(0.0, at_rest)], []
    if formulation.prestress != "none":
        levels.append((crank_speed, replace(formulation, rotation_terms=False)))
        powers.append(order.prestress)
    if formulation.rotation_terms and crank_speed:
        levels.append((crank_speed, formulation))
        powers.append(order.rotation)

    meshes = [engine, *(engine.with_(elements=n) for n in _companion_meshes(engine))]
    parts = np.stack(
        [
            _effects(
                replace(systems, engine=mesh, fastest=None, running=None), crank_angles, levels
            )
            for mesh in meshes
        ]
    )
    element_length = np.array([1 / mesh.elements for mesh in meshes])
    changes = np.swapaxes(parts, 0, 1)[1:]
    errors = np.stack(
        [_elastic_error(parts[:, 0], element_length, order.elastic, order.stretching)]
        + [_mesh_error(part, element_length, p) for part, p in zip(changes, powers, strict=True)]
    )
    # Parts that cancel are not known well enough to leave nothing.
    greatest = np.maximum(np.abs(errors.sum(axis=0)), np.abs(errors).max(axis=0) / 2)
    return np.asarray(greatest / parts[0].sum(axis=0), dtype=float)


def damping_ratio_discretisation_error(
    systems: Systems, crank_angles: FloatArray, crank_speed: float
) -> FloatArray:
    """Estimated error of the damping ratios by the mesh: the distance to a finer one.

    Their coarse meshes are not to be extrapolated from: the layer beside a pin, one element
    wide, reaches far into a link of four elements.

    Parameters
    ----------
    systems : Systems
        As in the map. Running states are left out: the mesh acts as about the equilibrium.
    crank_angles : ndarray, shape (A,)
    crank_speed : float

    Returns
    -------
    ndarray, shape (A, modes)
        Absolute, positive.
    """
    engine, formulation = systems.engine, systems.formulation.quasi_static
    times = 4 if 4 * engine.elements <= FINE_MESH else 2
    here, fine = (
        solve_damping_ratios(
            replace(
                systems, engine=mesh, formulation=formulation, running=None, detail=RATIO_DETAIL
            ).at(crank_angles, crank_speed),
            formulation.modes,
        )
        for mesh in (engine, engine.with_(elements=times * engine.elements))
    )
    return np.asarray(np.abs(here - fine) / (1 - times**-RATIO_ORDER), dtype=float)


def _effects(
    systems: Systems, crank_angles: FloatArray, levels: Sequence[tuple[float, Formulation]]
) -> FloatArray:
    """Frequencies at the first level, then what each level adds; (levels, A, modes)."""
    values = [
        solve_frequencies(replace(systems, formulation=level).at(crank_angles, speed), level.modes)
        for speed, level in levels
    ]
    return np.concatenate([values[:1], np.diff(np.stack(values), axis=0)])


def _mesh_error(values: FloatArray, element_length: FloatArray, power: int) -> FloatArray:
    """Error of ``values[0]`` if it goes with a power of the element length.

    A first-order error has a second-order part of like size (the layer at a pin is one
    element wide, and the shape changes across it): three meshes fit both.
    """
    if power > 1:
        ratio = (element_length[1] / element_length[0]) ** power
        return np.asarray((values[0] - values[1]) / (1 - ratio), dtype=float)
    fit = np.linalg.solve(element_length[:, None] ** [0, 1, 2], values.reshape(3, -1))
    return np.asarray(values[0] - fit[0].reshape(values[0].shape), dtype=float)


def _elastic_error(
    values: FloatArray, element_length: FloatArray, bending: int, stretching: int
) -> FloatArray:
    """Error of ``values[0]`` of linkages at rest: bending of a high order, stretching of a low one.

    A mode may do both. The decay of the differences of three meshes tells its order (Roache,
    Verification and Validation in Computational Science and Engineering, 1998, sec. 5.10).
    """
    order = np.argsort(element_length)
    near, far = values[order[0]] - values[order[1]], values[order[1]] - values[order[2]]
    refined = element_length[order[1]] / element_length[order[0]]
    with np.errstate(divide="ignore", invalid="ignore"):
        observed = far / near
    # Two elements bend poorly: only an order near that of stretching is taken for it.
    stretches = observed < refined ** (STRETCHING + 0.5)
    ratio = np.where(stretches, np.maximum(observed, refined**stretching), refined**bending)
    return np.asarray(near / (1 - ratio) + values[0] - values[order[0]], dtype=float)


def _companion_meshes(engine: Engine) -> tuple[int, int]:
    """Half and quarter mesh; twice and four times where these are too coarse."""
    mechanism = engine.mechanism
    least = max(len(pieces(m.length, m.point_positions)) for m in mechanism.link_masses_in_order)
    if engine.elements // 4 >= max(2, least):
        return engine.elements // 2, engine.elements // 4
    return 2 * engine.elements, 4 * engine.elements
