"""What `convert` writes, read back by the programs that it is written for.

    python interchange.py PROGRAM RECORDING...

PROGRAM is the built host-sim; Python needs numpy, mcap, mcap-ros2-support and rosbags. Every number of the
MCAP messages and of the tables must be the one that `replay` or `inspect` prints as JSON, bit for bit, and
arrays of numpy must hold the recording's own samples. Ends with status 1 at the first difference.
"""

import base64
import csv
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FLOAT32 = 7
TOPICS = [f"/stairscan/{name}" for name in ("answer", "echoes", "stairs", "status", "staircase", "free")]
# Definitions of this project's own messages.
PACKAGE = Path(__file__).resolve().parent / "../../ros2/stairscan_msgs/msg"
# Level of full scale in the map, and decibels of a level (docs/user/live.md).
FULL_SCALE, DB_PER_UNIT = 247, 0.3762875
LEVELS = {"ok": 0, "degraded": 1, "fault": 2}


def same(what, found, expected):
    if type(found) is not type(expected) or found != expected:
        sys.exit(f"{what}: found {found!r}, expected {expected!r}")


def run(program, *arguments, faults=False):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0 and not (faults and done.returncode == 1 and done.stdout):
        sys.exit(f"{' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def lines(program, command, recording):
    text = run(program, command, recording, "--format", "json", faults=True)
    return [json.loads(line) for line in text.splitlines()]


def samples(recording):
    """The recording as numpy reads it without this project."""
    meta = json.loads(Path(f"{recording}.sigmf-meta").read_text())
    data = np.fromfile(f"{recording}.sigmf-data", dtype="<i2")
    return data.reshape(-1, meta["global"]["stairscan:samples_per_chirp"], 2)


def arrays(program, recording, scratch):
    """To numpy and back: the samples, and then the bytes of both files."""
    expected = samples(recording)
    for name, flags in (("i2", []), ("c8", ["--complex"])):
        out = scratch / f"{name}.npy"
        run(program, "convert", recording, "-o", out, *flags)
        array = np.load(out)
        if flags:
            same("complex array", (str(array.dtype), array.shape), ("complex64", expected.shape[:2]))
            array = np.stack([array.real, array.imag], axis=-1) * 32768
        same("array", array.shape, expected.shape)
        if not np.array_equal(array, expected):
            sys.exit(f"{out}: not the recording's samples")
        back = scratch / f"{name}-back"
        run(program, "convert", out, "--keys-of", recording, "-o", back)
        for suffix in ("sigmf-meta", "sigmf-data"):
            if Path(f"{back}.{suffix}").read_bytes() != Path(f"{recording}.{suffix}").read_bytes():
                sys.exit(f"{back}.{suffix}: not the bytes of {recording}")
    # numpy's own file: other order in memory, numbers of its own.
    own = scratch / "own.npy"
    np.save(own, np.asfortranarray((expected[..., 0] + 1j * expected[..., 1]).astype(np.complex128)))
    run(program, "convert", own, "--full-scale", 32768, "--keys-of", recording, "-o", scratch / "own")
    if not np.array_equal(samples(scratch / "own"), expected):
        sys.exit(f"{own}: came back with other samples")


def cloud(message):
    """A cloud's points, by name; every field is 32-bit floating point."""
    same("is_bigendian", message.is_bigendian, False)
    fields = [(field.name, field.offset) for field in message.fields]
    same("field types", {field.datatype for field in message.fields}, {FLOAT32})
    same("row", message.row_step, message.point_step * message.width)
    kind = np.dtype(
        {
            "names": [name for name, _ in fields],
            "formats": ["<f4"] * len(fields),
            "offsets": [offset for _, offset in fields],
            "itemsize": message.point_step,
        }
    )
    return np.frombuffer(bytes(message.data), dtype=kind)


def echoes(message, expected):
    points = cloud(message)
    same("echoes", len(points), len(expected))
    for point, echo in zip(points, expected):
        told = {**echo, "x": echo["x_m"], "y": 0.0, "z": echo["y_m"], "against": float(echo["against"])}
        for name in points.dtype.names:
            same(f"echo's {name}", point[name].tobytes(), np.float32(told[name]).tobytes())


def stairs(message, answer):
    markers = {(marker.ns, marker.id): marker for marker in message.markers}
    same("markers", len(markers), len(message.markers))
    same("first marker's action", message.markers[0].action, 3)
    below = 0.0
    for number, step in enumerate(answer["steps"], 1):
        points = [(p.x, p.z) for p in markers["steps", number].points]
        foot, top = (step["distance_m"], below), (step["distance_m"], step["height_m"])
        same("step's foot and top", points[:4], [foot, foot, top, top])
        below = step["height_m"]
        cross = markers["2 sigma", number].points
        across, up = 2 * step["distance_sigma_m"], 2 * step["height_sigma_m"]
        ends = [(top[0] - across, top[1]), (top[0] + across, top[1]), (top[0], top[1] - up), (top[0], top[1] + up)]
        same("step's 2σ", [(p.x, p.z) for p in cross], ends)
    if answer["drop"]:
        edge, sigma = answer["drop"]["distance_m"], answer["drop"]["distance_sigma_m"]
        same("drop", [p.x for p in markers["drop", 1].points], [edge, edge])
        band = {p.x for p in markers["drop 3 sigma", 1].points}
        same("drop's 3σ", band, {edge - 3 * sigma, edge + 3 * sigma})
    for number, maybe in enumerate(answer["maybe"], 1):
        place = markers["maybe", number].pose.position
        same("maybe", (place.x, place.z), (maybe["distance_m"], maybe["height_m"]))
    if answer["horizon_m"]:
        same("horizon", markers["horizon", 1].points[0].x, answer["horizon_m"])
    kinds = [name for name, _ in markers]
    same("steps", kinds.count("steps"), len(answer["steps"]))
    same("drops", kinds.count("drop"), 1 if answer["drop"] else 0)
    same("maybes", kinds.count("maybe"), len(answer["maybe"]))
    same("horizons", kinds.count("horizon"), 1 if answer["horizon_m"] else 0)


def status(message, answer):
    (told,) = message.status
    level = told.level[0] if isinstance(told.level, (bytes, bytearray)) else told.level
    same("level", level, LEVELS[answer["status"]])
    values = {pair.key: pair.value for pair in told.values}
    for key in ("horizon_m", "free_m", "confidence", "lost_rows", "scan"):
        same(key, json.loads(values[key]), answer[key])
    for key in ("recording", "status", "direction"):
        same(key, values[key], answer[key])
    same("steps", values["steps"], str(len(answer["steps"])))
    for reason in answer["reasons"]:
        if not values[reason].endswith("."):
            sys.exit(f"{reason}: no meaning in {values}")


def typestore(store):
    """The messages of a distribution, and this project's own."""
    types = get_typestore(store)
    for path in PACKAGE.glob("*.msg"):
        types.register(get_types_from_msg(path.read_text(), f"stairscan_msgs/msg/{path.stem}"))
    return types


def staircase(message, answer):
    """The answer with its covariances, and NaN for `null`."""
    same("status", message.status, LEVELS[answer["status"]])
    same("direction", message.direction, {"up": 1, "none": 0, "down": -1}[answer["direction"]])
    same("reasons", list(message.reasons), answer["reasons"])
    same("steps", len(message.steps), len(answer["steps"]))
    for step, told in zip(message.steps, answer["steps"]):
        same("left end", (step.start.x, step.start.y, step.start.z), (told["distance_m"], 0.4, told["height_m"]))
        same("right end", (step.end.x, step.end.y, step.end.z), (told["distance_m"], -0.4, told["height_m"]))
        covariance(step.covariance, told["distance_sigma_m"], told["height_sigma_m"])
        found = [step.tread, step.riser, step.quality]
        alike("step", found, [told["tread_m"], told["riser_m"], told["quality"]])
    same("drops", len(message.drops), 1 if answer["drop"] else 0)
    for drop in message.drops:
        told = answer["drop"]
        alike("drop", [drop.edge.x, drop.depth, drop.probability], [told["distance_m"], told["depth_m"], told["probability"]])
        covariance(drop.covariance, told["distance_sigma_m"], 0.0)
    alike("ends", [message.horizon, message.confidence], [answer["horizon_m"], answer["confidence"]])
    same("free", message.free, answer["free_m"] or 0.0)
    same("numbers", (message.scan, message.lost_rows), (answer["scan"], answer["lost_rows"]))


def alike(what, found, expected):
    for value, told in zip(found, expected, strict=True):
        if not (math.isnan(value) if told is None else value == told):
            sys.exit(f"{what}: found {found}, expected {expected}")


def covariance(found, sigma_x, sigma_z):
    expected = [0.0] * 9
    expected[0], expected[8] = sigma_x * sigma_x, sigma_z * sigma_z
    same("covariance", list(found), expected)


def messages(program, recording, scratch):
    """MCAP by its own reader, with ROS 2's messages decoded from the schemas in the file."""
    out = scratch / "scans.mcap"
    run(program, "convert", recording, "-o", out)
    answers, inspected = (lines(program, command, recording) for command in ("replay", "inspect"))
    found = {}
    with out.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        same("profile", reader.get_header().profile, "")
        for schema, channel, message in reader.iter_messages():
            if channel.message_encoding == "json":
                same("schema", schema.encoding, "jsonschema")
                found.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
        for _, channel, message, decoded in reader.iter_decoded_messages(
            topics=[topic for topic in TOPICS if topic != "/stairscan/answer"]
        ):
            found.setdefault(channel.topic, []).append((message.log_time, decoded))
    distributions(out)
    topics = TOPICS
    same("topics", sorted(found), sorted(topics))
    for topic in topics:
        same(f"messages on {topic}", len(found[topic]), len(answers))
        times = [time for time, _ in found[topic]]
        same(f"order on {topic}", times, sorted(times))
    for k, (answer, inspection) in enumerate(zip(answers, inspected)):
        told = [found[topic][k][1] for topic in topics]
        same("answer", told[0], answer)
        echoes(told[1], inspection["scatterers"])
        stairs(told[2], answer)
        status(told[3], answer)
        staircase(told[4], answer)
        same("free", np.float32(told[5].data), np.float32(answer["free_m"] or 0.0))
        time = found[topics[0]][k][0]
        for message in (told[1], told[3], told[2].markers[0], told[4]):
            stamp = message.header.stamp
            same("stamp", stamp.sec * 10**9 + stamp.nanosec, time)
            same("frame", message.header.frame_id, "stairscan")
    return len(answers)


def distributions(out):
    """The messages by the definitions that ROS 2's distributions ship, not those in the file: the same bytes."""
    for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY):
        types = typestore(store)
        with out.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages():
                if channel.message_encoding != "cdr":
                    continue
                decoded = types.deserialize_cdr(message.data, schema.name)
                if bytes(types.serialize_cdr(decoded, schema.name)) != message.data:
                    sys.exit(f"{channel.topic}: {schema.name} of {store.name} has other bytes")


