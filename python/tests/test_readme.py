"""The examples of the README run, in their order, in a folder as that of a clone."""

import pathlib
import re
import shutil

import matplotlib.pyplot as plt
import pytest

ROOT = pathlib.Path(__file__).parents[2]


@pytest.mark.filterwarnings("ignore")
def test_every_example_of_the_readme_runs(program, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "configs", tmp_path / "configs")
    monkeypatch.chdir(tmp_path)
    program("run", "configs/quickstart.toml", "--quiet", "--set", "grid.V=1.0", "--set", "grid.c.points=11")
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "python" / "README.md").read_text(), re.DOTALL)
    assert len(blocks) > 5
    names = {}
    for block in blocks:
        exec(block, names)
    plt.close("all")
