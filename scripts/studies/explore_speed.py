#!/usr/bin/env python3
"""How long the page of `slipmap explore` takes, behind a server and as a file, and what it weighs.

    scripts/study explore_speed [--out results/explore/speed.csv]

In Debian's chromium: milliseconds from the navigation to the first picture, of the first opening and of the second; then the
fastest of fifteen answers, of the program on one core and of one worker of the file. Planes have 100 x 80 cells of the behaviour, with the
damping as an axis and without it. Also the bytes of the file, and as gzip sends it.
"""

import argparse
import csv
import gzip
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.append(str(Path(__file__).parents[1] / "checks"))
import explore

TABLE = "".join(f"{u / 4},{0.5 + 0.5 * 2.718281828 ** (-u / 2)}\n" for u in range(33))
LAWS = [
    ("exponential", {"name": "exponential"}, {"epsilon": 1, "mu": 0.5, "vs": 0.5, "eta": 0, "V": 1, "c": 0.1}, "mu"),
    ("formula", {"name": "expression", "phi": "mu + (1 - mu)*exp(-u/vs)"}, {"epsilon": 1, "mu": 0.5, "vs": 0.5, "V": 1, "c": 0.1}, "mu"),
    ("table", {"name": "table", "table": TABLE}, {"epsilon": 1, "V": 1, "c": 0.1}, "epsilon"),
]  # fmt: skip
TAKE = """async ([path, body]) => {
    const started = performance.now();
    await (path === "plane" ? slipmap.picture(body) : slipmap.post(path, body));
    return performance.now() - started;
}"""
FIRST = "document.getElementById('cells').dataset.cells !== undefined && performance.now()"


def first_picture(page, address):
    page.goto(address)
    while not (milliseconds := page.evaluate(FIRST)):
        page.wait_for_timeout(5)
    return milliseconds


def requests():
    """Name, path and body of what is asked."""
    for name, law, at, other in LAWS:
        place = {"law": law, "at": at}
        for up, end in (("c", 0.5), (other, 1.0)):
            sides = {"x": {"axis": "V", "from": 0.2, "to": 2.0, "points": 100}, "y": {"axis": up, "from": 0.1, "to": end, "points": 80}}
            yield f"{name}: plane V, {up}", "plane", place | sides | {"show": "regime"}
        yield f"{name}: point", "point", place
        yield f"{name}: motion", "figure", place | {"figure": "orbit"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("slipmap")
    parser.add_argument("--out", type=Path, default=Path("results/explore/speed.csv"))
    arguments = parser.parse_args()
    # The server inherits the one core; the browser has all.
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})
    server = explore.Server(arguments.slipmap)
    os.sched_setaffinity(0, cores)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        file = Path(folder) / "page.html"
        subprocess.run([arguments.slipmap, "explore", "--out", str(file)], check=True)
        bytes = file.read_bytes()
        rows = [["bytes", "", len(bytes)], ["bytes, sent as gzip", "", len(gzip.compress(bytes, 9))]]
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=explore.FLAGS)
        context = browser.new_context()
        # One worker computes the planes.
        context.add_init_script("Object.defineProperty(navigator, 'hardwareConcurrency', { value: 1 })")
        addresses = [server.address, f"file://{file}"]
        pages = [context.new_page(), context.new_page()]
        for words in ("first picture, cold", "first picture, warm"):
            rows.append([words, *(f"{first_picture(page, address + explore.STRIBECK):.0f}" for page, address in zip(pages, addresses))])
            for page in pages:
                explore.settle(page)
                page.goto("about:blank")
        for page, address in zip(pages, addresses):
            page.goto(address + explore.STRIBECK)
            explore.settle(page)
        for words, path, body in requests():
            rows.append([words, *(f"{min(page.evaluate(TAKE, [path, body]) for _ in range(15)):.1f}" for page in pages)])
            print(*rows[-1], flush=True)
        browser.close()
    server.end()
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with open(arguments.out, "w", newline="") as target:
        csv.writer(target).writerows([["what", "program on one core, ms", "file with one worker, ms"], *rows])
    return 0


if __name__ == "__main__":
    sys.exit(main())