def number(text):
    return None if text == "" else json.loads(text)


def table(program, recording, scratch, name):
    out = scratch / f"{name}.csv"
    run(program, "convert", recording, "--table", name, "-o", out)
    with out.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def tables(program, recording, scratch):
    rows = table(program, recording, scratch, "steps")
    for answer in lines(program, "replay", recording):
        mine = [row for row in rows if row["scan"] == str(answer["scan"])]
        same("rows of a scan", len(mine), max(1, len(answer["steps"])))
        for row in mine:
            same("status", row["status"], answer["status"])
            same("reasons", row["reasons"].split(), answer["reasons"])
            same("horizon_m", number(row["horizon_m"]), answer["horizon_m"])
            same("free_m", number(row["free_m"]), answer["free_m"])
            for key in ("distance_m", "distance_sigma_m", "depth_m", "probability"):
                same(f"drop_{key}", number(row[f"drop_{key}"]), (answer["drop"] or {}).get(key))
            same("confidence", number(row["confidence"]), answer["confidence"])
        for row, step in zip(mine, answer["steps"]):
            for key, value in step.items():
                same(key, number(row[key]), value)
    rows = table(program, recording, scratch, "echoes")
    told = [echo for scan in lines(program, "inspect", recording) for echo in scan["scatterers"]]
    same("echoes", len(rows), len(told))
    for row, echo in zip(rows, told):
        for key, value in echo.items():
            same(key, row[key] if key == "role" else number(row[key]), value)
    page = scratch / "page.html"
    run(program, "report", recording, "-o", page)
    data = re.search(r'type="application/json">(.*?)</script>', page.read_text(), re.S).group(1)
    scans = json.loads(data)["recordings"][0]["scans"]
    cells(table(program, recording, scratch, "map"), [scan["map"] for scan in scans])


