"""Friction laws."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, overload

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from . import _core, _given
from ._broadcast import Numbers, flat
from ._decode import decode
from ._fit import Fit
from ._results import Fitted


class Law:
    r"""A friction law: the friction force phi(u) at slip speed u >= 0, in units of the static force.

    Made by one of the class methods :meth:`stribeck`, :meth:`exponential`, :meth:`lorentzian`, :meth:`coulomb`,
    :meth:`expression`, :meth:`table`, :meth:`from_csv`, :meth:`from_dataframe` and :meth:`from_function`, or the law of
    a :meth:`fit`. A law may hold values of its parameters; the
    others are given at each call.

    Notes
    -----
    Friction at rest is 1. Friction in slip begins there, or lower by a drop: see `static` of :meth:`expression` and
    :meth:`table`, :meth:`coulomb` and :meth:`with_drop`. Slip speeds are in units of (static force) / sqrt(stiffness * mass); for SI see
    :class:`slipmap.Machine`.
    The oscillator is x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(\|x2 - V\|).

    Examples
    --------
    >>> import slipmap
    >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> law
    Law.exponential(mu=0.5, vs=1.0, eta=0.0)
    >>> round(float(law.phi(0.5)), 6)
    0.803265
    """

    __slots__ = ("_joint", "_law", "_quantity", "_values")

    def __init__(
        self,
        law: _core.Law,
        values: Mapping[str, Numbers | None],
        joint: Mapping[str, Sequence[float]] = {},
        quantity: str | None = None,
    ):
        """Not to be called by users: the class methods make laws.

        `joint` has rows of the Cholesky factor of the covariance of some values; `quantity` is "coefficient" or "force" of a
        law in SI units.
        """
        self._law, self._joint, self._quantity = law, dict(joint), quantity
        known = [name for name, *_ in law.parameters]
        for name in values:
            if name not in known:
                raise TypeError(_unknown(name, law))
        self._values = {name: values[name] for name in known if values.get(name) is not None}
        for name, _, least, greatest, domain in law.parameters:
            if name in self._values:
                _check(name, self._values[name], least, greatest, domain)

    @classmethod
    def stribeck(
        cls, alpha: Numbers | None = None, beta: Numbers | None = None, gamma: Numbers | None = None
    ) -> Law:
        """The paper's law, phi = (1 - alpha) / (1 + epsilon gamma u) + alpha + epsilon beta u**2.

        Parameters
        ----------
        alpha : array_like, optional
            Friction at high slip speed, from 0 (falls to nothing) to 1 (does not fall).
        beta : array_like, optional
            Rise of the friction with the square of the slip speed, at least 0.
        gamma : array_like, optional
            Rate at which friction weakens as slip begins, at least 0.

        Examples
        --------
        >>> import slipmap
        >>> float(slipmap.Law.stribeck(alpha=0.4, beta=0.2, gamma=2.0).phi(0.0, epsilon=0.1))
        1.0
        """
        return cls(_core.Law.built_in("stribeck"), {"alpha": alpha, "beta": beta, "gamma": gamma})

    @classmethod
    def exponential(
        cls,
        mu: Numbers | None = None,
        vs: Numbers | None = None,
        eta: Numbers | None = 0.0,
        exponent: Numbers | None = 1.0,
    ) -> Law:
        """The law phi = mu + (1 - mu) exp(-(u / vs)**exponent) + eta u.

        Parameters
        ----------
        mu : array_like, optional
            Friction at high slip speed, from 0 to 1.
        vs : array_like, optional
            Slip speed over which the friction falls, greater than 0.
        eta : array_like, optional
            Rise of the friction with the slip speed, at least 0, the default. None: given at each call.
        exponent : array_like, optional
            From 1, the default, for Tustin's law, to 100; 2 is Gauss's. None: given at each call. Below 1 friction would fall infinitely fast as
            slip begins; write that as a drop, see :meth:`with_drop`.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0, exponent=2.0)
        >>> round(float(law.phi(1.0)), 4)
        0.6839
        """
        law = _core.Law.built_in("exponential")
        values = {"mu": mu, "vs": vs, "eta": eta}
        if not (isinstance(exponent, (int, float)) and exponent == 1.0):
            law, values = law.with_exponent(), {**values, "exponent": exponent}
        return cls(law, values)

    @classmethod
    def lorentzian(
        cls, mu: Numbers | None = None, vs: Numbers | None = None, eta: Numbers | None = 0.0
    ) -> Law:
        """The law phi = mu + (1 - mu) / (1 + (u / vs)**2) + eta u, with parameters as :meth:`exponential`."""
        return cls(_core.Law.built_in("lorentzian"), {"mu": mu, "vs": vs, "eta": eta})

    @classmethod
    def coulomb(cls, drop: Numbers | None = None, eta: Numbers | None = 0.0) -> Law:
        """Two coefficients: friction 1 at rest, and 1 - drop + eta u in slip.

        Parameters
        ----------
        drop : array_like, optional
            Static less kinetic friction, in units of the static one: from 0 to below 1.
        eta : array_like, optional
            As in :meth:`exponential`.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.coulomb(drop=0.5, eta=0.0)
        >>> round(float(slipmap.critical_c(law, V=1.36962021, epsilon=1.0)), 8)
        0.02
        """
        return cls(_core.Law.built_in("coulomb"), {"drop": drop, "eta": eta})

    @classmethod
    def expression(
        cls, formula: str, *, static: float | None = None, rest: str | None = None, **parameters: Numbers
    ) -> Law:
        """A law given as a formula in the slip speed `u`, in `eps`, and in any other names, its parameters.

        Parameters
        ----------
        formula : str
            For example ``"mu + (1 - mu)*exp(-u/vs)"``. Functions: exp, ln, sqrt, sin, cos, tan, sinh, cosh,
            tanh, atan, asinh, log10, abs; the slip speed is `u` or `v`, and ``e^x`` is ``exp(x)``.
        static : float, optional
            Friction at rest, by which the formula is divided: its value at u = 0, or more where friction drops as slip
            begins. By default 1, the value of the formula at u = 0.
        rest : str, optional
            "peak" for a smoothed law, which rises from 0 at rest: the law beyond its first peak, with the peak as friction
            at rest and up to it: ``max(u, peak)`` for `u`. It has no parameters.
        **parameters : array_like
            Values of the names in the formula; those left out are given at each call.

        Raises
        ------
        ValueError
            If the text is no formula; the message points into it.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.expression("mu + (1 - mu)*exp(-u/vs)", mu=0.5, vs=1.0)
        >>> float(law.phi(0.0))
        1.0
        >>> law = slipmap.Law.expression("tanh(30*u)*(0.6 + 0.4*exp(-u))", rest="peak")
        >>> round(float(law.phi(0.01)), 12)
        1.0
        """
        level = None if static is None else float(static)
        return cls(_core.Law.expression(formula, level, _is_at_peak(rest, static)), parameters)

    @classmethod
    def table(
        cls,
        u: ArrayLike,
        friction: ArrayLike,
        stderr: ArrayLike | None = None,
        *,
        static: float | None = None,
        rest: str | None = None,
        origin: str = "the table",
    ) -> Law:
        """A measured law: friction at growing slip speeds, joined by cubics that keep the shape of the data.

        Parameters
        ----------
        u : array_like
            Slip speeds, from 0, strictly growing; at least three.
        friction : array_like
            Friction at these, in any unit.
        stderr : array_like, optional
            Standard error of each datum, in the same unit; :func:`slipmap.standard_error` makes one of c* of
            them.
        static : float, optional
            Friction at rest, by which the data are divided: the first of them (the default), or more where friction
            drops as slip begins. Two data at slip speed 0 say the same: the larger one holds, the smaller one slips.
        rest : str, optional
            "peak" for data that rise from 0 at rest: friction from rest up to the first peak is that of the peak.
        origin : str
            Where the data come from, for messages.

        Raises
        ------
        ValueError
            If the data are no friction law; the message names the row.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.table([0.0, 0.5, 1.0, 2.0, 4.0], [0.40, 0.31, 0.28, 0.26, 0.25])
        >>> round(float(law.phi(1.0)), 12)
        0.7
        """
        speeds, levels = _vector("u", u), _vector("friction", friction)
        if len(speeds) != len(levels):
            raise ValueError(f"friction: {len(levels)} values at {len(speeds)} slip speeds")
        errors = None if stderr is None else _vector("stderr", np.broadcast_to(stderr, speeds.shape))
        at_peak = _is_at_peak(rest, static)
        if static is None and not at_peak and len(speeds) > 2 and speeds[0] == 0 == speeds[1] < speeds[2] and levels[0] != levels[1]:
            static = max(levels[:2])
            slips = np.arange(len(speeds)) != np.argmax(levels[:2])
            speeds, levels = speeds[slips], levels[slips]
            errors = None if errors is None else errors[slips]
        level = None if static is None else float(static)
        return cls(_core.Law.table(speeds, levels, errors, level, at_peak, origin), {})

    @classmethod
    def from_csv(
        cls,
        path: str | os.PathLike[str],
        *,
        static: float | None = None,
        rest: str | None = None,
        quantity: str | None = None,
        kind: str | None = None,
        direction: str | None = None,
        column: str | None = None,
    ) -> Law:
        """A measured law from a file as rigs and spreadsheets write it, for a :class:`slipmap.Machine`: in SI units.

        Parameters
        ----------
        path : str or path
            The file: slip speed and friction, perhaps its standard error or the time, in any order, encoding and units,
            which the header names. Readings are reduced to a curve with errors; few are taken as they are.
        static, rest
            As in :meth:`table`.
        quantity : {"coefficient", "force"}, optional
            What the friction is where the header has no unit. Forces belong to the normal force at which they were measured:
            divided by it they are coefficients, for machines, maps and sweeps with any normal force.
        kind : {"record", "curve", "rows"}, optional
            Whether the rows are a record over time, independent readings, or the law itself; left out, what the file says.
        direction : {"mean", "forward", "backward"}, optional
            Of which direction of slip friction is taken.
        column : str, optional
            Which columns are read, by name or number: ``"speed=NAME, friction=NAME"``, and error, time, position, normal.

        Raises
        ------
        ValueError
            If the data have two meanings or none; the message names the line and the remedy.

        Examples
        --------
        >>> import pathlib, slipmap, tempfile
        >>> path = pathlib.Path(tempfile.mkdtemp(), "pad.csv")
        >>> _ = path.write_text("speed [mm/s];mu\\n0;0,40\\n50;0,31\\n100;0,28\\n200;0,26\\n")
        >>> round(float(slipmap.Law.from_csv(path).phi(0.1)), 12)
        0.7
        """
        return cls._measured(*_given.file(path), static, rest, quantity, kind, direction, column)

    @classmethod
    def from_dataframe(
        cls,
        data: pd.DataFrame,
        *,
        static: float | None = None,
        rest: str | None = None,
        quantity: str | None = None,
        kind: str | None = None,
        direction: str | None = None,
        column: str | None = None,
    ) -> Law:
        """A measured law from the columns of a DataFrame, which :meth:`from_csv` would read from a file.

        Examples
        --------
        >>> import pandas as pd, slipmap
        >>> data = pd.DataFrame({"speed": [0.0, 0.05, 0.1, 0.2], "mu": [0.40, 0.31, 0.28, 0.26]})
        >>> round(float(slipmap.Law.from_dataframe(data).phi(0.1)), 12)
        0.7
        """
        return cls._measured(*_given.columns(data), static, rest, quantity, kind, direction, column)

    @classmethod
    def _measured(
        cls,
        name: str,
        rows: bytes,
        static: float | None,
        rest: str | None,
        quantity: str | None,
        kind: str | None,
        direction: str | None,
        column: str | None,
    ) -> Law:
        level = None if static is None else float(static)
        at_peak, forces = _is_at_peak(rest, static), _is_force(quantity)
        law, forces = _core.measured(name, rows, level, at_peak, forces, kind, direction, column)
        return cls(law, {}, quantity="force" if forces else "coefficient")

    @classmethod
    def fit(
        cls,
        data: str | os.PathLike[str] | pd.DataFrame | ArrayLike,
        friction: ArrayLike | None = None,
        stderr: ArrayLike | None = None,
        *,
        law: str | None = None,
        quantity: str | None = None,
        kind: str | None = None,
        direction: str | None = None,
        column: str | None = None,
    ) -> Fit:
        """Fits laws to measured friction, for a :class:`slipmap.Machine`, as ``slipmap fit`` does.

        Parameters
        ----------
        data : str, path, DataFrame or array_like
            A file or a DataFrame, read as by :meth:`from_csv`; or slip speeds.
        friction, stderr : array_like
            Friction at these slip speeds and, optionally, its standard error, in SI units. A Series whose name has
            another unit is taken in SI units, too, with a warning.
        law : str, optional
            Which law to take in place of the best one, by its name in the table of laws.
        quantity, kind, direction, column
            As in :meth:`from_csv`.

        Returns
        -------
        Fit
            Its ``law`` carries the covariance of its parameters into the answers of machines.

        Raises
        ------
        ValueError
            If the data have two meanings or none, or no law follows from them.

        Examples
        --------
        >>> import numpy as np, slipmap
        >>> u = np.linspace(0.0, 0.4, 41)
        >>> noise = 0.002 * np.random.default_rng(1).standard_normal(41)
        >>> fit = slipmap.Law.fit(u, 0.25 + 0.15 * np.exp(-u / 0.05) + noise)
        >>> fit.name
        'exponential'
        >>> bool(abs(fit.parameters.value["v_s"] - 0.05) < 2.0 * fit.parameters.standard_error["v_s"])
        True
        """
        if friction is not None:
            u, level = _vector("data", np.asarray(data)), _vector("friction", friction)
            if len(u) != len(level):
                raise ValueError(f"friction: {len(level)} values at {len(u)} slip speeds")
            errors = {} if stderr is None else {"se": np.broadcast_to(np.asarray(stderr, dtype=float), u.shape)}
            names = _given.header("slip speed", "belt_speed", data), _given.header("friction", "normal_force", friction)
            source = _given.columns(pd.DataFrame({names[0]: u, names[1]: level, **errors}))
        else:
            source = _given.columns(data) if isinstance(data, pd.DataFrame) else _given.file(data)
        core, answer, toml = _core.fit(*source, law, _is_force(quantity), kind, direction, column)
        found = decode(Fitted, json.loads(answer))
        best = found.fit
        rows = np.linalg.cholesky(np.array(best.covariance))
        values, joint = dict(zip(best.names, best.values, strict=True)), dict(zip(best.names, rows.tolist(), strict=True))
        return Fit(cls(core, values, joint, found.quantity), found, toml)

    def with_drop(self, drop: Numbers | None = None) -> Law:
        """The same law with friction in slip less by the parameter `drop`; friction at rest stays 1.

        Parameters
        ----------
        drop : array_like, optional
            From 0 to below 1; given at each call if left out.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.exponential(mu=0.8, vs=0.5, eta=0.0).with_drop(0.2)
        >>> round(float(law.phi(0.0)), 12)
        0.8
        """
        return self._changed(self._law.with_drop(), {**self._values, "drop": drop})

    @classmethod
    def from_function(
        cls,
        function: Callable[[float], float],
        *,
        fastest: float,
        corners: ArrayLike = (),
        origin: str | None = None,
    ) -> Law:
        """A law given as a Python function, sampled once into polynomials, then as fast as any other.

        Errors of critical dampings include that of the samples. No test that proves anything decides for it.

        Parameters
        ----------
        function : callable
            Friction at a slip speed, a number at a time, in units of the static friction: 1 at slip speed 0.
        fastest : float
            Slip speed up to which it is sampled: at least twice the largest belt speed that will be asked
            about, better four times, as orbits that start beyond the belt line are faster.
        corners : array_like
            Slip speeds at which its slope jumps; elsewhere it should be smooth.
        origin : str, optional
            Its name in messages; by default that of the function.

        Returns
        -------
        Law
            Its :attr:`error` says how far its weakening rate may be from that of the function; the error
            estimates of :func:`critical_c` count it. The pieces are halved until they meet the function
            between its samples, too, next to rest and to corners down to 1e-12 of the range; a dip is seen that
            is as wide as a ten-thousandth of the range.

        Raises
        ------
        ValueError
            If a value is not finite, or not 1 at slip speed 0 or just above it. What the function itself
            raises is passed on.

        Examples
        --------
        >>> import math, slipmap
        >>> law = slipmap.Law.from_function(lambda u: 0.5 + 0.5 * math.exp(-u), fastest=16.0)
        >>> law.error < 1e-10
        True
        >>> built_in = slipmap.Law.exponential(mu=0.5, vs=1.0, eta=0.0)
        >>> difference = slipmap.critical_c(law, V=1.0, epsilon=1.0) - slipmap.critical_c(built_in, V=1.0, epsilon=1.0)
        >>> bool(abs(difference) < 1e-10)
        True
        """
        name = getattr(function, "__name__", "a function") if origin is None else origin
        kinks = [float(corner) for corner in np.atleast_1d(np.asarray(corners, dtype=float))]
        return cls(_core.Law.function(function, float(fastest), kinks, name), {})

    @property
    def error(self) -> float:
        """How far the weakening rate may be from that of the function that was sampled; 0 for other laws."""
        return self._law.error

    @property
    def name(self) -> str:
        """Name of the law in configurations and maps."""
        return self._law.name

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of all parameters in the order of a map's dimensions: epsilon, the law's own, V, c."""
        return tuple(self._law.axes)

    @property
    def parameters(self) -> dict[str, Numbers | None]:
        """The law's own parameters, with the values that it holds; ``None`` for those given at each call."""
        return {name: self._values.get(name) for name, *_ in self._law.parameters}

    @property
    def covariance(self) -> pd.DataFrame | None:
        """The covariance of the parameters of a fitted law; ``None`` for other laws."""
        if not self._joint:
            return None
        rows, names = np.array(list(self._joint.values())), list(self._joint)
        return pd.DataFrame(rows @ rows.T, names, names)

    def replace(self, **parameters: Numbers) -> Law:
        """The law with other values of some parameters.

        Examples
        --------
        >>> import slipmap
        >>> slipmap.Law.exponential(mu=0.5, vs=1.0).replace(eta=0.1)
        Law.exponential(mu=0.5, vs=1.0, eta=0.1)
        """
        return self._changed(self._law, {**self._values, **parameters})

    def read_as_small(self) -> Law:
        """The same law, read as 1 + epsilon F(u) with F = (phi - 1) / epsilon at the given epsilon.

        Then the tests to first order in epsilon, such as "perturbation", answer for every law; nothing else changes.

        Examples
        --------
        >>> import slipmap
        >>> law = slipmap.Law.expression("0.5 + 0.5*exp(-u)").read_as_small()
        >>> law
        Law.expression('0.5 + 0.5*exp(-u)').read_as_small()
        >>> point = slipmap.Point(law, V=1.0, c=0.1, epsilon=1.0)
        >>> slipmap.probe(point).methods["perturbation"].verdict
        'present'
        """
        return self._changed(self._law.read_as_small(), self._values)

    def _changed(self, law: _core.Law, values: Mapping[str, Numbers | None]) -> Law:
        """The law with other values; what is not changed keeps its errors."""
        joint = {name: row for name, row in self._joint.items() if values.get(name) is self._values[name]}
        return Law(law, values, joint, self._quantity)

    @overload
    def phi(self, u: float, *, epsilon: float = 1.0, **parameters: float) -> float: ...
    @overload
    def phi(self, u: ArrayLike, *, epsilon: float = 1.0, **parameters: float) -> NDArray[np.float64]: ...
    def phi(self, u: ArrayLike, *, epsilon: float = 1.0, **parameters: float) -> Any:
        """Friction at the slip speeds `u`, in units of the static force; NaN beyond the data of a table."""
        return self._evaluate(u, epsilon, parameters)[0]

    @overload
    def weakening(self, u: float, *, epsilon: float = 1.0, **parameters: float) -> float: ...
    @overload
    def weakening(self, u: ArrayLike, *, epsilon: float = 1.0, **parameters: float) -> NDArray[np.float64]: ...
    def weakening(self, u: ArrayLike, *, epsilon: float = 1.0, **parameters: float) -> Any:
        """Weakening rate -phi'(u) at the slip speeds `u`: positive where the friction falls with speed."""
        return self._evaluate(u, epsilon, parameters)[1]

    def _evaluate(self, u: ArrayLike, epsilon: float, parameters: Mapping[str, float]) -> tuple[Any, Any]:
        arguments = self._arguments(parameters)
        values = [_scalar(name, arguments[name]) for name in arguments]
        phi, weakening = self._law.evaluate(flat(u), float(epsilon), values)
        shape = np.shape(np.asarray(u))
        return phi.reshape(shape)[()], weakening.reshape(shape)[()]

    def _arguments(self, given: Mapping[str, Any], **shared: Any) -> dict[str, Any]:
        """Values of all axes that are in `shared` or are the law's own, in the order of the axes."""
        own = [name for name, *_ in self._law.parameters]
        for name in given:
            if name not in own:
                raise TypeError(_unknown(name, self._law))
        values = {**shared, **self._values, **given}
        if values.get("epsilon") is None and not self._law.needs_epsilon:
            values["epsilon"] = 1.0
        wanted = [name for name in self.axes if name in shared or name in own]
        missing = [name for name in wanted if values.get(name) is None]
        if missing:
            raise TypeError(f"the law `{self.name}` also needs {', '.join(missing)}")
        return {name: values[name] for name in wanted}

    def __repr__(self) -> str:
        values = [f"{name}={value!r}" for name, value in self._values.items()]
        maker, definition, small = self.name, self._law.definition, ""
        if self._law.is_read_as_small:
            definition, small = definition.split("\n", 1)[1], ".read_as_small()"
        if definition.startswith("drop\n"):
            definition, small = definition.split("\n", 1)[1], f".with_drop({self._values['drop']!r}){small}"
            values = [value for value in values if not value.startswith("drop=")]
        if self.name == "expression":
            values.insert(0, repr(definition.split("\n", 1)[1]))
        elif self.name == "table":
            rows = definition.split("\n{")[0].count("\n")
            values.insert(0, f"<{rows} data>")
        elif self.name == "function":
            maker = "from_function"
            values.insert(0, f"<{definition.split(' ', 1)[1].splitlines()[0]}>")
        return f"Law.{maker}({', '.join(values)}){small}"

    def _repr_html_(self) -> str:
        domains = {name: domain for name, *_, domain in self._law.parameters}
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(_shown(value))}</td><td>{html.escape(domains[name])}</td></tr>"
            for name, value in self.parameters.items()
        )
        head = "<tr><th>parameter</th><th>value</th><th>must be</th></tr>"
        formula = "" if self._law.formula is None else f": {html.escape(self._law.formula)}"
        table = f"<table>{head}{rows}</table>" if rows else ""
        told = "" if self._law.told is None else f"<p>read: {html.escape(self._law.told)}</p>"
        return f"<p>Law <b>{self.name}</b>{formula}</p>{told}{self._curve()}{table}"

    def _curve(self, speed: float = 1.0, force: float = 1.0) -> str:
        """The friction over the slip speed as a drawing (SVG), in these units; nothing while parameters are missing or arrays."""
        if any(value is None or np.size(np.asarray(value)) != 1 for value in self.parameters.values()):
            return ""
        # Up to twice the speed at which friction has fallen almost as far as it does.
        speeds = np.geomspace(1e-6, 1e6, 97)
        fall = 1.0 - np.nan_to_num(self.phi(speeds), nan=1.0)
        end = 2.0 * float(speeds[np.argmax(fall >= 0.95 * fall.max())])
        u = np.linspace(0.0, end, 101)
        phi = self.phi(u)
        top = float(np.nanmax([1.0, *phi]))
        width, height, edge = 240.0, 120.0, 14.0
        points = " ".join(
            f"{edge + width * x / end:.1f},{4 + height * (1.0 - y / top):.1f}" for x, y in zip(u, phi, strict=True) if np.isfinite(y)
        )
        return (
            f'<svg width="{width + 2 * edge:g}" height="{height + 22:g}" font-size="10" role="img" aria-label="friction over slip speed">'
            f'<path d="M{edge:g},4 V{height + 4:g} H{width + edge:g}" fill="none" stroke="gray"/>'
            f'<polyline points="{points}" fill="none" stroke="#0072b2" stroke-width="1.5"/>'
            f'<text x="2" y="12">{top * force:.3g}</text><text x="{edge:g}" y="{height + 17:g}">slip speed from 0 to {end * speed:.3g}</text></svg>'
        )

    def _key(self) -> tuple[Any, ...]:
        values = tuple((name, np.asarray(value).tobytes()) for name, value in self._values.items())
        return (self.name, self._law.definition, values, tuple(map(tuple, self._joint.values())), self._quantity)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        return (Law, (self._law, self._values, self._joint, self._quantity))


