"""What can be asked of a map: the accessor ``Dataset.slipmap``."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
import xarray as xr

from ._codes import METHODS, Verdict
from ._files import curves_of

PRESENT, ABSENT = int(Verdict["PRESENT"]), int(Verdict["ABSENT"])
REFERENCE = "simulation"
# Colours of Okabe and Ito, as in the program's figures.
_VERDICT_COLORS = {-1: "#f7e3bf", 0: "#ffffff", 1: "#0072b2", 2: "#000000", 3: "#8c8c8c"}
# The program distinguishes sets of attractors by hatching too; this module by colour alone.
_REGIME_COLORS = {
    "equilibrium": "#f7e3bf",
    "stick_slip": "#0072b2",
    "bistable": "#56b4e9",
    "pure_slip": "#009e73",
    "crossing": "#d55e00",
    "failed": "#000000",
    "pure_slip_and_stick_slip": "#f0e442",
    "pure_slip_and_equilibrium": "#b3e2cd",
    "equilibrium_pure_slip_and_stick_slip": "#cc79a7",
    "equilibrium_and_crossing": "#e69f00",
    "pure_slip_and_crossing": "#a6761d",
    "equilibrium_pure_slip_and_crossing": "#7f3b08",
    "stick_slip_and_crossing": "#542788",
    "equilibrium_stick_slip_and_crossing": "#8073ac",
    "pure_slip_stick_slip_and_crossing": "#b2abd2",
    "equilibrium_pure_slip_stick_slip_and_crossing": "#d8daeb",
    "neutral": "#8c8c8c",
}
_CURVE_STYLES = {
    "hopf": ("#000000", (0, (5, 2))),
    "grazing_sliding": ("#000000", "solid"),
    "landing": ("#d55e00", (0, (1, 1))),
    "crossing": ("#d55e00", "solid"),
    "fold": ("#cc79a7", "solid"),
}
_POINT_MARKS = {"bautin": "o", "hopf_at_grazing": "D", "fold_at_grazing": "^", "cusp": "s"}
# Letters in a row of a title, which the width of a figure by default holds.
_LONGEST = 60
_SYMBOLS = {"epsilon": "ε", "alpha": "α", "beta": "β", "gamma": "γ", "mu": "μ", "eta": "η"}


@xr.register_dataset_accessor("slipmap")
class MapAccessor:
    """Questions to a map that :func:`slipmap.map`, :func:`slipmap.run` or :func:`slipmap.open_map` gave.

    Examples
    --------
    >>> import numpy as np, slipmap
    >>> grid = {"V": [0.5, 1.0], "c": np.linspace(0.0, 1.0, 5), "epsilon": [0.1, 0.3]}
    >>> data = slipmap.map(grid, law=slipmap.Law.stribeck(0.4, 0.2, 2.0))
    >>> int(data.slipmap.contradictions().wrong_presence.sel(method_name="symmetric").sum())
    0
    """

    def __init__(self, data: xr.Dataset):
        self._data = data

    @property
    def methods(self) -> list[str]:
        """Names of the methods of the map."""
        return [str(name).removeprefix("verdict_") for name in self._data if str(name).startswith("verdict_")]

    @property
    def _names(self) -> xr.DataArray:
        return xr.DataArray(self.methods, dims="method_name", name="method_name")

    def verdict(self, method: str) -> xr.DataArray:
        """The verdicts of a method."""
        if method not in self.methods:
            raise KeyError(f"the map has no method `{method}`; it has {', '.join(self.methods)}")
        return self._data[f"verdict_{method}"]

    def _critical(self, method: str) -> xr.DataArray | None:
        """The stored critical damping, under the name of the damping."""
        return self._data.get(f"critical_{self._damping}_{method}")

    @property
    def curves(self) -> xr.Dataset | None:
        """The curves of codimension one that the map has, along their points; None if there are none."""
        if "curves" in self._data.encoding:
            stored: xr.Dataset = self._data.encoding["curves"]
            return stored
        source = self._data.encoding.get("source")
        return None if source is None else curves_of(source)

    def contradictions(self, reference: str = REFERENCE) -> xr.Dataset:
        """How often each method contradicts the reference, at each epsilon.

        Returns
        -------
        xarray.Dataset
            Over ``method_name`` and ``epsilon``, in cells: ``wrong_presence`` (it claims a cycle where the
            reference finds none), ``wrong_absence``, ``undecided``, ``agree``.
        """
        truth = self.verdict(reference)
        over = [dimension for dimension in truth.dims if dimension != "epsilon"]
        parts = []
        for name in self.methods:
            said = self.verdict(name)
            counts = {
                "wrong_presence": (said == PRESENT) & (truth == ABSENT),
                "wrong_absence": (said == ABSENT) & (truth == PRESENT),
                "undecided": said == int(Verdict["UNDECIDED"]),
                "agree": (said == truth) & ((said == PRESENT) | (said == ABSENT)),
            }
            parts.append(xr.Dataset({key: cells.sum(over) for key, cells in counts.items()}).drop_attrs())
        return xr.concat(parts, self._names)

    def claimed_volume(self, method: str | None = None) -> xr.DataArray:
        """Volume of parameter space in which each method claims a stick-slip cycle, rightly or not, as in the report.

        By the trapezoidal rule over the axes of more than one node except epsilon.

        Returns
        -------
        xarray.DataArray
            Over ``method_name`` (unless one is named) and ``epsilon``; the attribute ``box`` is the volume of
            the grid.
        """
        if method is None:
            parts = [self.claimed_volume(name) for name in self.methods]
            return xr.concat(parts, self._names, combine_attrs="override").rename("volume")
        claimed = (self.verdict(method) == PRESENT).astype(float)
        box = 1.0
        for axis in claimed.dims:
            if axis == "epsilon":
                continue
            if claimed.sizes[axis] == 1:
                claimed = claimed.isel({axis: 0}, drop=True)
            else:
                nodes = claimed[axis].values
                box *= float(nodes[-1] - nodes[0])
                claimed = claimed.integrate(axis)
        claimed.attrs = {"long_name": "volume in which a stick-slip cycle is claimed", "box": box}
        return claimed.rename("volume")

    @property
    def _damping(self) -> str:
        """The axis of the damping: c, or that of a machine."""
        return next((axis for axis in ("c", "damping_ratio") if axis in self._data.dims), "damping")

    def boundary(self, method: str = REFERENCE) -> xr.DataArray:
        """Damping at which a method's verdict changes from presence, in each column.

        The stored ``critical_c_METHOD`` if the map has it (its errors: ``critical_c_error_simulation``); else the middle between the last damping at which
        presence is claimed and the next node, NaN where it is claimed nowhere or at the last node.
        """
        stored = self._critical(method)
        if stored is not None:
            return stored
        present = self.verdict(method) == PRESENT
        damping = self._damping
        c = self._data[damping].values
        if len(c) < 2:
            raise ValueError("the map has one damping only, and no boundary along it")
        axis = present.get_axis_num(damping)
        last = len(c) - 1 - np.argmax(np.flip(present.values, axis), axis=axis)
        middle = np.append(0.5 * (c[1:] + c[:-1]), np.nan)
        values = np.where(present.any(damping).values, middle[last], np.nan)
        edge = present.isel({damping: 0}, drop=True).copy(data=values).rename(f"boundary_{method}")
        units = self._data[damping].attrs.get("units", "1")
        edge.attrs = {"long_name": f"damping at the edge of presence: {_long(method)}", "units": units}
        return edge

    def plot(
        self,
        variable: str = f"verdict_{REFERENCE}",
        *,
        x: str | None = None,
        y: str | None = None,
        ax: Any = None,
        **at: float,
    ) -> Any:
        """Draws a slice as the program does: verdicts or regimes as areas, boundaries as lines.

        Parameters
        ----------
        variable : str
            What to show: a verdict, the regime, or any variable over `x` and `y`.
        x, y : str
            The axes; by default the longest but the damping and epsilon, and the damping.
        ax : matplotlib Axes, optional
            Where to draw; by default a new figure.
        **at : float
            Values at which other axes are held; the nearest node is taken, by default the middle one.

        Returns
        -------
        matplotlib Axes
        """
        import matplotlib.pyplot as plt
        from matplotlib.colors import BoundaryNorm, ListedColormap
        from matplotlib.patches import Patch
        from matplotlib.ticker import LogLocator, NullFormatter

        cells = self._data[variable]
        damping = self._damping
        if y is None:
            y = damping if x != damping else next(str(axis) for axis in reversed(cells.dims) if axis != x)
        if x is None:
            others = [str(axis) for axis in cells.dims if axis not in (y, "epsilon")]
            x = max(others, key=lambda axis: cells.sizes[axis])
        held: dict[str, int] = {}
        for axis in (str(axis) for axis in self._data.dims):
            if axis in (x, y):
                continue
            nodes = self._data[axis].values
            held[axis] = int(np.abs(nodes - at.pop(axis)).argmin()) if axis in at else (len(nodes) - 1) // 2
        if at:
            raise TypeError(f"{', '.join(at)}: no axis of the map that can be held here")
        slice_ = cells.isel(held, missing_dims="ignore").transpose(y, x)
        if ax is None:
            _, ax = plt.subplots(figsize=(4.2, 3.4), layout="constrained")
        meanings = cells.attrs.get("flag_meanings", "").split()
        if meanings:
            codes = [int(code) for code in cells.attrs["flag_values"]]
            colors = [
                _REGIME_COLORS.get(word, "#8c8c8c") if variable == "regime" else _VERDICT_COLORS.get(code, "#8c8c8c")
                for word, code in zip(meanings, codes, strict=True)
            ]
            norm = BoundaryNorm([code - 0.5 for code in codes] + [codes[-1] + 0.5], len(codes))
            ax.pcolormesh(slice_[x], slice_[y], slice_, cmap=ListedColormap(colors), norm=norm, shading="nearest")
            shown = [code for code in codes if bool((slice_ == code).any())]
            patches = [
                Patch(facecolor=colors[codes.index(code)], edgecolor="#8c8c8c", label=_words(meanings[codes.index(code)]))
                for code in shown
            ]
            ax.legend(handles=patches, fontsize=7, loc="best", framealpha=0.9)
        else:
            mesh = ax.pcolormesh(slice_[x], slice_[y], slice_, cmap="cividis", shading="nearest")
            bar = ax.figure.colorbar(mesh, ax=ax)
            bar.set_label(textwrap.fill(cells.attrs.get("long_name", variable), 40), fontsize=8)
        exact = self._critical(REFERENCE)
        if y == damping and exact is not None:
            line = exact.isel(held, missing_dims="ignore")
            ax.plot(line[x], line, color="#000000", linewidth=1.2)
        self._draw_curves(ax, x, y, held)
        for nodes, axis, scale in ((slice_[x].values, ax.xaxis, ax.set_xscale), (slice_[y].values, ax.yaxis, ax.set_yscale)):
            if len(nodes) > 2 and nodes[0] > 0 and np.allclose(np.diff(np.log(nodes)), np.log(nodes[1] / nodes[0])):
                scale("log")
                # Few labels, also on less than a decade.
                axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if nodes[-1] < 200.0 * nodes[0] else (1.0,)))
                axis.set_major_formatter("{x:g}")
                axis.set_minor_formatter(NullFormatter())
        ax.set_xlim(slice_[x].values[[0, -1]])
        ax.set_ylim(slice_[y].values[[0, -1]])
        ax.set_xlabel(_SYMBOLS.get(x, x))
        ax.set_ylabel(_SYMBOLS.get(y, y))
        # Also those at which the map itself was taken.
        taken = [str(name) for name, it in cells.coords.items() if it.ndim == 0 and it.dtype.kind == "f"]
        values = [f"{_SYMBOLS.get(name, name)} = {float(slice_[name]):.4g}" for name in [*taken, *held] if name in slice_.coords]
        rows = (cells.attrs.get("long_name", variable), ", ".join(values))
        ax.set_title("\n".join(textwrap.fill(row, _LONGEST) for row in rows if row), fontsize=8)
        return ax

    def _draw_curves(self, ax: Any, x: str, y: str, held: dict[str, int]) -> None:
        found = self.curves
        if found is None or "point" not in found.dims:
            return
        kinds = found["curve"].attrs["flag_meanings"].split()
        words_x, words_y = (found[name].attrs["flag_meanings"].split() for name in ("plane_x", "plane_y"))
        for number in range(found.sizes["plane"]):
            names = {words_x[int(found.plane_x[number])], words_y[int(found.plane_y[number])]}
            nodes = {axis: float(self._data[axis][i]) for axis, i in held.items()}
            if names != {x, y} or any(float(found[f"held_{axis}"][number]) != node for axis, node in nodes.items()):
                continue
            of_plane = found.isel(point=found.plane_number.values == number + 1)
            for code, branch in dict.fromkeys(zip(of_plane.curve.values, of_plane.branch.values, strict=True)):
                line = of_plane.isel(point=(of_plane.curve.values == code) & (of_plane.branch.values == branch))
                color, dash = _CURVE_STYLES.get(kinds[int(code)], ("#8c8c8c", "solid"))
                # A point of codimension two is a branch of one point.
                mark = _POINT_MARKS.get(kinds[int(code)])
                ax.plot(line[x], line[y], color=color, linestyle=dash, linewidth=1.2, marker=mark, markersize=4)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _long(method: str) -> str:
    return METHODS[method].long_name if method in METHODS else _words(method)
