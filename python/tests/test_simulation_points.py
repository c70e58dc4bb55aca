"""Points, mixtures and rigid bodies made step by step: bits of the command's runs, driven plates, walls and bodies."""

import re
import runpy
import subprocess
from pathlib import Path

import numpy as np
import pytest

import comminute
from comminute import errors
from conftest import ROOT
from test_simulation import same_grains, same_row

SOIL = {
    "name": "soil",
    "grain": {"density_kg_m3": 2600.0},
    "elastic": {"E_GPa": 0.05, "nu": 0.3},
    "contact": {"friction": 0.4, "restitution": 0.5},
    "continuum": {"law": "elastic", "E_MPa": 10.0, "nu": 0.3},
}

# a small elastic oedometer of points
COLUMN = {
    "kind": "continuum",
    "body": [{"shape": "box", "min_mm": [0.0, 0.0, 0.0], "max_mm": [20.0, 20.0, 30.0], "porosity": 0.4}],
    "grid.cell_mm": 5.0,
    "test": {"rig": "oedometer", "axial_strain": 0.01, "strain_per_wave": 1e-3},
    "damping.local": 0.3,
    "records.rows": 20,
    "material": SOIL,
}

# a block of points on a floor, a driven plate above it, a free box beside it, and a wall
PRESSED = {
    "kind": "mixture",
    "duration_s": 0.002,
    "body": [{"shape": "box", "min_mm": [0.0, 0.0, 0.0], "max_mm": [40.0, 40.0, 20.0], "porosity": 0.4}],
    "block": [
        {"shape": "box", "size_mm": [50.0, 50.0, 10.0], "position_mm": [20.0, 20.0, 26.5], "driven": True},
        {"shape": "box", "size_mm": [20.0, 20.0, 20.0], "position_mm": [70.0, 20.0, 10.5], "velocity_m_s": [0.1, 0.0, -0.2]},
    ],
    "wall": [{"kind": "plane", "point_m": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0], "friction": 0.3}],
    "contact.law": "hertz_viscous",
    "gravity_m_s2": [0.0, 0.0, -9.81],
    "grid": {
        "cell_mm": 5.0,
        "min_mm": [-20.0, -20.0, -20.0],
        "max_mm": [100.0, 60.0, 60.0],
        "y_low": "symmetry",
    },
    "records.rows": 10,
    "material": SOIL,
}


def made(command: str, scene: comminute.Scene, folder: Path) -> comminute.Run:
    """The command's run of a scene."""
    scene.update({"records.figures": False, "records.snapshots": False})
    (folder / "scene.toml").write_text(scene.to_toml())
    args = [command, "run", folder / "scene.toml", "--quiet", "--threads", "2", "--out", folder / "out"]
    subprocess.run(args, check=True)
    return comminute.Run.open(folder / "out")


def followed(simulation: comminute.Simulation, run: comminute.Run) -> None:
    """Steps from row to row of a run, compares all rows, and is then at its end."""
    for step in run.history["step"]:
        assert not simulation.is_over
        while simulation.steps < step:
            simulation.step()
        # to ask for a row beside the run's own changes nothing
        same_row(simulation.row(), run.history)
        same_row(simulation.row(), run.history)
    assert simulation.is_over


def written(numbers: np.ndarray) -> np.ndarray:
    """The numbers as a table has them: nine digits."""
    return np.array([float(f"{x:.8e}") for x in numbers.ravel()])


def same_points(simulation: comminute.Simulation, run: comminute.Run) -> None:
    table, points = run.table("points_final.csv"), simulation.points
    columns = {"positions": ["x_m", "y_m", "z_m"], "velocities": ["vx_m_s", "vy_m_s", "vz_m_s"], "volumes": ["volume_m3"]}
    for name, names in {**columns, "plastic_strains": ["plastic_strain"], "ids": ["id"]}.items():
        found = table[names].to_numpy()
        np.testing.assert_array_equal(written(getattr(points, name)).reshape(found.shape), found, err_msg=name)
    mean = np.trace(points.stresses, axis1=1, axis2=2) / 3
    np.testing.assert_allclose(mean, 1e3 * table["p_kPa"], rtol=1e-8, atol=1e-9)
    np.testing.assert_array_equal(points.stresses, points.stresses.transpose(0, 2, 1))


