#!/usr/bin/env python3
"""Reads a map with xarray, h5py and ncdump, and recomputes its closed-form verdicts.

    scripts/checks/clients.py MAP.h5

Opens the map with xarray (engines netcdf4 and h5netcdf), h5py and ncdump; checks dimensions, types,
attributes and dimension scales as each of them sees them; recomputes every fingerprint of cells; and
compares the verdicts of the closed-form tests with their conditions, evaluated here from the
coordinates alone. Stored curves of codimension one are read with the same programs, and each point of a
Hopf or grazing curve of the Stribeck law is put to its condition. Nothing is shared with the program that wrote the map.
Exit code 0 if all holds.
"""

import argparse
import hashlib
import itertools
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import xarray as xr

AXES = {"stribeck": ("epsilon", "alpha", "beta", "gamma", "V", "c")}
VERDICTS = ((-1, 0, 1, 2, 3), "absent undecided present failed not_computed")
REGIMES = (
    tuple(range(17)),
    "equilibrium stick_slip bistable pure_slip crossing failed pure_slip_and_stick_slip pure_slip_and_equilibrium "
    "equilibrium_pure_slip_and_stick_slip equilibrium_and_crossing pure_slip_and_crossing "
    "equilibrium_pure_slip_and_crossing stick_slip_and_crossing equilibrium_stick_slip_and_crossing "
    "pure_slip_stick_slip_and_crossing equilibrium_pure_slip_stick_slip_and_crossing neutral",
)
# Units of a machine's map, for translation and rotation.
SI_UNITS = {"belt_speed": ("m/s", "rad/s"), "damping": ("N s/m", "N m s/rad"), "normal_force": ("N", "N m")}
GUARANTEES = {"asymptotic", "finite_epsilon", "numerical", "validated", "none"}
ROOT_TEXTS = (
    "Conventions title history source references crate_version git machine law methods fields "
    "config config_sha256"
).split()
ROOT_NUMBERS = "schema tolerance compression threads wall_seconds complete".split()

failures = 0


def expect(holds, what):
    """Counts and reports an expectation that does not hold."""
    global failures
    if not holds:
        failures += 1
        print(f"FAILED: {what}")


def text(value):
    """A text attribute as h5py returns it, decoded."""
    return value.decode() if isinstance(value, bytes) else value


def check_xarray(path, engine):
    """Checks the map read with xarray."""
    with xr.open_dataset(path, engine=engine) as data:
        law = data.attrs["law"]
        of_machine = "machine_motion" in data.attrs
        axes = AXES.get(None if of_machine else law, tuple(name for name in data.coords if name in data.dims))
        extra = check_si(data, engine) if of_machine else set()
        expect(data.attrs["Conventions"] == "CF-1.11", f"{engine}: Conventions")
        for name in ROOT_TEXTS:
            if name != "title":  # a map may have none
                expect(isinstance(data.attrs.get(name), str), f"{engine}: text attribute {name}")
        for name in ROOT_NUMBERS:
            expect(isinstance(data.attrs.get(name), np.number), f"{engine}: number attribute {name}")
        expect(data.attrs["complete"] == 1, f"{engine}: complete")
        digest = hashlib.sha256(data.attrs["config"].encode()).hexdigest()
        expect(data.attrs["config_sha256"] == digest, f"{engine}: config_sha256")
        expect(set(data.coords) == set(axes) | extra, f"{engine}: coordinates {list(data.coords)}")
        for name in axes:
            values = data[name]
            expect(values.dtype == np.float64 and values.dims == (name,), f"{engine}: axis {name}")
            expect(bool((np.diff(values) > 0).all()), f"{engine}: axis {name} increases")
        methods = data.attrs["methods"].split()
        expect([f"verdict_{m}" for m in methods] == [v for v in data if v.startswith("verdict_")], f"{engine}: methods")
        for name, variable in data.items():
            codes = name.startswith("verdict_") or name == "regime"
            dims = axes[:-1] if name.startswith(("critical_c_", "critical_damping_")) else axes
            expect(variable.dims == dims, f"{engine}: {name} has dimensions {variable.dims}")
            expect(variable.dtype == (np.int8 if codes else np.float64), f"{engine}: {name} is {variable.dtype}")
            expect(bool(extra) or variable.attrs.get("units") == "1", f"{engine}: {name} units")
            expect(bool(variable.attrs.get("long_name")), f"{engine}: {name} long_name")
            for place in (variable.attrs, variable.encoding):
                expect("_FillValue" not in place, f"{engine}: {name} has a _FillValue")
            if codes:
                values, meanings = REGIMES if name == "regime" else VERDICTS
                flags = variable.attrs["flag_values"]
                expect(flags.dtype == np.int8 and tuple(flags) == values, f"{engine}: {name} flag_values")
                expect(variable.attrs["flag_meanings"] == meanings, f"{engine}: {name} flag_meanings")
            if "_".join(name.split("_")[1:]) in methods:
                expect(variable.attrs.get("guarantee") in GUARANTEES, f"{engine}: {name} guarantee")
                expect(bool(variable.attrs.get("equation")), f"{engine}: {name} equation")
        print(f"xarray, {engine}: {len(data.data_vars)} variables over {dict(data.sizes)}")
        corner = {name: 0 for name in axes}
        return {name: variable.isel(corner, missing_dims="ignore").item() for name, variable in data.items()}


