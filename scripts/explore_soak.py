#!/usr/bin/env python3
"""Random use and hostile requests of `slipmap explore`, and the memory that the program holds.

    explore_soak.py SLIPMAP [--minutes 10] [--each 1000] [--out results/explore/soak.csv]

First EACH requests of every hostile kind from many connections at a time: huge grids, numbers that are none, deep formulas,
wrong types, foreign hosts and origins, bodies cut short, bodies that stop, silent connections. Every one must be refused or
answered, and the program answer a plain question after each kind. Then MINUTES of random use as the page would: planes of
random laws, axes, sizes and quantities, points, figures, curves, files. Memory is read after each kind and each minute.
"""

import argparse
import concurrent.futures
import csv
import http.client
import json
import random
import socket
import sys
import time
from pathlib import Path

from check_explore import Server

ANSWERS = {200, 204, 400, 403, 404, 405, 408, 413, 415, 422, 503}
SILENT = 200
LAWS = {
    "stribeck": {"epsilon": (0.01, 1), "alpha": (0, 0.9), "beta": (0, 0.5), "gamma": (0.1, 8), "V": (0.1, 3), "c": (0, 4)},
    "exponential": {"epsilon": (1, 1.01), "mu": (0.1, 0.9), "vs": (0.1, 2), "eta": (0, 0.1), "V": (0.1, 3), "c": (0, 1)},
    "expression": {"epsilon": (1, 1.01), "mu": (0.1, 0.9), "vs": (0.1, 2), "V": (0.1, 2), "c": (0, 1)},
    "table": {"epsilon": (1, 1.01), "V": (0.1, 1.9), "c": (0, 1)},
}
TABLE = "0,1\n0.25,0.8\n0.5,0.68\n1,0.56\n2,0.5\n4,0.5\n"
SHOWN = ["regime", "verdict_simulation", "verdict_symmetric", "decider", "difference:perturbation:simulation",
         "critical_c_simulation", "cycle_amplitude_x1", "kick_forward", "margin_simulation"]


class Client:
    def __init__(self, server):
        self.server, self.numbers = server, iter(range(1, 1 << 62))

    def send(self, method, path, body=None, headers=(), length=None):
        """Status of the answer; None where the program ended the connection, as it may."""
        connection = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=60)
        try:
            connection.putrequest(method, path, skip_host="Host" in dict(headers))
            for name, value in headers:
                connection.putheader(name, value)
            if body is not None:
                if "Content-Type" not in dict(headers):
                    connection.putheader("Content-Type", "application/json")
                connection.putheader("Content-Length", str(len(body) if length is None else length))
            connection.endheaders()
            if body is not None:
                connection.send(body)
            answer = connection.getresponse()
            answer.read()
            return answer.status
        except (ConnectionError, http.client.BadStatusLine, socket.timeout):
            return None
        finally:
            connection.close()

    def ask(self, path, request, tab):
        body = json.dumps({**request, "turn": {"tab": tab, "number": next(self.numbers)}}).encode()
        return self.send("POST", path, body)

    def memory(self):
        status = Path(f"/proc/{self.server.process.pid}/status").read_text()
        return 1024 * int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1])

    def alive(self):
        assert self.send("GET", "/api/catalogue") == 200, "the program does not answer"


def place(generator, name):
    law = {"name": name}
    if name == "expression":
        law["phi"] = "mu + (1 - mu)*exp(-u/vs)"
    if name == "table":
        law["table"] = TABLE
    return {"law": law, "at": {axis: generator.uniform(*ends) for axis, ends in LAWS[name].items()}}


def plane(generator, name, points):
    x, y = generator.sample([axis for axis in LAWS[name] if axis != "epsilon"], 2)
    sides = {}
    for side, axis in (("x", x), ("y", y)):
        from_, to = sorted(generator.uniform(*LAWS[name][axis]) for _ in range(2))
        sides[side] = {"axis": axis, "from": from_, "to": to + 1e-3, "log": from_ > 0 and generator.random() < 0.2,
                       "points": generator.randint(2, points)}
    return {**place(generator, name), **sides, "show": generator.choice(SHOWN), "curves": generator.random() < 0.3}


