"""Commented model files to start from."""

from __future__ import annotations

from flexmech.errors import InputError, suggestion

_HEAD = """# A model file of flexmech. Every value with a dimension is text with its unit;
# mm, cm, m, inch, GPa, MPa, psi, kg, g, lb, rpm, rad/s, Hz, ms and their like are understood.
# Lines that begin with # are comments: remove the # to use what they show.
# 'flexmech check FILE' prints what was understood.

name = "{name}"
source = "say where the numbers come from: a publication, a drawing, a measurement"
notes = ""
"""

_MATERIAL = """
[materials.aluminium]
youngs_modulus = "70 GPa"
density = "2700 kg/m^3"
poisson_ratio = 0.33
# Kelvin-Voigt damping, in one of two ways; a link may state its own, which then counts:
# damping_time = "2e-5 s"
# or
# damping_ratio = "0.5 %"
# damping_frequency = "50 Hz"
# What heat does to it; resins may state what water does too (see composite-four-bar):
# thermal_expansion = "23e-6 1/K"
"""

_FOUR_BAR = (
    """
[linkage]
kind = "four-bar"      # ground pivots O2 and O4, crank O2-A, coupler A-B, rocker O4-B
ground = "254 mm"
crank = "100 mm"
coupler = "280 mm"
rocker = "265 mm"
branch = "open"        # "open": B above at crank angle zero; "crossed": B below
# coupler_point = { distance = "80 mm", angle = "30 deg" }   # from A, and from A-B to the left
# ground_thermal_expansion = "11.7e-6 1/K"                   # of the frame
"""
    + _MATERIAL
    + """
# One table for each link: crank, coupler, rocker.
[links.crank]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "4 mm"      # in the plane of the linkage: h in I = b h^3 / 12
out_of_plane_width = "25 mm"     # along the joint axes: b

[links.coupler]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "2 mm"
out_of_plane_width = "25 mm"

# Any number of point masses, at a distance from the link's first joint (here A):
# [[links.coupler.point_masses]]
# position = "140 mm"
# mass = "10 g"

[links.rocker]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "2 mm"
out_of_plane_width = "25 mm"

# Or a section by its stiffness and mass per length, without a material:
# section = "general"
# axial_stiffness = "3.5e6 N"          # EA
# bending_stiffness = "1.2 N m^2"      # EI
# shear_stiffness = "1.1e6 N"          # kGA, with the shear correction factor k
# mass_per_length = "0.135 kg/m"       # rho A
# rotary_inertia = "4.5e-8 kg m"       # rho I
# in_plane_thickness = "2 mm"

# Point masses at the joints O2, A, B, O4, such as bearings:
# [joints.A]
# mass = "20 g"

[environment]
gravity = ["0 m/s^2", "0 m/s^2"]       # along x (from O2 to O4) and y

[operation]
crank_speeds = ["10 rad/s", "300 rpm"]
"""
)

_ROTATING_ARM = (
    """
[linkage]
kind = "rotating-arm"  # one link clamped to a hub that turns about O2
length = "300 mm"      # from the clamp to the free end
hub_radius = "20 mm"   # from the axis to the clamp
"""
    + _MATERIAL
    + """
[links.arm]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"      # in the plane of the rotation: h in I = b h^3 / 12
out_of_plane_width = "25 mm"     # along the axis: b

# Or a section by its stiffness and mass per length, without a material:
# section = "general"
# axial_stiffness = "5.25e6 N"         # EA
# bending_stiffness = "3.9375 N m^2"   # EI
# shear_stiffness = "1.7e6 N"          # kGA, with the shear correction factor k
# mass_per_length = "0.2025 kg/m"      # rho A
# rotary_inertia = "1.5e-7 kg m"       # rho I
# in_plane_thickness = "3 mm"

# Any number of point masses, at a distance from the clamp:
# [[links.arm.point_masses]]
# position = "300 mm"
# mass = "10 g"

[environment]
gravity = ["0 m/s^2", "0 m/s^2"]       # along x and y

[operation]
crank_speeds = ["10 rad/s", "300 rpm"]
"""
)

_DRAWN_LINKS = """
# Joints are pins where nothing else is said. The clamp is the drive: one ground point exactly.
[joints.O2]
kind = "clamp"
"""

