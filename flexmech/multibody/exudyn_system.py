"""A running mechanism as an Exudyn system in the user's hands, and as a script."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmech.files import given_path, moved_into
from flexmech.linkages import CrankDrive
from flexmech.multibody.items import Item, ItemKind
from flexmech.multibody.script import ScriptSource, linkage_script
from flexmech.multibody.sensors import add_sensors
from flexmech.multibody.simulation import Simulation
from flexmech.multibody.solver_settings import applied
from flexmech.short_repr import short_repr
from flexmech.time_domain.recorded_runs import LinkState
from flexmech.types import FloatArray

SCRIPT = "linkage.py"


@dataclass(frozen=True, eq=False, repr=False)
class ExudynSystem:
    """The assembled Exudyn system of a running mechanism, with named items and sensors.

    Of :func:`flexmech.exudyn_system`. It stands at time zero with the velocities of its start,
    and is solved by the settings with which flexmech itself runs it.

    Parameters
    ----------
    container : exudyn.SystemContainer
        For the viewer: ``container.renderer.Start()``.
    mbs : exudyn.MainSystem
    settings : exudyn.SimulationSettings
    items : tuple of Item
        Nodes, objects (elements, bodies, joints), markers, loads and sensors as they were
        added: each with its ``kind``, ``type``, ``name``, ``number`` and ``values``.
    step : float
        Time step in s.
    steps : int
    script : str
        A Python script that makes the same system, solves it and prints deflections; it
        needs exudyn and numpy alone.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> request = flexmech.ResponseRequest(flexmech.CrankDrive(20.0), 0.01, step=1e-4)
    >>> system = flexmech.exudyn_system(flexmech.ExudynEngine(mechanism, 2), request)
    >>> system.mbs.SolveDynamic(system.settings)
    True
    >>> list(system.sensors)[-3:]
    ['pin_B_force', 'pivot_O4_force', 'driving_torque']
    >>> system.history("coupler_deflection").shape
    (32, 2)
    """

    container: Any
    mbs: Any
    settings: Any
    items: tuple[Item, ...]
    step: float
    steps: int
    script: str

    @classmethod
    def of(
        cls, simulation: Simulation, drive: CrankDrive, start: LinkState, stride: int
    ) -> ExudynSystem:
        """Add sensors to the model of a simulation and hand it over.

        Parameters
        ----------
        simulation : Simulation
        drive : CrankDrive
        start : LinkState
        stride : int

        Returns
        -------
        ExudynSystem
        """
        model = simulation.model
        items = model.assembly.items
        add_sensors(model)
        items.mbs.Assemble()
        coordinates, rates = simulation.set_start(start)
        if simulation.drifts:
            items.mbs.SetPostStepUserFunction(model.joints.after_step)
        settings = simulation.settings() | {
            "solution.sensors.active": True,
            "solution.sensors.writePeriod": float(simulation.step),
        }
        script = linkage_script(
            ScriptSource(
                provenance=model.assembly.mechanism.provenance,
                drive=drive,
                items=items.listed,
                joints=model.joints,
                drifts=simulation.drifts,
                coordinates=coordinates,
                rates=rates,
                settings=settings,
                step=float(simulation.step),
                stride=stride,
            )
        )
        return cls(
            items.container,
            items.mbs,
            applied(settings),
            tuple(items.listed),
            float(simulation.step),
            simulation.steps,
            script,
        )

    @property
    def nodes(self) -> dict[str, int]:
        """Exudyn's number of every node, such as ``coupler_node_0``, by its name."""
        return self._numbers("node")

    @property
    def objects(self) -> dict[str, int]:
        """Number of every element, body, joint and constraint, such as ``crank_drive``."""
        return self._numbers("object")

    @property
    def markers(self) -> dict[str, int]:
        """Number of every marker, by its name."""
        return self._numbers("marker")

    @property
    def loads(self) -> dict[str, int]:
        """Number of every load, by its name."""
        return self._numbers("load")

    @property
    def sensors(self) -> dict[str, int]:
        """Number of every sensor, such as ``coupler_deflection``, by its name."""
        return self._numbers("sensor")

    def history(self, sensor: str) -> FloatArray:
        """What a sensor has recorded, after the system is solved.

        Parameters
        ----------
        sensor : str
            Its name, such as ``"coupler_deflection"`` in m, ``"pin_A_force"`` in N or
            ``"driving_torque"`` in N m.

        Returns
        -------
        ndarray, shape (steps + 1, 1 + n)
            Time in s and the sensor's values, at every step.
        """
        return np.asarray(self.mbs.GetSensorStoredData(self.sensors[sensor]))

    def save(self, folder: str | Path) -> list[Path]:
        """Write the script as ``linkage.py``.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If the folder cannot be written to.
        """
        folder = given_path(folder)
        with moved_into(folder) as temporary:
            (temporary / SCRIPT).write_text(self.script, encoding="utf-8", newline="\n")
        return [folder / SCRIPT]

    def __repr__(self) -> str:
        counts = {"nodes": self.nodes, "objects": self.objects, "sensors": self.sensors}
        return short_repr(self, *(f"{len(named)} {kind}" for kind, named in counts.items()))

    def _numbers(self, kind: ItemKind) -> dict[str, int]:
        return {item.name: item.number for item in self.items if item.kind == kind}
