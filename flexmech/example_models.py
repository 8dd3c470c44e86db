"""Model files that come with flexmech: the linkages of the papers, and examples.

They are the folder ``models`` of the repository. A wheel carries it inside the package; where
flexmech runs from the repository, as an editable install does, it lies beside the package.
"""

from __future__ import annotations

from functools import cache
from importlib import resources
from pathlib import Path

from flexmech.errors import InputError, suggestion


@cache
def _folder() -> Path:
    package = Path(str(resources.files("flexmech")))
    inside = package / "models"
    return inside if inside.is_dir() else package.parent / "models"


def example_names() -> tuple[str, ...]:
    """Names of all model files that come with flexmech, in their order.

    Examples
    --------
    >>> flexmech.example_names()[0]
    'aluminium_fourbar'
    """
    return tuple(sorted(path.stem for path in _folder().glob("*.toml")))


def example_model(name: str) -> Path:
    """Model file that comes with flexmech.

    Parameters
    ----------
    name : str
        One of :func:`example_names`, such as ``"aluminium_fourbar"``.

    Returns
    -------
    Path
        For :func:`flexmech.load_mechanism`.

    Raises
    ------
    InputError
        If there is no such example.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism(flexmech.example_model("aluminium_fourbar"))
    >>> mechanism.linkage.crank
    0.102
    """
    known = example_names()
    if not isinstance(name, str):
        raise InputError(f"name must be that of an example, got {name!r}; use {known[0]!r}")
    if name not in known:
        raise InputError(f"there is no example {name!r}; {suggestion(name, known)}")
    return _folder() / f"{name}.toml"
