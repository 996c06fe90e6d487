"""The log of a flight: an MCAP file of ROS 2 messages, written while flying."""

import json
import math
import mimetypes
from pathlib import Path

import numpy as np
from mcap.records import Message
from numpy.typing import NDArray

from crosstrack.flight import events, still
from crosstrack.flight.chunks import ChunkWriter, Index, headed, packed
from crosstrack.flight.effort import Effort
from crosstrack.flight.messages import definition
from crosstrack.flight.observer import Sample, collect
from crosstrack.flight.plan import Plan
from crosstrack.flight.scene import scene
from crosstrack.flight.topics import TOPICS, columns, nanoseconds
from crosstrack.types import Array, Outcome

CHUNK_DURATION = 1.0
"""s of flight time after which the samples are handed to the system: what a killed process loses at most"""


class LogWriter:
    """Write the log of one flight, as its observer.

    The file begins with the mission (metadata `mission`) and the files that it names (attachments), and ends
    with the outcome (metadata `outcome`). Every second of flight time is on the system's side as one chunk,
    so that a killed process leaves a file that can be read up to there.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._rows: list[Sample] = []
        self._written = -math.inf
        self._encoder: Encoder | None = None
        self._channels: dict[str, int] = {}

    def begin(self, plan: Plan) -> None:
        """Open the file and write what is known before the flight.

        Raises:
            OSError: the file cannot be written.
        """
        self._file = ChunkWriter(self.path)
        with self._file.whole():
            self._introduce(plan)

    def _introduce(self, plan: Plan) -> None:
        document = json.dumps(plan.document, ensure_ascii=False)
        self._file.metadata("mission", {"name": plan.name, "document": document})
        for name, data in plan.files.items():
            media_type = mimetypes.guess_type(name)[0] or "application/octet-stream"
            self._file.attachment(name, media_type, data)
        drawn = scene(plan)
        write_once(self._file, "/route", "nav_msgs/Path", still.path(drawn.route))
        write_once(self._file, "/course", "nav_msgs/Path", still.path(drawn.course))
        write_once(self._file, "/world", "visualization_msgs/MarkerArray", still.markers(drawn.meshes))

    def sample(self, row: Sample) -> None:
        """Keep a row; write the rows kept once the last one written is a second old."""
        self._rows.append(row)
        if row.time - self._written >= CHUNK_DURATION:
            self._flush()
            self._written = row.time

    def end(self, outcome: Outcome, effort: Effort) -> None:
        """Write what is left, the outcome and the index."""
        with self._file.whole():
            self._flush()
            self._file.metadata("outcome", {"outcome": outcome.name.lower(), **effort.texts()})
            self._file.close()

    def _flush(self) -> None:
        if not self._rows:
            return
        if self._encoder is None:
            self._encoder = Encoder(self._file, len(self._rows[0].rotor_speeds))
        self._file.chunk(*self._encoder.encode(self._rows))
        for row in self._rows:
            if len(row.seen):
                self._tell(events.SEEN, row.time, row.seen)
            if row.course is not None:
                self._tell(events.REPLANNED, row.time, row.course)
        self._rows = []

    def _tell(self, topic: str, time: float, points: Array) -> None:
        """Write what happened at a time (s)."""
        if topic not in self._channels:
            kind = events.KINDS[topic]
            self._channels[topic] = self._file.channel(topic, kind, definition(kind))
        stamp = int(nanoseconds(np.array([time]))[0])
        write_at(self._file, self._channels[topic], stamp, events.encoded(topic, time, points))


def write_once(file: ChunkWriter, topic: str, kind: str, data: bytes) -> None:
    """Write a topic of one message, at time zero."""
    write_at(file, file.channel(topic, kind, definition(kind)), 0, data)


def write_at(file: ChunkWriter, channel: int, stamp: int, data: bytes) -> None:
    """Write one message at a time (ns), as a chunk of its own."""
    message = Message(channel_id=channel, log_time=stamp, data=data, publish_time=stamp, sequence=0)
    file.chunk(packed(message), {channel: np.array([[stamp, 0]], dtype=np.uint64)})


class Encoder:
    """Turn samples into message records: all messages of one sample are one row of a structured array."""

    def __init__(self, file: ChunkWriter, rotors: int) -> None:
        self._channels = [file.channel(topic.name, topic.kind, definition(topic.kind)) for topic in TOPICS]
        types, templates = [], []
        for topic, channel in zip(TOPICS, self._channels, strict=True):
            layout = topic.layout(rotors)
            record, template = headed(layout.dtype(), bytes(layout.data), channel)
            types.append(record)
            templates.append(template)
        self._offsets = np.cumsum([0, *(record.itemsize for record in types[:-1])])
        self._template = b"".join(templates)
        names = [topic.name for topic in TOPICS]
        self._dtype = np.dtype(list(zip(names, types, strict=True)))
        self._count = 0

    def encode(self, rows: list[Sample]) -> tuple[bytes, dict[int, Index]]:
        """Return the message records of some samples and their index by channel."""
        record = collect(rows)
        filling = columns(record)
        buffer = bytearray(self._template * len(rows))
        messages = np.frombuffer(buffer, dtype=self._dtype)
        stamps = nanoseconds(record.time)
        for topic in TOPICS:
            self._head(messages[topic.name]["head"], stamps)
            data = messages[topic.name]["data"]
            for slot in data.dtype.names or ():
                data[slot] = filling[slot]
        self._count += len(rows)
        return bytes(buffer), self._index(stamps)

    def _head(self, head: NDArray[np.void], stamps: NDArray[np.uint64]) -> None:
        head["sequence"] = np.arange(self._count, self._count + len(stamps))
        head["log_time"] = stamps
        head["publish_time"] = stamps

    def _index(self, stamps: NDArray[np.uint64]) -> dict[int, Index]:
        starts = np.arange(len(stamps)) * self._dtype.itemsize
        return {
            channel: np.column_stack([stamps, starts + offset]).astype(np.uint64)
            for channel, offset in zip(self._channels, self._offsets, strict=True)
        }
