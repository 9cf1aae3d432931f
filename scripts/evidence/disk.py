"""A simulated disk under a shard and a merge: power cuts at random moments of their recorded system calls.

    scripts/study disk [SEEDS=10000] [FIRST=0]

One shard and one merge of a small map are recorded by strace: every write, sync, truncation, renaming and removal, those of the HDF5
library too. A seed then cuts the power after any of them. Of the disk remains what was forced to it, and of all that came later any subset,
writes torn at any sector and in any order, names too. One seed of four also forgets syncs that the program was told had happened. Then
`slipmap status`, `slipmap run --resume` and `slipmap check` must end well:

- nothing lost: every tile that was forced to disk is found, or the map is complete (where no sync was forgotten);
- nothing wrong: the map, made in the end, has the fingerprints of one that was never interrupted; what cannot be used is refused.
"""

import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from measure import fingerprints

MAP = """
[grid]
epsilon = [0.05, 0.2]
alpha = { from = 0.0, to = 0.8, points = 8 }
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 64 }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 32 }
[methods]
run = ["symmetric", "bendixson"]
[audit]
cells = 0
[output]
path = "map.h5"
fields = ["verdict", "critical_c"]
"""
CALLS = "openat,close,write,pwrite64,lseek,ftruncate,fsync,fdatasync,rename,renameat,renameat2,link,linkat,unlink,unlinkat"
SECTOR = 512
FRAME = b"\x89slip\r\n\x1a"
HEAD = 56


def text(word):
    return bytes.fromhex(word.replace("\\x", ""))


def operations(trace, folder):
    """The operations on files of the folder, from a trace of system calls. A file has its first name as a number."""
    files, names, found, pending = {}, {}, [], {}
    for line in trace.read_text().splitlines():
        thread, call = line.split(None, 1)
        if call.endswith("<unfinished ...>"):
            pending[thread] = call.removesuffix("<unfinished ...>")
            continue
        if resumed := re.match(r"<\.\.\. \w+ resumed>(.*)", call):
            call = pending.pop(thread) + resumed[1]
        match = re.match(r"(\w+)\((.*)\)\s+= (-?\d+)", call)
        if not match or int(match[3]) < 0:
            continue
        name, arguments, result = match[1], match[2], int(match[3])
        words = [text(word).decode("utf-8", "replace") for word in re.findall(r'"((?:\\x..)*)"', arguments)] if "write" not in name else []
        paths = [Path(os.path.normpath(folder / word)) for word in words]
        own = [path.name for path in paths if path.parent == folder and path.name.startswith("map.h5")]
        number = int(re.match(r"\d+", arguments)[0]) if re.match(r"\d+", arguments) else None
        if name == "openat":
            if own and "O_DIRECTORY" not in arguments:
                names.setdefault(own[0], own[0])
                if "O_CREAT" in arguments:
                    found.append(("name", own[0], names[own[0]]))
                files[result] = [names[own[0]], 0]
            elif paths == [folder]:
                files[result] = "folder"
            else:
                files.pop(result, None)
        elif name in ("rename", "renameat", "renameat2", "link", "linkat") and len(own) == 2:
            names[own[1]] = names[own[0]]
            found.append(("name", own[1], names[own[0]]))
            if "rename" in name:
                del names[own[0]]
                found.append(("forget", own[0]))
        elif name in ("unlink", "unlinkat") and own:
            names.pop(own[0], None)
            found.append(("forget", own[0]))
        elif number not in files:
            continue
        elif name == "close":
            del files[number]
        elif name in ("fsync", "fdatasync"):
            found.append(("sync", None if files[number] == "folder" else files[number][0]))
        elif files[number] == "folder":
            continue
        elif name == "lseek":
            files[number][1] = result
        elif name == "ftruncate":
            found.append(("cut", files[number][0], int(arguments.split(",")[1])))
        else:
            file = files[number]
            data = text(re.search(r'"((?:\\x..)*)"', arguments)[1])[:result]
            assert len(data) == result, "the trace is cut short"
            at = int(arguments.rsplit(",", 1)[1]) if name == "pwrite64" else file[1]
            found.append(("write", file[0], at, data))
            if name == "write":
                file[1] = at + result
    return found


def record(program, folder):
    (folder / "job.toml").write_text(MAP)
    found = []
    for number, arguments in enumerate((["run", "job.toml", "--shard", "1/1", "--threads", "1"], ["merge", "job.toml"])):
        trace = folder / f"trace{number}"
        subprocess.run(["strace", "-f", "-xx", "-s", "100000000", "-e", f"trace={CALLS}", "-o", trace, program, *arguments],
                       cwd=folder, check=True, capture_output=True)
        found += operations(trace, folder)
    return found


