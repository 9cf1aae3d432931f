"""What the tests share: the program, which they compare with to the last bit."""

import os
import pathlib
import subprocess

import matplotlib
import pytest

matplotlib.use("Agg")
ROOT = pathlib.Path(__file__).parents[2]


@pytest.fixture(scope="session")
def program():
    """Runs the program `slipmap`; skipped without one, unless SLIPMAP_PROGRAM names it."""
    named = os.environ.get("SLIPMAP_PROGRAM")
    places = [named] if named else [ROOT / "target" / kind / "slipmap" for kind in ("release", "debug")]
    found = next((str(place) for place in places if os.access(place, os.X_OK)), None)
    if found is None:
        assert named is None, f"{named} is no program"
        pytest.skip("there is no program; build it, or name it in SLIPMAP_PROGRAM")

    def run(*arguments):
        ended = subprocess.run([found, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    return run
