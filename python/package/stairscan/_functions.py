"""Scans of recordings and of arrays."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _stairscan
from ._types import (
    ECHO,
    HYPOTHESIS,
    PARTICLE,
    WAY,
    Answer,
    Config,
    Drop,
    Maybe,
    Posterior,
    Recording,
    Result,
    Step,
)

#: Maximum angle of the mirror's shaft, degrees.
_FARTHEST_DEG = 170.0
#: Minimum number of chirps of a scan.
_FEWEST = 3


def read(path: str | os.PathLike[str]) -> Recording:
    """Read a SigMF recording, named with or without suffix.

    Raises OSError if a file cannot be read, ValueError if its content is refused; both name file and key.
    """
    raw = _stairscan.read(_recording(path))
    config = raw["config"]
    return Recording(
        name=raw["name"],
        iq=raw["iq"],
        angles_deg=np.asarray(raw["angles_deg"], np.float64),
        scans=raw["scans"],
        config=None if config is None else Config(**config),
        metadata=json.loads(raw["metadata"]),
    )


def replay(
    path: str | os.PathLike[str],
    scan: int = 0,
    *,
    estimator: str = "likelihood",
    seed: int = 1,
    scans: int | None = None,
    backwards: bool = False,
    single: bool = False,
    motion: str | None = None,
) -> Result:
    """Scan a SigMF recording as ``cargo sim replay`` does, and return scan ``scan``, from 0.

    The scanner processes all scans up to that one, since it uses the evidence of earlier scans. The keywords are the
    options of the command: ``scans``: number of scans (a recording of one scan is repeated with alternating
    direction), ``backwards``: the mirror turns in the opposite direction, ``single``: each scan as if it were the
    first, ``motion``: mode without motion input, ``auto``, ``required`` or ``standing``.

    Raises OSError if a file cannot be read, ValueError if its content or an argument is refused.
    """
    options = _options(estimator, seed, scans, backwards, single, motion)
    if not 0 <= scan < 2**32:
        raise ValueError(f"scan: found {scan}, expected the number of a scan, from 0")
    return _result(_stairscan.replay(_recording(path), scan, options)[0])


def replay_all(
    path: str | os.PathLike[str],
    *,
    estimator: str = "likelihood",
    seed: int = 1,
    scans: int | None = None,
    backwards: bool = False,
    single: bool = False,
    motion: str | None = None,
) -> list[Result]:
    """Scan a SigMF recording as :func:`replay` does, and return all its scans."""
    options = _options(estimator, seed, scans, backwards, single, motion)
    return [_result(raw) for raw in _stairscan.replay(_recording(path), None, options)]


def scan(
    iq: npt.ArrayLike,
    angles: npt.ArrayLike | None = None,
    config: Config | None = None,
) -> Result:
    """Scan an array of samples: one scan at standstill.

    ``iq``: complex (chirps, samples) with full scale 1, or I and Q (chirps, samples, 2), int16 as from the converter
    or floating point with full scale 1; with ``config.real`` real samples (chirps, samples). 16 to 256 complex
    samples a chirp. An echo beats at a positive frequency. int16 is read without a copy, in one pass.

    ``angles``: angle of each chirp, degrees, strictly rising or falling in equal steps; a gap is a lost chirp.
    Without them the rows begin at ``config.first_angle_deg`` in steps of ``config.angle_step_deg``.

    Raises ValueError that names argument, index or field, the value and the expected value.
    """
    config = Config() if config is None else config
    if not isinstance(config, Config):
        raise TypeError(f"config: found {type(config).__name__}, expected Config")
    numbers = _pairs(iq, config.real)
    chirps = len(numbers)
    if chirps < _FEWEST:
        raise ValueError(f"iq: found {chirps} chirps, expected at least {_FEWEST} for a scan")
    degrees = _angles(angles, chirps, config)
    return _result(_stairscan.scan(numbers, degrees.tolist(), asdict(config)))


def _recording(path: str | os.PathLike[str]) -> str:
    """Return the path of a recording; arrays are refused."""
    name = os.fspath(path)
    if name.endswith((".npy", ".npz")):
        raise ValueError(f"{name}: an array, expected a SigMF recording: numpy.load it and call stairscan.scan")
    return name


def _options(
    estimator: str,
    seed: int,
    scans: int | None,
    backwards: bool,
    single: bool,
    motion: str | None,
) -> dict[str, Any]:
    return {
        "estimator": estimator,
        "seed": seed,
        "scans": scans,
        "backwards": backwards,
        "single": single,
        "motion": motion,
    }


def _pairs(iq: npt.ArrayLike, real: bool) -> npt.NDArray[Any]:
    """Return the samples as (chirps, samples, 2) of int16, float32 or float64, without a copy if possible."""
    array = np.asarray(iq)
    if real:
        shape = "real samples (chirps, samples), int16 or floating point"
        good = array.ndim == 2 and array.dtype.kind in "if"
    else:
        shape = "complex (chirps, samples), or I and Q (chirps, samples, 2), int16 or floating point"
        pairs = array.ndim == 3 and array.shape[2] == 2 and array.dtype.kind in "if"
        good = pairs or (array.ndim == 2 and array.dtype.kind == "c")
    good = good and (array.dtype.kind != "i" or array.dtype.itemsize == 2)
    if not good or array.dtype.itemsize // (2 if array.dtype.kind == "c" else 1) not in (2, 4, 8):
        raise ValueError(f"iq: found {array.dtype} of shape {array.shape}, expected {shape}")
    if array.dtype.kind == "f" and array.dtype.itemsize == 2:
        array = array.astype(np.float32)
    array = np.require(array, array.dtype.newbyteorder("="), ["C_CONTIGUOUS", "ALIGNED"])
    if real:
        chirps, values = array.shape
        if values % 2:
            raise ValueError(f"iq: found {values} real samples a chirp, expected an even number")
        return array.reshape(chirps, values // 2, 2)
    if array.dtype.kind == "c":
        part = np.float32 if array.dtype.itemsize == 8 else np.float64
        return array.view(part).reshape(*array.shape, 2)
    return array


def _angles(angles: npt.ArrayLike | None, chirps: int, config: Config) -> npt.NDArray[np.float64]:
    """Return the angle of each chirp, degrees."""
    if angles is None:
        degrees = config.first_angle_deg + config.angle_step_deg * np.arange(chirps, dtype=np.float64)
    else:
        try:
            degrees = np.asarray(angles, np.float64)
        except (TypeError, ValueError) as error:
            raise ValueError(f"angles: expected one number a chirp: {error}") from None
    if degrees.shape != (chirps,):
        raise ValueError(f"angles: found shape {degrees.shape}, expected ({chirps},): one a chirp")
    outside = np.flatnonzero(~(np.abs(degrees) <= _FARTHEST_DEG))
    if outside.size:
        k = outside[0]
        raise ValueError(f"angles[{k}]: found {degrees[k]}, expected degrees within ±{_FARTHEST_DEG:.0f}")
    steps = np.diff(degrees)
    turned = np.flatnonzero(steps * steps[0] <= 0)
    if turned.size:
        k = turned[0] + 1
        raise ValueError(f"angles[{k}]: found {degrees[k]} after {degrees[k - 1]}, expected strictly rising or falling")
    return degrees


def _answer(raw: dict[str, Any]) -> Answer:
    values = json.loads(raw["answer"])
    drop = values["drop"]
    return Answer(
        recording=values["recording"],
        scan=values["scan"],
        status=values["status"],
        direction=values["direction"],
        reasons=tuple(values["reasons"]),
        horizon_m=values["horizon_m"],
        free_m=values["free_m"],
        confidence=values["confidence"],
        steps=tuple(Step(**step) for step in values["steps"]),
        drop=None if drop is None else Drop(**drop),
        maybes=tuple(Maybe(**maybe) for maybe in values["maybe"]),
        ground=tuple((from_m, slope) for from_m, slope in values["ground"]),
        lost_rows=values["lost_rows"],
        sentences=tuple(raw["sentences"]),
        summary=raw["summary"],
        text=raw["text"],
    )


def _posterior(raw: dict[str, Any]) -> Posterior | None:
    if "counts" not in raw:
        return None
    values = json.loads(raw["hypotheses"])
    hypotheses = np.zeros(len(values), HYPOTHESIS)
    hypotheses["edges"] = np.nan
    for row, (name, probability, edges) in zip(hypotheses, values, strict=True):
        row["name"], row["probability"] = name, probability
        row["edges"][: len(edges)] = np.reshape(edges, (len(edges), 2))
    return Posterior(
        counts=raw["counts"],
        particles=raw["particles"].view(PARTICLE),
        hypotheses=hypotheses,
    )


def _result(raw: dict[str, Any]) -> Result:
    bias_deg, height_error_m = raw["calibration"] or (None, None)
    return Result(
        answer=_answer(raw),
        config=Config(**raw["config"]),
        map=raw["map"],
        detected=raw["detected"],
        present=raw["present"],
        angles_deg=raw["angles_deg"],
        ranges_m=raw["ranges_m"],
        echoes=raw["echoes"].view(ECHO),
        posterior=_posterior(raw),
        way=raw["way"].view(WAY)[:, 0],
        noise_dbfs=raw["noise_dbfs"],
        angle_bias_deg=bias_deg,
        mount_height_error_m=height_error_m,
    )
