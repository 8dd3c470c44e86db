"""Crank speeds of a request: numbers with their unit, or those that a mechanism names.

One form for all functions and requests: numbers are in ``speed_unit`` where it is given and in
rad/s where it is left out, and results speak in the same unit. Speeds that are left out are the
mechanism's, and results speak in the unit of its file.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.crank_values import Speeds, UsualSpeeds
from flexmech.errors import InputError
from flexmech.mechanism import Mechanism
from flexmech.units import ANGULAR_SPEED, from_si, to_si
from flexmech.validation import check_number, checked_array

RAD_S = ANGULAR_SPEED.unit
# Speeds of a model file that are named one by one; of more speeds the least and the
# greatest.
_MOST_SPEEDS = 5
# Printed digits of a speed: machines' speeds are known to fewer.
_DIGITS = 6


def rad_per_s(values: ArrayLike, unit: str | None, name: str = "crank_speeds") -> FloatArray:
    """Crank speeds in rad/s.

    Parameters
    ----------
    values : array_like
        In ``unit``.
    unit : str or None
        None: in rad/s.
    name : str
        Name of the argument, for messages.

    Returns
    -------
    ndarray
        Crank speeds in rad/s, of the shape of the input.

    Raises
    ------
    InputError
        If a value is no number, or the unit is none of crank speeds.
    """
    numbers = checked_array(values, name, unit or RAD_S)
    if unit is None:
        return numbers
    try:
        found = [to_si(number, unit, ANGULAR_SPEED) for number in numbers.ravel().tolist() or [0.0]]
    except InputError as error:
        raise error.within("speed_unit") from error
    return np.array(found[: numbers.size], dtype=float).reshape(numbers.shape)


def one_rad_per_s(value: float, unit: str | None, name: str = "crank_speed") -> float:
    """One crank speed in rad/s.

    Parameters
    ----------
    value : float
    unit : str or None
    name : str
        As of :func:`rad_per_s`.

    Returns
    -------
    float

    Raises
    ------
    InputError
        As :func:`rad_per_s`.
    """
    check_number(value, name, unit or RAD_S)
    return float(rad_per_s(value, unit, name))


def asked_speeds(
    values: ArrayLike | None,
    unit: str | None,
    mechanism: Mechanism,
    usual: Callable[[Mechanism], FloatArray],
) -> tuple[FloatArray, str]:
    """Crank speeds in rad/s, and the unit in which a result speaks of them.

    Parameters
    ----------
    values : array_like or None
        In ``unit``; None where they are left out.
    unit : str or None
    mechanism : Mechanism
    usual : callable
        Takes the mechanism, and gives the speeds in rad/s that are taken where they are left out.

    Returns
    -------
    ndarray
    str

    Raises
    ------
    InputError
        As :func:`rad_per_s`, or if speeds are left out and the mechanism names none.
    """
    if values is not None:
        return rad_per_s(values, unit), unit or RAD_S
    try:
        return usual(mechanism), unit or mechanism.speed_unit
    except InputError as error:
        raise error.within("crank_speeds") from error


def in_unit(speeds: FloatArray, unit: str) -> FloatArray:
    """Numbers (S,) of crank speeds (S,) in a unit, without the round-off of the conversion."""
    return np.array([float(f"{from_si(speed, unit):.15g}") for speed in np.ravel(speeds).tolist()])


def own_speeds(mechanism: Mechanism, usual: Callable[[Mechanism], FloatArray]) -> Speeds:
    """The speeds of a mechanism where none are asked for, or its drive, with a remark.

    Parameters
    ----------
    mechanism : Mechanism
    usual : callable
        Takes the mechanism, and gives the speeds in rad/s that are usual.

    Returns
    -------
    Speeds

    Raises
    ------
    InputError
        If the mechanism names no speed at which it turns.
    """
    unit, drive = mechanism.speed_unit, mechanism.drive
    if isinstance(usual, UsualSpeeds) and usual.or_drive and drive is not None:
        return Speeds((), unit, f"drive of the model file: {drive.words}", drive)
    speeds = usual(mechanism)
    return Speeds(tuple(in_unit(speeds, unit)), unit, speeds_taken(mechanism, speeds))


def speeds_taken(mechanism: Mechanism, speeds: FloatArray) -> str:
    """Crank speeds that were taken where none were asked for, in one line.

    Parameters
    ----------
    mechanism : Mechanism
    speeds : ndarray
        In rad/s.

    Returns
    -------
    str

    Examples
    --------
    >>> from flexmech.analyses.crank_speeds import speeds_taken
    >>> from flexmech.crank_values import CAMPBELL
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> speeds_taken(mechanism, CAMPBELL(mechanism))
    'speeds of the model file: 0 to 30 rad/s'
    """
    unit = mechanism.speed_unit
    texts = [f"{number:.{_DIGITS}g}" for number in in_unit(np.sort(speeds), unit)]
    if len(texts) > _MOST_SPEEDS:
        listed = f"{texts[0]} to {texts[-1]} {unit}"
    else:
        listed = f"{' and '.join([', '.join(texts[:-1]), texts[-1]][len(texts) == 1 :])} {unit}"
    if not any(mechanism.operating_speeds):
        return f"speeds, for the model names none: {listed}"
    return f"speed{'s' * (len(texts) > 1)} of the model file: {listed}"
