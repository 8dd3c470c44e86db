"""How far computed modes can be trusted: the error of the mesh, and of lumped masses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.modal_damping import StrainEnergyDamping
from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import MOST_ELEMENTS
from flexmech.mechanics import Engine
from flexmech.solvers.eigenproblem import solve_eigenvalues, solve_modes
from flexmech.solvers.formulation import Systems
from flexmech.solvers.reduction import (
    ModeErrors,
    converged_modes,
    unreduced_eigenvalues,
)

# Every 30 deg of a turn: each costs a solution on a finer mesh and one without component modes.
CHECK_ANGLES = 12
# A mesh is compared with one of four times the elements if that is no more than this, else of twice
# as many. The distance to four times as many is nearly the error itself (15/16 of it in second
# order), and a check is not to cost more than 64 elements do.
FINE_MESH = 64
# Component modes of the two meshes: the difference must be of the meshes alone. Speed alone: where
# they have a part in it all the same, unreduced matrices are compared.
DETAIL = 4.0
# What component modes may move an eigenvalue by: of the difference by the meshes, whose first digit
# that leaves right, or relative, where nobody asks for a smaller error.
SHARE, NEGLIGIBLE = 0.2, 1e-6
# In the element length, of any frequency of any element: that of cubic beams.
HIGHEST_ORDER = 4


def check_angle_indices(crank_angles: FloatArray, full_turn: bool) -> IntArray:
    """About a dozen of the crank angles, evenly spread, the first among them."""
    count = len(crank_angles)
    closed = full_turn and np.isclose(crank_angles[-1] - crank_angles[0], 2 * np.pi)
    places = np.linspace(0, count - 1, CHECK_ANGLES + 1 if closed else CHECK_ANGLES)
    chosen = np.unique(np.round(places[:-1] if closed else places).astype(np.intp))
    return chosen[chosen < count]


def mesh_error(
    systems: Systems,
    crank_angles: FloatArray,
    crank_speed: float,
    *,
    compared: Engine | None = None,
) -> ModeErrors:
    """Estimated error of the lowest modes by the mesh, from the distance to a finer one.

    No order of convergence is assumed. Bending converges in fourth order of the element length,
    stretching in second, rotation terms in first, prestress and point masses lower some of them,
    and one mode may be of all kinds. Coarser meshes do not tell the orders: stretching and bending
    stand in another sequence there. The distance d to a mesh r times as fine is the share
    ``1 - r^-p`` of the error, from ``1 - 1/r`` in first order to nearly all of it in fourth:
    ``d / sqrt(1 - 1/r)`` is right within 15 % for r = 4 and within a factor of 1.4 for r = 2.

    Both meshes have many component modes. Where the difference is greatest they are compared with
    unreduced matrices; if they have a part in it, as those of links that springs bend, eigenvalues
    of the unreduced matrices are compared.

    Parameters
    ----------
    systems : Systems
        As in the map. Running states are left out: the mesh acts as about the equilibrium.
    crank_angles : ndarray, shape (A,)
    crank_speed : float
    compared : Engine, optional
        :func:`on_compared_mesh`, where it is at hand.

    Returns
    -------
    ModeErrors
    """
    compared = on_compared_mesh(systems.engine) if compared is None else compared
    meshed = [_quasi_static(systems, engine) for engine in (systems.engine, compared)]
    count = systems.formulation.modes
    here, there = (
        np.concatenate([solve_eigenvalues(s, count) for s in m.batches(crank_angles, crank_speed)])
        for m in meshed
    )
    share = share_of_error(systems.engine.elements, compared.elements)
    error = _apart(here, there, share)
    if not systems.engine.component_modes or systems.engine.turns_as_one_body:
        return error
    place = int(error.frequency.max(axis=1).argmax())
    worst = slice(place, place + 1)
    for each, found in zip(meshed, (here, there), strict=True):
        exact = unreduced_eigenvalues(each, crank_angles[worst], crank_speed)
        if not _outweighs(error.at(worst), _apart(found[worst], exact)):
            here, there = (unreduced_eigenvalues(m, crank_angles, crank_speed) for m in meshed)
            return _apart(here, there, share)
    return error


def share_of_error(divisions: int, compared: int) -> float:
    """Share of an error that is the distance to a result of other divisions; see `mesh_error`.

    Parameters
    ----------
    divisions, compared : int
        Elements or time steps of the result, and of the one that it is compared with.

    Returns
    -------
    float
        Between the share in first order and that of high orders. Against half the divisions, where
        twice as many do not fit into memory, the distance is the error itself in first order and
        more than it in a higher one.

    Examples
    --------
    >>> round(share_of_error(8, 16), 3), share_of_error(8, 4)
    (0.707, 1.0)
    """
    return float(np.sqrt(1 - divisions / compared)) if compared > divisions else 1.0


def lumping_error(systems: Systems, crank_angles: FloatArray, crank_speed: float) -> FloatArray:
    """Error of the lowest modes by masses that are lumped: their distance to distributed ones.

    Between lumped masses any mesh is exact at rest, since links without mass bend in cubic
    parabolas: a finer mesh does not move such a frequency, and says nothing of what lumps do to
    it. So the same engine solves for modes of distributed mass, on the mesh that
    :func:`mesh_error` compares with. Lumps are as many as Kumar & Chandrakar's Figure 1.5 has; what
    they are off by may be any share of a frequency.

    Parameters
    ----------
    systems : Systems
        As in the map, of an engine whose masses are lumped.
    crank_angles : ndarray, shape (A,)
    crank_speed : float

    Returns
    -------
    ndarray, shape (A, m)
        Relative to the frequencies of the lumped masses.
    """
    engine, count = systems.engine, systems.formulation.modes
    whole = on_compared_mesh(engine).with_(mass="distributed")
    exact = converged_modes(replace(systems, engine=whole), crank_angles, crank_speed).modes
    lumped = np.concatenate(
        [solve_eigenvalues(s, count) for s in systems.batches(crank_angles, crank_speed)]
    )
    return np.asarray(np.abs(2 * np.pi * exact.frequency[:, :count] / np.abs(lumped) - 1))


def damping_error(systems: Systems, crank_angles: FloatArray, crank_speed: float) -> FloatArray:
    """Estimated error of damping by modal strain energy by the mesh, as :func:`mesh_error` has it.

    Parameters
    ----------
    systems : Systems
        As in the map, of an engine on a mechanism with specific damping.
    crank_angles : ndarray, shape (A,)
    crank_speed : float

    Returns
    -------
    ndarray, shape (A, m)
        Estimated relative error of each damping ratio.
    """
    meshed = [systems.engine, on_compared_mesh(systems.engine)]
    here, there = (
        _strain_energy_damping(_quasi_static(systems, engine), crank_angles, crank_speed)
        for engine in meshed
    )
    share = share_of_error(*(engine.elements for engine in meshed))
    return np.asarray(np.abs(here - there) / share)


def _strain_energy_damping(
    systems: Systems, crank_angles: FloatArray, crank_speed: float
) -> FloatArray:
    """Damping ratios (A, m) of systems about the quasi-static state."""
    losses, formulation = StrainEnergyDamping.of(systems.engine), systems.formulation
    assert losses is not None
    ratios = [
        losses.ratio(
            system, solve_modes(system, formulation.modes), formulation.quasi_static_prestress
        )
        for system in systems.batches(crank_angles, crank_speed)
    ]
    return np.concatenate(ratios)


def _outweighs(mesh: ModeErrors, reduction: ModeErrors) -> bool:
    """Whether what component modes are off by has no part in what the mesh is off by."""
    pairs = zip(vars(mesh).values(), vars(reduction).values(), strict=True)
    return all(bool(np.all(r <= np.maximum(SHARE * e, NEGLIGIBLE))) for e, r in pairs)


def _apart(
    here: NDArray[np.complex128], there: NDArray[np.complex128], share: float = 1.0
) -> ModeErrors:
    """Difference of eigenvalues (A, m), over its share of the error."""
    ratio, other_ratio = (-values.real / np.abs(values) for values in (here, there))
    return ModeErrors(
        frequency=np.abs(np.abs(here) / np.abs(there) - 1) / share,
        damping_ratio=np.abs(ratio - other_ratio) / share,
    )


def _compared_mesh(elements: int) -> int:
    """Elements of the mesh that one of so many is compared with."""
    if 4 * elements <= FINE_MESH:
        return 4 * elements
    return 2 * elements if 2 * elements <= MOST_ELEMENTS else elements // 2


def on_compared_mesh(engine: Engine) -> Engine:
    """The engine on the mesh that its own is compared with; serves all speeds."""
    return engine.with_(elements=_compared_mesh(engine.elements))


def _quasi_static(systems: Systems, engine: Engine) -> Systems:
    """The systems of an engine on this or another mesh about the quasi-static state."""
    return replace(
        systems,
        engine=engine,
        formulation=systems.formulation.quasi_static,
        running=None,
        detail=max(DETAIL, systems.detail),
    )
