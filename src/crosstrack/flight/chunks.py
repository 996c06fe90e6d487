"""An MCAP file written a chunk at a time, each on the disk's side of the process before the next begins.

The mcap library's own writer takes one message at a time, 10 µs each; this one takes a chunk of messages
already laid out, and leaves the other records to the library.
Source: the MCAP format specification, version 0.
"""

import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

Index = NDArray[np.uint64]
"""(n, 2): log time in ns and offset of the messages of one channel in a chunk"""


class ChunkWriter:
    """Write one file, from its magic to its index."""

    def __init__(self, path: Path) -> None:
        self._stream = path.open("wb")
        self._position = 0
        self._checksum = 0
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._declared = b""
        self._indexes: list[McapRecord] = []
        self._statistics = Statistics(
            message_count=0,
            schema_count=0,
            channel_count=0,
            attachment_count=0,
            metadata_count=0,
            chunk_count=0,
            message_start_time=0,
            message_end_time=0,
            channel_message_counts={},
        )
        self._write(MCAP0_MAGIC + packed(Header("ros2", "crosstrack")))

    def metadata(self, name: str, values: dict[str, str]) -> None:
        """Write texts by name."""
        offset, length = self._write(packed(Metadata(name, values)))
        self._indexes.append(MetadataIndex(offset, length, name))
        self._statistics.metadata_count += 1
        self._stream.flush()

    def attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file into the file."""
        offset, length = self._write(packed(Attachment(0, 0, name, media_type, data)))
        self._indexes.append(
            AttachmentIndex(
                offset=offset,
                length=length,
                log_time=0,
                create_time=0,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )
        self._statistics.attachment_count += 1

    def channel(self, topic: str, kind: str, definition: str) -> int:
        """Declare a topic of ROS messages, in the next chunk; return its number."""
        name = kind.replace("/", "/msg/")
        schema = next((known for known in self._schemas if known.name == name), None)
        if schema is None:
            schema = Schema(len(self._schemas) + 1, definition.encode(), "ros2msg", name)
            self._schemas.append(schema)
            self._declared += packed(schema)
        channel = Channel(len(self._channels) + 1, topic, "cdr", {}, schema.id)
        self._channels.append(channel)
        self._declared += packed(channel)
        return channel.id

    def chunk(self, messages: bytes, index: Mapping[int, Index]) -> None:
        """Write message records as one compressed chunk and hand it to the system.

        Args:
            messages: the records, end to end
            index: of every channel in them; offsets are into `messages`
        """
        times = np.concatenate([entries[:, 0] for entries in index.values()])
        first, last = int(times.min()), int(times.max())
        data = self._declared + messages
        shift = np.array([0, len(self._declared)], dtype=np.uint64)
        self._declared = b""
        compressed = zstandard.compress(data)
        start, length = self._write(packed(Chunk("zstd", compressed, last, first, zlib.crc32(data), len(data))))
        end = self._position
        offsets = {channel: self._write(packed_index(channel, rows + shift))[0] for channel, rows in index.items()}
        self._stream.flush()
        self._indexes.append(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression="zstd",
                compressed_size=len(compressed),
                message_end_time=last,
                message_index_length=self._position - end,
                message_index_offsets=offsets,
                message_start_time=first,
                uncompressed_size=len(data),
            )
        )
        self._count(index, first, last)

    def close(self) -> None:
        """Write the index and close the file."""
        self._write(packed(DataEnd(self._checksum)))
        self._statistics.schema_count = len(self._schemas)
        self._statistics.channel_count = len(self._channels)
        summary = packed(*self._schemas, *self._channels, self._statistics, *self._indexes)
        start = self._position
        unsigned = packed(Footer(start, 0, 0))[:-4]
        footer = packed(Footer(start, 0, zlib.crc32(summary + unsigned)))
        self._write(summary + footer + MCAP0_MAGIC)
        self._stream.close()

    @contextmanager
    def whole(self) -> Iterator[None]:
        """Let the file go where writing it fails, such as on a full disk."""
        try:
            yield
        except OSError:
            with suppress(OSError):
                self._stream.close()
            raise

    def _write(self, data: bytes) -> tuple[int, int]:
        """Append bytes; return where they begin and how many they are."""
        start = self._position
        self._stream.write(data)
        self._checksum = zlib.crc32(data, self._checksum)
        self._position += len(data)
        return start, len(data)

    def _count(self, index: Mapping[int, Index], first: int, last: int) -> None:
        statistics = self._statistics
        statistics.message_start_time = min(first, statistics.message_start_time if statistics.chunk_count else first)
        statistics.message_end_time = max(last, statistics.message_end_time)
        statistics.chunk_count += 1
        for channel, rows in index.items():
            statistics.message_count += len(rows)
            counts = statistics.channel_message_counts
            counts[channel] = counts.get(channel, 0) + len(rows)


def packed(*records: McapRecord) -> bytes:
    """Return records as bytes, end to end."""
    builder: Any = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


def packed_index(channel: int, rows: Index) -> bytes:
    """Return a MessageIndex record, without a step for every message."""
    builder: Any = RecordBuilder()
    builder.start_record(Opcode.MESSAGE_INDEX)
    builder.write2(channel)
    builder.write4(rows.nbytes)
    builder.write(rows.astype("<u8").tobytes())
    builder.finish_record()
    return bytes(builder.end())


HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
"""what stands before the data of a message, without gaps"""


def headed(layout: np.dtype[np.void], template: bytes, channel: int) -> tuple[np.dtype[np.void], bytes]:
    """Return the type and the template of a message record from those of its data."""
    head = np.zeros(1, dtype=HEAD)
    head["opcode"] = Opcode.MESSAGE
    head["length"] = HEAD.itemsize - 9 + len(template)
    head["channel"] = channel
    return np.dtype([("head", HEAD), ("data", layout)]), head.tobytes() + template
