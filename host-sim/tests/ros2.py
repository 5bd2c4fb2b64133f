"""`live --ros2`, read by CycloneDDS, another implementation of DDS.

    python ros2.py PROGRAM RECORDING...

PROGRAM is the built host-sim, which builds one with the feature `ros2` itself where it has none; Python needs what
interchange.py needs, and cyclonedds. Neither side has ROS 2: the types are those that ROS 2's distributions define, as
the package rosbags knows them, and those of ros2/stairscan_msgs. Everything stays on the loopback interface. Each
recording is played at its true speed: every message must hold what the MCAP file of the same recording holds. Ends with
status 1 at the first difference.
"""

import json
import math
import os
import signal
import struct
import subprocess
import sys
import tempfile
import time
import types
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl import types as idl
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from mcap.reader import make_reader
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores

from interchange import lines, pictures, run, same, typestore

# From where ports lie above those that Linux gives to whoever asks for any.
DOMAIN = 215 + os.getpid() % 17
LOOPBACK = """
<CycloneDDS><Domain id="any">
  <General>
    <Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
    <AllowMulticast>false</AllowMulticast>
  </General>
  <Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer address="127.0.0.1"/></Peers></Discovery>
</Domain></CycloneDDS>
"""
# Longest wait for a message, and for the node's beginning and end, seconds.
PATIENCE = 30.0
# Longest time in which the program builds one with the feature, seconds.
LONGEST_BUILD = 1800.0
SCAN_TOPICS = ["/stairscan/echoes", "/stairscan/free", "/stairscan/staircase", "/stairscan/stairs", "/stairscan/status"]
PORT_TOPICS = ["/stairscan/free", "/stairscan/staircase", "/stairscan/stairs", "/stairscan/status"]
TYPES = {
    "/stairscan/echoes": "sensor_msgs/msg/PointCloud2",
    "/stairscan/free": "std_msgs/msg/Float32",
    "/stairscan/map": "sensor_msgs/msg/Image",
    "/stairscan/staircase": "stairscan_msgs/msg/Staircase",
    "/stairscan/stairs": "visualization_msgs/msg/MarkerArray",
    "/stairscan/status": "diagnostic_msgs/msg/DiagnosticArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/tf_static": "tf2_msgs/msg/TFMessage",
}
# Topics that are not in MCAP files.
ONLY_HERE = ["/diagnostics", "/stairscan/map"]


STORE = typestore(Stores.ROS2_JAZZY)
BUILT = {}


def structure(name, kind="msg"):
    """The type of CycloneDDS for one of ROS 2, under the name that ROS 2 gives it on the wire."""
    if name not in BUILT:
        package, base = name.split("/")[0], name.split("/")[-1]
        _, members = STORE.fielddefs[name]
        notes = {field: member(node) for field, node in members}
        BUILT[name] = record(f"{package}.{kind}.dds_.{base}_", notes)
    return BUILT[name]


def record(name, notes):
    """A structure by its name on the wire and its members' types."""
    body = lambda space: space.update(__annotations__=notes, __module__=__name__)
    return dataclass(types.new_class(name.split(".")[-1], (IdlStruct,), {"typename": name}, body))


def member(node):
    """The type of a member, as rosbags describes it."""
    kind, told = node
    if kind == Nodetype.BASE:
        simple = {"string": str, "bool": bool, "byte": idl.uint8, "char": idl.uint8}
        base = told[0] if isinstance(told, tuple) else told
        return simple.get(base) or getattr(idl, base)
    if kind == Nodetype.NAME:
        return structure(told)
    inner, length = told
    return idl.array[member(inner), length] if kind == Nodetype.ARRAY else idl.sequence[member(inner)]


def qos(kept=False):
    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1)),
        Policy.Durability.TransientLocal if kept else Policy.Durability.Volatile,
        Policy.History.KeepLast(100),
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )


class Client:
    """A participant with a reader for each topic."""

    def __init__(self, topics):
        self.participant = DomainParticipant(DOMAIN)
        self.readers = {topic: self.reader("rt" + topic, structure(TYPES[topic]), topic == "/tf_static") for topic in topics}

    def reader(self, name, kind, kept=False):
        return DataReader(self.participant, Topic(self.participant, name, kind), qos=qos(kept))

    def writer(self, name, kind):
        return DataWriter(self.participant, Topic(self.participant, name, kind), qos=qos())

    def message(self, topic, patience=PATIENCE):
        return awaited(self.readers[topic], topic, patience)


