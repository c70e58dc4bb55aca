"""Campaigns and calibrations: the files of the command, errors, stops."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import comminute
from comminute import errors
from conftest import ROOT, SMALL
from test_run import files, lasting

COKE = ROOT / "experiments/petroleum_coke/h-c-2.toml"
TESTS = ROOT / "figures/calibration/grains/simulated.csv"
LOW = {**SMALL, "loading.max_stress_kPa": 60, "records.snapshots": False, "records.figures": False}


def same(ours: dict[str, bytes], theirs: dict[str, bytes]) -> None:
    assert set(ours) == set(theirs)
    for name in ours:
        if name.endswith("summary.json"):
            assert lasting(ours[name]) == lasting(theirs[name]), name
        elif name.endswith("runs.csv"):
            # the last column is the time that a run took
            assert without_last(ours[name]) == without_last(theirs[name]), name
        else:
            assert ours[name] == theirs[name], name


def without_last(table: bytes) -> list[bytes]:
    return [line.rpartition(b",")[0] for line in table.splitlines()]


def test_an_ensemble_has_the_files_of_the_command(command, tmp_path):
    told = []
    scene = comminute.Scene.load(COKE, LOW)
    ensemble = comminute.ensemble(scene, tmp_path / "ours", seeds=[1, 2], progress=lambda share, line: told.append(line))
    sets = [word for key, value in scene_sets().items() for word in ("--set", f"{key}={value}")]
    subprocess.run([command, "ensemble", COKE, *sets, "--seeds", "1,2", "--quiet", "--out", tmp_path / "theirs"], check=True)
    ours, theirs = files(tmp_path / "ours"), files(tmp_path / "theirs")
    assert {"mean.csv", "figures/compression.svg", "seed-2/history.csv"} <= set(ours)
    same(ours, theirs)
    assert [run.scene["seed.packing"] for run in ensemble.runs] == [1, 2]
    assert "compression" in ensemble.figures and len(ensemble.mean) > 1
    assert any("of 2 done" in line for line in told)
    # what is done is not done again
    comminute.ensemble(scene, tmp_path / "ours", seeds=[1, 2])
    same(files(tmp_path / "ours"), theirs)


def scene_sets() -> dict[str, object]:
    return {key: str(value).lower() if isinstance(value, bool) else value for key, value in LOW.items()}


def test_a_failing_run_is_told(tmp_path):
    scene = comminute.Scene.load(COKE, {**LOW, "loading.max_wait_steps": 1, "loading.max_lag": 1e-6})
    with pytest.raises(errors.CampaignError, match="1 of 1 runs failed") as failed:
        comminute.ensemble(scene, tmp_path / "out", seeds=[1])
    [(folder, reason)] = failed.value.failed
    assert folder == tmp_path / "out" / "seed-1" and "loading stands still" in reason


def test_wrong_words_are_refused(tmp_path):
    with pytest.raises(errors.InputError, match="invalid value 'all' for '--vary"):
        comminute.ensemble(COKE, tmp_path / "out", vary="all")
    with pytest.raises(errors.InputError, match="--executor command: needs --executor-command"):
        comminute.ensemble(COKE, tmp_path / "out", executor="command")
    with pytest.raises(errors.Error, match="no such file"):
        comminute.study(tmp_path / "plan.toml", tmp_path / "out")
    with pytest.raises(errors.InputError, match="--budget 3: is less than"):
        scene = ROOT / "experiments/calibration/coke_small.toml"
        curve = ROOT / "experiments/calibration/targets/target-05.csv"
        comminute.calibrate_curve(curve, scene, tmp_path / "out", budget=3)


def test_a_curve_is_calibrated_as_by_the_command(command, tmp_path):
    """The curve of a run as a frame; the same estimates as the command's from the file that is written of it."""
    key = "material.strength.fixed_angle.sigma_lim0_MPa"
    tiny = {**SMALL, "specimen.grains": 100, "specimen.porosity": 0.5, "preparation.growth_steps": 1000, "preparation.porosity_tolerance": 0.05}
    tiny |= {"preparation.max_steps": 30000, "loading.max_stress_kPa": 60.0, "loading.settle_steps": 100, key: 50.0}
    tiny |= {"loading.programme": "adaptive", "records.at_kPa": [], "records.figures": False, "records.snapshots": False}
    scene = comminute.Scene.load(COKE, tiny)
    history = scene.run(out=tmp_path / "lab").history
    curve = history.loc[(history.stage == "load") & (history.sigma_v_kPa > 5), ["sigma_v_kPa", "void_ratio"]].iloc[::10]
    few = {"budget": 12, "design": 6, "check": 2, "specimens": 2, "jobs": 2}
    found = comminute.calibrate_curve(curve, scene, tmp_path / "fit", parameters={key: "25..100:log"}, **few)
    told = found.result["parameters"][key]
    assert 25.0 <= told["lower"] < told["estimate"] < told["upper"] <= 100.0
    assert found.result["runs"]["failed"] == 0 and key in found.report

    options = [word for name, value in few.items() for word in (f"--{name}", str(value))]
    sets = [word for name, value in tiny.items() for word in ("--set", f"{name}={json.dumps(value)}")]
    words = [command, "calibrate", "curve", tmp_path / "fit.csv", "--scene", COKE, *sets, "--parameter", f"{key}=25..100:log", *options]
    subprocess.run([*words, "--quiet", "--out", tmp_path / "command"], check=True)
    assert json.loads((tmp_path / "command/calibration.json").read_text())["parameters"] == found.result["parameters"]


