"""plotly.js as a page carries it."""

from __future__ import annotations

import re

# Where the bundle registers every kind of plot beyond lines and points, which its core has.
REGISTERED = re.compile(r"\.register\(\[(?:[\w$]+\(\),){20,}[\w$]+\(\)\]\)")


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
