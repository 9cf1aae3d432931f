"""Maps: files of the program, and maps in memory that equal them."""

import csv
import os
import shutil

import h5py
import numpy as np
import pytest
import slipmap
import xarray as xr

CONFIG = """\
title = "a small map"
[grid]
epsilon = [0.05, 0.3]
alpha = [0.0, 0.4]
beta = 0.1
gamma = { from = 0.5, to = 8.0, points = 5, spacing = "log" }
V = [0.5, 1.0, 2.0]
c = { from = 0.0, to = 4.0, points = 17 }
[curves]
planes = [{ x = "gamma", y = "c" }, { x = "V", y = "c", at = { epsilon = 0.3 } }]
[output]
path = "unused.h5"
fields = ["margin", "critical_c", "regime", "landing", "cycle", "basin"]
[audit]
cells = 10
"""


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "small.toml"
    path.write_text(CONFIG)
    return path


@pytest.fixture(scope="module")
def stored(program, config):
    path = config.with_suffix(".h5")
    program("run", config, "--set", f"output.path={path}", "--quiet")
    return path


def test_a_map_is_opened_and_every_fingerprint_recomputed(stored):
    with slipmap.open_map(stored) as data:
        assert data.attrs["title"] == "a small map"
        assert data.verdict_simulation.dims == ("epsilon", "alpha", "beta", "gamma", "V", "c")
        assert data.slipmap.methods[-1] == "simulation"
        assert set(data.slipmap.curves.curve.attrs["flag_meanings"].split()) >= {"grazing_sliding"}


def test_damage_is_found(stored, tmp_path):
    byte = tmp_path / "byte.h5"
    content = bytearray(stored.read_bytes())
    content[len(content) // 2] ^= 1
    byte.write_bytes(content)
    with pytest.raises(slipmap.MapError, match="sealed"):
        slipmap.open_map(byte)
    # A program that opens a map for writing cuts the seal off; the fingerprints remain.
    for damage, words in [
        (lambda file: file["verdict_simulation"].__setitem__((0, 0, 0, 0, 0, 0), 0), "the cells of verdict_simulation"),
        (lambda file: file["V"].__setitem__(0, 0.6), "the cells of V"),
        (lambda file: file.attrs.__setitem__("tolerance", 1.0), "the attributes of the file"),
        (lambda file: file["regime"].attrs.__setitem__("units", "m"), "the attributes of regime"),
        (lambda file: file["curves/error"].__setitem__(0, 1.0), "the cells of curves"),
    ]:
        path = tmp_path / "damaged.h5"
        shutil.copy(stored, path)
        with open(path, "r+b") as cut:
            cut.truncate(path.stat().st_size - 119)
        with h5py.File(path, "r+") as file:
            damage(file)
        with pytest.raises(slipmap.MapError, match=words):
            slipmap.open_map(path)
        slipmap.open_map(path, verify=False).close()
        os.remove(path)


def test_no_maps_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no such file"):
        slipmap.open_map(tmp_path / "nothing.h5")
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["x"] = [1.0]
    for verify in (True, False):
        with pytest.raises(slipmap.MapError):
            slipmap.open_map(other, verify=verify)


def test_the_accessor_says_what_the_report_says(program, stored, tmp_path):
    program("report", stored, "--out", tmp_path / "report")
    with slipmap.open_map(stored) as data:
        volumes, counts = data.slipmap.certified_volume(), data.slipmap.contradictions()
        with open(tmp_path / "report" / "tables" / "volume.csv", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#"))]
        assert rows
        for row in rows:
            own = volumes.sel(method_name=row["method"], epsilon=float(row["epsilon"]))
            # Sums of some thousand terms in another order.
            assert np.isclose(float(own), float(row["volume"]), rtol=1e-12)
        agreement = next(p for p in (tmp_path / "report" / "tables").glob("*.csv") if "wrong_presence" in p.read_text())
        with open(agreement, encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#")) if row["epsilon"]]
            for row in rows:
                own = counts.sel(method_name=row["method"], epsilon=float(row["epsilon"]))
                for name in ("wrong_presence", "wrong_absence", "undecided"):
                    assert int(own[name]) == int(row[name])


def test_boundaries_bracket_the_critical_damping(stored):
    with slipmap.open_map(stored) as data:
        exact = data.slipmap.boundary()
        assert exact.equals(data.critical_c_simulation)
        coarse = data.drop_vars("critical_c_simulation").slipmap.boundary()
        step = float(data.c[1] - data.c[0])
        both = np.isfinite(exact) & np.isfinite(coarse)
        assert both.any() and (abs(exact - coarse).where(both, 0.0) <= 0.5 * step).all()
        with pytest.raises(KeyError, match="the map has no method `none`"):
            data.slipmap.boundary("none")


def test_slices_are_drawn(stored):
    with slipmap.open_map(stored) as data:
        for variable in ("verdict_simulation", "regime", "margin_simulation"):
            ax = data.slipmap.plot(variable, x="gamma", epsilon=0.3)
            assert ax.get_xscale() == "log" and ax.get_ylabel() == "c"
            # The exact boundary and the curves of the plane.
            assert len(ax.lines) >= 1
        with pytest.raises(TypeError, match="delta"):
            data.slipmap.plot(delta=1.0)


def test_maps_are_datasets(stored):
    with slipmap.open_map(stored) as data:
        assert isinstance(data.mean(), xr.Dataset)
