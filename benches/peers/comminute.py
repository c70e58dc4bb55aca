"""comminute itself, through `comminute bench`; it also makes the packings."""

import json
import math
import shutil
from pathlib import Path

from common import PLATEN_SPEED, RESTITUTION, STEPS, TIME_STEP, WARM_UP, Failed, Packing, Result, execute

NAME = "comminute"
BLOCKS = 3
# skin of a grain over its radius: pairs are listed up to a gap of twice that
SKIN_OVER_RADIUS = 0.05


def find(given=None):
    """The program that was asked for, or that of the repository, or that of the path."""
    built = Path(__file__).resolve().parents[2] / "target" / "release" / "comminute"
    for program in [given] if given else [str(built), "comminute"]:
        found = shutil.which(program)
        if found:
            return str(Path(found).resolve())
    return None


def version(program):
    return execute([program, "--version"], ".").split()[-1]


def packing(program, grains, cache):
    """The packing of so many grains, made if the folder has none."""
    path = Path(cache) / f"oedometer-{grains}.csv"
    if not path.exists():
        bench(program, grains, 1, cache, ["--warm-up", 0, "--steps", 1, "--repeats", 1])
    return Packing(path)


def run(program, packing, cores, folder, options):
    plan = ["--warm-up", WARM_UP, "--steps", STEPS // BLOCKS, "--repeats", BLOCKS]
    told = bench(program, len(packing), cores, packing.path.parent, [*plan, "--skin", SKIN_OVER_RADIUS])
    case, row = {**told["case"], **told["packings"][0]}, told["rows"][0]
    same = {"time_step_s": TIME_STEP, "platen_speed_m_s": PLATEN_SPEED, "restitution_hertz_viscous": RESTITUTION}
    for key, value in same.items():
        if not math.isclose(case[key], value):
            raise Failed(f"the bench has another case: {key} is {case[key]}, here {value}")
    # all timed steps over all their time, as the other codes have it
    speed = len(row["blocks"]) / sum(1.0 / block for block in row["blocks"])
    return Result(speed, row["stress_kPa"]["volume"], row["steps"])


def bench(program, grains, cores, cache, more):
    what = ["--grains", grains, "--threads", cores, "--law", "hertz_viscous", "--breakages", 0]
    return json.loads(execute([program, "bench", *what, "--cache", cache, *more, "--json", "--quiet"], "."))
