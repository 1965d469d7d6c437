"""Frames of telemetry, as the documentation of fos_embedded::telemetry describes them: postcard and its CRC-32 in COBS, ended by a zero."""

import struct
import zlib
from typing import NamedTuple


class Sample(NamedTuple):
    tick: int
    still: bool
    measured: list
    quantities: list
    innovations: list
    validity: list


class Reader:
    def __init__(self, content):
        self.content, self.at = content, 0

    def varint(self):
        value = shift = 0
        while True:
            byte = self.content[self.at]
            self.at += 1
            value |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return value

    def floats(self):
        count = self.varint()
        self.at += 4 * count
        return list(struct.unpack_from(f"<{count}f", self.content, self.at - 4 * count))


def unstuff(frame):
    """Content of a COBS frame without its zero; None if it is damaged."""
    content, at = bytearray(), 0
    while at < len(frame):
        block = frame[at]
        if at + block > len(frame):
            return None
        content += frame[at + 1:at + block]
        at += block
        if block < 0xFF and at < len(frame):
            content.append(0)
    return bytes(content)


def decode(stream):
    """Samples of the complete frames in a stream, number of damaged frames, and the bytes after the last frame."""
    samples, damaged = [], 0
    *frames, rest = bytes(stream).split(b"\0")
    for frame in filter(None, frames):
        content = unstuff(frame)
        if not content or len(content) < 5 or zlib.crc32(content[:-4]) != int.from_bytes(content[-4:], "little"):
            damaged += 1
            continue
        reader = Reader(content)
        # 0 is a start frame
        if reader.varint() == 1:
            tick, still = reader.varint(), reader.varint() == 1
            values = [reader.floats() for _ in range(3)]
            samples.append(Sample(tick, still, *values, [reader.varint() for _ in range(reader.varint())]))
    return samples, damaged, rest
