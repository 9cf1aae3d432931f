#!/usr/bin/env python3
"""Published numbers beside ours, for docs/gallery.md: results/gallery/published.md, of bSTAB every row,
results/gallery/bstab2021.csv, and the maps over what people turn, with known points on them.

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

import numpy as np
import xarray as xr

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = sys.argv[1]
XI = 0.05
# Shares by bSTAB with 5,000 random starts per belt speed, as stored in tests/integration/friction/
# main_friction_v_study.json of github.com/adrianwix/pyBasin.
PUBLISHED = [0, 0, 0, 0, 0, 0.0132, 0.08, 0.1478, 0.213, 0.2776, 0.3544, 0.4202, 0.4922, 0.5678, 1, 1, 1, 1, 1, 1]
STARTS = 5000
# The same at the belt speed 1.5, as stored in main_friction_case1.json there; main_friction.csv beside it, with every start,
# shows the box of starts: [-2, 2] x [0, 2], as bSTAB's.
CASE = (1.5, 0.304)


def runge_kutta(field, step, *state):
    """The state after a step of the classical Runge-Kutta method."""
    k1 = field(*state)
    k2 = field(*(x + step / 2 * k for x, k in zip(state, k1)))
    k3 = field(*(x + step / 2 * k for x, k in zip(state, k2)))
    k4 = field(*(x + step * k for x, k in zip(state, k3)))
    return tuple(x + step / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in zip(state, k1, k2, k3, k4))


def area(belt, top, steps=20000):
    """Area inside the slip cycle whose largest velocity is `top`, within x in [-2, 2] and x' in [0, 2]."""

    def field(x, v):
        return v, -x - 2 * XI * v + 0.5 + 0.5 * math.exp(-(belt - v) / 0.5)

    h = 2.1 * math.pi / steps
    x, v = -2 * XI * top + 0.5 + 0.5 * math.exp(-(belt - top) / 0.5), top
    total = 0.0
    for step in range(steps):
        new = runge_kutta(field, h, x, v)
        if step > steps // 2 and new[1] > 0 and field(*new)[1] <= 0:
            break
        inside = [min(max(value, -2), 2) for value in (x, new[0])], [min(max(value, 0), 2) for value in (v, new[1])]
        total += 0.5 * sum(inside[0]) * (inside[1][1] - inside[1][0])
        x, v = new
    return abs(total)


def share_by_its_rule(belt, starts=6000, step=0.02):
    """The share of random starts that bSTAB's rule calls at rest, |x'| <= 0.2 from t = 400 to 500, by the classical
    Runge-Kutta method: orbits that approach rest with the time 430 of its e-fold may not be there yet."""
    random = np.random.default_rng(2021)
    x, v = random.uniform(-2, 2, starts), random.uniform(0, 2, starts)
    stuck, largest = np.zeros(starts, bool), np.zeros(starts)
    for count in range(round(500 / step)):
        side = np.where(v > belt, 1.0, -1.0)

        def field(x, v):
            return v, -x - 2 * XI * v - side * (0.5 + 0.5 * np.exp(-np.abs(v - belt) / 0.5))

        new = runge_kutta(field, step, x, v)
        # On the belt line friction holds where the spring and the damper pull less than 1.
        meets = (new[1] - belt) * side <= 0
        stuck = (stuck | meets) & (np.abs(x + 2 * XI * belt) < 1)
        x, v = np.where(stuck, x + step * belt, new[0]), np.where(stuck, belt, new[1])
        if count * step >= 400:
            largest = np.maximum(largest, np.abs(v))
    return (largest <= 0.2).mean(), starts


def lugre():
    """The periods without and with memory of friction: 1 kg, 2 N/m, 0.1 m/s, friction from 1.5 to 1 N over 0.001 m/s as a
    Gauss curve and 0.4 N s/m; the bristles of LuGre have 1e5 N/m and sqrt(1e5) N s/m. By the classical Runge-Kutta method."""
    stiffness, speed, bristle, viscous = 2.0, 0.1, 1e5, 0.4

    def field(stretch, v, z):
        bent = v - abs(v) * bristle / (1 + 0.5 * math.exp(-((v / 1e-3) ** 2))) * z
        force = bristle * z + math.sqrt(bristle) * bent + viscous * v
        return speed - v, stiffness * stretch - force, bent

    step, state, rises = 2e-5, (0.0, 0.0, 0.0), []
    for count in range(round(16 / step)):
        new = runge_kutta(field, step, *state)
        if state[1] < 0.05 <= new[1]:
            rises.append(step * (count + (0.05 - state[1]) / (new[1] - state[1])))
        state = new
    unit = 1.5 / math.sqrt(stiffness)
    point = {"mu": 2 / 3, "vs": 1e-3 / unit, "eta": viscous * unit / 1.5, "exponent": 2, "V": speed / unit, "c": 0}
    told = ask("probe", "--law=exponential", "--epsilon=1", *(f"--{name}={value!r}" for name, value in point.items()))
    both = [told["flow"][engine]["landing"]["period"] / math.sqrt(stiffness) for engine in ("arcs", "direct")]
    return rises[-1] - rises[-2], both[0], max(abs(both[0] - both[1]), 1e-9)


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


