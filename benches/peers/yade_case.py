"""Yade (Debian package `yade`), with OpenMP on more than one core; `yade_script.py` is what Yade runs.

Yade has no round wall to hold grains from outside, so the cylinder is a prism of many plane sides with the same mean radius: grains
meet it a little differently, and the stress beside the speed tells how much that matters.
"""

import json
import math
import shutil
from pathlib import Path

from common import STEPS, WARM_UP, Failed, Result, execute, package_version

NAME = "Yade"
# how far, m, the corners of the prism lie outside of its sides: about the overlap of a grain with the wall
CORNER = 1e-5


def find():
    return shutil.which("yade")


def version(program):
    return package_version("yade") or "unknown version"


def run(program, packing, cores, folder, options):
    steps = options.yade_steps
    task = {
        "grains": [[float(x) for x in grain] for grain in packing.grains],
        "bottom": packing.bottom,
        "top": packing.top,
        "sides": list(prism(packing)),
        "steps": steps,
    }
    (folder / "task.json").write_text(json.dumps(task))
    here = Path(__file__).resolve().parent
    env = {"PYTHONPATH": str(here), "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": str(cores)}
    text = execute([program, "-n", "-x", f"-j{cores}", here / "yade_script.py"], folder, env)
    if not (folder / "told.json").exists():
        raise Failed("no figures: " + " | ".join(text.strip().splitlines()[-4:]))
    told = json.loads((folder / "told.json").read_text())
    speed = len(packing) * steps / told["seconds"]
    if told["step"] != WARM_UP + STEPS:
        return Result(speed, None, told["step"], f"{steps} steps only")
    return Result(speed, 1e-3 * told["force_times_length"] / packing.volume(told["step"]), told["step"])


def prism(packing):
    """Corners of the sides: each a triangle with its base low down and its tip high up, wider than the side, so that a grain meets
    one plane a side."""
    count = math.ceil(math.pi * math.sqrt(packing.radius / (2.0 * CORNER)))
    turn = 2.0 * math.pi / count
    # the mean over a side of the distance from the axis is the radius
    near = packing.radius * (1.0 - turn**2 / 24.0)
    half = packing.radius * turn
    base, tip = packing.bottom - 0.1 * packing.height, packing.bottom + 4.0 * packing.height
    corners = [(-half, base), (half, base), (0.0, tip)]
    for k in range(count):
        c, s = math.cos(k * turn), math.sin(k * turn)
        yield [(near * c - along * s, near * s + along * c, z) for along, z in corners]
