#!/usr/bin/env python3
"""Compares the mattes of a project with true ones.

TRUTH holds a folder per photo with a PNG per object, as large as the photo, whose alpha is the truth
(`projects/piazza/make.py --mattes TRUTH`). Printed per photo and object, over the pixels that show the object's
rectangle: the mean absolute error of alpha, the share of pixels on the wrong side of one half, the same two for
the pixels whose true alpha is neither 0 nor 1, and the share that is not known.

    matte_truth.py PROJECT TRUTH

Run `quadratura matte PROJECT` before. Needs numpy and Pillow.
"""

import argparse
import io
import json
import pathlib
import urllib.parse

import numpy as np
from PIL import Image

UNKNOWN = 1


def mattes(file):
    """The object, the rectangle, alpha and what is known, of each matte of a photo."""
    data = file.read_bytes()
    line = data.index(b"\n")
    at = line + 1
    for entry in json.loads(data[:line])["mattes"]:
        pictures = []
        for length in entry["bytes"]:
            pictures.append(np.array(Image.open(io.BytesIO(data[at : at + length]))))
            at += length
        yield entry["object"], entry["rect"], pictures[0][..., 3] / 255, pictures[1]


def truth(file, rect):
    x, y, w, h = rect
    picture = Image.open(file)
    alpha = np.array(picture.getchannel("A") if "A" in picture.getbands() else picture.convert("L"))
    return (alpha / (65535 if alpha.max() > 255 else 255))[y : y + h, x : x + w]


def errors(found, true, where):
    if not where.any():
        return "-", "-"
    off = np.abs(found - true)[where].mean()
    wrong = ((found >= 0.5) != (true >= 0.5))[where].mean()
    return f"{off:.4f}", f"{100 * wrong:.1f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("project", type=pathlib.Path)
    parser.add_argument("truth", type=pathlib.Path)
    chosen = parser.parse_args()
    rows = [("photo", "object", "off", "wrong", "off, mixed", "wrong, mixed", "not known")]
    for file in sorted((chosen.project / "cache" / "mattes").glob("*.bin")):
        photo = urllib.parse.unquote(file.name[: -len(".bin")])
        for name, rect, alpha, known in mattes(file):
            if not (chosen.truth / photo / f"{name}.png").exists():
                continue
            true = truth(chosen.truth / photo / f"{name}.png", rect)
            shown = known > 0
            mixed = shown & (true > 1 / 32) & (true < 31 / 32)
            unknown = f"{100 * (known == UNKNOWN)[shown].mean():.1f} %"
            rows.append((photo, name, *errors(alpha, true, shown), *errors(alpha, true, mixed), unknown))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


if __name__ == "__main__":
    main()
