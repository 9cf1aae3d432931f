"""Arrays of any layout, masked arrays, Series, and blocks for other processes."""

import cloudpickle
import dask.array as da
import numpy as np
import pandas as pd
import pytest
import slipmap
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

LAW = slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0)


def strided(values):
    return np.repeat(values, 2, axis=-1)[..., ::2] if values.ndim else values


def backward(values):
    return values[..., ::-1].copy()[..., ::-1] if values.ndim else values


def misaligned(values):
    raw = np.frombuffer(bytearray(1) + bytearray(values.tobytes()), np.uint8)
    return raw[1:].view(np.float64).reshape(values.shape)


def swapped(values):
    return values.astype(values.dtype.newbyteorder())


def by_columns(values):
    return np.require(values, requirements="F")


def read_only(values):
    values = values.copy()
    values.flags.writeable = False
    return values


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from([(), (0,), (1,), (4,), (2, 3), (0, 3), (1, 1)]),
    st.sampled_from([strided, backward, misaligned, swapped, by_columns, read_only]),
)
def test_the_layout_of_an_array_does_not_matter(shape, laid):
    V = np.linspace(0.5, 2.0, int(np.prod(shape))).reshape(shape)
    other = laid(V)
    assert np.array_equal(slipmap.critical_c(LAW, V=other, epsilon=0.1), slipmap.critical_c(LAW, V=V, epsilon=0.1))
    assert np.array_equal(LAW.phi(other), LAW.phi(V))
    rows = slipmap.backbone(LAW, [0.5, 1.0], V=other, epsilon=0.1)
    assert np.array_equal(rows, slipmap.backbone(LAW, [0.5, 1.0], V=V, epsilon=0.1)) and rows.shape == (*shape, 2)


def test_arrays_compute_through_their_mask():
    # What lies under a mask need not be legal.
    V = np.ma.array([0.5, -1.0, 2.0], mask=[False, True, False])
    c = slipmap.critical_c(LAW, V=V[:, None], epsilon=[0.1, 0.2])
    assert np.ma.isMaskedArray(c) and np.array_equal(c.mask, [[False] * 2, [True] * 2, [False] * 2])
    assert np.array_equal(c[[0, 2]].data, slipmap.critical_c(LAW, V=[[0.5], [2.0]], epsilon=[0.1, 0.2]))
    codes = slipmap.verdicts(LAW, V=V, c=0.3, epsilon=0.1, methods="simulation")
    assert codes.dtype == np.int8 and np.array_equal(codes.mask, V.mask)
    assert np.array_equal(slipmap.backbone(LAW, [1.0], V=V, epsilon=0.1).mask[:, 0], V.mask)


def test_series_keep_their_index_and_results_are_named():
    V = pd.Series([0.5, 1.0], index=["slow", "fast"], name="V")
    c, error = slipmap.critical_c(LAW, V=V, epsilon=0.1, return_error=True)
    assert isinstance(c, pd.Series) and list(c.index) == ["slow", "fast"]
    assert (c.name, error.name) == ("critical_c", "critical_c_error")
    assert np.array_equal(c, slipmap.critical_c(LAW, V=V.to_numpy(), epsilon=0.1))
    table = slipmap.verdicts(LAW, V=V, c=0.3, epsilon=0.1)
    assert isinstance(table, pd.DataFrame) and table.loc["fast", "simulation"] == 1
    assert list(slipmap.backbone(LAW, [0.5, 1.0], V=V, epsilon=0.1).columns) == [0.5, 1.0]
    with pytest.raises(ValueError, match="different indexes"):
        slipmap.critical_c(LAW, V=V, epsilon=pd.Series([0.1, 0.2], index=["fast", "slow"]))
    array = xr.DataArray([0.5, 1.0], dims="V", coords={"V": [0.5, 1.0]}, name="V")
    assert slipmap.critical_c(LAW, V=array, epsilon=0.1).name == "critical_c"
    assert slipmap.regime(LAW, V=array, c=0.1, epsilon=0.1).name == "regime"


def test_blocks_can_be_sent_to_other_processes():
    # As dask's scheduler of processes sends them; arrays arrive in buffers of any alignment.
    V = np.linspace(0.5, 2.0, 64)
    lazy = slipmap.critical_c(LAW, V=da.from_array(V, chunks=16), epsilon=0.1, threads=1)
    sent = cloudpickle.loads(cloudpickle.dumps(lazy))
    assert np.allclose(sent.compute(), slipmap.critical_c(LAW, V=V, epsilon=0.1), rtol=0, atol=1e-8)
    rows = slipmap.backbone(LAW, [0.5, 1.0], V=xr.DataArray(V, dims="V").chunk(V=32), epsilon=0.1)
    assert rows.chunks is not None
    rows = cloudpickle.loads(cloudpickle.dumps(rows)).compute()
    assert rows.dims == ("V", "amplitude") and rows.shape == (64, 2)
