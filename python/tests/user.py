"""What a user's script may do, checked by mypy --strict (test_stubs.py) and run as a test."""

from __future__ import annotations

import numpy as np
import pandas as pd
import slipmap
import xarray as xr


def critical(law: slipmap.Law, speeds: xr.DataArray) -> xr.DataArray:
    """A result is of the kind of its arguments, as that of a ufunc of NumPy."""
    c: xr.DataArray = slipmap.critical_c(law, V=speeds)
    return c


def test_a_script() -> None:
    law = slipmap.Law.exponential(mu=0.5, vs=np.array([0.5, 1.0]))
    friction: float = slipmap.Law.exponential(mu=0.5, vs=1.0).phi(0.5)
    assert 0.5 < friction < 1.0
    speeds = xr.DataArray([0.5, 1.0], dims="V")
    assert critical(law.replace(vs=1.0), speeds).dims == ("V",)
    assert len(slipmap.critical_c(law.replace(vs=1.0), V=pd.Series([0.5, 1.0]))) == 2
    answer = slipmap.probe(law, V=1.0, c=0.1, vs=1.0)
    margin: float | None = answer.methods["simulation"].margin
    value: float | None = answer.critical_c.value
    assert margin is not None and value is not None
    if answer.landing is not None:
        period: float = answer.landing.period
        assert period > 0.0
    eigenvalues: tuple[complex, ...] = answer.equilibrium.eigenvalues
    assert len(eigenvalues) == 2
    pad = slipmap.Machine(
        mass={"value": 2.0, "sd": 0.1},
        stiffness=800.0,
        damping=4.0,
        belt_speed=0.1,
        normal_force=50.0,
        friction=slipmap.Law.expression("low + 0.1*exp(-u/0.05)"),
        low=0.3,
    )
    mass: float = pad["mass"]
    unit: float = pad.units.velocity
    machine = pad.probe().machine
    assert mass == 2.0 and unit > 0.0 and machine is not None
    needed: float | None = machine.critical_damping
    assert needed is not None and pad.replace(damping=needed).motion == "translation"
    data: xr.Dataset = slipmap.map({"V": speeds, "c": [0.0, 0.1], "epsilon": 1.0, "vs": 1.0}, law=law.replace(vs=1.0))
    volume: xr.DataArray = data.slipmap.claimed_volume()
    assert "method_name" in volume.dims
