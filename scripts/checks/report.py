#!/usr/bin/env python3
"""Recomputes every number in the tables of a report from its map, and opens the files with other programs.

    scripts/checks/report.py MAP.h5 REPORT [--study DIR] [--figure F.png]

REPORT is the folder of `slipmap report MAP.h5`. Only h5py and numpy read the map, and nothing is shared with the program:
volumes are sums of weights of nodes here and of boxes there, errors come from sorting here and from histograms
there. The map has to store the verdict and critical_c of every method. DIR is the folder of `slipmap work-precision`, F.png
a figure of scripts/plot_map.py. Exit code 0 if all holds.
"""

import argparse
import csv
import re
import sys
from math import isclose, log, nan
from pathlib import Path

import h5py
import numpy as np

ABSENT, PRESENT, FAILED, NOT_COMPUTED = -1, 1, 2, 3
BIN = 2.0**-11  # half the relative width of the report's histogram of errors
SUMS = 1e-9  # sums of millions of numbers in another order

failures = 0
checked = 0


def expect(found, wanted, what, relative=SUMS, absolute=0.0):
    """Compares a cell of a table (text; empty for none) with a number, a word, or None."""
    global failures, checked
    checked += 1
    if wanted is None or wanted != wanted:
        holds = found == ""
    elif isinstance(wanted, str):
        holds = found == wanted
    elif found == "":
        holds = False
    else:
        holds = isclose(float(found), float(wanted), rel_tol=relative, abs_tol=absolute)
    if not holds:
        failures += 1
        print(f"FAILED: {what}: the table says {found!r}, the map {wanted!r}")


def read_table(folder, name):
    with open(folder / "tables" / f"{name}.csv", newline="") as file:
        return list(csv.DictReader(file))


def share(part, whole):
    return 100.0 * part / whole if whole > 0 else None


class Map:
    """The map's data, from which the tables are recomputed."""

    def __init__(self, path):
        self.file = h5py.File(path)
        first = next(name for name in self.file if name.startswith("verdict_"))
        self.axes = [self.file[self.scale(first, i)] for i in range(self.file[first].ndim)]
        self.names = [axis.name.strip("/") for axis in self.axes]
        self.nodes = [axis[:] for axis in self.axes]
        self.methods = self.text("methods").split()
        self.verdicts = {method: self.file[f"verdict_{method}"][:] for method in self.methods}
        self.epsilons = self.nodes[0]

    def scale(self, variable, dimension):
        return self.file[self.file[variable].attrs["DIMENSION_LIST"][dimension][0]].name

    def text(self, name):
        value = self.file.attrs.get(name)
        return value.decode() if isinstance(value, bytes) else value

    def number(self, name):
        value = self.file.attrs.get(name)
        return None if value is None else float(np.atleast_1d(value)[0])

    def critical(self, method):
        """Critical dampings, one row for each eps; NaN where there is none at c >= 0."""
        values = self.file[f"critical_c_{method}"][:].reshape(len(self.epsilons), -1)
        return np.where((values >= 0) & np.isfinite(values), values, nan)

    def errors(self):
        """The errors of the critical dampings of the simulation, as in critical()."""
        return self.file["critical_c_error_simulation"][:].reshape(len(self.epsilons), -1)

    def columns(self):
        """The parameters of every column, as in critical(), by name."""
        grids = np.meshgrid(*self.nodes[:-1], indexing="ij")
        return {name: grid.reshape(len(self.epsilons), -1) for name, grid in zip(self.names, grids)}


def trapezoids(nodes):
    """The weight of each node in the trapezoidal rule; 1 for a single node."""
    if len(nodes) == 1:
        return np.ones(1)
    steps = np.diff(nodes)
    return 0.5 * (np.append(steps, 0) + np.append(0, steps))


def weigh(values, weights):
    for axis_weights in reversed(weights):
        values = values @ axis_weights
    return float(values)


