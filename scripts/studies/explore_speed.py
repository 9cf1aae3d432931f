#!/usr/bin/env python3
"""How long `slipmap explore` takes from a request to the painted plane, and what it weighs.

    scripts/study explore_speed [--out results/explore/speed.csv] [--points 512]

In Debian's chromium, the page's own code asks for a picture and paints it: milliseconds of the fastest of five, and milliseconds of
the program's processor time. For each law with the damping as an axis and without it; the behaviour (`regime`) and the verdict of the simulation.
Also the bytes of the page and of the program, and its memory at the end.
"""

import argparse
import csv
import os
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.append(str(Path(__file__).parents[1] / "checks"))
import explore

TABLE = "".join(f"{u / 4},{0.5 + 0.5 * 2.718281828 ** (-u / 2)}\n" for u in range(33))
LAWS = [
    ("stribeck", {"name": "stribeck"}, {"epsilon": 0.2, "alpha": 0.3, "beta": 0.1, "gamma": 2, "V": 1, "c": 0.5}, "gamma"),
    ("formula", {"name": "expression", "phi": "mu + (1 - mu)*exp(-u/vs)"}, {"epsilon": 1, "mu": 0.5, "vs": 0.5, "V": 1, "c": 0.1}, "mu"),
    ("table", {"name": "table", "table": TABLE}, {"epsilon": 1, "V": 1, "c": 0.1}, "epsilon"),
]
TAKE = """async ([body, canvas]) => {
    const { picture } = await import("/assets/server.js");
    const { paint } = await import("/assets/paint.js");
    const catalogue = await (await fetch("/api/catalogue")).json();
    const board = Object.assign(document.createElement("canvas"), { width: canvas, height: canvas });
    const started = performance.now();
    try {
        const found = await picture(body);
        paint(board, { ...found, show: body.show }, catalogue);
    } catch (problem) { return null }
    return performance.now() - started;
}"""


def processor_seconds(process):
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("slipmap")
    parser.add_argument("--out", type=Path, default=Path("results/explore/speed.csv"))
    parser.add_argument("--points", type=int, default=512)
    arguments = parser.parse_args()
    server = explore.Server(arguments.slipmap)
    rows = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=explore.FLAGS)
        page = browser.new_page()
        page.goto(server.address + explore.STRIBECK)
        explore.settle(page)
        for name, law, at, other in LAWS:
            for up, end in (("c", 0.5), (other, 1.0)):
                for show in ("regime", "verdict_simulation"):
                    sides = {"x": {"axis": "V", "from": 0.2, "to": 2.0}, "y": {"axis": up, "from": 0.1, "to": end}}
                    body = {"law": law, "at": at, "show": show}
                    body |= {side: it | {"points": arguments.points} for side, it in sides.items()}
                    taken = []
                    for _ in range(5):
                        before = processor_seconds(server.process.pid)
                        milliseconds = page.evaluate(TAKE, [body, arguments.points])
                        if milliseconds is None:
                            break
                        taken.append((milliseconds, 1000 * (processor_seconds(server.process.pid) - before)))
                        if milliseconds > 2000:
                            break
                    best = [f"{min(times):.0f}" for times in zip(*taken)] if taken else ["more than 20000", ""]
                    rows.append([name, f"V, {up}", show, *best])
                    print(*rows[-1], flush=True)
        browser.close()
    memory = next(line for line in Path(f"/proc/{server.process.pid}/status").read_text().splitlines() if line.startswith("VmRSS"))
    server.end()
    assets = sum(path.stat().st_size for path in Path("crates/explore/src/assets").iterdir())
    rows += [["page", "bytes", "", assets, ""], ["program", "bytes", "", Path(arguments.slipmap).stat().st_size, ""]]
    rows += [["memory", "bytes", "", 1024 * int(memory.split()[1]), ""]]
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    with open(arguments.out, "w", newline="") as file:
        csv.writer(file).writerows([["law", "plane", "show", "milliseconds", "processor milliseconds"], *rows])
    return 0


if __name__ == "__main__":
    sys.exit(main())
