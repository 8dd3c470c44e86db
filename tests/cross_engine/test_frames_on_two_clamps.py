"""Frames that stand on two clamps, whose cables Exudyn keeps from turning by their slopes."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    Load,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.linkages import AttachmentPoint
from tests.cross_engine.test_exudyn_joints import KINDS

CORNERS = {"O": (0.0, 0.0), "P": (0.0, 0.3), "Q": (0.3, 0.3), "R": (0.4, 0.0)}


@pytest.mark.parametrize("kind", KINDS)
def test_engines_agree_on_a_loaded_frame_with_a_slanted_column(kind: str) -> None:
    """Held at another angle at its foot, the column would bow by itself."""
    frame = PlanarLinkage(
        CORNERS,
        (
            PlanarLink("left", ("O", "P")),
            PlanarLink("beam", ("P", "Q")),
            PlanarLink("right", ("R", "Q")),
        ),
        ("O", "R"),
        (
            *(PlanarJoint(foot, "clamp") for foot in "OR"),
            *(PlanarJoint(corner, "weld") for corner in "PQ"),
        ),
    )
    strip = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3)
    load = Load("side", AttachmentPoint("beam", 0.1), ((4.0, -6.0),))
    mechanism = Mechanism(
        frame,
        dict.fromkeys(frame.topology.link_names, strip),
        gravity=(0.0, -9.81),
        loads=(load,),
    )
    element = {"ancf": "euler", "geometrically-exact": "timoshenko"}[kind]
    reference, exudyn = (
        natural_frequencies(engine, frame.drawn_angle, 0.0, modes=3, prestress="equilibrium")
        for engine in (ReferenceEngine(mechanism, 6, element), ExudynEngine(mechanism, 6, kind))
    )
    np.testing.assert_allclose(exudyn, reference, rtol=2e-3)
