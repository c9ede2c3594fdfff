#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A study as a Slurm array, one part of which is requeued while it runs.

usage: slurm.py RA2D SOURCE_FOLDER

Starts a private slurmctld and slurmd in a temporary folder, on this machine and for this user
alone. Submits the very script of docs/studies.md, requeues one part once it has finished some runs,
merges, and compares the table with that of an uninterrupted study: every byte but the times. Where
ra2d has MPI and Slurm has PMIx, srun's ranks, too. Exit status: 0 as it should be, 1 not, 9 there
is no Slurm here.
"""

import ctypes
import getpass
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

SKIPPED = 9
PARTS, SEEDS = 8, 40
STUDY = """
base = "{base}"
seeds = {seeds}
[set]
"scene.duration" = 0.02
"time.scheme" = "adaptive"
"time.tolerance" = 1e-6
"output.rate" = 1e4
[vary]
speed = {{ key = "scene.speed", values = [0.1, 0.2, 0.4] }}
rq = {{ keys = ["resonator.surface.rq", "slider.surface.rq"], values = [4e-6, 8e-6] }}
"""
# No accounts, no keys, no cgroups; two processors, whatever there are; what waits is looked at
# every second
CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SwitchType=switch/none
MpiDefault=none
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=0
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=test Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


def until(what, condition, seconds=120):
    """Waits for something true, and gives it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        answer = condition()
        if answer:
            return answer
        time.sleep(0.05)
    raise AssertionError(f"{what}: not within {seconds} s")


def run(*words, may_fail=False):
    ended = subprocess.run([str(word) for word in words], capture_output=True, text=True,
                           check=False)
    if ended.returncode != 0 and not may_fail:
        raise AssertionError(
            f"{' '.join(map(str, words))} ended with {ended.returncode}: "
            f"{ended.stdout}{ended.stderr}")
    return ended


def batch_script(source):
    """The script of the documentation."""
    text = (source / "docs/studies.md").read_text()
    scripts = [block for block in re.findall(r"```bash\n(.*?)```", text, re.DOTALL)
               if "#SBATCH --array" in block]
    assert len(scripts) == 1, f"docs/studies.md has {len(scripts)} scripts for Slurm"
    return scripts[0]


def content(table):
    """All that a table holds but what tells of times: bytes of every dataset, and every
    attribute."""
    held = {}
    with h5py.File(table) as file:
        held["/"] = dict(file.attrs)
        for name, data in file.items():
            if name == "wall_seconds":
                continue
            held[name] = dict(data.attrs)
            values = data[()]
            text = values.dtype == object
            held[name + " bytes"] = (values.shape, values.tolist() if text else values.tobytes())
    return {name: repr(plain(value)) for name, value in held.items()}


def plain(value):
    """References to scales are other numbers in every file."""
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()
                if key not in ("DIMENSION_LIST", "REFERENCE_LIST")}
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def same(first, second):
    one, other = content(first), content(second)
    assert "v_rms bytes" in one and one.keys() == other.keys(), (
        f"{first} and {second} have other datasets")
    for name, value in one.items():
        assert value == other[
            name], f"{first} and {second} differ in {name}: {value[:300]} and {other[name][:300]}"


def requeue_one(job, folder):
    """Requeues a part that has finished some runs and not all, and gives its number."""
    for part in range(1, PARTS + 1):
        number = f"{job}_{part}"
        ledger = folder / f"fig5/ledger/shard-{part}-of-{PARTS}.log"
        until(f"part {part} runs", lambda: ledger.exists() and ledger.stat().st_size > 1000)
        if run("scontrol", "requeue", number, may_fail=True).returncode != 0:
            continue  # it is done: this machine is quick
        # it would wait two minutes, for the sake of nodes that are slow to clean up
        until("it waits", lambda: "BeginTime" in run("squeue", "--noheader", "-o", "%r", "-j",
                                                     number).stdout)
        # the node knows what it is not to start any more by whole seconds, and would take the new
        # job for the old one
        time.sleep(2)
        run("scontrol", "update", f"JobId={number}", "StartTime=now")
        return part
    raise AssertionError("no part was caught while it ran")


