"""What an engineer would remark on in how a linkage moves: transmission angles, laws of motion."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from flexmech.analyses.check.in_short import turns_fully
from flexmech.linkages import Drive, PlanarLinkage
from flexmech.mechanism import Mechanism

_TURN = np.radians(np.arange(0.0, 360.0))
# In m/s^2, some 1e4 times that of weight: the fastest machines stay well below it.
_MOST_ACCELERATION = 1e5
_GRAVITY = 9.80665
# Time in which the crank gains its speed over the period of the first mode. A cycloidal move takes
# pi times as long: a tenth of a period.
_LEAST_RISE = 0.03


def on_transmission(linkage: PlanarLinkage, least: float) -> Iterator[str]:
    """On joints of a drawn linkage whose transmission angle is small.

    Parameters
    ----------
    linkage : PlanarLinkage
    least : float
        Usual transmission angle in degrees.

    Yields
    ------
    str
        Nothing of a crank that does not turn fully, which ends where a transmission angle is zero.
    """
    if linkage.drawing.is_stationary or not turns_fully(linkage):
        return
    for joint, angle in linkage.transmission_angles(_TURN).items():
        place = int(angle.argmin())
        found = math.degrees(float(angle[place]))
        if found < least:
            yield (
                f"joint {joint}: transmission angle {found:.4g} deg (pressure angle "
                f"{90 - found:.4g} deg) at crank angle {math.degrees(_TURN[place]):.4g} deg is "
                f"below {least:g} deg: large forces in the pins and little motion for them"
            )


def on_drive(mechanism: Mechanism, first: float | None) -> Iterator[str]:
    """On a law of motion, or a run-up, that is faster than machines are.

    Parameters
    ----------
    mechanism : Mechanism
    first : float or None
        First natural frequency in Hz, where it is known.

    Yields
    ------
    str
    """
    drive = mechanism.drive
    if not isinstance(drive, Drive) or drive.is_constant:
        return
    crank = mechanism.linkage.topology.links[0]
    times = drive.passing_times
    accelerations, speeds = drive.crank_acceleration(times), drive.crank_speed(times)
    gained, speed = float(np.abs(accelerations).max()), float(np.abs(speeds).max())
    reached = crank.length * float(np.hypot(accelerations, speeds**2).max())
    if reached > _MOST_ACCELERATION:
        yield (
            f"drive, {drive.words}: the end of the {crank.name} is accelerated by up to "
            f"{reached:.3g} m/s^2, {reached / _GRAVITY:.3g} times its weight; check the times"
        )
    if first and gained and speed / gained * first < _LEAST_RISE:
        yield (
            f"drive, {drive.words}: the crank gains its speed of {speed:.4g} rad/s in some "
            f"{speed / gained:.2g} s, {speed / gained * first:.2g} of a period of the first "
            f"natural frequency, {first:.4g} Hz: the links cannot follow; check the times"
        )
