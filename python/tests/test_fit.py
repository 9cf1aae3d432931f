"""Measured friction: tables and fits, against the program."""

import json
import pickle

import numpy as np
import pandas as pd
import pytest
import slipmap
from slipmap._decode import decode
from slipmap._results import Fitted

NUMBERS = {"mass": 2.0, "stiffness": 5.05e5, "damping": 900.0, "normal_force": 1000.0, "belt_speed": 0.05}


@pytest.fixture(scope="module")
def record():
    u = np.repeat(np.linspace(0.0, 0.4, 21), 2)
    noise = 0.002 * np.random.default_rng(5).standard_normal(u.size)
    return pd.DataFrame({"speed [mm/s]": 1e3 * u, "mu": 0.25 + 0.15 * np.exp(-u / 0.05) + noise})


@pytest.fixture(scope="module")
def folder(record, tmp_path_factory):
    path = tmp_path_factory.mktemp("fit")
    record.to_csv(path / "pad.csv", index=False)
    numbers = "\n".join(f"{name} = {value}" for name, value in NUMBERS.items())
    (path / "table.toml").write_text(f'[machine]\n{numbers}\n[friction]\nlaw = "table"\nfile = "pad.csv"\n')
    fit = slipmap.Law.fit(path / "pad.csv")
    (path / "fit.toml").write_text(f"[machine]\n{numbers}\n{fit.toml}")
    return path


def test_a_fit_is_that_of_the_program(program, folder, record):
    told = json.loads(program("fit", folder / "pad.csv", "--json"))
    fit = slipmap.Law.fit(folder / "pad.csv")
    assert fit.answer == decode(Fitted, told) and fit.name == told["fit"]["law"]
    assert list(fit.table.index) == [it["law"] for it in told["fits"]] and fit.table.aicc.iloc[0] == 0.0
    assert np.array_equal(fit.covariance, told["fit"]["covariance"])
    assert np.array_equal(fit.residuals, told["residuals"])
    # Two readings of each speed in slip; those at rest are none.
    assert list(fit.residuals.index[::2]) == sorted(set(record["speed [mm/s]"][2:] * 1e-3))
    other = slipmap.Law.fit(record, law=fit.table.index[1])
    assert other.name == told["fits"][1]["law"] and tuple(told["fits"][1]["values"]) == other.answer.fit.values
    speeds = record["speed [mm/s]"] * 1e-3
    arrays = slipmap.Law.fit(speeds.to_numpy(), record.mu)
    assert np.allclose(arrays.parameters, fit.parameters, rtol=1e-9)
    # The name says mm/s, of numbers that are none any more.
    with pytest.warns(UserWarning, match="taken in SI units"):
        converted = slipmap.Law.fit(speeds, record.mu)
    assert np.allclose(converted.parameters, fit.parameters, rtol=1e-9)
    forces = slipmap.Law.fit(speeds.rename("v [m/s]"), record.mu.rename("F [N]"))
    assert forces.answer.quantity == "force" and forces.answer.fit.units[0] == "N"
    shown, as_good = fit._repr_html_(), sum(fit.table.aicc <= 4.0) - 1
    assert "<svg" in shown and "mu_s" in shown and "lorentzian" in shown and "m/s" in shown and "exp(-" in shown
    assert (f"{as_good} more law" in shown) == (as_good > 0)


def test_a_fit_takes_its_errors_into_machines(program, folder):
    law = slipmap.Law.fit(folder / "pad.csv").law
    machine, read = slipmap.Machine(**NUMBERS, friction=law), slipmap.Machine.from_toml(folder / "fit.toml")
    assert machine.quantities == read.quantities and set(machine.uncertain) == set(read.uncertain)
    for name, spread in read.uncertain.items():
        assert np.isclose(machine.uncertain[name]["sd"], spread["sd"], rtol=1e-9)
    assert pickle.loads(pickle.dumps(law)) == law and pickle.loads(pickle.dumps(machine)) == machine
    page = read.page(draws=1000)
    assert page.answers == json.loads(program("machine", folder / "fit.toml", "--draws", "1000", "--json"))
    assert "&lt;svg" in page._repr_html_()
    # Two ways to the factor of the covariance: the last bits differ.
    sd, own = read.risk(draws=1000).critical_damping_standard_error, machine.risk(draws=1000).critical_damping_standard_error
    assert np.isclose(own, sd, rtol=1e-6)
    # A number in place of one that was fitted has no error; the others keep theirs.
    known = slipmap.Machine(**NUMBERS, friction=law.replace(mu_k=0.25))
    assert "mu_k" not in known.uncertain and known.uncertain["mu_s"] == machine.uncertain["mu_s"]
    assert law.replace(mu_k=0.25).covariance.shape == (2, 2)


