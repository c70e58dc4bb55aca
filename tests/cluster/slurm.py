"""A cluster of this machine alone: munge, slurmctld and two slurmd in a temporary folder, without systemd.

Debian's packages slurm-wlm and munge are enough. Needs root, as slurmd does. By hand:

    python3 tests/cluster/slurm.py FOLDER

starts one, prints what the shell needs to use it, and stops it when its standard input ends.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

NODES = ("n1", "n2")

CONFIG = """
ClusterName=test
SlurmctldHost=localhost
SlurmctldPort={ports[0]}
SlurmUser=root
AuthInfo=socket={folder}/munge/socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=sched_interval=1,bf_interval=1
ReturnToService=2
SlurmdParameters=config_overrides
SlurmdTimeout=4
KillWait=3
NodeName=n1 NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[1]} CPUs=2 RealMemory=100000
NodeName=n2 NodeHostname=localhost NodeAddr=127.0.0.1 Port={ports[2]} CPUs=2 RealMemory=100000
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> str | None:
    """Why no cluster can be started here; None where it can."""
    programs = [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "squeue") if shutil.which(name, path=paths()) is None]
    if programs:
        return f"{', '.join(programs)} not installed (Debian: slurm-wlm, munge)"
    return None if os.geteuid() == 0 else "slurmd needs root"


def paths() -> str:
    """Where daemons and commands are."""
    return f"{os.environ.get('PATH', '')}:/usr/sbin"


def free_ports(count: int) -> list[int]:
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Cluster:
    """A controller and two nodes of two processors."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        for name in ("munge", "state", *(f"spool/{node}" for node in NODES)):
            (self.folder / name).mkdir(parents=True)
        self.config = self.folder / "slurm.conf"
        self.config.write_text(CONFIG.format(folder=self.folder, ports=free_ports(3)))
        self.environment = {**os.environ, "SLURM_CONF": str(self.config), "PATH": paths()}
        self.daemons: dict[str, subprocess.Popen[bytes]] = {}
        key = self.folder / "munge" / "key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        (self.folder / "munge").chmod(0o711)
        files = [f"--{name}-file={self.folder}/munge/{name}" for name in ("key", "pid", "log", "seed")]
        try:
            self._start("munged", "--foreground", "--force", f"--socket={self.folder}/munge/socket", *files)
            self._wait(lambda: (self.folder / "munge" / "socket").exists(), "munged")
            self._start("slurmctld", "-D", "-f", str(self.config))
            for node in NODES:
                self.start(node)
            self._wait(lambda: self.call("sinfo", "-h", "-o", "%T %D").split() == ["idle", "2"], "slurmd")
        except BaseException:
            self.stop()
            raise

    def _start(self, name: str, *words: str, key: str = "") -> None:
        log = open(self.folder / f"{key or name}.said", "ab")
        program = shutil.which(name, path=paths()) or name
        self.daemons[key or name] = subprocess.Popen(
            [program, *words], env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
        )
        log.close()

    def _wait(self, done, what: str) -> None:  # type: ignore[no-untyped-def]
        until = time.monotonic() + 30
        while not done():
            if time.monotonic() > until:
                logs = "\n".join(path.read_text(errors="replace")[-1500:] for path in self.folder.glob("*.said"))
                raise RuntimeError(f"{what} does not start:\n{logs}")
            time.sleep(0.1)

    def call(self, *words: str) -> str:
        """What a command of Slurm prints."""
        return subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False).stdout

    def start(self, node: str) -> None:
        """Starts a node, or starts it again."""
        self._start("slurmd", "-D", "-f", str(self.config), "-N", node, key=node)

    def kill(self, node: str) -> int:
        """Kills a node as a power cut does: its daemon and all that it runs. Gives the number of processes of runs."""
        self.daemons[node].kill()
        self.daemons[node].wait()
        killed = set()
        for process in Path("/proc").glob("[0-9]*"):
            try:
                environment = (process / "environ").read_bytes().split(b"\0")
                ours = f"SLURM_CONF={self.config}".encode() in environment and f"SLURMD_NODENAME={node}".encode() in environment
                if ours:
                    killed.add(int(process.name))
                    parent = int((process / "stat").read_text().rsplit(")", 1)[1].split()[1])
                    # the one that looks after the run, with it
                    if (Path("/proc") / str(parent) / "comm").read_text().startswith("slurmstepd"):
                        os.kill(parent, signal.SIGKILL)
            except OSError:
                continue
        for process in killed:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return len(killed)

    def kill_controller(self) -> None:
        """Kills the daemon that the commands ask."""
        self.daemons["slurmctld"].kill()
        self.daemons["slurmctld"].wait()

    def start_controller(self) -> None:
        """Starts it again."""
        self._start("slurmctld", "-D", "-f", str(self.config))

    def stop(self) -> None:
        """Ends everything."""
        self.call("scancel", "--me")
        for name in (*NODES, "slurmctld", "munged"):
            daemon = self.daemons.get(name)
            if daemon is not None and daemon.poll() is None:
                daemon.terminate()
        for daemon in self.daemons.values():
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()


def main() -> None:
    why = missing()
    if why:
        sys.exit(why)
    cluster = Cluster(Path(sys.argv[1]))
    print(f"export SLURM_CONF={cluster.config}", flush=True)
    try:
        sys.stdin.read()
    finally:
        cluster.stop()


if __name__ == "__main__":
    main()
