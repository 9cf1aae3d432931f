"""The notebooks run, and say what the program says."""

import ast
import csv
import json
import pathlib

import matplotlib.pyplot as plt
import pytest

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"
CONFIGS = pathlib.Path(__file__).parents[2] / "configs"
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture
def run(monkeypatch):
    """Executes the cells of a notebook as Jupyter does, in this process; returns the names that they leave."""
    monkeypatch.chdir(NOTEBOOKS)

    def run(name):
        names = {"__name__": "__main__"}
        for cell in json.loads((NOTEBOOKS / f"{name}.ipynb").read_text())["cells"]:
            if cell["cell_type"] != "code":
                continue
            assert cell["execution_count"], f"{name} is stored without its outputs: jupyter execute --inplace"
            tree = ast.parse("".join(cell["source"]))
            shown = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, name, "exec"), names)
            if shown is not None:
                value = eval(compile(ast.Expression(shown.value), name, "eval"), names)
                getattr(value, "_repr_html_", value.__repr__)()
        return names

    yield run
    plt.close("all")


@pytest.mark.parametrize("name", ["bifurcations", "brake_pad", "dask", "machine", "own_law"])
def test_a_notebook_runs(name, run):
    run(name)


def test_notebooks_are_small_and_each_is_tried():
    found = sorted(NOTEBOOKS.glob("*.ipynb"))
    assert [path.stem for path in found] == ["bifurcations", "brake_pad", "dask", "machine", "own_law", "paper_comparison"]
    assert all(path.stat().st_size < 150_000 for path in found)


def test_the_paper_comparison_has_the_numbers_of_the_report(program, tmp_path, run):
    names = run("paper_comparison")
    fewer, volume, percent, medians = (names[name] for name in ("fewer", "volume", "percent", "medians"))

    path = tmp_path / "paper.h5"
    sets = [word for key, value in fewer.items() for word in ("--set", f"{key}={value}")]
    program("run", CONFIGS / "paper.toml", "--quiet", "--set", f"output.path={path}", *sets)
    program("report", path, "--quiet", "--out", tmp_path / "report")

    def table(name):
        with open(tmp_path / "report" / "tables" / f"{name}.csv", newline="") as file:
            return {(row["epsilon"], row["method"]): row for row in csv.DictReader(file) if row["epsilon"]}

    agreement, volumes, boundary = table("agreement"), table("volume"), table("boundary")
    rows = names["agreement"].to_dict("records")
    assert len(rows) == len(agreement) == 21
    for row in rows:
        report = agreement[str(row["epsilon"]), row["method_name"]]
        for name in ("wrong_presence", "wrong_absence", "undecided"):
            assert row[name] == int(report[name]), (row, name)
    for row in volume.to_series().reset_index().to_dict("records"):
        report = volumes[str(row["epsilon"]), row["method_name"]]
        # The same sums of some ten thousand terms, in another order.
        assert 100 * row["volume"] / volume.attrs["box"] == pytest.approx(float(report["percent_of_box"]), rel=1e-11)
        share = percent[row["epsilon"]][row["method_name"]]
        assert share == pytest.approx(float(report["percent_of_simulation"]), rel=1e-11)
    for epsilon, of_methods in medians.to_dict().items():
        for method, median in of_methods.items():
            # The report counts errors in bins of relative width 2^-10 and gives the middle of a bin.
            assert median == pytest.approx(float(boundary[str(epsilon), method]["median_error"]), rel=2**-11 * 1.001)