def same_bodies(simulation: comminute.Simulation, run: comminute.Run) -> None:
    """The bodies at the end, as far as the nine digits of ``blocks.csv`` go."""
    table = run.table("blocks.csv")
    last = table[table["step"] == table["step"].iloc[-1]]
    assert len(last) == len(simulation.bodies)
    for body, (_, row) in zip(simulation.bodies, last.iterrows(), strict=True):
        for name, columns in (
            ("position", ["x_m", "y_m", "z_m"]),
            ("orientation", ["q_w", "q_x", "q_y", "q_z"]),
            ("velocity", ["vx_m_s", "vy_m_s", "vz_m_s"]),
            ("spin", ["wx_rad_s", "wy_rad_s", "wz_rad_s"]),
        ):
            np.testing.assert_allclose(getattr(body, name), row[columns].astype(float), rtol=1e-8, atol=1e-300, err_msg=name)
        for name, force in body.forces.items():
            columns = [f"{'blocks' if name == 'bodies' else name}_{axis}_N" for axis in "xyz"]
            if name != "joints":
                np.testing.assert_allclose(force, row[columns].astype(float), rtol=1e-8, atol=1e-300, err_msg=name)


@pytest.mark.parametrize(
    ("file", "sets"),
    [
        ("mpm/triaxial_fine_small.toml", {"test.axial_strain": 0.002, "records.rows": 20}),
        ("mpm/triaxial_cylinder.toml", {"grid.cell_mm": 12.5, "test.axial_strain": 0.002, "records.rows": 7}),
        ("mpm/column_collapse_2d.toml", {"duration_s": 0.05, "grid.cell_mm": 10.0}),
        ("mixture/oedometer_crushing.toml", {"grid.cell_mm": 2.5}),
        ("mixture/rocks_drop.toml", {"duration_s": 0.013, "records.rows": 20}),
        ("blocks/oedometer.toml", {"block_set[0].count": 8, "block_set[0].max_mm": [60.0] * 3, "test.axial_strain": 0.03, "records.rows": 30}),
    ],
)
def test_steps_have_the_bits_of_the_command(command, tmp_path, file, sets):
    scene = comminute.Scene.load(ROOT / "experiments" / file, sets)
    run = made(command, scene, tmp_path)
    simulation = comminute.Simulation(scene, threads=1)
    assert simulation.steps == 0 and simulation.stage == run.history["stage"].iloc[0]
    followed(simulation, run)
    assert len(simulation.points) == run.summary["points"]
    if len(simulation.points):
        same_points(simulation, run)
    if len(simulation.ids):
        same_grains(simulation, run.grains)
    if len(simulation.bodies):
        same_bodies(simulation, run)
    for ours, name in ((simulation.breakages, "breakage.csv"), (simulation.body_breakages, "block_breakage.csv")):
        if name in run.tables:
            theirs = run.table(name)
            assert simulation.crush_events == len(ours) == len(theirs) > 0 and list(ours.columns) == list(theirs.columns)
            np.testing.assert_allclose(ours["force_N"], theirs["force_N"], rtol=1e-8)
    # and on, beyond the end
    steps = simulation.steps
    simulation.step(5)
    assert simulation.steps >= steps + 5 and simulation.is_over


def test_a_specimen_grows_as_in_a_run_or_is_read(command, tmp_path):
    small = {"growth.fines_diameter_mm": [3.4, 3.6], "grid.cell_mm": 6.25, "growth.friction": 0.1, "test.axial_strain": 0.0005}
    scene = comminute.Scene.load(ROOT / "experiments/mixture/twin_points.toml", {**small, "records.rows": 5})
    run = made(command, scene, tmp_path)
    grown = comminute.Simulation(scene)
    scene["specimen.file"] = tmp_path / "out/specimen.csv"
    read = comminute.Simulation(scene)
    for simulation in (grown, read):
        # settling writes rows of its own: the last row is that of the end
        while not simulation.is_over:
            simulation.step()
        same_row(simulation.row(), run.history)
        same_points(simulation, run)
        same_grains(simulation, run.grains)


