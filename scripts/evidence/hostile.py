#!/usr/bin/env python3
"""Formulas that cancel, and altered files behind a right seal, through the built program.

    scripts/study hostile [NUMBER=1000] [SEED=1] [PART]

NUMBER random formulas whose terms cancel through `probe`, `explore` (one server for all) and, every fifth, `run`: none may end
the program, and only those that are 1 at rest in real numbers may be accepted (PART formulas). NUMBER maps (maps), altered by h5py and sealed again, and
NUMBER certificates (certificates), each with one claim made wrong or one part made huge, through `check`, the maps through `plot` too: each is
refused, within ten seconds of processor time and 500 MB. Exit code 0 if all holds.
"""

import hashlib
import http.client
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import h5py
import numpy as np

import extremes

MEMORY = 500 << 20
LABEL = b"\nslipmap seal, sha256 of every byte before this line: "
MAP = """
[grid]
epsilon = [0.05, 0.2]
alpha = [0.1, 0.5]
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 4, spacing = "log" }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 8 }
[methods]
run = ["symmetric", "simulation"]
[curves]
planes = [{ x = "gamma", y = "c" }]
[output]
path = "good.h5"
fields = ["verdict", "margin", "critical_c", "regime"]
"""
FORMULA_MAP = """
[friction]
law = "expression"
phi = "{}"
[grid]
epsilon = 1
V = 1
c = [0.05, 0.5]
[output]
path = "map.h5"
"""


def formula(rng):
    """A formula whose terms cancel, and by how much it differs from 1 at rest in real numbers."""
    text, beyond = "0.5+0.5*exp(-u)", 0.0
    for _ in range(rng.randint(1, 4)):
        a, k = f"{rng.choice([1, 3, 7.5])}e{rng.randint(-3, 22)}", rng.choice([0.0, 0.25, 0.9])
        term, value = rng.choice([
            (f"-{k}*(({a}+1)-{a})", -k),
            (f"+(u+{a})^2-u^2-2*{a}*u-{a}^2", 0.0),
            (f"+(u+{a})^3-u^3-{a}^3", 0.0),
            (f"+sin({a}+u)-sin({a}+u)", 0.0),
            (f"+{k}*u*(({a}+u)-{a})/(1+u^2)", 0.0),
            (f"+tanh({a}*u)*(cos({a}+u)-cos({a}+u))", 0.0),
            (f"+0.1*(sqrt(u^2+{a})-sqrt({a}))", 0.0),
            (f"+ln(1+{a}*u)-ln(1+{a}*u)", 0.0),
            (f"+{a}*u-{a}*u", 0.0),
            (f"+exp({a}-{a}-u)-exp(-u)", 0.0),
        ])
        text, beyond = text + term, beyond + value
    return text, beyond


