"""What the tests share: the repository, the command, and one small run."""

import os
import shutil
from pathlib import Path

import pytest

import comminute

ROOT = Path(__file__).parents[2]

# the oedometer of petroleum coke, made so small that it takes a second
SMALL = {
    "specimen.scale": 4.0,
    "specimen.grains": 240,
    "specimen.porosity": 0.46,
    "preparation.growth_friction": 0.4,
    "preparation.growth_steps": 1500,
    "preparation.porosity_tolerance": 0.02,
    "loading.settle_steps": 500,
    "loading.max_stress_kPa": 600,
}


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def command() -> str:
    """The command of the same build: COMMINUTE_COMMAND, or the one on the path."""
    found = os.environ.get("COMMINUTE_COMMAND") or shutil.which("comminute")
    if found is None:
        pytest.skip("the command comminute is not installed, and COMMINUTE_COMMAND does not say where it is")
    return found


@pytest.fixture
def coke() -> comminute.Scene:
    return comminute.Scene.load(ROOT / "experiments/petroleum_coke/h-c-2.toml", SMALL)


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> comminute.Run:
    """A run of :func:`coke`, made once; tests do not change its folder."""
    scene = comminute.Scene.load(ROOT / "experiments/petroleum_coke/h-c-2.toml", SMALL)
    return scene.run(tmp_path_factory.mktemp("runs") / "coke", threads=2)
