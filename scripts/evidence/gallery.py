#!/usr/bin/env python3
"""Published numbers beside ours, for docs/gallery.md: results/gallery/published.md, and of bSTAB every row,
results/gallery/bstab2021.csv.

    scripts/study gallery

What settles at rest is the inside of the unstable slip cycle. The map stores the cycle's largest velocity; one turn from
there by the classical Runge-Kutta method gives its area within the published box of starts; its error is the difference
between 20,000 steps and half of them.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import xarray as xr

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = sys.argv[1]
XI = 0.05
# Shares by bSTAB with 5,000 random starts per belt speed, as stored in tests/integration/friction/
# main_friction_v_study.json of github.com/adrianwix/pyBasin.
PUBLISHED = [0, 0, 0, 0, 0, 0.0132, 0.08, 0.1478, 0.213, 0.2776, 0.3544, 0.4202, 0.4922, 0.5678, 1, 1, 1, 1, 1, 1]
STARTS = 5000


def area(belt, top, steps=20000):
    """Area inside the slip cycle whose largest velocity is `top`, within x in [-2, 2] and x' in [0, 2]."""

    def field(x, v):
        return v, -x - 2 * XI * v + 0.5 + 0.5 * math.exp(-(belt - v) / 0.5)

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


def ask(*arguments):
    """The answer of the program, from its JSON."""
    told = subprocess.run([PROGRAM, *arguments, "--json"], cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(told.stdout)


def bstab():
    """Writes every share, and returns for each with a standard error (belt speed, published, its error, here, error)."""
    rows, lines = [], ["V,regime,share_at_rest,published,standard_error,deviation_in_standard_errors"]
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/map.h5"
        configuration = "configs/gallery/bstab2021.toml"
        command = [PROGRAM, "run", configuration, "--quiet", "--set", f"output.path={path}"]
        subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        m = xr.open_dataset(path).squeeze(drop=False).load()
        m.close()
    names = m.regime.attrs["flag_meanings"].split()
    for i, published in enumerate(PUBLISHED):
        cell = m.isel(V=i)
        regime = names[list(m.regime.attrs["flag_values"]).index(int(cell.regime))]
        top = float(cell.boundary_velocity)
        cycle = not math.isnan(top)
        share = area(float(cell.V), top) / 8 if cycle else float(regime == "equilibrium")
        error = math.sqrt(published * (1 - published) / STARTS)
        deviation = f"{(published - share) / error:.1f}" if error else ""
        lines.append(f"{float(cell.V):.4g},{regime},{share:.4f},{published},{error:.4f},{deviation}")
        if error:
            ours = abs(share - area(float(cell.V), top, 10000) / 8) if cycle else 0.0
            rows.append((float(cell.V), published, error, share, ours))
    (ROOT / "results/gallery/bstab2021.csv").write_text("\n".join(lines) + "\n")
    return rows


def machine(configuration, belt_speed, damping):
    """A machine of the gallery at one working point."""
    point = [f"belt_speed={belt_speed!r}", f"damping={damping!r}"]
    return ask("machine", configuration, "--set", point[0], "--set", point[1])


def largest_speed(configuration, start, damping):
    """The largest belt speed with stick-slip at this damping, and its error: that of the critical damping there,
    and its distance from this damping, over its derivative by belt speed."""
    speed = machine(configuration, start, damping)["may_stick_slip_below_belt_speed"]
    there = machine(configuration, speed, damping)
    slopes = {each["quantity"]: each["critical_damping"] for each in there["sensitivities"]}
    off = abs(there["may_stick_slip_below_damping"] - damping) + there["may_stick_slip_below_damping_error"]
    return speed, off / abs(slopes["belt_speed"])


def rows():
    """(source, quantity, published, ours, error of ours or what it is, why they differ)"""
    leine = ask("probe", "--epsilon=1", "--alpha=0", "--beta=0", "--gamma=3", "--V=0.2", "--c=0")
    both = [leine["flow"][engine]["landing"]["period"] for engine in ("return_map", "direct")]
    cycle = leine["attracting_cycle"]
    source = "Leine et al. 1998"
    yield source, "period, switch model", 12.00103129, both[0], abs(both[0] - both[1]), "last digit published"
    yield source, "largest x1", 1.13394467, cycle["x1"]["to"], abs(both[0] - both[1]), "last digit published"

    source = "Thomsen and Fidlin 2003"
    v_b1 = 0.5 * math.sqrt(1 - 4 * 0.05 * 0.5 / (3 * 0.15))
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        # Their oscillator as published, which the gallery has in units of the static friction.
        file.write(
            '[friction]\nlaw = "expression"\nphi = "0.4 - 0.225*(2*u - (2*u)^3/3)"\n[machine]\nmass = 1.0\n'
            "stiffness = 1.0\nnormal_force = 1.0\nbelt_speed = 0.42\ndamping = 0.1\n"
        )
        file.flush()
        hopf = machine(file.name, v_b1, 0.1)["steady_slip_unstable_below_damping"]
        yield source, "damping of the Hopf point at v_b1 = 0.4410", 0.1, hopf, 1e-15, "linear stability"
        grazing = largest_speed(file.name, 0.42, 0.1)
        yield source, "v_b0, below which cycles stick", math.sqrt(0.8) * v_b1, *grazing, "averaged to first order"
        amplitude = machine(file.name, 0.42, 0.1)["amplitude"]
        averaged = 2 * math.sqrt(v_b1**2 - 0.42**2)
        yield source, "amplitude at v_b = 0.42", averaged, amplitude, 1e-9, "averaged to first order"

    source = "bSTAB 2021"
    for speed, published, error, here, ours in bstab():
        off = abs(published - here) / error
        why = f"{off:.1f} standard errors ({error:.4f}) of its {STARTS} starts"
        yield source, f"share at rest, belt speed {speed:.4g}", published, here, ours, why

    source = "static and kinetic friction"
    speed = 0.5 * 2.73924041678
    told = ask("probe", "--law=coulomb", "--epsilon=1", "--drop=0.5", "--eta=0", f"--V={speed!r}", "--c=0.01")["critical_c"]
    yield source, "zeta at lambda = 2.73924041678, closed form", 0.01, told["value"] / 2, told["error"] / 2, ""
    small = 1 / (4 * math.pi * 2.73924041678**2)
    yield source, "the same by 1/(4 pi lambda^2)", small, told["value"] / 2, told["error"] / 2, "for small damping alone"

    told = machine("configs/gallery/bowed_string.toml", 0.2, 20.0)["steady_slip_unstable_below_damping"]
    slope = 500 * (40 * math.exp(-20) + 4.5 * math.exp(-2))
    yield "Woodhouse 2003", "fall of rosin's friction force at 0.2 m/s, N s/m, by hand", slope, told, 1e-12, ""

    source = "Verasztó and Stépán 2017"
    hopf = math.log(40 / 5.946) / 10
    told = machine("configs/gallery/veraszto2017.toml", hopf, 5.746)["steady_slip_unstable_below_damping"]
    yield source, "damping of the Hopf point at 0.1906 m/s, N s/m", 5.746, told, 1e-13, "linear stability"
    largest = largest_speed("configs/gallery/veraszto2017.toml", 0.25, 5.746)
    cubic = 0.4 * (1 - math.sqrt(1 - 5 * hopf))
    yield source, "largest belt speed with stick-slip, m/s", cubic, *largest, "friction expanded to third order"


def shown(value, error):
    """As many digits as the error leaves, ten at most."""
    digits = max(1, min(10, math.floor(math.log10(abs(value))) - math.floor(math.log10(error)))) if value else 1
    return f"{value:.{digits}g}"


lines = [
    "# Published numbers, and ours",
    "",
    "Made by `scripts/study gallery`; the cases, with their sources and pictures: [gallery](../../docs/gallery.md).",
    "Formulas that were published are evaluated.",
    "",
    "| source | quantity | published | here | error of ours | difference | why |",
    "| --- | --- | ---: | ---: | ---: | ---: | --- |",
]
for source, quantity, published, ours, error, why in rows():
    # Two engines may agree to the last bit.
    error = max(error, 2e-16 * abs(ours))
    off = published - ours
    difference = f"{100 * off / ours:+.2g} %" if abs(off) > error else "none"
    cells = [source, quantity, f"{published:.10g}", shown(ours, error), f"{error:.0e}", difference, why]
    lines.append("| " + " | ".join(cells) + " |")
(ROOT / "results/gallery/published.md").write_text("\n".join(lines) + "\n")
print("results/gallery/published.md")
