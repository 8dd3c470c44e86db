"""Inertial terms of rotating frames, and the system matrices that contain them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import ROTATION_TERMS
from flexmech.errors import InputError
from flexmech.validation import check_flag, check_instance

# All terms or none of them in one word, as users write it and as results have it.
_WHOLE = {"all": True, "on": True, "none": False, "off": False}
_KNOWN = f"all, none, or a comma list of {', '.join(ROTATION_TERMS)}"


@dataclass(frozen=True)
class RotationTerms:
    """Selection of the inertial terms of the rotating frames.

    They are those of the right-hand side of Turcic & Midha's equation (Kumar & Chandrakar,
    eq. 1.57); the geometric stiffness, its left-hand side, is chosen by the prestress.

    Parameters
    ----------
    coriolis : bool
        Velocity-proportional terms: ``2 M_d`` and ``2 M_vel``, and ``N'D Ndot``, which damped
        links add to the stiffness where a pin turns.
    centripetal : bool
        Terms in squares and products of angular velocities: ``M_acc``, ``M_dd``,
        ``2 M_d,vel``.
    tangential : bool
        Terms in angular accelerations of ``M_acc`` and ``M_dd``.

    Raises
    ------
    InputError
        If one is neither True nor False.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> alone = flexmech.RotationTerms.parse("coriolis")
    >>> flexmech.natural_frequencies(engine, 0.0, 20.0, modes=2, rotation_terms=alone).round(2)
    array([45.14, 47.69])
    """

    coriolis: bool = True
    centripetal: bool = True
    tangential: bool = True

    def __post_init__(self) -> None:
        for name in ROTATION_TERMS:
            check_flag(getattr(self, name), name)

    @classmethod
    def all_or_none(cls, wanted: bool) -> RotationTerms:
        """All terms, or the frozen inertial form."""
        return cls(wanted, wanted, wanted)

    @classmethod
    def of(cls, wanted: bool | RotationTerms) -> RotationTerms:
        """All terms, none of them, or a selection, as arguments ``rotation_terms`` have it.

        Parameters
        ----------
        wanted : bool or RotationTerms

        Returns
        -------
        RotationTerms

        Raises
        ------
        InputError
            If it is neither.
        """
        if isinstance(wanted, cls):
            return wanted
        if not isinstance(wanted, bool | np.bool_):
            raise InputError(
                f"rotation_terms must be True, False or RotationTerms, got {wanted!r}; some of "
                'them are flexmech.RotationTerms.parse("coriolis,tangential")'
            )
        return cls.all_or_none(bool(wanted))

    @classmethod
    def parse(cls, text: str) -> RotationTerms:
        """Read ``all``, ``none`` or a comma list, as the command line has it.

        Parameters
        ----------
        text : str
            ``on`` and ``off``, which results have in their attribute ``rotation_terms``, are
            ``all`` and ``none``.

        Returns
        -------
        RotationTerms

        Raises
        ------
        InputError
            If a word is none of these; lists those that there are.

        Examples
        --------
        >>> flexmech.RotationTerms.parse("coriolis, tangential")
        RotationTerms(coriolis=True, centripetal=False, tangential=True)
        """
        check_instance(text, str, "rotation_terms", f"write {_KNOWN}")
        asked = [term.strip().lower() for term in text.split(",")]
        if len(asked) == 1 and asked[0] in _WHOLE:
            return cls.all_or_none(_WHOLE[asked[0]])
        for term in asked:
            if term not in ROTATION_TERMS:
                raise InputError(
                    f"got {text!r}, in which {term!r} is no rotation term; write {_KNOWN}"
                )
        return cls(*(name in asked for name in ROTATION_TERMS))

    def __str__(self) -> str:
        chosen = [name for name in ROTATION_TERMS if getattr(self, name)]
        if len(chosen) in (0, len(ROTATION_TERMS)):
            return "on" if chosen else "off"
        return ",".join(chosen)

    @property
    def any(self) -> bool:
        """Whether any term is included."""
        return self.coriolis or self.centripetal or self.tangential


@dataclass(frozen=True)
class SystemMatrices:
    """Mass, damping and stiffness over a batch; each of shape (B, n, n)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
