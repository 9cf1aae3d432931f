#!/usr/bin/env python3
"""Formulas that cancel, and altered certificates, through the built program.

    scripts/study hostile [NUMBER=1000] [SEED=1] [PART]

NUMBER random formulas whose terms cancel through `probe`, `explore` (one server for all) and, every fifth, `run`: none may end
the program, and only those that are 1 at rest in real numbers may be accepted (PART formulas). NUMBER certificates (certificates), each
with one claim made wrong or one part made huge, through `check`: each is refused, within ten seconds of processor time and 500 MB.
Exit code 0 if all holds.
"""

import http.client
import json
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import extremes

MEMORY = 500 << 20
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
        self.port, self.path = self.process.stdout.readline().strip().removeprefix("http://127.0.0.1:").split("/", 1)

    def ask(self, phi):
        """Status of the answer about a point of a formula; None where there is none."""
        request = {"law": {"name": "expression", "phi": phi},
                   "at": {"epsilon": 1.0, "V": 1.0, "c": 0.05}}
        connection = http.client.HTTPConnection("127.0.0.1", int(self.port), timeout=60)
        try:
            connection.request("POST", f"/{self.path}point", json.dumps(request))
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
            for part in (formulas, certificates):
                if part.__name__ in (sys.argv[4:] or part.__name__):
                    part(trial, random.Random(f"{part.__name__} {seed}"), count)
        except KeyboardInterrupt:
            print("\nended early: what follows is of a part")
    trial.end(f"{count} of each part")


if __name__ == "__main__":
    main()
