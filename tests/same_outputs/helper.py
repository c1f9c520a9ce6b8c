"""Help for tests/same_outputs.sh, with the standard library alone.

    helper.py paint FOLDER                 paints on one layer of a folder export
    helper.py compare OLD NEW RENAMED      compares two folders, lists the files that differ; status 1 if any does
"""

import json
import re
import struct
import sys
import zlib
from itertools import zip_longest
from pathlib import Path

# Keys whose values no two runs have alike: when it was, and how long it took.
OF_A_RUN = re.compile(r"^(time|.*seconds|.*_ms)$")
# In this file, hashes of when documents were written.
TAKEN = re.compile(r'("stamp": ")[0-9a-f]{64}(")')
# Points of time in strings.
TIMES = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d)?(\.\d+)?(Z| UTC)?")
# Durations in messages.
DURATIONS = re.compile(r"\b\d+(\.\d+)? ?(ms|s|min)\b")
# Times of files in nanoseconds since 1970: no other number that is written is as large.
NANOSECONDS = 10**17
# Locks say which process holds them, stamps when files of this run were written.
LEFT_OUT = re.compile(r"\.lock$|/cache/stamps/")


class Png:
    """An RGBA PNG of 8 or 16 bits, not interlaced."""

    def __init__(self, path):
        self.path, data = path, path.read_bytes()
        self.before, self.after, packed, at = [], [], b"", 8
        while at < len(data):
            length, kind = struct.unpack(">I4s", data[at : at + 8])
            body = data[at + 8 : at + 8 + length]
            if kind == b"IDAT":
                packed += body
            else:
                (self.after if packed else self.before).append((kind, body))
            at += 12 + length
        self.width, self.height, self.bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", self.before[0][1])
        self.is_rgba = colour == 6 and interlaced == 0
        self.rows = self.unfiltered(zlib.decompress(packed)) if self.is_rgba else []

    def unfiltered(self, raw):
        pixel, rows = 4 * self.bits // 8, []
        above = bytearray(self.width * pixel)
        for y in range(self.height):
            start = y * (len(above) + 1)
            kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + len(above)])
            for i in range(len(row) if kind else 0):
                a = row[i - pixel] if i >= pixel else 0
                b, c = above[i], above[i - pixel] if i >= pixel else 0
                if kind == 4:
                    p = a + b - c
                    apart = (abs(p - a), abs(p - b), abs(p - c))
                    guess = (a, b, c)[apart.index(min(apart))]
                else:
                    guess = (0, a, b, (a + b) // 2)[kind]
                row[i] = (row[i] + guess) & 255
            rows.append(row)
            above = row
        return rows

    def write(self):
        data = zlib.compress(b"".join(b"\0" + bytes(row) for row in self.rows), 1)
        chunks = self.before + [(b"IDAT", data)] + self.after
        packed = [
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
            for kind, body in chunks
        ]
        self.path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))