def awaited(reader, what, patience=PATIENCE):
    until = time.monotonic() + patience
    while time.monotonic() < until:
        found = reader.take(1)
        if found:
            return found[0]
        time.sleep(0.01)
    sys.exit(f"{what}: nothing came for {patience:.0f} s")


@contextmanager
def serving(program, *arguments):
    """The program; at the end Ctrl-C, upon which it must end by itself."""
    process = subprocess.Popen(
        [program, "live", *arguments, "--ros2", "--domain", str(DOMAIN)], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        yield process
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=PATIENCE)
        same(f"status after Ctrl-C ({errors.decode()})", process.returncode, 0)
        same("what it says", errors.decode(), f"ROS 2: node /stairscan on 127.0.0.1, domain {DOMAIN}\n")
    finally:
        process.kill()


def constant(name):
    """Whether a field is one of rosbags' own, or a constant of the definition."""
    return name.startswith("__") or name.isupper()


def plain(value, frames=("stairscan",)):
    """A message as dictionaries and lists, without the stamps of headers whose frame must be one of `frames`."""
    if isinstance(value, (bytes, bytearray, str)):
        return value if isinstance(value, str) else list(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(part, frames) for part in value]
    if isinstance(value, float) and math.isnan(value):
        return "nan"
    if not is_dataclass(value):
        return value
    told = {field.name: getattr(value, field.name) for field in fields(value) if not constant(field.name)}
    if told.get("frame_id"):
        same("frame", told["frame_id"] in frames, True)
        del told["stamp"], told["frame_id"]
    return {name: plain(part, frames) for name, part in told.items()}


def converted(program, recording, scratch):
    """The MCAP of a recording: the messages of each scan by topic, in the order of the scans."""
    out = scratch / "scans.mcap"
    run(program, "convert", recording, "-o", out, "--force")
    scans = {}
    with out.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.message_encoding == "cdr":
                same(f"type of {channel.topic}", schema.name, TYPES[channel.topic])
                decoded = STORE.deserialize_cdr(message.data, schema.name)
                scans.setdefault(message.log_time, {})[channel.topic] = plain(decoded)
    return [scans[stamp] for stamp in sorted(scans)]


def stamp_of(message):
    header = message.markers[0].header if hasattr(message, "markers") else message.header
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def collected(client, topics, count):
    """The messages of `count` whole scans by their time, and those without a time in the order in which they came."""
    # From here on every reader gets everything.
    for topic in [*topics, "/stairscan/free"]:
        client.message(topic)
    scans, free = {}, []
    until = time.monotonic() + PATIENCE + 10 * count
    whole = lambda: [stamp for stamp, scan in scans.items() if len(scan) == len(topics)]
    while len(whole()) < count:
        if time.monotonic() > until:
            sys.exit(f"{len(whole())} of {count} whole scans came: {[sorted(scan) for scan in scans.values()]}")
        for topic in topics:
            for message in client.readers[topic].take(100):
                late = time.time() - stamp_of(message) / 1e9
                same(f"{topic} comes {late:.3f} s after its time", -0.1 < late < 2.0, True)
                scans.setdefault(stamp_of(message), {})[topic] = message
        free += client.readers["/stairscan/free"].take(100)
        time.sleep(0.01)
    # Published last; the next scan takes a second.
    time.sleep(0.2)
    free += client.readers["/stairscan/free"].take(100)
    return {stamp: scans[stamp] for stamp in sorted(whole())}, free


def recordings(program, recording, scratch):
    """A pass and a scan more, whatever the scan at which the client came."""
    order = converted(program, recording, scratch)
    with serving(program, "--play", recording):
        client = Client([*SCAN_TOPICS, *ONLY_HERE, "/tf_static"])
        topics = [topic for topic in [*SCAN_TOPICS, *ONLY_HERE] if topic != "/stairscan/free"]
        scans, free = collected(client, topics, len(order) + 1)
        maps, before = {}, None
        for scan in scans.values():
            number = numbered(scan["/stairscan/status"], order)
            same("order", before is None or number == (before + 1) % len(order), True)
            before = number
            for topic, expected in order[number].items():
                if topic != "/stairscan/free":
                    same(f"{topic} of scan {number + 1}", plain(scan[topic]), expected)
            same("diagnostics", scan["/diagnostics"], scan["/stairscan/status"])
            maps[number] = scan["/stairscan/map"]
        expected = [plain(scan["/stairscan/staircase"])["free"] for scan in scans.values()]
        found = [message.data for message in free[-len(scans) :]]
        same("free distance", found, [struct.unpack("f", struct.pack("f", value))[0] for value in expected])
        pictures(program, recording, scratch, [maps[number] for number in sorted(maps)])
        known(client)
        parameters(client, recording)
    return len(order)


