"""One point: against the program to the last bit."""

import json
import pathlib
import pickle

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


CONFIGS = pathlib.Path(__file__).parents[2] / "configs"
PAD = {"mass": 2.0, "stiffness": 5.05e5, "damping": 20.0, "normal_force": 1000.0, "belt_speed": 0.05}
SPEEDS, FRICTION = [0.0, 0.02, 0.05, 0.1, 0.2, 0.4], [0.40, 0.32, 0.28, 0.26, 0.25, 0.25]


@pytest.mark.parametrize(
    ("friction", "numbers", "words"),
    [
        (None, {"static_friction": 0.4, "kinetic_friction": 0.25, "stribeck_velocity": 0.05}, ""),
        (
            slipmap.Law.lorentzian(),
            {"static_friction": 0.4, "kinetic_friction": 0.25, "stribeck_velocity": 0.05, "strengthening": 0.01},
            'law = "lorentzian"',
        ),
        (
            slipmap.Law.expression("low + (0.4 - low)*exp(-u/0.05)"),
            {"low": 0.25},
            'law = "expression"\nphi = "low + (0.4 - low)*exp(-u/0.05)"',
        ),
        (slipmap.Law.table(SPEEDS, FRICTION, origin="pad.csv"), {}, 'law = "table"\nfile = "pad.csv"'),
    ],
)
def test_a_machine_is_that_of_the_program(program, tmp_path, friction, numbers, words):
    config = tmp_path / "pad.toml"
    rows = "\n".join(f"{u},{mu}" for u, mu in zip(SPEEDS, FRICTION, strict=True))
    (tmp_path / "pad.csv").write_text(f"u,phi\n{rows}\n")
    lines = "\n".join(f"{name} = {value}" for name, value in {**PAD, **numbers}.items())
    config.write_text(f"[machine]\n{lines}\n[friction]\n{words}\n")
    told = program("probe", "--machine", config, "--json")
    expected = json.loads(told)
    machine = slipmap.Machine(**PAD, friction=friction, **numbers)
    answer, read = machine.probe(), slipmap.Machine.from_toml(config)
    assert read.probe().to_dict() == expected
    # Reasons name the file of measurements.
    assert answer.to_dict() == json.loads(told.replace(str(tmp_path / "pad.csv"), "pad.csv"))
    assert answer.machine.natural_frequency == expected["machine"]["natural_frequency"]
    c, error = machine.critical_damping(return_error=True)
    assert abs(c - answer.machine.critical_damping) <= error
    assert pickle.loads(pickle.dumps(read)) == read and read.quantities == machine.quantities
    assert "<svg" in machine._repr_html_() and "normal force" in machine._repr_html_()


def test_the_risk_of_a_machine_is_that_of_the_program(program, tmp_path):
    machine = slipmap.Machine(
        **{**PAD, "damping": {"value": 900.0, "sd": 50.0}, "mass": {"min": 1.9, "max": 2.1}},
        static_friction=0.4,
        kinetic_friction=0.25,
        stribeck_velocity=0.05,
    )
    config = tmp_path / "pad.toml"
    values = {**machine.quantities, "damping": "{ value = 900.0, sd = 50.0 }", "mass": "{ min = 1.9, max = 2.1 }"}
    config.write_text("[machine]\n" + "\n".join(f"{name} = {value}" for name, value in values.items()))
    expected = json.loads(program("machine", config, "--draws", "2000", "--json"))["risk"]
    risk = slipmap.Machine.from_toml(config).risk(draws=2000)
    assert risk.probability.value == expected["probability"]["value"]
    assert [it.damping.value for it in risk.rare_by[:2]] == [it["damping"]["value"] for it in expected["rare_by"][:2]]
    # Other draws of the same distributions, whose order is another: the shares differ by four standard errors at most.
    share = machine.risk(draws=2000).probability.value
    assert abs(share - expected["probability"]["value"]) <= 4.0 * np.sqrt(2.0 * max(share * (1.0 - share), 1e-4) / 2000)
    assert machine.replace(damping=90.0).uncertain == machine.uncertain
    with pytest.raises(ValueError, match="nothing of the machine is uncertain"):
        slipmap.Machine(**machine.quantities).risk()


