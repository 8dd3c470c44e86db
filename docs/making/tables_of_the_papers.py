"""Tables of the three papers, and ours beside them."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import flexmech
from flexmech import Mechanism
from flexmech.materials import (
    Hygrothermal,
)
from flexmech.modelfile import mechanism_from_toml
from making.state import REPOSITORY

__all__ = ["PaperTables"]

MODELS = REPOSITORY / "models"
LINKS = ("crank", "coupler", "rocker")
RISE = 80.0
"""Temperature rise of S in K."""


@dataclass(frozen=True)
class PaperTables:
    """Markdown of the tables, each a method without arguments.

    Parameters
    ----------
    printed : mapping
        What the papers print and no file of the package has.
    study : Path
        Folder of what ``scenarios/papers/elamy_2023.py`` wrote.
    """

    printed: Mapping[str, Any]
    study: Path

    def four_bars(self) -> str:
        """K, section 3: what is printed, and what the model files have."""
        rows, as_printed = [], True
        for name, printed in self.printed["four_bars"].items():
            mechanism = flexmech.load_mechanism(MODELS / f"{name}_fourbar.toml")
            for quantity, unit, value, ours in _of_four_bar(printed, mechanism):
                as_printed &= bool(np.isclose(value, ours, rtol=1e-12))
                rows.append((name, quantity, unit, f"{value:g}", f"{ours:.6g}"))
        heading = ("four-bar", "quantity", "unit", "printed", "model file")
        return f"{_taken(as_printed)}\n\n" + _folded(heading, rows)

    def lumps(self) -> str:
        """K, beside Figure 1.5: places of the lumped masses."""
        steel = flexmech.load_mechanism(MODELS / "steel_fourbar.toml")
        data = flexmech.kinematics(steel, 0.0, crank_angles=np.zeros(1), lumped=(1, 4, 4)).dataset
        place = 1e3 * data["lump_position"].values
        # Two lumps of the crank, five of the coupler from A on, five of the rocker from O4 on.
        ours = {"d4": place[3], "d5": place[4], "d6": place[5]}
        ours |= {"d11": place[8], "d10": place[9], "d9": place[10]}
        rows = [
            (name, f"{value:g}", f"{ours[name]:.6g}")
            for name, value in self.printed["lumps"].items()
        ]
        return (
            f"{data.sizes['lump']} lumped masses; distances from A ($d_4$ to $d_6$) and from O4 "
            "($d_9$ to $d_{11}$) in mm.\n\n" + _table(("distance", "printed", "ours"), rows)
        )

    def constituents(self) -> str:
        """E, Table 1."""
        shipped = flexmech.published_constituents()
        rows = []
        for name in ("E-glass", "carbon", "polyester"):
            one, isotropic = shipped[name], shipped[f"{name} (isotropic shear)"]
            spread = one.uncertainty
            rows.append(
                (
                    name,
                    _spread(one.youngs_modulus, spread.get("youngs_modulus"), 1e9),
                    _spread(one.shear_modulus, spread.get("shear_modulus"), 1e6),
                    _spread(one.density, spread.get("density"), 1e3),
                    f"{one.poisson_ratio:g}",
                    f"{isotropic.shear_modulus / 1e6:.0f}",
                )
            )
        heading = (
            "",
            "E (GPa)",
            "G (MPa)",
            "density (g/cm³)",
            "Poisson's ratio",
            "G of an isotropic material with this E and Poisson's ratio (MPa)",
        )
        return (
            "Taken as printed (`flexmech.published_constituents`); the last column is ours.\n\n"
            + _table(heading, rows)
        )

    def laminates(self) -> str:
        """E, Table 2: as printed, and by the rule of mixtures from Table 1."""
        found = pd.read_csv(self.study / "composite_properties.csv")
        found = found.set_index(["laminate", "plies", "layers"])
        moduli, others = [], []
        for code, printed in _elamy()["laminates"].items():
            in_plane = found.loc[code, "unidirectional", "across width"]
            bent, stretched, woven = (
                f"{one['modulus_GPa']:.1f}"
                for one in (
                    found.loc[code, "unidirectional", "through thickness"],
                    in_plane,
                    found.loc[code, "woven", "across width"],
                )
            )
            modulus = f"{printed['modulus']:g}"
            moduli.append((code, printed["stack"], modulus, bent, stretched, woven))
            others.append(
                (
                    code,
                    f"{printed['strength']:g}",
                    f"{printed['poisson_ratio']:g}",
                    f"{in_plane['poisson_ratio']:.3f}",
                    f"{printed['density']:g}",
                    f"{in_plane['density_kg_m3']:.0f}",
                )
            )
        of_moduli = (
            "laminate",
            "stack",
            "E printed (GPa)",
            "ours, straight plies, bent through the stack",
            "straight plies, stretched or bent in their plane",
            "woven plies, the same",
        )
        of_others = (
            "laminate",
            "strength printed (MPa)",
            "Poisson's ratio printed",
            "ours, straight plies",
            "density printed (kg/m³)",
            "ours",
        )
        return (
            "Headers and one unit of the printed table put right. Ours are of plies with 60 % of "
            "fibres by the rule of mixtures from Table 1. Strengths are missing: the "
            "paper prints none of a fibre or of the resin.\n\n"
            f"{_table(of_moduli, moduli)}\n{_table(of_others, others)}"
        )

    def cases(self) -> str:
        """E, Table 3, and the limits of the transmission angle of section 5.1."""
        claims = self._claims().set_index("statement")
        rows = []
        for case, lengths in _elamy()["cases"].items():
            limits = claims.loc[f"limits of the transmission angle, case {case}"]
            design = claims[claims.index.str.startswith(f"case {case} from")]["computed"]
            rows.append(
                (
                    case,
                    ", ".join(f"{length:.2f}" for length in lengths),
                    design.iloc[0] if len(design) else "not designed by these equations",
                    limits["printed"],
                    limits["computed"],
                )
            )
        heading = (
            "case",
            "R2, R3, R4 over R1, printed",
            "ours, equations 11 to 17",
            "transmission angle, printed",
            "ours, equations 2 and 3",
        )
        return _table(heading, rows)

    def least_angle(self) -> str:
        """E, Table 4."""
        return self._frequencies("min")

    def right_angle(self) -> str:
        """E, Table 5."""
        return self._frequencies("90")

    def greatest_angle(self) -> str:
        """E, Table 6."""
        return self._frequencies("max")

    def resins(self) -> str:
        """S, Table 1, and what follows from it."""
        rows, as_printed = [], True
        for name, printed in self.printed["resins"].items():
            resin = _resin(name)
            assert resin.wet_thermal_expansion is not None
            assert resin.equilibrium is not None
            saturation = resin.equilibrium.saturation
            ours = (
                1e6 * resin.thermal_expansion,
                1e6 * resin.wet_thermal_expansion,
                1e3 * resin.moisture_expansion / 100,
                100 * saturation,
            )
            as_printed &= bool(np.allclose(printed, ours, rtol=1e-12))
            strain = resin.free_strain(RISE, saturation)
            lengths = (f"{strain:.6f}", f"{100 * (1 + strain):.3f}")
            rows.append((name, *(f"{value:g}" for value in printed), *lengths))
        heading = (
            "resin",
            "expansion, dry (1e-6/K)",
            "wet",
            "by moisture (1e-3/%)",
            "equilibrium moisture (%)",
            "our strain, saturated, +80 K",
            "100 mm become (mm)",
        )
        return f"{_taken(as_printed)} The last two columns are ours.\n\n" + _table(heading, rows)

    def _claims(self) -> pd.DataFrame:
        return pd.read_csv(self.study / "composite_claims.csv", dtype=str, keep_default_na=False)

    def _frequencies(self, position: str) -> str:
        """One of Tables 4 to 6 beside the first model of the study."""
        data = pd.read_csv(self.study / "composites.csv", dtype={"position": str})
        # What tells models apart are the columns of words, those of the first model first.
        words = [name for name in data if not pd.api.types.is_numeric_dtype(data[name])]
        words = [name for name in words if name not in ("position", "laminate")]
        first = data[words].iloc[0]
        ours = data[(data[words] == first).all(axis=1)]
        rows = [
            (
                row.laminate,
                row.case,
                f"{row.published_finite_element_Hz:g}",
                f"{row.published_measured_Hz:g}",
                f"{row.frequency_Hz:.2f}",
                f"{row.published_finite_element_ratio:.3f}",
                f"{row.published_measured_ratio:.3f}",
                f"{row.ratio:.3f}",
                f"{row.published_damping:g}",
                f"{row.strain_energy_damping:.2e}",
            )
            for row in ours[ours["position"] == position].itertuples()
        ]
        heading = (
            "laminate",
            "case",
            "printed FE (Hz)",
            "measured (Hz)",
            "ours (Hz)",
            "ratio, FE",
            "measured",
            "ours",
            "damping printed",
            "ours",
        )
        return (
            "The paper prints no link size: Hz are ours of the size that the study assumes, and "
            "ratios compare, each to its own C1, case 1 of Table 4. It prints no loss of its "
            "materials either: our damping is of an assumed loss in the resin. Ours: "
            f"{', '.join(f'{name} {value}' for name, value in first.items())}.\n\n"
            + _folded(heading, rows)
        )


def _elamy() -> dict[str, Any]:
    """What E prints of its laminates and cases."""
    file = REPOSITORY / "scenarios/papers/data/elamy_2023.toml"
    return tomllib.loads(file.read_text(encoding="utf-8"))


def _of_four_bar(
    printed: Mapping[str, Any], mechanism: Mechanism
) -> Iterable[tuple[str, str, float, float]]:
    """Quantity, unit, printed value and that of the model, of one four-bar of K."""
    linkage = mechanism.linkage
    assert isinstance(linkage, flexmech.FourBar)
    lengths = linkage.lengths
    names = zip(("r1", "r2", "r3", "r4"), ("ground", *LINKS), strict=True)
    yield from ((f"{r}, {name}", "mm", printed[r], 1e3 * lengths[name]) for r, name in names)
    for number, link in enumerate(LINKS):
        section = mechanism.sections[link]
        area = section.axial_stiffness / (1e6 * printed["E"])
        height = np.sqrt(12 * section.bending_stiffness / section.axial_stiffness)
        density = section.mass_per_length / area
        yield f"{link}, in the plane", "mm", printed["thickness"][number], 1e3 * height
        yield f"{link}, out of the plane", "mm", printed["width"][number], 1e3 * area / height
        yield f"{link}, density", "t/mm³", printed["density"][number], 1e-12 * density


def _resin(name: str) -> Hygrothermal:
    """Resin of S by its name, from a model file that has both."""
    file = MODELS / "neat_resin_figure_5.toml"
    text = file.read_text(encoding="utf-8").replace('material = "R-914"', f'material = "{name}"')
    layers = mechanism_from_toml(text, file.name).sections["coupler"].layers
    assert layers is not None
    resin = layers.laminate.layers[0].ply.resin
    assert resin is not None
    return resin.hygrothermal


def _taken(as_printed: bool) -> str:
    if not as_printed:
        raise RuntimeError("a model file has other data than the paper that it names")
    return "The model files have these numbers as printed."


def _spread(value: float, spread: float | None, unit: float) -> str:
    more = "" if spread is None else f" ± {spread / unit:g}"
    return f"{value / unit:g}{more}"


def _table(heading: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    titles = list(heading)
    lines = [titles, ["-"] * len(titles), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def _folded(heading: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A long table that a browser folds."""
    return f"<details><summary>All numbers</summary>\n\n{_table(heading, rows)}\n</details>\n"
