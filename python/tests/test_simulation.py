"""Tests made step by step: bits of the command's runs, driven walls, arrays, stresses."""

import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import comminute
from comminute import errors
from conftest import ROOT, SMALL

MATERIAL = {
    "name": "rubber",
    "grain": {"density_kg_m3": 1100.0},
    "elastic": {"E_GPa": 0.5, "nu": 0.45},
    "contact": {"friction": 0.5},
}

# two grains of different size thrown at each other over a floor, between walls of which one moves
FREE = {
    "kind": "assembly",
    "steps": 3000,
    "gravity_m_s2": [0.0, 0.0, -9.81],
    "contact.law": "hertz",
    "grain": [
        {"position_m": [-0.012, 0.001, 0.0105], "radius_m": 0.01, "velocity_m_s": [0.5, 0.0, 0.0]},
        {"position_m": [0.012, 0.0, 0.0085], "radius_m": 0.008, "velocity_m_s": [-0.5, 0.1, 0.0]},
    ],
    "wall": [
        {"kind": "plane", "point_m": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
        {"kind": "plane", "point_m": [0.03, 0.0, 0.0], "normal": [-1.0, 0.0, 0.0], "velocity_m_s": 0.05},
    ],
    "material": MATERIAL,
}

# one grain between two planes that touch it; a step is a unit of time
BETWEEN = {
    "kind": "assembly",
    "steps": 1,
    "contact.law": "hertz",
    "stepping.inertia_scaling": True,
    "damping.local": 0.5,
    "grain": [{"position_m": [0.0, 0.0, 0.01], "radius_m": 0.01}],
    "wall": [
        {"kind": "plane", "point_m": [0.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]},
        {"kind": "plane", "point_m": [0.0, 0.0, 0.02], "normal": [0.0, 0.0, -1.0]},
    ],
    "material": MATERIAL,
}


def hertz(overlap: float) -> float:
    """Force, N, between a rigid plane and the grain of ``BETWEEN``."""
    return 4 / 3 * 0.5e9 / (1 - 0.45**2) * 0.01**0.5 * overlap**1.5


def same_grains(simulation: comminute.Simulation, table) -> None:
    for name, columns in (
        ("positions", ("x_m", "y_m", "z_m")),
        ("velocities", ("vx_m_s", "vy_m_s", "vz_m_s")),
        ("spins", ("wx_rad_s", "wy_rad_s", "wz_rad_s")),
    ):
        np.testing.assert_array_equal(getattr(simulation, name), table[list(columns)].to_numpy(), err_msg=name)
    np.testing.assert_array_equal(simulation.radii, table["r_m"])


def same_row(row: dict, table) -> None:
    """The row of the instant, and that of the history at its step: nine digits."""
    written = table[table["step"] == row["step"]].iloc[0]
    assert list(row) == list(table.columns)
    for column, value in row.items():
        expected = written[column]
        if isinstance(value, str):
            assert value == expected
        else:
            assert value == pytest.approx(expected, rel=1e-8, abs=1e-300, nan_ok=True), column


@pytest.mark.parametrize("threads", [1, 2])
def test_a_free_scene_has_the_bits_of_the_command(command, tmp_path, threads):
    scene = comminute.Scene(FREE)
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    subprocess.run([command, "run", tmp_path / "scene.toml", "--quiet", "--threads", "2", "--out", tmp_path / "out"], check=True)
    run = comminute.Run.open(tmp_path / "out")
    simulation = comminute.Simulation(scene, threads=threads)
    assert (simulation.steps, simulation.is_over) == (0, False)
    same_row(simulation.row(), run.history)
    simulation.step(3000)
    assert simulation.is_over and simulation.time == pytest.approx(run.history["time_s"].iloc[-1], rel=1e-8)
    same_row(simulation.row(), run.history)
    # a run writes its last record, and then ends with its last step
    simulation.step()
    same_grains(simulation, run.grains)
    assert simulation.walls[1].displacement > 0


def test_a_specimen_has_the_bits_of_a_run(run, coke):
    simulation = comminute.Simulation(coke, threads=1)
    first = run.history.iloc[0]
    assert simulation.steps == first["step"] == 500
    # the last row is that of the end
    for step in run.history["step"]:
        assert not simulation.is_over
        simulation.step(int(step) - simulation.steps)
        same_row(simulation.row(), run.history)
    assert simulation.is_over
    simulation.step()
    same_grains(simulation, run.grains)
    ours, theirs = simulation.breakages, run.breakage
    assert simulation.crush_events == len(ours) == len(theirs) > 0
    assert list(ours.columns) == list(theirs.columns) and ours.attrs["units"] == theirs.attrs["units"]
    for column in ("event", "step", "mother"):
        assert list(ours[column]) == list(theirs[column])
    np.testing.assert_allclose(ours["force_N"], theirs["force_N"], rtol=1e-8)


def test_a_driven_wall_follows_what_it_is_told():
    simulation = comminute.Simulation(comminute.Scene(BETWEEN))
    bottom, top = simulation.walls.values()
    assert top.stress is None and top.normal is not None and list(top.normal) == [0, 0, -1]
    top.velocity = 1e-8
    assert simulation.driven and top.velocity == 1e-8
    for way in (2.5e-5, 5e-5, 1e-4):
        top.velocity = 1e-8
        simulation.step(round((way - top.displacement) / 1e-8))
        top.velocity = 0.0
        simulation.step(2000)
        assert top.displacement == pytest.approx(way, rel=1e-9)
        assert top.position[2] == pytest.approx(0.02 - way, rel=1e-9)
        assert bottom.displacement == 0.0
        # half of the way is the overlap on either side
        for wall in (bottom, top):
            assert wall.force == pytest.approx(hertz(0.5 * way), rel=1e-6)
        assert np.abs(simulation.forces).max() < 1e-6 * top.force
        contacts = simulation.contacts
        assert list(contacts["wall"]) == [True, True] and sorted(contacts["other"]) == [0, 1]
        np.testing.assert_allclose(contacts["normal_force"], hertz(0.5 * way), rtol=1e-6)
        # Love and Weber over a unit volume: the force along the distance of the two contacts
        np.testing.assert_allclose(simulation.stress(1.0)[2, 2], top.force * (0.02 - way), rtol=1e-6)
    # and back, until they part
    top.velocity = -1e-7
    simulation.step(2000)
    assert top.force == 0.0 and top.displacement == pytest.approx(-1e-4, rel=1e-6)


def test_a_wall_holds_a_stress():
    simulation = comminute.Simulation(comminute.Scene(BETWEEN))
    top = simulation.walls["wall_1"]
    top.hold(50e3, area=4e-4)
    simulation.step(5000)
    assert top.area == 4e-4 and top.stress == pytest.approx(50e3, rel=1e-4)
    assert top.force == pytest.approx(20.0, rel=1e-4)
    assert hertz(0.5 * top.displacement) == pytest.approx(20.0, rel=1e-3)


def test_a_specimen_is_driven_from_python(coke):
    """Compression at a rate of one's own: the ring stands still, stresses rise, and the mean stress is that on the walls."""
    coke["crushing.enabled"] = False
    simulation = comminute.Simulation(coke)
    platen, ring = simulation.platen, simulation.walls["cylinder"]
    height = simulation.row()["height_mm"] * 1e-3
    begin = platen.stress
    assert begin == pytest.approx(5e3, rel=0.2) and not simulation.driven
    rate = 1e-3 / simulation.inertial_time(50e3)
    platen.velocity = rate * height
    steps = round(0.01 / rate)
    simulation.step(steps)
    assert platen.displacement == pytest.approx(0.01 * height, rel=1e-3)
    assert ring.displacement == simulation.walls["bottom"].displacement == 0.0
    platen.velocity = 0.0
    simulation.step(3000)
    row = simulation.row()
    assert (row["stage"], np.isnan(row["target_kPa"])) == ("driven", True)
    assert row["axial_strain"] == pytest.approx(0.01, rel=1e-3)
    assert platen.stress > 4 * begin and ring.stress > 2 * begin
    stress = simulation.stress()
    np.testing.assert_allclose(stress, stress.T, atol=0.02 * stress[2, 2])
    assert stress[2, 2] == pytest.approx(1e3 * row["sigma_v_kPa"], rel=0.01)
    assert 0.5 * (stress[0, 0] + stress[1, 1]) == pytest.approx(1e3 * row["sigma_h_kPa"], rel=0.01)
    # a triaxial programme of one's own: the cell pressure is let down, and the specimen widens
    ring.hold(0.5 * ring.stress)
    simulation.step(3000)
    assert ring.displacement < 0.0


def test_arrays_are_those_of_their_instant():
    simulation = comminute.Simulation(comminute.Scene(FREE))
    before = simulation.positions
    assert simulation.positions is before and before.shape == (2, 3) and list(simulation.ids) == [0, 1]
    with pytest.raises(ValueError, match="read-only"):
        before[0, 0] = 1.0
    kept = before.copy()
    simulation.step(10)
    assert simulation.positions is not before and (simulation.positions != before).any()
    np.testing.assert_array_equal(before, kept)
    volume = 4 / 3 * np.pi * simulation.radii**3
    np.testing.assert_allclose(simulation.masses, 1100.0 * volume, rtol=1e-12)
    np.testing.assert_allclose(simulation.forces, simulation.masses[:, None] * [[0, 0, -9.81]], rtol=1e-12)
    assert np.isinf(simulation.strengths).all() and (simulation.generations == 0).all()
    assert len(simulation.breakages) == 0 and "force_N" in simulation.breakages.columns


def test_what_cannot_be_is_refused(coke):
    platen = comminute.Scene.load(ROOT / "experiments/platen/petroleum_coke.toml")
    with pytest.raises(errors.InputError, match="to be made step by step"):
        comminute.Simulation(platen)
    simulation = comminute.Simulation(comminute.Scene(BETWEEN))
    with pytest.raises(errors.InputError, match="velocity"):
        simulation.walls[1].velocity = float("nan")
    with pytest.raises(errors.InputError, match="a plane of a free scene has no area"):
        simulation.walls[1].hold(1e3)
    with pytest.raises(KeyError, match="wall_0, wall_1"):
        simulation.walls["top"]
    with pytest.raises(ValueError, match="a free scene has no volume"):
        simulation.stress()
    assert not simulation.driven
    # a grain that is pushed through the floor
    simulation.walls[1].velocity = 1e-3
    with pytest.raises(errors.UnstableError) as lost:
        simulation.step(100)
    with pytest.raises(errors.FailedError, match="a step before has failed"):
        simulation.step()
    assert lost.value.step > 0


CTRL_C = """
import threading, time, comminute
simulation = comminute.Simulation(comminute.Scene({scene!r}))
def tell():
    time.sleep(0.3)
    print("going", flush=True)
threading.Thread(target=tell).start()
try:
    simulation.step(10**12)
except KeyboardInterrupt:
    before = simulation.steps
    simulation.step(5)
    print(before > 0, simulation.steps - before)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_stops_between_two_steps():
    args = [sys.executable, "-P", "-c", CTRL_C.format(scene=BETWEEN)]
    with subprocess.Popen(args, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None and child.stdout.readline() == "going\n"
        child.send_signal(signal.SIGINT)
        assert child.stdout.read() == "True 5\n"


def test_a_specimen_of_a_run_is_used_again(run, coke):
    coke["specimen.file"] = run.folder / "specimen.csv"
    simulation = comminute.Simulation(coke)
    same_row(simulation.row(), run.history)
    assert SMALL["specimen.grains"] == len(simulation.ids)