def test_the_correlated_errors_of_a_fit_stay_with_a_machine(program, tmp_path):
    fit = "low = 0.25, fall = 0.15, speed = 0.05, covariance = [[4e-6, -3e-6, 0], [-3e-6, 4e-6, 0], [0, 0, 1e-6]]"
    config = tmp_path / "fitted.toml"
    lines = "\n".join(f"{name} = {value}" for name, value in {**PAD, "damping": 1230.0}.items())
    law = f'law = "expression"\nphi = "low + fall*exp(-u/speed)"\nfit = {{ {fit} }}'
    config.write_text(f"[machine]\n{lines}\n[friction]\n{law}\n")
    expected = json.loads(program("machine", config, "--draws", "2000", "--json"))["risk"]["probability"]["value"]
    machine = slipmap.Machine.from_toml(config)
    assert 0.0 < expected < 1.0 and machine.uncertain["low"]["sd"] == 0.002
    for own in (machine, pickle.loads(pickle.dumps(machine)), machine.replace(damping=900.0).replace(damping=1230.0)):
        assert own == machine and own.risk(draws=2000).probability.value == expected


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
        assert np.isclose(with_units[name], plain[name], rtol=1e-15)
    speeds = [0.1, 0.2] * unit.m / unit.s
    assert np.array_equal(plain.critical_damping(belt_speed=speeds.to("cm/s")), plain.critical_damping(belt_speed=[0.1, 0.2]))
    with pytest.raises(ValueError, match="mass"):
        plain.replace(mass=2.0 * unit.meter)
    with pytest.raises(ValueError, match="belt_speed = 0"):
        plain.replace(belt_speed=0.0)
    with pytest.raises(TypeError, match="`colour` is no quantity"):
        plain.replace(colour=1.0)
    with pytest.raises(TypeError, match="leave out mu"):
        plain.replace(friction=slipmap.Law.exponential(mu=0.5))
    with pytest.raises(TypeError, match="also needs static_friction"):
        slipmap.Machine(mass=1.0, stiffness=1.0, damping=0.0, normal_force=1.0, belt_speed=1.0)
    with pytest.raises(ValueError, match="belt_speed has 40 values; choose one"):
        slipmap.Machine.from_toml(CONFIGS / "brake_pad.toml", damping=20.0)
    with pytest.raises(ValueError, match="sd"):
        plain.replace(damping={"value": 1.0, "spread": 0.1})


def test_a_machine_takes_text_with_units_and_tells_what_is_none(tmp_path):
    numbers = {"stiffness": 5.05e5, "normal_force": 1000.0, "friction": slipmap.Law.coulomb(), "static_friction": 0.4}
    given = {"mass": "2000 g", "damping_ratio": "2 %", "belt_speed": {"value": "50 mm/s", "sd": "1 mm/s"}}
    machine = slipmap.Machine(**numbers, **given, kinetic_friction="0.3 -")
    assert [machine[name] for name in ("mass", "damping_ratio", "belt_speed")] == [2.0, 0.02, 0.05]
    assert machine.uncertain["belt_speed"] == {"sd": 0.001}
    assert machine.critical_damping(belt_speed="60 mm/s") == machine.critical_damping(belt_speed=0.06)
    for change, words in [
        ({"mass": "2 N"}, "mass: N is no unit of it; write it in kg"),
        ({"belt_speed": "fast"}, "belt_speed: `fast` is no number with a unit"),
        ({"kinetic_friction": "1 m"}, "kinetic_friction: it is a pure number"),
    ]:
        with pytest.raises(ValueError, match=words):
            machine.replace(**change)
    # A law by its name, and the page in the units in which the numbers were given.
    named = slipmap.Machine(**{**numbers, "friction": "coulomb"}, **given, kinetic_friction="0.3 -")
    assert named == machine
    page = pickle.loads(pickle.dumps(named)).page(draws=100).html
    assert "50 mm/s" in page and "2000 g" in page and "may stick-slip below belt speed" in page and "0.05 m/s" not in page
    try:
        document = named.explorer(title="A pad")
        assert '"title":"A pad"' in document and '["mm/s",0.001]' in document and len(document) > 1_000_000
    except NotImplementedError as why:
        assert "rustup target add" in str(why)
    with pytest.raises(TypeError, match=r"a Law is needed, not 'columb': slipmap\.Law\.stribeck\(\), "):
        machine.replace(friction="columb")
    with pytest.raises(TypeError, match=r"also needs stribeck_velocity, or friction=Law\.coulomb\(\)"):
        slipmap.Machine(**PAD, static_friction=0.4, kinetic_friction=0.3)
    at = {"V": 1.0, "c": 0.1}
    for asked in (slipmap.probe, slipmap.orbit, lambda it: slipmap.regime(it, **at), lambda it: slipmap.Point(it, **at)):
        with pytest.raises(TypeError, match=r"a machine answers by its own methods critical_damping"):
            asked(machine)
    with pytest.raises(ValueError, match="draws = 0: must be at least 1"):
        machine.risk(draws=0)
    shown = machine.probe()._repr_html_()
    assert shown.index("The machine, in SI units") < shown.index("N s/m") < shown.index("In dimensionless terms")


