"""A four-bar drawn by its points: another description of the same linkage."""

from __future__ import annotations

from flexmech import FourBar, PlanarJoint, PlanarLink, PlanarLinkage


def drawn_as_planar(linkage: FourBar, crank_angle: float) -> PlanarLinkage:
    """The linkage as it stands at a crank angle in rad."""
    motion = linkage.motion(crank_angle)
    a, b = motion.position(1, 0.0), motion.position(1, linkage.coupler)
    return PlanarLinkage(
        {"O2": (0.0, 0.0), "A": tuple(a), "B": tuple(b), "O4": (linkage.ground, 0.0)},
        (
            PlanarLink("crank", ("O2", "A")),
            PlanarLink("coupler", ("A", "B")),
            PlanarLink("rocker", ("O4", "B")),
        ),
        ("O2", "O4"),
        (PlanarJoint("O2", "clamp"),),
        crank_angle,
    )
