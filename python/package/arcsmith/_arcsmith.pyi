from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Protocol, final

from ._figures import Figures

class _ArrowStream(Protocol):
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

class _ArrowArray(Protocol):
    def __arrow_c_array__(self, requested_schema: object | None = None) -> tuple[object, object]: ...

_Path = str | PathLike[str]
_Recording = _Path | _ArrowStream | _ArrowArray | Mapping[str, Sequence[Any] | _ArrowStream | _ArrowArray]
_File = _Path | Mapping[str, Mapping[str, Any]]
_Map = Mapping[str, str] | Sequence[str]
_Model = Fit | Diagnosis | Coefficients | _Path | Mapping[str, Any]
_Option = str | float | bool | Sequence[str | float] | None

__all__ = [
    "ArcsmithError",
    "Coefficients",
    "Columns",
    "Diagnosis",
    "Fit",
    "Generated",
    "Rows",
    "__version__",
    "apply",
    "diagnose",
    "diagnose_batch",
    "fit",
    "generate",
    "main",
    "simulate",
]
__version__: str

class ArcsmithError(ValueError):
    """What was given is refused: one message, that of the program."""

    parts: dict[str, Any]

@final
class Coefficients:
    """The model of a sensor's error: what `apply` and `generate` take."""

    @property
    def order(self) -> int: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_json(self) -> str: ...
    def write(self, path: _Path) -> None: ...

@final
class Columns:
    """Columns of numbers, row for row of what was given."""

    @property
    def columns(self) -> list[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def summary(self) -> dict[str, Any]: ...
    def to_dict(self) -> dict[str, list[float]]: ...
    def plot(self) -> Figures: ...
    def write(self, path: _Path) -> None: ...
    def _repr_html_(self) -> str: ...
    def __getitem__(self, key: str, /) -> list[float]: ...
    def __len__(self) -> int: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

@final
class Fit:
    """A fit: the order that was chosen, the coefficients, and what they leave."""

    @property
    def coefficients(self) -> Coefficients: ...
    @property
    def order(self) -> int: ...
    @property
    def harmonics(self) -> int | None: ...
    @property
    def unit(self) -> str: ...
    @property
    def before_rms(self) -> float | None: ...
    @property
    def after_rms(self) -> float | None: ...
    @property
    def notes(self) -> list[str]: ...
    def to_dict(self) -> dict[str, Any]: ...
    def report(self) -> str: ...
    def plot(self) -> Figures: ...
    def write(self, path: _Path) -> None: ...
    def _repr_html_(self) -> str: ...

@final
class Diagnosis:
    """What a recording says of its simulation: where it differs, what explains it, and whether the fit improves."""

    @property
    def verdict(self) -> Literal["consistent", "explained", "described", "partly_explained", "unexplained"]: ...
    @property
    def effects(self) -> list[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def coefficients(self) -> Coefficients | None: ...
    @property
    def plant(self) -> str | None: ...
    @property
    def simulated(self) -> Columns | None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def to_json(self) -> str: ...
    def report(self) -> str: ...
    def plot(self) -> Figures: ...
    def _repr_html_(self) -> str: ...

@final
class Generated:
    """Routines with their proven bounds: nothing is written before `write`."""

    @property
    def files(self) -> dict[str, str]: ...
    @property
    def certificate(self) -> dict[str, Any]: ...
    @property
    def notes(self) -> list[str]: ...
    def to_dict(self) -> dict[str, Any]: ...
    def write(self, folder: _Path) -> int: ...
    def _repr_html_(self) -> str: ...

def fit(
    recording: _Recording,
    mirror: _File,
    *,
    map: _Map | None = None,
    order: int | None = None,
    harmonics: int | None = None,
    splits: int = 100,
    held_out_percent: int = 30,
    seed: int = 1,
    solver: Literal["qr", "trust-region"] = "qr",
    average: bool = False,
    probe_distance_error: float | None = None,
    name: str | None = None,
) -> Fit:
    """Fit the angular error of a sensor, and choose the order of the model by cross-validation."""

def apply(
    recording: _Recording,
    coefficients: _Model,
    *,
    map: _Map | None = None,
    strict: bool = False,
    name: str | None = None,
) -> Columns:
    """Correct every row of a recording, which needs no reference."""

def diagnose(
    recording: _Recording,
    mirror: _File | None = None,
    *,
    plant: _File | None = None,
    map: _Map | None = None,
    effects: _Path | None = None,
    held_out: _Recording | None = None,
    simulated: _Recording | None = None,
    without: Sequence[str] | None = None,
    harmonics: int | None = None,
    order: int | None = None,
    turn_harmonics: int | None = None,
    name: str | None = None,
) -> Diagnosis:
    """Locate where a recording differs from its simulation, name the physics, and show that the fit improves."""

@final
class Rows:
    """Rows of a fleet's tables."""

    @property
    def columns(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

def diagnose_batch(
    batch: _ArrowStream | _ArrowArray | Mapping[str, Sequence[Any] | _ArrowStream | _ArrowArray],
    *,
    unit: str,
    mirror: _Path,
    lot: str | None = None,
    time: str | None = None,
    table: Literal["units", "parameters"] = "units",
    map: _Map | None = None,
    effects: _Path | None = None,
    without: Sequence[str] | None = None,
    harmonics: int | None = None,
    order: int | None = None,
    turn_harmonics: int | None = None,
) -> Rows:
    """Diagnose every unit of a table: the rows of one table of `arcsmith fleet`."""

def generate(coefficients: _Model, **options: _Option) -> Generated:
    """Generate the correction for firmware, in Rust and C, with a proven bound.

    The keywords are the options of `arcsmith generate`: `format="q31"`, `target="cortex-m4f"`, `bound_arcsec=0.01`,
    `fma=True` (floats with fused multiply-adds), ...
    """

def simulate(
    drive: _Recording,
    plant: _File,
    *,
    begin: Literal["recorded", "rest"] | None = None,
    name: str | None = None,
) -> Columns:
    """Run a plant, with all that was found in it, on the drive of a recording."""

def main(words: Sequence[str]) -> int:
    """Run the program with these words, its own path first, and return its exit code."""
