"""A Slurm cluster of one node, this machine: three daemons in a temporary folder, nothing of the system's is touched."""
from __future__ import annotations

import getpass
import os
import shutil
import socket
import subprocess
import tempfile
import time
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")
PATIENCE_S = 1800.0  # after which a process hangs, whatever else the machine does
NODE = "node"

CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={here}/munge.socket
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={here}/state
SlurmdSpoolDir={here}/spool
SlurmctldPidFile={here}/slurmctld.pid
SlurmdPidFile={here}/slurmd.pid
SlurmctldLogFile={here}/slurmctld.log
SlurmdLogFile={here}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0,sched_interval=1,bf_interval=1
KillWait=2
SlurmdParameters=config_overrides
NodeName={node} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={node} Default=YES State=UP MaxTime=INFINITE
"""

CONTROL_GROUPS = "/sys/fs/cgroup"


def why_not() -> str:
    """Why there can be none here; '' if there can."""
    missing = [name for name in PROGRAMS if not _program(name)]
    if missing:
        return f"not installed: {', '.join(missing)} (Debian: munge, slurmctld, slurmd, slurm-client)"
    if not os.path.ismount(CONTROL_GROUPS):
        return f"nothing is mounted on {CONTROL_GROUPS}, which slurmd wants"
    return ""


def _program(name: str) -> str | None:
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")


def _free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class SlurmNode:
    """Context manager; within it `environment` leads Slurm's commands to this cluster."""

    def __init__(self) -> None:
        self.here = Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))  # short: it holds a socket
        self.here.chmod(0o711)  # for others' way to the socket, which munged asks for
        self.environment = {**os.environ, "SLURM_CONF": str(self.here / "slurm.conf")}
        self._daemons: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> "SlurmNode":
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _start(self) -> None:
        for name in ("state", "spool"):
            (self.here / name).mkdir(mode=0o700)
        key = self.here / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(128))
        controller, daemon = _free_ports(2)
        (self.here / "slurm.conf").write_text(CONFIGURATION.format(
            here=self.here, user=getpass.getuser(), controller=controller, daemon=daemon, node=NODE,
            host=os.uname().nodename.split(".")[0]))
        place = {part: f"--{part}-file={self.here}/munge.{part}" for part in ("key", "pid", "log", "seed")}
        # --force: a folder below /tmp is not one that munged trusts by itself.
        self._daemon("munged", "--foreground", "--force", f"--socket={self.here}/munge.socket", *place.values())
        self._until("munged listens", lambda: (self.here / "munge.socket").exists())
        self._daemon("slurmctld", "-D", "-f", self.environment["SLURM_CONF"])
        self._daemon("slurmd", "-D", "-N", NODE, "-f", self.environment["SLURM_CONF"])
        self._until("the node is idle", lambda: self.command("sinfo", "-h", "-o", "%T").strip() == "idle")

    def _daemon(self, name: str, *arguments: str) -> None:
        with (self.here / f"{name}.out").open("wb") as out:
            self._daemons.append(subprocess.Popen([str(_program(name)), *arguments], env=self.environment, stdout=out,
                                                  stderr=out, stdin=subprocess.DEVNULL, start_new_session=True))

    def _until(self, what: str, happened: "object") -> None:
        end = time.monotonic() + PATIENCE_S
        while not happened():  # type: ignore[operator]
            dead = [p.args for p in self._daemons if p.poll() is not None]
            if dead or time.monotonic() > end:
                words = "\n".join(f"{p.name}: {p.read_text(errors='replace')[-1500:]}" for p in self.here.glob("*.out"))
                raise RuntimeError(f"never came: {what}; ended: {dead}\n{words}")
            time.sleep(0.1)

    def command(self, *words: str) -> str:
        """What a Slurm command of this cluster prints; '' where it fails."""
        return subprocess.run(words, env=self.environment, text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, check=False).stdout

    def __exit__(self, *exception: object) -> None:
        if len(self._daemons) == 3:
            self.command("scancel", "--user", getpass.getuser())
        for daemon in reversed(self._daemons):
            daemon.terminate()
            try:
                daemon.wait(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        shutil.rmtree(self.here, ignore_errors=True)
