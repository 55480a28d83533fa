#!/usr/bin/env python3
"""Reads a recording with the public MCAP packages and checks that it is what the interface promises.

    pip install mcap mcap-protobuf-support
    python tests/check_recording.py FILE.mcap

Nothing of this repository is used: the schemas come out of the file. Prints one line a topic; exit status 1 with a
sentence for the first thing that is wrong.
"""

import json
import math
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

SCHEMAS = {
    "/cycle": ("protobuf", "elite.Cycle"),
    "/joint_states": ("protobuf", "foxglove.JointStates"),
    "/tf": ("protobuf", "foxglove.FrameTransforms"),
    "/tcp": ("protobuf", "foxglove.PoseInFrame"),
    "/scene": ("protobuf", "foxglove.SceneUpdate"),
    "/log": ("protobuf", "foxglove.Log"),
    "/script": ("jsonschema", None),
    "/command": ("jsonschema", None),
    "/io": ("jsonschema", None),
    "/external": ("jsonschema", "elite.External"),
}
SIX = """target_q target_qd target_qdd actual_q actual_qd target_torque actual_torque target_tcp_pose actual_tcp_pose
    target_tcp_speed actual_tcp_speed tcp_force""".split()
FIELDS = {
    "double": "time speed_scaling analog_in analog_out step_duration_us wakeup_latency_us".split() + SIX,
    "uint64": "cycle command_id digital_in digital_out".split(),
    "uint32": "safety_mode robot_mode".split(),
    "string": ["mode"],
}
REQUIRED = {
    "/script": ["program"],
    "/command": ["id", "cycle", "name", "arguments", "program", "line"],
    "/io": ["cycle", "name", "value"],
    "/external": ["number", "program", "turn", "cycle", "kind"],
    "/world": ["cycle"],
}
# After a part has come or gone the scene is drawn again within this time, ns.
SCENE_DELAY = 250_000_000


def check(condition, sentence):
    if not condition:
        sys.exit(f"check_recording: {sentence}")


def check_cycle_type(descriptor):
    """Every promised field is there with the promised type."""
    numbers = {"double": 1, "uint64": 4, "string": 9, "uint32": 13}  # of FieldDescriptor.TYPE_*
    for kind, names in FIELDS.items():
        for name in names:
            field = descriptor.fields_by_name.get(name)
            check(field is not None, f"elite.Cycle has no field {name}")
            check(field.type == numbers[kind], f"elite.Cycle.{name} is not {kind}")


def check_world(reader):
    """Every part of a cell is drawn, as one entity, and no other; whoever follows all updates
    sees what the latest one shows."""
    parts, changed, kept, scenes, meshes = set(), 0, set(), 0, set()
    factory = DecoderFactory()
    for schema, channel, message in reader.iter_messages(topics=["/world", "/scene"]):
        if channel.topic == "/world":
            news = json.loads(message.data)
            now = (parts | {row["name"] for row in news.get("parts", [])}) - set(news.get("removed", []))
            if now != parts:
                parts, changed = now, message.log_time
            continue
        decoded = factory.decoder_for(channel.message_encoding, schema)(message.data)
        # Triangles are sent seldom, in messages of their own, and stay until they are deleted.
        triangles = {entity.id for entity in decoded.entities if entity.triangles}
        meshes = (meshes - {deletion.id for deletion in decoded.deletions}) | triangles
        if triangles:
            check(len(triangles) == len(decoded.entities), "triangles are drawn in one message with other shapes")
            continue
        ids = [entity.id for entity in decoded.entities]
        meshes -= set(ids)
        check(len(ids) == len(set(ids)), f"entities are drawn twice: {sorted(set(i for i in ids if ids.count(i) > 1))}")
        kept = (kept - {deletion.id for deletion in decoded.deletions}) | set(ids)
        check(kept == set(ids), f"entities stay that are drawn no more: {sorted(kept - set(ids))}")
        whole = {i for i in meshes if "/piece " not in i}
        drawn = {i.removeprefix("part/") for i in whole | set(ids) if i.startswith("part/")}
        if message.log_time - changed > SCENE_DELAY:
            check(drawn == parts, f"drawn are the parts {sorted(drawn)}, there are {sorted(parts)}")
        for entity in decoded.entities:
            if entity.id.startswith("gripper/"):
                check(entity.frame_id == "flange", f"{entity.id} is drawn in {entity.frame_id}")
        scenes += bool(drawn)
    check(scenes > 0 or not parts, "no part is ever drawn")