_SLIDER_CRANK = (
    """
[linkage]
kind = "planar"        # any planar linkage, drawn once
drawn_at = "90 deg"    # crank angle of the coordinates below
ground = ["O2"]        # points that do not move

[linkage.points]       # x and y
O2 = ["0 mm", "0 mm"]
A = ["0 mm", "60 mm"]
B = ["190 mm", "0 mm"]
"""
    + _MATERIAL
    + """
# One table for each link, with the points at its two ends.
[links.crank]
points = ["O2", "A"]
rigid = true           # mass and inertia, but does not bend; or give it a section as the rod has
mass = "0.3 kg"
inertia = "2e-4 kg m^2"          # about its centre of mass
centre = "25 mm"                 # from its first point; its middle if left out

# A counterweight, hub or the like; offset of its centre of mass along and across the link:
# [[links.crank.bodies]]
# position = "0 mm"
# mass = "0.2 kg"
# inertia = "5e-5 kg m^2"
# offset = ["-30 mm", "0 mm"]

[links.rod]
points = ["A", "B"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "8 mm"      # in the plane of the linkage: h in I = b h^3 / 12
out_of_plane_width = "12 mm"     # along the joint axes: b
"""
    + _DRAWN_LINKS
    + """
[joints.B]
kind = "slider"
direction = "0 deg"              # of its line, to the ground's x axis
mass = "0.15 kg"                 # of the slider

# What is on the drive, acts on links, or is between points:
# [shaft]
# inertia = "1e-4 kg m^2"
#
# [loads.gas]
# point = "B"
# over = "crank_angle"
# table = [["0 deg", "-200 N", "0 N"], ["90 deg", "-20 N", "0 N"], ["270 deg", "0 N", "0 N"]]
#
# [springs.return]
# points = ["B", ["300 mm", "0 mm"]]
# stiffness = "200 N/m"
# free_length = "80 mm"

[environment]
gravity = ["0 m/s^2", "0 m/s^2"]       # along x and y

[operation]
crank_speeds = ["10 rad/s", "300 rpm"]
"""
)

_PLANAR = (
    """
[linkage]
kind = "planar"        # any planar linkage, drawn once
drawn_at = "60 deg"    # crank angle of the coordinates below
ground = ["O2", "O4", "O6"]

[linkage.points]       # x and y; links that share a point are pinned there
O2 = ["0 mm", "0 mm"]
A = ["50 mm", "86.6 mm"]
B = ["263.8 mm", "266.5 mm"]
O4 = ["254 mm", "0 mm"]
C = ["281.3 mm", "168.1 mm"]
D = ["473.2 mm", "400 mm"]
O6 = ["300 mm", "500 mm"]
"""
    + _MATERIAL
    + """
[links.crank]
points = ["O2", "A"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "5 mm"      # in the plane of the linkage: h in I = b h^3 / 12
out_of_plane_width = "25 mm"     # along the joint axes: b

[links.coupler]
points = ["A", "B", "C"]         # a chain: beams "coupler-1" and "coupler-2", welded at B
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"
out_of_plane_width = "25 mm"

[links.rocker]
points = ["O4", "B"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"
out_of_plane_width = "25 mm"

[links.connector]
points = ["C", "D"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"
out_of_plane_width = "25 mm"

[links.output]
points = ["O6", "D"]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "3 mm"
out_of_plane_width = "25 mm"
"""
    + _DRAWN_LINKS
    + """
# Other joints:
# [joints.D]
# kind = "weld"                  # keeps the angle between the links that meet there
# kind = "slider"                # stays on a line, by its direction to the ground or to guide
# direction = "0 deg"
# guide = "output"               # a rigid link that does not pass through the point
# mass = "15 g"
# torsional_stiffness = "0.2 N m/rad"   # of a pin, with free_angle and torsional_damping

[environment]
gravity = ["0 m/s^2", "0 m/s^2"]       # along x and y

[operation]
crank_speeds = ["10 rad/s", "20 rad/s"]
"""
)