class Server:
    """A running `slipmap explore`."""

    def __init__(self, program):
        command = [program, "explore", "--no-browser", "--port", "0"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.port = int(self.process.stdout.readline().strip().rstrip("/").rsplit(":", 1)[1])

    def ask(self, phi):
        """Status of the answer about a point of a formula; None where there is none."""
        request = {"law": {"name": "expression", "phi": phi},
                   "at": {"epsilon": 1.0, "V": 1.0, "c": 0.05}}
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        try:
            connection.request("POST", "/api/point", json.dumps(request), {"Content-Type": "application/json"})
            return connection.getresponse().status
        except (OSError, http.client.HTTPException):
            return None
        finally:
            connection.close()


def formulas(trial, rng, count):
    server = Server(trial.program)
    for i in range(count):
        text, beyond = formula(rng)
        point = ["--law", "expression", "--phi", text, "--epsilon", "1", "--V", "1", "--c", "0.05"]
        wrong = True if beyond else None
        code = trial.run("probe", text, ["probe", *point, "--proof", "c.json", "--overwrite"], wrong)
        if code == 0:
            trial.run("check of its proof", text, ["check", "--proof", "c.json"], False)
        if i % 5 == 0:
            Path(trial.folder, "formula.toml").write_text(FORMULA_MAP.format(text))
            trial.run("run", text, ["run", "formula.toml", "--quiet", "--overwrite"], wrong)
        status = server.ask(text)
        trial.ends["explore", status] = trial.ends.get(("explore", status), 0) + 1
        if status not in (200, 422, 503) or (status == 200 and wrong):
            trial.problem(f"explore answers {status}: {text}")
    if server.process.poll() is not None:
        trial.problem(f"explore ended with {server.process.returncode}")
    server.process.kill()


def seal(path):
    data = Path(path).read_bytes()
    cut = data.rfind(LABEL)
    data = data[:cut] if cut >= 0 else data
    Path(path).write_bytes(data + LABEL + hashlib.sha256(data).hexdigest().encode() + b"\n")


def bare(file, name, kind, shape, chunk=None, filters=()):
    """Replaces a dataset by one without data."""
    if name in file:
        del file[name]
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    if chunk:
        properties.set_chunk(chunk)
    for add in filters:
        {"deflate": lambda: properties.set_deflate(9), "shuffle": properties.set_shuffle,
         "fletcher32": properties.set_fletcher32, "scaleoffset": lambda: properties.set_scaleoffset(2, 0)}[add]()
    space = h5py.h5s.create_simple(shape, tuple(h5py.h5s.UNLIMITED for _ in shape) if chunk else shape)
    return h5py.Dataset(h5py.h5d.create(file.id, name.encode(), h5py.h5t.py_create(np.dtype(kind)), space, properties))


def stored(rng, file):
    """The names of the datasets."""
    names = []
    file.visititems(lambda name, thing: names.append(name) if isinstance(thing, h5py.Dataset) else None)
    return rng.choice(sorted(names))


def set_text(place, name, text):
    place.attrs[name] = text  # of variable length: such a text may be longer than 64 KiB


def alter(rng, file):
    """Makes one random alteration; says which."""
    shape = (2, 2, 2, 4, 2, 8)

    def rows():
        name = rng.choice([name for name in sorted(file["curves"]) if name not in ("plane", "point")])
        kind = file["curves"][name].dtype
        attributes = dict(file["curves"][name].attrs)
        column = bare(file, f"curves/{name}", kind, (rng.choice([1, 60_000, 10**6, 10**9]),))
        if "flag_meanings" in attributes:
            set_text(column, "flag_meanings", rng.choice(["V ", "c "]) + "w" * rng.choice([10, 30_000, 60_000]))
        return f"rows of {name} that are not stored"

    def links():
        more = [f"m{i}" for i in range(rng.choice([1, 5, 60, 500, 3000]))]
        for name in more:
            file[f"verdict_{name}"] = file["verdict_symmetric"]
        set_text(file, "methods", " ".join(["symmetric", "simulation", *more]))
        set_text(file, "fields", "verdict")
        return f"{len(more)} links to one verdict"

    def filters():
        name = rng.choice(["verdict_symmetric", "verdict_simulation", "regime"])
        some = [rng.choice(["deflate", "shuffle", "fletcher32", "scaleoffset"]) for _ in range(rng.randint(2, 3))]
        bare(file, name, "i1", shape, (1, 1, 1, 1, 1, 8), some)
        return f"{name} by {some}"

    def bomb():
        chunk = (2, 2, 2, 4, 2, rng.choice([8, 512, 1 << 14]))
        twice = rng.random() < 0.5
        cells = bare(file, "verdict_symmetric", "i1", shape, chunk, ["deflate"] * (1 + twice))
        stream = zlib.compress(bytes(rng.choice([1 << 20, 200 << 20])), 9)
        cells.id.write_direct_chunk((0,) * 6, zlib.compress(stream * 20, 9) if twice else stream)
        return f"a stream of {len(stream)} bytes"

    def types():
        kind, depth = h5py.h5t.IEEE_F64LE, rng.choice([2, 300, 300, 1500, 6000])
        for _ in range(depth):
            kind = h5py.h5t.vlen_create(kind) if rng.random() < 0.5 else h5py.h5t.array_create(kind, (1,))
        place = rng.choice(["verdict_symmetric", "regime", "attribute", "V"])
        space = h5py.h5s.create(h5py.h5s.SCALAR)
        if place == "attribute":
            h5py.h5a.create(file.id, b"nested", kind, space)
        else:
            del file[place]
            h5py.h5d.create(file.id, place.encode(), kind, space)
        return f"{depth} types in {place}"

    def declared():
        name = rng.choice(["alpha", "c", "verdict_symmetric", "margin_simulation", "regime"])
        rank = file[name].ndim
        sizes = tuple(rng.choice([1, 2, 1000, 10**6, 10**9]) for _ in range(rank))
        bare(file, name, file[name].dtype, sizes, tuple(min(size, 1 << rng.randint(0, 24)) for size in sizes))
        return f"{name} of shape {sizes}"

    def attribute():
        place = rng.choice([file, file[stored(rng, file)]])
        name = rng.choice(sorted(set(place.attrs) - {"DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"}))
        value = rng.choice([
            "", "x", "w" * 10**6, "small eps\n" * 10**5, " ".join("abcdefgh"), 0, -1, 5, 1e308, [1] * 6, [10**9] * 6,
            np.zeros(5000), ["t" * 30_000] * 2, np.array([float("nan")]),
        ])
        place.attrs[name] = value
        return f"attribute {name} of {place.name} is {str(value)[:40]}"

    def law():
        set_text(file, "law", rng.choice(["expression", "table", "function", "stribeck"]))
        set_text(file, "law_definition", rng.choice([
            "small eps\n" * 10**5, "1\n" + "(" * 10**5, "1\n" + "u^" * 10**5 + "u", "1 t\n" + "0,1\n" * 10**5,
            "0 f\n\n0," + ",".join(map(str, range(1, 10**4))), "1\nexp(-u)" + "+a" * 10**4, "\n",
        ]))
        return "another law"

    def cells():
        name = rng.choice(["verdict_symmetric", "margin_simulation", "critical_c_simulation", "regime", "alpha"])
        values = file[name][...]
        at = tuple(rng.randrange(size) for size in values.shape)
        values[at] = values[at] + 1 if np.isfinite(values[at]) else 0
        file[name][...] = values
        return f"a cell of {name}"

    def gone():
        name = stored(rng, file)
        del file[name]
        return f"without {name}"

    def more():
        for i in range(rng.choice([1, 2000])):
            file.create_dataset(f"more{i}", data=np.zeros(1))
        return "other variables"

    return rng.choice([rows, links, filters, bomb, types, declared, attribute, law, cells, gone, more])()


def maps(trial, rng, count):
    folder = Path(trial.folder)
    Path(folder, "map.toml").write_text(MAP)
    assert trial.run("made", "", ["run", "map.toml", "--quiet"], False) == 0
    assert trial.run("made", "", ["check", "good.h5"], False) == 0
    for number in range(count):
        what = None
        while what is None:
            shutil.copy(folder / "good.h5", folder / "map.h5")
            try:
                with h5py.File(folder / "map.h5", "r+") as file:
                    what = alter(rng, file)
            except (KeyError, OSError, RuntimeError, TypeError, ValueError):
                pass  # HDF5 does not write such a file
        seal(folder / "map.h5")
        trial.run("check of a map", f"map {number}: {what}", ["check", "map.h5"], True)
        # Behind a right seal some contents are not looked at again: it costs no more, that is all.
        trial.run("plot", f"map {number}: {what}", ["plot", "map.h5", "--x", "gamma", "--y", "c", "--out", "plot.svg", "--overwrite"])


def certificates(trial, rng, count):
    folder = Path(trial.folder)
    point = ["--epsilon", "1", "--V", "1", "--c", "0.05", "--overwrite", "--proof", "good.json"]
    trial.run("made", "", ["probe", "--law", "expression", "--phi", "0.5+0.5*exp(-u)", *point], False)
    of_point = json.loads((folder / "good.json").read_text())
    grids = {
        "surface": "epsilon = 0.05\nalpha = [0.1, 0.5]\nbeta = [0.0, 0.1]\ngamma = [0.5, 1.0]\nV = [0.5, 1.0]\nc = [0.0, 1.0]\n",
        "law": "epsilon = 1\nmu = [0.6, 0.65]\nvs = [1.0, 1.05]\nV = [1.0, 1.1]\nc = [0.0, 0.5]\n",
    }
    all_of = [of_point]
    for name, grid in grids.items():
        friction = '[friction]\nlaw = "expression"\nphi = "mu+(1-mu)*exp(-u/vs)"\n' if name == "law" else ""
        (folder / "proof.toml").write_text(
            f'{friction}[grid]\n{grid}[methods]\nrun = ["validated"]\n[validated]\nboxes = 2\nproof = "{name}.json"\n'
            f'[output]\npath = "{name}.h5"\nfields = ["verdict"]\n')
        trial.run("made", "", ["run", "proof.toml", "--quiet", "--overwrite"], False)
        all_of.append(json.loads((folder / f"{name}.json").read_text()))
    huge = [[], [0] * 300_000, [[]] * 1_000_000, [[0, 0]] * 300_000, {}, "x" * 5_000_000, 1e308, -1, None, "small eps\n" * 30_000]

    def false_claim(of):
        """One claim that is no longer true."""
        if "critical_c" in of:
            lo, hi = of["critical_c"]
            phi = formula(rng)
            while not phi[1]:
                phi = formula(rng)
            changes = {
                "critical_c": [lo + rng.uniform(1e-4, 1), hi + 1.1], "verdict": rng.choice(["absent", "Present", ""]),
                "law_definition": "1\n" + phi[0], "statement": of["statement"].replace("does not", "does"),
                "V": of["V"] * rng.choice([-1, 0, 1.5]), "epsilon": of["epsilon"] * 1.5,
            }
            key = rng.choice(list(changes))
            of[key] = changes[key]
            return key
        tile = rng.choice(of["tiles"])
        kind = rng.randrange(5)
        if kind == 0:
            tile["radius"] *= 10.0 ** -rng.uniform(4, 12)
        elif kind == 1 and isinstance(tile["viscous"], list):
            tile["viscous"][0] += int(10 * tile["radius"] / of["unit"])
        elif kind == 1:
            tile["viscous"] += 10 * tile["radius"]
        elif kind == 2:
            of["tiles"].remove(tile)
        elif kind == 3:
            of["tiles"].append(tile)
        else:
            of["statement"] = of["statement"].replace("comes back", "never comes back")
        return f"kind {kind}"

    def huge_part(of):
        inner = of
        keys = [key for key in of if key not in ("written_by", "run")]
        if of.get("tiles") and rng.random() < 0.5:
            inner = of["tiles"][0]
            keys = list(inner)
        name = rng.choice(keys)
        # A wide radius claims less than the truth.
        new = rng.choice([value for value in huge if value != inner[name] and (name, value) != ("radius", 1e308)])
        inner[name] = new
        return f"{name} is {str(new)[:30]}"

    for number in range(count):
        of = json.loads(json.dumps(rng.choice(all_of)))
        what = rng.choice([false_claim, huge_part])(of)
        text = json.dumps(of, separators=(",", ":"))
        if rng.random() < 0.02:
            text = text.replace("[", "[" * 100_000, 1)
        (folder / "proof.json").write_text(text)
        trial.run("check of a proof", f"certificate {number}: {what}", ["check", "--proof", "proof.json"], True)


def main():
    program = os.path.abspath(sys.argv[1])
    count, seed = (int(given) for given in [*sys.argv[2:4], *["1000", "1"][len(sys.argv) - 2 :]])
    with tempfile.TemporaryDirectory() as folder:
        trial = extremes.Trial(program, folder, MEMORY)
        try:
            for part in (formulas, maps, certificates):
                if part.__name__ in (sys.argv[4:] or part.__name__):
                    part(trial, random.Random(f"{part.__name__} {seed}"), count)
        except KeyboardInterrupt:
            print("\nended early: what follows is of a part")
    trial.end(f"{count} of each part")


if __name__ == "__main__":
    main()