def paint(folder):
    """A disc with a soft rim, and an erased stripe, in the middle of the largest layer."""
    layers = [path for path in folder.rglob("*.png") if path.parent.name not in ("guides", "masks")]
    sizes = {path: struct.unpack(">II", path.read_bytes()[16:24]) for path in layers}
    layers.sort(key=lambda path: (-sizes[path][0] * sizes[path][1], str(path)))
    for path in [path for path in layers if not path.name.startswith(("merged", "photo", "reference"))]:
        png = Png(path)
        if not png.is_rgba:
            continue
        bytes_of, full = png.bits // 8, (1 << png.bits) - 1
        middle = (png.width // 2, png.height // 2)
        radius, painted = max(4, min(min(png.width, png.height) // 4, 90)), 0
        for y in range(max(0, middle[1] - radius), min(png.height, middle[1] + radius)):
            for x in range(max(0, middle[0] - radius), min(png.width, middle[0] + radius)):
                away = ((x - middle[0]) ** 2 + (y - middle[1]) ** 2) ** 0.5 / radius
                if away >= 1:
                    continue
                alpha = 0 if abs(y - middle[1]) < 2 else 1 if away < 0.8 else (1 - away) / 0.2
                colour = [(x * 5) % 256 / 255, 0.2, (y * 3) % 256 / 255, alpha]
                samples = b"".join(int(value * full).to_bytes(bytes_of, "big") for value in colour)
                png.rows[y][4 * bytes_of * x : 4 * bytes_of * (x + 1)] = samples
                painted += 1
        png.write()
        print(f"{painted} pixels painted on {path.relative_to(folder)}")
        return
    sys.exit(f"{folder} has no layer to paint on")


class Renamed:
    """The committed table of names that changed on purpose."""

    def __init__(self, path):
        self.fields, self.texts, self.gone = {}, [], []
        for line in path.read_text(encoding="utf-8").splitlines():
            if line and not line.startswith("#"):
                kind, old, *new = line.split("\t")
                if kind == "field":
                    self.fields[old] = new[0]
                elif kind == "text":
                    self.texts.append((old, new[0]))
                elif kind == "gone":
                    self.gone.append(old)
                else:
                    sys.exit(f"{path}: a line begins with {kind}, not with field, text or gone")

    def text(self, text):
        for old, new in self.texts:
            text = text.replace(old, new)
        return DURATIONS.sub("DURATION", TIMES.sub("TIME", text))

    def is_gone(self, note):
        return isinstance(note, dict) and any(str(note.get("text", "")).startswith(start) for start in self.gone)

    def value(self, value):
        if isinstance(value, dict):
            named = {self.fields.get(key, key): inner for key, inner in value.items()}
            return {key: "OF A RUN" if OF_A_RUN.match(key) else self.value(inner) for key, inner in named.items()}
        if isinstance(value, list):
            return [self.value(inner) for inner in value if not self.is_gone(inner)]
        if isinstance(value, int) and value >= NANOSECONDS:
            return "TIME"
        return self.text(value) if isinstance(value, str) else value

    def json(self, data):
        """JSON, or JSON a line; `None` where it is neither."""
        try:
            return self.value(json.loads(data))
        except ValueError:
            pass
        try:
            return [self.value(json.loads(line)) for line in data.splitlines() if line.strip()]
        except ValueError:
            return None


def first_difference(old, new, at=""):
    """Where two JSON values differ, in words."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key not in old or key not in new:
                return f"{at}.{key} is in {'the old' if key in old else 'the new'} one only"
            if old[key] != new[key]:
                return first_difference(old[key], new[key], f"{at}.{key}")
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (a, b) in enumerate(zip(old, new)):
            if a != b:
                return first_difference(a, b, f"{at}[{i}]")
    return f"{at}: {str(old)[:200]} and {str(new)[:200]}"


def compared(name, old, new, renamed):
    """How two files called `name` were compared, and how they differ; empty where they are the same."""
    a, b = old.read_bytes(), new.read_bytes()
    if a == b:
        return "byte for byte", ""
    if name.endswith(".json"):
        if name.endswith("/taken.json"):
            a, b = (TAKEN.sub(r"\1OF A RUN\2", text.decode()) for text in (a, b))
        a, b = renamed.json(a), renamed.json(b)
        same = a is not None and a == b
        return "as JSON", "" if same else f": {first_difference(a, b)}"
    if name.startswith("said/"):
        a, b = (renamed.text(text.decode(errors="replace")) for text in (a, b))
        pairs = zip_longest(a.splitlines(), b.splitlines(), fillvalue="(nothing)")
        return "as messages", next((f": {x!r} and {y!r}" for x, y in pairs if x != y), "")
    place = next((i for i, (x, y) in enumerate(zip(a, b)) if x != y), min(len(a), len(b)))
    return "byte for byte", f", from byte {place} on ({len(a)} and {len(b)} bytes)"


def compare(old, new, renamed):
    def names_of(folder):
        files = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
        return {name for name in files if not LEFT_OUT.search(name)}

    names = [names_of(old), names_of(new)]
    different = [
        f"{name} was written by the {'old' if name in names[0] else 'new'} program alone"
        for name in sorted(names[0] ^ names[1])
    ]
    counts = {"byte for byte": [0, 0], "as JSON": [0, 0], "as messages": [0, 0]}
    for name in sorted(names[0] & names[1]):
        how, difference = compared(name, old / name, new / name, renamed)
        if difference:
            different.append(f"{name}{difference}")
            continue
        counts[how][0] += 1
        counts[how][1] += (old / name).stat().st_size
    if different:
        sys.exit("".join(f"DIFFERENT: {line}\n" for line in different) + f"{len(different)} files differ")
    kinds = {}
    for name in names[0]:
        kinds[Path(name).suffix or "others"] = kinds.get(Path(name).suffix or "others", 0) + 1
    files, size = (sum(count[i] for count in counts.values()) for i in (0, 1))
    if files == 0:
        sys.exit("DIFFERENT: nothing was written at all")
    print(f"the same: {files} files, {size:,} bytes")
    for how, (count, size) in counts.items():
        print(f"  {how}: {count} files, {size:,} bytes")
    print("  " + ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())))


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "paint":
        paint(Path(sys.argv[2]))
    elif len(sys.argv) == 5 and sys.argv[1] == "compare":
        compare(Path(sys.argv[2]), Path(sys.argv[3]), Renamed(Path(sys.argv[4])))
    else:
        sys.exit(__doc__)


main()
