"""A radar stair scanner for powered wheelchairs: recordings and arrays of samples in, answers and arrays out.

The scanner is the code that is flashed, run by the code of ``cargo sim replay``: the same samples give the same
sentences, bit for bit.

>>> import stairscan
>>> result = stairscan.replay("recordings/stair_a")
>>> result.answer.status, len(result.answer.steps)
('ok', 3)

Lengths are in metres, angles in degrees unless a name ends in ``_rad``, powers in decibels relative to a tone at the
converter's full scale (dBFS).
"""

from ._functions import read, replay, replay_all, scan
from ._stairscan import REVISION as revision
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

__all__ = [
    "ECHO",
    "HYPOTHESIS",
    "PARTICLE",
    "WAY",
    "Answer",
    "Config",
    "Drop",
    "Maybe",
    "Posterior",
    "Recording",
    "Result",
    "Step",
    "read",
    "replay",
    "replay_all",
    "revision",
    "scan",
]
