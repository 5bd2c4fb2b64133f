"""`live --foxglove`, read by a client of its own.

    python foxglove.py PROGRAM RECORDING...

PROGRAM is the built host-sim, which builds one with the feature `foxglove` itself where it has none; Python needs what interchange.py needs, and websockets. The
client keeps to Foxglove's WebSocket protocol (https://github.com/foxglove/ws-protocol). Each recording is played at
its true speed: every message must hold what the MCAP file of the same recording holds, chirps must be the recorded
samples at their times, and the map the cells of `convert --table map`. Ends with status 1 at the first difference.
"""

import json
import math
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from interchange import lines, pictures, run, same, samples

PORT_TOPICS = [f"/stairscan/{name}" for name in ("answer", "free", "staircase", "stairs", "status")]
SCAN_TOPICS = [*PORT_TOPICS, "/stairscan/echoes"]
ON_REQUEST = ["/stairscan/chirp", "/stairscan/map"]
SUBPROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = 1
# True speed: a message comes so long after its time at most, seconds. For a busy machine.
LATE = 2.0
# Longest wait for a message, and for the server's beginning and end, seconds.
PATIENCE = 30.0


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Client:
    """A connection, its topics, and the messages that came on those subscribed to."""

    def __init__(self, port):
        until = time.monotonic() + PATIENCE
        self.stack = ExitStack()
        while True:
            try:
                connection = connect(f"ws://127.0.0.1:{port}", subprotocols=[SUBPROTOCOL], max_size=None)
                self.socket = self.stack.enter_context(connection)
                break
            except OSError:
                if time.monotonic() > until:
                    sys.exit(f"port {port}: nobody listens")
                time.sleep(0.05)
        same("subprotocol", self.socket.subprotocol, SUBPROTOCOL)
        self.channels, self.topics, self.server = {}, {}, None

    def offered(self, topics):
        """Waits for the server's name and all its topics."""
        while self.server is None or len(self.channels) < len(topics):
            self.text(self.socket.recv(timeout=PATIENCE))
        same("topics", sorted(self.channels), sorted(topics))
        if not self.server.startswith("stairscan "):
            sys.exit(f"server's name: {self.server}")

    def text(self, message):
        if not isinstance(message, str):
            sys.exit("a message before any subscription")
        told = json.loads(message)
        if told["op"] == "serverInfo":
            self.server = told["name"]
        elif told["op"] == "advertise":
            for channel in told["channels"]:
                self.channels[channel["topic"]] = channel

    def subscribe(self, topics):
        subscriptions = []
        for topic in topics:
            number = 100 + self.channels[topic]["id"]
            self.topics[number] = topic
            subscriptions.append({"id": number, "channelId": self.channels[topic]["id"]})
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": subscriptions}))

    def unsubscribe(self, topics):
        numbers = [100 + self.channels[topic]["id"] for topic in topics]
        self.socket.send(json.dumps({"op": "unsubscribe", "subscriptionIds": numbers}))

    def message(self):
        """The next message: topic, time in nanoseconds, bytes."""
        while True:
            data = self.socket.recv(timeout=PATIENCE)
            if isinstance(data, str):
                continue
            kind, number, stamp = struct.unpack_from("<BIQ", data)
            same("kind of message", kind, MESSAGE_DATA)
            late = time.time() - stamp / 1e9
            if not -0.1 < late < LATE:
                sys.exit(f"{self.topics[number]}: comes {late:.3f} s after its time")
            return self.topics[number], stamp, data[13:]

    def decoded(self, topic, data):
        channel = self.channels[topic]
        if channel["encoding"] == "json":
            return json.loads(data)
        schema = Schema(
            id=1, name=channel["schemaName"], encoding=channel["schemaEncoding"], data=channel["schema"].encode()
        )
        return DecoderFactory().decoder_for("cdr", schema)(data)