def arguments_of(law: Law, given: Mapping[str, Any], **shared: Any) -> dict[str, Any]:
    """The values of a law's axes, for a function of dimensionless parameters."""
    refuse_si(law)
    return law._arguments(given, **shared)


def refuse_si(law: Law) -> None:
    """Refuses what is no law, and laws in SI units."""
    if not isinstance(law, Law):
        raise TypeError(f"law: {no_machine(law, 'Law')}")
    if law._quantity is not None:
        raise ValueError(
            "law: its slip speeds are in SI units, as measured friction has them; ask a machine with this friction, "
            "slipmap.Machine(.., friction=law)"
        )


def no_machine(given: Any, wanted: str) -> str:
    """What to do where something else than a law or a point was given."""
    if type(given).__name__ == "Machine":
        return (
            f"a {wanted} is needed; a machine answers by its own methods critical_damping(..), probe() and page(), and "
            "machine.point() is its dimensionless point"
        )
    return f"a {wanted} is needed, not {given!r:.60}"


def _is_at_peak(rest: str | None, static: float | None) -> bool:
    if rest not in (None, "peak"):
        raise ValueError(f'rest = {rest!r}: it can be "peak" only; friction at rest is `static`')
    if rest is not None and static is not None:
        raise ValueError("friction at rest is given twice, by `rest` and by `static`")
    return rest is not None


