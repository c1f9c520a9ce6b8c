#!/usr/bin/env python3
"""How like trees from images are to all of their polygons: the table of docs/quality.md.

    trees.py QUADRATURA WORK [--plants maple oak] [--sides 400 120 ...]

Eight views around each plant, 8 degrees above the horizontal and between those of `--cameras orbit`, in squares of several
sides, by each method and quality, with `tree render --compare`. Told are means over the views, and the light of the view
that is off most. WORK is a folder for pictures and for the plants' images, which are kept from run to run.
"""

import argparse
import json
import math
import pathlib
import subprocess

METHODS = {
    "flakes of slabs": ["--method", "flakes"],
    "flakes of layers": ["--method", "flakes", "--flakes-of", "layers"],
    "layers": ["--method", "layers"],
    "planes": ["--method", "planes"],
}
# Of the views: how many, the field in degrees that the plant's ball fills, degrees above the horizontal.
AROUND, FIELD, ABOVE = 8, 40.0, 8.0


def told(command):
    return json.loads(subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout)


def camera_path(ball, side):
    """A camera path whose keyframes are the views, one a second and one frame a second."""
    distance = ball["radius"] / math.sin(math.radians(FIELD / 2))
    level, rise = math.cos(math.radians(ABOVE)), math.sin(math.radians(ABOVE))

    def keyframe(i):
        angle = 2 * math.pi * (i + 0.5) / AROUND
        outwards = [level * math.cos(angle), level * math.sin(angle), rise]
        eye = [middle + distance * along for middle, along in zip(ball["middle"], outwards)]
        return {"t": i, "position": eye, "look_at": ball["middle"], "fov": FIELD}

    keyframes = [keyframe(i) for i in range(AROUND)]
    return {"version": 1, "size": [side, side], "fps": 1, "up": [0, 0, 1], "keyframes": keyframes}


def figures(options, plant, side, method, quality):
    path = options.work / f"{plant}-{side}.json"
    ball = told([options.quadratura, "--json", "tree", "info", plant])["ball"]
    path.write_text(json.dumps(camera_path(ball, side)))
    images = options.work / f"{plant}-images"
    command = [options.quadratura, "--json", "tree", "render", plant, "--cameras", path, "--compare"]
    command += ["--quality", quality, "--images", images, "--out", options.work / "pictures", *METHODS[method]]
    views = [view["similarity"] for view in told(command)["compared"]]
    assert len(views) == AROUND, f"{len(views)} views"

    def mean(key):
        return sum(view[key] for view in views) / len(views)

    worst = max((view["light"] - 1 for view in views), key=abs)
    rows = round(mean("height_px"))
    percent = [f"{100 * value:+.1f} %" for value in (mean("coverage") - 1, mean("light") - 1, worst)]
    return rows, [f"{mean('ssim'):.3f}", *percent]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("quadratura", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--plants", nargs="+", default=["maple", "oak"])
    parser.add_argument("--sides", nargs="+", type=int, default=[400, 120, 40, 16, 8])
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    columns = "SSIM | coverage | light | worst"
    print(f"| | rows | | preview: {columns} | final: {columns} |", flush=True)
    print("|---" * 11 + "|", flush=True)
    for plant in options.plants:
        for i, side in enumerate(options.sides):
            for j, method in enumerate(METHODS):
                rows, preview = figures(options, plant, side, method, "preview")
                _, final = figures(options, plant, side, method, "final")
                names = [plant if i == j == 0 else "", str(rows) if j == 0 else "", method]
                print("| " + " | ".join(names + preview + final) + " |", flush=True)


if __name__ == "__main__":
    main()
