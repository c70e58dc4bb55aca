"""Runs: bytes, tables, figures, stops."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pandas
import pytest

import comminute
from comminute import errors
from conftest import ROOT, SMALL

# entries of summary.json that tell of the machine and its clock
OF_THE_MACHINE = ("second", "memory", "host", "threads", "steps_per")


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def lasting(summary: bytes) -> dict:
    return {key: value for key, value in json.loads(summary).items() if not any(word in key for word in OF_THE_MACHINE)}


def test_the_folder_is_that_of_the_command(run, command, tmp_path):
    """Every file, byte for byte, with another number of threads."""
    sets = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    scene = ROOT / "experiments/petroleum_coke/h-c-2.toml"
    subprocess.run([command, "run", scene, *sets, "--quiet", "--threads", "1", "--out", tmp_path / "coke"], check=True)
    ours, theirs = files(run.folder), files(tmp_path / "coke")
    assert set(ours) == set(theirs)
    assert {"history.csv", "gsd.csv", "breakage.csv", "figures/compression.svg"} <= set(ours)
    assert lasting(ours.pop("summary.json")) == lasting(theirs.pop("summary.json"))
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_tables_are_frames_with_units(run):
    history = run.history
    assert history.attrs["units"]["sigma_v_kPa"] == "kPa" and history.attrs["units"]["void_ratio"] == "-"
    assert "vertical stress" in history.attrs["meanings"]["sigma_v_kPa"]
    assert set(history.attrs["units"]) == set(history.columns), "a column without a unit"
    assert history["sigma_v_kPa"].iloc[-1] == pytest.approx(600, rel=0.05)
    assert history["void_ratio"].iloc[-1] < history["void_ratio"].iloc[0]
    assert len(run.breakage) == run.summary["crush_events"] > 0
    assert len(run.grains) == run.summary["grains_final"]
    assert len(run.specimen) == 240
    for table in (run.gradation, run.breakage, run.grains, run.specimen):
        assert set(table.attrs["units"]) == set(table.columns)
    with pytest.raises(FileNotFoundError, match="platen.csv; it has .*history.csv"):
        run.table("platen")


def test_tables_go_to_parquet_and_back(run, tmp_path):
    files = run.to_parquet(tmp_path / "tables")
    assert [file.stem for file in files] == [Path(name).stem for name in run.tables] and len(files) > 4
    for name, file in zip(run.tables, files, strict=True):
        ours, back = run.table(name), pandas.read_parquet(file)
        pandas.testing.assert_frame_equal(ours, back, check_exact=True)
        assert back.attrs == ours.attrs and back.attrs["units"], name


def test_arrays_of_numpy_hold_the_same(run):
    for name in ("history.csv", "breakage.csv", "grains_final.csv", "gsd.csv"):
        frame, array = run.table(name), run.table(name, pandas=False)
        assert array.attrs == frame.attrs and list(array.dtype.names) == list(frame.columns)
        for column in frame.columns:
            a, f = array[column], frame[column]
            if a.dtype.kind == "U":
                assert list(a) == list(f.fillna("")), column
            else:
                np.testing.assert_array_equal(np.asarray(a, float), f.to_numpy(float), err_msg=column)
    assert run.table("history", pandas=False)[:2].attrs["units"]["step"] == "-"


def test_a_run_is_opened(run, tmp_path):
    again = comminute.Run.open(str(run.folder))
    assert again.summary == run.summary and again.finished
    assert again.scene.to_toml() == (run.folder / "scene.resolved.toml").read_text()
    assert "history.csv" in again.tables
    with pytest.raises(FileNotFoundError, match="holds no run"):
        comminute.Run.open(tmp_path)


def test_a_report_is_written(run, tmp_path):
    page = run.report(tmp_path / "page.html")
    assert "comminute report" in page.read_text(encoding="utf-8")[:200]
    (tmp_path / "notes.html").write_text("mine")
    with pytest.raises(errors.InputError, match="is no report"):
        run.report(tmp_path / "notes.html")


def test_figures_are_shown(run, tmp_path):
    figures = run.plot()
    assert {"compression", "gradation", "specimen"} <= set(figures)
    assert figures["compression"]._repr_svg_().lstrip().startswith(("<svg", "<?xml"))
    assert figures["compression"].png.is_file() and figures["compression"].data.is_file()
    assert figures._repr_html_().count("<img ") == len(figures)
    with pytest.raises(KeyError, match="compression"):
        figures["compresion"]
    common = comminute.plot([run, run.folder], tmp_path / "figures")
    assert "compression" in common and (tmp_path / "figures" / "runs.csv").is_file()


def test_a_folder_with_a_run_is_kept(run, coke):
    before = files(run.folder)
    with pytest.raises(errors.ExistsError, match="holds a run already") as wrong:
        coke.run(run.folder)
    assert isinstance(wrong.value, FileExistsError) and wrong.value.path == run.folder
    with pytest.raises(errors.OtherRunError, match="a run of another scene"):
        coke.copy({"loading.max_stress_kPa": 500}).run(run.folder, resume=True)
    assert coke.run(run.folder, resume=True).summary == run.summary
    assert files(run.folder) == before


def test_a_stopped_run_goes_on_to_the_same_bytes(run, coke, tmp_path):
    out = tmp_path / "coke"
    with pytest.raises(errors.Interrupted) as stop:
        coke.run(out, stop_after=2500)
    assert (stop.value.step, stop.value.path, stop.value.exit_code) == (2500, out, 130)
    assert not comminute.Run.open(out).finished
    ended = comminute.resume(stop.value.path)
    for name in ("history.csv", "gsd.csv", "breakage.csv", "grains_final.csv"):
        assert (out / name).read_bytes() == (run.folder / name).read_bytes(), name
    assert ended.finished
    with pytest.raises(errors.CheckpointError, match="the run is finished"):
        comminute.resume(out)


def test_progress_is_told_and_can_stop(coke, tmp_path):
    told = []

    def watch(share: float, line: str) -> None:
        told.append((share, line))
        raise LookupError("enough")

    coke["loading.max_stress_kPa"] = 50_000
    with pytest.raises(LookupError, match="enough") as stopped:
        coke.run(tmp_path / "coke", progress=watch)
    assert len(told) == 1 and 0 <= told[0][0] <= 1 and told[0][1]
    assert "interrupted at step" in stopped.value.__notes__[0]
    assert (tmp_path / "coke" / "checkpoint.bin").is_file()


CTRL_C = """
import sys, comminute
scene = comminute.Scene.load(sys.argv[1], {sets!r})
scene["loading.max_stress_kPa"] = 50000
try:
    scene.run(sys.argv[2], progress=lambda share, line: print("going", flush=True))