def test_plates_are_driven_from_python():
    """An elastic column is pressed by hand, let go to a stress, and follows σ = M ln(h/h₀)."""
    simulation = comminute.Simulation(comminute.Scene(COLUMN))
    assert list(simulation.walls) == ["x_low", "x_high", "y_low", "y_high", "bottom", "top"]
    platen, modulus = simulation.platen, 10e6 * 0.7 / (1.3 * 0.4)
    assert not simulation.driven and platen.area == pytest.approx(4e-4) and simulation.volume == pytest.approx(1.2e-5)
    platen.velocity = 0.05
    assert simulation.driven and simulation.stage == "driven" and platen.velocity == 0.05
    while platen.displacement < 3e-4:
        simulation.step(10)
    platen.velocity = 0.0
    simulation.step(3000)
    assert not simulation.is_over
    # the first row is a mean from the start on, the second one over the steps since
    first = simulation.row()
    assert first["stage"] == "driven" and 0.005 < first["axial_strain"]
    assert simulation.row() == first
    simulation.step(500)
    row = simulation.row()
    # the contacts of the points with the plate give way as well
    assert first["axial_strain"] < row["axial_strain"] < 0.01
    strain = np.log(1 / (1 - row["axial_strain"]))
    assert platen.stress == pytest.approx(modulus * strain, rel=0.02)
    assert 1e3 * row["sigma_v_kPa"] == pytest.approx(platen.stress, rel=0.01)
    assert simulation.walls["bottom"].stress == pytest.approx(platen.stress, rel=0.01)
    assert simulation.walls["x_high"].stress == pytest.approx(platen.stress * 3 / 7, rel=0.02)
    mean = np.average(simulation.points.stresses, axis=0, weights=simulation.points.volumes)
    assert mean[2, 2] == pytest.approx(platen.stress, rel=0.02) and platen.work > 0
    platen.hold(50e3)
    simulation.step(6000)
    assert platen.stress == pytest.approx(50e3, rel=0.02)
    with pytest.raises(errors.InputError, match="bottom is a side of the specimen that stands still"):
        simulation.walls["bottom"].velocity = 1e-3


def test_bodies_and_walls_are_driven_from_python():
    simulation = comminute.Simulation(comminute.Scene(PRESSED))
    plate, box = simulation.bodies
    assert plate.driven and not box.driven and repr(plate) == "<Body 0: box, driven>" and len(simulation.bodies) == 2
    assert list(simulation.walls) == ["wall_0", "y_low"]
    with pytest.raises(errors.InputError, match="body = 1: moves freely"):
        box.velocity = [0.0, 0.0, 1.0]
    with pytest.raises(errors.InputError, match="y_low is a side of the grid"):
        simulation.walls["y_low"].velocity = 1.0
    with pytest.raises(ValueError, match="must be three numbers"):
        plate.velocity = 1.0
    with pytest.raises(errors.InputError, match="velocity"):
        plate.velocity = [0.0, 0.0, float("inf")]
    with pytest.raises(IndexError, match="there are 2"):
        simulation.bodies[2]
    assert not simulation.driven
    plate.velocity = [0.0, 0.0, -0.5]
    start, weight = plate.position, 9.81 * simulation.points.masses.sum()
    while plate.position[2] > start[2] - 2.5e-3:
        simulation.step(20)
    assert plate.position[2] == pytest.approx(start[2] - 0.5 * simulation.time, rel=1e-9)
    # the plate presses on the points, the points on the floor
    assert plate.forces["points"][2] > 10 * weight and abs(plate.force[0]) < 0.05 * plate.force[2]
    assert simulation.walls["wall_0"].force > 5 * weight
    stresses = simulation.points.stresses
    assert np.average(stresses[:, 2, 2], weights=simulation.points.volumes) > 0
    corners, triangles = plate.surface
    # rounded corners: within the box, and a closed surface
    assert (np.abs(corners - plate.position) < [0.02501, 0.02501, 0.00501]).all() and len(triangles) == 12
    assert simulation.row()["driven_work_J"] > 0
    # a turn of its own
    plate.velocity, plate.spin = [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]
    before, time = plate.position, simulation.time
    simulation.step(50)
    angle = 2.0 * (simulation.time - time)
    np.testing.assert_allclose(plate.position, before)
    np.testing.assert_allclose(plate.orientation, [np.cos(angle / 2), 0, 0, np.sin(angle / 2)], atol=1e-9)
    # the floor moves up
    floor = simulation.walls["wall_0"]
    floor.velocity = 0.1
    time = simulation.time
    simulation.step(50)
    assert floor.displacement == pytest.approx(0.1 * (simulation.time - time), rel=1e-9) and floor.velocity == 0.1
    with pytest.raises(errors.InputError, match="a plane of a free scene has no area"):
        floor.hold(1e3)


