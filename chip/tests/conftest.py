"""What the tests share: the image and loader that are flashed, a board around the model, and no complaint."""

import os
import pathlib
import pickle
import subprocess
import sys
import traceback

import pytest

CHIP = pathlib.Path(__file__).resolve().parent.parent
ROOT = CHIP.parent
sys.path.insert(0, str(CHIP))

from board.shaft import Shaft  # noqa: E402
from board.terminal import Terminal  # noqa: E402
from model.chip import Chip  # noqa: E402

FIRMWARE = pathlib.Path(os.environ.get("STAIRSCAN_FIRMWARE", ROOT / "target/thumbv7em-none-eabihf/firmware"))
PROGRAM = os.environ.get("STAIRSCAN_HOST_SIM", str(ROOT / "target/release/host-sim"))


class Bench:
    """A chip with loader and image on its board, without power."""

    def __init__(self, seed=1, image="stairscan", **options):
        self.chip = Chip(seed, verbose=bool(os.environ.get("VERBOSE")), **options)
        self.chip.load(FIRMWARE / "stairscan-boot")
        if image:
            self.chip.load(FIRMWARE / image)
        self.shaft = Shaft(self.chip)
        self.terminal = Terminal(self.chip)

    def boot(self, length=5.0):
        """Power, and the image's first sentence."""
        self.chip.power_on()
        return self.terminal.wait("BOOT", length=length)


@pytest.fixture
def bench(request):
    """Makes benches; at the end none of them may have complained, unless the test has emptied the list."""
    made = []

    def make(**options):
        made.append(Bench(**options))
        return made[-1]

    yield make
    for each in made:
        assert not each.chip.complaints, dict(each.chip.complaints)


def replay(recording):
    """The sentences of `cargo sim replay`."""
    output = subprocess.run([PROGRAM, "replay", str(recording)], capture_output=True, text=True, check=True).stdout
    return [line.strip() for line in output.splitlines() if line.strip().startswith("$PSTR")]


def fields(line):
    """The fields of a sentence, `PSTR` the first."""
    return line.partition("*")[0].lstrip("$").split(",")


def in_fork(call):
    """The result of `call` in a copy of this process: what it does to a bench stays there.

    A chip is as it was afterwards, however far the copy has gone: a snapshot.
    """
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        try:
            result = (True, call())
        except BaseException:
            result = (False, traceback.format_exc())
        with os.fdopen(writer, "wb") as file:
            pickle.dump(result, file)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as file:
        good, result = pickle.load(file)
    os.waitpid(child, 0)
    assert good, result
    return result