def check_si(data, engine):
    """Axes and numbers of a machine's map in SI units; the names of its single numbers, which are coordinates."""
    turns = data.attrs["machine_motion"] == "rotation"
    expect(tuple(data.sizes)[-2:] == ("belt_speed", "damping"), f"{engine}: the last axes are {tuple(data.sizes)[-2:]}")
    for name, units in SI_UNITS.items():
        expect(name in data.coords and data[name].attrs["units"] == units[turns], f"{engine}: unit of {name}")
    for name, variable in data.items():
        if name.startswith("critical_damping_"):
            expect(variable.attrs["units"] == SI_UNITS["damping"][turns], f"{engine}: unit of {name}")
    single = {name for name, values in data.coords.items() if values.ndim == 0}
    for name, variable in data.items():
        expect(single <= set(variable.coords), f"{engine}: {name} lacks {single - set(variable.coords)}")
    print(f"xarray, {engine}: axes in SI units, {data.belt_speed.units} and {data.damping.units}")
    return single


def check_h5py(path):
    """Checks the map read with h5py, and the fingerprints of its cells."""
    with h5py.File(path, "r") as file:
        axes = None if "machine_motion" in file.attrs else AXES.get(text(file.attrs["law"]))
        tile = tuple(int(n) for n in np.atleast_1d(file.attrs["tile_shape"]))
        corner = {}
        for name, data in file.items():
            if name == "curves":
                for column in data.values():
                    expect(digest([column[:]]) == text(column.attrs["sha256"]), f"h5py: sha256 of {column.name}")
                continue
            if data.is_scale:
                expect(h5py.h5ds.get_scale_name(data.id) == name.encode(), f"h5py: name of scale {name}")
                expect(digest([data[:]]) == text(data.attrs["sha256"]), f"h5py: sha256 of {name}")
                continue
            if data.ndim == 0:
                expect(digest([np.atleast_1d(data[()])]) == text(data.attrs["sha256"]), f"h5py: sha256 of {name}")
                continue
            scales = [[scale.name.strip("/") for scale in d.values()] for d in data.dims]
            expect(axes is None or scales == [[axis] for axis in axes[: data.ndim]], f"h5py: scales of {name}: {scales}")
            for axis, dimension in enumerate(data.dims):
                for scale in dimension.values():
                    expect(h5py.h5ds.is_attached(data.id, scale.id, axis), f"h5py: {name} and {scale.name}")
            expect(data.chunks == tile[: data.ndim], f"h5py: chunks of {name}")
            expect(data.fletcher32 is False and data.scaleoffset is None, f"h5py: filters of {name}")
            expect(digest(boxes(data, tile)) == text(data.attrs["sha256"]), f"h5py: sha256 of {name}")
            corner[name] = data[(0,) * data.ndim].item()
        print(f"h5py: {len(corner)} variables, chunks {tile}, fingerprints recomputed")
        return corner


