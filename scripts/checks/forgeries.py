"""Whether scripts/checks/proof.py refuses forged certificates: those of the files named, each altered in every way below.

    python scripts/checks/forgeries.py point.json ...
"""

import copy
import json
import sys

from proof import Refused, prove

OTHER = {"returns": "absent", "absent": "returns", "lands": "absent"}


def forgeries(honest):
    """What is altered, and the certificate."""

    def altered(what, change):
        forged = copy.deepcopy(honest)
        change(forged)
        return what, forged

    def put(*path, to):
        *way, last = path

        def change(forged):
            for key in way:
                forged = forged[key]
            forged[last] = to(forged[last]) if callable(to) else to

        return change

    yield altered("statement", put("statement", to=lambda text: text.replace("does not", "does", 1)))
    yield altered("format", put("format", to="slipmap proof of a point 1"))
    yield altered("a key more", put("more", to=1) if "more" in honest else lambda forged: forged.update(more=1))
    yield altered("verdict", put("verdict", to={"present": "absent", "absent": "present"}.get(honest["verdict"], "present")))
    yield altered("V", put("V", to=lambda V: 1.002 * V))
    yield altered("law", put("law", to="none"))
    if honest["critical_c"][0] is not None:
        yield altered("lower bound", put("critical_c", 0, to=lambda c: c * 1.002))
    if honest["critical_c"][1] is not None:
        yield altered("upper bound", put("critical_c", 1, to=lambda c: c - 0.002 * abs(c)))
    for i, _ in enumerate(honest["parameters"]):
        # A parameter that is 0 has no share of itself.
        yield altered(f"parameter {i}", put("parameters", i, to=lambda x: x * 1.002 if x else 1.0))
    for i, curve in enumerate(honest["curves"]):
        here = ("curves", i)
        if curve["kind"] != "lands" or honest["verdict"] == "present":
            yield altered("no such curve", lambda forged, i=i: forged["curves"].pop(i))
        yield altered("kind", put(*here, "kind", to=OTHER[curve["kind"]]))
        if curve["kind"] != "lands":
            across = 0.002 if curve["kind"] == "returns" else -0.002
            yield altered("damping across", put(*here, "viscous", to=lambda C, across=across: C + across * abs(C)))
        yield altered("reversed", put(*here, "pieces", to=lambda all: [points[::-1] for points in all[::-1]]))
        yield altered("no pieces", put(*here, "pieces", to=[]))
        yield altered("sizes", put(*here, "pieces", to=lambda all: all * 1000))
        for k, points in enumerate(curve["pieces"]):
            piece = (*here, "pieces", k)
            yield altered("a piece missing", lambda forged, i=i, k=k: forged["curves"][i]["pieces"].pop(k))
            yield altered("a piece reversed", put(*piece, to=lambda points: points[::-1]))
            yield altered("a piece moved", put(*piece, to=lambda points: [[u, y + 1e-4] for u, y in points]))
            if curve["kind"] != "lands":
                # Far from c* a curve has room, and another one proves the same.
                yield altered("a point moved", put(*piece, len(points) // 2, to=lambda p: [1.02 * p[0], 0.98 * p[1]]))
            yield altered("beyond the line", put(*piece, 1, 0, to=-1e-9))
            yield altered("no number", put(*piece, 1, 1, to=float("nan")))
    first, last = honest["curves"][0]["pieces"][0][0], honest["curves"][0]["pieces"][-1][-1]
    yield altered("start", put("curves", 0, "pieces", 0, 0, to=[first[0], first[1] + 1e-3]))
    yield altered("end", put("curves", 0, "pieces", -1, -1, to=[last[0] + 1e-3, last[1]]))


def main(paths):
    accepted = 0
    for path in paths:
        with open(path, encoding="utf-8") as file:
            honest = json.load(file)
        prove(honest)
        count = 0
        for what, forged in forgeries(honest):
            count += 1
            try:
                prove(forged)
            except Refused:
                continue
            accepted += 1
            print(f"{path}: accepted with another {what}")
        print(f"{path}: {count} forgeries")
    return 1 if accepted or not paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
