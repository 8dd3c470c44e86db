"""The balanced model file: that of the mechanism with its counterweights."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from flexmech.analyses.balance.counterweights import Counterweight
from flexmech.errors import InputError
from flexmech.mechanism import Mechanism
from flexmech.modelfile.read import mechanism_from_toml


def balanced_text(
    mechanism: Mechanism, given: Mechanism, weights: Sequence[Counterweight], remark: str
) -> str:
    """Write a model file that loads back equal to the balanced mechanism.

    Parameters
    ----------
    mechanism : Mechanism
        With the counterweights.
    given : Mechanism
        Without them; its own file, comments included, is kept where it can be.
    weights : sequence of Counterweight
    remark : str
        What the counterweights are for, in a line.

    Returns
    -------
    str
        TOML.
    """
    tables = "".join(_table(weight) for weight in weights if weight.mass)
    name = f"name = {json.dumps(mechanism.provenance.name, ensure_ascii=False)}"
    own = re.sub(r"(?m)^name\s*=.*$", lambda _: name, given.provenance.text, count=1)
    text = f"{own.rstrip()}\n\n# {remark}{tables}"
    if given.provenance.text and _reads_as(text, mechanism):
        return text
    return f"# {remark}\n{mechanism.to_toml()}"


def _reads_as(text: str, mechanism: Mechanism) -> bool:
    """Whether a text is a model file of a mechanism.

    A file whose links stand in lines of their own takes no table at its end.
    """
    try:
        return mechanism_from_toml(text) == mechanism
    except InputError:
        return False


def _table(weight: Counterweight) -> str:
    """The counterweight as a table at the end of a model file."""
    name = weight.link.name
    key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)
    rows = (f"{key} = {json.dumps(value)}" for key, value in weight.body.to_table().items())
    return "\n".join([f"\n[[links.{key}.bodies]]", *rows, ""])