def boxes(data, tile):
    """The variable tile by tile, slowest axis first."""
    ranges = [range(0, n, step) for n, step in zip(data.shape, tile)]
    for start in itertools.product(*ranges):
        yield data[tuple(slice(i, i + step) for i, step in zip(start, tile))]


def digest(tiles):
    """SHA-256 of the tiles' own SHA-256s, each over little-endian cells with one NaN."""
    whole = hashlib.sha256()
    for cells in tiles:
        if cells.dtype.kind == "f":
            cells = np.where(np.isnan(cells), np.nan, cells).astype("<f8")
        whole.update(hashlib.sha256(np.ascontiguousarray(cells).tobytes()).digest())
    return whole.hexdigest()


def check_ncdump(path):
    """Checks the map read with the NetCDF library's own tool."""
    if shutil.which("ncdump") is None:
        expect(False, "ncdump is not installed (Debian package netcdf-bin)")
        return
    run = subprocess.run(["ncdump", "-h", path], capture_output=True, text=True)
    expect(run.returncode == 0, f"ncdump: {run.stderr.strip()}")
    header = run.stdout
    expect(header.startswith("netcdf "), "ncdump: header")
    expect("byte verdict_" in header, "ncdump: verdicts are bytes")
    expect("phony_dim" not in header, "ncdump: every dimension has its name")
    expect("_FillValue" not in header, "ncdump: no _FillValue")
    expect("string " not in header, "ncdump: texts are of the kind every NetCDF tool reads")
    print(f"ncdump: {len(header.splitlines())} lines of header")


BIFURCATIONS = {"bautin", "hopf_at_grazing", "fold_at_grazing", "cusp", "hopf", "grazing_sliding", "landing", "crossing", "fold"}


def check_curves(path):
    """Checks the curves of codimension one read with xarray, and the conditions that hold on them."""
    with h5py.File(path, "r") as file:
        if "curves" not in file:
            print("curves: none are stored")
            return
    root = xr.open_dataset(path)
    axes = tuple(name for name in root.coords if name in root.dims)
    views = [xr.load_dataset(path, group="curves", engine=engine) for engine in ("netcdf4", "h5netcdf")]
    data = views[0]
    expect(views[0].identical(views[1]), "curves: xarray's engines disagree")
    for name in ("plane_x", "plane_y"):
        expect(set(words(data[name])) <= set(axes), f"curves: {name}")
    for plane in range(data.sizes["plane"]):
        shown = {words(data[name])[plane] for name in ("plane_x", "plane_y")}
        for axis in axes:
            held = data[f"held_{axis}"].values[plane]
            expect(np.isnan(held) if axis in shown else held in root[axis].values, f"curves: {axis} of plane {plane + 1}")
    if "point" not in data.sizes:
        print(f"curves: {data.sizes['plane']} planes without a curve")
        return
    kinds = np.array(words(data.curve))
    expect(set(kinds) <= BIFURCATIONS, f"curves: kinds {sorted(set(kinds))}")
    for name in ("plane_number", "branch"):
        expect(data[name].dtype == np.int32 and bool((data[name] >= 1).all()), f"curves: {name}")
    expect(bool((data.error >= 0).all()), "curves: errors")
    for axis in axes:
        expect(bool(((data[axis] >= root[axis].min()) & (data[axis] <= root[axis].max())).all()), f"curves: {axis}")
    print(f"curves: {data.sizes['point']} points in {data.sizes['plane']} planes, {', '.join(sorted(set(kinds)))}")
    if root.attrs["law"] != "stribeck" or "machine_motion" in root.attrs:
        print("curves: the conditions written here are those of the Stribeck law; not compared")
        return
    for kind, condition in (("hopf", trace), ("grazing_sliding", grazing_margin)):
        if not (kinds == kind).any():
            continue
        part = data.isel(point=np.flatnonzero(kinds == kind))
        point = {axis: part[axis].values for axis in axes}
        # Convert the size of the condition to a distance by its slopes along the sides of the plane, from
        # differences.
        steps = []
        for name in ("plane_x", "plane_y"):
            shown = np.array(words(data[name]))[part.plane_number.values - 1]
            moved = {axis: np.where(shown == axis, further(root[axis].values, point[axis], 1e-5), point[axis]) for axis in axes}
            steps.append((condition(**moved) - condition(**point)) / 1e-5)
        value, slope = condition(**point), np.hypot(*steps)
        distance = np.abs(value) / slope
        # The slopes here are good to about 1e-4, the integration to about 1e-9.
        bound = 1.001 * part.error.values + 1e-7
        expect(bool((distance <= bound).all()), f"curves: {kind} is off by {distance.max():.1e} sides")
        print(f"curves, {kind}: {part.sizes['point']} points, off by at most {distance.max():.1e} sides of the plane")


