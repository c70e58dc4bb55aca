"""What the tests share: the command, a scene that takes a second, and a cluster."""

import os
import shutil
from pathlib import Path

import pytest

from slurm import Cluster, missing

ROOT = Path(__file__).parents[2]

# a small crushable specimen, pressed long enough to be caught in the middle
SCENE = f"""
base = "{ROOT}/experiments/petroleum_coke/h-c-2.toml"
name = "small"
[specimen]
scale = 4.0
grains = 100
porosity = 0.48
[preparation]
growth_friction = 0.4
growth_steps = 1000
porosity_tolerance = 0.05
max_steps = 30000
[loading]
max_stress_kPa = 100.0
programme = "adaptive"
settle_steps = 100
[records]
at_kPa = []
figures = false
snapshots = false
checkpoint_seconds = 0.02
[material]
base = "{ROOT}/materials/petroleum_coke.toml"
[material.strength.fixed_angle]
sigma_lim0_MPa = 60.0
"""


@pytest.fixture(scope="session")
def command() -> str:
    found = os.environ.get("COMMINUTE_COMMAND") or shutil.which("comminute")
    if found is None:
        pytest.skip("the command comminute is not installed, and COMMINUTE_COMMAND does not say where it is")
    return found


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def cluster(tmp_path: Path):
    """A Slurm of this machine alone; where none can be started the test is skipped, unless COMMINUTE_REQUIRE_SLURM=1."""
    why = missing()
    found = None
    if why is None:
        try:
            found = Cluster(tmp_path / "cluster")
        except RuntimeError as said:
            why = str(said)
    if found is None:
        if os.environ.get("COMMINUTE_REQUIRE_SLURM") == "1":
            pytest.fail(f"no Slurm: {why}")
        pytest.skip(f"NO SLURM, so nothing about it was tested: {why}")
    yield found
    found.stop()
