"""How far the joints of a link keep it from twisting as its off-axis plies bend.

A laminate with plies off the link's axis twists as it bends (``D16``). Where pins along the joint
axes hold both ends, the ends cannot turn about the link's axis: a torque along the whole link,
the same everywhere, takes the twist back on the average. It adds the energy
``c^2 GJ (phi_2 - phi_1)^2 / (2 L)``, with c the twist that a unit of curvature brings, GJ the
torsional stiffness and phi the rotations of the ends. A half sine, the first mode between pins,
meets ``8 / pi^2`` of ``c^2 GJ``; the second mode, which turns both ends alike, nothing.

c and GJ are those of the cross-section in three dimensions
(:mod:`flexmech.sections.free_edges`): the shear stress of torsion turns round at the edges of
the width, within a layer of about the thickness. A link as wide as thick holds little of the
plate's torsional stiffness, a wide one all.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

Twist = Literal["free", "held"]
TWISTS: tuple[Twist, ...] = get_args(Twist)

FIRST_MODE = 8 / np.pi**2
"""Share of the twist's energy that a half sine between two joints meets."""
