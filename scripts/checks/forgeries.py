"""Whether scripts/checks/proof.py refuses forged certificates: those of the files named, altered in up to so many ways each.

    python scripts/checks/forgeries.py [--most N] proof.json ...
"""

import argparse
import copy
import json

from proof import Refused, prove

OTHER = {"returns": "absent", "absent": "returns", "lands": "absent"}


def leaves(node, here):
    """The places of all curves of a proof, with those of the cuts."""
    if "cut" in node:
        yield (*here, "cut"), None
        for part in ("below", "above"):
            yield from leaves(node["cut"][part], (*here, "cut", part))
    for i, curve in enumerate(node.get("curves", [])):
        yield (*here, "curves", i), curve


def forgeries(honest):
    """What is altered, and the certificate."""

    def altered(what, *path, to):
        forged = copy.deepcopy(honest)
        place = forged
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = to(place[path[-1]]) if callable(to) else to
        return what, forged

    yield altered("statement", "statement", to=lambda text: text.replace("does not", "does", 1))
    yield altered("format", "format", to="slipmap proof 2")
    yield altered("key", "more", to=1)
    yield altered("law", "law", to="none")
    yield altered("axes", "axes", to=lambda axes: axes[::-1])
    for p, part in enumerate(honest["parts"]):
        here, is_point = ("parts", p), part["c"][0] == part["c"][1]
        for name in ("present", "absent"):
            yield altered(f"share {name}", *here, name, to=lambda share: share + 1e-6 + (1 - share) * is_point)
        yield altered("dampings", *here, "c", to=[0.0, 1e6] if is_point else lambda c: [c[0], 2 * c[1]])
        for axis, _ in enumerate(part["domain"]):
            # A parameter that is 0 has no share of itself.
            yield altered(f"axis {axis}", *here, "domain", axis, to=lambda range_: [1.002 * x if x else 1.0 for x in range_])
        for place, curve in leaves(part["proof"], (*here, "proof")):
            if curve is None:
                yield altered("cut moved", *place, "at", to=lambda at: 1.001 * at)
                yield altered("cut outside", *place, "at", to=1e9)
                yield altered("parts exchanged", *place, to=lambda cut: {**cut, "below": cut["above"], "above": cut["below"]})
                yield altered("part without proof", *place, "below", to={})
                continue
            # Of a point the curves of the other side are not needed.
            if not is_point or (curve["kind"] == "absent") == (part["absent"] > 0):
                yield altered("curve missing", *place[:-1], to=lambda curves, i=place[-1]: curves[:i] + curves[i + 1 :])
            yield altered("kind", *place, "kind", to=OTHER[curve["kind"]])
            if curve["kind"] != "lands":
                across = 1 if curve["kind"] == "returns" else -1
                much = 0.002 if is_point else 0.2
                yield altered("damping across", *place, "c", to=lambda c, by=across * much: c + by * abs(c))
            yield altered("reversed", *place, "pieces", to=lambda all: [points[::-1] for points in all[::-1]])
            yield altered("pieces", *place, "pieces", to=[])
            yield altered("sizes", *place, "pieces", to=lambda all: all * 1000)
            for i, _ in enumerate(curve.get("along", [])):
                yield altered("slopes", *place, "along", i, "c", to=lambda c: c + 0.5)
                yield altered("slopes missing", *place, "along", to=lambda along, i=i: along[:i] + along[i + 1 :])
                yield altered("slopes of points", *place, "along", i, "pieces", 0, 1, to=lambda p: [p[0] + 0.1, p[1] + 0.1])
            for k, points in enumerate(curve["pieces"]):
                piece = (*place, "pieces", k)
                yield altered("piece missing", *place, "pieces", to=lambda all, k=k: all[:k] + all[k + 1 :])
                yield altered("piece reversed", *piece, to=lambda points: points[::-1])
                yield altered("piece moved", *piece, to=lambda points: [[u, y + 1e-4] for u, y in points])
                if curve["kind"] != "lands" and is_point:
                    # Far from c* a curve has room, and another one proves the same.
                    yield altered("point moved", *piece, len(points) // 2, to=lambda p: [1.02 * p[0], 0.98 * p[1]])
                yield altered("beyond the line", *piece, 1, 0, to=-1e-9)
                yield altered("no number", *piece, 1, 1, to=float("nan"))
            if curve["kind"] != "lands" and is_point:
                yield altered("start", *place, "pieces", 0, 0, to=lambda p: [p[0], p[1] + 1e-3])
            yield altered("end", *place, "pieces", -1, -1, to=lambda p: [p[0] + 1e-3, p[1]])


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--most", type=int, default=10**6)
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    accepted = 0
    for path in arguments.files:
        with open(path, encoding="utf-8") as file:
            honest = json.load(file)
        prove(honest)
        every = list(forgeries(honest))
        # Evenly, those of the head included.
        count = min(arguments.most, len(every))
        for what, forged in (every[i * len(every) // count] for i in range(count)):
            try:
                prove(forged)
            except Refused:
                continue
            accepted += 1
            print(f"{path}: accepted with another {what}")
        print(f"{path}: {count} forgeries")
    return 1 if accepted else 0


if __name__ == "__main__":
    raise SystemExit(main())
