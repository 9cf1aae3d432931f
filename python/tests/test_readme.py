"""The examples of the READMEs and of the guide run, page by page, in a folder as that of a clone."""

import pathlib
import re
import shutil

import matplotlib.pyplot as plt
import pytest

ROOT = pathlib.Path(__file__).parents[2]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", ["python/README.md", "README.md", "docs/python.md"])
def test_every_example_runs(page, program, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    monkeypatch.chdir(tmp_path)
    program("run", "configs/quickstart.toml", "--quiet", "--set", "grid.V=1.0", "--set", "grid.c.points=11")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    # Elsewhere than on the package's own page a test of the guide runs those that need the program alone.
    blocks = [block for block in blocks if "import slipmap" in block or page == "python/README.md"]
    assert blocks
    names = {}
    for block in blocks:
        exec(block, names)
    plt.close("all")
