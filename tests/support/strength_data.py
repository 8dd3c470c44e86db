"""A mechanism whose plies have strengths, and what its strength looks like."""

from __future__ import annotations

from dataclasses import replace

import xarray as xr

from flexmech import Mechanism, PlyStrength, load_mechanism, strength
from tests.support.command import MODELS

STRENGTH = PlyStrength(1500e6, 1200e6, 40e6, 246e6, 68e6, 90e6, 0.35, 0.30)


def with_strengths(mechanism: Mechanism) -> Mechanism:
    """The mechanism with strengths for all plies of its links."""
    sections = {}
    for link, section in mechanism.sections.items():
        assert section.layers is not None
        layers = tuple(
            replace(layer, ply=replace(layer.ply, strength=STRENGTH))
            for layer in section.layers.laminate.layers
        )
        laminate = replace(section.layers.laminate, layers=layers)
        sections[link] = replace(section, layers=section.layers.resized(laminate, 1.0))
    return replace(mechanism, sections=sections)


def composite() -> Mechanism:
    """The composite four-bar with strengths for its plies."""
    return with_strengths(load_mechanism(MODELS / "composite_fourbar.toml"))


def strength_dataset() -> xr.Dataset:
    """Strength of the composite four-bar at 950 rpm."""
    return strength(composite(), 950.0, speed_unit="rpm").dataset