def machine(configuration, belt_speed, damping=None, **others):
    """A machine of the gallery at one working point."""
    point = {"belt_speed": belt_speed, **({} if damping is None else {"damping": damping}), **others}
    sets = [part for name, value in point.items() for part in ("--set", f"{name}={value!r}")]
    return ask("machine", configuration, *sets)


def largest_speed(configuration, start, damping, **others):
    """The largest belt speed with stick-slip at this damping, and its error: that of the critical damping there,
    and its distance from this damping, over its derivative by belt speed."""
    speed = machine(configuration, start, damping, **others)["may_stick_slip_below_belt_speed"]
    there = machine(configuration, speed, damping, **others)
    slopes = {each["quantity"]: each["critical_damping"] for each in there["sensitivities"]}
    off = abs(there["may_stick_slip_below_damping"] - damping) + there["may_stick_slip_below_damping_error"]
    return speed, off / abs(slopes["belt_speed"])


RPM = math.pi / 30
NODES = 151
# The largest rotary speeds with stick-slip, in rpm, by weight on bit in N, computed twice by others.
DRILL = {20e3: 17.45903, 30e3: 24.83689, 50e3: 36.42244, 80e3: 50.33051}


def brake_hopf(pressure):
    """The rotary speed below which the gallery's brake slides unsteadily, and its damping, by hand."""
    damping = 2 * 0.05 * math.sqrt(3e3 * 4e-3)
    return 0.1 * math.log(pressure * 5e-4 * 0.1 * 0.25 / (0.1 * damping)), damping


def rosin_force(speed):
    """The bow force at which the gallery's damping is the fall of rosin's friction, by hand."""
    return 300 / (40 * math.exp(-speed / 0.01) + 4.5 * math.exp(-speed / 0.1))


def stage_speed(stiffness):
    """The stage's largest speed with stick-slip by lambda = 1/sqrt(4 pi zeta)."""
    return 0.08 * 196.2 / math.sqrt(20 * stiffness * 4 * math.pi * 0.02)


def slider_hopf(force):
    """The slider's Hopf speed: published at 6 N, here with that part of the friction that the force makes."""
    return math.log(40 * force / 6 / (5.746 + 0.2 * force / 6)) / 10


def pictures():
    """(configuration, axes across and up, words for the known points, and these points in the configuration's units)"""
    yield "drill_string_weight", "belt_speed", "normal_force", "computed by others", [(s, w / 1e3) for w, s in DRILL.items()]
    bars = range(1, 7)
    yield "brake_pressure", "belt_speed", "pressure", "Hopf line by hand", [(brake_hopf(1e5 * p)[0] / RPM, p) for p in bars]
    speeds = [0.04 * k for k in range(1, 7)]
    yield "bow_force", "belt_speed", "normal_force", "fall of rosin by hand", [(v, rosin_force(v)) for v in speeds]
    stiffnesses = [10 ** (4.5 + 0.5 * k) for k in range(7)]
    yield "stage_stiffness", "stiffness", "belt_speed", "lambda for small damping", [(k, 1e3 * stage_speed(k)) for k in stiffnesses]
    yield "hopf_normal_force", "normal_force", "belt_speed", "published at 6 N", [(6.0, slider_hopf(6.0))]
    ratios = [10 ** (-2.75 + 0.25 * k) for k in range(10)]
    asymptote = [(zeta, 1 / math.sqrt(4 * math.pi * zeta)) for zeta in ratios]
    yield "two_coefficients", "damping_ratio", "belt_speed", "asymptote for small damping", asymptote