def _is_force(quantity: str | None) -> bool | None:
    if quantity not in (None, "coefficient", "force"):
        raise ValueError(f'quantity = {quantity!r}: it can be "coefficient" or "force"')
    return None if quantity is None else quantity == "force"


def _unknown(name: str, law: _core.Law) -> str:
    own = ", ".join(own for own, *_ in law.parameters) or "none"
    return f"`{name}` is no parameter of the law `{law.name}`; its parameters are: {own}"


def _check(name: str, values: Any, least: float, greatest: float, domain: str) -> None:
    """Refuses numbers outside a parameter's domain; those of dask are not computed here, NaN is no number."""
    if isinstance(values, (xr.DataArray, xr.Variable)):
        values = values.data
    if type(values).__module__.startswith("dask."):
        return
    try:
        numbers = flat(values)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: real numbers are needed, not {values!r:.60}") from None
    illegal = ~(np.isnan(numbers) | (np.isfinite(numbers) & (numbers >= least) & (numbers <= greatest)))
    if illegal.any():
        place = f" (element {illegal.argmax()})" if numbers.size > 1 else ""
        raise ValueError(f"{name}{place} = {numbers[illegal][0]:g}: it must be {domain}")


def _shown(value: Any) -> str:
    if value is None:
        return "given at each call"
    return f"{float(value):g}" if np.ndim(value) == 0 else f"shape {np.shape(value)}"


def _vector(name: str, values: ArrayLike) -> np.ndarray:
    if np.ndim(values) != 1:
        raise ValueError(f"{name}: one row of numbers is needed, not the shape {np.shape(values)}")
    return flat(values)


def _scalar(name: str, value: Any) -> float:
    array = np.asarray(value, dtype=float)
    if array.ndim:
        raise ValueError(f"{name}: one number is needed here, not the shape {array.shape}")
    return float(array)


# The laws whose parameters follow from a machine's coefficients, by their names.
BUILT_IN = {law.__name__: law for law in (Law.stribeck, Law.exponential, Law.lorentzian, Law.coulomb)}
