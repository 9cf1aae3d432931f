"""Derivatives of the critical damping."""

import math

import numpy as np
import pytest
import slipmap
import xarray as xr


def test_exact_derivatives_are_met():
    law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    V = np.array([0.3, 0.8, 1.5])
    slopes, errors = slipmap.sensitivity(law, V=V, epsilon=2.0, return_error=True)
    c = slipmap.critical_c(law, V=V, epsilon=2.0)
    # epsilon c* does not depend on epsilon in a law without it, and eta takes itself from the weakening rate:
    # epsilon dc*/d eta = -1, exactly.
    assert (np.abs(slopes["dc_depsilon"] + c / 2.0) <= errors["dc_depsilon"] + 1e-9).all()
    assert (np.abs(slopes["dc_deta"] + 0.5) <= errors["dc_deta"] + 1e-9).all()
    assert max(float(it.max()) for it in errors.values()) < 1e-5
    # The mean value theorem in V.
    width = 1e-3
    step = slipmap.critical_c(law, V=V + width, epsilon=2.0, tolerance=1e-13) - c
    assert np.allclose(slopes["dc_dV"], step / width, atol=2e-3)


def test_shapes_names_and_edges():
    law = slipmap.Law.stribeck(beta=0.0)
    V = xr.DataArray([0.5, 1.0], dims="V")
    alpha = xr.DataArray([0.0, 0.5, 0.9], dims="alpha")
    slopes = slipmap.sensitivity(law, V=V, epsilon=0.1, alpha=alpha, gamma=2.0)
    assert isinstance(slopes, xr.Dataset) and set(slopes.data_vars) >= {"dc_dalpha", "dc_dbeta"}
    assert set(slopes["dc_dalpha"].dims) == {"V", "alpha"}
    # Less weakening, and friction that rises, both need less damping to end stick-slip.
    assert (slopes["dc_dalpha"] < 0).all() and (slopes["dc_dbeta"] < 0).all()
    assert slopes["dc_dbeta"].attrs["long_name"] == "derivative of the critical damping by beta"


def test_the_influence_of_the_curve_makes_the_derivatives():
    law = slipmap.Law.exponential(mu=0.5, vs=0.7, eta=0.1)
    found = slipmap.influence(law, 500, V=0.8, epsilon=1.0)
    assert abs(float(found.share.sum()) - 1.0) < 1e-12 and (found.share >= 0).all()
    # The weakening rate is (1 - mu) exp(-u / vs) / vs - eta: its derivative by mu, weighted by the shares.
    # Within a range of width h it differs from that in the middle by h^2 / 24 of its second derivative, at
    # most 1 / vs^3, and by the slope of the weight as much again.
    width = float(found.slip_to[0] - found.slip_from[0])
    mean = float((found.share * -np.exp(-found.slip_speed / 0.7) / 0.7).sum())
    slopes = slipmap.sensitivity(law, V=0.8, epsilon=1.0)
    assert abs(mean - slopes["dc_dmu"]) < width / 0.7**2
    with pytest.raises(ValueError, match="negative"):
        slipmap.influence(law.replace(eta=2.0), V=0.8, epsilon=1.0)
    with pytest.raises(ValueError, match="parts"):
        slipmap.influence(law, 0, V=0.8, epsilon=1.0)


def test_the_standard_error_of_data_is_that_of_drawn_tables():
    u = np.array([0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0])
    friction = 0.4 * (0.6 + 0.4 * np.exp(-u / 0.5))
    law = slipmap.Law.table(u, friction, 0.0005)
    # The curve between the data has an error, too, also where they are exact.
    of_curve = slipmap.standard_error(slipmap.Law.table(u, friction, 0.0), V=0.8, epsilon=1.0)
    error = math.sqrt(slipmap.standard_error(law, V=0.8, epsilon=1.0) ** 2 - of_curve**2)
    random = np.random.default_rng(3)
    drawn = [
        slipmap.critical_c(slipmap.Law.table(u, friction + 0.0005 * random.standard_normal(u.size)), V=0.8, epsilon=1.0)
        for _ in range(60)
    ]
    # The spread of 60 draws has a relative standard error of 1 / sqrt(120): four of them.
    assert abs(np.std(drawn) / error - 1.0) < 4.0 / math.sqrt(120.0) and of_curve > 0.0
    with pytest.raises(TypeError, match="standard errors"):
        slipmap.standard_error(slipmap.Law.table(u, friction), V=0.8, epsilon=1.0)
    with pytest.raises(ValueError, match="row 1"):
        slipmap.Law.table(u, friction, [0.1, -0.1, 0.1, 0.1, 0.1, 0.1, 0.1])


def test_the_backbone_ends_at_the_hopf_and_the_critical_damping():
    law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    V = xr.DataArray([0.4, 1.0, 1.5], dims="V")
    c, error = slipmap.backbone(law, V=V, epsilon=2.0, return_error=True)
    assert c.dims == ("V", "amplitude") and error.dims == ("V",)
    critical, own = slipmap.critical_c(law, V=V, epsilon=2.0, return_error=True)
    assert (np.abs(c.isel(amplitude=-1) - critical) <= error + own).all()
    assert (np.abs(c.isel(amplitude=0) - law.weakening(V.values) / 2.0) <= error).all()
    # One slip cycle at every damping between, and it repels: C rises with the amplitude.
    assert (c.diff("amplitude") > 0).all()
    plain = slipmap.backbone(law, [0.0, 1.0], V=[0.4, 1.0, 1.5], epsilon=2.0)
    assert plain.shape == (3, 2) and np.array_equal(plain[:, 1], c.isel(amplitude=-1))
    with pytest.raises(ValueError, match="from 0 to 1"):
        slipmap.backbone(law, [2.0], V=1.0, epsilon=1.0)
