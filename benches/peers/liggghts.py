"""LIGGGHTS (Debian package `liggghts`), with MPI on more than one core."""

import shutil

from common import (
    FRICTION,
    PLATEN_SPEED,
    POISSON,
    RESTITUTION,
    SKIN,
    STEPS,
    TIME_STEP,
    WARM_UP,
    YOUNG,
    execute,
    mpi,
    package_version,
    read_log,
)

NAME = "LIGGGHTS"


def find():
    return shutil.which("liggghts")


def version(program):
    return package_version("liggghts") or "unknown version"


def run(program, packing, cores, folder, options):
    packing.write_data(folder / "packing.data", 2)
    (folder / "top.stl").write_text(plate(1.05 * packing.radius, packing.top))
    (folder / "in.txt").write_text(script(packing))
    # no `-screen none`: reading a mesh under it ends in a crash
    execute([*mpi(cores), program, "-in", "in.txt", "-log", "log.txt"], folder)
    return read_log(packing, folder / "log.txt")


def plate(half, z):
    """A square of two triangles at height z."""
    corners = [(-half, -half), (-half, half), (half, half), (half, -half)]
    text = "solid top\n"
    for three in ((0, 1, 2), (0, 2, 3)):
        text += "facet normal 0 0 -1\nouter loop\n"
        text += "".join(f"vertex {corners[k][0]!r} {corners[k][1]!r} {z!r}\n" for k in three)
        text += "endloop\nendfacet\n"
    return text + "endsolid top\n"


def script(packing):
    """Grains are of type 1, walls of type 2: the same material without friction."""
    law = "model hertz tangential history"
    return f"""
units si
atom_style sphere
boundary f f f
newton off
communicate single vel yes
read_data packing.data
neighbor {SKIN} bin
neigh_modify delay 0 every 1 check yes
timestep {TIME_STEP}
fix young all property/global youngsModulus peratomtype {YOUNG} {YOUNG}
fix poisson all property/global poissonsRatio peratomtype {POISSON} {POISSON}
fix restitution all property/global coefficientRestitution peratomtypepair 2 {" ".join([str(RESTITUTION)] * 4)}
fix friction all property/global coefficientFriction peratomtypepair 2 {FRICTION} 0 0 0
pair_style gran {law}
pair_coeff * *
fix move all nve/sphere
fix side all wall/gran {law} primitive type 2 zcylinder {packing.radius!r} 0 0
fix bottom all wall/gran {law} primitive type 2 zplane {packing.bottom!r}
fix plate all mesh/surface file top.stl type 2
fix top all wall/gran {law} mesh n_meshes 1 meshes plate
fix press all move/mesh mesh plate linear 0 0 {-PLATEN_SPEED}
compute stress all pressure thermo_temp virial
thermo_style custom step atoms c_stress[3] vol
thermo {STEPS}
thermo_modify lost error norm no
run {WARM_UP}
run {STEPS}
"""
