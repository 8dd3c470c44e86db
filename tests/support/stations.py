"""Internal forces of two results at the places along links that both have."""

from __future__ import annotations

import numpy as np
import xarray as xr


def at_common_places(
    first: xr.Dataset, second: xr.Dataset, name: str
) -> list[tuple[np.ndarray, np.ndarray]]:
    """A force of both, of every link over (..., place); peaks of a link are at further places."""
    pairs = []
    for link in range(first.sizes["link"]):
        data = [each.isel(link=link) for each in (first, second)]
        places = [each["position"].values.round(9) for each in data]
        common = np.intersect1d(*(place[np.isfinite(place)] for place in places))
        assert len(common) >= 9
        one, other = (
            each[name].values[..., np.isin(place, common)]
            for each, place in zip(data, places, strict=True)
        )
        pairs.append((one, other))
    return pairs
