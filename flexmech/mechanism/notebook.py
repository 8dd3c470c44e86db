"""How a notebook shows a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Protocol

from flexmech.linkages import Linkage, LinkMass, linkage_positions, picture_crank_angle
from flexmech.mechanism.parts import Provenance
from flexmech.sections import BeamSection


class _Shown(Protocol):
    """What a notebook shows of a mechanism."""

    @property
    def linkage(self) -> Linkage: ...
    @property
    def sections(self) -> Mapping[str, BeamSection]: ...
    @property
    def provenance(self) -> Provenance: ...

    def link_mass(self, link: str) -> LinkMass: ...


def notebook_html(mechanism: _Shown, drawing: str) -> str:
    """A mechanism as a notebook shows it: in words, drawn, and its links in a table.

    Parameters
    ----------
    mechanism : Mechanism
    drawing : str
        Of :func:`flexmech.mechanism.drawing.drawing`.
    """
    from flexmech.plots import figure_html, plot_linkage

    dataset = linkage_positions(mechanism.linkage, picture_crank_angle(mechanism.linkage))
    figure = plot_linkage(
        dataset.assign_attrs(mechanism=mechanism.provenance.name, drawing=drawing)
    )
    headings = ("link", "length (mm)", "mass (g)", "EA (N)", "EI (N m²)", "thickness (mm)")
    rows: list[tuple[str, ...]] = [headings]
    for link in mechanism.linkage.topology.links:
        length, section = link.length * 1e3, mechanism.sections.get(link.name)
        if section is None:
            mass = mechanism.link_mass(link.name).moment(0)
            rows.append((link.name, f"{length:.5g}", f"{1e3 * mass:.5g}", "rigid", "rigid", ""))
            continue
        numbers = (
            length,
            section.mass_per_length * link.length * 1e3,
            section.axial_stiffness,
            section.bending_stiffness,
            section.in_plane_thickness * 1e3,
        )
        rows.append((link.name, *(f"{number:.5g}" for number in numbers)))
    cells = ("".join(f"<td>{escape(text)}</td>" for text in row) for row in rows)
    table = "".join(f"<tr>{row}</tr>" for row in cells)
    return f"<p>{escape(repr(mechanism))}</p>{figure_html(figure)}<table>{table}</table>"