@contextmanager
def serving(program, *arguments):
    """The program with its port; at the end Ctrl-C, upon which it must end by itself."""
    port = free_port()
    process = subprocess.Popen(
        [program, "live", *arguments, "--foxglove", f"127.0.0.1:{port}"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        yield port
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        same(f"status after Ctrl-C ({errors.decode()})", process.returncode, 0)
    finally:
        process.kill()


def ended(client):
    """The server has closed the connection as the protocol wants it."""
    try:
        while True:
            client.socket.recv(timeout=PATIENCE)
    except ConnectionClosed as closed:
        if closed.rcvd is None:
            sys.exit("the connection broke off: no close frame")
    client.stack.close()


def plain(value, time_ns):
    """A decoded message as dictionaries and lists; the stamp in each header that names a frame must be `time_ns`."""
    if isinstance(value, (list, tuple)):
        return [plain(part, time_ns) for part in value]
    if isinstance(value, float) and math.isnan(value):
        return "nan"
    if not hasattr(value, "__slots__"):
        return value
    fields = {name: getattr(value, name) for name in value.__slots__}
    if fields.get("frame_id"):
        same("stamp", fields["stamp"].sec * 10**9 + fields["stamp"].nanosec, time_ns)
        del fields["stamp"]
    return {name: plain(part, time_ns) for name, part in fields.items()}


def converted(program, recording, scratch):
    """The MCAP of a recording: channels by topic, and the messages of each scan by its number."""
    out = scratch / "scans.mcap"
    run(program, "convert", recording, "-o", out, "--force")
    channels, scans, order = {}, {}, []
    with out.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            channels[channel.topic] = (schema.name, schema.encoding, schema.data.decode(), channel.message_encoding)
            scans.setdefault(message.log_time, {})[channel.topic] = message.data
    for stamp in sorted(scans):
        number = json.loads(scans[stamp]["/stairscan/answer"])["scan"]
        order.append((number, stamp, scans[stamp]))
    return channels, order


def schemas(client, channels):
    for topic, expected in channels.items():
        told = client.channels[topic]
        found = (told["schemaName"], told["schemaEncoding"], told["schema"], told["encoding"])
        same(f"schema of {topic}", found, expected)


def scan_messages(client, count):
    """The messages of `count` whole scans, by their time."""
    scans = {}
    while len([scan for scan in scans.values() if len(scan) == len(SCAN_TOPICS)]) < count:
        topic, stamp, data = client.message()
        same("a topic that was asked for", topic in SCAN_TOPICS, True)
        scans.setdefault(stamp, {})[topic] = data
    return scans


def compared(client, scans, order):
    """Every scan against the MCAP's; those of one pass must be as far apart in time."""
    by_number = {number: (k, stamp, messages) for k, (number, stamp, messages) in enumerate(order)}
    before = None
    for stamp in sorted(scans):
        if len(scans[stamp]) < len(SCAN_TOPICS):
            continue
        answer = json.loads(scans[stamp]["/stairscan/answer"])
        k, recorded, messages = by_number[answer["scan"]]
        for topic in SCAN_TOPICS:
            found = plain(client.decoded(topic, scans[stamp][topic]), stamp)
            same(f"{topic} of scan {answer['scan']}", found, plain(client.decoded(topic, messages[topic]), recorded))
        if before is not None:
            same("order", k, (before[0] + 1) % len(order))
            if k > before[0]:
                same("time between scans", stamp - before[1], recorded - before[2])
        before = (k, stamp, recorded)


def on_request(program, client, recording, scratch):
    """Map and chirps: none before they are asked for, all of a pass then, none afterwards."""
    expected = samples(recording)
    meta = json.loads(Path(f"{recording}.sigmf-meta").read_text())
    times = meta["global"].get("stairscan:time_s")
    angles = [capture["stairscan:mirror_angle_deg"] for capture in meta["captures"]]
    client.subscribe(ON_REQUEST)
    chirps, maps = {}, {}
    while len(chirps) < len(expected):
        topic, stamp, data = client.message()
        if topic == "/stairscan/chirp":
            chirp = client.decoded(topic, data)
            # From a whole pass.
            if chirp["chirp"] == 0 or chirps:
                chirps[chirp["chirp"]] = (stamp, chirp)
        elif topic == "/stairscan/map" and chirps:
            maps[stamp] = client.decoded(topic, data)
    first = chirps[0][0]
    for k, (stamp, chirp) in chirps.items():
        found = np.stack([np.array(chirp["i"]), np.array(chirp["q"])], axis=-1)
        if not np.array_equal(found, expected[k]):
            sys.exit(f"chirp {k}: not the recording's samples")
        same("chirp's angle", chirp["angle_deg"], angles[k])
        if times:
            same("chirp's time", abs((stamp - first) - (times[k] - times[0]) * 1e9) < 1e3, True)
    # The last scan's map follows its last chirp.
    while len(maps) < meta["global"].get("stairscan:scans", 1):
        topic, stamp, data = client.message()
        if topic == "/stairscan/map":
            maps[stamp] = client.decoded(topic, data)
    pictures(program, recording, scratch, [maps[stamp] for stamp in sorted(maps)])
    client.unsubscribe(ON_REQUEST)
    quiet(client)


def quiet(client):
    """After what was under way: answers go on, map and chirps do not."""
    answers = 0
    while answers < 3:
        topic, _, _ = client.message()
        answers += topic == "/stairscan/answer"
        if answers > 1 and topic in ON_REQUEST:
            sys.exit(f"{topic}: comes though nobody subscribes to it")


def recordings(program, recording, scratch):
    channels, order = converted(program, recording, scratch)
    with serving(program, "--play", recording) as port:
        client = Client(port)
        client.offered(SCAN_TOPICS + ON_REQUEST)
        schemas(client, channels)
        client.subscribe(SCAN_TOPICS)
        compared(client, scan_messages(client, len(order) + 1), order)
        on_request(program, client, recording, scratch)
        # A second client beside the first.
        other = Client(port)
        other.offered(SCAN_TOPICS + ON_REQUEST)
        other.subscribe(["/stairscan/answer"])
        same("second client", other.message()[0], "/stairscan/answer")
    ended(client)
    ended(other)
    return len(order)


def scanner(program, recording):
    """A scanner on this machine: what its report port says, with times of today."""
    (expected,) = lines(program, "replay", recording)
    with serving(program, "--demo", recording) as port:
        client = Client(port)
        client.offered(PORT_TOPICS)
        client.subscribe(PORT_TOPICS)
        found = {}
        while len(found) < len(PORT_TOPICS):
            topic, stamp, data = client.message()
            found[topic] = client.decoded(topic, data)
        answer = found["/stairscan/answer"]
        for key, value in expected.items():
            if key not in ("recording", "scan"):
                same(key, answer[key], value)
        (status,) = found["/stairscan/status"].status
        values = {pair.key: pair.value for pair in status.values}
        same("status", values["status"], expected["status"])
        kinds = [marker.ns for marker in found["/stairscan/stairs"].markers]
        same("steps", kinds.count("steps"), len(expected["steps"]))
    ended(client)


def refused(program, recording):
    """Errors name what is wrong."""

    def error(*arguments):
        done = subprocess.run([program, "live", *arguments], capture_output=True, text=True)
        same(f"{arguments}: fails", done.returncode != 0, True)
        return done.stderr

    # A program without the feature builds one with it first.
    told = error("/dev/no-such-port", "--foxglove", str(free_port()))
    same("no such port", "no /dev/no-such-port" in told, True)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        told = error("--play", recording, "--foxglove", address)
        same("address in use", address in told and "in use" in told, True)
    told = error("--play", recording, "--foxglove", "nowhere:1")
    same("bad address", "nowhere:1" in told and "expected ADDRESS:PORT" in told, True)


def main(program, *paths):
    if not paths:
        sys.exit(__doc__)
    paths = [path.removesuffix(".sigmf-meta") for path in paths]
    refused(program, paths[0])
    print("taken and bad addresses and missing ports are named")
    for recording in paths:
        with tempfile.TemporaryDirectory() as scratch:
            scans = recordings(program, recording, Path(scratch))
        print(f"{recording}: {scans} scans, and map and chirps on request, agree")
    scanner(program, paths[0])
    print(f"{paths[0]}: a scanner's answers agree")


if __name__ == "__main__":
    main(*sys.argv[1:])