def further(nodes, value, share):
    """A value moved by a share of the axis with these nodes, logarithmically if the nodes are logarithmic."""
    if nodes[0] > 0 and len(nodes) > 2 and np.allclose(nodes[1:] / nodes[:-1], nodes[1] / nodes[0], rtol=1e-6):
        return value * (nodes[-1] / nodes[0]) ** share
    return value + share * (nodes[-1] - nodes[0])


def words(codes):
    """The meanings of codes."""
    meanings = codes.attrs["flag_meanings"].split()
    return [meanings[code] for code in codes.values]


def divergence(u, epsilon, alpha, beta, gamma, c):
    return epsilon * (gamma * (1 - alpha) / (1 + epsilon * gamma * u) ** 2 - 2 * beta * u - c)


def trace(epsilon, alpha, beta, gamma, V, c):
    """Trace of the linearisation at the equilibrium."""
    return divergence(V, epsilon, alpha, beta, gamma, c)


def grazing_margin(epsilon, alpha, beta, gamma, V, c):
    """r(2 pi) / V - 1 of the orbit from the exit point, by the classical Runge-Kutta method in the angle."""

    def slope(angle, r):
        d = divergence(V - V * r * np.cos(angle), epsilon, alpha, beta, gamma, c)
        return d * r * np.sin(angle) ** 2 / (1 + d * np.sin(angle) * np.cos(angle))

    steps = 2000
    h, r = 2 * np.pi / steps, np.ones_like(V)
    for angle in h * np.arange(steps):
        a = slope(angle, r)
        b = slope(angle + h / 2, r + h / 2 * a)
        d = slope(angle + h / 2, r + h / 2 * b)
        r = r + h / 6 * (a + 2 * b + 2 * d + slope(angle + h, r + h * d))
    return r - 1


