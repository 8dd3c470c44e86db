"""The pictures that a command writes: in which formats, and how wide."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.choices import PICTURE_FORMATS, PageWidth, PictureFormat
from flexmech.errors import InputError


@dataclass(frozen=True)
class Pictures:
    """What pictures a command writes.

    Parameters
    ----------
    formats : tuple of {"png", "pdf", "svg"}
        Empty where none are wanted.
    width : {"one-column", "two-column"}
        Of a journal's page.
    """

    formats: tuple[PictureFormat, ...] = ("png",)
    width: PageWidth = "two-column"

    def __bool__(self) -> bool:
        return bool(self.formats)


def plain_style() -> None:
    """Leave out what a ``matplotlibrc`` of the user sets, such as text by a TeX that is not there.

    The pictures of a command are the same on all machines.
    """
    import matplotlib

    matplotlib.rcdefaults()


PNG = Pictures()
"""What is written unless something else is asked for."""


def asked_pictures(no_plots: bool, formats: str, width: PageWidth) -> Pictures:
    """Pictures of ``--no-plots``, ``--format`` and ``--width``.

    Parameters
    ----------
    no_plots : bool
    formats : str
        Comma list such as ``"pdf,svg"``.
    width : {"one-column", "two-column"}

    Returns
    -------
    Pictures

    Raises
    ------
    InputError
        If a format is none that pictures are written in.
    """
    asked = [each.strip().lower().removeprefix(".") for each in formats.split(",")]
    found = tuple(known for known in PICTURE_FORMATS if known in asked)
    for each in asked:
        if each not in PICTURE_FORMATS:
            known = ", ".join(PICTURE_FORMATS)
            raise InputError(
                f"--format: got {formats!r}, in which {each!r} is no format of pictures; choose "
                f"from {known}, as in --format pdf,svg"
            )
    return Pictures(() if no_plots else found, width)
