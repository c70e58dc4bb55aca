"""The case that every code runs, and what the scripts share.

The case is that of `comminute bench --law hertz_viscous`: its packing (a CSV with the cylinder in its head), Hertz-Mindlin with
viscous damping, frictionless walls of the grains' own material, no gravity, top platen moving down.
"""

import csv
import math
import os
import re
import subprocess
from collections import namedtuple
from pathlib import Path

YOUNG = 0.8e9
POISSON = 0.12
FRICTION = 0.35
RESTITUTION = 0.3
DENSITY = 2600.0
TIME_STEP = 1.4e-6
PLATEN_SPEED = 5e-3
# gap, m, up to which pairs are listed: 0.1 r
SKIN = 1e-4
WARM_UP = 500
STEPS = 3000
# room, m, between the walls and the box of the codes that have one
MARGIN = 1e-4

# seconds after which a run is given up
PATIENCE = 3600

# Speed in grain-steps per second of wall time; mean vertical stress in kPa, with the step it was taken at, or None; a remark.
Result = namedtuple("Result", "speed stress step note", defaults=[""])


class Failed(Exception):
    """A code that stopped, or that left no figure."""


class Packing:
    """Grains (x, y, z, r: the text of the file, so that no digit is lost) in a cylinder about the z axis."""

    def __init__(self, path):
        lines = Path(path).read_text().splitlines()
        head = dict(re.findall(r"^# (\w+) = (\S+)$", "\n".join(lines), re.M))
        self.path = Path(path).resolve()
        self.radius = float(head["cylinder_radius_m"])
        self.bottom = float(head["bottom_m"])
        self.height = float(head["height_m"])
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        self.grains = [(row["x_m"], row["y_m"], row["z_m"], row["r_m"]) for row in rows]

    def __len__(self):
        return len(self.grains)

    @property
    def top(self):
        return self.bottom + self.height

    def volume(self, steps):
        """Volume inside the walls after so many steps."""
        return math.pi * self.radius**2 * (self.height - PLATEN_SPEED * TIME_STEP * steps)

    def box(self):
        """(low, high) along x, y, z: the walls and a margin."""
        side = self.radius + MARGIN
        return [(-side, side), (-side, side), (self.bottom - MARGIN, self.top + MARGIN)]

    def write_data(self, path, types):
        """The data file that LAMMPS and LIGGGHTS read: id, type, diameter, density, position."""
        with open(path, "w") as out:
            out.write(f"packing of comminute bench\n\n{len(self)} atoms\n{types} atom types\n\n")
            for axis, (low, high) in zip("xyz", self.box()):
                out.write(f"{low!r} {high!r} {axis}lo {axis}hi\n")
            out.write("\nAtoms\n\n")
            for k, (x, y, z, r) in enumerate(self.grains, 1):
                out.write(f"{k} 1 {2.0 * float(r)!r} {DENSITY} {x} {y} {z}\n")


def execute(command, folder, env=None):
    """Runs a command in a folder and gives back its standard output. Libraries with threads of their own get one."""
    command = [str(part) for part in command]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", **(env or {})}
    try:
        done = subprocess.run(
            command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise Failed(str(error)) from error
    if done.returncode != 0:
        last = (done.stdout + done.stderr).strip().splitlines()[-3:]
        raise Failed(f"{command[0]} ended with {done.returncode}: " + " / ".join(last))
    return done.stdout


def mpi(processes):
    """What to put before a command to run it as so many processes."""
    if processes == 1:
        return []
    root = ["--allow-run-as-root"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    return ["mpirun", *root, "--oversubscribe", "--bind-to", "none", "-np", processes]


def read_log(packing, path):
    """The result that a LAMMPS or LIGGGHTS log tells: the loop time of its last run, and the virial stress of its last line, which
    both codes divide by the volume of their box."""
    log = Path(path).read_text()
    loops = re.findall(r"^Loop time of (\S+) on \d+ procs for (\d+) steps", log, re.M)
    table = re.findall(rf"^\s*(\d+)\s+{len(packing)}\s+(\S+)\s+(\S+)\s*$", log, re.M)
    if not loops or not table:
        raise Failed("the log has no loop time or no stress (grains lost?)")
    seconds, steps = loops[-1]
    done, stress, box = (float(x) for x in table[-1])
    return Result(len(packing) * int(steps) / float(seconds), 1e-3 * stress * box / packing.volume(done), int(done))


def package_version(name):
    """Version of an installed Debian package, or an empty string."""
    try:
        done = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", name], capture_output=True, text=True)
    except FileNotFoundError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
