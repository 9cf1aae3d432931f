"""Progress of long work."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TypeAlias

# True shows a bar; a function is called with what is done and all.
Progress: TypeAlias = bool | Callable[[int, int], None]


def told(progress: Progress, all: int, unit: str) -> Callable[[int], None] | None:
    """What the engine is to call with the number of pieces done."""
    if progress is False:
        return None
    if callable(progress):
        return lambda done: progress(done, all)
    try:
        from tqdm.auto import tqdm
    except ImportError:

        def line(done: int) -> None:
            print(f"\r{done:,} of {all:,} {unit}", end="\n" if done >= all else "", file=sys.stderr, flush=True)

        return line
    bar = tqdm(total=all, unit=unit)

    def update(done: int) -> None:
        bar.update(done - bar.n)
        if done >= all:
            bar.close()

    return update
