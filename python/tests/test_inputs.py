"""What is taken, and what is refused with the name of what is wrong."""

import os
import re
import threading
from dataclasses import FrozenInstanceError, asdict, replace
from pathlib import Path

import numpy as np
import pytest
import stairscan
from conftest import same
from stairscan import Config, _stairscan


@pytest.fixture(scope="module")
def read(stair_a):
    return stairscan.read(stair_a)


def test_defaults_are_the_firmware_s():
    assert asdict(Config()) == _stairscan.defaults()


def test_every_field_reaches_the_scanner_and_comes_back(read):
    changed = replace(
        read.config,
        carrier_hz=77e9,
        sample_rate_hz=1e6,
        beamwidth_deg=6.0,
        mirror_echo_m=0.221,
        mirror_level_db=-20.5,
        range_scale_ppm=-150,
        cfar_guard_cells=2,
        cfar_training_cells=10,
        cfar_false_alarm=1e-3,
        cfar_near_margin_m=0.2,
        particles=500,
        modes=4,
        spread="uniform",
        rounds=15,
        mode_sigma_m=0.05,
        vigilance=0.25,
        estimator="paper",
        seed=2**32 - 1,
    )
    assert stairscan.scan(read.iq, read.angles_deg, changed).config == changed


def test_a_mount_height_that_is_wrong_is_noticed(read):
    wrong = replace(read.config, mount_height_m=0.44)
    answer = stairscan.scan(read.iq, read.angles_deg, wrong).answer
    assert answer.status == "degraded" and "mount" in answer.reasons and answer.horizon_m == 0


def test_a_missing_angle_is_a_lost_chirp(read):
    iq, angles = np.delete(read.iq, 7, 0), np.delete(read.angles_deg, 7)
    result = stairscan.scan(iq, angles, read.config)
    assert result.answer.lost_rows == 1 and "lost-rows" in result.answer.reasons
    assert not result.present[7] and result.present.sum() == 280
    assert np.isnan(result.map_dbfs[7]).all() and not np.isnan(result.map_dbfs[8]).any()


def test_any_layout_of_the_same_samples_gives_the_same(read):
    result = stairscan.scan(read.iq, read.angles_deg, read.config)
    unaligned = np.frombuffer(b"_" + read.iq.tobytes(), np.int16, offset=1).reshape(read.iq.shape)
    for iq in (
        unaligned,
        np.asfortranarray(read.iq),
        read.iq.astype(">i2"),
        read.iq.astype(np.float32) / np.float32(32768),
        read.samples,
        np.asfortranarray(read.samples.astype(">c16")),
    ):
        assert same(stairscan.scan(iq, read.angles_deg, read.config), result)
    # From the last angle to the first: the same map, row by row.
    back = stairscan.scan(read.iq[::-1], read.angles_deg[::-1], read.config)
    assert (back.map == result.map).all()


def test_a_scan_leaves_its_input_alone(read):
    iq = read.iq.copy()
    iq.flags.writeable = False
    stairscan.scan(iq, read.angles_deg, read.config)
    assert (iq == read.iq).all()


def test_arrays_are_handed_over(read):
    result = stairscan.scan(read.iq, read.angles_deg, read.config)
    for array in (result.map, result.detected, result.echoes, result.posterior.particles, read.iq):
        # The memory is the compiled half's, behind as many views as there are types.
        assert not array.flags.owndata
    assert (result.map.dtype, result.map.shape) == (np.uint8, (281, 217))
    assert result.echoes.dtype == stairscan.ECHO


def test_no_signal_is_a_fault_without_anything(read):
    result = stairscan.scan(np.zeros_like(read.iq), read.angles_deg, read.config)
    answer = result.answer
    assert (answer.status, answer.reasons, answer.steps) == ("fault", ("silent",), ())
    assert answer.horizon_m is None and answer.free_m is None
    noise = np.random.default_rng(1).integers(-9, 10, read.iq.shape, np.int16)
    assert stairscan.scan(noise, read.angles_deg, read.config).answer.status == "fault"


def test_answers_cannot_be_changed(stair_a):
    answer = stairscan.replay(str(stair_a) + ".sigmf-meta").answer
    with pytest.raises(FrozenInstanceError):
        answer.status = "ok"
    assert str(answer) == answer.text and answer.summary in answer.text


def test_threads_scan_at_once(stair_a):
    results = [None] * 3

    def work(k):
        results[k] = stairscan.replay(stair_a)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert same(results[0], results[1]) and same(results[1], results[2])


GOOD = np.zeros((5, 32), np.complex64)
FIELD = "config.mount_height_m: found 9.0, expected 0.01 to 5 metres"


