"""What the tests share: recordings, and the host tool as the independent other side."""

import json
import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def full_scans(meta):
    """Whether a recording holds full scans, and not sweeps of the guard."""
    return "stairscan:mode" not in json.loads(meta.read_text())["global"]


RECORDINGS = sorted(
    meta.with_suffix("") for meta in (ROOT / "recordings").glob("*.sigmf-meta") if full_scans(meta)
)


@pytest.fixture(scope="session")
def host_sim():
    """Runs a command of the host tool and returns what it prints; a fault's exit status is no failure."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = Path(os.environ.get("STAIRSCAN_HOST_SIM", target / "release" / "host-sim"))
    if not program.exists():
        message = f"{program} is missing: cargo build --release --package host-sim"
        if os.environ.get("CI"):
            pytest.fail(message)
        pytest.skip(message)

    def run(*args, fails=False):
        done = subprocess.run([program, *args], capture_output=True, text=True, check=False, cwd=ROOT)
        assert fails or not done.stderr, done.stderr
        return done.stderr if fails else done.stdout

    return run


@pytest.fixture(scope="session", params=RECORDINGS, ids=lambda path: path.name)
def recording(request):
    """Path of each recording of the repository, without suffix."""
    return request.param


@pytest.fixture(scope="session")
def stair_a():
    """Path of one of them."""
    return ROOT / "recordings" / "stair_a"


def same(a, b):
    """Whether two results are the same to the last bit, but for name and number of the scan."""
    arrays = ["map", "detected", "present", "angles_deg", "ranges_m", "echoes", "way"]
    pairs = [(getattr(a, name), getattr(b, name)) for name in arrays]
    if a.posterior is not None and b.posterior is not None:
        parts = ["counts", "particles", "hypotheses"]
        pairs += [(getattr(a.posterior, name), getattr(b.posterior, name)) for name in parts]
    return (
        a.answer.sentences == b.answer.sentences
        and (a.posterior is None) == (b.posterior is None)
        and all(x.dtype == y.dtype and x.tobytes() == y.tobytes() for x, y in pairs)
    )