def draw():
    """Draws the maps over what people turn, from more nodes than their configurations have, which tests run."""
    for name, x, y, words, points in pictures():
        with tempfile.TemporaryDirectory() as folder:
            marks = Path(folder) / f"{words.replace(' ', '_')}.csv"
            marks.write_text(f"{x},{y}\n" + "".join(f"{across!r},{up!r}\n" for across, up in points))
            output = f"{folder}/map.h5"
            run = [PROGRAM, "run", f"configs/gallery/{name}.toml", "--quiet", "--set", f"output.path={output}"]
            run += [part for axis in (x, y) for part in ("--set", f"machine.{axis}.points={NODES}")]
            plot = [PROGRAM, "plot", output, "--x", x, "--y", y, "--variable", "regime", "--mark", str(marks), "--overwrite"]
            for command in (run, [*plot, "--out", f"results/gallery/{name}.png"]):
                subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


def rows():
    """(source, quantity, published, ours, error of ours or what it is, why they differ)"""
    leine = ask("probe", "--epsilon=1", "--alpha=0", "--beta=0", "--gamma=3", "--V=0.2", "--c=0")
    both = [leine["flow"][engine]["landing"]["period"] for engine in ("arcs", "direct")]
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
        if off > 3:
            share, starts = share_by_its_rule(speed)
            why += f"; by its rule at t = 400 to 500 the share of {starts} starts is {share:.4f}: some are not at rest yet"
        yield source, f"share at rest, belt speed {speed:.4g}", published, here, ours, why

    speed, published = CASE
    point = {"mu": 0.5, "vs": 0.5, "eta": 0, "V": speed, "c": 2 * XI}
    told = ask("probe", "--law=exponential", "--epsilon=1", *(f"--{name}={value!r}" for name, value in point.items()))
    top = told["basin_boundary"]["cycle"]["x2"]["to"]
    here, ours = area(speed, top) / 8, abs(area(speed, top) - area(speed, top, 10000)) / 8
    error = math.sqrt(published * (1 - published) / STARTS)
    why = f"{abs(published - here) / error:.1f} standard errors ({error:.4f}) of its {STARTS} starts"
    yield "pyBasin's case", f"share at rest, belt speed {speed:.4g}", published, here, ours, why

    source = "static and kinetic friction"
    speed = 0.5 * 2.73924041678
    told = ask("probe", "--law=coulomb", "--epsilon=1", "--drop=0.5", "--eta=0", f"--V={speed!r}", "--c=0.01")["critical_c"]
    yield source, "zeta at lambda = 2.73924041678, closed form", 0.01, told["value"] / 2, told["error"] / 2, ""
    small = 1 / (4 * math.pi * 2.73924041678**2)
    yield source, "the same by 1/(4 pi lambda^2)", small, told["value"] / 2, told["error"] / 2, "for small damping alone"

    configuration = "configs/gallery/stage_stiffness.toml"
    start = 0.9 * stage_speed(1e6)
    known = machine(configuration, start, stiffness=1e6)["may_stick_slip_below_belt_speed"]
    exact = 1.88327991447274 * 0.08 * 196.2 / math.sqrt(20 * 1e6)
    yield "a stage", "largest speed with stick-slip at 1e6 N/m, m/s, closed form", exact, known, 1e-8 * exact, ""
    yield "a stage", "the same by lambda = 1/sqrt(4 pi zeta)", stage_speed(1e6), known, 1e-8 * exact, "for small damping alone"

    for weight, speed in DRILL.items():
        start = 0.95 * speed * RPM
        ours, error = largest_speed("configs/gallery/drill_string_weight.toml", start, 222.3067, normal_force=weight)
        what = f"largest speed with stick-slip at {weight / 1e3:.0f} kN, rpm"
        yield "two other computations", what, speed, ours / RPM, max(error / RPM, 5e-6), "last digit told"

    speed, damping = brake_hopf(3e5)
    told = machine("configs/gallery/brake_pressure.toml", speed, pressure=3e5)["steady_slip_unstable_below_damping"]
    yield "a brake", f"damping of the Hopf point at 3 bar, {speed / RPM:.3f} rpm, N m s/rad, by hand", damping, told, 1e-13, ""

    told = machine("configs/gallery/bowed_string.toml", 0.2, 20.0)["steady_slip_unstable_below_damping"]
    slope = 500 * (40 * math.exp(-20) + 4.5 * math.exp(-2))
    yield "Woodhouse 2003", "fall of rosin's friction force at 0.2 m/s, N s/m, by hand", slope, told, 1e-12, ""

    memory, *ours = lugre()
    yield "LuGre", "period with memory of friction, s", memory, *ours, "friction here is a function of the slip speed: no memory"

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


draw()
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