def numbered(status, order):
    """Which scan of the MCAP file this is, from 0."""
    values = {pair.key: pair.value for pair in status.status[0].values}
    told = [{pair["key"]: pair["value"] for pair in scan["/stairscan/status"]["status"][0]["values"]} for scan in order]
    return [scan["scan"] for scan in told].index(values["scan"])


def known(client):
    """The node is in the graph of ROS 2, with the parameter services (Iron and later)."""
    gid = record("rmw_dds_common.msg.dds_.Gid_", {"data": idl.array[idl.uint8, 16]})
    gids = idl.sequence[gid]
    node = {"node_namespace": str, "node_name": str, "reader_gid_seq": gids, "writer_gid_seq": gids}
    node = record("rmw_dds_common.msg.dds_.NodeEntitiesInfo_", node)
    kind = {"gid": gid, "node_entities_info_seq": idl.sequence[node]}
    kind = record("rmw_dds_common.msg.dds_.ParticipantEntitiesInfo_", kind)
    reader = client.reader("ros_discovery_info", kind, kept=True)
    found = None
    # Entries since the node's beginning; the last one is whole: seven topics and transforms, parameter events, the log, and
    # six services.
    while found is None or found[0] < 16 or found[1] < 6:
        (node,) = awaited(reader, f"the node's entry in the graph, after {found}").node_entities_info_seq
        same("node", (node.node_namespace, node.node_name), ("/", "stairscan"))
        found = (len(node.writer_gid_seq), len(node.reader_gid_seq))


class Service:
    """A parameter service of the node."""

    def __init__(self, client, name, request, reply):
        kind = name.title().replace("_", "")
        self.name = name
        self.request = record(f"rcl_interfaces.srv.dds_.{kind}_Request_", request)
        self.reply = record(f"rcl_interfaces.srv.dds_.{kind}_Response_", reply)
        self.writer = client.writer(f"rq/stairscan/{name}Request", self.request)
        self.reader = client.reader(f"rr/stairscan/{name}Reply", self.reply)
        until = time.monotonic() + PATIENCE
        while not (self.writer.get_matched_subscriptions() and self.reader.get_matched_publications()):
            if time.monotonic() > until:
                sys.exit(f"service {name}: not found")
            time.sleep(0.01)
        # The node has to have seen both, too: it tells nobody when.
        time.sleep(0.5)

    def __call__(self, *arguments):
        self.writer.write(self.request(*arguments))
        return awaited(self.reader, f"service {self.name}")


def parameters(client, recording):
    """Parameters are told and set, and frames follow them; bad values are refused."""
    value = structure("rcl_interfaces/msg/ParameterValue")
    parameter = structure("rcl_interfaces/msg/Parameter")
    result = structure("rcl_interfaces/msg/SetParametersResult")
    get = Service(client, "get_parameters", {"names": idl.sequence[str]}, {"values": idl.sequence[value]})
    put = Service(
        client, "set_parameters", {"parameters": idl.sequence[parameter]}, {"results": idl.sequence[result]}
    )
    text = lambda words: value(4, False, 0, 0.0, words, [], [], [], [], [])
    number = lambda metres: value(3, False, 0, metres, "", [], [], [], [], [])
    height = json.loads(Path(f"{recording}.sigmf-meta").read_text())["global"]["stairscan:mount_height_m"]
    values = get(["frame_id", "base_frame_id", "mount_x", "mount_y", "mount_height"]).values
    same("names", [told.string_value for told in values[:2]], ["stairscan", "base_link"])
    same("mount", [told.double_value for told in values[2:]], [0.0, 0.0, height])
    transforms(client, ["base_link", "stairscan_mirror", "stairscan"], [0.0, 0.0, height])
    # Late ones get it, too.
    transforms(Client(["/tf_static"]), ["base_link", "stairscan_mirror", "stairscan"], [0.0, 0.0, height])
    bad = [("frame_id", text("")), ("frame_id", text("/a")), ("mount_x", number(math.nan)), ("mount_x", text("1"))]
    for name, wrong in [*bad, ("mount_x", number(1e9)), ("no_such", number(1.0))]:
        (told,) = put([parameter(name, wrong)]).results
        same(f"{name} = {wrong}: {told.reason}", (told.successful, bool(told.reason)), (False, True))
    wanted = [("frame_id", text("front")), ("base_frame_id", text("chair")), ("mount_x", number(0.3))]
    for told in put([parameter(name, right) for name, right in wanted]).results:
        same(f"set: {told.reason}", told.successful, True)
    transforms(client, ["chair", "front_mirror", "front"], [0.3, 0.0, height])
    client.readers["/stairscan/staircase"].take(100)
    same("frame", client.message("/stairscan/staircase").header.frame_id, "front")


