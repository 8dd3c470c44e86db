"""What is said of a mechanism: its masses, its operation, and what heat and moisture change."""

from __future__ import annotations

import numpy as np

from flexmech.hygrothermal import absorbing_links, inert_links
from flexmech.mechanism import Mechanism

__all__ = ["mechanism_lines"]

ZERO_CELSIUS = 273.15


def mechanism_lines(mechanism: Mechanism) -> list[str]:
    """Masses and operation of a mechanism, its coupler point, and its links in heat and moisture.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    list of str
    """
    x, y = mechanism.gravity
    speeds = [f"{w:.6g} rad/s ({w * 30 / np.pi:.4g} rpm)" for w in mechanism.operating_speeds]
    lines = [
        *_mass_lines(mechanism),
        f"gravity: ({x:g}, {y:g}) m/s^2",
        f"operating speeds: {', '.join(speeds) or 'none stated'}",
    ]
    point = mechanism.coupler_point
    if point is not None:
        degrees = np.degrees(point.angle)
        lines.append(f"coupler point: {_milli(point.distance)} mm from A, {degrees:.6g} deg")
    inert = inert_links(mechanism)
    changed = [name for name in mechanism.linkage.topology.link_names if name not in inert]
    if changed:
        lines.append(
            f"heat and moisture change: {', '.join(changed)}; water enters: "
            f"{', '.join(absorbing_links(mechanism)) or 'none'}; reference temperature "
            f"{mechanism.reference_temperature - ZERO_CELSIUS:.4g} degC"
        )
    return lines


def _mass_lines(mechanism: Mechanism) -> list[str]:
    joints = [f"{name} {_milli(mass)} g" for name, mass in mechanism.joint_masses.items()]
    points = [
        f"{point.link} {_milli(point.mass)} g at {_milli(point.position)} mm"
        for point in mechanism.link_masses
    ]
    # Links with the point masses along them and at their joints.
    total = sum(link.moment(0) for link in mechanism.link_masses_in_order)
    return [
        f"joint masses: {', '.join(joints) or 'none'}",
        f"link point masses: {', '.join(points) or 'none'}",
        f"total mass: {_milli(total)} g",
    ]


def _milli(value: float) -> str:
    """Write a length in mm or a mass in g."""
    return f"{value * 1e3:.6g}"
