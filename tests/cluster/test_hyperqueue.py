"""Campaigns by HyperQueue, for which a program stands in that behaves as its documentation says: the bytes are those without it, a killed call is gone on with."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from campaigns import SEEDS, begun, call, ensemble, files, wait_for

STAND_IN = Path(__file__).parent / "stand_in"


@pytest.fixture
def server(tmp_path):
    (tmp_path / "server").mkdir()
    return {**os.environ, "PATH": f"{STAND_IN}:{os.environ['PATH']}", "HQ_STAND_IN": str(tmp_path / "server")}


def test_an_ensemble_survives_a_killed_call(command, scene, server):
    subprocess.run(ensemble(command, scene, "--quiet", out="local"), check=True)
    by_hyperqueue = ensemble(command, scene, "--executor", "hyperqueue", out="hyperqueue")
    runs = scene.parent / "hyperqueue"
    first = subprocess.Popen(by_hyperqueue, env=server, stderr=subprocess.DEVNULL)
    wait_for(lambda: begun(runs))
    first.kill()
    first.wait()
    calls = [subprocess.Popen(by_hyperqueue, env=server, stderr=subprocess.DEVNULL) for _ in range(2)]
    assert [each.wait(300) for each in calls] == [0, 0]
    ours, theirs = files(runs), files(scene.parent / "local")
    assert ours == theirs and len(ours) > 8 * SEEDS
    assert len(list(runs.glob("hyperqueue/*/array.json"))) == 1, "nothing was submitted twice"


def test_what_goes_wrong_is_told_and_a_second_call_goes_on(command, scene, server):
    by_hyperqueue = ensemble(command, scene, "--executor", "hyperqueue", out="hyperqueue")
    runs = scene.parent / "hyperqueue"
    bare = call({**server, "PATH": "/nowhere"}, by_hyperqueue, 2)
    assert "error: hq: is not on the PATH" in bare
    no_server = call({**server, "HQ_STAND_IN": "/nowhere"}, by_hyperqueue, 2)
    assert "error: hq submit: refuses the runs: No running instance of HQ found" in no_server
    refused = call(server, [*by_hyperqueue, "--executor-options=--partition=night"], 2)
    assert "hq submit: refuses the runs: error: unexpected argument '--partition' found" in refused
    assert not list(runs.glob("hyperqueue/[0-9]*")), "nothing was submitted"

    said = scene.parent / "said"
    with said.open("wb") as file:
        running = subprocess.Popen([*by_hyperqueue, "--jobs", "1"], env=server, stderr=file)
        wait_for((runs / "seed-2/checkpoint.bin").exists)
        killed = subprocess.run(["pkill", "-KILL", "-f", f"{runs}/seed-2 "], check=False).returncode
        assert running.wait(120) == 1, said.read_text()
    text = said.read_text()
    assert killed == 0 and f"{SEEDS} of {SEEDS} runs submitted to HyperQueue as job 1" in text, text
    assert "seed-2: element 2 of HyperQueue's job 1 ended with exit code 137" in text and f"1 of {SEEDS} runs failed" in text
    assert "--jobs is not kept" in text

    # a call that is asked to stop says what stays in the queue; what was done is not done again
    done = {path: path.stat().st_mtime_ns for path in runs.glob("seed-*/summary.json")}
    stopped = subprocess.Popen(by_hyperqueue, env=server, stderr=subprocess.PIPE, text=True)
    wait_for((scene.parent / "server/2").exists)
    time.sleep(0.3)
    stopped.send_signal(signal.SIGTERM)
    text = stopped.communicate(timeout=20)[1]
    assert stopped.returncode == 0 or "out of it takes them: hq job cancel 2" in text, text
    assert f"{SEEDS} of {SEEDS} runs done" in call(server, by_hyperqueue, 0)
    assert len(done) == SEEDS - 1 and all(path.stat().st_mtime_ns == when for path, when in done.items())