@pytest.mark.parametrize(
    ("iq", "angles", "config", "words"),
    [
        (np.zeros(5), None, {}, "iq: found float64 of shape (5,), expected complex (chirps, samples), or I and Q"),
        (np.zeros((5, 32)), None, {}, "iq: found float64 of shape (5, 32), expected complex"),
        (np.zeros((5, 32, 3), np.int16), None, {}, "iq: found int16 of shape (5, 32, 3), expected complex"),
        (np.zeros((5, 32, 2), np.int32), None, {}, "iq: found int32 of shape (5, 32, 2)"),
        (np.zeros((5, 32, 2), bool), None, {}, "iq: found bool"),
        (np.array([["a"]]), None, {}, "iq: found <U1"),
        (GOOD[:, :15], None, {}, "iq: samples per chirp: found 15, expected a whole number from 16 to 256"),
        (np.zeros((5, 257), complex), None, {}, "iq: samples per chirp: found 257"),
        (GOOD[:2], None, {}, "iq: found 2 chirps, expected at least 3"),
        (GOOD[:0], None, {}, "iq: found 0 chirps"),
        (GOOD + 2, None, {}, "iq: chirp 0, sample 0: I is 2, expected a number within ±1"),
        (GOOD * np.nan, None, {}, "iq: chirp 0, sample 0: I is NaN"),
        (np.where(np.arange(32) == 9, -1.5j, GOOD), None, {}, "iq: chirp 0, sample 9: Q is -1.5"),
        (GOOD, [1, 2, 3], {}, "angles: found shape (3,), expected (5,)"),
        (GOOD, [[1, 2, 3, 4, 5]], {}, "angles: found shape (1, 5)"),
        (GOOD, ["a"] * 5, {}, "angles: expected one number a chirp"),
        (GOOD, [1, 2, np.nan, 4, 5], {}, "angles[2]: found nan"),
        (GOOD, [1, 2, 3, 4, 171], {}, "angles[4]: found 171.0, expected degrees within ±170"),
        (GOOD, [1, 2, 3, 3, 5], {}, "angles[3]: found 3.0 after 3.0, expected strictly rising or falling"),
        (GOOD, [1, 2, 3.4, 4, 5], {}, "angles[2]: found 3.4, expected a multiple of 1.0000 degrees from 1"),
        (GOOD, [0, 1e-6, 2e-6, 3e-6, 4e-6], {}, "angles: angle-step: expected"),
        (GOOD, None, {"mount_height_m": 9.0}, FIELD),
        (GOOD, None, {"mount_height_m": "high"}, "config.mount_height_m: found 'high', expected a number"),
        (GOOD, None, {"mount_height_m": np.inf}, "config.mount_height_m: found inf, expected a finite number"),
        (GOOD, None, {"bandwidth_hz": 0.0}, "config.bandwidth_hz: found 0.0, expected a swept bandwidth"),
        (GOOD, None, {"carrier_hz": -1.0}, "config.carrier_hz: found -1.0, expected a frequency above 0"),
        (GOOD, None, {"sample_rate_hz": 0.0}, "config.sample_rate_hz: found 0.0, expected a rate above 0"),
        (GOOD, None, {"plane": "sideways"}, 'config.plane: found "sideways", expected "depth" or "height"'),
        (GOOD, None, {"cfar_guard_cells": 17}, "config.cfar_guard_cells: found 17, expected 0 to 16 (cells)"),
        (GOOD, None, {"cfar_guard_cells": 1.5}, "config.cfar_guard_cells: found 1.5, expected a whole number"),
        (GOOD, None, {"mode_sigma_m": 5.0}, "config.mode_sigma_m: found 5, expected 100 to 100000 (0.01 mm)"),
        (GOOD, None, {"spread": "wide"}, 'config.spread: found "wide", expected uniform or gmm-raw or gmm-cfar'),
        (GOOD, None, {"estimator": "mine"}, 'config.estimator: found "mine", expected likelihood or paper'),
        (GOOD, None, {"seed": -1}, "config.seed: found -1"),
        (GOOD, None, {"real": True}, "iq: found complex64 of shape (5, 32), expected real samples"),
        (np.zeros((5, 33), np.int16), None, {"real": True}, "iq: found 33 real samples a chirp, expected an even"),
        (np.zeros((1000, 256), complex), np.arange(1000) / 10, {}, "iq: 1000 chirps: angle-count: expected a map"),
        (GOOD, None, {"mirror_offset_m": 0.4}, "iq: 5 chirps: bandwidth: expected at least 8 range bins"),
    ],
)
def test_what_is_wrong_is_named(iq, angles, config, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        stairscan.scan(iq, angles, Config(**config))


def test_a_config_is_a_config():
    with pytest.raises(TypeError, match="config: found dict, expected Config"):
        stairscan.scan(GOOD, None, {"mount_height_m": 0.5})


def test_refusals_of_recordings_are_the_host_tool_s(host_sim, stair_a, tmp_path):
    def message(path):
        return host_sim("replay", path, fails=True).removeprefix("error: ").rstrip("\n")

    missing = tmp_path / "missing"
    with pytest.raises(FileNotFoundError) as error:
        stairscan.replay(missing)
    assert str(error.value) == message(missing)
    meta = Path(f"{stair_a}.sigmf-meta").read_text(encoding="utf-8")
    data = Path(f"{stair_a}.sigmf-data").read_bytes()
    for name, meta_text, samples in (
        ("short", meta, data[:-4]),
        ("nothing", "", data),
        ("bandwidth", meta.replace('"stairscan:bandwidth_hz"', '"stairscan:bandwidth"'), data),
        ("plane", meta.replace('"depth"', '"width"'), data),
    ):
        Path(tmp_path / f"{name}.sigmf-meta").write_text(meta_text, encoding="utf-8")
        Path(tmp_path / f"{name}.sigmf-data").write_bytes(samples)
        for function in (stairscan.replay, stairscan.read):
            with pytest.raises(ValueError, match=name) as error:
                function(tmp_path / name)
            assert str(error.value) == message(tmp_path / name)
    for function in (stairscan.read, stairscan.replay, stairscan.replay_all):
        with pytest.raises(ValueError, match=re.escape("chirps.npy: an array, expected a SigMF recording")):
            function(tmp_path / "chirps.npy")
    with pytest.raises(IsADirectoryError, match="expected one recording"):
        stairscan.replay(tmp_path)
    (tmp_path / "lone.sigmf-meta").write_text(meta, encoding="utf-8")
    with pytest.raises(OSError, match=re.escape("lone.sigmf-data")):
        stairscan.replay(tmp_path / "lone")


@pytest.mark.skipif(os.name != "posix", reason="text that is no text in Unicode names files on POSIX only")
def test_any_bytes_name_a_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        stairscan.replay(os.fsdecode(os.fsencode(tmp_path) + b"/\xff"))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scan": 1}, "stair_a: scan 1, counted from 0: there is 1 scan"),
        ({"scan": -1}, "scan: found -1"),
        ({"scan": 2**70}, "scan: found"),
        ({"scans": 0}, "scans: found 0, expected 1 to 1000"),
        ({"scans": -1}, "scans: found -1, expected"),
        ({"estimator": "mine"}, 'estimator: found "mine", expected likelihood or paper'),
        ({"seed": 2**40}, "seed: found 1099511627776, expected"),
        ({"motion": "fast"}, 'motion: found "fast", expected'),
        ({"backwards": "yes"}, "backwards: found 'yes', expected True or False"),
    ],
)
def test_wrong_options_are_named(stair_a, options, words):
    with pytest.raises(ValueError, match=f"^{re.escape(words)}"):
        stairscan.replay(stair_a, **options)


