"""Reading a log back: the records of an MCAP file, and the record of the flight in them."""

import io
import json
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import MCAP0_MAGIC

from crosstrack.errors import InputError, Problem
from crosstrack.flight import events
from crosstrack.flight.cdr import constant
from crosstrack.flight.effort import NO_EFFORT, Effort
from crosstrack.flight.effort import read as read_effort
from crosstrack.flight.flight import Replan, thinned
from crosstrack.flight.observer import NOTHING
from crosstrack.flight.record import Record
from crosstrack.flight.topics import BODY, TOPICS, Topic, header
from crosstrack.types import Array, Outcome

CHUNK_LIMIT = 1 << 28
"""bytes, the largest chunk that is unpacked"""
LIMIT = 1 << 31
"""bytes, the most that is unpacked of one file: some hours of flight"""
MOST_ROTORS = 64
FRAME = struct.Struct("<BQ")
NAMES = tuple(topic.name for topic in TOPICS)


@dataclass(frozen=True)
class Recording:
    """What a log holds of a flight."""

    document: dict[str, Any]
    """the resolved mission"""
    files: dict[str, bytes]
    """the files that the mission names"""
    record: Record
    """the samples, as many as were written"""
    outcome: Outcome | None
    """None where the log ends before the flight did"""
    effort: Effort
    """nothing where the log ends before the flight did"""
    replans: tuple[Replan, ...] = ()
    """the courses planned in flight"""
    seen: Array = field(default_factory=lambda: NOTHING)
    """(n, 3) m, what the sensors saw: one point of every 0.1 m"""


@dataclass
class Contents:
    """What is read of a file, as it comes."""

    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    files: dict[str, bytes] = field(default_factory=dict)
    topics: dict[int, str] = field(default_factory=dict)
    messages: dict[str, list[bytes]] = field(default_factory=lambda: {name: [] for name in (*NAMES, *events.KINDS)})
    unpacked: int = 0

    def take(self, record: McapRecord) -> None:
        """Sort in one record."""
        if isinstance(record, Metadata):
            self.metadata[record.name] = record.metadata
        elif isinstance(record, Attachment):
            self.files[record.name] = record.data
        elif isinstance(record, Channel):
            self.topics[record.id] = record.topic
        elif isinstance(record, Message):
            wanted = self.messages.get(self.topics.get(record.channel_id, ""))
            if wanted is not None:
                wanted.append(record.data)
        elif isinstance(record, Chunk):
            self.unpack(record)

    def unpack(self, chunk: Chunk) -> None:
        """Sort in the records of a chunk, once its sizes are known to be sound."""
        if chunk.compression not in ("", "zstd"):
            raise ValueError(f"chunk compressed by {chunk.compression!r}; allowed: zstd or none")
        size = zstandard.frame_content_size(chunk.data) if chunk.compression else len(chunk.data)
        self.unpacked += size
        if size != chunk.uncompressed_size or size > CHUNK_LIMIT or self.unpacked > LIMIT:
            allowed = f"at most {CHUNK_LIMIT} bytes, {LIMIT} in one file"
            raise ValueError(f"chunk of {size} bytes, announced as {chunk.uncompressed_size}; allowed: {allowed}")
        for record in breakup_chunk(chunk, validate_crc=True):
            self.take(record)


def read_log(path: Path) -> Recording:
    """Read a log, whole or cut off at any point.

    Raises:
        InputError: no MCAP file, not one of ours, or damaged before its end.
        OSError: the file cannot be read.
    """
    contents = Contents()
    try:
        with path.open("rb") as stream:
            for record in records(stream, path.stat().st_size):
                contents.take(record)
        return recording(contents)
    except (McapError, ValueError, KeyError, RecursionError, struct.error, zstandard.ZstdError) as error:
        message = str(error) or "a record ends too early"
        raise InputError(str(path), [Problem("", f"not a whole Crosstrack log: {message}")]) from error