_COMPOSITE_FOUR_BAR = """
[linkage]
kind = "four-bar"      # ground pivots O2 and O4, crank O2-A, coupler A-B, rocker O4-B
ground = "254 mm"
crank = "100 mm"
coupler = "280 mm"
rocker = "265 mm"

# Plies by their constituents. Published ones: E-glass, carbon, polyester (Elamy et al. 2023).
[fibres.T300]
youngs_modulus = "230 GPa"
transverse_modulus = "15 GPa"
shear_modulus = "15 GPa"
transverse_shear_modulus = "7 GPa"
density = "1760 kg/m^3"
poisson_ratio = 0.2

[matrices.epoxy]
youngs_modulus = "4.0 GPa"
shear_modulus = "1.48 GPa"
density = "1260 kg/m^3"
poisson_ratio = 0.35
specific_damping = "8 %"         # energy lost in a cycle over its largest
# What heat and water do to it; what is left out, they do not do:
thermal_expansion = "55e-6 1/K"
moisture_expansion = "3e-3 1/percent"    # strain per moisture, in percent of its dry mass
equilibrium_moisture = "5 percent"       # in the end at 100 % relative humidity
glass_transition = "200 degC"            # dry; lower when wet, and the resin softens towards it
diffusivity = "5e-13 m^2/s"              # of water in it
diffusivity_temperature = "20 degC"
activation_energy = "45 kJ/mol"

[plies.C]
type = "constituents"
fibre = "T300"
matrix = "epoxy"
fibre_volume_fraction = "60 %"
rule = "chamis"                  # or "halpin-tsai", "rule-of-mixtures"
weave = "unidirectional"         # or "woven"
thickness = "0.5 mm"

# Or by measured constants:
[plies.G]
type = "orthotropic"
longitudinal_modulus = "37.8 GPa"
transverse_modulus = "10.9 GPa"
in_plane_shear_modulus = "4.9 GPa"
poisson_ratio = 0.29
density = "1814 kg/m^3"
longitudinal_damping = "0.87 %"
transverse_damping = "5.05 %"
shear_damping = "6.91 %"
thickness = "0.5 mm"

# Layers lie in the plane of the linkage, the first one at the lowest y of the link's frame
# (to the right when looking from the link's first joint to its second). After @ stands the
# angle of the fibres to the link's axis in degrees, after * how often the layer is repeated;
# a final s mirrors the stack.
[laminates.skin_and_core]
stacking = "[C@0*2/C@45/C@-45/G*2]s"
# ply_thickness = "0.5 mm"       # instead of that of the plies

[links.crank]
section = "laminate"
laminate = "skin_and_core"
out_of_plane_width = "25 mm"     # along the joint axes
reduction = "narrow"             # "wide": held from contracting along the joint axes
# damping_frequency = "50 Hz"    # runs in time take the plies' specific damping at this frequency
# exposed_faces = "both"         # where water comes in: or "lower", "upper" (of the link's y)
# exposed_sides = false          # and along the joint axes

[links.coupler]
section = "laminate"
laminate = "skin_and_core"
out_of_plane_width = "25 mm"

[links.rocker]
section = "laminate"
laminate = "skin_and_core"
out_of_plane_width = "25 mm"

[operation]
crank_speeds = ["10 rad/s", "300 rpm"]
"""

_TEMPLATES = {
    "four-bar": _HEAD.format(name="my four-bar") + _FOUR_BAR,
    "composite-four-bar": _HEAD.format(name="my composite four-bar") + _COMPOSITE_FOUR_BAR,
    "rotating-arm": _HEAD.format(name="my rotating arm") + _ROTATING_ARM,
    "slider-crank": _HEAD.format(name="my slider-crank") + _SLIDER_CRANK,
    "planar": _HEAD.format(name="my six-bar") + _PLANAR,
}

KINDS = tuple(_TEMPLATES)
"""Kinds of linkages that a model file can describe."""


def template(kind: str) -> str:
    """Give a commented model file that loads without change.

    Parameters
    ----------
    kind : str
        One of :data:`KINDS`.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If the kind is unknown.
    """
    if kind not in _TEMPLATES:
        raise InputError(f"unknown kind of linkage {kind!r}; {suggestion(kind, list(KINDS))}")
    return _TEMPLATES[kind]
