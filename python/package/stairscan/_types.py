"""Types of inputs and results."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _stairscan

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

#: An echo: a point scatterer below the size of a cell. ``x_m`` forward from the mirror's centre, ``y_m`` up from the
#: ground, ``width`` of its lobe over the angle in units of a point's, ``role`` under the answer,
#: ``against``: whether it contradicts the answer.
ECHO = np.dtype(
    [
        ("x_m", "<f4"),
        ("y_m", "<f4"),
        ("range_m", "<f4"),
        ("range_sigma_m", "<f4"),
        ("angle_rad", "<f4"),
        ("angle_sigma_rad", "<f4"),
        ("snr_db", "<f4"),
        ("width", "<f4"),
        ("role", "<U12"),
        ("against", "?"),
    ]
)

#: A particle of the posterior. ``kind``: ``stairs``, ``descent``, ``nothing``, ``ramp``, ``drop``, ``box`` or ``threshold``;
#: ``at_m``: start of a ramp or place of a drop; ``wall_m``: infinite without a wall; ``x_m`` and ``top_m``: place
#: of each riser and level at its top, NaN after the last.
PARTICLE = np.dtype(
    [
        ("probability", "<f4"),
        ("kind", "<U12"),
        ("steps", "u1"),
        ("open", "?"),
        ("overhang_m", "<f4"),
        ("wall_m", "<f4"),
        ("at_m", "<f4"),
        ("slope", "<f4"),
        ("x_m", "<f4", (_stairscan.MAX_STEPS,)),
        ("top_m", "<f4", (_stairscan.MAX_STEPS,)),
    ]
)

#: A hypothesis: particles with the same visible steps. ``edges``: distance and height of each visible edge, NaN after
#: the last.
HYPOTHESIS = np.dtype(
    [
        ("name", "<U80"),
        ("probability", "<f8"),
        ("edges", "<f8", (_stairscan.MAX_STEPS, 2)),
    ]
)

#: A cell of the path ahead. ``right``: probability that the answer is correct from the mirror to the cell's end, from
#: this scan alone; ``asked``: minimum probability for the horizon to include the cell, above 1 if none suffices.
WAY = np.dtype([("end_m", "<f4"), ("right", "<f4"), ("asked", "<f4")])


@dataclass(frozen=True)
class Config:
    """Configuration of a scan. Defaults are the firmware's; limits are those of docs/user/hardware.md."""

    bandwidth_hz: float = 10e9
    """Swept bandwidth of the chirp."""
    carrier_hz: float = 94e9
    """Centre frequency of the chirp."""
    sample_rate_hz: float | None = None
    """Rate of the samples: complex ones, or real ones if ``real`` is set."""
    real: bool = False
    """Whether the radar samples one channel: real samples instead of I and Q."""
    plane: str = "depth"
    """``depth``: angles from the horizontal, positive downwards; ``height``: angles from straight down, positive
    towards the front."""
    mirror_offset_m: float = 0.22
    """Radar lens to mirror centre."""
    mount_height_m: float = 0.4
    """Mirror centre above the ground that the chair stands on."""
    beamwidth_deg: float = 5.0
    """Two-sided 3 dB width of the beam that leaves the mirror."""
    first_angle_deg: float = -20.0
    """Angle of the first row, if ``scan`` is given no angles."""
    angle_step_deg: float = 0.25
    """Angle between rows, if ``scan`` is given no angles."""
    mirror_echo_m: float = 0.0
    """Range of the mirror's own echo at the calibration; 0: not calibrated."""
    mirror_level_db: float = 0.0
    """Level of that echo, dBFS; 0: not calibrated."""
    range_scale_ppm: int = 0
    """Excess of ranges over those from ``bandwidth_hz``, parts per million."""
    cfar_guard_cells: int = 3
    """Guard cells on each side of the cell under test."""
    cfar_training_cells: int = 8
    """Training cells on each side, beyond the guard cells."""
    cfar_false_alarm: float = 1.7e-4
    """False-alarm probability of CA-CFAR in a cell of noise."""
    cfar_near_margin_m: float = 0.15
    """Ranges up to this distance beyond the mirror are left out."""
    particles: int = 1000
    """Number of particles of the paper's estimator."""
    modes: int = 10
    """Number of Gaussian modes of their initial distribution."""
    spread: str = "gmm-cfar"
    """Their initial distribution: ``uniform``, ``gmm-raw`` or ``gmm-cfar``."""
    rounds: int = 2
    """Number of rounds of resampling."""
    mode_sigma_m: float = 0.08
    """Standard deviation of a mode."""
    vigilance: float = 0.5
    """Vigilance of Fuzzy ART, 0 to 1."""
    estimator: str = "likelihood"
    """``likelihood``, or ``paper``: the estimator of the paper."""
    seed: int = 0
    """Seed of the paper's particles. ``cargo sim replay`` and :func:`stairscan.replay` use 1."""


@dataclass(frozen=True)
class Step:
    """A step of the answer. Sigmas are standard deviations."""

    distance_m: float
    """Horizontal distance from the mirror's centre to the foremost edge."""
    height_m: float
    """Height of the tread above the ground that the chair stands on."""
    tread_m: float | None
    """Depth of the tread up to the next edge; None for the last."""
    riser_m: float | None
    """Height of the riser; None if the previous level is unknown."""
    distance_sigma_m: float
    height_sigma_m: float
    quality: int
    """Detection quality of the step, 0 to 100."""


@dataclass(frozen=True)
class Drop:
    """Edge at which the ground ends, without reported downward stairs."""

    distance_m: float
    distance_sigma_m: float
    depth_m: float | None
    """Depth of the next surface; None if unknown."""
    probability: float


