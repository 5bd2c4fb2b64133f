"""Statistics of recordings of Acconeer's A121, a pulsed coherent radar at 60 GHz, as `cargo sim profile --statistics`
prints them of chirps: noise, phase, and the fluctuation of echoes (docs/design/real-signals.md).

    pip install numpy h5py
    python3 python/examples/a121.py RECORDING.h5...

Each sub-sweep has a pulse, a step and a gain of its own, and a block of its own. Sweeps stand in the place of chirps,
points (ranges) in that of bins; levels are dB of one count of the sensor. Noise is half the power of the difference of
two successive sweeps of a frame; where a frame holds one sweep, of two successive frames.
"""

import json
import sys

import h5py
import numpy as np

EMPTY = 1.6  # power of a point over its noise up to which it holds no echo: 2 dB
HUNDREDTH = np.log(100)  # multiple of its mean that exponential power exceeds in one of a hundred cases
LEAKAGE_M = 0.08  # reach of the direct path between the antennas with the shortest pulse


def db(power):
    return 10 * np.log10(np.maximum(power, 1e-3))


def sweeps(path):
    """Yields name, ranges in metres and samples (frames, sweeps, points) of each sub-sweep of the first session."""
    with h5py.File(path) as file:
        entry = file["sessions/session_0/group_0/entry_0"]
        base = json.loads(entry["metadata"][()])["base_step_length_m"]
        config = json.loads(file["sessions/session_0/session_config"][()])
        raw = entry["result/frame"][()]
    x = raw["real"].astype(float) + 1j * raw["imag"]
    (sensor,) = config["groups"][0].values()
    first = 0
    for sub in sensor["subsweeps"]:
        points = np.arange(sub["num_points"])
        ranges = base * (sub["start_point"] + sub["step_length"] * points)
        name = f"{sub['profile'].lower().replace('_', ' ')}, {100 * base * sub['step_length']:.1f} cm a point"
        yield name, ranges, x[:, :, first : first + len(points)]
        first += len(points)


def noise_lines(x, pairs, noise):
    """Statistics of the points without an echo."""
    power = (abs(x) ** 2).mean((0, 1))
    empty = np.flatnonzero(power < EMPTY * noise)
    if len(empty) < 3:
        return []
    d = pairs[:, empty]
    relative = (abs(d) ** 2 / (abs(d) ** 2).mean(0)).ravel()
    both = empty[:-1][np.diff(empty) == 1]
    a, b = pairs[:, both], pairs[:, both + 1]
    along = abs((b * a.conj()).sum()) / (0.5 * (abs(a) ** 2 + abs(b) ** 2)).sum() if len(both) else np.nan
    still = x[..., empty] - x[..., empty].mean((0, 1))
    still = still if x.shape[1] > 1 else still.swapaxes(0, 1)
    a, b = still[:, :-1], still[:, 1:]
    sweeps = (b * a.conj()).real.sum() / (0.5 * (abs(a) ** 2 + abs(b) ** 2)).sum()
    return [
        f"noise of {len(empty)} points, {relative.size} values          theory",
        f"  power, dB                         {db(noise[empty].mean()):7.1f}",
        f"  mean over median of power         {relative.mean() / np.median(relative):7.3f}     {1 / np.log(2):.3f}",
        f"  above 4.6 times the mean, %       {100 * (relative > HUNDREDTH).mean():7.2f}     1.00",
        f"  correlation of neighbours         {along:7.3f}",
        f"  correlation of successive sweeps  {sweeps:7.3f}     0.000",
    ]


def echo_line(name, x, ranges, k, noise, floor):
    """Level and phase of point `k` over time."""
    z = x[..., k]
    sums = z.sum(1)
    runs = z if x.shape[1] > 2 else z.reshape(1, -1)
    bends = np.angle(runs[:, 2:] * runs[:, :-2] * runs[:, 1:-1].conj() ** 2)
    power = (abs(z) ** 2).mean()
    changes = np.angle(sums[1:] * sums[:-1].conj())
    # Fluctuation about the mean echo: 1 if it is exponential, as that of many scatterers.
    moving = abs(z - z.mean()) ** 2
    return (
        f"{name:15} {ranges[k]:6.3f} {db(power):6.1f} {db(power / floor):6.1f} {db(noise[k] / floor):+7.1f}   "
        f"{np.sqrt((bends**2).mean() / 6):8.5f}  {np.sqrt(floor / (2 * power)):8.5f}    "
        f"{np.sqrt((changes**2).mean()):8.5f} {np.sqrt((np.diff(db(abs(sums) ** 2)) ** 2).mean()):8.3f}   "
        f"{db(moving.mean() / power):6.1f} {moving.std() / moving.mean():6.2f}"
    )


def report(path):
    for name, ranges, x in sweeps(path):
        frames, per_frame, points = x.shape
        if points < 3:
            continue
        runs = x if per_frame > 1 else x.swapaxes(0, 1)
        even = runs[:, : runs.shape[1] // 2 * 2]
        pairs = ((even[:, 1::2] - even[:, ::2]) / np.sqrt(2)).reshape(-1, points)
        noise = np.median(abs(pairs) ** 2, 0) / np.log(2)
        power = (abs(x) ** 2).mean((0, 1))
        print(f"\n{path.rsplit('/', 1)[-1]}, {name}, {ranges[0]:.2f} to {ranges[-1]:.2f} m: {frames} frames of {per_frame}")
        print("\n".join(noise_lines(x, pairs, noise)))
        empty = power < EMPTY * noise
        floor = noise[empty].mean() if empty.any() else noise.min()
        print("                 range  power  over    noise    phase, rad rms        frame to frame       about the mean")
        print("                m      dB     noise   there    sweeps    by noise    rad rms   dB rms   dBc    std/mean")
        near = ranges < LEAKAGE_M
        change = (abs(x - x.mean((0, 1))) ** 2).mean((0, 1))
        rows = ("leakage", near, power), ("strongest echo", ~near, power), ("most changing", ~near, change)
        for row, where, what in rows:
            if where.any():
                k = np.flatnonzero(where)[what[where].argmax()]
                print(echo_line(row, x, ranges, k, noise, floor))


if __name__ == "__main__":
    for argument in sys.argv[1:]:
        report(argument)