def records(stream: BinaryIO, size: int) -> Iterator[McapRecord]:
    """Yield the records that matter of a file of `size` bytes, up to the last whole one."""
    wanted = {Opcode.METADATA, Opcode.ATTACHMENT, Opcode.CHUNK, Opcode.DATA_END}
    if stream.read(len(MCAP0_MAGIC)) != MCAP0_MAGIC:
        raise ValueError("it does not begin as an MCAP file does")
    checksum = zlib.crc32(MCAP0_MAGIC)
    for opcode, frame in frames(stream, size):
        if opcode in wanted:
            record = next(StreamReader(io.BytesIO(frame), skip_magic=True, emit_chunks=True).records)
            if isinstance(record, DataEnd):
                check(record, checksum)
                return
            yield record
        checksum = zlib.crc32(frame, checksum)


def frames(stream: BinaryIO, size: int) -> Iterator[tuple[int, bytes]]:
    """Yield the opcode and the bytes of every whole record; one that is cut off ends them."""
    while len(head := stream.read(FRAME.size)) == FRAME.size:
        opcode, length = FRAME.unpack(head)
        if length > size - stream.tell():
            break
        yield opcode, head + stream.read(length)
    stream.seek(-len(MCAP0_MAGIC), io.SEEK_END)
    if stream.read() == MCAP0_MAGIC:
        raise ValueError("damaged: a record is longer than the file")


def check(end: DataEnd, checksum: int) -> None:
    """Compare the checksum of the data section, where there is one."""
    if end.data_section_crc not in (0, checksum):
        raise ValueError(f"damaged: checksum {checksum:08x}, expected {end.data_section_crc:08x}")


def recording(contents: Contents) -> Recording:
    """Make the flight's record of what was read."""
    mission = contents.metadata.get("mission", {})
    document = json.loads(mission.get("document", "null"))
    if not isinstance(document, dict):
        raise ValueError("it holds no mission")  # noqa: TRY004 - the file is at fault, not a type
    ended = contents.metadata.get("outcome")
    return Recording(
        document=document,
        files=contents.files,
        record=rebuild(contents.messages),
        outcome=outcome_named(ended["outcome"]) if ended else None,
        effort=read_effort(ended) if ended else NO_EFFORT,
        replans=tuple(map(events.replan, contents.messages[events.REPLANNED])),
        seen=thinned([events.decoded(events.SEEN, data)[1] for data in contents.messages[events.SEEN]]),
    )


def outcome_named(key: str) -> Outcome:
    """Return the outcome of a key."""
    known = {outcome.name.lower(): outcome for outcome in Outcome}
    if key not in known:
        raise ValueError(f"outcome {key!r}; allowed: {', '.join(known)}")
    return known[key]


def rebuild(messages: dict[str, list[bytes]]) -> Record:
    """Make a record of the messages of every topic."""
    rotors = rotor_count(messages["/vehicle/rotors"])
    columns: dict[str, Array] = {}
    for topic in TOPICS:
        if topic.columns:
            data = decode(topic, rotors, messages[topic.name])
            columns |= {name: np.ascontiguousarray(data[name]) for name in topic.columns}
    counts = {len(column) for column in columns.values()}
    if len(counts) != 1 or 0 in counts:
        raise ValueError(f"its topics hold {sorted(counts)} samples; allowed: the same number of each, at least 1")
    return Record(**columns)


def rotor_count(messages: list[bytes]) -> int:
    """Return how many rotors the first message tells of."""
    if not messages:
        raise ValueError("it holds no samples")
    (count,) = struct.unpack_from("<I", messages[0], len(header(BODY).data))
    if count > MOST_ROTORS:
        raise ValueError(f"{count} rotors; allowed: at most {MOST_ROTORS}")
    return int(count)


def decode(topic: Topic, rotors: int, messages: list[bytes]) -> Any:
    """Return the messages of a topic as a structured array, checked against its layout."""
    layout = topic.layout(rotors)
    dtype = layout.dtype()
    if any(len(message) != dtype.itemsize for message in messages):
        raise ValueError(f"topic {topic.name}: a message is not {dtype.itemsize} bytes long")
    raw = np.frombuffer(b"".join(messages), dtype=np.uint8).reshape(-1, dtype.itemsize)
    fixed = constant(dtype)
    expected = np.frombuffer(layout.data, dtype=np.uint8)[fixed]
    if (raw[:, fixed] != expected).any():
        raise ValueError(f"topic {topic.name}: a message is not laid out as {topic.kind}")
    return raw.reshape(-1).view(dtype)
