"""Friction laws fitted to measured friction."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import pandas as pd

from ._results import Fitted

if TYPE_CHECKING:
    from ._law import Law


@dataclass(frozen=True)
class Fit:
    """A law fitted to measured friction, and the laws with which it was compared; see :meth:`slipmap.Law.fit`."""

    law: Law
    """The law, with the values of its parameters and their covariance, which a machine with this friction takes over."""
    answer: Fitted = field(repr=False)
    """All that ``slipmap fit --json`` prints."""
    toml: str = field(repr=False)
    """The law as the table ``[friction]`` of a configuration."""

    @property
    def name(self) -> str:
        """Name of the law in the table of laws."""
        return self.answer.fit.law

    @property
    def table(self) -> pd.DataFrame:
        """All laws, the best one first: Akaike's criterion less that of the best, and the residuals."""
        laws = self.answer.fits
        columns = {
            "aicc": [it.aicc - laws[0].aicc for it in laws],
            "residual": [it.residual for it in laws],
            "reduced_chi_squared": [it.reduced_chi_squared for it in laws],
            "formula": [it.formula for it in laws],
        }
        return pd.DataFrame(columns, pd.Index([it.law for it in laws], name="law"))

    @property
    def parameters(self) -> pd.DataFrame:
        """Value and standard error of each parameter, in SI units: those of ``answer.fit.units``."""
        best = self.answer.fit
        columns = {"value": best.values, "standard_error": best.standard_errors}
        return pd.DataFrame(columns, pd.Index(best.names, name="parameter"))

    @property
    def covariance(self) -> pd.DataFrame:
        """Covariance of the parameters."""
        best = self.answer.fit
        return pd.DataFrame(best.covariance, list(best.names), list(best.names))

    @property
    def residuals(self) -> pd.Series:
        """Readings less the law, by slip speed."""
        return pd.Series(self.answer.residuals, pd.Index(self.answer.slip_speeds, name="slip_speed"), name="residual")

    def _repr_html_(self) -> str:
        found = self.answer
        read = "".join(f"<p>{html.escape(phrase)}</p>" for phrase in found.read)
        law = f"<p><b>{html.escape(self.name)}</b>: {html.escape(found.fit.formula)}</p>{self.law._curve()}"
        more = found.about_as_good
        also = f"{more} more law{' is' if more == 1 else 's are'} about as good: take each with law=.., and compare the answers"
        tables = (self.parameters.assign(unit=found.fit.units), self.table)
        parameters, laws = (table.to_html(float_format="{:.4g}".format, index_names=False) for table in tables)
        return f"{read}{law}{parameters}<p>{also if more else 'no other law is about as good'}</p>{laws}"
