"""What a result came from: model file, engines and versions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib.metadata import version

from flexmech.linear_system import Engine

__all__ = ["provenance"]


@cache
def _version(package: str) -> str:
    return version(package)


def provenance(engines: Sequence[Engine]) -> dict[str, str | int]:
    """Attributes that every result carries.

    Parameters
    ----------
    engines : sequence of Engine
        All of one mechanism.

    Returns
    -------
    dict
    """
    source = engines[0].mechanism.provenance
    packages = ["flexmech", "numpy", "scipy"]
    packages += ["exudyn"] if any(e.name == "exudyn" for e in engines) else []
    return {
        "mechanism": source.name,
        "source": source.source,
        "model_file": source.file,
        "model_sha256": source.sha256,
        "elements": engines[0].elements,
        **{f"{name}_version": _version(name) for name in packages},
    }
