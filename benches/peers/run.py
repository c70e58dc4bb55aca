#!/usr/bin/env python3
"""Measures peer DEM codes and comminute on the same packing and law, in turn, and prints ratios. See README.md."""

import argparse
import datetime
import json
import os
import platform
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.dont_write_bytecode = True

import comminute
import lammps
import liggghts
import yade_case
from common import STEPS, WARM_UP, Failed

CODES = {"comminute": comminute, "liggghts": liggghts, "lammps": lammps, "yade": yade_case}
# part of its stress by which a code may be off the reference
TOLERANCE = 0.005
REFERENCE = "liggghts"


def main():
    options = arguments()
    programs = {name: code.find(options.comminute) if code is comminute else code.find() for name, code in CODES.items()}
    if programs["comminute"] is None:
        sys.exit("comminute is not there: build it (cargo build --release) or say where it is (--comminute)")
    now = datetime.datetime.now(datetime.timezone.utc)
    report = {
        "date": now.strftime("%Y-%m-%d %H:%M UTC"),
        "machine": machine(),
        "versions": {name: version(CODES[name], programs[name]) for name in options.codes},
        "runs": [],
    }
    for name in options.codes:
        tell(f"{CODES[name].NAME}: {report['versions'][name] or 'not installed'}")
    packings = {}
    for grains in options.grains:
        tell(f"packing of {grains} grains")
        try:
            packings[grains] = comminute.packing(programs["comminute"], grains, options.cache)
        except Failed as error:
            sys.exit(f"no packing of {grains} grains: {error}")
    for turn in range(options.repeats):
        for grains in options.grains:
            for cores in options.threads:
                for name in options.codes:
                    if programs[name]:
                        report["runs"].append(one(name, programs[name], packings[grains], cores, turn, options))
        cases = [(grains, cores) for grains in options.grains for cores in options.threads]
        report["rows"] = [row for case in cases for row in rows(report, options, *case)]
        if options.out:
            options.out.with_suffix(".json").write_text(json.dumps(report, indent=1) + "\n")
            options.out.with_suffix(".md").write_text(markdown(report))
    print(markdown(report), end="")


def arguments():
    names = lambda text: text.split(",")
    numbers = lambda text: [int(x) for x in names(text)]
    parser = argparse.ArgumentParser(description=__doc__)
    add = parser.add_argument
    add("--grains", type=numbers, default=[5000, 50000], metavar="N,N", help="grains of the packings [5000,50000]")
    add("--threads", type=numbers, default=[1, 2], metavar="N,N", help="cores to run on [1,2]")
    add("--repeats", type=int, default=3, metavar="N", help="rounds, each with one run of every code [3]")
    add("--codes", type=names, default=list(CODES), metavar="CODE,CODE", help=f"[{','.join(CODES)}]")
    add("--comminute", metavar="PATH", help="the program [target/release/comminute, or that of the path]")
    add("--cache", type=Path, default=Path("runs/bench"), metavar="DIR", help="folder of the packings [runs/bench]")
    add("--yade-steps", type=int, default=STEPS, metavar="N", help=f"timed steps of Yade; no check of its stress below [{STEPS}]")
    add("--wait", type=float, default=0.0, metavar="SECONDS", help="before a run, wait so long for other programs to end [0]")
    add("--work", type=Path, metavar="DIR", help="folder to keep inputs and logs of the last round in")
    add("--out", type=Path, metavar="NAME", help="writes NAME.md and NAME.json after each round")
    options = parser.parse_args()
    unknown = [name for name in options.codes if name not in CODES]
    if unknown:
        parser.error(f"no such code: {unknown[0]}")
    # ratios need the one, checks the other
    options.codes = [name for name in CODES if name in options.codes or name in ("comminute", REFERENCE)]
    options.cache = options.cache.resolve()
    return options


def version(code, program):
    try:
        return code.version(program) if program else None
    except Failed:
        return "unknown version"


def one(name, program, packing, cores, turn, options):
    """One run of one code, as an entry of the report."""
    run = {"code": name, "grains": len(packing), "cores": cores, "round": turn, "load": load()}
    wait_for_others(options.wait)
    meter = Others()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.work / f"{name}-{len(packing)}-{cores}" if options.work else Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.iterdir():
            old.unlink()
        try:
            result = CODES[name].run(program, packing, cores, folder.resolve(), options)
            run.update(speed=result.speed, stress_kPa=result.stress, step=result.step, note=result.note)
        except Failed as error:
            run["failed"] = str(error)
    run["others"] = meter.cores()
    figure = f"{1e-6 * run['speed']:.2f} M grain-steps/s" if "speed" in run else f"failed: {run['failed']}"
    tell(f"round {turn + 1}: {CODES[name].NAME}, {len(packing)} grains, {cores} cores: {figure}")
    return run


