#!/usr/bin/env python3
"""Makes crates/numbers/itf1788.txt: what IEEE 1788's public test vectors say of the operations that
slipmap's intervals have.

    scripts/evidence/itf1788.py libieeep1788_elem.itl > crates/numbers/itf1788.txt

The file is of ITF1788 (https://github.com/oheim/ITF1788, folder itl, commit b6ee1e24), by
M. Nehmeier and O. Heimlich, Apache License 2.0. Only facts are taken: an operation, the ends of its
operands and those of the tightest enclosure, as the 16 hexadecimal digits of their doubles.
"""

import re
import struct
import sys
from pathlib import Path

UNARY = {"neg", "sqr", "exp", "log", "sqrt", "sin", "cos", "tanh", "atan", "abs"}
BINARY = {"add", "sub", "mul", "div", "intersection", "convexHull"}
INTERVAL = r"\[([^\],]+)(?:,([^\]]+))?\]"
ROW = re.compile(rf"^\s*(\w+)\s+{INTERVAL}(?:\s+{INTERVAL})?\s*=\s*{INTERVAL}\s*;")


def end(text):
    """The double of a number as ITL writes it."""
    text = text.strip().lower()
    if text in ("infinity", "-infinity"):
        return float(text)
    return float.fromhex(text) if "0x" in text else float(text)


def interval(low, high):
    """The ends of an interval; None of the empty one and of none."""
    if low.strip() == "entire":
        return float("-inf"), float("inf")
    if low.strip() in ("empty", "nai"):
        return None
    return end(low), end(high if high is not None else low)


def digits(x):
    """A double as hexadecimal digits; both zeros are zero."""
    return struct.pack(">d", x + 0.0).hex()


rows = set()
for line in Path(sys.argv[1]).read_text(encoding="utf-8").splitlines():
    found = ROW.match(line)
    if not found:
        continue
    name, *ends = found.groups()
    operands = [interval(*ends[:2])] + ([interval(*ends[2:4])] if ends[2] is not None else [])
    result = interval(*ends[4:])
    arity = 1 if name in UNARY else 2 if name in BINARY else 0
    if arity == len(operands) and None not in (*operands, result):
        rows.add((name, *(digits(x) for pair in (*operands, result) for x in pair)))
print("# Made by scripts/evidence/itf1788.py: operation, ends of the operands, ends of the tightest enclosure.")
for row in sorted(rows):
    print(*row)
