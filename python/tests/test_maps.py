"""Maps: files of the program, and maps in memory that equal them."""

import csv
import math
import os
import shutil

import dask.array as da
import h5py
import numpy as np
import pytest
import slipmap

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
    # A program that opens a map for writing removes the seal; the fingerprints remain.
    for damage, words in [
        (lambda file: file["verdict_simulation"].__setitem__((0, 0, 0, 0, 0, 0), 0), "the cells of verdict_simulation"),
        (lambda file: file["V"].__setitem__(0, 0.6), "the cells of V"),
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


def test_other_layouts_are_refused(stored, tmp_path):
    path = tmp_path / "other.h5"
    for schema in [0, 99, None]:
        shutil.copy(stored, path)
        with open(path, "r+b") as cut:
            cut.truncate(path.stat().st_size - 119)
        with h5py.File(path, "r+") as file:
            if schema is None:
                del file.attrs["schema"]
            else:
                file.attrs["schema"] = schema
        with pytest.raises(slipmap.MapError, match="its layout has number"):
            slipmap.open_map(path)


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
        volumes, counts = data.slipmap.claimed_volume(), data.slipmap.contradictions()
        with open(tmp_path / "report" / "tables" / "volume.csv", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#"))]
        assert rows
        for row in rows:
            own = volumes.sel(method_name=row["method"], epsilon=float(row["epsilon"]))
            # Sums of some thousand terms in another order.
            assert np.isclose(100 * float(own) / own.attrs["box"], float(row["percent_of_box"]), rtol=1e-12)
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
        part = data.sel(epsilon=0.3, method="nearest")
        title = part.slipmap.plot("critical_c_simulation", x="gamma", y="V").get_title()
        assert "ε = 0.3" in title and "c = " not in title and max(map(len, title.splitlines())) <= 60
        with pytest.raises(TypeError, match="delta"):
            data.slipmap.plot(delta=1.0)


def test_blocks_of_a_map_are_several_tiles(stored):
    with slipmap.open_map(stored, chunks={}) as data:
        assert data.verdict_simulation.data.npartitions == data.critical_c_simulation.data.npartitions == 1


def same(own, stored):
    """Two maps are equal, variable by variable, coordinates and attributes included."""
    assert list(own.data_vars) == list(stored.data_vars) and set(own.coords) == set(stored.coords)
    for name in own.variables:
        a, b = own[name], stored[name]
        assert a.dims == b.dims and a.dtype == b.dtype, name
        assert a.values.tobytes() == b.values.tobytes() or np.array_equal(a.values, b.values, equal_nan=True), name
        assert set(a.attrs) == set(b.attrs), name
        for key, value in b.attrs.items():
            assert np.array_equal(a.attrs[key], value), (name, key)


def test_a_configuration_gives_the_map_of_the_program(config, stored):
    cells = []
    # The stored text of the configuration has the overrides applied: the same ones are required.
    sets = {"output.path": str(stored)}
    own = slipmap.run(config, set=sets, progress=lambda done, all: cells.append((done, all)))
    with slipmap.open_map(stored) as data:
        same(own, data)
        for name in ("title", "law", "methods", "fields", "tolerance", "config", "config_sha256"):
            assert own.attrs[name] == data.attrs[name], name
        assert set(data.attrs) == set(own.attrs)
        same(own.slipmap.curves, data.slipmap.curves)
    assert cells and cells[-1] == (own.verdict_simulation.size, own.verdict_simulation.size)
    assert not config.with_name("unused.h5").exists()


def test_a_grid_gives_the_map_of_the_program(config, stored):
    with slipmap.open_map(stored) as data:
        fields = ["margin", "critical_c", "regime", "landing", "cycle", "basin"]
        own = slipmap.map(data.coords, fields=fields, threads=3, audit_cells=10)
        same(own, data)
        law = slipmap.Law.stribeck(beta=0.1)
        grid = {name: data[name] for name in ("epsilon", "alpha", "gamma", "V", "c")}
        few = slipmap.map(grid, law=law, methods=["simulation", "symmetric"], audit_cells=0)
        assert few.slipmap.methods == ["symmetric", "simulation"]
        assert np.array_equal(few.verdict_simulation, data.verdict_simulation)
        # Elementwise calls give the same results.
        said = slipmap.verdicts(slipmap.Law.stribeck(), methods="simulation", **{name: data[name] for name in data.dims})
        assert np.array_equal(said.transpose(*data.verdict_simulation.dims), data.verdict_simulation)


def test_configurations_can_be_changed_and_are_checked(config):
    sets = {"grid.V": [1.0], "grid.c.points": 3, "output.fields": ["verdict"], "methods.run": ["simulation"], "curves.planes": []}
    own = slipmap.run(config, set=sets)
    assert own.sizes["V"] == 1 and own.sizes["c"] == 3
    # Texts are quoted as TOML has it.
    assert slipmap.run(config, set={**sets, "title": "it's \"so\" \\ so"}).attrs["title"] == "it's \"so\" \\ so"
    with pytest.raises(ValueError, match="gama"):
        slipmap.run(config, set=["grid.gama=1"])
    with pytest.raises(ValueError, match="there is no such file"):
        slipmap.run(config.with_name("none.toml"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"grid": {"V": [1.0, 0.5]}}, "V must increase strictly"),
        ({"grid": {"V": -1.0}}, "axis V has the value -1"),
        ({"grid": {"delta": 1.0}}, "delta is no axis"),
        ({"grid": {}, "fields": ["colour"]}, "there is no field `colour`"),
        ({"grid": {}, "methods": ["guess"]}, "there is no method `guess`"),
        ({"grid": {}, "methods": []}, "at least one method"),
        ({"grid": {}, "tolerance": 2.0}, "tolerance"),
    ],
)
def test_wrong_plans_are_told(arguments, words):
    grid = {"epsilon": 0.1, "V": 1.0, "c": [0.1, 0.2], **arguments.pop("grid")}
    with pytest.raises(ValueError, match=words):
        slipmap.map(grid, law=slipmap.Law.stribeck(0.4, 0.2, 2.0), **arguments)
    with pytest.raises(ValueError, match="the grid also needs c"):
        slipmap.map({"epsilon": 0.1, "V": 1.0}, law=slipmap.Law.stribeck(0.4, 0.2, 2.0))