def array_of_jobs(source, folder, ra2d):
    (folder / "array.sh").write_text(batch_script(source))
    # one processor each: two parts run at a time
    job = run("sbatch", "--parsable", "--cpus-per-task=1", folder / "array.sh").stdout.strip()
    part = requeue_one(job, folder)
    until("all parts end", lambda: run("squeue", "--noheader").stdout == "", 240)
    said = (folder / f"slurm-{job}_{part}.out").read_text()
    kept = re.search(r"interrupted: (\d+) of \d+ runs are finished and kept", said)
    assert kept, f"the requeued part was not interrupted: {said}"
    assert f"{kept[1]} were finished before" in said, f"it did not go on from there: {said}"
    run(ra2d, "study", "merge", "fig5", "--quiet")
    same("fig5/results.h5", "whole/results.h5")
    print(f"part {part} was requeued with {kept[1]} runs finished")


def ranks(ra2d):
    listed = run("srun", "--mpi=list", may_fail=True)
    if not (ra2d.parent / "libra2d_mpi.so").exists() or "pmix" not in listed.stdout + listed.stderr:
        return
    run("srun", "--mpi=pmix", "--ntasks=2", ra2d, "study", "fig5.toml", "-o", "ranks", "--quiet")
    assert pathlib.Path("ranks/ledger/all-rank-1.log").exists()
    same("ranks/results.h5", "whole/results.h5")
    print("two ranks of srun share a study")


def attempt(ra2d, source, folder):
    os.chdir(folder)
    os.environ["SLURM_CONF"] = str(folder / "slurm.conf")
    os.environ["PATH"] = f"{ra2d.parent}:{os.environ['PATH']}"
    for name in ("state", "spool"):
        (folder / name).mkdir()
    host = socket.gethostname().split(".")[0]
    (folder / "slurm.conf").write_text(
        CONFIGURATION.format(host=host, user=getpass.getuser(), ports=free_ports(2), folder=folder))
    (folder / "fig5.toml").write_text(STUDY.format(base=source / "scenes/dang2012.toml",
                                                   seeds=SEEDS))
    libc = ctypes.CDLL(None)
    daemons = []
    try:
        for words in (["slurmctld", "-D", "-i"], ["slurmd", "-D"]):
            # none outlives this script (PR_SET_PDEATHSIG)
            with open(folder / (words[0] + ".out"), "w") as out:
                daemons.append(subprocess.Popen(words, stdout=out, stderr=out,
                                                preexec_fn=lambda: libc.prctl(1, signal.SIGKILL)))
        run(ra2d, "study", "fig5.toml", "-o", "whole", "--quiet")
        until("the node is there", lambda: "idle" in run("sinfo", "--noheader", "-o", "%T",
                                                         may_fail=True).stdout, 60)
        array_of_jobs(source, folder, ra2d)
        ranks(ra2d)
    except AssertionError:
        for log in sorted(folder.glob("slurm*.[lo][ou][gt]")):
            print(f"---- {log.name}\n" + "\n".join(log.read_text().splitlines()[-25:]))
        raise
    finally:
        if len(daemons) == 2 and all(daemon.poll() is None for daemon in daemons):
            run("scancel", "--user", getpass.getuser(), may_fail=True)
            until("no job is left",
                  lambda: run("squeue", "--noheader", may_fail=True).stdout == "", 20)
        for daemon in reversed(daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()


def main():
    ra2d, source = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    os.environ["PATH"] += ":/usr/sbin"  # of Debian's daemons, which users do not have in theirs
    missing = [name for name in ("slurmctld", "slurmd", "sbatch", "scontrol", "srun")
               if shutil.which(name) is None]
    if missing:
        print(f"no Slurm here: {', '.join(missing)} not found")
        return SKIPPED
    folder = pathlib.Path(tempfile.mkdtemp(prefix="ra2d_slurm_"))
    try:
        attempt(ra2d, source, folder)
    except AssertionError as fault:
        print(fault)
        return 1
    finally:
        os.chdir("/")
        shutil.rmtree(folder, ignore_errors=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