def test_a_wall_holds_a_stress_on_points():
    """A wall comes down on soil that rests on another one."""
    walls = [*PRESSED["wall"], {"kind": "plane", "point_m": [0.0, 0.0, 0.0201], "normal": [0.0, 0.0, -1.0]}]
    scene = {key: value for key, value in PRESSED.items() if key != "block"}
    simulation = comminute.Simulation(comminute.Scene({**scene, "wall": walls, "damping.local": 0.3}))
    floor, top = simulation.walls["wall_0"], simulation.walls["wall_1"]
    with pytest.raises(errors.InputError, match="max_velocity = None: is missing"):
        top.hold(-5e3, area=1.6e-3)
    with pytest.raises(errors.InputError, match="gain"):
        top.hold(5e3, area=1.6e-3, gain=2.0)
    assert not simulation.driven
    top.hold(5e3, area=1.6e-3)
    simulation.step(2000)
    weight = 9.81 * simulation.points.masses.sum()
    assert top.area == 1.6e-3 and top.stress == pytest.approx(5e3, rel=0.03) and top.displacement > 0
    assert floor.force == pytest.approx(top.force + weight, rel=0.05)
    assert simulation.walls["y_low"].force == 0.0


def test_force_and_torque_are_what_moves_a_body():
    """A tilted cube falls on another one and on the floor: its velocity and spin change by force and torque times the step."""
    cube = {"shape": "box", "size_mm": [20.0, 20.0, 20.0]}
    blocks = [
        {**cube, "position_mm": [0.0, 0.0, 18.0], "axis": [1.0, 2.0, 0.5], "angle_deg": 30.0, "velocity_m_s": [0.2, 0.0, -1.0]},
        {**cube, "position_mm": [29.0, 3.0, 15.0], "axis": [0.0, 1.0, 0.2], "angle_deg": 20.0, "velocity_m_s": [-1.0, 0.0, -0.5]},
    ]
    material = {key: value for key, value in SOIL.items() if key != "continuum"}
    scene = {key: PRESSED[key] for key in ("kind", "wall", "contact.law", "gravity_m_s2")}
    simulation = comminute.Simulation(comminute.Scene({**scene, "duration_s": 0.02, "block": blocks, "material": material}))
    most = {"walls": 0.0, "bodies": 0.0}
    simulation.step()
    step = simulation.time
    while not simulation.is_over:
        before = [(body.force, body.torque, body.velocity, body.spin) for body in simulation.bodies]
        last, earlier = simulation.time, step
        simulation.step()
        step = simulation.time - last
        # velocities are those between two instants
        dt = 0.5 * (earlier + step)
        for body, (force, torque, velocity, spin) in zip(simulation.bodies, before, strict=True):
            gained = body.mass * ((body.velocity - velocity) / dt + [0.0, 0.0, 9.81])
            np.testing.assert_allclose(gained, force, atol=1e-6 * (1 + np.abs(force).max()))
            # the moment of a cube is the same about all axes
            turned = body.mass * 0.02**2 / 6 * (body.spin - spin) / dt
            np.testing.assert_allclose(turned, torque, atol=1e-6 * (1e-3 + np.abs(torque).max()))
            most = {name: max(most[name], np.abs(body.forces[name]).max()) for name in most}
    assert min(most.values()) > 1.0 and len(simulation.points) == len(simulation.ids) == 0


