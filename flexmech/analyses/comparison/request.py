"""What a comparison with a record is asked to be."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from flexmech.analyses.crank_speeds import one_rad_per_s
from flexmech.errors import InputError
from flexmech.validation import check_angle, check_instance, checked_tuple


@dataclass(frozen=True)
class ComparisonRequest:
    """How a record was taken, and what of the model is fitted to it.

    Parameters
    ----------
    speed : float, optional
        Crank speed in ``speed_unit`` at which the record was taken; 0 for natural frequencies at
        rest.
    angle : float, optional
        Crank angle in rad at which the crank was locked, for a frequency-response function.
        One of the two.
    quantity : str, optional
        What is computed: a column of ``response.csv`` over time, such as
        ``"coupler_mid_strain"``; for a frequency-response function the points of impact and
        response, such as ``"coupler:0.5"`` or ``"coupler:0.5,rocker:0.5"``, behind the
        function's name and an @ where the record holds several. Left out: what the record's own
        column names.
    fit : sequence of str, optional
        Any of ``"damping"``, ``"damping:LINK"``, ``"stiffness:LINK"``, ``"offset"`` and
        ``"gain"``, or ``"none"``. Left out: ``damping`` over time, ``damping`` and ``gain`` for a
        frequency-response function, nothing for natural frequencies.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which results speak of it. Left out: rad/s.

    Raises
    ------
    InputError
        If a value is impossible, or not one of speed and angle is given.

    Examples
    --------
    >>> flexmech.ComparisonRequest(speed=20.0, fit=("damping", "stiffness:coupler")).fit
    ('damping', 'stiffness:coupler')
    """

    speed: float | None = None
    angle: float | None = None
    quantity: str | None = None
    fit: tuple[str, ...] | None = None
    speed_unit: str | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if (self.speed is None) == (self.angle is None):
            raise InputError(
                "a comparison needs either the crank speed at which the record was taken, or the "
                "angle at which the crank was locked; give one of speed and angle"
            )
        _ = self.crank_speed
        if self.angle is not None:
            check_angle(self.angle, "angle")
        if self.quantity is not None:
            check_instance(self.quantity, str, "quantity", "write the name of a column")
        if self.fit is not None:
            remedy = "it must be a tuple of names, as ('damping',), or ('none',) to fit nothing"
            object.__setattr__(self, "fit", checked_tuple(self.fit, str, "fit", remedy))
            if not self.fit:
                raise InputError(f"fit is empty; {remedy}")

    @cached_property
    def crank_speed(self) -> float | None:
        """Crank speed in rad/s."""
        speed = self.speed
        return None if speed is None else one_rad_per_s(speed, self.speed_unit, "speed")
