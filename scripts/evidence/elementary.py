#!/usr/bin/env python3
"""Makes crates/numbers/elementary.txt: elementary functions at random places, rounded correctly.

    scripts/evidence/elementary.py > crates/numbers/elementary.txt

A row is the name of a function, its argument (of `pow` two) and its value, as the 16 hexadecimal digits of doubles. The values
come from mpmath with 60 digits; places are drawn with a fixed seed, over all sizes at which the function is no constant.
"""

import random
import struct

import mpmath

mpmath.mp.dps = 60
draw = random.Random(1788)


def size(low, high):
    """A number of any size between two powers of ten, of any sign."""
    return draw.choice([-1, 1]) * 10 ** draw.uniform(low, high)


PLACES = {
    "exp": lambda: size(-18, 2.85),
    "ln": lambda: abs(size(-300, 300)) if draw.random() < 0.5 else 1 + size(-15, -0.31),
    "sqrt": lambda: abs(size(-300, 300)),
    "sin": lambda: size(-18, 6),
    "cos": lambda: size(-18, 6),
    "tanh": lambda: size(-18, 1.3),
    "atan": lambda: size(-18, 18),
    "pow": lambda: (abs(size(-20, 20)), size(-2, 1.1)),
}
FUNCTIONS = {name: getattr(mpmath, name) for name in ("exp", "ln", "sqrt", "sin", "cos", "tanh", "atan")}
FUNCTIONS["pow"] = mpmath.power


def digits(x):
    return struct.pack(">d", x).hex()


print("# Made by scripts/evidence/elementary.py: function, arguments, value.")
for name, place in PLACES.items():
    for _ in range(100):
        at = place()
        at = at if isinstance(at, tuple) else (at,)
        value = float(FUNCTIONS[name](*map(mpmath.mpf, at)))
        if value not in (0.0, float("inf")):
            print(name, *map(digits, at), digits(value))
