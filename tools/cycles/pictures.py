# Float EXR files by scan lines into arrays, and arrays into PNG.
import struct
import zlib

import numpy


def text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


# The channels as float32 arrays [height][width] by name, and the attributes that are strings.
def read_exr(path):
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != 20000630 or version & 0x1A00:  # tiles, deep data, several parts
        raise ValueError(f"{path}: not an EXR file of scan lines in one part")
    attributes, at = {}, 8
    while data[at]:
        name, at = text(data, at)
        kind, at = text(data, at)
        (length,) = struct.unpack_from("<i", data, at)
        attributes[name] = (kind, data[at + 4:at + 4 + length])
        at += 4 + length
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names = channel_names(attributes["channels"][1], path)
    compression = attributes["compression"][1][0]
    lines = {0: 1, 1: 1, 2: 1, 3: 16}.get(compression)  # none, RLE, ZIPS, ZIP: scan lines a block
    if lines is None:
        raise ValueError(f"{path}: compression {compression} is not read; none, RLE, ZIPS and ZIP are")

    picture = numpy.empty((height, len(names), width), numpy.float32)
    blocks = -(-height // lines)
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, length = struct.unpack_from("<ii", data, offset)
        rows = picture[y - y0:y - y0 + lines]
        block = data[offset + 8:offset + 8 + length]
        if length < rows.nbytes:  # a block that does not shrink is stored as it is
            block = unpredicted(without_runs(block) if compression == 1 else zlib.decompress(block))
        rows[:] = numpy.frombuffer(block, "<f4").reshape(rows.shape)
    strings = {name: value.decode() for name, (kind, value) in attributes.items() if kind == "string"}
    return {name: picture[:, i] for i, name in enumerate(names)}, strings


def channel_names(data, path):
    names, at = [], 0
    while data[at]:
        name, at = text(data, at)
        if struct.unpack_from("<i", data, at)[0] != 2:
            raise ValueError(f"{path}: channel {name} is not 32-bit float")
        names.append(name)
        at += 16
    return names


# RLE counts: n below 0 before -n bytes as they are, others before a byte that is there n + 1 times.
def without_runs(data):
    parts, at = [], 0
    while at < len(data):
        n = data[at] - 256 if data[at] > 127 else data[at]
        if n < 0:
            parts.append(data[at + 1:at + 1 - n])
        else:
            parts.append(data[at + 1:at + 2] * (n + 1))
        at += 1 - n if n < 0 else 2
    return b"".join(parts)


# RLE and ZIP hold differences of bytes, first those at even places, then those at odd ones.
def unpredicted(data):
    steps = numpy.frombuffer(data, numpy.uint8).astype(numpy.uint64)
    steps[1:] -= numpy.uint64(128)
    values = numpy.cumsum(steps).astype(numpy.uint8)
    half = (len(values) + 1) // 2
    result = numpy.empty_like(values)
    result[0::2], result[1::2] = values[:half], values[half:]
    return result.tobytes()


# rgb: [height][width][3], 0..1, encoded.
def write_png(path, rgb):
    height, width, _ = rgb.shape
    bytes_ = (numpy.clip(numpy.nan_to_num(rgb), 0, 1) * 255 + 0.5).astype(numpy.uint8).reshape(height, width * 3)
    lines = numpy.hstack([numpy.zeros((height, 1), numpy.uint8), bytes_]).tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines, 6)) +
                     chunk(b"IEND", b""))