def check_files(reader):
    """The files of the cell that the metadata names are there, before everything else and with a time of the
    recording."""
    for metadata in reader.iter_metadata():
        if metadata.name == "eliteserver":
            named = json.loads(metadata.metadata.get("files", "[]"))
            epoch = int(metadata.metadata["epoch_ns"])
    attached = list(reader.iter_attachments())
    names = [attachment.name for attachment in attached]
    check(names == [f"cell/{name}" for name in named], f"the metadata names the files {named}, there are {names}")
    for attachment in attached:
        check(
            attachment.log_time == attachment.create_time == epoch, f"{attachment.name} has another time than the start"
        )
    summary = reader.get_summary()
    first = min(index.chunk_start_offset for index in summary.chunk_indexes)
    late = [index.name for index in summary.attachment_indexes if index.offset > first]
    check(not late, f"files stand behind messages: {late}")


def main(path):
    counts = dict.fromkeys(SCHEMAS, 0)
    cycles, frames, drawn = [], set(), set()
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        check(summary is not None and summary.statistics is not None, "the file has no summary")
        for channel in summary.channels.values():
            schema = summary.schemas[channel.schema_id]
            if channel.topic in SCHEMAS:
                encoding, name = SCHEMAS[channel.topic]
                check(schema.encoding == encoding, f"{channel.topic}: schema encoding {schema.encoding}")
                check(name in (None, schema.name), f"{channel.topic}: schema name {schema.name}")
        found = {channel.topic for channel in summary.channels.values()}
        check(found >= set(SCHEMAS), f"topics are missing: {sorted(set(SCHEMAS) - found)}")
        for schema, channel, message in reader.iter_messages():
            topic = channel.topic
            counts[topic] = counts.get(topic, 0) + 1
            if channel.message_encoding == "json":
                value = json.loads(message.data)
                properties = json.loads(schema.data)["properties"]
                for key in REQUIRED.get(topic, []):
                    check(key in value, f"{topic}: a message has no {key}")
                check(set(value) <= set(properties), f"{topic}: {sorted(value)} is not in the schema")
        for _, channel, message, decoded in reader.iter_decoded_messages(topics=["/cycle"]):
            if not cycles:
                check_cycle_type(decoded.DESCRIPTOR)
            for name in SIX:
                values = getattr(decoded, name)
                check(len(values) == 6 and all(map(math.isfinite, values)), f"cycle {decoded.cycle}: {name} {values}")
            if cycles:
                check(decoded.cycle == cycles[-1][0] + 1, f"cycle {decoded.cycle} follows cycle {cycles[-1][0]}")
            cycles.append((decoded.cycle, decoded.time, message.log_time))
        for _, channel, message, decoded in reader.iter_decoded_messages(
            topics=["/tf", "/scene", "/joint_states", "/log"]
        ):
            if channel.topic == "/tf":
                frames |= {t.child_frame_id for t in decoded.transforms}
                frames |= {t.parent_frame_id for t in decoded.transforms}
            elif channel.topic == "/scene":
                drawn |= {e.frame_id for e in decoded.entities}
            elif channel.topic == "/joint_states":
                check(len(decoded.joints) == 6, f"{len(decoded.joints)} joint states")
            elif channel.topic == "/log":
                stamp = decoded.timestamp.seconds * 10**9 + decoded.timestamp.nanos
                check(stamp == message.log_time, "a log message has another time than its stamp")
        check_world(reader)
        check_files(reader)
    check(cycles, "there are no cycles")
    check(drawn <= frames, f"drawn in frames that are not sent: {drawn - frames}")
    duration = (cycles[-1][2] - cycles[0][2]) / 1e9
    simulated = cycles[-1][1] - cycles[0][1]
    check(abs(duration - simulated) < 1e-6, f"stamps span {duration} s, the cycles {simulated} s")
    for topic in ("/joint_states", "/tf", "/tcp"):
        rate = (counts[topic] - 1) / duration if duration > 1 else math.inf
        check(rate >= 50, f"{topic} comes {rate:.1f} times a second")
    check(counts["/scene"] >= 1 + math.floor(simulated / 10.1), f"the arm is drawn {counts['/scene']} times")
    for topic, count in sorted(counts.items()):
        print(f"{topic}: {count}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: check_recording.py FILE.mcap")
    main(sys.argv[1])