def test_a_campaign_is_stopped(tmp_path):
    def stop(share: float, line: str) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        comminute.ensemble(comminute.Scene.load(COKE, {**SMALL, "loading.max_stress_kPa": 1e6}), tmp_path / "out", progress=stop)
    assert not list((tmp_path / "out").glob("*/summary.json"))


def test_a_study_compares(tmp_path):
    sets = [f"{key}={value}" for key, value in scene_sets().items()]
    plan = tmp_path / "plan.toml"
    plan.write_text(
        f'title = "Friction"\nquestion = "What does friction change?"\nscene = "{COKE}"\nset = {sets!r}\nseeds = "1"\n'
        'measures = ["compression"]\n[tolerance]\ncompression = 0.01\n[reference]\nname = "as it is"\n'
        '[[factor]]\nname = "friction"\nkey = "material.contact.friction"\nvalues = [0.2]\n'
    )
    study = comminute.study(plan, tmp_path / "out")
    assert "What does friction change?" in study.report and "time_error_compression" in study.figures
    assert len(study.table("study", pandas=False)) == 2


def test_grains_are_calibrated_as_by_the_command(command, tmp_path):
    args = [command, "calibrate", "grains", TESTS, "--theta0", "0.1309", "--samples", "19", "--quiet", "--out", tmp_path / "theirs"]
    subprocess.run(args, check=True)
    found = comminute.calibrate_grains(TESTS, tmp_path / "ours", theta0=0.1309, samples=19)
    same(files(tmp_path / "ours"), files(tmp_path / "theirs"))
    assert found.material is not None and "survival" in " ".join(found.figures)
    assert found.result["data"]["grains"] > 10
    # a frame of the same numbers gives the same estimates
    pandas = pytest.importorskip("pandas")
    frame = pandas.read_csv(TESTS, comment="#")
    again = comminute.calibrate_grains(frame, tmp_path / "frame", theta0=0.1309, samples=19)
    assert again.result["data"].pop("file") == str(tmp_path / "frame.csv")
    found.result["data"].pop("file")
    assert again.result == found.result
    with pytest.raises(errors.ExistsError):
        comminute.calibrate_grains(frame, tmp_path / "frame", theta0=0.1309)
    with pytest.raises(errors.Error, match="force"):
        comminute.calibrate_grains({"diameter_mm": [1.0, 2.0]}, tmp_path / "none")


def test_tables_of_one_length(tmp_path):
    with pytest.raises(ValueError, match="one length"):
        comminute.calibrate_grains({"diameter_mm": [1.0], "force_N": []}, tmp_path / "out")
    from comminute import _tables

    text = _tables.csv_text({"a": np.array([1, 2]), "b": [0.1, float("nan")]})
    assert text == "a,b\n1,0.1\n2,\n"


def test_the_package_is_the_command(command, tmp_path):
    """`python -m comminute`, from a folder that has a `comminute` of its own."""
    ours = [sys.executable, "-P", "-m", "comminute"]
    for words in (["--version"], ["check", COKE], ["run"], ["check", "no.toml"], ["run", "--help"]):
        a, b = (subprocess.run([*name, *words], capture_output=True, text=True, cwd=tmp_path, check=False) for name in (ours, [command]))
        assert (a.returncode, a.stdout, a.stderr) == (b.returncode, b.stdout, b.stderr), words
    listed = subprocess.run([*ours, "ensemble", COKE, "--seeds", "1", "--list"], capture_output=True, text=True, check=True)
    assert listed.stdout.startswith(f"{sys.executable} -P -m comminute run {os.fspath(COKE)}")
