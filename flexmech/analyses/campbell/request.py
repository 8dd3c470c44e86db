"""What a Campbell diagram is asked to cover."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.requests import without_end
from flexmech.arrays import FloatArray, IntArray
from flexmech.crank_values import MOST_ORDER
from flexmech.errors import InputError
from flexmech.solvers.formulation import Formulation
from flexmech.validation import checked_array


@dataclass(frozen=True)
class CampbellRequest:
    """Crank speeds, crank angles and orders of a Campbell diagram.

    Parameters
    ----------
    crank_speeds : ndarray, shape (S,)
        rad/s; kept ascending.
    crank_angles : ndarray, shape (A,)
        Increasing, rad.
    orders : ndarray of int, shape (o,)
        Multiples of the crank's speed; kept ascending.
    formulation : Formulation
    shown_unit : str
        In which results speak of crank speeds.

    Raises
    ------
    InputError
        If angles do not increase or are degrees, a value is not finite, a speed or an order
        repeats, or an order is no whole number from 1 on.
    """

    crank_speeds: FloatArray
    crank_angles: FloatArray
    orders: IntArray
    formulation: Formulation
    shown_unit: str = "rad/s"

    def __post_init__(self) -> None:
        checked = FrequencyRequest(self.crank_angles, self.crank_speeds, self.formulation)
        object.__setattr__(self, "crank_speeds", np.sort(checked.crank_speeds))
        object.__setattr__(self, "crank_angles", checked.crank_angles)
        object.__setattr__(self, "orders", _checked_orders(self.orders))

    @property
    def full_turn(self) -> bool:
        """Whether the angles cover a full turn."""
        return FrequencyRequest(self.crank_angles, self.crank_speeds, self.formulation).full_turn

    @property
    def turn(self) -> FloatArray:
        """The crank angles, without the end of a full turn, which is its start again."""
        return without_end(self.crank_angles) if self.full_turn else self.crank_angles


def _checked_orders(values: ArrayLike) -> IntArray:
    """Orders as whole numbers, ascending."""
    orders = checked_array(values, "orders")
    if orders.ndim != 1 or not len(orders):
        raise InputError("orders must be a list of one whole number or more, such as [1, 2, 3]")
    wrong = orders[(orders != np.round(orders)) | (orders < 1) | (orders > MOST_ORDER)]
    if len(wrong):
        raise InputError(f"orders must be whole numbers from 1 to {MOST_ORDER}, got {wrong[0]:g}")
    if len(np.unique(orders)) != len(orders):
        raise InputError("orders repeats an order; give each one once")
    return np.sort(orders.astype(np.intp))