def test_a_measured_table_is_that_of_the_program(program, folder, record):
    expected = json.loads(program("probe", "--machine", folder / "table.toml", "--json"))
    law = slipmap.Law.from_csv(folder / "pad.csv")
    for own in (law, pickle.loads(pickle.dumps(law)), slipmap.Law.from_dataframe(record)):
        answer = slipmap.Machine(**NUMBERS, friction=own).probe()
        assert answer.critical_c.value == expected["critical_c"]["value"]
        # The errors of the data, and of the curve between them.
        assert answer.sensitivity.standard_error.value == expected["sensitivity"]["standard_error"]["value"]
    assert "slip speeds in mm/s; 40 readings in slip reduced" in law._repr_html_()


def test_measured_forces_need_no_normal_force(folder):
    forces = slipmap.Law.from_csv(folder / "pad.csv", quantity="force")
    with pytest.raises(ValueError, match="leave the normal force out"):
        slipmap.Machine(**NUMBERS, friction=forces)
    without = {name: value for name, value in NUMBERS.items() if name != "normal_force"}
    machine = slipmap.Machine(**without, friction=forces)
    assert "normal_force" not in machine.quantities
    path = folder / "forces.toml"
    numbers = "\n".join(f"{name} = {value}" for name, value in without.items())
    path.write_text(f"[machine]\n{numbers}\n{slipmap.Law.fit(folder / 'pad.csv', quantity='force').toml}")
    for own in (machine, slipmap.Machine.from_toml(path)):
        for asked in (own.critical_damping, own.replace):
            with pytest.raises(ValueError, match="leave the normal force out"):
                asked(normal_force=200.0)


def test_errors_are_those_of_the_friction(folder):
    law = slipmap.Law.fit(folder / "pad.csv").law
    fitted = slipmap.Machine(**NUMBERS, friction=law)
    for machine in (fitted, slipmap.Machine(**NUMBERS, friction=slipmap.Law.from_csv(folder / "pad.csv"))):
        critical, error = machine.critical_damping(belt_speed=[0.05, 0.06], return_error=True)
        expected = machine.page(draws=1).answers["may_stick_slip_below_damping_standard_error"]
        assert np.isclose(error[0], expected, rtol=1e-6) and error[0] > 1e-3 * critical[0] and error[1] != error[0]
        assert np.isclose(machine.probe().machine.critical_damping_standard_error, expected, rtol=1e-12)
    # What is given has no error.
    slope = fitted.critical_damping(mu_k=law.parameters["mu_k"], return_error=True)[1]
    assert 0.0 < slope != fitted.critical_damping(return_error=True)[1]


def test_laws_in_si_units_belong_to_machines(folder):
    law = slipmap.Law.fit(folder / "pad.csv").law
    for asked in (lambda: slipmap.critical_c(law, V=1.0), lambda: slipmap.map({"V": 1.0, "c": 0.1}, law=law)):
        with pytest.raises(ValueError, match="its slip speeds are in SI units"):
            asked()


def test_what_is_no_measured_friction_is_told(tmp_path):
    with pytest.raises(ValueError, match=r"few\.csv: there are too few slip speeds"):
        (tmp_path / "few.csv").write_text("u,mu\n0,0.4\n1,0.3\n2,0.2\n")
        slipmap.Law.fit(tmp_path / "few.csv")
    with pytest.raises(ValueError, match="no column is the"):
        slipmap.Law.from_dataframe(pd.DataFrame({"time": [0.0, 1.0], "temperature": [1.0, 2.0]}))
    with pytest.raises(ValueError, match="there is no such law: cubic"):
        slipmap.Law.fit(np.linspace(0.0, 1.0, 9), np.exp(-np.linspace(0.0, 1.0, 9)), law="cubic")
    with pytest.raises(TypeError, match="a file, a DataFrame"):
        slipmap.Law.fit([0.0, 1.0])


def test_a_measured_law_is_pickled_with_what_is_known_of_it(tmp_path):
    path = tmp_path / "rig.csv"
    # No row at rest: the first one is on the line through the next two, and moves with them.
    path.write_text("v [mm/s],mu,se\n20,0.38,0.01\n50,0.34,0.01\n100,0.3,0.01\n500,0.28,0.01\n1000,0.28,0.01\n")
    law = slipmap.Law.from_csv(path)
    again = pickle.loads(pickle.dumps(law))
    errors = [
        slipmap.Machine(mass=2.0, stiffness=8e5, damping=4.0, normal_force=1e3, belt_speed=0.1, friction=law).risk(
            draws=100
        ).critical_damping_standard_error
        for law in (law, again)
    ]
    assert errors[0] == errors[1]
