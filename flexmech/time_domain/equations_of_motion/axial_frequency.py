"""The lowest frequency at which the links of a linkage vibrate along themselves."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from flexmech.linear_system import Engine, LinkFrames, LinkModel, RotationTerms
from flexmech.types import FloatArray

# Of the greatest eigenvalue: what is below is round-off of links that turn.
LOOSE = 1e-10


def lowest_axial_frequency(engine: Engine, crank_angle: FloatArray) -> float:
    """Lowest natural frequency of a linkage whose links stretch but do not bend, in Hz.

    Straight links, pinned as they are, with all masses and without stress: a truss, in which
    a clamped link does not turn. The least of all positions. Bearings hold in it. Welds are pins
    in it: links that turn about these without stretching any do not vibrate and are not counted,
    nor are rigid links, of which a truss may be loose.

    Parameters
    ----------
    engine : Engine
    crank_angle : ndarray, shape (m,)
        In rad.

    Returns
    -------
    float
    """
    engine.check_runs()
    topology = engine.tied_topology
    links = [_straight(link) for link in engine.links]
    frames = LinkFrames(topology, links)
    matrices = frames.assemble(
        engine.mechanism.linkage.motion(crank_angle, 0.0),
        [link.stiffness for link in links],
        RotationTerms.all_or_none(False),
    )
    clamped = [topology.index(clamp.held.link) for clamp in topology.clamps]
    turning = [frames.targets[number][-2:] for number in clamped]
    free = np.setdiff1d(np.arange(frames.size), turning)
    loose = bool(topology.welds or any(link.rigid for link in links))
    squares = [
        _lowest(k, m, loose)
        for k, m in zip(
            matrices.stiffness[:, free[:, None], free],
            matrices.mass[:, free[:, None], free],
            strict=True,
        )
    ]
    return float(np.sqrt(max(min(squares), 0.0)) / (2 * np.pi))


def _lowest(stiffness: FloatArray, mass: FloatArray, loose: bool) -> float:
    """Lowest eigenvalue; of a loose truss the lowest of what stretches."""
    if not loose:
        found = scipy.linalg.eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, 0])
        return float(found[0])
    found = scipy.linalg.eigh(stiffness, mass, eigvals_only=True)
    return float(found[found > LOOSE * found[-1]][0])


def _straight(link: LinkModel) -> LinkModel:
    """A link that only stretches and turns: its last two coordinates move its ends across."""
    if link.rigid:
        return link
    axial = np.flatnonzero(link.is_axial)
    along = np.zeros((link.size, len(axial)))
    along[axial, np.arange(len(axial))] = 1.0
    at_end = link.fields.tangential / float(link.fields.centripetal[link.end[0]])
    basis = np.column_stack([along, link.fields.across - at_end, at_end])
    start, end = np.searchsorted(axial, [link.start[0], link.end[0]])
    places = {"start": np.array([start, len(axial)]), "end": np.array([end, len(axial) + 1])}
    return link.projected(basis, places)
