"""What ``flexmech coupler-curve`` prints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexmech.hygrothermal import CouplerPath, State
    from flexmech.mechanism import Mechanism

__all__ = ["lines"]


def lines(mechanism: Mechanism, paths: Mapping[str, CouplerPath], state: State | None) -> list[str]:
    """Lengths, double points, changes, and the check by the sextic.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    paths : mapping of str to CouplerPath
        By state: ``dry`` and, where asked for, ``wet``.
    state : HygrothermalState or Exposure, optional
        The wet one.

    Returns
    -------
    list of str
    """
    from flexmech.cli.state_report import link_lines

    said = link_lines(mechanism, state)
    for name, path in paths.items():
        lengths = ", ".join(f"{link} {1e3 * m:.6g}" for link, m in path.linkage.lengths.items())
        said.append(f"{name}: {lengths}, coupler point {1e3 * path.point.distance:.6g} mm from A")
    for name, path in paths.items():
        said += _topology_lines(name, path)
    if "wet" in paths:
        said += _change_lines(paths["dry"], paths["wet"])
    worst = max(path.sextic_residual for path in paths.values())
    said.append(f"check: the curve's sextic equation is met within {worst:.1e}")
    return said


def _topology_lines(name: str, path: CouplerPath) -> list[str]:
    import numpy as np

    crunodes, cusps = path.count("crunode"), path.count("cusp")
    words = (
        f"{crunodes} crunode{'' if crunodes == 1 else 's'} and {cusps} "
        f"cusp{'' if cusps == 1 else 's'}"
    )
    if not path.linkage.crank_turns_fully:
        words += f" on the whole circuit, both branches ({path.linkage.grashof_class})"
    lines = [f"{name}: {words}"]
    for double in path.double_points:
        first, second = np.degrees(double.crank_angles)
        x, y = 1e3 * double.position
        lines.append(
            f"{name}: {double.kind} at ({x:.6g}, {y:.6g}) mm, crank angles {first:.6g} and "
            f"{second:.6g} deg"
        )
    return lines


def _change_lines(dry: CouplerPath, wet: CouplerPath) -> list[str]:
    import numpy as np

    change = np.angle(np.exp(1j * (wet.angles - dry.angles)))
    lines = []
    for link, values in zip(("theta3", "theta4"), np.degrees(change).T, strict=True):
        low, high = int(values.argmin()), int(values.argmax())
        at = np.degrees(dry.crank_angle)
        lines.append(
            f"change of {link}: {values[low]:+.5f} deg (at {at[low]:g} deg) to "
            f"{values[high]:+.5f} deg (at {at[high]:g} deg)"
        )
    moved = np.hypot(*(wet.position - dry.position).T)
    lines.append(
        f"coupler point: moved by at most {1e3 * moved.max():.5g} mm, at crank angle "
        f"{np.degrees(dry.crank_angle[moved.argmax()]):g} deg"
    )
    return lines
