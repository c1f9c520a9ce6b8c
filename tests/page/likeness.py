"""How alike two pictures are, where the expected one covers its pixels wholly. Python's standard library alone."""

import math
import struct
import zlib


def read_png(file):
    """Returns width, height and RGBA bytes of a PNG with 8 bits a channel that is not interlaced."""
    data = open(file, "rb").read()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
            assert depth == 8 and colour in (2, 6), (depth, colour)
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    parts = 4 if colour == 6 else 3
    raw, stride, rows, above = zlib.decompress(packed), parts * width, [], bytes(parts * width)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left = row[i - parts] if i >= parts else 0
            up, corner = above[i], above[i - parts] if i >= parts else 0
            if kind == 1:
                row[i] = (row[i] + left) & 255
            elif kind == 2:
                row[i] = (row[i] + up) & 255
            elif kind == 3:
                row[i] = (row[i] + (left + up) // 2) & 255
            elif kind == 4:
                guess = left + up - corner
                by = [(abs(guess - left), 0, left), (abs(guess - up), 1, up), (abs(guess - corner), 2, corner)]
                row[i] = (row[i] + min(by)[2]) & 255
        rows.append(bytes(row))
        above = row
    if parts == 3:
        rows = [b"".join(row[i:i + 3] + b"\xff" for i in range(0, stride, 3)) for row in rows]
    return width, height, b"".join(rows)


def likeness(expected, shown):
    """Returns the PSNR in dB over the pixels of `expected` that are opaque."""
    width, height, a = read_png(expected)
    size, b = (width, height), read_png(shown)
    assert size == b[:2], (size, b[:2])
    b = b[2]
    total = count = 0
    for at in range(0, 4 * width * height, 4):
        if a[at + 3] == 255:
            total += (a[at] - b[at]) ** 2 + (a[at + 1] - b[at + 1]) ** 2 + (a[at + 2] - b[at + 2]) ** 2
            count += 3
    return 10 * math.log10(255 ** 2 * count / max(total, 1))


def where_opaque(expected, shown):
    """Returns the colours of RGBA bytes with the opacity of others."""
    found = bytearray(shown)
    found[3::4] = expected[3::4]
    return bytes(found)


# Changes are those of means over squares of so many pixels: a thin line that moves from one pixel to the next does not pop.
SQUARE = 4


def squares(width, height, values):
    """Yields the sums of R, G and B over each square of RGBA bytes; None where one is not wholly opaque."""
    for top in range(0, height - SQUARE + 1, SQUARE):
        for left in range(0, width - SQUARE + 1, SQUARE):
            rows = [values[4 * (y * width + left):4 * (y * width + left + SQUARE)] for y in range(top, top + SQUARE)]
            opaque = all(row[3::4].count(255) == SQUARE for row in rows)
            yield [sum(sum(row[c::4]) for row in rows) for c in range(3)] if opaque else None


def largest_changes(pictures):
    """Returns by how much the mean of a square changes from each picture to the next, at most; pictures are width, height, RGBA bytes."""
    before, found = None, []
    for picture in pictures:
        after = list(squares(*picture))
        if before:
            pairs = [(a, b) for a, b in zip(before, after) if a and b]
            found.append(max(abs(x - y) for a, b in pairs for x, y in zip(a, b)) / SQUARE / SQUARE)
        before = after
    return found

