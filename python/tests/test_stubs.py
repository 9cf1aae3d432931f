"""The stubs say what is there, and examples in the documents run."""

import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).parents[1]


def test_stubs_and_types_hold():
    for command in (["mypy.stubtest", "slipmap._core"], ["mypy", "--no-error-summary", "slipmap", "tests/user.py"]):
        ended = subprocess.run(
            [sys.executable, "-m", *command], capture_output=True, text=True, check=False, cwd=HERE
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
