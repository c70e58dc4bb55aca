"""LAMMPS (Debian package `lammps`, pair style granular), with MPI on more than one core.

Two of its numbers mean something else than in the other codes; the script writes those that make the law the same:

- Tsuji damping takes a restitution through a polynomial fit, and is weaker than the law of the case at the same number;
- walls are too stiff in older versions (E / 2 (1 - nu) instead of E / 2 (1 - nu^2): 12 % here, and 1.1 % of the stress after 3500
  steps), so one grain is pressed on a wall first, and Young's modulus of the walls divided by the excess of its force.
"""

import math
import re
import shutil

from common import (
    DENSITY,
    FRICTION,
    PLATEN_SPEED,
    POISSON,
    RESTITUTION,
    SKIN,
    STEPS,
    TIME_STEP,
    WARM_UP,
    YOUNG,
    Failed,
    execute,
    mpi,
    package_version,
    read_log,
)

NAME = "LAMMPS"


def find():
    return shutil.which("lmp") or shutil.which("lammps")


def version(program):
    own = re.search(r"Simulator - (.*)", execute([program, "-h"], "."))
    return ", ".join(filter(None, [own and own.group(1).strip(), package_version("lammps")])) or "unknown version"


def run(program, packing, cores, folder, options):
    packing.write_data(folder / "packing.data", 1)
    (folder / "in.txt").write_text(script(packing, wall_excess(program, folder)))
    execute([*mpi(cores), program, "-in", "in.txt", "-log", "log.txt", "-screen", "none"], folder)
    return read_log(packing, folder / "log.txt")


def tsuji(restitution):
    """Damping over sqrt(effective mass x 4/3 E* contact radius), as LAMMPS takes it from a restitution."""
    fit = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    return sum(c * restitution**k for k, c in enumerate(fit))


def damping_number():
    """The restitution to write, for the damping sqrt(5) ln(1/e) / sqrt(pi^2 + ln(e)^2) of the case."""
    log = math.log(1.0 / RESTITUTION)
    wanted = math.sqrt(5.0) * log / math.hypot(math.pi, log)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if tsuji(middle) > wanted else (low, middle)
    return low


def contact(young, friction):
    """Parameters of pairs or of walls."""
    # sqrt(8 G* / 2 E*): both dampings are the same share of the critical one of their spring
    tangential = math.sqrt(4.0 * (1.0 - POISSON) / (2.0 - POISSON))
    normal = f"hertz/material {young!r} {damping_number():.9f} {POISSON}"
    return f"{normal} tangential mindlin NULL {tangential:.9f} {friction} damping tsuji"


def wall_excess(program, folder):
    """Force of one grain on a wall over what Hertz has it be."""
    radius, overlap = 1e-3, 1e-5
    (folder / "wall.txt").write_text(
        f"""
units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
region all block -0.01 0.01 -0.01 0.01 -0.01 0.01
create_box 1 all
create_atoms 1 single 0 0 {radius - overlap!r}
set group all diameter {2.0 * radius!r} density {DENSITY}
pair_style granular
pair_coeff * * {contact(YOUNG, FRICTION)}
fix move all nve/sphere
fix wall all wall/gran granular {contact(YOUNG, 0.0)} zplane 0.0 NULL
compute push all reduce sum fz
thermo_style custom step atoms c_push
run 0
"""
    )
    execute([program, "-in", "wall.txt", "-log", "wall.log", "-screen", "none"], folder)
    line = re.search(r"^\s*0\s+1\s+(\S+)\s*$", (folder / "wall.log").read_text(), re.M)
    if not line:
        raise Failed("one grain on a wall: no force in the log")
    hertz = 4.0 / 3.0 * YOUNG / (2.0 * (1.0 - POISSON**2)) * math.sqrt(radius) * overlap**1.5
    return float(line.group(1)) / hertz


def script(packing, excess):
    wall = f"granular {contact(YOUNG / excess, 0.0)}"
    return f"""
units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
read_data packing.data
neighbor {SKIN} bin
neigh_modify delay 0 every 1 check yes
timestep {TIME_STEP}
pair_style granular
pair_coeff * * {contact(YOUNG, FRICTION)}
fix move all nve/sphere
fix side all wall/gran {wall} zcylinder {packing.radius!r}
fix bottom all wall/gran {wall} zplane {packing.bottom!r} NULL
variable sunk equal {-PLATEN_SPEED * TIME_STEP!r}*step
region top plane 0 0 {packing.top!r} 0 0 -1 side in move NULL NULL v_sunk
fix top all wall/gran/region {wall} region top
compute stress all pressure NULL virial
thermo_style custom step atoms c_stress[3] vol
thermo {STEPS}
thermo_modify lost error norm no
run {WARM_UP}
run {STEPS}
"""
