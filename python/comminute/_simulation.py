"""Tests that are made step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, overload

import numpy as np

from . import _comminute, _tables
from ._scene import Scene

# numbers of a contact as the native part packs them
_CONTACT = np.dtype(
    [
        ("grain", "i8"),
        ("other", "i8"),
        ("wall", "?"),
        ("material_point", "?"),
        ("point", "f8", 3),
        ("normal", "f8", 3),
        ("force", "f8", 3),
        ("normal_force", "f8"),
        ("overlap", "f8"),
    ]
)


class Wall:
    """A wall: a plane, or an upright cylinder with the grains inside. It moves along its normal alone. Sides of the grid, and those of a
    specimen of points that stand still, cannot be driven.

    Velocities are positive towards the grains, as ``velocity_m_s`` in scenes, in m for a unit of :attr:`Simulation.time`: m/s, and with
    inertia scaling m for a step.
    """

    def __init__(self, simulation: Simulation, number: int, name: str) -> None:
        self._simulation = simulation
        self.number = number
        """Its number, from 0."""
        self.name = name
        """``bottom``, ``top`` and ``cylinder`` of a specimen, ``x_low``, ``x_high``, … of a box; of a free scene ``wall_0``, ``wall_1``, …
        and the sides of the grid that hold points, ``x_low`` to ``z_high``."""

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
        imbalance that is removed in a step; that of the scene (``specimen.servo_gain``, ``test.servo_gain``), and 0.2 in free scenes, if not
        given. ``max_velocity``: the largest; where a wall of a mixture is told none, the stress over the root of Young's modulus times
        density of its materials, and between loading plates a share of the test's own rate.
        """
        self._simulation._native.hold(self.number, stress, area, gain, max_velocity)

    @property
    def force(self) -> float:
        """Normal force of grains, points and bodies on the wall, N, compression positive; on a cylinder the sum of the radial forces."""
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


class Body:
    """A rigid body that is no sphere, a ``[[block]]`` of the scene or of a set. A driven one moves as it is told, whatever acts on it."""

    def __init__(self, simulation: Simulation, number: int) -> None:
        self._simulation = simulation
        self.number = number
        """Its number, from 0, as the column ``block`` of records. Where bodies break, a piece keeps the number of its body."""

    def _about(self) -> dict[str, Any]:
        return self._simulation._native.body(self.number)

    @property
    def shape(self) -> str:
        """Name of its shape, as in scenes."""
        return str(self._about()["shape"])

    @property
    def driven(self) -> bool:
        """Whether it is driven; only then its velocity and spin can be set."""
        return bool(self._about()["driven"])

    @property
    def mass(self) -> float:
        """Mass, kg; a mesh has none."""
        return float(self._about()["mass"])

    @property
    def material(self) -> int:
        """Number of the material."""
        return int(self._about()["material"])

    @property
    def position(self) -> np.ndarray:
        """Centre of mass, m."""
        return np.array(self._about()["position"])

    @property
    def orientation(self) -> np.ndarray:
        """Unit quaternion (w, x, y, z) that turns the axes of space into the principal axes of the body."""
        return np.array(self._about()["orientation"])

    @property
    def velocity(self) -> np.ndarray:
        """Velocity of the centre of mass, m/s, half a step before the present instant. Setting it makes a driven body move so from the
        next step on, and ends its path."""
        return np.array(self._about()["velocity"])

    @velocity.setter
    def velocity(self, velocity: Sequence[float] | np.ndarray) -> None:
        self._simulation._native.drive_body(self.number, _three("velocity", velocity), self._about()["spin"])

    @property
    def spin(self) -> np.ndarray:
        """Angular velocity, rad/s, half a step before the present instant. Setting it makes a driven body turn so from the next step on."""
        return np.array(self._about()["spin"])

    @spin.setter
    def spin(self, spin: Sequence[float] | np.ndarray) -> None:
        self._simulation._native.drive_body(self.number, self._about()["velocity"], _three("spin", spin))

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy, J."""
        return float(self._about()["kinetic_energy"])

    @property
    def forces(self) -> dict[str, np.ndarray]:
        """Force on the body, N, of ``points``, ``grains``, ``walls``, ``bodies`` and ``joints``."""
        parts = self._simulation._native.body_forces(self.number)[0]
        return {name: np.array(part) for name, part in zip(("points", "grains", "walls", "bodies", "joints"), parts, strict=True)}

    @property
    def force(self) -> np.ndarray:
        """Force of all that touches the body and of its joints, N; without its weight, and without what pushes it."""
        force: np.ndarray = np.sum(list(self.forces.values()), axis=0)
        return force

    @property
    def torque(self) -> np.ndarray:
        """Torque of the same about its centre of mass, N m."""
        return np.array(self._simulation._native.body_forces(self.number)[1])

    @property
    def surface(self) -> tuple[np.ndarray, np.ndarray]:
        """Its surface now: corners, m, and triangles as three indices of corners each."""
        corners, triangles = self._simulation._native.body_surface(self.number)
        return np.frombuffer(corners).reshape(-1, 3), np.frombuffer(triangles, dtype="i8").reshape(-1, 3)

    def __repr__(self) -> str:
        return f"<Body {self.number}: {self.shape}{', driven' if self.driven else ''}>"


def _three(name: str, vector: Sequence[float] | np.ndarray) -> list[float]:
    numbers = np.asarray(vector, dtype=float)
    if numbers.shape != (3,):
        raise ValueError(f"{name} = {vector!r}: must be three numbers, along x, y and z")
    return [float(number) for number in numbers]


class Bodies(Sequence[Body]):
    """The rigid bodies by number. Pieces of bodies that break come at the end."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def __len__(self) -> int:
        return self._simulation._native.body_count

    @overload
    def __getitem__(self, number: int) -> Body: ...
    @overload
    def __getitem__(self, number: slice) -> Sequence[Body]: ...
    def __getitem__(self, number: int | slice) -> Body | Sequence[Body]:
        count = len(self)
        if isinstance(number, slice):
            return [Body(self._simulation, k) for k in range(*number.indices(count))]
        if not -count <= number < count:
            raise IndexError(f"there is no body {number}; there are {count}, from 0")
        return Body(self._simulation, number % count)

    def __repr__(self) -> str:
        return f"<Bodies: {len(self)}>"


