#!/usr/bin/env python3
"""Compares the mattes of a project with true ones.

TRUTH holds a folder per photo with a PNG per object, as large as the photo, whose grey or alpha is the truth
(`projects/piazza/make.py --mattes TRUTH`). Printed per photo and object, and for all together:

- over the pixels that show the object's rectangle, the mean absolute error of alpha and the share of pixels on the
  wrong side of one half;
- the same two for the band, the pixels that were solved;
- with --yardstick, the same two for the band as pymatting solves it in closed form from the same known pixels, in
  linear light;
- the share of the pixels that is in the band, and the share of which nothing is known.

    matte_truth.py PROJECT TRUTH [--yardstick PHOTOS]

Run `quadratura matte PROJECT` before. Needs numpy and Pillow, the yardstick pymatting, too.
"""

import argparse
import io
import json
import pathlib
import urllib.parse

import numpy as np
from PIL import Image

UNKNOWN, SOLVED = 1, 3


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
    """The sums of absolute errors and of pixels on the wrong side, and the number of pixels."""
    wrong = (found >= 0.5) != (true >= 0.5)
    return np.array([np.abs(found - true)[where].sum(), wrong[where].sum(), where.sum()], float)


def shown(sums):
    off, wrong, count = sums
    return (f"{off / count:.4f}", f"{100 * wrong / count:.1f} %") if count else ("-", "-")


def linear(samples):
    value = samples / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def yardstick(photo, rect, alpha, known):
    """Alpha as pymatting solves it, from the pixels that were decided; pixels that show something else count as 0."""
    import pymatting

    x, y, w, h = rect
    picture = np.array(Image.open(photo).convert("RGB"))[y : y + h, x : x + w]
    trimap = np.where(known == SOLVED, 0.5, np.where(known == 0, 0.0, np.round(alpha)))
    if not ((trimap == 0).any() and (trimap == 1).any()):
        return None
    return pymatting.estimate_alpha_cf(linear(picture), trimap)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("project", type=pathlib.Path)
    parser.add_argument("truth", type=pathlib.Path)
    parser.add_argument("--yardstick", type=pathlib.Path, metavar="PHOTOS", help="the folder of the photos")
    chosen = parser.parse_args()
    rows = [("photo", "object", "off", "wrong", "band off", "wrong", "pymatting off", "wrong", "band", "not known")]
    total = np.zeros((3, 3))
    for file in sorted((chosen.project / "cache" / "mattes").glob("*.bin")):
        photo = urllib.parse.unquote(file.name[: -len(".bin")])
        for name, rect, alpha, known in mattes(file):
            true_file = chosen.truth / photo / f"{name}.png"
            if not true_file.exists():
                continue
            true, band = truth(true_file, rect), known == SOLVED
            sums = np.array([errors(alpha, true, known > 0), errors(alpha, true, band), np.zeros(3)])
            if chosen.yardstick and band.any():
                other = yardstick(chosen.yardstick / photo, rect, alpha, known)
                sums[2] = errors(other, true, band) if other is not None else sums[1]
            total += sums
            shares = [f"{100 * part[known > 0].mean():.1f} %" for part in (band, known == UNKNOWN)]
            rows.append((photo, name, *(cell for part in sums for cell in shown(part)), *shares))
    share = f"{100 * total[1, 2] / max(total[0, 2], 1):.1f} %"
    rows.append(("all", "", *(cell for part in total for cell in shown(part)), share, ""))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())


if __name__ == "__main__":
    main()
