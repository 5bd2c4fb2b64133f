"""The compiled half: plain objects and arrays. Use the package's functions."""

from typing import Any

import numpy.typing as npt

FULL_SCALE: int
DB_PER_UNIT: float
MAX_STEPS: int
REVISION: str

def replay(path: str, scan: int | None, options: dict[str, Any]) -> list[dict[str, Any]]: ...
def scan(numbers: npt.NDArray[Any], angles_deg: list[float], config: dict[str, Any]) -> dict[str, Any]: ...
def read(path: str) -> dict[str, Any]: ...
def defaults() -> dict[str, Any]: ...
