#!/usr/bin/env python3
"""Plots one slice of a map with xarray and matplotlib: python scripts/plot_map.py MAP.h5 OUT.png

A starting point for figures of your own. Needs: pip install xarray h5netcdf h5py matplotlib
"""

import sys

import matplotlib

matplotlib.use("Agg")  # draws into files, needs no screen
import matplotlib.pyplot as plt
import xarray as xr
from matplotlib.colors import BoundaryNorm, ListedColormap

COLORS = ["#f7e3bf", "#ffffff", "#0072b2", "#000000", "#8c8c8c"]  # absent, undecided, present, failed, not computed
SYMBOLS = {"epsilon": "ε", "alpha": "α", "beta": "β", "gamma": "γ"}


def main(map_path, out_path):
    with xr.open_dataset(map_path, engine="h5netcdf") as data:
        names = [name for name in data if name.startswith("verdict_")]
        # Two axes to show: the damping, and the longest of the others except epsilon. All others are fixed at
        # their middle.
        sizes = data[names[0]].sizes
        y = tuple(sizes)[-1]
        x = max((axis for axis in sizes if axis not in (y, "epsilon")), key=lambda axis: sizes[axis])
        held = {axis: size // 2 for axis, size in sizes.items() if axis not in (y, x)}
        critical = f"critical_{y}_simulation"
        fig, panels = plt.subplots(1, len(names), figsize=(2.2 * len(names), 2.6), sharey=True, squeeze=False)
        for panel, name in zip(panels[0], names):
            cells = data[name].isel(held).transpose(y, x)
            codes = list(cells.attrs["flag_values"])
            norm = BoundaryNorm([code - 0.5 for code in codes] + [codes[-1] + 0.5], len(codes))
            panel.pcolormesh(cells[x], cells[y], cells, cmap=ListedColormap(COLORS), norm=norm, shading="nearest")
            if critical in data:
                exact = data[critical].isel(held)
                panel.plot(exact[x], exact, "k-", linewidth=1.2)
            panel.set_title(name.removeprefix("verdict_").replace("_", " "), fontsize=8)
            panel.set_xlabel(SYMBOLS.get(x, x))
            panel.set_ylim(float(cells[y].min()), float(cells[y].max()) or None)
        panels[0][0].set_ylabel(y)
        at = ", ".join(f"{SYMBOLS.get(axis, axis)} = {float(data[axis][i]):.4g}" for axis, i in held.items())
        fig.suptitle(at, fontsize=9)
        fig.tight_layout()
        fig.savefig(out_path, dpi=200)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
