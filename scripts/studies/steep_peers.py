"""heyoka on friction that falls steeply: the verdicts of 4,096 cells beside a map of them.

    scripts/study steep_peers [--date YYYY-MM-DD]

Friction falls from 1 to 0.58 as exp(-u/vs); 256 belt speeds from 0.1 to 1 times 16 dampings c from 0 to 1.5, eps = 1. heyoka
integrates v' = w, w' = D(V - v) w - v in batches of 64, first for a time of 1, then until v = V (the orbit returns) or
w = 0 (it does not). (With exp(-u/vs) as a third variable it needs no exponential, but that loses its digits far from the
line.) Its tolerance is the loosest of a ladder at which it agrees with c* of the map in every cell that is farther than
1e-6 from it. Times are processor time of one thread, the least of three passes, compiling, reading and writing not counted.
"""

import argparse
import datetime
import json
import sys
import tempfile
import time
from pathlib import Path

import h5py
import heyoka as hy
import numpy as np

from measure import done, table

ROOT = Path(__file__).resolve().parents[2]
FALL, LANES, PASSES = 0.42, 64, 3
BELTS, DAMPINGS = np.linspace(0.1, 1.0, 256), np.linspace(0.0, 1.5, 16)
WIDTHS = [1.0, 0.1, 0.03, 0.01, 0.001]
# An orbit that has not turned by then tends to rest.
LONGEST = 50.0
LADDER = [10.0**-k for k in range(3, 16)]


def own(program, vs):
    """Seconds of a map's simulation, and its c* by belt speed."""
    job = (
        f'[friction]\nlaw = "exponential"\n[grid]\nepsilon = 1.0\nmu = {1 - FALL!r}\nvs = {vs!r}\neta = 0.0\n'
        f"V = {BELTS.tolist()}\nc = {DAMPINGS.tolist()}\n"
        '[methods]\nrun = ["simulation"]\n[audit]\ncells = 0\n[output]\npath = "map.h5"\nfields = ["verdict", "critical_c"]\n'
    )
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "job.toml").write_text(job)
        command = [program, "run", "job.toml", "--quiet", "--threads", "1", "--json", "--overwrite"]
        runs = [json.loads(done(command, folder, messages=None).said) for _ in range(PASSES)]
        with h5py.File(Path(folder, "map.h5")) as file:
            critical = file["critical_c_simulation"][()].ravel()
    return min(run["methods"]["simulation"]["seconds"] for run in runs), critical


class Heyoka:
    """Integrators of a law: without events, and with those that end an orbit, which then rests in v = 0."""

    def __init__(self, tolerance, vs):
        v, w = hy.make_vars("v", "w")
        viscous, belt = hy.par[0], hy.par[1]
        flow = [(v, w), (w, (FALL / vs * hy.exp((v - belt) / vs) - viscous) * w - v)]
        self.returned, start, pars = np.zeros(LANES, bool), np.ones((2, LANES)), np.ones((2, LANES))
        ends = [
            hy.t_event_batch(v - belt, callback=self.end(True), direction=hy.event_direction.positive),
            hy.t_event_batch(w, callback=self.end(False), direction=hy.event_direction.negative),
        ]
        self.first = hy.taylor_adaptive_batch(flow, start, pars=pars, tol=tolerance)
        self.second = hy.taylor_adaptive_batch(flow, start, pars=pars, tol=tolerance, t_events=ends)

    def end(self, returns):
        def callback(integrator, sign, lane):
            self.returned[lane] |= returns
            integrator.state[:, lane] = 0.0
            return True

        return callback

    def returns(self):
        """Whether the orbit of each cell returns; the seconds, and the steps of a batch for each cell."""
        belts, dampings = (grid.ravel() for grid in np.meshgrid(BELTS, DAMPINGS, indexing="ij"))
        found, steps, start = np.zeros(len(belts), bool), 0, time.process_time()
        for i in range(0, len(belts), LANES):
            lanes = slice(i, i + LANES)
            self.first.state[:] = [belts[lanes], np.zeros(LANES)]
            self.first.pars[:] = self.second.pars[:] = [dampings[lanes], belts[lanes]]
            self.first.set_time(0.0)
            self.first.propagate_until([1.0] * LANES)
            self.second.state[:] = self.first.state
            self.second.set_time(0.0)
            self.second.reset_cooldowns()
            self.returned[:] = False
            self.second.propagate_until([LONGEST] * LANES)
            steps += max(result[3] for result in self.first.propagate_res)
            steps += max(result[3] for result in self.second.propagate_res)
            found[lanes] = self.returned
        return found, time.process_time() - start, steps * LANES / len(belts)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--date", default=datetime.date.today().isoformat())
    args = parser.parse_args()
    columns = ["vs", "slipmap_microseconds", "heyoka_tolerance", "heyoka_wrong", "heyoka_steps", "heyoka_microseconds", "ratio"]
    add = table(ROOT / "results" / f"steep-peers-{args.date}.csv", columns)
    for vs in WIDTHS:
        seconds, critical = own(args.program, vs)
        known = (np.abs(critical[:, None] - DAMPINGS) > 1e-6).ravel()
        truth = (critical[:, None] > DAMPINGS).ravel()
        for tolerance in LADDER:
            peer = Heyoka(tolerance, vs)
            found, best, steps = peer.returns()
            wrong = np.sum(known & (found != truth))
            if wrong == 0:
                break
        best = min(best, *(peer.returns()[1] for _ in range(PASSES - 1)))
        times = [1e6 * taken / len(truth) for taken in (seconds, best)]
        add([vs, f"{times[0]:.3g}", f"{tolerance:.0e}", wrong, f"{steps:.0f}", f"{times[1]:.3g}", f"{best / seconds:.3g}"])
        sys.stdout.flush()


if __name__ == "__main__":
    main()