class Points:
    """The material points of a continuum or mixture (and those that crushing makes in an oedometer of grains): arrays of the present
    instant, read-only, in the order of the ids. Without points they are empty."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def _array(self, name: str, *shape: int, kind: str = "f8") -> np.ndarray:
        simulation = self._simulation
        array: np.ndarray = simulation._kept_array(f"points.{name}", lambda: simulation._native.point_array(name), shape, kind)
        return array

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def ids(self) -> np.ndarray:
        """Ids of the points."""
        return self._array("ids", kind="i8")

    @property
    def positions(self) -> np.ndarray:
        """Positions, m: a row for each point."""
        return self._array("positions", 3)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities, m/s, half a step before the present instant (leapfrog)."""
        return self._array("velocities", 3)

    @property
    def masses(self) -> np.ndarray:
        """Masses with which the points move, kg (per metre in plane strain): ``stepping.points_inertia`` is in them."""
        return self._array("masses")

    @property
    def volumes(self) -> np.ndarray:
        """Present volumes, m³ (m² in plane strain)."""
        return self._array("volumes")

    @property
    def stresses(self) -> np.ndarray:
        """Stress tensors, Pa, compression positive: an array n × 3 × 3."""
        return self._array("stresses", 3, 3)

    @property
    def plastic_strains(self) -> np.ndarray:
        """Accumulated plastic strains, as the column ``plastic_strain`` of ``points_final.csv``."""
        return self._array("plastic_strains")

    @property
    def porosities(self) -> np.ndarray:
        """Volumes of pores over present volumes."""
        return self._array("porosities")

    @property
    def materials(self) -> np.ndarray:
        """Numbers of the laws of the points, in the order of the materials that have ``[continuum]``."""
        return self._array("laws", kind="i8")

    def __repr__(self) -> str:
        return f"<Points: {len(self)}>"


