"""Derivatives of the critical damping."""

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
    slopes = slipmap.sensitivity(law, V=V, epsilon=0.1, alpha=alpha, gamma=2.0, wrt=["alpha", "beta"])
    assert isinstance(slopes, xr.Dataset) and set(slopes.data_vars) == {"dc_dalpha", "dc_dbeta"}
    assert set(slopes["dc_dalpha"].dims) == {"V", "alpha"}
    # Less weakening, and friction that rises, both need less damping to end stick-slip.
    assert (slopes["dc_dalpha"] < 0).all() and (slopes["dc_dbeta"] < 0).all()
    with pytest.raises(ValueError, match="`c` is no parameter"):
        slipmap.sensitivity(law, V=1.0, epsilon=0.1, alpha=0.1, gamma=1.0, wrt=["c"])
