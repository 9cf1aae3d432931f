"""One point: against the program to the last bit."""

import json

import numpy as np
import pytest
import slipmap

PARAMETERS = {"alpha": 0.3, "beta": 0.1, "gamma": 2.0}


@pytest.mark.parametrize(
    ("law", "values", "flags"),
    [
        (slipmap.Law.stribeck(), {"epsilon": 0.1, **PARAMETERS, "V": 1.0, "c": 0.5}, []),
        (slipmap.Law.stribeck(), {"epsilon": 0.8, "alpha": 0.1, "beta": 0.0, "gamma": 3.0, "V": 2.5, "c": 0.9}, []),
        (
            slipmap.Law.lorentzian(),
            {"epsilon": 1.0, "mu": 0.5, "vs": 1.0, "eta": 0.0, "V": 0.6, "c": 0.2},
            ["--law", "lorentzian"],
        ),
    ],
)
def test_a_probe_is_that_of_the_program(program, law, values, flags):
    arguments = [word for name, value in values.items() for word in (f"--{name}", repr(value))]
    expected = json.loads(program("probe", *flags, *arguments, "--json"))
    answer = slipmap.probe(law, **values)
    assert answer.to_dict() == expected
    assert answer.critical_c.value == expected["critical_c"]["value"]
    slopes, errors = slipmap.sensitivity(law, return_error=True, **{k: v for k, v in values.items() if k != "c"})
    assert {f"dc_d{name}": by.value for name, by in answer.sensitivity.derivatives.items()} == slopes
    assert {f"dc_d{name}": by.error for name, by in answer.sensitivity.derivatives.items()} == errors
    assert answer.methods["simulation"].verdict == expected["methods"]["simulation"]["verdict"]
    # The elementwise functions give the same results.
    own = {name: value for name, value in values.items() if name != "c"}
    c, error = slipmap.critical_c(law, **own, return_error=True)
    assert (c, error) == (answer.critical_c.value, answer.critical_c.error)
    said = slipmap.verdicts(law, **values, methods=list(answer.methods))
    assert {name: slipmap.Verdict(code).name.lower() for name, code in said.items()} == {
        name: it.verdict for name, it in answer.methods.items()
    }
    assert slipmap.Regime(slipmap.regime(law, **values)).name.lower() == answer.regime


def test_a_machine_is_that_of_the_program(program, tmp_path):
    numbers = {
        "mass": 2.0,
        "stiffness": 5.05e5,
        "damping": 20.0,
        "normal_force": 1000.0,
        "static_friction": 0.4,
        "kinetic_friction": 0.25,
        "stribeck_velocity": 0.05,
        "belt_speed": 0.05,
    }
    config = tmp_path / "pad.toml"
    config.write_text("[machine]\n" + "\n".join(f"{name} = {value}" for name, value in numbers.items()))
    expected = json.loads(program("probe", "--machine", config, "--json"))
    answer = slipmap.Machine(**numbers).probe()
    assert answer.to_dict() == expected
    assert answer.machine.natural_frequency == expected["machine"]["natural_frequency"]


def test_a_machine_takes_quantities_of_pint():
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    plain = slipmap.Machine(
        mass=2.0,
        stiffness=800.0,
        damping=4.0,
        normal_force=50.0,
        static_friction=0.4,
        kinetic_friction=0.3,
        stribeck_velocity=0.25,
        belt_speed=0.1,
    )
    with_units = plain.replace(mass=2000.0 * unit.gram, stiffness=0.8 * unit.newton / unit.mm, belt_speed=10 * unit.cm / unit.s)
    for name in ("mass", "stiffness", "belt_speed"):
        assert np.isclose(getattr(with_units, name), getattr(plain, name), rtol=1e-15)
    with pytest.raises(ValueError, match="mass"):
        plain.replace(mass=2.0 * unit.meter)
    with pytest.raises(ValueError, match="belt_speed = 0"):
        plain.replace(belt_speed=0.0)
    with pytest.raises(ValueError, match="has no coefficients of friction"):
        plain.probe(slipmap.Law.expression("1 - 0*u"))


def test_an_answer_shows_itself():
    answer = slipmap.probe(slipmap.Law.stribeck(**PARAMETERS), V=1.0, c=0.5, epsilon=0.1)
    shown = answer._repr_html_()
    assert "<table>" in shown and "symmetric" in shown and "critical damping" in shown
    assert "regime" in repr(answer)
    assert answer.flow.direct.fate == answer.flow.return_map.fate
    assert all(isinstance(it, complex) for it in answer.equilibrium.eigenvalues)


def test_a_point_can_be_asked_with_changes():
    point = slipmap.Point(slipmap.Law.stribeck(**PARAMETERS), V=1.0, c=0.5, epsilon=0.1)
    assert slipmap.probe(point, c=0.6) == slipmap.probe(point.replace(c=0.6))
    with pytest.raises(TypeError, match="also needs c"):
        slipmap.probe(point.law, V=1.0, epsilon=0.1)


def test_orbits_meet_the_numbers_of_the_answer():
    point = slipmap.Point(slipmap.Law.stribeck(**PARAMETERS), V=1.0, c=0.5, epsilon=0.1)
    answer, orbit = slipmap.probe(point), slipmap.orbit(point)
    assert orbit.attrs["ending"] == "closes"
    # Both engines are run for an error of 1e-9, which the angle at the belt line magnifies in a landing.
    assert np.isclose(orbit.attrs["period"], answer.landing.period, rtol=1e-6)
    sticking = orbit.where(orbit.phase == 0, drop=True)
    assert (sticking.x2 == 1.0).all()
    assert np.isclose(float(sticking.x1[0]), answer.landing.x1, atol=1e-6)
    assert float(orbit.x1.max()) <= answer.attracting_cycle.x1.high + 1e-6
    portrait = slipmap.phase_portrait(point, max_time=30.0)
    assert {"exit", "inner", "outer"} <= set(portrait.orbit.values)
    assert float(portrait.exit_x1) == answer.exit_point.x1


def test_the_unstable_cycle_is_one():
    law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    band = slipmap.probe(law, V=1.0, c=0.0, epsilon=0.3).bistable_band
    point = slipmap.Point(law, V=1.0, c=0.5 * (band.from_c + band.to_c), epsilon=0.3)
    portrait = slipmap.phase_portrait(point)
    cycle = portrait.isel(sample=portrait.orbit.values == "unstable_cycle")
    assert np.allclose([cycle.x1[0], cycle.x2[0]], [cycle.x1[-1], cycle.x2[-1]], atol=1e-5)


def test_curves_of_a_plane():
    law = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)
    found = slipmap.curves(law, V=[0.5, 2.0], c=[0.0, 1.5], epsilon=0.1)
    kinds = found.curve.attrs["flag_meanings"].split()
    grazing = found.isel(point=found.curve.values == kinds.index("grazing_sliding"))
    critical = slipmap.critical_c(law, V=grazing.V.values, epsilon=0.1)
    # Errors are in sides of the plane, 1.5 long; the slope of c* in V is below 2.
    assert (np.abs(critical - grazing.c) <= 1e-8 + 4.5 * grazing.error).all()
    with pytest.raises(ValueError, match="two parameters make a plane"):
        slipmap.curves(law, V=[0.5, 2.0], c=0.1, epsilon=0.1)