def test_a_law_that_is_a_function_has_maps():
    law = slipmap.Law.from_function(lambda u: 0.5 + 0.5 / (1.0 + u), fastest=8.0)
    data = slipmap.map({"epsilon": 1.0, "V": [0.5, 1.0], "c": np.linspace(0.0, 1.0, 9)}, law=law, fields=["critical_c"])
    exact = slipmap.critical_c(law, V=data.V, epsilon=1.0)
    assert np.allclose(data.critical_c_simulation.squeeze(), exact, atol=1e-8)


def test_a_map_in_blocks_is_the_map():
    law = slipmap.Law.exponential(mu=0.5, vs=1.0)
    grid = {"epsilon": 1.0, "V": np.linspace(0.3, 2.0, 7), "c": np.linspace(0.0, 1.0, 11)}
    whole = slipmap.map(grid, law=law, fields=["critical_c", "regime"])
    for lazy in (
        slipmap.map(grid, law=law, fields=["critical_c", "regime"], chunks={"V": 3, "c": 11}),
        slipmap.map({**grid, "V": da.from_array(grid["V"], chunks=4)}, law=law, fields=["critical_c", "regime"]),
    ):
        assert isinstance(lazy.regime.data, da.Array) and lazy.regime.dtype == np.int8 and lazy.chunks["V"] in ((3, 3, 1), (4, 3))
        assert set(lazy.data_vars) == set(whole.data_vars) and lazy.attrs["law"] == "exponential"
        done = lazy.compute()
        for name in ("verdict_simulation", "verdict_symmetric", "regime"):
            assert np.array_equal(done[name], whole[name]) and done[name].attrs["flag_meanings"] == whole[name].attrs["flag_meanings"]
        both = whole.critical_c_error_simulation + done.critical_c_error_simulation
        assert (abs(done.critical_c_simulation - whole.critical_c_simulation) <= both).all()
        assert done.slipmap.contradictions().equals(whole.slipmap.contradictions())
    # 1e8 cells, of which one block is computed.
    large = {"epsilon": 1.0, "V": np.linspace(0.3, 2.0, 10_000), "c": np.linspace(0.0, 1.0, 10_000)}
    part = slipmap.map(large, law=law, methods=["symmetric"], chunks={"V": 100, "c": 10_000})
    assert part.verdict_symmetric.size == 10**8
    corner = part.verdict_symmetric.isel(V=slice(0, 100)).squeeze().compute()
    said = slipmap.verdicts(law, V=corner.V, c=corner.c, methods="symmetric")
    assert np.array_equal(corner.transpose("V", "c"), said.transpose("V", "c"))


