"""Functions of parameters: shapes, types, NaN, threads, Ctrl-C."""

import math
import pickle
import signal
import subprocess
import sys
import threading
import time

import dask.array as da
import numpy as np
import pytest
import slipmap
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

LAW = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)



@settings(max_examples=20, deadline=None)
@given(st.data(), st.sampled_from([np.float64, np.float32, np.float16]))
def test_any_shapes_broadcast_and_elements_are_those_of_calls(data, dtype):
    shapes = data.draw(hnp.mutually_broadcastable_shapes(num_shapes=2, max_dims=3, max_side=3))
    V, epsilon = (
        data.draw(hnp.arrays(dtype, shape, elements=st.floats(0.125, 4.0, width=16))) for shape in shapes.input_shapes
    )
    c, error = slipmap.critical_c(LAW, V=V, epsilon=epsilon, return_error=True)
    assert np.shape(c) == shapes.result_shape == np.shape(error)
    assert c.dtype == np.float64
    for index in list(np.ndindex(shapes.result_shape))[:3]:
        speed, small = (np.broadcast_to(it, shapes.result_shape)[index] for it in (V, epsilon))
        one, own = slipmap.critical_c(LAW, V=float(speed), epsilon=float(small), return_error=True)
        # Columns share vector registers, so that the last bits may differ, within their errors.
        assert abs(one - c[index]) <= own + error[index]


@settings(max_examples=20, deadline=None)
@given(hnp.arrays(st.sampled_from([np.int8, np.uint16, np.int64]), 3, elements=st.integers(1, 4)))
def test_whole_numbers_are_numbers(V):
    assert np.array_equal(
        slipmap.critical_c(LAW, V=V, epsilon=0.1), slipmap.critical_c(LAW, V=V.astype(float), epsilon=0.1)
    )


def test_scalars_give_scalars_and_nothing_gives_nothing():
    c = slipmap.critical_c(LAW, V=1.0, epsilon=0.1)
    assert isinstance(c, np.float64)
    assert slipmap.critical_c(LAW, V=[], epsilon=0.1).shape == (0,)
    assert slipmap.critical_c(LAW, V=np.ones((1, 1)), epsilon=0.1).shape == (1, 1)


def test_nan_in_nan_out():
    V = np.array([0.5, np.nan, 2.0])
    c = slipmap.critical_c(LAW, V=V, epsilon=0.1)
    assert np.array_equal(np.isnan(c), [False, True, False])
    assert slipmap.verdicts(LAW, V=V, c=0.3, epsilon=0.1, methods="simulation")[1] == slipmap.Verdict["NOT_COMPUTED"]
    assert slipmap.regime(LAW, V=V, c=0.3, epsilon=0.1)[1] == slipmap.Regime["FAILED"]


def test_steep_laws_meet_their_limit_within_their_errors():
    arguments = {"V": [1.0, 0.2], "mu": [0.5, 0.9], "vs": [1e-9, 1e-13], "epsilon": 1.0}
    c, error = slipmap.critical_c(slipmap.Law.exponential(eta=0.0), **arguments, return_error=True)
    # The limit of steep laws depends on V / (1 - mu) alone.
    limit = 0.035876191808776
    assert (abs(c - limit) <= error + np.array([1e-8, 1e-12])).all() and (error <= 1e-6 * limit).all()


def test_dimensions_and_coordinates_are_kept():
    V = xr.DataArray([0.5, 1.0, 2.0], dims="V", coords={"V": [0.5, 1.0, 2.0]})
    c = xr.DataArray(np.linspace(0.0, 1.0, 4), dims="c", coords={"c": np.linspace(0.0, 1.0, 4), "si": ("c", range(4))})
    critical = slipmap.critical_c(LAW, V=V, epsilon=0.1)
    assert critical.dims == ("V",) and critical.attrs["units"] == "1"
    verdicts = slipmap.verdicts(LAW, V=V, c=c, epsilon=0.1)
    assert isinstance(verdicts, xr.Dataset) and verdicts["simulation"].dims == ("V", "c")
    assert "si" in verdicts.coords
    assert verdicts["simulation"].dtype == np.int8
    assert "present" in verdicts["simulation"].attrs["flag_meanings"]
    # The verdict is presence below the critical damping, unless the orbit lands beyond the stick segment.
    assert ((verdicts["simulation"] == 1) == (c < critical)).all()
    codes = slipmap.regime(LAW, V=V, c=c, epsilon=0.1)
    assert codes.dims == ("V", "c") and "stick_slip" in codes.attrs["flag_meanings"]


