"""The same bits as the host tool, which is another program, and as the recording's own samples."""

import csv
import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import stairscan
from conftest import ROOT, same


def of_json(answer):
    """An answer as `replay --format json` prints it."""
    told = {key: value for key, value in asdict(answer).items() if key not in ("sentences", "summary", "text")}
    told["maybe"] = list(told.pop("maybes"))
    return json.loads(json.dumps(told))


@pytest.mark.parametrize("estimator", ["likelihood", "paper"])
def test_sentences_are_those_of_the_host_tool(host_sim, recording, estimator):
    printed = host_sim("replay", recording, "--estimator", estimator)
    answer = stairscan.replay(recording, estimator=estimator).answer
    sentences = [line.removeprefix("  ") for line in printed.splitlines() if "$PSTR" in line]
    assert sentences and list(answer.sentences) == sentences
    assert printed.startswith(answer.text)
    told = host_sim("replay", recording, "--estimator", estimator, "--format", "json")
    assert of_json(answer) == json.loads(told)


def test_own_samples_give_the_same_bits(recording):
    read = stairscan.read(recording)
    config = replace(read.config, seed=1)
    replayed = stairscan.replay(recording)
    assert config == replayed.config
    assert same(stairscan.scan(read.iq, read.angles_deg, config), replayed)
    # As complex numbers, and with angles from the configuration.
    assert same(stairscan.scan(read.samples, config=config), replayed)
    assert same(stairscan.scan(read.samples.astype(np.complex128), config=config), replayed)


def test_echoes_and_posterior_are_those_of_inspect(host_sim, recording):
    told = json.loads(host_sim("inspect", recording, "--format", "json"))
    result = stairscan.replay(recording)
    echoes = result.echoes
    assert len(echoes) == len(told["scatterers"]) > 5
    for name in ("x_m", "y_m", "range_m", "range_sigma_m", "snr_db", "width"):
        assert np.allclose(echoes[name], [s[name] for s in told["scatterers"]], rtol=0, atol=6e-7), name
    angles = np.degrees(echoes["angle_rad"].astype(np.float64))
    assert np.allclose(angles, [s["angle_deg"] for s in told["scatterers"]], rtol=0, atol=6e-7)
    assert echoes["role"].tolist() == [s["role"] for s in told["scatterers"]]
    assert echoes["against"].tolist() == [s["against"] for s in told["scatterers"]]
    assert result.noise_dbfs == pytest.approx(told["noise_dbfs"], abs=6e-7)
    ends = [cell["up_to_m"] for cell in told["way"]]
    assert np.allclose(result.way["end_m"], ends, rtol=0, atol=6e-7)
    posterior = result.posterior
    if told["posterior"] is None:
        assert posterior is None
        return
    assert np.allclose(posterior.counts, told["posterior"]["counts"], rtol=0, atol=6e-7)
    assert posterior.particles["probability"].sum() == pytest.approx(1, abs=1e-5)
    hypotheses = told["posterior"]["hypotheses"]
    assert posterior.hypotheses["name"].tolist() == [h["name"] for h in hypotheses]
    for found, said in zip(posterior.hypotheses, hypotheses, strict=True):
        assert found["probability"] == pytest.approx(said["probability"], abs=6e-7)
        edges = found["edges"][: len(said["edges"])]
        assert np.allclose(edges, [list(edge.values()) for edge in said["edges"]] or edges, rtol=0, atol=6e-7)
        assert np.isnan(found["edges"][len(said["edges"]) :]).all()


def test_the_map_is_that_of_convert(host_sim, recording, tmp_path):
    host_sim("convert", recording, "--table", "map", "-o", tmp_path / "map.csv")
    with open(tmp_path / "map.csv", newline="", encoding="utf-8") as file:
        cells = list(csv.DictReader(file))
    result = stairscan.replay(recording)
    assert len(cells) == result.map[result.present].size

    def column(name):
        return np.array([cell[name] for cell in cells], np.float32)

    assert (column("power_dbfs") == result.map_dbfs[result.present].ravel()).all()
    detected = [cell["detected"] == "true" for cell in cells]
    assert (np.array(detected) == result.detected[result.present].ravel()).all()
    angles = np.repeat(result.angles_deg[result.present], result.map.shape[1])
    assert (column("angle_deg") == angles).all()
    ranges = np.tile(result.ranges_m, result.present.sum())
    assert (column("range_m") == ranges).all()
    x_m, y_m = result.places_m
    assert np.allclose(column("distance_m"), x_m[result.present].ravel(), atol=1e-5)
    assert np.allclose(column("height_m"), y_m[result.present].ravel(), atol=1e-5)


@pytest.fixture(scope="module")
def approach(host_sim, tmp_path_factory):
    path = tmp_path_factory.mktemp("approach") / "approach"
    host_sim("simulate", "scenes/stair_b.toml", "--approach", "2", "-o", path)
    return path


def test_a_sequence_is_followed_scan_by_scan(host_sim, approach):
    for option in ([], ["--single"]):
        printed = host_sim("replay", approach, "--format", "json", *option).splitlines()
        results = stairscan.replay_all(approach, single=bool(option))
        assert [of_json(r.answer) for r in results] == [json.loads(line) for line in printed]
        assert len(results) == 2
        last = stairscan.replay(approach, 1, single=bool(option))
        assert same(last, results[1])
    read = stairscan.read(approach)
    assert read.scans == 2 and read.truth(1)["direction"] == "up"
    assert len(read.iq[read.chirps_of(1)]) == len(read.iq) // 2


def test_options_are_those_of_the_command(host_sim, stair_a):
    def told(*options):
        lines = host_sim("replay", stair_a, "--format", "json", *options).splitlines()
        return [json.loads(line) for line in lines]

    results = stairscan.replay_all(stair_a, scans=2, backwards=True, motion="auto", seed=7)
    expected = told("--scans", "2", "--backwards", "--motion", "auto", "--seed", "7")
    assert [of_json(r.answer) for r in results] == expected


def test_a_pitch_without_travel_is_in_the_angles(host_sim, stair_a, tmp_path):
    meta = json.loads(Path(f"{stair_a}.sigmf-meta").read_text(encoding="utf-8"))
    meta["global"]["stairscan:pitch_deg"] = 1.25
    path = tmp_path / "pitched"
    Path(f"{path}.sigmf-meta").write_text(json.dumps(meta), encoding="utf-8")
    Path(f"{path}.sigmf-data").write_bytes(Path(f"{stair_a}.sigmf-data").read_bytes())
    read, replayed = stairscan.read(path), stairscan.replay(path)
    assert read.angles_deg[0] == -21.25 and replayed.config.first_angle_deg == -21.25
    assert same(stairscan.scan(read.iq, read.angles_deg, replace(read.config, seed=1)), replayed)
    assert host_sim("replay", path).startswith(replayed.answer.text)


def test_real_samples(host_sim, tmp_path):
    scene = tmp_path / "real.toml"
    text = (ROOT / "scenes" / "stair_a.toml").read_text(encoding="utf-8")
    assert "[radar]" not in text
    scene.write_text(f"{text}\n[radar]\nreal = true\n", encoding="utf-8")
    host_sim("simulate", scene, "-o", tmp_path / "real")
    replayed = stairscan.replay(tmp_path / "real")
    read = stairscan.read(tmp_path / "real")
    assert read.config.real
    samples = read.iq.reshape(len(read.iq), -1)
    assert same(stairscan.scan(samples, read.angles_deg, replace(read.config, seed=1)), replayed)
