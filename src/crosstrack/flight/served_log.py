"""The log of a served session: an MCAP file of ROS 2 messages, written while clients fly."""

import json
import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Message

from crosstrack.airsim.scene.markers import Marker
from crosstrack.flight import served_markers, still
from crosstrack.flight.cdr import Builder
from crosstrack.flight.chunks import ChunkWriter, headed, packed
from crosstrack.flight.messages import definition
from crosstrack.flight.scene import Mesh
from crosstrack.flight.served_track import track
from crosstrack.flight.topics import into_body, odometry, transform
from crosstrack.types import Array

LARGEST = 1 << 30
"""bytes of messages, after which a log ends"""
MOVES, COLLISIONS, MARKERS, OBJECTS = "/moves", "/collisions", "/markers", "/world"
KINDS = {
    "/tf": "tf2_msgs/TFMessage",
    MOVES: "std_msgs/String",
    COLLISIONS: "std_msgs/String",
    MARKERS: "visualization_msgs/MarkerArray",
    OBJECTS: "visualization_msgs/MarkerArray",
}
"""of the topics beside `/NAME/odometry` of every vehicle"""
ODOMETRY = "nav_msgs/Odometry"

log = logging.getLogger(__name__)

MOST_TEXTS = 1000
"""that are kept before they are written: while the clock stands still, time alone does not ask for it"""


class SessionLog:
    """Write the log of a session; where that fails, say so, and write no more.

    The file begins with metadata `session`, and ends with metadata `outcome` where the server was not killed.

    Args:
        path: the file
        begins: ns, of the simulated clock; messages are stamped by it

    Raises:
        OSError: the file cannot be written.
    """

    def __init__(self, path: Path, begins: int) -> None:
        self.path, self.begins = path, begins
        self.open = True
        self.ended = ""
        """why it ended before the session did; empty where it did not"""
        self._size = 0
        self._markers = 0
        self._texts: list[tuple[str, int, bytes]] = []
        self._channels: dict[str, int] = {}
        self._file = ChunkWriter(path)
        self._file.metadata("session", {"begins": str(begins)})

    def rows(self, name: str, rows: Sequence[Array]) -> None:
        """Write rows (14,) of the track of a vehicle, world NED, as one chunk."""
        self._write(lambda: self._tracked(name, np.array(rows)))

    def told(self, topic: str, time: int, values: dict[str, Any]) -> None:
        """Keep what happened at a time (ns), as JSON, until it is written."""
        text = Builder()
        text.text(json.dumps(values, ensure_ascii=False))
        self._texts.append((topic, time, bytes(text.data)))
        if len(self._texts) >= MOST_TEXTS:
            self.flush()

    def flush(self) -> None:
        """Write what was told."""
        texts, self._texts = self._texts, []
        if texts:
            self._write(lambda: self._messages(texts))

    def drawn(self, markers: Sequence[Marker], time: int) -> None:
        """Write what was drawn until a time (ns)."""
        data = served_markers.message(markers, self._markers)
        self._markers += served_markers.count(markers)
        self._write(lambda: self._messages([(MARKERS, time, data)]))

    def objects(self, meshes: Sequence[Mesh], time: int) -> None:
        """Write the obstacles as they are at a time (ns)."""
        self._write(lambda: self._messages([(OBJECTS, time, still.markers(meshes))]))

    def close(self, outcome: dict[str, str]) -> None:
        """Write what is left, how it ended, and the index."""
        self.flush()
        if self.open:
            self._write(lambda: self._finish(outcome))
        self.open = False

    def _finish(self, outcome: dict[str, str]) -> None:
        self._file.metadata("outcome", outcome)
        self._file.close()

    def _write(self, write: Callable[[], None]) -> None:
        """Write, as long as there is room."""
        if not self.open:
            return
        try:
            with self._file.whole():
                write()
                if self._size > LARGEST:
                    self._finish({})
                    self._stop(f"it holds {LARGEST >> 20} MiB, its limit")
        except OSError as error:
            self._stop(error.strerror or str(error))

    def _stop(self, why: str) -> None:
        self.open, self.ended = False, why
        log.warning("the log %s ends: %s", self.path, why)

    def _messages(self, messages: Sequence[tuple[str, int, bytes]]) -> None:
        """Write topic, time (ns) and data of messages as one chunk."""
        records = bytearray()
        index: dict[int, list[tuple[int, int]]] = {}
        for topic, time, data in messages:
            channel, at = self._channel(topic, KINDS[topic]), max(time, 0)
            index.setdefault(channel, []).append((at, len(records)))
            records += packed(Message(channel_id=channel, log_time=at, data=data, publish_time=at, sequence=0))
        self._size += len(records)
        self._file.chunk(bytes(records), {channel: np.array(rows, dtype=np.uint64) for channel, rows in index.items()})

    def _tracked(self, name: str, rows: Array) -> None:
        flown = track(rows)
        stamps = (self.begins + np.rint(flown.time * 1e9).astype(np.int64)).astype(np.uint64)
        columns = {
            "sec": (stamps // 10**9 % 2**31).astype(np.int32),
            "nanosec": (stamps % 10**9).astype(np.uint32),
            "body_velocity": into_body(flown.attitude, flown.velocity),
            **{column: getattr(flown, column) for column in ("position", "attitude", "rate")},
        }
        data, index, start = b"", {}, 0
        for topic, kind, layout in ((f"/{name}/odometry", ODOMETRY, odometry), ("/tf", KINDS["/tf"], transform)):
            channel, built = self._channel(topic, kind), layout(0, name)
            dtype, template = headed(built.dtype(), bytes(built.data), channel)
            buffer = bytearray(template * len(rows))
            messages: Any = np.frombuffer(buffer, dtype=dtype)
            messages["head"]["log_time"] = messages["head"]["publish_time"] = stamps
            for slot in messages["data"].dtype.names:
                messages["data"][slot] = columns[slot]
            offsets = (start + np.arange(len(rows)) * dtype.itemsize).astype(np.uint64)
            index[channel] = np.column_stack([stamps, offsets])
            data, start = data + bytes(buffer), start + len(buffer)
        self._size += len(data)
        self._file.chunk(data, index)

    def _channel(self, topic: str, kind: str) -> int:
        if topic not in self._channels:
            self._channels[topic] = self._file.channel(topic, kind, definition(kind))
        return self._channels[topic]
