"""The stubs say what is there, and examples in the documents run."""

import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).parents[1]


def test_stubs_and_types_hold(tmp_path):
    # The compiled part has types of NumPy alone, and to read all others takes as long again.
    config = tmp_path / "mypy.ini"
    config.write_text("[mypy]\nignore_missing_imports = True\n[mypy-slipmap.*,xarray.*,pandas.*,dask.*,h5py.*]\nfollow_imports = skip\n")
    stubs = ["mypy.stubtest", "--mypy-config-file", str(config), "slipmap._core"]
    for command in (stubs, ["mypy", "--no-error-summary", "slipmap", "tests/user.py"]):
        ended = subprocess.run(
            [sys.executable, "-m", *command], capture_output=True, text=True, check=False, cwd=HERE
        )
        assert ended.returncode == 0, ended.stdout + ended.stderr