def transforms(client, tree, mount):
    """The last transforms: the mirror above the chair's frame, and the ground below the mirror."""
    told = client.message("/tf_static").transforms
    found = [(part.header.frame_id, part.child_frame_id) for part in told]
    same("frames", found, [(tree[0], tree[1]), (tree[1], tree[2])])
    places = [[getattr(part.transform.translation, axis) for axis in "xyz"] for part in told]
    same("places", places, [mount, [0.0, 0.0, -mount[2]]])
    same("turns", {(part.transform.rotation.z, part.transform.rotation.w) for part in told}, {(0.0, 1.0)})


def scanner(program, recording):
    """A scanner on this machine: what its report port says, with times of today."""
    (expected,) = lines(program, "replay", recording)
    with serving(program, "--demo", recording):
        client = Client(PORT_TOPICS)
        topics = [topic for topic in PORT_TOPICS if topic != "/stairscan/free"]
        scans, free = collected(client, topics, 1)
        answer = list(scans.values())[-1]["/stairscan/staircase"]
        same("status", ["ok", "degraded", "fault"][answer.status], expected["status"])
        same("direction", {1: "up", 0: "none", -1: "down"}[answer.direction], expected["direction"])
        same("steps", len(answer.steps), len(expected["steps"]))
        for step, told in zip(answer.steps, expected["steps"]):
            same("place", (step.start.x, step.start.z), (told["distance_m"], told["height_m"]))
            same("other end", (step.end.x, step.end.y, step.end.z), (step.start.x, -step.start.y, step.start.z))
            variances = [told["distance_sigma_m"] ** 2, 0.0, told["height_sigma_m"] ** 2]
            for k, variance in enumerate(variances):
                same("variance", math.isclose(step.covariance[4 * k], variance, rel_tol=1e-12), True)
        same("free", (answer.free, len(free) > 0), (expected["free_m"] or 0.0, True))


def refused(program, recording):
    """Errors name what is wrong."""

    def error(*arguments, **variables):
        command = [program, "live", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **variables}, timeout=LONGEST_BUILD)
        same(f"{arguments}: fails", done.returncode != 0, True)
        return done.stderr

    # A program without the feature builds one with it first.
    told = error("/dev/no-such-port", "--ros2", "--domain", str(DOMAIN))
    same(f"no such port: {told}", "no /dev/no-such-port" in told, True)
    for domain in ("233", "-1", "one"):
        told = error("--play", recording, "--ros2", f"--domain={domain}")
        same(f"bad domain: {told}", domain in told and "0 to 232" in told, True)
    told = error("--play", recording, "--ros2", ROS_DOMAIN_ID="233")
    same(f"bad variable: {told}", "ROS_DOMAIN_ID=233" in told and "0 to 232" in told, True)
    told = error("--play", recording, "--ros2", "/dev/ttyUSB0")
    same(f"bad interface: {told}", "IPv4 address" in told, True)
    told = error("--play", recording, "--ros2", "192.0.2.1")
    same(f"no such interface: {told}", "192.0.2.1" in told, True)
    told = error("--play", recording, "--ros2", "--foxglove")
    same(f"two services: {told}", "cannot be used with" in told, True)


def main(program, *paths):
    if not paths:
        sys.exit(__doc__)
    # For all participants of this program; held until the end.
    domain = Domain(DOMAIN, LOOPBACK)
    paths = [path.removesuffix(".sigmf-meta") for path in paths]
    refused(program, paths[0])
    print("bad domains and interfaces and missing ports are named")
    for recording in paths:
        with tempfile.TemporaryDirectory() as scratch:
            scans = recordings(program, recording, Path(scratch))
        print(f"{recording}: {scans} scans, map, transforms, node and parameters agree")
    scanner(program, paths[0])
    print(f"{paths[0]}: a scanner's answers agree")
    del domain


if __name__ == "__main__":
    main(*sys.argv[1:])