@dataclass(frozen=True)
class Maybe:
    """A possible step or drop that is not part of the answer."""

    distance_m: float
    height_m: float
    """Height above the ground; negative for a possible end of the ground."""
    probability: float


@dataclass(frozen=True)
class Answer:
    """The scanner's report of a scan."""

    recording: str
    scan: int
    """Number of the scan, from 1."""
    status: Literal["ok", "degraded", "fault"]
    direction: Literal["up", "down", "none"]
    reasons: tuple[str, ...]
    """Reasons that prevent ``ok``, and weaknesses of an ``ok`` answer: words of docs/reasons.md."""
    horizon_m: float | None
    """The answer is valid from the mirror up to here."""
    free_m: float | None
    """Free distance ahead; None if there is none."""
    confidence: float | None
    """Probability that nothing is wrong up to the horizon, or over the first metre if that is farther."""
    steps: tuple[Step, ...]
    drop: Drop | None
    maybes: tuple[Maybe, ...]
    ground: tuple[tuple[float, float], ...]
    """Where the ground bends, metres from the mirror, and its slope from there on; empty for level ground."""
    lost_rows: int
    sentences: tuple[str, ...] = field(repr=False)
    """The sentences of the UART, without line ends."""
    summary: str = field(repr=False)
    """Summary in one line."""
    text: str = field(repr=False)
    """Sentences and a text table, as ``cargo sim replay`` prints them."""

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, eq=False)
class Posterior:
    """Posterior of one scan alone."""

    counts: Float32
    """Probability by number of steps, from 0."""
    particles: npt.NDArray[np.void]
    """Weighted staircases, dtype :data:`PARTICLE`."""
    hypotheses: npt.NDArray[np.void]
    """Particles grouped by their visible steps, likeliest first, dtype :data:`HYPOTHESIS`."""


@dataclass(frozen=True, eq=False)
class Result:
    """Result of a scan: the answer, and the data that it is based on."""

    answer: Answer
    config: Config = field(repr=False)
    """Configuration of the scanner."""
    map: npt.NDArray[np.uint8] = field(repr=False)
    """Polar map, rows (angles) × range bins: logarithmic power as in the chip, 1/8 octave a unit."""
    detected: npt.NDArray[np.bool_] = field(repr=False)
    """Whether the cell passes the CA-CFAR."""
    present: npt.NDArray[np.bool_] = field(repr=False)
    """Whether the row's chirp was received."""
    angles_deg: Float32 = field(repr=False)
    """Beam angle of each row, as defined by ``config.plane``."""
    ranges_m: Float32 = field(repr=False)
    """Range of each bin from the mirror's centre."""
    echoes: npt.NDArray[np.void] = field(repr=False)
    """Echoes, strongest first, dtype :data:`ECHO`; none with the paper's estimator."""
    posterior: Posterior | None = field(repr=False)
    """None with the paper's estimator, and without echoes."""
    way: npt.NDArray[np.void] = field(repr=False)
    """The path ahead by cells, nearest first, dtype :data:`WAY`."""
    noise_dbfs: float | None
    """Median of the filtered map."""
    angle_bias_deg: float | None
    """Error of the angles from this scan's ground, which the answer corrects; 0 without visible ground."""
    mount_height_error_m: float | None
    """Error of the mount height from this scan's ground, which the answer corrects; 0 without visible ground."""

    @property
    def map_dbfs(self) -> Float32:
        """The map in dBFS; rows whose chirp was lost are NaN."""
        units = self.map.astype(np.float32) - np.float32(_stairscan.FULL_SCALE)
        power = units * np.float32(_stairscan.DB_PER_UNIT)
        power[~self.present] = np.nan
        return power

    @property
    def places_m(self) -> tuple[Float64, Float64]:
        """Distance and height of each cell of the map, two arrays of its shape."""
        angle = np.radians(self.angles_deg.astype(np.float64))[:, np.newaxis]
        along, across = np.cos(angle), np.sin(angle)
        if self.config.plane == "height":
            along, across = across, along
        ranges = self.ranges_m.astype(np.float64)
        return along * ranges, self.config.mount_height_m - across * ranges


@dataclass(frozen=True, eq=False)
class Recording:
    """A recording in memory."""

    name: str
    iq: npt.NDArray[np.int16] = field(repr=False)
    """I and Q, shape (chirps, samples, 2), full scale 32768; real samples consecutively."""
    angles_deg: Float64 = field(repr=False)
    """Beam angle of each chirp, corrected for the chair's pitch; empty without a mirror."""
    scans: int
    """Number of consecutive scans, with equal numbers of chirps."""
    config: Config | None = field(repr=False)
    """Configuration of its samples, for :func:`stairscan.scan`; None if it cannot be scanned."""
    metadata: dict[str, Any] = field(repr=False)
    """The contents of its SigMF metadata file."""

    @property
    def samples(self) -> npt.NDArray[np.complex64]:
        """Return the samples as complex numbers (chirps, samples), full scale 1."""
        scaled = self.iq.astype(np.float32) / np.float32(32768)
        return scaled.view(np.complex64)[..., 0]

    def chirps_of(self, scan: int) -> slice:
        """Return the chirps of scan ``scan``, from 0."""
        each = len(self.iq) // self.scans
        return slice(scan * each, (scan + 1) * each)

    def truth(self, scan: int = 0) -> dict[str, Any] | None:
        """Return the ground truth of scan ``scan``, from 0; None if the recording does not contain it."""
        keys = self.metadata["global"]
        of_scans = keys.get("stairscan:truth_scans")
        if of_scans is not None:
            return dict(of_scans[scan])
        truth = keys.get("stairscan:truth") if self.scans == 1 else None
        return None if truth is None else dict(truth)
