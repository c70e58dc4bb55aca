"""Tests that are made step by step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from . import _comminute, _tables
from ._scene import Scene

# numbers of a contact as the native part packs them
_CONTACT = np.dtype(
    [
        ("grain", "i8"),
        ("other", "i8"),
        ("wall", "?"),
        ("point", "f8", 3),
        ("normal", "f8", 3),
        ("force", "f8", 3),
        ("normal_force", "f8"),
        ("overlap", "f8"),
    ]
)


class Wall:
    """A wall: a plane, or an upright cylinder with the grains inside. It moves along its normal alone.

    Velocities are positive towards the grains, as ``velocity_m_s`` in scenes, in m for a unit of :attr:`Simulation.time`: m/s, and with
    inertia scaling m for a step.
    """

    def __init__(self, simulation: Simulation, number: int, name: str) -> None:
        self._simulation = simulation
        self.number = number
        """Its number, from 0."""
        self.name = name
        """``bottom``, ``top`` and ``cylinder`` of a specimen; ``wall_0``, ``wall_1``, … of a free scene."""

    def _about(self) -> dict[str, Any]:
        return self._simulation._native.wall(self.number)

    @property
    def position(self) -> np.ndarray:
        """A point on the plane, m; x and y of the axis of a cylinder."""
        return np.array(self._about()["position"])

    @property
    def normal(self) -> np.ndarray | None:
        """Unit normal of the plane, towards the grains; ``None`` for a cylinder."""
        normal = self._about().get("normal")
        return None if normal is None else np.array(normal)

    @property
    def radius(self) -> float | None:
        """Radius of the cylinder, m; ``None`` for a plane."""
        return self._about().get("radius")

    @property
    def displacement(self) -> float:
        """Way towards the grains since the simulation began, m; of a cylinder the decrease of its radius."""
        return float(self._about()["displacement"])

    @property
    def velocity(self) -> float:
        """Velocity towards the grains. Setting it makes the wall move so from the next step on."""
        return float(self._about()["velocity"])

    @velocity.setter
    def velocity(self, velocity: float) -> None:
        self._simulation._native.drive(self.number, velocity)

    def hold(
        self, stress: float, *, area: float | None = None, gain: float | None = None, max_velocity: float | None = None
    ) -> None:
        """Lets the wall hold a normal stress, Pa, compression positive, from the next step on.

        ``area``, m²: that on which the stress acts, for planes of free scenes; walls of specimens have their own. ``gain``: share of the
        imbalance that is removed in a step; ``specimen.servo_gain``, and 0.2 in free scenes, if not given. ``max_velocity``: the largest.
        """
        self._simulation._native.hold(self.number, stress, area, gain, max_velocity)

    @property
    def force(self) -> float:
        """Normal force of the grains on the wall, N, compression positive; on a cylinder the sum of the radial forces."""
        return float(self._about()["force"])

    @property
    def shear_z(self) -> float:
        """Sum of the z components of the tangential forces of the grains on the wall, N."""
        return float(self._about()["shear_z"])

    @property
    def area(self) -> float | None:
        """Area over which the force is a stress, m²; ``None`` for a plane of a free scene that holds no stress."""
        area: float | None = self._about()["area"]
        return area

    @property
    def stress(self) -> float | None:
        """Normal stress on the wall, Pa, compression positive: force over area; ``None`` without an area."""
        about = self._about()
        return None if about["area"] is None else about["force"] / about["area"]

    @property
    def work(self) -> float:
        """Work of the wall on the grains, J, since the energy ledger was opened: when the programme of a specimen begins."""
        return float(self._about()["work"])

    def __repr__(self) -> str:
        return f"<Wall {self.name}>"


class Walls(Mapping[str, Wall]):
    """Walls by name or number."""

    def __init__(self, walls: Sequence[Wall]) -> None:
        self._walls = {wall.name: wall for wall in walls}

    def __getitem__(self, name: str | int) -> Wall:
        if isinstance(name, int):
            return list(self._walls.values())[name]
        if name not in self._walls:
            raise KeyError(f"there is no wall {name}; there are {', '.join(self._walls)}")
        return self._walls[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._walls)

    def __len__(self) -> int:
        return len(self._walls)

    def __repr__(self) -> str:
        return f"Walls({', '.join(self)})"


class Simulation:
    """A test of grains that Python makes step by step: a free scene (``assembly``), ``oedometer``, ``triaxial`` or ``isotropic``.

    A free scene stands at its beginning; of a test on a specimen the specimen has been made (as by a run, which takes as long; or read,
    with ``specimen.file`` in the scene), rests under its isotropic stress, and the programme begins. At every time the forces are known
    and nothing has moved yet, so places, forces and stresses belong together as in the records of a run; the grains are those of a run
    of the scene to the last bit.

    ``threads``: one for each core if not given; results do not depend on it.
    """

    def __init__(self, scene: Scene, *, threads: int | None = None) -> None:
        self.scene = scene
        """The scene."""
        self._native = _comminute.Simulation.of(scene._native, threads)
        self._kept: dict[str, np.ndarray] = {}
        walls = [Wall(self, number, name) for number, name in enumerate(self._native.wall_names())]
        self.walls = Walls(walls)
        """The walls: ``walls["top"]``, ``walls[0]``."""

    def step(self, steps: int = 1) -> None:
        """Makes so many steps. Ctrl-C raises ``KeyboardInterrupt`` between two of them; stepping can go on. After an error it cannot."""
        self._kept.clear()
        self._native.step(steps)

    @property
    def steps(self) -> int:
        """Number of steps made; of a specimen those since its preparation, rest included, as the column ``step`` of records."""
        return self._native.steps

    @property
    def time(self) -> float:
        """Time, s; with inertia scaling (all tests on specimens) the number of steps."""
        return self._native.time

    @property
    def dt(self) -> float:
        """Present time step, s; with inertia scaling 1."""
        return self._native.dt

    @property
    def is_over(self) -> bool:
        """Whether the scene's programme (or duration) is over; stepping can go on. Never in a test on a specimen whose walls are driven
        from here."""
        return self._native.is_over

    @property
    def driven(self) -> bool:
        """Whether walls are driven from here. In a test on a specimen this ends the programme of the scene: walls stand still until they
        are told something else."""
        return self._native.driven

    @property
    def platen(self) -> Wall:
        """The top platen of a specimen."""
        return self.walls["top"]

    def _array(self, name: str, *shape: int, kind: str = "f8") -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = np.frombuffer(self._native.array(name), dtype=kind).reshape(-1, *shape)
        return self._kept[name]

    @property
    def ids(self) -> np.ndarray:
        """Ids of the grains; all arrays are in their order. Grains of the start have 0, 1, …; daughters have new ones."""
        return self._array("ids", kind="i8")

    @property
    def positions(self) -> np.ndarray:
        """Centres, m: a row for each grain. This and all arrays are those of the present instant, and read-only."""
        return self._array("positions", 3)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities, m/s, half a step before the present instant (leapfrog)."""
        return self._array("velocities", 3)

    @property
    def spins(self) -> np.ndarray:
        """Angular velocities, rad/s, half a step before the present instant."""
        return self._array("spins", 3)

    @property
    def radii(self) -> np.ndarray:
        """Radii, m."""
        return self._array("radii")

    @property
    def masses(self) -> np.ndarray:
        """Masses, kg."""
        return self._array("masses")

    @property
    def inertial_masses(self) -> np.ndarray:
        """Masses with which the grains move, kg: others than :attr:`masses` with inertia scaling."""
        return self._array("inertial_masses")

    @property
    def strengths(self) -> np.ndarray:
        """Limit strengths, Pa; infinite where a grain cannot break."""
        return self._array("strengths")

    @property
    def materials(self) -> np.ndarray:
        """Numbers of the materials."""
        return self._array("materials", kind="i8")

    @property
    def generations(self) -> np.ndarray:
        """Numbers of breakages between a grain of the start and this one."""
        return self._array("generations", kind="i8")

    @property
    def forces(self) -> np.ndarray:
        """Total force on each grain, N: contacts, gravity, points; before damping."""
        return self._array("forces", 3)

    @property
    def contacts(self) -> np.ndarray:
        """The contacts, a structured array: ``grain``, ``other`` (id of the other grain; number of the wall where ``wall`` is true),
        ``point``, m, ``normal`` (from the grain to the other), ``force`` on the grain, N, ``normal_force``, N, compression positive,
        and ``overlap``, m. Each contact stands there once."""
        if "contacts" not in self._kept:
            self._kept["contacts"] = np.frombuffer(self._native.contacts(), dtype=_CONTACT)
        return self._kept["contacts"]

    def stress(self, volume: float | None = None) -> np.ndarray:
        """Mean stress tensor by Love and Weber, Pa, compression positive: the contact forces times branch vectors over the ``volume``,
        m³; that between the walls of a specimen if none is given."""
        return np.array(self._native.mean_stress(volume))

    @property
    def volume(self) -> float | None:
        """Volume between the walls of a specimen, m³; ``None`` in a free scene."""
        return self._native.volume

    def inertial_time(self, pressure: float) -> float:
        """Time scale of grain rearrangement d √(ρ/p) under a pressure, Pa. A strain rate times this is the inertial number: a platen
        that moves at ``number * height / inertial_time(p)`` strains the specimen at the inertial number ``number``."""
        return self._native.inertial_time(pressure)

    @property
    def crush_events(self) -> int:
        """Number of breakages so far."""
        return self._native.crush_events

    @property
    def breakages(self) -> Any:
        """All breakages since the beginning, as ``breakage.csv``: a pandas frame, or a structured array where pandas is not installed."""
        return _tables.of_rows(self._native.breakages(), "breakage.csv", self.scene.kind)

    def row(self) -> dict[str, Any]:
        """What ``history.csv`` says of the present instant, column by column: stresses, void ratios, breakage indices, and the energy
        ledger if ``records.energy`` is set. Costs as much as some steps."""
        return self._native.row()

    def __repr__(self) -> str:
        return f"<Simulation of {self.scene.name}: step {self.steps}, {len(self.ids)} grains>"