def test_a_formula_with_a_power_is_friction_of_a_machine():
    bell = slipmap.Law.expression("0.25 + 0.15*exp(-(u/0.05)^1.5)")
    named = {"static_friction": 0.4, "kinetic_friction": 0.25, "stribeck_velocity": 0.05, "exponent": 1.5}
    values = [
        slipmap.Machine(**PAD, friction=law, **numbers).critical_damping(return_error=True)
        for law, numbers in ((bell, {}), (slipmap.Law.exponential(), named))
    ]
    (one, error), (other, own) = values
    assert abs(one - other) <= error + own and error < 1e-6 * one


def test_a_critical_damping_that_is_not_known_has_a_reason():
    machine = slipmap.Machine(**PAD, friction=slipmap.Law.table(SPEEDS, FRICTION))
    with pytest.warns(RuntimeWarning, match="the critical damping of element 1 is not known: "):
        assert np.isnan(machine.critical_damping(belt_speed=[0.05, 0.39])).tolist() == [False, True]


def test_an_answer_shows_itself():
    answer = slipmap.probe(slipmap.Law.stribeck(**PARAMETERS), V=1.0, c=0.5, epsilon=0.1)
    shown = answer._repr_html_()
    assert "<table>" in shown and "symmetric" in shown and "critical damping" in shown
    assert "regime" in repr(answer)
    assert answer.flow.direct.fate == answer.flow.arcs.fate
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
    assert float(orbit.x1.max()) <= answer.attracting_cycle.x1.hi + 1e-6
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


def test_points_of_codimension_two_are_branches_of_one_point():
    # w is proportional to x exp(-x^2), x = u / vs: w'' vanishes at x^2 = 3/2.
    law = slipmap.Law.exponential(mu=0.6, vs=0.3, eta=0.0, exponent=2.0)
    found = slipmap.curves(law, V=[0.2, 0.6], c=[0.1, 2.0], epsilon=1.0)
    kinds = found.curve.attrs["flag_meanings"].split()
    bautin = found.isel(point=found.curve.values == kinds.index("bautin"))
    x = np.sqrt(1.5)
    assert bautin.V.values == pytest.approx([0.3 * x], abs=1e-9)
    assert bautin.c.values == pytest.approx([0.8 * x / 0.3 * np.exp(-1.5)], abs=1e-9)


def test_a_margin_may_be_infinite():
    answer = slipmap.probe(slipmap.Law.stribeck(1.0, 0.5, 0.0), V=3.0, c=0.1, epsilon=1.0)
    assert answer.methods["symmetric"].margin == -np.inf
    assert answer.to_dict()["methods"]["symmetric"]["margin"] == "-inf"
    assert answer.methods["event_step"].margin is None


def test_other_units_are_told():
    pad = slipmap.Machine(mass="2 t", stiffness=8e5, damping=4.0, normal_force="50 kN", static_friction=0.4,
                          kinetic_friction=0.3, stribeck_velocity=0.25, belt_speed=0.1)
    assert pad.notes == ["1 t is 1000 kg", "1 kN is 1000 N"]
    assert pad.replace(mass=2.0).notes == ["1 kN is 1000 N"]
