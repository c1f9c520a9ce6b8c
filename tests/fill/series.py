#!/usr/bin/env python3
"""How the cost of `fill` grows with what is hidden: the sample project, its photos made smaller.

    series.py QUADRATURA PHOTOS SPARSE MODEL WORK [--shares 0.25 0.5 ...]

SPARSE holds COLMAP's text files with PINHOLE cameras. WORK is a new or empty folder. Gains and relief are made before
the clock starts; told are seconds of processor time, whatever else runs. Needs Pillow.
"""

import argparse
import json
import os
import pathlib
import subprocess

from PIL import Image


def smaller(options, share, folder):
    """Photos and cameras at a share of their size; sparse points are left out."""
    (folder / "photos").mkdir(parents=True)
    (folder / "sparse").mkdir()
    for photo in sorted(options.photos.iterdir()):
        picture = Image.open(photo)
        size = [round(side * share) for side in picture.size]
        picture.resize(size, Image.Resampling.BOX).save(folder / "photos" / photo.name, quality=92)
    lines = [line for line in (options.sparse / "cameras.txt").read_text().splitlines() if line and line[0] != "#"]
    cameras = []
    for line in lines:
        number, kind, *values = line.split()
        width, height, *rest = [float(value) * share for value in values]
        cameras.append(" ".join([number, kind, str(round(width)), str(round(height)), *map(str, rest)]))
    (folder / "sparse" / "cameras.txt").write_text("\n".join(cameras) + "\n")
    lines = [line for line in (options.sparse / "images.txt").read_text().splitlines() if not line.startswith("#")]
    poses = [line for line in lines if len(line.split()) == 10 and not line.split()[-1][0].isdigit()]
    poses = poses or [line for line in lines[::2] if line]
    (folder / "sparse" / "images.txt").write_text("".join(f"{line}\n\n" for line in poses))
    (folder / "sparse" / "points3D.txt").write_text("")


def run(*typed):
    """What a command prints as JSON, and its seconds of processor time."""
    before = os.times()
    done = subprocess.run([*map(str, typed), "-q", "--json"], check=True, capture_output=True)
    after = os.times()
    seconds = after.children_user - before.children_user + after.children_system - before.children_system
    return json.loads(done.stdout), seconds


def hidden(project):
    stacks = (json.loads(path.read_text()) for path in (project / "stacks").glob("*/stack.json"))
    return sum(stack["fill"]["texels_hidden"] for stack in stacks)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("quadratura")
    for name in ["photos", "sparse", "model", "work"]:
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--shares", type=float, nargs="+", default=[0.25, 0.5, 0.75, 1.0])
    options = parser.parse_args()
    print(f"{'hidden texels':>14}{'exemplar, s':>14}{'diffusion, s':>14}{'the same, us a texel':>22}")
    for share in options.shares:
        folder = options.work / f"{share}"
        smaller(options, share, folder)
        project, sparse = folder / "project", folder / "sparse"
        run(options.quadratura, "new", project, "--photos", folder / "photos", "--cameras", sparse, "--model", options.model)
        run(options.quadratura, "build", project)
        run(options.quadratura, "fill", project)
        texels = hidden(project)
        times = [
            run(options.quadratura, "fill", project, "--force", "--invent", way)[1] for way in ["exemplar", "diffusion"]
        ]
        print(f"{texels:14}{times[0]:14.1f}{times[1]:14.1f}{1e6 * times[1] / texels:22.2f}", flush=True)


if __name__ == "__main__":
    main()
