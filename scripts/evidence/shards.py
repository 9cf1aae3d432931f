"""One map by shards: n^5 cells by 1, 2, 7 and 64 of them, merged, against one process; the speed of merging; one large map.

    scripts/study shards [n=64]           # the first table; a GB of disk for n = 64
    scripts/study shards --large [CELLS]  # 10^10 cells in eight shards: run, merged, checked, a slice plotted

Shards run two at a time with one thread each; their efficiency is the processor time of one process with two threads over theirs, which a
busy machine changes less than elapsed time. Merging is compared with copying the journals and forcing them to disk.
"""

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from measure import FIVE_AXES, done, fingerprints


def measured(folder, *commands):
    """Runs commands at once; elapsed and processor seconds, and the largest memory of one in MB."""
    start = time.monotonic()
    with ThreadPoolExecutor(len(commands)) as pool:
        all_of = list(pool.map(lambda command: done(command, folder), commands))
    wall = time.monotonic() - start
    return wall, sum(ran.processor for ran in all_of), max(ran.memory for ran in all_of) / (1 << 20)


def shards(program, folder, of):
    """Two at a time, each with one thread: two workers that take every other shard."""
    loop = 'for k in $(seq "$1" 2 "$2"); do "$0" run job.toml --shard "$k/$2" --threads 1 --quiet || exit 1; done'
    workers = [["sh", "-c", loop, program, str(first), str(of)] for first in (1, 2)[: of]]
    return measured(folder, *workers)


def size(paths):
    return sum(path.stat().st_size for path in paths) / 1e6


def copying(folder):
    """Seconds to copy the journals and to force the copies to disk."""
    copies = folder / "copies"
    copies.mkdir()
    start = time.monotonic()
    for path in folder.glob("map.h5.part.*"):
        subprocess.run(["cp", path, copies], check=True)
    for path in copies.iterdir():
        handle = os.open(path, os.O_RDONLY)
        os.fsync(handle)
        os.close(handle)
    seconds = time.monotonic() - start
    subprocess.run(["rm", "-r", copies], check=True)
    return seconds


def small(program, folder, n):
    (folder / "job.toml").write_text(FIVE_AXES.format(a=n, n=n))
    whole, whole_processor, peak = measured(folder, [program, "run", "job.toml", "--threads", "2", "--quiet"])
    expected = fingerprints(folder / "map.h5")
    print(f"{n}^5 cells, one process of two threads: {whole:.1f} s, {whole_processor:.1f} s of processor, {peak:.0f} MB of memory, {size([folder / 'map.h5']):.1f} MB\n")
    print("| shards | run, s | processor, s | efficiency | journals, MB | merge, s | processor, s | copying them, s | memory of merging, MB | equal |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for of in (1, 2, 7, 64):
        (folder / "map.h5").unlink()
        seconds, processor, _ = shards(program, folder, of)
        journals = size(folder.glob("map.h5.part.*"))
        copied = copying(folder)
        merging, merging_processor, peak = measured(folder, [program, "merge", "job.toml", "--quiet"])
        equal = "yes" if fingerprints(folder / "map.h5") == expected else "NO"
        # Of a run with its merge, as the one process makes its map too.
        efficiency = whole_processor / (processor + merging_processor)
        print(f"| {of} | {seconds:.1f} | {processor:.1f} | {efficiency:.2f} | {journals:.1f} | {merging:.2f} | {merging_processor:.2f} | {copied:.2f} | {peak:.0f} | {equal} |", flush=True)


def large(program, folder, cells):
    n = 100
    (folder / "job.toml").write_text(FIVE_AXES.format(a=round(cells / n**4), n=n))
    print(f"{round(cells / n**4) * n**4:,} cells in eight shards, two at a time\n\n| step | s | processor, s | memory, MB |\n| --- | --- | --- | --- |")

    def step(name, found):
        print(f"| {name} | {found[0]:.1f} | {found[1]:.1f} | {found[2]:.0f} |", flush=True)

    step("run", shards(program, folder, 8))
    print(f"| copy {size(folder.glob('map.h5.part.*')):.0f} MB of journals | {copying(folder):.1f} | | |")
    step("merge", measured(folder, [program, "merge", "job.toml", "--quiet"]))
    step(f"check {size([folder / 'map.h5']):.0f} MB", measured(folder, [program, "check", "map.h5"]))
    plot = [program, "plot", "map.h5", "--x", "gamma", "--y", "c", "--variable", "verdict_simulation", "--out", "slice.png"]
    step("plot a slice, gamma and c", measured(folder, plot))
    read = "import xarray; map = xarray.open_dataset('map.h5', chunks={}); print(map.verdict_simulation[0, 5, 7].mean().compute())"
    step("xarray with dask: open, mean of a slice", measured(folder, [sys.executable, "-c", read]))


def main():
    program, arguments = str(Path(sys.argv[1]).resolve()), sys.argv[2:]
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as scratch:
        if arguments[:1] == ["--large"]:
            large(program, Path(scratch), float(arguments[1]) if arguments[1:] else 1e10)
        else:
            small(program, Path(scratch), int(arguments[0]) if arguments else 64)


main()