def hostile(generator, client):
    """Each kind with one request of it."""
    good = plane(generator, "stribeck", 16)
    wrong = [None, "x", [], {}, True, -1, 1e308, -1e308, 5e-324, 0, 2**64, "NaN"]

    def changed(*keys, value):
        request = json.loads(json.dumps(good))
        inner = request
        for key in keys[:-1]:
            inner = inner[key]
        inner[keys[-1]] = value
        return request

    def nonsense():
        keys = generator.choice([("at", "V"), ("at", "gamma"), ("x", "from"), ("x", "to"), ("y", "points"), ("show",), ("law",), ("law", "name"), ("x", "axis"), ("at",)])
        return client.ask("/api/plane", changed(*keys, value=generator.choice(wrong)), tab())

    def tab():
        return f"h{generator.randint(0, 40)}"

    def depth():
        return generator.randint(100, 3000)

    def formula(text):
        return client.ask("/api/law", {"name": "expression", "phi": text}, tab())

    def raw(body, **more):
        return client.send("POST", generator.choice(["/api/plane", "/api/point", "/api/law", "/api/texts"]), body, **more)

    text = json.dumps({**good, "turn": {"tab": "t", "number": 1}}).encode()
    return {
        "huge grids": lambda: client.ask("/api/plane", changed("x", "points", value=generator.randint(4097, 2**62)), tab()),
        "numbers that are none": lambda: raw(text.replace(b'"V": ', generator.choice([b'"V": NaN, "W": ', b'"V": Infinity, "W": ', b'"V": 1e999, "W": ']))),
        "wrong types": nonsense,
        "deep formulas": lambda: formula(generator.choice(["(" * depth(), "-" * depth() + "u", "exp(" * depth() + "u" + ")" * depth(), "1" + "+u" * depth(), "u^" * depth() + "2"])),
        "deep JSON": lambda: raw(generator.choice([b"[", b'{"a":']) * depth() * 10),
        "long bodies": lambda: raw(b" " * (1 << 21)),
        "bodies cut short": lambda: raw(text[: generator.randrange(len(text))]),
        "foreign hosts": lambda: client.send("GET", "/", headers=[("Host", generator.choice(["example.com", "127.0.0.1", "localhost:1", "[::1]"]))]),
        "foreign origins": lambda: client.send("POST", "/api/point", text, headers=[("Origin", generator.choice(["http://example.com", "null", "https://localhost"]))]),
        "forms": lambda: client.send("POST", "/api/point", text, headers=[("Content-Type", "text/plain")]),
        "other files": lambda: client.send("GET", generator.choice(["/assets/../../../../etc/passwd", "/assets/%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "//etc/passwd", "/api/none"])),
        "other methods": lambda: client.send(generator.choice(["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE"]), "/api/plane"),
    }


def slow_bodies(client, count):
    """Connections that stop in the middle of a body, and others that say nothing, while a question is answered."""
    open_ = []
    for number in range(min(count, SILENT)):
        connection = socket.create_connection(("127.0.0.1", client.server.port))
        if number % 2:
            connection.sendall(f"POST /api/plane HTTP/1.1\r\nHost: 127.0.0.1:{client.server.port}\r\nContent-Type: application/json\r\nContent-Length: 99\r\n\r\n{{".encode())
        open_.append(connection)
    client.alive()
    for connection in open_:
        connection.close()


def use(generator, client, seconds, strange):
    """Random use: the statuses that were met, with their numbers; answers that must not be go to `strange`."""
    end, met = time.monotonic() + seconds, {}

    def one(number):
        pick = random.Random(number)
        name = pick.choices(list(LAWS), [6, 3, 1, 1])[0]
        request = plane(pick, name, 160 if name == "stribeck" else 40)
        path = pick.choices(["/api/plane", "/api/glance", "/api/point", "/api/figure", "/api/curves", "/api/texts", "/api/law"],
                            [30, 20, 6, 8, 4, 2, 5])[0]
        if path == "/api/figure":
            request["figure"] = pick.choice(["orbit", "friction", "backbone"])
        if path == "/api/law":
            request = request["law"]
        status = client.ask(path, request, f"tab{pick.randint(0, 5)}")
        if status not in ANSWERS:
            strange.append(f"{path} {status} {json.dumps(request)}")
        return status

    while time.monotonic() < end:
        with concurrent.futures.ThreadPoolExecutor(6) as workers:
            for status in workers.map(one, [generator.randrange(1 << 60) for _ in range(60)]):
                met[status] = met.get(status, 0) + 1
    return met


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("slipmap")
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--each", type=int, default=1000)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    client = Client(Server(arguments.slipmap))
    try:
        rows, strange = soak(client, arguments)
        client.server.end()
    finally:
        client.server.kill()
    print(*strange, sep="\n")
    if arguments.out:
        with open(arguments.out, "w", newline="") as file:
            csv.writer(file).writerows([["what", "requests", "answers", "bytes of memory"], *rows])
    return 1 if strange else 0


def soak(client, arguments):
    """The rows of the table, and the answers that must not be."""
    generator = random.Random(20)
    client.alive()
    rows = [["start", 0, "", client.memory()]]
    for kind in hostile(generator, client):
        with concurrent.futures.ThreadPoolExecutor(16) as workers:
            answers = list(workers.map(lambda _: hostile(generator, client)[kind](), range(arguments.each)))
        strange = [status for status in answers if status is not None and status not in ANSWERS]
        assert not strange, f"{kind}: {strange[:5]}"
        client.alive()
        told = " ".join(f"{status}:{answers.count(status)}" for status in sorted(set(answers), key=str))
        rows.append([kind, len(answers), told, client.memory()])
        print(*rows[-1], flush=True)
    for _ in range(max(1, arguments.each // SILENT)):
        slow_bodies(client, SILENT)
    rows.append(["slow bodies and silent connections", max(1, arguments.each // SILENT) * SILENT, "", client.memory()])
    print(*rows[-1], flush=True)
    strange = []
    for minute in range(1, round(arguments.minutes) + 1):
        met = use(generator, client, 60, strange)
        told = " ".join(f"{status}:{count}" for status, count in sorted(met.items()))
        rows.append([f"minute {minute} of random use", sum(met.values()), told, client.memory()])
        print(*rows[-1], flush=True)
    client.alive()
    return rows, strange


if __name__ == "__main__":
    sys.exit(main())