def cells(rows, maps):
    """The map's cells against those of the page, which keeps them as bytes."""
    k = 0
    for polar in maps:
        levels = np.frombuffer(base64.b64decode(polar["cells"]), dtype=np.uint8)
        hits = np.unpackbits(
            np.frombuffer(base64.b64decode(polar["hits"]), dtype=np.uint8), bitorder="little"
        )
        mine = rows[k : k + len(levels)]
        same("cells", len(mine), len(levels))
        power = np.array([row["power_dbfs"] for row in mine], dtype=np.float32)
        expected = (levels.astype(np.float32) - np.float32(polar["full_scale"])) * np.float32(polar["db_per_unit"])
        if not np.array_equal(power, expected):
            sys.exit("map: powers differ from the page's")
        same("detections", [row["detected"] == "true" for row in mine], [bool(hit) for hit in hits[: len(levels)]])
        k += len(levels)
    same("cells of all scans", len(rows), k)


def pictures(program, recording, scratch, images):
    """The pixels against the cells of `convert`."""
    rows = table(program, recording, scratch, "map")
    for number, image in enumerate(images, 1):
        same("encoding", (image.encoding, image.step), ("mono8", image.width))
        cells = [row for row in rows if row["scan"] == str(number)]
        pixels = np.frombuffer(bytes(image.data), dtype=np.uint8).reshape(image.height, image.width)
        lost = sorted(set(range(image.height)) - {int(row["row"]) for row in cells})
        same("lost rows are black", bool(pixels[lost].any()), False)
        pixels = np.delete(pixels, lost, axis=0).ravel()
        power = np.array([row["power_dbfs"] for row in cells], dtype=np.float32)
        same("cells", len(pixels), len(power))
        levels = (pixels.astype(np.float32) - np.float32(FULL_SCALE)) * np.float32(DB_PER_UNIT)
        same("pixels are levels", bool(np.array_equal(levels, power)), True)


def main(program, *recordings):
    if not recordings:
        sys.exit(__doc__)
    for recording in recordings:
        recording = recording.removesuffix(".sigmf-meta")
        meta = json.loads(Path(f"{recording}.sigmf-meta").read_text(encoding="utf-8"))
        if meta["global"].get("stairscan:mode") == "guard":
            # Tables and messages are of full scans.
            continue
        with tempfile.TemporaryDirectory() as scratch:
            arrays(program, recording, Path(scratch))
            scans = messages(program, recording, Path(scratch))
            tables(program, recording, Path(scratch))
        print(f"{recording}: {scans} scans, arrays, tables and messages agree")


if __name__ == "__main__":
    main(*sys.argv[1:])