def test_nothing_that_is_drawn_at_random_brings_it_down():
    random = np.random.default_rng(5)

    def any_number():
        return float(random.choice([0, -1, 1, 10, 1e3, 1e10, 1e300, random.normal(), random.normal() * 1e5, np.nan]))

    scanned = 0
    for _ in range(300):
        iq = random.integers(-32768, 32768, (random.integers(0, 40), random.integers(10, 260), 2), np.int16)
        changed = {name: any_number() for name in random.choice(list(asdict(Config())), random.integers(0, 4))}
        changed |= {"first_angle_deg": any_number(), "angle_step_deg": any_number()} if random.random() < 0.2 else {}
        try:
            result = stairscan.scan(iq, None, Config(**changed))
        except ValueError as error:
            assert str(error).startswith(("iq", "angles", "config.")), error
        else:
            scanned += 1
            assert result.answer.status in ("ok", "degraded", "fault")
    assert scanned > 30


def test_stubs_name_what_there_is():
    package = Path(stairscan.__file__).parent
    assert (package / "py.typed").exists()
    stub = (package / "_stairscan.pyi").read_text(encoding="utf-8")
    named = set(re.findall(r"^(?:def )?(\w+)[:(]", stub, re.MULTILINE))
    assert named == {name for name in dir(_stairscan) if not name.startswith("__")}
