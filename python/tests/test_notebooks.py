"""The notebooks run, and say what the program says."""

import csv
import json
import pathlib

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"
CONFIGS = pathlib.Path(__file__).parents[2] / "configs"
# Widgets and kernels emit warnings of their own.
pytestmark = pytest.mark.filterwarnings("ignore")


def run(path, *more):
    """The notebook executed anew, with cells of code `more` behind its own."""
    notebook = nbformat.read(path, as_version=4)
    stored = [cell.get("execution_count") for cell in notebook.cells if cell.cell_type == "code"]
    assert all(stored), f"{path.name} is stored without its outputs: jupyter execute --inplace"
    notebook.cells.extend(nbformat.v4.new_code_cell(source) for source in more)
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(path.parent)}}).execute()
    return notebook


@pytest.mark.parametrize("name", ["bifurcations", "brake_pad", "dask", "machine", "own_law"])
def test_a_notebook_runs(name):
    run(NOTEBOOKS / f"{name}.ipynb")


def test_notebooks_are_small_and_each_is_tried():
    found = sorted(NOTEBOOKS.glob("*.ipynb"))
    assert [path.stem for path in found] == ["bifurcations", "brake_pad", "dask", "machine", "own_law", "paper_comparison"]
    assert all(path.stat().st_size < 150_000 for path in found)


def test_the_comparison_of_the_paper_has_the_numbers_of_the_report(program, tmp_path):
    told = """
import json
print(json.dumps({
    "fewer": fewer,
    "agreement": agreement.to_dict("records"),
    "volume": volume.to_series().reset_index().to_dict("records"),
    "percent": percent.T.to_dict(),
    "medians": medians.to_dict(),
}))
"""
    notebook = run(NOTEBOOKS / "paper_comparison.ipynb", told)
    own = json.loads(notebook.cells[-1].outputs[0].text)

    path = tmp_path / "paper.h5"
    sets = [word for key, value in own["fewer"].items() for word in ("--set", f"{key}={value}")]
    program("run", CONFIGS / "paper.toml", "--quiet", "--set", f"output.path={path}", *sets)
    program("report", path, "--quiet", "--out", tmp_path / "report")

    def table(name):
        with open(tmp_path / "report" / "tables" / f"{name}.csv", newline="") as file:
            return {(row["epsilon"], row["method"]): row for row in csv.DictReader(file) if row["epsilon"]}

    agreement, volume, boundary = table("agreement"), table("volume"), table("boundary")
    assert len(own["agreement"]) == len(agreement) == 21
    for row in own["agreement"]:
        report = agreement[str(row["epsilon"]), row["method_name"]]
        for name in ("wrong_presence", "wrong_absence", "undecided"):
            assert row[name] == int(report[name]), (row, name)
    for row in own["volume"]:
        report = volume[str(row["epsilon"]), row["method_name"]]
        # The same sums of some ten thousand terms, in another order.
        assert row["volume"] == pytest.approx(float(report["volume"]), rel=1e-11)
        percent = own["percent"][row["method_name"]][str(row["epsilon"])]
        assert percent == pytest.approx(float(report["percent_of_simulation"]), rel=1e-11)
    for epsilon, medians in own["medians"].items():
        for method, median in medians.items():
            # The report counts errors in bins of relative width 2^-10 and gives the middle of a bin.
            assert median == pytest.approx(float(boundary[epsilon, method]["median_error"]), rel=2**-11 * 1.001)