def check_volume(data, folder):
    weights = [trapezoids(nodes) for nodes in data.nodes[1:]]
    box = float(np.prod([nodes[-1] - nodes[0] for nodes in data.nodes[1:] if len(nodes) > 1]))
    measured = {}
    for e, epsilon in enumerate(data.epsilons):
        simulated = data.verdicts["simulation"][e] == PRESENT if "simulation" in data.methods else None
        for method in data.methods:
            inside = (data.verdicts[method][e] == PRESENT).astype(float)
            volume = weigh(inside, weights)
            in_c = 0.0
            if len(data.nodes[-1]) > 1:
                steps = np.diff(data.nodes[-1])
                in_c = 0.5 * weigh(np.abs(np.diff(inside, axis=-1)), [*weights[:-1], steps])
            corners = inside
            lengths = []
            for axis, nodes in enumerate(data.nodes[1:]):
                if len(nodes) > 1:
                    low = corners.take(range(len(nodes) - 1), axis)
                    corners = 0.5 * (low + corners.take(range(1, len(nodes)), axis))
                lengths.append(np.diff(nodes) if len(nodes) > 1 else np.ones(1))
            mixed = (corners > 0) & (corners < 1)
            error = weigh(np.where(mixed, np.maximum(corners, 1 - corners), 0.0), lengths)
            confirmed = weigh(inside * simulated, weights) if simulated is not None else None
            measured[epsilon, method] = volume, in_c, error, confirmed
    for row in read_table(folder, "volume"):
        epsilon, method = float(row["epsilon"]), row["method"]
        what = f"volume of {method} at {epsilon}"
        volume, in_c, error, confirmed = measured[epsilon, method]
        expect(row["volume"], volume, what)
        expect(row["volume_error_in_c"], in_c, what, absolute=SUMS * box)
        expect(row["volume_error"], error, what, absolute=SUMS * box)
        expect(row["percent_of_box"], share(volume, box), what)
        reference, reference_error = measured.get((epsilon, "simulation"), (0.0, 0.0))[:2]
        expect(row["percent_of_simulation"], share(volume, reference), what)
        expect(row["percent_of_simulation_confirmed"], share(confirmed or 0.0, reference), what)
        bound = None
        if reference > reference_error and method != "simulation":
            middle = volume / reference
            high = (volume + in_c) / (reference - reference_error)
            low = max(volume - in_c, 0.0) / (reference + reference_error)
            bound = 100.0 * max(high - middle, middle - low)
        expect(row["percent_of_simulation_error"], bound, what, relative=1e-6)


def check_agreement(data, folder):
    for row in read_table(folder, "agreement"):
        method = row["method"]
        layer = slice(None) if row["epsilon"] == "" else int(np.flatnonzero(data.epsilons == float(row["epsilon"]))[0])
        codes = data.verdicts[method][layer]
        what = f"agreement of {method} at {row['epsilon'] or 'all epsilon'}"
        for name, found in [("absent", [-1]), ("undecided", [0]), ("present", [1]), ("failed", [FAILED, NOT_COMPUTED])]:
            expect(row[name], np.isin(codes, found).sum(), f"{what}: {name}")
        expect(row["percent_decided"], share(np.isin(codes, [ABSENT, PRESENT]).sum(), codes.size), what)
        wrong = [None] * 3
        if "simulation" in data.methods:
            truth = data.verdicts["simulation"][layer]
            wrong = [
                ((codes == PRESENT) & (truth == ABSENT)).sum(),
                ((codes == ABSENT) & (truth == PRESENT)).sum(),
                (~np.isin(truth, [ABSENT, PRESENT])).sum(),
            ]
        for name, count in zip(("wrong_presence", "wrong_absence", "not_compared"), wrong):
            expect(row[name], count, f"{what}: {name}")


def quantile(sizes, q):
    """The least size that at least the share q of all do not exceed."""
    return np.sort(sizes)[max(int(np.ceil(q * len(sizes))), 1) - 1] if len(sizes) else None


def check_boundary(data, folder):
    exact, known, parameters = data.critical("simulation"), data.errors(), data.columns()
    errors = {m: data.critical(m) - exact for m in data.methods if np.isfinite(data.critical(m)).any() or m != "simulation"}
    for row in read_table(folder, "boundary"):
        method, e = row["method"], int(np.flatnonzero(data.epsilons == float(row["epsilon"]))[0])
        what = f"boundary of {method} at {row['epsilon']}"
        own, error = np.isfinite(data.critical(method)[e]), errors[method][e]
        both = np.isfinite(error)
        sizes = np.abs(error[both])
        expect(row["columns"], both.sum(), what)
        expect(row["only_exact"], (~own & np.isfinite(exact[e])).sum(), what)
        expect(row["only_method"], (own & ~np.isfinite(exact[e])).sum(), what)
        expect(row["median_error"], quantile(sizes, 0.5), what, relative=BIN * 1.001)
        expect(row["percentile_95_error"], quantile(sizes, 0.95), what, relative=BIN * 1.001)
        expect(row["percent_beyond"], share((error[both] > known[e][both]).sum(), both.sum()), what)
        if both.any():
            worst = np.flatnonzero(both)[np.argmax(sizes)]
            expect(row["worst_error"], error[worst], what)
            if np.sum(sizes == sizes.max()) == 1:
                for name in data.names[1:-1]:
                    expect(row[name], parameters[name][e][worst], f"{what}: worst {name}")
    check_order(data, folder, errors, known)


def check_order(data, folder, errors, known):
    # A map of one epsilon has no order.
    if not (folder / "tables" / "order.csv").exists():
        return
    rows = read_table(folder, "order")
    for method in dict.fromkeys(row["method"] for row in rows):
        error = np.abs(errors[method])
        common = np.isfinite(error).all(axis=0)
        points = []
        for e, epsilon in enumerate(data.epsilons):
            median = quantile(error[e][common], 0.5)
            if median is not None and median > quantile(known[e], 0.5):
                points.append((log(epsilon), log(median)))
        found = [row for row in rows if row["method"] == method and row["order"] != ""]
        what = f"order of {method}"
        expect(len(found), max(len(points) - 1, 0), what)
        for row, (x, y), (to_x, to_y) in zip(found, points, points[1:]):
            # Medians are off by up to half a bin, so the slope between two of them by up to 2 bins over their
            # distance.
            expect(row["order"], (to_y - y) / (to_x - x), what, absolute=4 * BIN / (to_x - x))