def image(log, rng, forgetful):
    """Names and contents of the files after a power cut, and the number of tiles that were forced to disk."""
    # Every other time near the end, where the map gets its name and the journals go.
    log = log[: len(log) - rng.randrange(rng.choice([len(log) + 1, 16]))]
    honest = [not (forgetful and rng.random() < 0.5) for _ in log]
    forced = {}
    for at, entry in enumerate(log):
        if entry[0] == "sync" and honest[at]:
            forced[entry[1]] = at
    whole, files, names, safe_names = {}, {}, {}, {}
    for at, entry in enumerate(log):
        kind = entry[0]
        if kind in ("name", "forget"):
            is_safe = at < forced.get(None, -1)
            for known, happens in ((safe_names, is_safe), (names, is_safe or rng.random() < 0.5)):
                if happens and kind == "name":
                    known[entry[1]] = entry[2]
                elif happens:
                    known.pop(entry[1], None)
        elif kind in ("write", "cut"):
            is_safe = at < forced.get(entry[1], -1)
            for contents, happens in ((whole, is_safe), (files, is_safe or rng.random() < 0.7)):
                file = contents.setdefault(entry[1], bytearray())
                if not happens:
                    continue
                if kind == "cut":
                    del file[entry[2] :]
                    file.extend(bytes(entry[2] - len(file)))
                    continue
                _, _, start, data = entry
                file.extend(bytes(max(0, start + len(data) - len(file))))
                sectors = range(start // SECTOR, (start + len(data) - 1) // SECTOR + 1)
                torn = not is_safe and rng.random() < 0.5
                for sector in sectors:
                    if not torn or rng.random() < 0.6:
                        one, end = max(start, sector * SECTOR), min(start + len(data), (sector + 1) * SECTOR)
                        file[one:end] = data[one - start : end - start]
    forced_tiles = 0
    for name, number in safe_names.items():
        # Removed before the cut, whether the disk knows or not: the map was complete.
        if ".part." in name and not any(entry[:2] == ("forget", name) for entry in log):
            bytes_, at = whole.get(number, b""), 0
            while bytes_[at : at + 8] == FRAME:
                length = int.from_bytes(bytes_[at + 8 : at + 16], "little")
                at += HEAD + length
                forced_tiles += at <= len(bytes_)
            forced_tiles -= 1  # the header
    return {name: bytes(files.get(number, b"")) for name, number in names.items()}, max(forced_tiles, 0)


def judge(program, folder, log, expected, seed):
    """What is wrong after the power cut of this seed; and what was found."""
    rng = random.Random(seed)
    forgetful = seed % 4 == 3
    files, forced = image(log, rng, forgetful)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    (folder / "job.toml").write_text(MAP)
    for name, contents in files.items():
        (folder / name).write_bytes(contents)

    def run(*arguments):
        return subprocess.run([program, *arguments], cwd=folder, capture_output=True, text=True)

    status = run("status", "job.toml", "--json")
    if status.returncode == 2:
        # A map whose bytes never reached a disk that said so: it is refused, not used.
        if forgetful and ("is damaged" in status.stderr or "is not a map" in status.stderr):
            return None, "refused"
        return f"status: {status.stderr}", "wrong"
    if status.returncode != 0:
        return f"status ends with {status.returncode}: {status.stderr}", "wrong"
    state = json.loads(status.stdout)
    if not forgetful and not state["complete"] and state["done"] < forced:
        return f"lost: {forced} tiles were forced to disk, {state['done']} are found", "wrong"
    resumed = run("run", "job.toml", "--resume", "--threads", "1", "--quiet")
    if resumed.returncode != 0:
        return f"resumed: {resumed.returncode} {resumed.stderr}", "wrong"
    checked = run("check", "map.h5")
    if checked.returncode != 0 or fingerprints(folder / "map.h5") != expected:
        return f"another map: {checked.stdout}", "wrong"
    left = [path.name for path in folder.iterdir() if ".part" in path.name]
    if any((folder / name).read_bytes()[:8] == FRAME for name in left):
        return f"journals are left: {left}", "wrong"
    return None, "complete" if state["complete"] else "some tiles" if state["done"] else "nothing"


def main():
    program = str(Path(sys.argv[1]).resolve())
    seeds, first = (list(map(int, sys.argv[2:])) + [10000, 0][len(sys.argv) - 2 :])[:2]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch).resolve() / "recorded"
        folder.mkdir()
        log = record(program, folder)
        expected = fingerprints(folder / "map.h5")
        kinds = {kind: sum(entry[0] == kind for entry in log) for kind in ("write", "sync", "cut", "name", "forget")}
        print(f"recorded: {kinds}", flush=True)
        found, wrong = {}, 0
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            def one(seed):
                return seed, judge(program, Path(scratch) / f"seed{seed}", log, expected, seed)
            for seed, (problem, what) in pool.map(one, range(first, first + seeds)):
                shutil.rmtree(Path(scratch) / f"seed{seed}")
                found[what] = found.get(what, 0) + 1
                if problem:
                    wrong += 1
                    print(f"seed {seed}: {problem}", flush=True)
        print(f"{seeds} power cuts, found beside the output: {found}")
        sys.exit(min(wrong, 1))


main()
