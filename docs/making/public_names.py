"""The reference of the public Python names, from their docstrings."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import flexmech

__all__ = ["public_name_page"]

HEAD = """# Python

All of this is `import flexmech`, and nothing is loaded before it is used. Angles are rad, speeds
rad/s and all else SI units; units of other kinds live in model files and on the command line. A
result is a frozen object around an `xarray.Dataset` (`result.dataset`) with named dimensions and
units, which saves, loads back equal, exports CSV, and draws itself (`result.plot()`).

"""
Rule = Callable[[str, Any], bool]


def _is_result(_: str, thing: Any) -> bool:
    return inspect.isclass(thing) and issubclass(thing, flexmech.Result)


def _is_error(_: str, thing: Any) -> bool:
    return inspect.isclass(thing) and issubclass(thing, Exception)


def _comes_from(*rooms: str) -> Rule:
    def rule(_: str, thing: Any) -> bool:
        room = str(getattr(thing, "__module__", "")).removeprefix("flexmech.").partition(".")[0]
        return room in rooms

    return rule


# The first rule that a name meets decides where it stands.
SECTIONS: dict[str, Rule] = {
    "Results": _is_result,
    "Errors": _is_error,
    "Questions": _comes_from("analyses", "studies", "verification", "report"),
    "Engines": _comes_from("reference", "multibody"),
    "Mechanisms and linkages": _comes_from(
        "mechanism", "linkages", "modelfile", "example_models", "mechanics", "solvers"
    ),
    "Measured records": _comes_from("measured_data"),
    "Sections and materials": _comes_from("sections", "materials"),
    "Heat and moisture": _comes_from("hygrothermal"),
}
QUESTIONS_FIRST = ("Questions", "Results")


def public_name_page() -> str:
    """Markdown with one autodoc directive for each public name."""
    placed: dict[str, list[str]] = {title: [] for title in SECTIONS}
    for name in sorted(flexmech.__all__, key=str.lower):
        thing = getattr(flexmech, name)
        if inspect.ismodule(thing) or isinstance(thing, str):
            continue
        for title, rule in SECTIONS.items():
            if rule(name, thing):
                placed[title].append(name)
                break
        else:
            raise ValueError(f"no section of docs/making/public_names.py takes flexmech.{name}")
    rest = [title for title in SECTIONS if title not in QUESTIONS_FIRST]
    parts = [HEAD]
    for title in [*QUESTIONS_FIRST, *rest]:
        parts += [f"## {title}\n", *(_directive(name) for name in placed[title])]
    return "\n".join(parts)


def _directive(name: str) -> str:
    thing = getattr(flexmech, name)
    if inspect.isclass(thing):
        kind, options = "autoclass", ":members:\n:inherited-members: Exception, object\n"
    else:
        kind, options = "autofunction", ""
    return (
        f"```{{eval-rst}}\n.. {kind}:: flexmech.{name}\n"
        + "".join(f"   {line}\n" for line in options.splitlines())
        + "```\n"
    )