def test_a_saved_map_is_opened_again(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    grid = {"epsilon": 0.1, "V": np.linspace(0.3, 2.0, 70), "c": np.linspace(0.0, 1.0, 301)}
    data = slipmap.map(grid, law=slipmap.Law.stribeck(0.4, 0.2, 2.0), methods=["symmetric", "simulation"])
    assert math.prod(data.attrs["tile_shape"]) < data.verdict_symmetric.size
    data.to_netcdf(tmp_path / "saved.h5", engine="h5netcdf")
    with slipmap.open_map("~/saved.h5", chunks={"V": 10}) as again:
        assert again.chunks["V"] == (10,) * 7
        same(again, data)


def test_a_map_shows_its_progress(capsys):
    slipmap.map({"epsilon": 0.1, "V": 1.0, "c": [0.1, 0.2]}, law=slipmap.Law.stribeck(0.4, 0.2, 2.0), progress=True)
    assert "2" in capsys.readouterr().err


def test_the_map_of_an_uncertain_machine_has_its_probability(tmp_path):
    config = tmp_path / "pad.toml"
    config.write_text(
        "[machine]\nmass = 2.0\nstiffness = 5.05e5\nnormal_force = 1000.0\nbelt_speed = [0.05, 0.1]\n"
        'damping = [100.0, 1240.0, 2000.0]\n[friction]\nlaw = "expression"\nphi = "low + fall*exp(-u/0.05)"\n'
        "fit = { low = 0.25, fall = 0.15, covariance = [[4e-6, -3e-6], [-3e-6, 4e-6]] }\n"
    )
    own = slipmap.run(config, set={"audit.cells": 0})
    assert own.stick_slip_probability.dims == ("belt_speed", "damping")
    # The critical damping is normal, to first order in the errors of the fit.
    here = slipmap.Machine.from_toml(config, belt_speed=0.05, damping=1240.0)
    sd = here.risk(draws=100).critical_damping_standard_error
    expected = 0.5 + 0.5 * math.erf((here.critical_damping() - 1240.0) / sd / math.sqrt(2.0))
    chances = own.stick_slip_probability.values
    # Of 10000 draws: four standard errors.
    assert abs(chances[0, 1] - expected) < 4.0 * 0.5 / math.sqrt(10_000)
    assert chances[0].tolist()[::2] == [1.0, 0.0]
    # What does not vary is a coordinate of a single number.
    assert float(own.normal_force) == 1000.0
    ax = own.slipmap.plot("stick_slip_probability", x="belt_speed")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("belt_speed", "damping")


def test_boundaries_of_a_machine_are_along_its_damping_ratio(tmp_path):
    config = tmp_path / "pad.toml"
    config.write_text(
        "[machine]\nmass = 2.0\nfrequency = 80.0\nnormal_force = 1000.0\nstatic_friction = 0.4\nkinetic_friction = 0.25\n"
        "stribeck_velocity = 0.05\nbelt_speed = [0.05, 0.1]\ndamping_ratio = { from = 0.0, to = 2.0, points = 21 }\n"
    )
    data = slipmap.run(config, set={"audit.cells": 0})
    exact = data.slipmap.boundary()
    assert exact.equals(data.critical_damping_ratio_simulation)
    coarse = data.drop_vars(exact.name).slipmap.boundary()
    assert coarse.dims == exact.dims and np.isfinite(coarse).all()
    assert (abs(exact - coarse) <= 0.05).all()
    ax = data.slipmap.plot("regime")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("belt_speed", "damping_ratio") and len(ax.lines) == 1


def test_a_map_that_does_not_fit_is_a_memory_error():
    axis = np.linspace(0.1, 1.0, 100_000)
    with pytest.raises(MemoryError, match="does not fit"):
        slipmap.map({"epsilon": 0.1, "alpha": 0.3, "beta": 0.1, "gamma": axis, "V": axis, "c": axis})
