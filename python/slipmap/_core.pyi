from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

_Reals = NDArray[np.float64]
_Codes = NDArray[np.int8]

__all__ = [
    "FIELDS",
    "Law",
    "METHODS",
    "Machine",
    "Map",
    "OWN_QUANTITIES",
    "REGIMES",
    "USUAL_METHODS",
    "SCHEMA",
    "VERDICTS",
    "__version__",
    "backbone",
    "compute_map",
    "critical_c",
    "curves",
    "fit",
    "influence",
    "measured",
    "orbit",
    "probe",
    "regime",
    "run_config",
    "sensitivity",
    "share",
    "verdicts",
    "with_deviation",
]

__version__: str
SCHEMA: int
VERDICTS: list[tuple[str, int]]
REGIMES: list[tuple[str, int, str]]
METHODS: list[tuple[str, str, str, str]]
USUAL_METHODS: list[str]
FIELDS: list[str]
OWN_QUANTITIES: list[str]

@final
class Law:
    @staticmethod
    def built_in(name: str) -> Law: ...
    @staticmethod
    def expression(formula: str, static_level: float | None, at_peak: bool) -> Law: ...
    @staticmethod
    def table(
        u: _Reals, friction: _Reals, errors: _Reals | None, static_level: float | None, at_peak: bool, origin: str
    ) -> Law: ...
    @staticmethod
    def function(function: Callable[[float], float], fastest: float, corners: list[float], origin: str) -> Law: ...
    def with_exponent(self) -> Law: ...
    def with_drop(self) -> Law: ...
    @staticmethod
    def from_definition(name: str, definition: str) -> Law: ...
    def read_as_small(self) -> Law: ...
    @property
    def is_read_as_small(self) -> bool: ...
    @property
    def name(self) -> str: ...
    @property
    def has_standard_errors(self) -> bool: ...
    @property
    def definition(self) -> str: ...
    @property
    def parameters(self) -> list[tuple[str, str, float, float, str]]: ...
    @property
    def needs_epsilon(self) -> bool: ...
    @property
    def told(self) -> str | None: ...
    def unit_of(self, quantity: str, motion: str, normal: str) -> str | None: ...
    def number_of(
        self, text: str, quantity: str, motion: str, normal: str, radius: float | None
    ) -> tuple[float, str]: ...
    @property
    def formula(self) -> str | None: ...
    @property
    def axes(self) -> list[str]: ...
    @property
    def error(self) -> float: ...
    def __reduce__(self) -> tuple[Callable[[str, str], Law], tuple[str, str]]: ...
    def evaluate(self, u: _Reals, epsilon: float, parameters: list[float]) -> tuple[_Reals, _Reals]: ...

@final
class Machine:
    def __new__(
        cls,
        law: Law,
        motion: str,
        quantities: dict[str, float],
        uncertain: list[tuple[str, list[float]]],
        written: dict[str, tuple[str, float]],
    ) -> Machine: ...
    @staticmethod
    def from_toml(path: str, values: list[tuple[str, float | str]]) -> Machine: ...
    @property
    def motion(self) -> str: ...
    @property
    def friction(self) -> Law: ...
    @property
    def quantities(self) -> list[tuple[str, float]]: ...
    @property
    def holds_forces(self) -> bool: ...
    @property
    def written(self) -> dict[str, tuple[str, float]]: ...
    @property
    def uncertain(self) -> list[tuple[str, list[float]]]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def doubts(self) -> list[str]: ...
    def point(self) -> tuple[Law, list[float], list[float]]: ...
    def probe(self, tolerance: float) -> str: ...
    def risk(self, draws: int | None, rare: list[float], seconds: float | None) -> str: ...
    def page(self, title: str, draws: int | None, rare: list[float]) -> tuple[str, str]: ...
    def explorer(self, title: str) -> str: ...
    def behaviour(
        self,
        names: list[str],
        arrays: list[_Reals],
        all: bool,
        tolerance: float,
        threads: int | None,
        progress: Callable[[int], None] | None,
    ) -> tuple[_Codes, list[_Reals]]: ...
    def critical_damping(
        self,
        names: list[str],
        arrays: list[_Reals],
        tolerance: float,
        by_friction: bool,
        threads: int | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> tuple[_Reals, _Reals, tuple[int, str] | None]: ...

def with_deviation(text: str) -> tuple[str, str] | None: ...
def share(text: str) -> float | None: ...
def critical_c(
    law: Law,
    arrays: list[_Reals],
    tolerance: float,
    threads: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> tuple[_Reals, _Reals]: ...
def verdicts(
    law: Law, arrays: list[_Reals], methods: list[str], tolerance: float, threads: int | None = None
) -> _Codes: ...
def regime(law: Law, arrays: list[_Reals], tolerance: float, threads: int | None = None) -> _Codes: ...
def backbone(
    law: Law, arrays: list[_Reals], amplitudes: list[float], tolerance: float, threads: int | None = None
) -> tuple[_Reals, _Reals]: ...
def sensitivity(law: Law, arrays: list[_Reals], threads: int | None = None) -> tuple[_Reals, _Reals]: ...
def influence(law: Law, values: list[float], parts: int) -> tuple[_Reals, _Reals]: ...
def probe(law: Law, values: list[float], tolerance: float) -> str: ...
def orbit(
    law: Law, values: list[float], start: tuple[float, float] | None, tolerance: float, max_time: float
) -> tuple[_Reals, _Reals, _Reals, _Codes, str, float | None]: ...
def curves(
    law: Law, nodes: list[list[float]], x: int, y: int, threads: int | None
) -> list[tuple[str, _Reals, _Reals, _Reals]]: ...

def measured(
    name: str,
    rows: bytes,
    static_level: float | None,
    at_peak: bool,
    forces: bool | None,
    kind: str | None,
    direction: str | None,
    column: str | None,
) -> tuple[Law, bool]: ...
def fit(
    name: str,
    rows: bytes,
    law: str | None,
    forces: bool | None,
    kind: str | None,
    direction: str | None,
    column: str | None,
) -> tuple[Law, str, str]: ...

_Attributes = dict[str, Any]

@final
class Map:
    @property
    def axes(self) -> list[tuple[str, _Attributes, _Reals]]: ...
    @property
    def pieces(self) -> list[tuple[str, _Attributes, NDArray[Any]]]: ...
    @property
    def variables(self) -> list[tuple[str, _Attributes, NDArray[Any]]]: ...
    @property
    def attributes(self) -> _Attributes: ...
    @property
    def tile_shape(self) -> list[int]: ...
    @property
    def curves(self) -> list[tuple[str, str, _Attributes, NDArray[Any]]] | None: ...

def compute_map(
    law: Law,
    nodes: list[list[float]],
    methods: list[str] | None,
    fields: list[str],
    tolerance: float,
    audit_cells: int,
    proof_boxes: int,
    threads: int | None,
    progress: Callable[[int], None] | None,
) -> Map: ...
def run_config(
    path: str, sets: list[str], threads: int | None, progress_of: Callable[[int], Callable[[int], None] | None]
) -> Map: ...