def rows(report, options, grains, cores):
    """The lines of the table for one packing and number of cores."""
    here = [run for run in report["runs"] if (run["grains"], run["cores"]) == (grains, cores)]
    mine = {name: [run for run in here if run["code"] == name] for name in options.codes}
    good = {name: {r["round"]: r for r in runs if "speed" in r} for name, runs in mine.items()}
    stress = {name: next((r["stress_kPa"] for r in runs.values()), None) for name, runs in good.items()}
    checks = {name: check(name, stress[name], stress[REFERENCE]) for name in options.codes}
    for name in options.codes:
        row = {"grains": grains, "cores": cores, "code": name, "stress_kPa": stress[name]}
        if not mine[name]:
            verdict = "not installed"
        elif not good[name]:
            verdict = "failed: " + mine[name][-1]["failed"]
        else:
            row["speed"] = spread([r["speed"] for r in good[name].values()])
            both = sorted(good[name].keys() & good["comminute"].keys())
            row["ratio"] = spread([good["comminute"][k]["speed"] / good[name][k]["speed"] for k in both])
            row["off"], verdict = checks[name]
            notes = sorted({r["note"] for r in good[name].values()} - {""})
            if checks["comminute"][1] == "void" and name != "comminute":
                notes.append("void for comminute's stress")
            busy = sum(any(disturbed(r, report["machine"]) for r in (good[name][k], good["comminute"][k])) for k in both)
            if busy:
                notes.append(f"machine busy in {busy} of {len(both)} rounds")
            verdict = ", ".join([verdict, *notes])
        yield {**row, "verdict": verdict}


def check(name, stress, reference):
    """How far a stress is off the reference, and what that makes of the row."""
    if name == REFERENCE:
        return None, "reference"
    if stress is None:
        return None, "speed only"
    if reference is None:
        return None, "unchecked"
    off = stress / reference - 1.0
    return off, "valid" if abs(off) <= TOLERANCE else "void"


def disturbed(run, machine):
    """Whether other programs took what the run needed: processes that wait for one another spin, and then lose far more than that."""
    return run["others"] is not None and run["others"] > machine["cores"] - run["cores"] + 0.1


def spread(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values)} if values else None


def markdown(report):
    machine = report["machine"]
    rounds = 1 + max(run["round"] for run in report["runs"])
    loads = [run["load"] for run in report["runs"] if run["load"] is not None]
    versions = [f"{CODES[name].NAME} {v or '(not installed)'}" for name, v in report["versions"].items()]
    busy = f"; load average {min(loads):.1f} to {max(loads):.1f} before the runs" if loads else ""
    heads = [
        "grains",
        "cores",
        "code",
        "M grain-steps/s, median (min - max)",
        "comminute / code, median (min - max)",
        f"σ_zz after {WARM_UP + STEPS} steps, kPa",
        f"off {CODES[REFERENCE].NAME}",
        "row",
    ]
    lines = [
        f"{machine['processor']}, {machine['cores']} cores, {machine['system']}; {report['date']}; rounds: {rounds}{busy}.",
        "; ".join(versions) + ".",
        "",
        "| " + " | ".join(heads) + " |",
        "|--:|--:|---|--:|--:|--:|--:|---|",
    ]
    for row in report["rows"]:
        void = "void" in row["verdict"]
        cells = [
            row["grains"],
            row["cores"],
            CODES[row["code"]].NAME,
            figures(row.get("speed"), 1e-6),
            "void" if void else figures(row.get("ratio") if row["code"] != "comminute" else None),
            "-" if row["stress_kPa"] is None else f"{row['stress_kPa']:.3f}",
            "-" if row.get("off") is None else f"{100.0 * row['off']:+.2f} %",
            row["verdict"].replace("|", "/"),
        ]
        lines.append("| " + " | ".join(str(cell) for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def figures(spread, scale=1.0):
    if spread is None:
        return "-"
    middle, low, high = (scale * spread[key] for key in ("median", "min", "max"))
    return f"{middle:.2f} ({low:.2f} - {high:.2f})"


def machine():
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    system = f"{platform.system()} {platform.machine()}"
    return {"processor": names[0] if names else platform.processor(), "cores": os.cpu_count(), "system": system}


def load():
    """Load average of the last minute, where the system tells."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


class Others:
    """How many cores all other programs kept busy (Linux), from here to the call of `cores`."""

    def __init__(self):
        self.start = self.now()

    @staticmethod
    def now():
        """Clock, and processor time of the machine and of the programs this one has run, s."""
        stat = Path("/proc/stat")
        if not stat.exists():
            return None
        # user, nice, system, idle, wait for disks, interrupts (two kinds), steal
        columns = [int(x) for x in stat.read_text().splitlines()[0].split()[1:9]]
        busy = (sum(columns) - columns[3] - columns[4]) / os.sysconf("SC_CLK_TCK")
        own = os.times()
        return time.monotonic(), busy, sum(own[:4])

    def cores(self):
        if self.start is None:
            return None
        seconds, busy, own = (after - before for before, after in zip(self.start, self.now()))
        return max(0.0, busy - own) / seconds


def wait_for_others(seconds):
    """Waits until other programs keep less than a tenth of a core busy, or for so long."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        meter = Others()
        time.sleep(2.0)
        if (meter.cores() or 0.0) < 0.1:
            return


def tell(text):
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
