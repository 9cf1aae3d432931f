"""Random legal configurations over the whole range of doubles through run, check, report, plot and probe.

    scripts/study extremes [NUMBER=1000] [SEED=1]

Each command must end within ten seconds of processor time and 1 GiB, or give the reason for a refusal; none may panic.
"""

import os
import random
import resource
import sys
import tempfile
from pathlib import Path

from measure import ended

SECONDS = 10.0
MEMORY = 1 << 30
# A point may take up to two seconds, by its budgets of work.
CELLS = 8
LARGEST, SMALLEST = 1.7e308, 5e-324

LAWS = {
    "stribeck": ["alpha", "beta", "gamma"],
    "exponential": ["mu", "vs"],
    "lorentzian": ["mu", "vs", "eta"],
    "expression": ["a", "b"],
}
FORMULAS = ["1 - a*u*exp(-b*u)", "1 - a*sin(b*u)", "1 - a*tanh(b*u)", "1/(1 + abs(a)*u) + b*u^2"]
SHARES = {"alpha", "mu"}


def number(rng, positive):
    """Any legal number: ordinary ones half of the time, else any exponent that a double has."""
    kind = rng.random()
    if kind < 0.1 and not positive:
        return 0.0
    if kind < 0.5:
        return rng.choice([0.05, 0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 5.0]) * rng.uniform(0.9, 1.1)
    if kind < 0.75:
        return 10.0 ** rng.uniform(-9, 9)
    value = 10.0 ** rng.uniform(-323.5, 308.2)
    return min(max(value, SMALLEST), LARGEST)


def axis(rng, name, most):
    """One to four nodes, at most `most`, strictly increasing."""
    count = min(rng.choice([1, 1, 2, 3, 4]), most)
    if name in SHARES:
        values = {rng.choice([0.0, 1.0, rng.random()]) for _ in range(count)}
    else:
        values = {number(rng, name in ("epsilon", "V", "vs")) for _ in range(count)}
    return sorted(values)


def configuration(rng):
    law = rng.choice(list(LAWS))
    lines = ["[friction]", f'law = "{law}"']
    if law == "expression":
        lines.append(f'phi = "{rng.choice(FORMULAS)}"')
    lines.append("[grid]")
    names = ["epsilon", *LAWS[law], "V", "c"]
    left, nodes = CELLS, {}
    for name in rng.sample(names, len(names)):
        nodes[name] = axis(rng, name, left)
        left //= len(nodes[name])
    lines += [f"{name} = {nodes[name]}" for name in names]
    fields = rng.sample(["margin", "critical_c", "regime", "landing", "cycle", "basin", "epsilon_limit"], rng.randint(0, 4))
    names = ", ".join(f'"{field}"' for field in ["verdict", *fields])
    lines += ["[audit]", "cells = 20", "[output]", 'path = "map.h5"', f"fields = [{names}]"]
    return law, "\n".join(lines) + "\n"


def run(program, arguments, folder):
    """Exit code, messages, processor seconds and bytes of memory of one command."""

    def limits():
        # Twice the allowed time: a command that takes longer is stopped, and reported.
        resource.setrlimit(resource.RLIMIT_CPU, (int(2 * SECONDS), int(2 * SECONDS) + 1))

    ran = ended([program, *arguments], folder, before=limits)
    return ran.code, ran.said, ran.processor, ran.memory


class Trial:
    """Runs the program, and collects what should not be."""

    def __init__(self, program, folder, allowed):
        self.program, self.folder, self.allowed = program, folder, allowed
        self.problems, self.ends, self.most = 0, {}, {}

    def problem(self, what, said=""):
        self.problems += 1
        print(f"\n# {what}\n{said[-400:]}", flush=True)

    def run(self, kind, what, arguments, refused=None):
        """Exit code of a command; with `refused`, whether it must be refused."""
        code, said, seconds, memory = run(self.program, arguments, self.folder)
        self.ends[kind, code] = self.ends.get((kind, code), 0) + 1
        self.most[kind] = [max(a, b) for a, b in zip(self.most.get(kind, [0, 0]), (seconds, memory))]
        wrong = [f"ended with {code}"] * (code not in (0, 1, 2)) + ["panicked"] * ("panicked" in said)
        wrong += ["refused without a message"] * (code == 2 and "error:" not in said)
        if kind != "made":
            wrong += [f"{seconds:.1f} s"] * (seconds > SECONDS) + [f"{memory >> 20} MiB"] * (memory > self.allowed)
        wrong += ["believed"] * (refused is True and code == 0) + ["refused"] * (refused is False and code != 0)
        if wrong:
            self.problem(f"{kind}: {', '.join(wrong)}: {what}", said)
        return code

    def end(self, done):
        """Tells what was found, and ends; the exit code is 0 if nothing is a problem."""
        for (kind, code), number_of in sorted(self.ends.items(), key=str):
            print(f"{kind:20} exit code {code:4}: {number_of}")
        for kind, (seconds, memory) in self.most.items():
            print(f"{kind:20} at most {seconds:.2f} s, {memory >> 20} MiB")
        print(f"\n{done}, {self.problems} problems")
        sys.exit(bool(self.problems))


def main():
    program = os.path.abspath(sys.argv[1])
    count, seed = (int(given) for given in [*sys.argv[2:4], *["1000", "1"][len(sys.argv) - 2 :]])
    rng = random.Random(seed)
    trial = Trial(program, None, MEMORY)
    for i in range(count):
        law, text = configuration(rng)
        with tempfile.TemporaryDirectory() as folder:
            trial.folder = folder
            Path(folder, "map.toml").write_text(text)
            commands = {
                "run": ["run", "map.toml", "--quiet"],
                "check": ["check", "map.h5"],
                "report": ["report", "map.h5", "--out", "report", "--quiet"],
                "plot": ["plot", "map.h5", "--x", "V", "--y", "c", "--out", "plot.png"],
                "probe": ["probe", "--points", "points.csv", "--out", "answers.csv", "--quiet"],
            }
            # The first node of every axis as a point.
            nodes = dict(line.split(" = ") for line in text.split("[grid]")[1].split("[simulation]")[0].strip().splitlines())
            point = {name: values.strip("[]").split(", ")[0] for name, values in nodes.items()}
            Path(folder, "points.csv").write_text(",".join(point) + "\n" + ",".join(point.values()) + "\n")
            phi = next((line.split(" = ")[1].strip('"') for line in text.splitlines() if line.startswith("phi")), None)
            commands["probe"] += ["--phi", phi] if phi else ["--law", law]
            for name, arguments in commands.items():
                if name in ("check", "report", "plot") and not Path(folder, "map.h5").exists():
                    continue
                trial.run(name, f"configuration {i}\n{text}", arguments)
    trial.end(f"{count} configurations")


if __name__ == "__main__":
    main()
