"""Sections of random sandwiches and laminates for :mod:`tests.support.random_planar_mechanisms`."""

from __future__ import annotations

import numpy as np

from flexmech import BeamSection, Laminate, LaminateSection, Material, Ply, ply_from_constituents
from flexmech.linkages import Link
from flexmech.materials import Fibre, Hygrothermal, Layer, Matrix
from flexmech.materials.moisture import Diffusivity, MoistureEquilibrium
from tests.support.random_mechanisms import log_uniform

SATURATION = 0.05


def resin(random: np.random.Generator) -> Hygrothermal:
    """It swells and softens, and takes up water within weeks."""
    dry = random.uniform(40e-6, 70e-6)
    return Hygrothermal(
        thermal_expansion=dry,
        wet_thermal_expansion=dry * random.uniform(1.0, 1.3),
        moisture_expansion=random.uniform(0.1, 0.4),
        equilibrium=MoistureEquilibrium(SATURATION, random.uniform(0.8, 1.5)),
        diffusivity=Diffusivity(log_uniform(random, 1e-13, 1e-12), 293.15, 45e3),
        glass_transition=random.uniform(440.0, 500.0),
    )


def neat_resin(random: np.random.Generator, link: Link) -> BeamSection:
    """A bar of one material."""
    material = Material(
        log_uniform(random, 3e9, 5e9),
        random.uniform(1100.0, 1400.0),
        random.uniform(0.3, 0.4),
        resin(random),
    )
    thickness = link.length * log_uniform(random, 1 / 50, 1 / 15)
    return BeamSection.rectangle(material, thickness, log_uniform(random, 5e-3, 40e-3))


def carbon_epoxy(random: np.random.Generator) -> Ply:
    fibre = Fibre(
        "carbon", random.uniform(150e9, 300e9), 15e9, 1780.0, 0.2, thermal_expansion=-0.5e-6
    )
    own = resin(random)
    matrix = Matrix(
        "epoxy",
        random.uniform(3e9, 5e9),
        random.uniform(1.2e9, 1.6e9),
        1265.0,
        0.37,
        thermal_expansion=own.thermal_expansion,
        moisture_expansion=own.moisture_expansion,
        wet_thermal_expansion=own.wet_thermal_expansion,
        equilibrium=own.equilibrium,
        diffusivity=own.diffusivity,
        glass_transition=own.glass_transition,
    )
    return ply_from_constituents(fibre, matrix, random.uniform(0.4, 0.6))


def laminate(random: np.random.Generator, link: Link) -> BeamSection:
    """Carbon and epoxy; a third of the stacks is not symmetric, so that the pins are off the axis.

    Their twist is free: ends that hold it are of the reference engine alone.
    """
    ply, count = carbon_epoxy(random), int(random.integers(3, 6))
    angles = np.radians(random.choice([0.0, 0.0, 30.0, 45.0, -45.0, 90.0], count))
    angles[0] = 0.0
    if random.random() < 2 / 3:
        angles = np.concatenate([angles, angles[::-1]])
    thickness = link.length * log_uniform(random, 1 / 50, 1 / 20)
    layers = tuple(Layer(ply, thickness / len(angles), float(angle)) for angle in angles)
    return BeamSection.of_laminate(
        LaminateSection(Laminate(layers), log_uniform(random, 1e-2, 4e-2), twist="free")
    )


def sandwich(random: np.random.Generator, link: Link) -> BeamSection:
    """Carbon faces on a foam of their resin, whose shear lowers frequencies by a tenth and more."""
    face, thickness = carbon_epoxy(random), link.length * log_uniform(random, 1 / 30, 1 / 15)
    stuff = log_uniform(random, 1e8, 1e9), random.uniform(60.0, 200.0), 0.3
    assert face.resin is not None
    foam = Ply.isotropic(Material(*stuff, face.resin.hygrothermal))
    part = random.uniform(0.05, 0.15) * thickness
    layers = (Layer(face, part), Layer(foam, thickness - 2 * part), Layer(face, part))
    return BeamSection.of_laminate(
        LaminateSection(Laminate(layers), log_uniform(random, 1e-2, 4e-2))
    )