def conditions(epsilon, alpha, beta, gamma, V, c):
    """For each test: quantities positive where it claims presence, and where it claims absence.

    Each is a difference together with the size of its terms, against which rounding is measured. None
    where the test claims nothing. The third entry: whether presence also needs that the mass lands on
    the stick segment, a condition on V that is not recomputed here.
    """
    weakening = gamma * (1 - alpha)
    k = epsilon * gamma * V
    q = np.sqrt(1 + 2 * k)
    loss = 2 * beta * V
    hump = 2 * weakening / (q * (1 + k + q))
    odd = weakening * (1 + 1 / (1 + 2 * k) ** 2) / 2

    def minus_c(*terms):
        return sum(terms) - c, sum(abs(term) for term in terms) + c

    def c_minus(*terms):
        return c - sum(terms), sum(abs(term) for term in terms) + c

    return {
        "perturbation": (minus_c(weakening, -loss), c_minus(weakening, -loss), False),
        "instability": (minus_c(weakening / (1 + k) ** 2, -loss), None, True),
        "bendixson_leading": (minus_c(weakening, -2 * loss), None, False),
        "symmetric": (minus_c(weakening / (1 + k) ** 2, -loss), c_minus(odd, -loss), True),
        "harmonic_balance": (minus_c(hump, -loss), c_minus(hump, -loss), False),
    }


def check_verdicts(path):
    """Stored verdicts against the conditions of the tests, one epsilon at a time."""
    with h5py.File(path, "r") as file:
        if text(file.attrs["law"]) != "stribeck" or "machine_motion" in file.attrs:
            print("verdicts: the conditions written here are those of the dimensionless Stribeck law; not compared")
            return
        axes = AXES["stribeck"]
        _, *rest = np.ix_(*(file[name][:] for name in axes))
        counts = {}
        for i, epsilon in enumerate(file["epsilon"][:]):
            alpha, beta, gamma, V, c = (axis[0] for axis in rest)
            for name, (present, absent, lands) in conditions(epsilon, alpha, beta, gamma, V, c).items():
                if f"verdict_{name}" not in file:
                    continue
                stored = file[f"verdict_{name}"][i]
                count = counts.setdefault(name, dict.fromkeys(("cells", "ties", "not landing", "wrong"), 0))
                claims = [claimed(condition, stored.shape) for condition in (present, absent)]
                (yes, tie_yes), (no, tie_no) = claims
                expected = np.where(yes, 1, np.where(no, -1, 0))
                # Within rounding of its edge a condition may have either sign.
                tie = tie_yes | tie_no
                # On a fast belt the mass may land beyond the stick segment; a test that is right at every
                # epsilon is then undecided. For slow belts the landing speed is too small for that.
                fast = lands & (expected == 1) & (stored == 0) & (V > 0.3)
                wrong = (stored != expected) & ~tie & ~fast
                count["cells"] += stored.size
                count["ties"] += int(tie.sum())
                count["not landing"] += int(fast.sum())
                count["wrong"] += int(wrong.sum())
                if wrong.any() and count["wrong"] == wrong.sum():
                    at = tuple(index[0] for index in np.nonzero(wrong))
                    point = dict(zip(axes, (epsilon, *(file[n][j] for n, j in zip(axes[1:], at)))))
                    print(f"  {name} stores {stored[at]} where its condition says {expected[at]}: {point}")
        for name, count in counts.items():
            expect(count["wrong"] == 0, f"verdicts of {name}: {count['wrong']} of {count['cells']} cells differ")
            print(f"verdicts, {name}: " + ", ".join(f"{n} {what}" for what, n in count.items()))


def claimed(condition, shape):
    """Where a condition holds, and where rounding decides."""
    if condition is None:
        return np.zeros(shape, bool), np.zeros(shape, bool)
    # A dozen roundings on either side, each of half a unit in the last place of the largest term.
    difference, size = (np.broadcast_to(part, shape) for part in condition)
    return difference > 0, np.abs(difference) <= 12 * np.finfo(float).eps * size


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map")
    options = parser.parse_args()
    path = options.map
    views = [check_xarray(path, engine) for engine in ("netcdf4", "h5netcdf")]
    views.append(check_h5py(path))
    same = all(np.array_equal([view[n] for n in views[0]], [view.get(n) for n in views[0]], equal_nan=True) for view in views)
    expect(same, "the readers disagree on the first cell")
    check_ncdump(path)
    check_verdicts(path)
    check_curves(path)
    print("all clients agree" if failures == 0 else f"{failures} expectations failed")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
