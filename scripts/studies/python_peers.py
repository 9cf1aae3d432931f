"""One question put to three Python packages: stick-slip or not over 200 x 200 belt speeds and dampings?

    scripts/studies/python_peers.py OUT.md

The law is phi = 0.5 + 0.5 exp(-u), epsilon 1. Each function below is what a user writes; its lines are
counted, its answer is compared with that of the engine `direct`, which shares nothing with the engine that
slipmap answers with but the law. SciPy and pyBasin are asked every fifth node of both axes, and their times are
multiplied by 25. Needs: slipmap, scipy, pybasin (Python 3.12 or newer, which brings PyTorch).
"""

import datetime
import importlib.metadata
import inspect
import os
import sys
import time

import numpy as np

V = np.linspace(0.2, 2.0, 200)
C = np.linspace(0.01, 0.6, 200)
STRIDE = 5


def by_slipmap(V, c):
    import slipmap

    law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    return slipmap.verdicts(law, V=V[:, None], c=c, epsilon=1.0, methods="simulation") == 1


def by_scipy(V, c):
    from scipy.integrate import solve_ivp

    def below(t, y, V, c):
        return [y[1], -y[0] - c * y[1] + 0.5 + 0.5 * np.exp(y[1] - V)]

    def above(t, y, V, c):
        return [y[1], -y[0] - c * y[1] - 0.5 - 0.5 * np.exp(V - y[1])]

    def meets(t, y, V, c):
        return y[1] - V

    def turns(t, y, V, c):
        return below(t, y, V, c)[1]

    def falls(t, y, V, c):
        return y[1] - V

    meets.terminal, meets.direction = True, 1
    turns.terminal, turns.direction = True, -1
    falls.terminal, falls.direction = True, -1

    def sticks(V, c):
        exit_x1 = 1 - c * V
        options = {"args": (V, c), "rtol": 1e-9, "atol": 1e-11}
        # Next to the exit point the orbit leaves the line as a parabola, downwards.
        t = 1e-3
        first = [exit_x1 + V * t, V - 0.5 * V * t * t]
        slip = solve_ivp(below, (0, 50), first, events=[meets, turns], **options)
        if not len(slip.t_events[0]):
            return False
        x1 = slip.y_events[0][0][0]
        if x1 >= exit_x1 - 2:
            return True
        over = solve_ivp(above, (0, 50), [x1, V * (1 + 1e-12)], events=falls, **options)
        return bool(len(over.t_events[0]) and over.y_events[0][0][0] < exit_x1)

    return np.array([[sticks(speed, damping) for damping in c] for speed in V])


def by_pybasin(V, c):
    import torch
    from pybasin.solvers.torch_ode_system import ODESystem
    from pybasin.solvers.torchdiffeq_solver import TorchDiffEqSolver

    class Belt(ODESystem):
        # Position and velocity from the exit point, so that one start suits all parameters. Dry friction is
        # smoothed over a velocity of 1e-2.
        def ode(self, t, y, p):
            x, v = y.unbind(-1)
            V, c = p.unbind(-1)
            friction = torch.tanh(-v / 1e-2) * (0.5 + 0.5 * torch.exp(-v.abs()))
            return torch.stack([V + v, friction - (x + 1 - c * V) - c * (V + v)], dim=-1)

        def get_str(self):
            return "belt"

    grid = np.stack(np.meshgrid(V, c, indexing="ij"), axis=-1).reshape(-1, 2)
    solver = TorchDiffEqSolver(t_span=(0, 150), t_steps=200, t_eval=(135, 150), device="cpu", cache_dir=None)
    start = torch.tensor([[0.0, -1e-3]])
    _, states = solver.integrate(Belt({}), start, torch.tensor(grid, dtype=torch.float32))
    return (states[:, :, 1].amax(0) > -1e-2).reshape(len(V), len(c)).numpy()


def lines(function):
    source = inspect.getsource(function).splitlines()
    return sum(1 for line in source if line.strip() and not line.strip().startswith("#"))


def main(out):
    import slipmap

    grid = {"V": V, "c": C, "epsilon": 1.0}
    law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    truth = slipmap.map(grid, law=law, methods=["direct"], audit_cells=0)
    truth = truth.verdict_direct.squeeze().values == 1
    critical = slipmap.critical_c(law, V=V, epsilon=1.0)
    near = np.abs(C[None, :] - critical[:, None]) < 0.01
    rows = []
    for package, function, stride in (("slipmap", by_slipmap, 1), ("pybasin", by_pybasin, STRIDE), ("scipy", by_scipy, STRIDE)):
        try:
            version = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            print(f"{package} is not installed; left out", file=sys.stderr)
            continue
        wall, processor = time.perf_counter(), time.process_time()
        said = function(V[::stride], C[::stride])
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
        right = said == truth[::stride, ::stride]
        next_to = near[::stride, ::stride]
        rows.append(
            f"| {package} {version} | {lines(function)} | {wall * stride**2:.3g} | {processor * stride**2:.3g} | "
            f"{right.size:,} | {int((~right).sum())} | {int((~right & next_to).sum())} of {int(next_to.sum())} |"
        )
    text = [
        f"# Stick-slip or not over 200 x 200 belt speeds and dampings, {datetime.date.today()}",
        "",
        f"`scripts/python_peers.py`, {os.cpu_count()} cores, load of the machine {os.getloadavg()[0]:.1f}. Law "
        "0.5 + 0.5 exp(-u), epsilon 1, V from 0.2 to 2, c from 0.01 to 0.6. Truth is the engine `direct`.",
        "",
        "| package | lines of user code | seconds | processor seconds | cells asked | wrong | wrong within 0.01 of c* |",
        "| --- | --: | --: | --: | --: | --: | --: |",
        *rows,
        "",
        "SciPy and pyBasin were asked every fifth node of both axes; their seconds are those of 1,600 cells times 25. pyBasin "
        "integrates a smoothed friction for its cells in one batch in single precision, as its users do for friction; it knows "
        "neither the exit point nor an error.",
        "",
    ]
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(text))
    print("\n".join(text))


if __name__ == "__main__":
    main(*sys.argv[1:])