except KeyboardInterrupt as stop:
    print("stopped", stop.__notes__[0])
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_stops_a_run_and_keeps_its_data(tmp_path):
    out = tmp_path / "coke"
    scene = ROOT / "experiments/petroleum_coke/h-c-2.toml"
    args = [sys.executable, "-P", "-c", CTRL_C.format(sets=SMALL), str(scene), str(out)]
    with subprocess.Popen(args, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None and child.stdout.readline() == "going\n"
        child.send_signal(signal.SIGINT)
        said = child.stdout.read()
    assert child.returncode == 0 and f"stopped {out}: interrupted at step" in said
    assert (out / "checkpoint.bin").is_file()
    with pytest.raises(errors.Interrupted):
        comminute.resume(out, stop_after=1)


def test_other_threads_of_python_go_on(coke, tmp_path):
    """A thread of Python works while a run is made on another, and two runs at once give the same bytes."""
    scenes = [coke.copy(), coke.copy()]
    threads = [threading.Thread(target=s.run, args=(tmp_path / str(i),), kwargs={"threads": 1}) for i, s in enumerate(scenes)]
    for thread in threads:
        thread.start()
    counted = 0
    while any(thread.is_alive() for thread in threads):
        counted += 1
        time.sleep(0.001)
    assert counted > 10
    first, second = (files(tmp_path / str(i)) for i in range(2))
    assert first["history.csv"] == second["history.csv"]


def test_an_unknown_backend_is_refused(coke, tmp_path):
    with pytest.raises(ValueError, match="must be one of cpu, gpu, auto"):
        coke.run(tmp_path / "coke", backend="abacus")
    assert not (tmp_path / "coke").exists()
