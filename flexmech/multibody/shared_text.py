"""Functions and classes whose text an exported script contains."""

from __future__ import annotations

from flexmech.multibody.closure import AngleGap, ClosedJoints, JoinedEnd, LineGap, PlaceGap
from flexmech.multibody.user_functions import (
    AxisPoint,
    HubClamp,
    Joints,
    Shaft,
    constraint_force,
    difference_mass,
    guide_line_force,
    load_history,
    middle_deflection,
    torque_history,
    turned_frame,
)

# In the order in which they need each other.
SHARED = (
    Shaft,
    AxisPoint,
    HubClamp,
    Joints,
    JoinedEnd,
    PlaceGap,
    AngleGap,
    LineGap,
    ClosedJoints,
    difference_mass,
    turned_frame,
    load_history,
    torque_history,
    middle_deflection,
    constraint_force,
    guide_line_force,
)