def check_rest(data, folder):
    cells = data.verdicts[data.methods[0]].size
    for row in read_table(folder, "cost"):
        seconds = data.number(f"seconds_{row['method']}")
        expect(row["cells"], cells, "cost")
        expect(row["seconds"], seconds, "cost")
        expect(row["cells_per_second"], cells / seconds if seconds else None, "cost")
    audit = {"decided again": "audit_cells", "contradicted": "audit_disagreements"}
    for row in read_table(folder, "failures"):
        if row["what"].startswith("cells without an answer"):
            lost = sum(int(((v == FAILED) | (v == NOT_COMPUTED)).sum()) for v in data.verdicts.values())
            expect(row["count"], lost, row["what"])
            continue
        if row["what"].startswith("cells in which theorems"):
            expect(row["count"], data.number("contradicted_cells"), row["what"])
            continue
        if row["what"].startswith("cells whose regime"):
            regimes = data.file["regime"]
            failed = regimes.attrs["flag_meanings"].split().index(b"failed")
            expect(row["count"], int((regimes[...] == regimes.attrs["flag_values"][failed]).sum()), row["what"])
            continue
        method, what = row["what"].split(": ", 1)
        if method in data.methods:
            code = FAILED if what == "cells failed" else NOT_COMPUTED
            expect(row["count"], (data.verdicts[method] == code).sum(), row["what"])
        else:
            name = next(name for words, name in audit.items() if words in what)
            expect(row["count"], data.number(name), row["what"])
    for row, name, nodes in zip(read_table(folder, "axes"), data.names, data.nodes, strict=True):
        for key, value in [("axis", name), ("nodes", len(nodes)), ("from", nodes[0]), ("to", nodes[-1])]:
            expect(row[key], value, f"axis {name}")
    for row, method in zip(read_table(folder, "methods"), data.methods, strict=True):
        attributes = data.file[f"verdict_{method}"].attrs
        expect(row["method"], method, "methods")
        for key in ("guarantee", "equation"):
            value = attributes[key]
            value = value.decode() if isinstance(value, bytes) else str(value)
            expect(row[key], value.replace("_", " ") if key == "guarantee" else value, f"{key} of {method}")
    told = {row["what"]: row["value"] for row in read_table(folder, "provenance")}
    expect(told["cells"], str(cells), "provenance")
    for what, name in [("title", "title"), ("machine", "machine"), ("sources", "git"), ("engine", "engine")]:
        expect(told[what], data.text(name), f"provenance: {what}")
    expect(told["SHA-256 of the configuration"], data.text("config_sha256"), "provenance")


def check_page(folder):
    """Checks that report.html needs no network, and that its figures contain searchable text."""
    page = (folder / "report.html").read_text()
    expect(str(len(re.findall(r'(?:src|href)\s*=(?!"#)|url\((?!#)|@import|<script', page))), "0", "report.html: things from elsewhere")
    expect("yes" if page.count("<svg") >= 5 and page.count("<text") > 100 else "no", "yes", "report.html: figures")


def check_study(folder):
    """Checks that the study's HDF5 file equals its CSV, with both engines of xarray."""
    import xarray as xr

    with open(folder / "work-precision.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for engine in ("h5netcdf", "netcdf4"):
        with xr.open_dataset(folder / "work-precision.h5", engine=engine) as data:
            meanings = data["method"].attrs["flag_meanings"].split()
            for i, row in enumerate(rows):
                expect(meanings[int(data["method"][i])], row["method"].replace(" ", "_"), f"{engine}: method")
                for key in ("seconds_per_cell", "margin_error_worst", "critical_c_error_median", "near_wrong"):
                    value = float(data[key][i])
                    expect(row[key], value, f"{engine}: {key} of {row['method']}")
            expect(str(data.sizes["cell"]), str(sum(1 for _ in open(folder / "cells.csv")) - 1), f"{engine}: cells")


def check_figure(path):
    """Checks that a picture exists, is large enough for several panels, and has areas of several colours."""
    import matplotlib.image

    pixels = matplotlib.image.imread(path)[..., :3]
    colors, counts = np.unique((255 * pixels).round().astype(np.uint8).reshape(-1, 3), axis=0, return_counts=True)
    large = int(np.sum(counts > 0.005 * counts.sum()))
    expect("yes" if pixels.shape[1] > 500 and large >= 3 else "no", "yes", f"{path}: {pixels.shape}, {large} colours")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("map", type=Path)
    parser.add_argument("report", type=Path)
    parser.add_argument("--study", type=Path)
    parser.add_argument("--figure", type=Path)
    args = parser.parse_args()
    data = Map(args.map)
    check_volume(data, args.report)
    check_agreement(data, args.report)
    check_boundary(data, args.report)
    check_rest(data, args.report)
    check_page(args.report)
    if args.study:
        check_study(args.study)
    if args.figure:
        check_figure(args.figure)
    print(f"{checked} numbers of {args.report} recomputed, {failures} differ")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