def test_dask_arrays_stay_lazy_and_agree():
    V = da.linspace(0.5, 2.0, 64, chunks=16)
    expected = slipmap.critical_c(LAW, V=V.compute(), epsilon=0.1)
    lazy = slipmap.critical_c(LAW, V=V, epsilon=0.1)
    assert isinstance(lazy, da.Array)
    assert np.allclose(lazy.compute(), expected, rtol=0, atol=1e-8)
    named = xr.DataArray(V, dims="V")
    result = slipmap.critical_c(LAW, V=named, epsilon=0.1)
    assert isinstance(result.data, da.Array)
    assert np.allclose(result, expected, rtol=0, atol=1e-8)
    by_hand = xr.apply_ufunc(
        lambda V: slipmap.critical_c(LAW, V=V, epsilon=0.1), named, dask="parallelized", output_dtypes=[float]
    )
    assert np.allclose(by_hand, expected, rtol=0, atol=1e-8)
    both = slipmap.verdicts(LAW, V=named, c=0.3, epsilon=0.1, methods=["symmetric", "simulation"])
    assert set(both) == {"symmetric", "simulation"} and isinstance(both["simulation"].data, da.Array)


def test_a_column_is_decided_as_its_points_are():
    c = np.linspace(0.0, 2.0, 21)[::-1]
    for law, values in [
        (LAW, {"epsilon": 0.1, "V": 1.0}),
        (slipmap.Law.exponential(0.5, 1.0, 0.0), {"epsilon": 1.0, "V": 0.6}),
    ]:
        whole = slipmap.verdicts(law, c=c, **values)
        for i in (0, 7, 20):
            assert {name: it[i] for name, it in whole.items()} == slipmap.verdicts(law, c=c[i], **values)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"V": -1.0, "epsilon": 0.1}, r"V = -1: it must be greater than 0"),
        ({"V": [1.0, np.inf], "epsilon": 0.1}, r"V \(element 1\) = inf"),
        ({"V": np.ones(2), "epsilon": np.ones(3)}, r"epsilon \(3,\), V \(2,\)"),
        ({"V": 1.0, "epsilon": 0.1, "tolerance": 1.0}, "tolerance"),
    ],
)
def test_wrong_values_are_told_by_name(arguments, words):
    with pytest.raises(ValueError, match=words):
        slipmap.critical_c(LAW, **arguments)


def test_wrong_names_and_types_are_told():
    with pytest.raises(TypeError, match="`mu` is no parameter of the law `stribeck`"):
        slipmap.critical_c(LAW, V=1.0, epsilon=0.1, mu=1.0)
    with pytest.raises(TypeError, match="also needs gamma"):
        slipmap.critical_c(slipmap.Law.stribeck(0.4, 0.2), V=1.0, epsilon=0.1)
    with pytest.raises(TypeError, match="V: real numbers are needed"):
        slipmap.critical_c(LAW, V="fast", epsilon=0.1)
    with pytest.raises(ValueError, match="there is no method `symmetrical`"):
        slipmap.verdicts(LAW, V=1.0, c=0.0, epsilon=0.1, methods="symmetrical")


def test_bad_laws_are_told_with_their_place():
    with pytest.raises(ValueError, match=r"\^"):
        slipmap.Law.expression("mu + exp(-u/")
    with pytest.raises(ValueError, match="row 2"):
        slipmap.Law.table([0.0, 1.0, 1.0, 2.0], [1.0, 0.8, 0.7, 0.6])
    with pytest.raises(ValueError, match="2 V"):
        slipmap.critical_c(slipmap.Law.table([0.0, 1.0, 2.0], [1.0, 0.8, 0.7]), V=1.5, epsilon=1.0)


def test_laws_and_points_can_be_pickled_and_compared():
    for law in [LAW, slipmap.Law.expression("1 - a*u", a=0.1), slipmap.Law.table([0, 1, 2], [1, 0.8, 0.7])]:
        again = pickle.loads(pickle.dumps(law))
        assert again == law and hash(again) == hash(law)
        assert again.phi(0.5) == law.phi(0.5)
    point = slipmap.Point(LAW, V=1.0, c=0.3, epsilon=0.1)
    assert pickle.loads(pickle.dumps(point)) == point
    assert point.replace(c=0.4) != point


def test_a_formula_is_the_built_in_law():
    built_in = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    formula = slipmap.Law.expression("mu + (1 - mu)*exp(-u/vs)", mu=0.5, vs=1.0)
    u = np.linspace(0.0, 3.0, 7)
    assert np.allclose(formula.phi(u), built_in.phi(u), rtol=4e-16)
    assert np.allclose(formula.weakening(u), built_in.weakening(u), rtol=1e-15)
    V = np.linspace(0.2, 2.0, 5)
    c, error = slipmap.critical_c(built_in, V=V, epsilon=1.0, return_error=True)
    other, own = slipmap.critical_c(formula, V=V, epsilon=1.0, return_error=True)
    assert (np.abs(c - other) <= error + own).all()


