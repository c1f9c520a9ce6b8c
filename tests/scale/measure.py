"""Measures each step of the program on synthetic towns of several sizes (tests/scale.sh)."""

import os
import shutil
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

# The view that is rendered, and the photo to which steps of one photo apply.
PHOTO = "0003.jpg"
VIEW = "960x540"
MIB = 1024 * 1024


def run(command):
    """Runs a command; returns its processor seconds, seconds by the clock, and peak memory in MiB."""
    began = time.monotonic()
    with open(os.devnull, "w") as nowhere:
        child = subprocess.Popen([str(part) for part in command], stdout=nowhere, stderr=subprocess.PIPE)
        said = child.stderr.read().decode(errors="replace")
        _, status, used = os.wait4(child.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    child.returncode = code
    if code != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with status {code}:\n{said[-2000:]}")
    return used.ru_utime + used.ru_stime, time.monotonic() - began, used.ru_maxrss / 1024


def on_disk(folder):
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file()) / MIB


def beside(town, folder):
    """Writes the cameras of a view half a metre beside a photo; returns their folder."""
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(town / "sparse/cameras.txt", folder)
    (folder / "points3D.txt").write_text("")
    for line in (town / "sparse/images.txt").read_text().splitlines()[::2]:
        words = line.split()
        if words[9] == PHOTO:
            words[5] = str(float(words[5]) + 0.5)
            (folder / "images.txt").write_text(" ".join(words) + "\n\n")
            return folder
    sys.exit(f"{town}: there is no photo {PHOTO}")


def block_mask(file, width, height):
    """Writes a white PNG with a black block of 40 x 40 pixels."""
    rows = bytearray()
    for y in range(height):
        row = bytearray(b"\xff" * width)
        if 500 <= y < 540:
            row[700:740] = bytes(40)
        rows += b"\0" + row
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = [b"\x89PNG\r\n\x1a\n", chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(bytes(rows))), chunk(b"IEND", b"")]
    file.write_bytes(b"".join(parts))


def steps(program, town, work, photos):
    """Yields name, whether it concerns all photos, and the command of each step, in order."""
    project, out = work / f"project-{photos}", work / f"out-{photos}"
    for folder in (project, out):
        shutil.rmtree(folder, ignore_errors=True)
    out.mkdir()
    site = ["--photos", town / "photos", "--cameras", town / "sparse", "--model", town / "town.obj"]
    view = beside(town, out / "view")
    yield "new", True, [program, "new", project, *site]
    yield "check", True, [program, "check", project]
    yield "build", True, [program, "build", project]
    yield "fill", True, [program, "fill", project]
    yield "update, nothing to do", True, [program, "update", project]
    yield "info", True, [program, "info", project]
    yield "render one view", False, [program, "render", project, "--cameras", view, "--size", VIEW, "--out", out / "render"]
    yield "score one photo", False, [program, "score", project, "--cameras", view, "--photos", town / "photos"]
    yield "export one photo", False, [program, "export", project, "--photo", PHOTO, "--out", out / "export"]
    yield "one layered image", False, [program, "ldi", "build", project, "--photo", PHOTO, "--out", out / "photo.ldi"]
    width, height = map(int, (town / "sparse/cameras.txt").read_text().split()[2:4])
    block_mask(out / "mask.png", width, height)
    yield "mask one photo", False, [program, "mask", project, "--photo", PHOTO, "--add", out / "mask.png"]
    yield "update, one mask", False, [program, "update", project]
    photo = town / "photos" / PHOTO
    kept = photo.read_bytes()
    # Decoders ignore what follows the end of the image.
    photo.write_bytes(kept + b"changed")
    try:
        yield "update, one photo", False, [program, "update", project]
    finally:
        photo.write_bytes(kept)


def main():
    program, work, numbers = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), [int(n) for n in sys.argv[3:]]
    costs = {}
    for photos in numbers:
        print(f"\n{photos} photos        processor s   a photo   clock s   memory MiB   disk MiB", flush=True)
        for name, of_all, command in steps(program, work / f"town-{photos}", work, photos):
            processor, clock, memory = run(command)
            each = processor / photos if of_all else processor
            costs[name, photos] = (each, memory)
            by_photo = f"{each:9.3f}" if of_all else " " * 9
            disk = on_disk(work / f"project-{photos}")
            print(f"{name:22}{processor:12.1f} {by_photo} {clock:9.1f} {memory:12.0f} {disk:10.1f}", flush=True)
    few, many = min(numbers), max(numbers)
    if few < many:
        print(f"\n{many} photos against {few}: processor time (of a photo, where a step concerns all), memory a further photo")
        for name in dict.fromkeys(name for name, _ in costs):
            (time_few, memory_few), (time_many, memory_many) = costs[name, few], costs[name, many]
            growth = (memory_many - memory_few) / (many - few)
            print(f"{name:22}{time_many / max(time_few, 1e-3):9.2f} times {growth:10.2f} MiB")


main()
