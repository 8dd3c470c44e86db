"""Choices by name: the words of requests, of engines and of command-line options.

They stand on the ground floor and import nothing, so that the command line can list them without
waiting for a library.
"""

from __future__ import annotations

from typing import Literal, get_args

EngineName = Literal["reference", "exudyn"]
EngineChoice = Literal[EngineName, "both"]
ReferenceElement = Literal["euler", "timoshenko", "reddy", "zigzag"]
ExudynElement = Literal["ancf", "geometrically-exact"]
ElementName = Literal[ReferenceElement, ExudynElement]
"""Beam elements of the two engines."""
ELEMENTS: dict[EngineName, tuple[ElementName, ...]] = {
    "reference": get_args(ReferenceElement),
    "exudyn": get_args(ExudynElement),
}
"""Elements of each engine: first the slender beam, then the one that shears as well."""

Prestress = Literal["none", "axial", "equilibrium"]
"""Quasi-static stress at which links are linearized."""
PRESTRESS_LEVELS: tuple[Prestress, ...] = get_args(Prestress)
MapPrestress = Literal["none", "axial", "equilibrium", "trajectory"]
"""With the states of the simulated, steady motion besides."""
RotationTerm = Literal["coriolis", "centripetal", "tangential"]
"""An inertial term of the turning link frames, in the order in which a split adds them."""
ROTATION_TERMS: tuple[RotationTerm, ...] = get_args(RotationTerm)
MovingFrame = Literal["link", "inertial"]
"""Axes in which displacements of running links are written."""
LinkDirection = Literal["transverse", "axial"]
"""Directions of a force on a point of a link, or of its displacement, in the link's frame."""
LINK_DIRECTIONS: tuple[LinkDirection, ...] = get_args(LinkDirection)

ShaftChoice = Literal["prescribed", "free"]
"""Whether the shaft turns as prescribed, or as its torque and its inertia let it."""
SHAFTS: tuple[ShaftChoice, ...] = get_args(ShaftChoice)

MassChoice = Literal["distributed", "lumped"]
"""Whether links have their mass along them, or in points as Kumar & Chandrakar have it."""
MASSES: tuple[MassChoice, ...] = get_args(MassChoice)

Store = Literal["needed", "all"]
"""Content of a stored response: the part for pictures and comparisons, or all there is."""
Integrator = Literal["trapezoidal", "generalized-alpha"]
"""Time integration of a simulation."""
STORES: tuple[Store, ...] = get_args(Store)
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
Start = Literal["rigid", "equilibrium", "periodic"]
"""State in which a run begins."""
STARTS: tuple[Start, ...] = get_args(Start)

ShaperName = Literal["zv", "zvd", "ei"]
"""Input shapers: zero vibration, zero vibration and derivative, extra insensitive."""
SHAPERS: tuple[ShaperName, ...] = get_args(ShaperName)
ShapedFor = Literal["end", "path"]
"""Frequencies that a law is shaped for: those where the crank stops, or those along its path."""
SHAPED_FOR: tuple[ShapedFor, ...] = get_args(ShapedFor)

CriterionName = Literal["max-stress", "tsai-hill", "tsai-wu", "hashin", "puck", "von-mises"]
"""Failure criteria for the layers of a link."""
CRITERIA: tuple[CriterionName, ...] = get_args(CriterionName)

LoadSource = Literal["quasi-static", "periodic", "transient", "rigid"]
"""Motion whose internal forces a link has to bear: of elastic links at rest in their frames, their
steady vibration, a run from straight links at full speed, or of links that are taken as rigid."""

TemplateKind = Literal["four-bar", "composite-four-bar", "rotating-arm", "slider-crank", "planar"]
"""Model files to start from."""

ReportPart = Literal[
    "frequencies", "campbell", "response", "kinematics", "coupler-curve", "section", "moisture"
]
"""Sections of a report."""
REPORT_PARTS: tuple[ReportPart, ...] = get_args(ReportPart)

PictureFormat = Literal["png", "pdf", "svg"]
"""Files that a picture can be written into."""
PICTURE_FORMATS: tuple[PictureFormat, ...] = get_args(PictureFormat)
PageWidth = Literal["one-column", "two-column"]
"""How much of a journal's page a picture takes."""
PAGE_WIDTHS: dict[PageWidth, float] = {"one-column": 88.0, "two-column": 180.0}
"""Width of a picture in mm. Columns of the usual journals are 84 to 90 mm wide."""

ELEMENTS_A_LINK = 8
"""Finite elements on each link by default, where a map begins to refine."""
TOLERANCE = 1e-3
"""Relative error by the mesh up to which the ``frequencies`` command refines."""
KEPT_MODES = 8
"""Natural modes whose Floquet modes a stability map keeps by default."""
MODES = 4
"""Natural frequencies asked for by default, in maps and responses alike."""

MOST_AVERAGES = 1000
"""Impacts of a hammer test: noise falls by their root, more are taken for a slip."""
MOST_SEED = 2**63 - 1
"""Greatest seed of random numbers: files of results keep no greater integers."""

MOST_ELEMENTS = 200
"""Elements a link: with so many, a four-bar takes 0.9 GB; with 500 it took more than 17 GB."""
MOST_MODES = 4500
"""Three coordinates a node of so many elements on three links."""


def engine_of(element: ElementName) -> EngineName:
    """Name the engine that has an element."""
    return next(engine for engine, elements in ELEMENTS.items() if element in elements)
