"""The native part: results as the JSON of the command's `--json`. Use `ridgetone` instead."""

from os import PathLike

import numpy as np
import numpy.typing as npt

__version__: str

class Error(Exception): ...
class UsageError(Error): ...

class Samples:
    name: str
    @staticmethod
    def file(path: str | PathLike[str], time_column: str | None, flatten: bool = False, has_columns: bool = False) -> Samples: ...
    @staticmethod
    def array(name: str, names: list[str], values: object, times: object | None, beside: dict[str, object] | None) -> Samples: ...
    def read(self) -> tuple[list[str], bytearray | None, bytearray, str | None]: ...

def time_unit(unit: str) -> float | None: ...
def is_time(name: str) -> bool: ...
def declared_unit(name: str) -> float | None: ...

class Fitted:
    def picture(self) -> str: ...

class Board:
    def __new__(
        cls,
        port: str | None,
        usb_serial: str | None,
        emulated: bool,
        scene: str | PathLike[str] | None,
        once: bool,
        pace: float,
        elf: str | PathLike[str] | None,
        raw: bool,
        settings: str | None,
        record: str | PathLike[str] | None,
    ) -> Board: ...
    def next(self, most_s: float) -> tuple[str, str] | None: ...
    def settings(self) -> str: ...
    def change(self, changes: str, keep: bool) -> None: ...
    def command(self, name: str) -> None: ...
    def counts(self) -> tuple[int, int, int]: ...
    def close(self) -> None: ...

def fit(
    samples: Samples,
    rate_hz: float | None,
    from_s: float | None,
    to_s: float | None,
    columns: list[str],
    harmonics: int | None,
    mains_hz: float | None,
    speed_column: str | None,
    position_column: str | None,
    positions: str | PathLike[str] | None,
    whole: bool,
    mm_per_count: float | None,
    min_hz: float | None,
    max_hz: float | None,
    exclude: list[str],
    moving_speed: bool,
) -> tuple[str, list[str], Fitted]: ...
def feel(
    spectra_um: npt.NDArray[np.float32], measured_s: float, sigma_fraction: float, m: tuple[float, float] | None
) -> list[tuple[str, tuple[float, float] | None, str | None]]: ...
def volts_per_um(
    amplitudes: list[list[float]],
    spectra: npt.NDArray[np.float32],
    measured_s: float,
    surface: dict[str, float],
) -> list[tuple[float, float] | None]: ...
def replay(
    samples: Samples | None,
    scene: str | PathLike[str] | None,
    rate_hz: float | None,
    scale: float,
    seed: int | None,
    settings: str,
    picture: bool,
) -> tuple[list[str], list[str], str | None]: ...
def settings(file: str | PathLike[str] | None, changes: str) -> str: ...
def messages(path: str | PathLike[str]) -> list[str] | None: ...
