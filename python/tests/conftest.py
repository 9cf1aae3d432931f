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
    """Runs the program `slipmap`: that of scripts/test_python, or the one that the tests of the crates have built."""
    found = os.environ.get("SLIPMAP_PROGRAM", ROOT / "target" / "debug" / "slipmap")

    def run(*arguments):
        ended = subprocess.run([found, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    return run
