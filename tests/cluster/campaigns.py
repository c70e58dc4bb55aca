"""What tests of campaigns share, whoever starts the runs."""

import csv
import json
import os
import subprocess
import time
from pathlib import Path

SEEDS = int(os.environ.get("COMMINUTE_SLURM_SEEDS", "4"))
# what depends on the machine, as in tests/common/left.rs
OF_THE_MACHINE = ("second", "predicted_", "peak_memory", "minutes", "bytes_", "threads", "host", "simd", "version")


def lasting(name: str) -> bool:
    return not any(word in name for word in OF_THE_MACHINE)


def files(folder: Path) -> dict[str, object]:
    """What a campaign has left, without what depends on the machine and without its notes about the queue."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_dir() or name.startswith(("slurm/", "hyperqueue/")):
            continue
        if path.suffix == ".json":
            values = json.loads(path.read_text())
            found[name] = {key: value for key, value in values.items() if lasting(key)}
        elif path.name == "runs.csv":
            with path.open(newline="") as table:
                found[name] = [{key: value for key, value in row.items() if lasting(key)} for row in csv.DictReader(table)]
        else:
            found[name] = path.read_bytes()
    return found


def ensemble(command: str, scene: Path, *words: str, out: str = "slurm") -> list[str]:
    return [command, "ensemble", str(scene), "--seeds", f"1..{SEEDS}", "--out", str(scene.parent / out), *words]


def call(environment: dict[str, str], words: list[str], code: int) -> str:
    """What a command says that must end with this exit code."""
    ended = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == code, ended.stderr
    return ended.stderr


def wait_for(what, seconds: float = 60) -> None:
    until = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < until, "nothing comes of it"
        time.sleep(0.02)


def begun(runs: Path) -> list[Path]:
    """Runs in the middle: with a checkpoint."""
    return list(runs.glob("seed-*/checkpoint.bin"))
