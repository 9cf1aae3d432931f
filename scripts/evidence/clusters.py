"""Runs the recipes of docs/clusters.md as they stand there: Slurm on one node, GNU parallel, Snakemake, Dask.

    scripts/study clusters [RECIPE ...]

Each makes the map of `map.toml` in a folder of its own, with a process killed or ended by its time limit on the way, and every variable of
the map is compared with that of one process. Slurm needs root, and the packages slurmctld, slurmd and munge; its daemons run in the scratch
folder and end with the script.
"""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from measure import fingerprints

ROOT = Path(__file__).resolve().parents[2]

# A second or two of work in 256 tiles; the engine that is slow.
MAP = """
[grid]
epsilon = [0.05, 0.2]
alpha = { from = 0.0, to = 0.8, points = 16 }
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 32 }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 32 }
[methods]
run = ["symmetric", "simulation"]
[simulation]
engine = "direct"
[output]
path = "map.h5"
"""

SLURM = """
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/ctld.pid
SlurmdPidFile={folder}/d.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
SchedulerParameters=batch_sched_delay=0,sched_interval=1,requeue_delay=0
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES State=UP
"""


def recipe(name):
    """The block of the page that has this name."""
    page = (ROOT / "docs/clusters.md").read_text()
    return re.search(rf"^```\w+ file={re.escape(name)}\n(.*?)^```", page, re.M | re.S)[1]


def run(command, folder, **more):
    return subprocess.run(command, cwd=folder, check=True, text=True, **more)


def kill_one(folder):
    """Kills one process of this folder's shards, once some tiles are finished."""
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline:
        for entry in Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and Path(os.readlink(entry / "cwd")) == folder:
                    words = (entry / "cmdline").read_bytes().split(b"\0")
                    if words[0].endswith(b"slipmap") and b"--shard" in words and any(folder.glob("map.h5.part.*")):
                        time.sleep(0.2)
                        os.kill(int(entry.name), signal.SIGKILL)
                        return True
            except OSError:
                continue
        time.sleep(0.01)
    return False


def with_a_kill(command, folder):
    child = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    killed = kill_one(folder)
    code = child.wait()
    assert code == 0, f"{command}: {code}"
    return "one process killed" if killed else "nothing killed"


def parallel(folder):
    (folder / "map.sh").write_text(recipe("map.sh"))
    return with_a_kill(["bash", "map.sh"], folder)


def snakemake(folder):
    (folder / "Snakefile").write_text(recipe("Snakefile"))
    return with_a_kill([str(Path(sys.executable).with_name("snakemake")), "--cores", "2", "--quiet"], folder)


def dask(folder):
    (folder / "shards.py").write_text(recipe("shards.py"))
    return with_a_kill([sys.executable, "shards.py"], folder)


def slurm(folder):
    host = socket.gethostname().split(".")[0]
    for name in ["state", "spool"]:
        (folder / name).mkdir()
    conf = folder / "slurm.conf"
    conf.write_text(SLURM.format(host=host, folder=folder))
    os.environ["SLURM_CONF"] = str(conf)
    Path("/run/munge").mkdir(exist_ok=True)
    script = recipe("map.sbatch").replace("1-64", "1-8").replace("--cpus-per-task=2", "--cpus-per-task=1").replace("55m", "300ms")
    (folder / "map.sbatch").write_text(script)
    daemons = [subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
               for words in (["munged", "-F", "--force"], ["slurmctld", "-D"], ["slurmd", "-D"])]
    try:
        for _ in range(100):
            if subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout.strip() == "idle":
                break
            time.sleep(0.3)
        job = run(["sbatch", "--parsable", "map.sbatch"], folder, stdout=subprocess.PIPE).stdout.strip()
        merge = ["sbatch", f"--dependency=afterok:{job}", "--wrap", "slipmap merge map.toml"]
        # A task is killed and queued again, as where its node fails.
        running = ["squeue", "-h", "-t", "R", "-j", f"{job}_1", "-o", "%T"]
        for _ in range(300):
            if subprocess.run(running, capture_output=True, text=True).stdout.strip():
                break
            time.sleep(0.05)
        run(["scontrol", "requeue", f"{job}_1"], folder)
        run(merge, folder, stdout=subprocess.DEVNULL)
        deadline = time.monotonic() + 300
        while not (folder / "map.h5").exists():
            assert time.monotonic() < deadline, "the map was never made"
            time.sleep(0.5)
        limits = sum(path.read_text().count("the time limit was reached") for path in folder.glob("slurm-*.out"))
        return f"one task requeued by hand, {limits} by their time limit"
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            daemon.wait()


def main():
    program, names = Path(sys.argv[1]).resolve(), sys.argv[2:]
    with tempfile.TemporaryDirectory() as scratch:
        tools = Path(scratch) / "bin"
        tools.mkdir()
        (tools / "slipmap").symlink_to(program)
        os.environ["PATH"] = f"{tools}:{os.environ['PATH']}"
        expected = None
        for name in ["one process"] + (names or ["parallel", "snakemake", "dask", "slurm"]):
            folder = Path(scratch) / name
            folder.mkdir()
            (folder / "map.toml").write_text(MAP)
            start = time.monotonic()
            if expected is None:
                run(["slipmap", "run", "map.toml", "--quiet"], folder, stdout=subprocess.DEVNULL)
                expected = fingerprints(folder / "map.h5")
                print(f"one process: {time.monotonic() - start:.1f} s, {len(expected)} variables")
                continue
            what = globals()[name](folder)
            assert fingerprints(folder / "map.h5") == expected, f"{name}: another map"
            assert not list(folder.glob("map.h5.part*")), f"{name}: journals are left"
            print(f"{name}: {time.monotonic() - start:.1f} s, {what}; the map equals that of one process", flush=True)


main()