class Simulation:
    """A test that Python makes step by step: grains (``assembly``, ``oedometer``, ``triaxial``, ``isotropic``), points and mixtures
    (``continuum``, ``mixture``), rigid bodies among them.

    A free scene stands at its beginning; of a test on a cylindrical specimen of grains the specimen has been made (as by a run, which
    takes as long; or read, with ``specimen.file`` in the scene), rests under its isotropic stress, and the programme begins. Tests of
    points and mixtures stand where their history begins: a specimen that grows has grown, one that settles has not settled yet. At every
    time the forces are known and nothing has moved yet, so places, forces and stresses belong together as in the records of a run; all
    numbers are those of a run of the scene on the processor to the last bit.

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
        self.points = Points(self)
        """The material points: ``points.stresses``."""
        self.bodies = Bodies(self)
        """The rigid bodies: ``bodies[0]``."""

    def step(self, steps: int = 1) -> None:
        """Makes so many steps (in a mixture cycles of grains and points). Ctrl-C raises ``KeyboardInterrupt`` between two of them; stepping can go on. After an error it cannot."""
        self._kept.clear()
        self._native.step(steps)

    @property
    def steps(self) -> int:
        """Number of steps made, as the column ``step`` of records: of a specimen those since its preparation, rest included; of a mixture
        those of its points, of which a cycle may have several."""
        return self._native.steps

    @property
    def time(self) -> float:
        """Time, s; with inertia scaling (all tests on cylindrical specimens of grains) the number of steps."""
        return self._native.time

    @property
    def dt(self) -> float:
        """Present time step, s; of a mixture that of a cycle; with inertia scaling 1."""
        return self._native.dt

    @property
    def is_over(self) -> bool:
        """Whether the scene's programme (or duration) is over; stepping can go on. Never in a test on a specimen whose walls are driven
        from here."""
        return self._native.is_over

    @property
    def stage(self) -> str:
        """Stage of the test, as the column ``stage`` of records: ``settle``, ``load``, …; ``driven`` where walls of a specimen are driven
        from here."""
        return self._native.stage

    @property
    def driven(self) -> bool:
        """Whether walls or bodies are driven from here. In a test on a specimen this ends the programme of the scene: walls stand still until they
        are told something else."""
        return self._native.driven

    @property
    def platen(self) -> Wall:
        """The top platen of a specimen; in plane strain, where y points upwards, ``y_high``."""
        return self.walls["y_high" if "top" not in self.walls and "y_high" in self.walls else "top"]

    def _array(self, name: str, *shape: int, kind: str = "f8") -> np.ndarray:
        return self._kept_array(name, lambda: self._native.array(name), shape, kind)

    def _kept_array(self, name: str, get: Callable[[], bytes], shape: tuple[int, ...], kind: str) -> np.ndarray:
        if name not in self._kept:
            self._kept[name] = np.frombuffer(get(), dtype=kind).reshape(-1, *shape)
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
        """Total force on each grain, N: contacts, gravity, points, bodies; before damping."""
        return self._array("forces", 3)

    @property
    def contacts(self) -> np.ndarray:
        """The contacts of grains, a structured array: ``grain``, ``other`` (id of the other grain; number of the wall where ``wall`` is true,
        as those of ``wall_0``, … or in a box the sides in their order; id of the point where ``material_point`` is true),
        ``point``, m, ``normal`` (from the grain to the other), ``force`` on the grain, N, ``normal_force``, N, compression positive,
        and ``overlap``, m. Each contact stands there once."""
        if "contacts" not in self._kept:
            self._kept["contacts"] = np.frombuffer(self._native.contacts(), dtype=_CONTACT)
        return self._kept["contacts"]

    def stress(self, volume: float | None = None) -> np.ndarray:
        """Mean stress tensor by Love and Weber, Pa, compression positive: the contact forces times branch vectors over the ``volume``,
        m³; that between the walls of a specimen if none is given. Of grains alone: points have ``points.stresses``."""
        return np.array(self._native.mean_stress(volume))

    @property
    def volume(self) -> float | None:
        """Volume between the walls of a specimen, m³ (m² in plane strain); ``None`` in a free scene."""
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

    @property
    def body_breakages(self) -> Any:
        """All breakages of rigid bodies since the beginning, as ``block_breakage.csv``."""
        return _tables.of_rows(self._native.body_breakages(), "block_breakage.csv", self.scene.kind)

    def row(self) -> dict[str, Any]:
        """What ``history.csv`` says of the present instant, column by column: stresses, void ratios, breakage indices, and the energy
        ledger if ``records.energy`` is set. Costs as much as some steps.

        In tests of points and mixtures between platens stresses and strains are means over all steps since the last row, as in a run: of
        the run's own rows as long as the programme of the scene goes on, then of those that were asked for here."""
        return self._native.row()

    def __repr__(self) -> str:
        there = {"grains": len(self.ids), "points": len(self.points), "bodies": len(self.bodies)}
        what = ", ".join(f"{count} {name}" for name, count in there.items() if count)
        return f"<Simulation of {self.scene.name}: step {self.steps}, {what}>"
