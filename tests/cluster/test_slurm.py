"""Campaigns by a real Slurm: the bytes are those without it, whatever is killed meanwhile, and what goes wrong is told by name."""

import json
import os
import signal
import subprocess
import time

from campaigns import SEEDS, begun, call, ensemble, files, wait_for

# whether the test tells Slurm that the node is down, instead of letting Slurm find it out
AT_ONCE = SEEDS < 16


def test_an_ensemble_survives_a_killed_node_and_a_killed_call(command, scene, cluster):
    subprocess.run(ensemble(command, scene, "--quiet", out="local"), check=True)
    by_slurm = ensemble(command, scene, "--executor", "slurm")
    runs = scene.parent / "slurm"
    with (scene.parent / "said").open("wb") as said:
        first = subprocess.Popen(by_slurm, env=cluster.environment, stderr=said)
        wait_for(lambda: begun(runs))
        first.kill()
        first.wait()
        calls = [subprocess.Popen(by_slurm, env=cluster.environment, stderr=said) for _ in range(2)]
        # the node that has a run in the middle
        killed = 0
        while not killed:
            wait_for(lambda: begun(runs))
            node = cluster.call("squeue", "-h", "-t", "running", "-o", "%N").split()
            killed = cluster.kill(node[0]) if node else 0
        started = time.monotonic()
        if AT_ONCE:
            # Slurm sees it after half a minute, and gives the node two more to be tidied up before it runs again what was lost there
            cluster.call("scontrol", "update", f"node={node[0]}", "state=down", "reason=power")
            for job in cluster.call("squeue", "-h", "-r", "-t", "pending", "-o", "%A").split():
                cluster.call("scontrol", "update", f"job={job}", "starttime=now")
            wait_for(lambda: "BeginTime" not in cluster.call("squeue", "-h", "-r", "-o", "%r"))
        else:
            wait_for(lambda: f"{node[0]} down" in cluster.call("sinfo", "-h", "-N", "-o", "%N %T"))
        cluster.start(node[0])
        codes = [each.wait(600) for each in calls]
    print(f"{killed} processes killed, done {time.monotonic() - started:.0f} s later")
    text = (scene.parent / "said").read_text()
    assert codes == [0, 0], text
    ours, theirs = files(runs), files(scene.parent / "local")
    assert not {name: text for name, text in ours.items() if name.endswith(".log")}
    assert ours.keys() == theirs.keys() and len(ours) > 8 * SEEDS
    for name, content in theirs.items():
        assert ours[name] == content, name
    # nothing was submitted twice, but for runs that Slurm told to stop when their node came back
    arrays = {path.parent.name: json.loads(path.read_text())["runs"] for path in runs.glob("slurm/*/array.json")}
    first_array = arrays.pop("1")
    assert len(first_array) == SEEDS
    for run in (run for array in arrays.values() for run in array):
        # by the run itself, or by its shell where the signal came before the run listened
        assert (runs / "slurm/1" / f"{first_array.index(run) + 1}.code").read_text() in ("130\n", "143\n"), text


def test_what_goes_wrong_is_told_and_a_second_call_goes_on(command, scene, cluster):
    runs = scene.parent / "slurm"
    by_slurm = ensemble(command, scene, "--executor", "slurm")
    bare = subprocess.run(by_slurm, env={**os.environ, "PATH": "/nowhere"}, capture_output=True, text=True, check=False)
    assert bare.returncode == 2 and "error: sbatch: is not on the PATH" in bare.stderr
    refused = call(cluster.environment, [*by_slurm, "--executor-options=--partition=night"], 2)
    assert "sbatch: refuses the runs: invalid partition specified: night" in refused
    assert not list(runs.glob("slurm/[0-9]*")), "nothing was submitted"

    # one run is cancelled, the controller is away for a while
    held = [*by_slurm, "--jobs", "1", "--executor-options=--hold --comment=a"]
    said = scene.parent / "said"
    with said.open("wb") as file:
        running = subprocess.Popen(held, env=cluster.environment, stderr=file)
        wait_for(lambda: "JobHeldUser" in said.read_text())
        job = cluster.call("squeue", "-h", "-o", "%F").split()[0]
        assert f"{SEEDS} of {SEEDS} runs submitted to Slurm as job {job}" in said.read_text()
        asked = cluster.call("scontrol", "show", "job", f"{job}_1")
        assert "TimeLimit=00:16:00" in asked and "MinMemoryNode=256M" in asked and "Comment=a" in asked, asked
        cluster.kill_controller()
        wait_for(lambda: "squeue does not answer: " in said.read_text())
        cluster.start_controller()
        wait_for(lambda: "(null)" not in cluster.call("squeue", "-h", "-o", "%i") and cluster.call("squeue", "-h"))
        cluster.call("scontrol", "release", job)
        wait_for((runs / "seed-2/checkpoint.bin").exists)
        cluster.call("scancel", f"{job}_2")
        assert running.wait(120) == 1, said.read_text()
    text = said.read_text()
    assert f"seed-2: element 2 of Slurm's job {job} ended as CANCELLED: slurmstepd" in text, text
    assert f"1 of {SEEDS} runs failed" in text
    done = {path: path.stat().st_mtime_ns for path in runs.glob("seed-*/summary.json")}
    assert len(done) == SEEDS - 1

    # a call that is asked to stop leaves the queue alone
    stopped = subprocess.Popen([*by_slurm, "--executor-options=--hold"], env=cluster.environment, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: len(cluster.call("squeue", "-h", "-r").splitlines()) == 1)
    stopped.send_signal(signal.SIGTERM)
    text = stopped.communicate(timeout=20)[1]
    job = cluster.call("squeue", "-h", "-o", "%F").strip()
    assert stopped.returncode == 130 and f"scancel {job}" in text, text
    cluster.call("scontrol", "release", job)
    text = call(cluster.environment, by_slurm, 0)
    assert f"{SEEDS} of {SEEDS} runs done" in text
    assert all(path.stat().st_mtime_ns == when for path, when in done.items()), "what was done is not done again"


def test_a_run_that_fails_by_itself_is_told_as_without_slurm(command, scene, cluster):
    words = ["sweep", str(scene), "--grid", "specimen.porosity=0.2,0.48", "--quiet"]
    told = {}
    for executor in ("local", "slurm"):
        out = scene.parent / executor
        text = call(cluster.environment, [command, *words, "--out", str(out), "--executor", executor], 1)
        assert "1 of 2 runs failed" in text and "step 30001: preparation" in text, text
        told[executor] = text.replace(executor, "")
        assert (out / "porosity-0.2.log").is_file() and not (out / "porosity-0.48.log").exists()
    assert told["local"] == told["slurm"]
