"""Where the stations along the undeformed links are."""

from __future__ import annotations

import numpy as np

from flexmech.linear_system import Engine
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray


def rigid_positions(engine: Engine, motion: RigidMotion) -> FloatArray:
    """Stations of the undeformed links in ground axes.

    Parameters
    ----------
    engine : Engine
        Whose stations they are.
    motion : RigidMotion
        Batch of shape (B,).

    Returns
    -------
    ndarray, shape (B, n_links, n_stations, 2)
        In m.
    """
    parts = []
    for number, (link, body) in enumerate(
        zip(engine.links, engine.mechanism.linkage.topology.links, strict=True)
    ):
        places = np.linspace(0.0, body.length, len(link.shape))
        parts.append(np.stack([motion.position(number, float(x)) for x in places], axis=1))
    return np.stack(parts, axis=1)
