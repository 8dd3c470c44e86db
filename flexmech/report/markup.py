"""Texts on their way into a page: names stay text, equations get their indices."""

from __future__ import annotations

import json
import re
from html import escape
from typing import Any

# What would end a script element or is no character of JSON in old scripts.
ESCAPES = {
    ord("<"): "\\u003c",
    ord(">"): "\\u003e",
    ord("&"): "\\u0026",
    0x2028: "\\u2028",
    0x2029: "\\u2029",
}


def json_text(content: Any) -> str:
    r"""JSON that is text wherever it stands in a page: no name in it ends an element.

    Parameters
    ----------
    content : object
        Of lists, dicts, texts, finite numbers and None.

    Returns
    -------
    str

    Examples
    --------
    >>> json_text({"name": "</script>"})
    '{"name":"\\u003c/script\\u003e"}'
    """
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.translate(ESCAPES)


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()

    def __html__(self) -> str:
        """Itself, for templates that escape all other text."""
        return str(self)


def equation_markup(text: str) -> Markup:
    """An equation with ``_x`` or ``_{xy}`` lowered and ``^{xy}`` raised.

    Parameters
    ----------
    text : str

    Returns
    -------
    Markup

    Examples
    --------
    >>> print(equation_markup("K_g < e^{λt}"))
    K<sub>g</sub> &lt; e<sup>λt</sup>
    """
    lowered = re.sub(r"_(?:\{([^}]*)\}|(\w))", _element("sub"), escape(text))
    return Markup(re.sub(r"\^(?:\{([^}]*)\}|(\w))", _element("sup"), lowered))


def _element(name: str) -> Any:
    return lambda found: f"<{name}>{found[1] or found[2]}</{name}>"
