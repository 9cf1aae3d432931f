#!/usr/bin/env python3
"""Shares of initial states that tend to the equilibrium, for docs/gallery.md: results/gallery/bstab2021.csv.

    slipmap run configs/gallery/bstab2021.toml
    scripts/study gallery results/bstab2021.h5 > results/gallery/bstab2021.csv

What settles at rest is the inside of the unstable slip cycle. The map stores the cycle's largest velocity; one turn from
there by the classical Runge-Kutta method, in 20,000 steps, gives its area within the published box of starts.
"""

import math
import sys

import xarray as xr

XI = 0.05
# Shares by bSTAB with 5,000 random starts per belt speed, as stored in tests/integration/friction/
# main_friction_v_study.json of github.com/adrianwix/pyBasin.
PUBLISHED = [0, 0, 0, 0, 0, 0.0132, 0.08, 0.1478, 0.213, 0.2776, 0.3544, 0.4202, 0.4922, 0.5678, 1, 1, 1, 1, 1, 1]
STARTS = 5000


def area(belt, top):
    """Area inside the slip cycle whose largest velocity is `top`, within x in [-2, 2] and x' in [0, 2]."""

    def field(x, v):
        return v, -x - 2 * XI * v + 0.5 + 0.5 * math.exp(-(belt - v) / 0.5)

    steps = 20000
    h = 2.1 * math.pi / steps
    x, v = -2 * XI * top + 0.5 + 0.5 * math.exp(-(belt - top) / 0.5), top
    total = 0.0
    for step in range(steps):
        k1 = field(x, v)
        k2 = field(x + h / 2 * k1[0], v + h / 2 * k1[1])
        k3 = field(x + h / 2 * k2[0], v + h / 2 * k2[1])
        k4 = field(x + h * k3[0], v + h * k3[1])
        new = (
            x + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0]),
            v + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1]),
        )
        if step > steps // 2 and new[1] > 0 and field(*new)[1] <= 0:
            break
        inside = [min(max(value, -2), 2) for value in (x, new[0])], [min(max(value, 0), 2) for value in (v, new[1])]
        total += 0.5 * sum(inside[0]) * (inside[1][1] - inside[1][0])
        x, v = new
    return abs(total)


m = xr.open_dataset(sys.argv[1]).squeeze(drop=False)
names = m.regime.attrs["flag_meanings"].split()
print("V,regime,share_at_rest,published,standard_error,deviation_in_standard_errors")
for i, published in enumerate(PUBLISHED):
    cell = m.isel(V=i)
    regime = names[list(m.regime.attrs["flag_values"]).index(int(cell.regime))]
    top = float(cell.boundary_velocity)
    share = area(float(cell.V), top) / 8 if not math.isnan(top) else float(regime == "equilibrium")
    error = math.sqrt(published * (1 - published) / STARTS)
    deviation = f"{(published - share) / error:.1f}" if error else ""
    print(f"{float(cell.V):.4g},{regime},{share:.4f},{published},{error:.4f},{deviation}")
