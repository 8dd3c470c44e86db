"""Linkages in two-dimensional elasticity; needs scikit-fem."""

from __future__ import annotations

import numpy as np

from flexmech.errors import InputError
from flexmech.types import FloatArray
from flexmech.verification.methods.engines import example


def four_bar_by_plane_elasticity(
    *, model: str, crank_angle: float, elements: int, modes: int
) -> FloatArray:
    """Natural frequencies of a four-bar at rest by plane stress, its layers in elements.

    Parameters
    ----------
    model : str
        Name of an example with laminated links.
    crank_angle : float
        In deg.
    elements : int
        Along each link.
    modes : int

    Returns
    -------
    ndarray, shape (modes,)
        In Hz.

    Raises
    ------
    InputError
        If a link has no layers.
    """
    from flexmech.verification.methods.plane_elasticity import fourbar_frequencies, plane_link

    mechanism = example(model)
    links = mechanism.linkage.topology.links
    made = []
    for link in links:
        layers = mechanism.sections[link.name].layers
        if layers is None:
            raise InputError(f"{model}: {link.name} has no layers")
        made.append(plane_link(layers.laminate, layers.width, link.length, elements))
    angles = mechanism.linkage.motion(np.radians(crank_angle)).angle.tolist()
    return fourbar_frequencies(made, angles, [link.length for link in links], modes)