def test_a_python_function_is_the_law_built_in():
    own = slipmap.Law.from_function(lambda u: 0.5 + 0.5 * math.exp(-u), fastest=12.0)
    built_in = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    V = np.linspace(0.2, 3.0, 9)
    c, error = slipmap.critical_c(own, V=V, epsilon=1.0, return_error=True)
    exact, more = slipmap.critical_c(built_in, V=V, epsilon=1.0, return_error=True)
    assert (np.abs(c - exact) <= error + more).all() and error.max() < 1e-8
    for dampings in (0.5 * exact, 1.5 * exact):
        said = slipmap.verdicts(own, V=V, c=dampings, epsilon=1.0, methods="simulation")
        assert np.array_equal(said, slipmap.verdicts(built_in, V=V, c=dampings, epsilon=1.0, methods="simulation"))
        # A theorem about the samples is none about the function.
        assert (slipmap.verdicts(own, V=V, c=dampings, epsilon=1.0, methods="symmetric") == slipmap.Verdict.UNDECIDED).all()
    again = pickle.loads(pickle.dumps(own))
    assert again == own and again.error == own.error
    assert "lambda" in repr(own)


def test_python_functions_that_are_no_laws_are_told():
    with pytest.raises(ZeroDivisionError):
        slipmap.Law.from_function(lambda u: 1.0 / (u - u), fastest=1.0)
    with pytest.raises(ValueError, match=r"phi\(0\) is 2"):
        slipmap.Law.from_function(lambda u: 2.0 - u, fastest=1.0)
    with pytest.raises(TypeError):
        slipmap.Law.from_function(lambda u: "one", fastest=1.0)
    with pytest.raises(ValueError, match="below 2 V"):
        slipmap.critical_c(slipmap.Law.from_function(lambda u: 1.0 - 0.1 * u, fastest=1.0), V=1.0, epsilon=1.0)


def test_a_call_tells_its_progress():
    told = []
    slipmap.critical_c(LAW, V=np.linspace(0.5, 2.0, 1000), epsilon=0.1, progress=lambda done, all: told.append((done, all)))
    assert told[-1] == (1000, 1000) and told == sorted(told)


def test_laws_without_epsilon_need_none_and_errors_have_places():
    law = slipmap.Law.exponential(mu=0.5, vs=1.0)
    assert slipmap.critical_c(law, V=1.0) == slipmap.critical_c(law.replace(eta=0.0), V=1.0, epsilon=1.0)
    assert slipmap.Point(law, V=1.0, c=0.1)["epsilon"] == 1.0
    with pytest.raises(TypeError, match="also needs epsilon"):
        slipmap.critical_c(LAW, V=1.0)
    with pytest.raises(ValueError, match=r"mu = 1.5: it must be between 0 and 1"):
        slipmap.Law.exponential(mu=1.5)
    with pytest.raises(ValueError, match=r"vs \(element 1\) = 0: it must be greater than 0"):
        law.replace(vs=[1.0, 0.0])
    with pytest.raises(TypeError, match="mu: real numbers are needed"):
        slipmap.Law.exponential(mu="low")
    shown = law._repr_html_()
    assert "<polyline" in shown and "exp(" in shown and "greater than 0" in shown
    assert "<polyline" not in slipmap.Law.exponential(mu=0.5)._repr_html_()


def test_ten_threads_at_once():
    V = np.linspace(0.3, 3.0, 600)
    expected = slipmap.critical_c(LAW, V=V, epsilon=0.1)
    said = slipmap.verdicts(LAW, V=V, c=0.3, epsilon=0.1)
    results = [None] * 10

    def work(i):
        results[i] = (slipmap.critical_c(LAW, V=V, epsilon=0.1), slipmap.verdicts(LAW, V=V, c=0.3, epsilon=0.1))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for critical, verdicts in results:
        assert np.array_equal(critical, expected)
        assert all(np.array_equal(verdicts[name], said[name]) for name in said)


def test_the_interpreter_runs_while_the_engine_works():
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    slipmap.regime(LAW, V=np.linspace(0.3, 3.0, 500), c=0.3, epsilon=0.1)
    done.set()
    thread.join()
    assert counted[0] > 1000


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_the_work():
    # A shell starts background processes with SIGINT ignored, and Python keeps that setting.
    code = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)
import numpy as np, slipmap
law = slipmap.Law.expression("0.5 + 0.5*exp(-u)")
print("ready", flush=True)
try:
    slipmap.regime(law, V=np.linspace(0.3, 3.0, 10_000_000), c=0.1, epsilon=1.0)
except KeyboardInterrupt:
    print("stopped", flush=True)
"""
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    # In the midst of the work.
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=120)
    assert out == "stopped\n" and child.returncode == 0
