"""What a page holds as text: numbers, JSON, equations and plotly.js; none ends an element."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# What would end a script element or is no character of JSON in old scripts.
ESCAPES = {
    ord("<"): "\\u003c",
    ord(">"): "\\u003e",
    ord("&"): "\\u0026",
    0x2028: "\\u2028",
    0x2029: "\\u2029",
}

# Where the bundle registers every kind of plot beyond lines and points, which its core has.
REGISTERED = re.compile(r"\.register\(\[(?:[\w$]+\(\),){20,}[\w$]+\(\)\]\)")

# Words that a column of a narrow screen does not hold.
LONG = re.compile(r"\S{17,}")


class Arrays:
    """Arrays of a page, each once; what shows them refers to them by number."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self.encoded: list[str] = []
        """Little-endian numbers of 4 bytes, as text by base64."""

    def add(self, values: ArrayLike) -> int:
        """Keep an array, and give its number."""
        content = np.asarray(values, dtype="<f4").tobytes()
        if content not in self._numbers:
            self._numbers[content] = len(self.encoded)
            self.encoded.append(b64encode(content).decode("ascii"))
        return self._numbers[content]


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


def breakable_markup(text: str) -> str:
    """A text whose long words, as those of a layup, are broken after a stroke.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> breakable_markup("crank: [U@45*2/U@-45*2/U*4]s at 20 rad/s")
    'crank: [U@45*2/<wbr>U@-45*2/<wbr>U*4]s at 20 rad/s'
    """
    # As templates escape all else; it comes with jinja2.
    from markupsafe import escape as escaped

    return LONG.sub(lambda word: word[0].replace("/", "/<wbr>"), str(escaped(text)))


def equation_markup(text: str) -> str:
    """An equation with ``_x`` or ``_{xy}`` lowered and ``^{xy}`` raised.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> equation_markup("K_g < e^{λt}")
    'K<sub>g</sub> &lt; e<sup>λt</sup>'
    """
    lowered = re.sub(r"_(?:\{([^}]*)\}|(\w))", _element("sub"), escape(text))
    return re.sub(r"\^(?:\{([^}]*)\}|(\w))", _element("sup"), lowered)


def _element(name: str) -> Any:
    return lambda found: f"<{name}>{found[1] or found[2]}</{name}>"


def plotly_source() -> str:
    """Text of plotly.js, which ends no script element.

    Kinds of plots that the report does not draw (maps, surfaces) stay in the text and are not
    registered: a browser would run all of them before the first line is drawn, which takes more
    than half of its time. A bundle that registers them in another way is taken as it is.

    Returns
    -------
    str
    """
    from plotly.offline import get_plotlyjs

    source: str = get_plotlyjs()
    if len(REGISTERED.findall(source)) == 1:
        source = REGISTERED.sub(".register([])", source)
    return source.replace("</script", "<\\/script")
