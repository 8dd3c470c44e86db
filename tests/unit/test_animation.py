"""Animations hold the stored motion, enlarged as stated, and can be played."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text
from PIL import Image

from flexmech.errors import InputError
from flexmech.linkages import FourBar, Linkage, RotatingArm
from flexmech.plots import animation
from flexmech.plots.animation import mp4_available, write_animation
from flexmech.plots.style import SERIES_STYLES

STATIONS = np.linspace(0.0, 1.0, 21)
FOURBAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
ARM = RotatingArm(length=0.4, hub_radius=0.025)
GREATEST = 1e-3


def response_dataset(
    linkage: Linkage = FOURBAR, turns: float = 1.0, samples: int = 33
) -> xr.Dataset:
    """Dataset by the schema of Response, with bows of at most 1 mm and twice that in exudyn."""
    angle = np.linspace(0.0, 2 * np.pi * turns, samples)
    position = np.array([rigid_positions(linkage, theta) for theta in angle])
    along = position[:, :, -1] - position[:, :, 0]
    normal = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    bow = GREATEST * np.sin(np.pi * STATIONS) * np.cos(5 * angle)[:, None]
    displacement = bow[:, None, :, None] * normal[:, :, None, :]
    names = list(linkage.links)
    return xr.Dataset(
        {
            "rigid_position": (("time", "link", "station", "component"), position),
            "displacement": (
                ("engine", "time", "link", "station", "component"),
                np.stack([displacement, 2 * displacement]),
            ),
        },
        coords={
            "engine": ["reference", "exudyn"],
            "element": ("engine", ["euler", "ancf"]),
            "time": angle / 20.0,
            "crank_angle": ("time", angle),
            "link": names,
            "probe": ("link", ["tip"] + ["middle"] * (len(names) - 1)),
            "station": STATIONS,
            "component": ["x", "y"],
        },
        attrs={"mechanism": "test linkage", "crank_speed": 20.0},
    )