def test_a_side_of_the_grid_bears_the_weight():
    grid = {"cell_mm": 5.0, "min_mm": [-20.0, -20.0, 0.0], "max_mm": [60.0, 60.0, 40.0], "z_low": "slip"}
    scene = {key: PRESSED[key] for key in ("body", "gravity_m_s2", "material")}
    simulation = comminute.Simulation(comminute.Scene({**scene, "kind": "continuum", "steps": 2000, "grid": grid, "damping.local": 0.5}))
    floor = simulation.walls["z_low"]
    assert list(simulation.walls) == ["z_low"] and floor.normal is not None and list(floor.normal) == [0, 0, 1] and floor.area is None
    simulation.step(2000)
    assert simulation.is_over
    assert floor.force == pytest.approx(9.81 * simulation.points.masses.sum(), rel=0.01)


def test_a_body_that_is_told_its_velocity_goes_as_one_that_begins_with_it():
    told = comminute.Simulation(comminute.Scene(PRESSED))
    told.bodies[0].velocity = [0.0, 0.0, -0.5]
    scene = comminute.Scene(PRESSED)
    given = {**PRESSED, "block": [{**PRESSED["block"][0], "velocity_m_s": [0.0, 0.0, -0.5]}, PRESSED["block"][1]]}
    begun = comminute.Simulation(comminute.Scene(given))
    for simulation in (told, begun):
        while simulation.time < 2e-3:
            simulation.step(10)
    np.testing.assert_allclose(told.points.positions, begun.points.positions, rtol=1e-9)
    np.testing.assert_allclose(told.bodies[1].position, begun.bodies[1].position, rtol=1e-9)
    assert scene.kind == "mixture"


def test_arrays_of_points_are_those_of_their_instant():
    simulation = comminute.Simulation(comminute.Scene(COLUMN))
    points = simulation.points
    before, kept = points.positions, points.positions.copy()
    assert points.positions is before and before.shape == (len(points), 3) and points.stresses.shape == (len(points), 3, 3)
    with pytest.raises(ValueError, match="read-only"):
        before[0, 0] = 1.0
    simulation.step(10)
    assert points.positions is not before and (points.positions != before).any()
    np.testing.assert_array_equal(before, kept)
    np.testing.assert_allclose(points.masses.sum(), 0.6 * 2600 * 1.2e-5, rtol=1e-12)
    np.testing.assert_allclose(points.porosities, 0.4, rtol=1e-3)
    assert (points.materials == 0).all() and (points.plastic_strains == 0).all()
    assert len(simulation.ids) == len(simulation.contacts) == len(simulation.bodies) == 0
    assert re.fullmatch(r"<Simulation of .*: step 10, \d+ points>", repr(simulation))
    with pytest.raises(ValueError, match="points have `points.stresses`"):
        simulation.stress()


def test_the_example_presses_a_plate_into_sand(capsys):
    main = runpy.run_path(str(ROOT / "python/examples/plate_into_sand.py"))["main"]
    depth, force = main([]).T
    # nothing before it touches; then of the size of the bearing capacity of a strip of 44 mm at the surface, γ B²/2 Nγ with Nγ of 30 to 60
    gravity = 9.81 * 0.6 * 2650.0 * 0.044**2 / 2
    assert (force[depth < 0] == 0).all() and depth.max() == pytest.approx(5e-3, rel=0.02)
    assert 25 * gravity < force[depth > 3.2e-3].mean() < 75 * gravity
    # it has been lifted on the way
    assert (np.diff(depth) < 0).any() and "N/m" in capsys.readouterr().out
