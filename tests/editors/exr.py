"""exr.py FILE.exr PHOTO STACK.json: OpenEXR reads the layers of a photo as they were written, and over each other they are the photo.

Parts have the rectangles of STACK.json as data windows and the photo as display window. Colours are half floats in linear light: laid over
each other, nearest first, they are compared with the part of the photo as stored bytes.
"""

import json
import sys

import numpy
import OpenEXR
from PIL import Image

# Bytes. Two programs decode a JPEG differently; half floats are rounded and summed.
SAME_PHOTO, SAME_LIGHT = 6, 0.5


def stored(light):
    light = numpy.clip(light, 0, 1)
    return 255.0 * numpy.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def main():
    file, photo, stack = sys.argv[1:]
    photo = numpy.asarray(Image.open(photo).convert("RGB")).astype(float)
    height, width = photo.shape[:2]
    layers = {layer["id"]: layer for layer in json.load(open(stack, encoding="utf-8"))["image_layers"]}
    # Channels by their own names, without R, G, B, A gathered to pictures.
    parts = OpenEXR.File(file, separate_channels=True).parts
    bad = []
    light, alpha = numpy.zeros((height, width, 3)), numpy.zeros((height, width, 1))
    orders = []
    for part in parts:
        header, channels = part.header, part.channels
        low, high = header["displayWindow"]
        if [*low, *high] != [0, 0, width - 1, height - 1]:
            bad.append(f"{part.name()}: display window {low} {high}")
        (x0, y0), (x1, y1) = [[int(v) for v in corner] for corner in header["dataWindow"]]
        token = part.name().split("_")[0]
        if token in layers:
            rect = layers.pop(token)["rect"]
            if [x0, y0, x1 - x0 + 1, y1 - y0 + 1] != rect:
                bad.append(f"{part.name()}: data window {x0} {y0} {x1} {y1}, expected {rect}")
            orders.append(header["quadratura:order"])
        elif part.name() not in ("photo", "depth", "leftovers"):
            bad.append(f"{part.name()}: no layer")
        if part.name() == "depth":
            depth = channels["Z"].pixels
            if depth.dtype != numpy.float32 or not (depth > 0).all():
                bad.append("depth: not above 0")
            continue
        rgba = numpy.stack([channels[name].pixels for name in "RGBA"], axis=-1)
        if rgba.dtype != numpy.float16:
            bad.append(f"{part.name()}: {rgba.dtype}")
        rgba = rgba.astype(float)
        if part.name() == "photo":
            off = numpy.abs(stored(rgba[..., :3]) - photo).max()
            if off > SAME_PHOTO:
                bad.append(f"photo: off by {off:.1f}")
            plate = stored(rgba[..., :3])
            continue
        # Under what is nearer.
        ys, xs = slice(max(y0, 0), min(y1 + 1, height)), slice(max(x0, 0), min(x1 + 1, width))
        inside = rgba[ys.start - y0:ys.stop - y0, xs.start - x0:xs.stop - x0]
        left = 1 - alpha[ys, xs]
        light[ys, xs] += left * inside[..., :3]
        alpha[ys, xs] += left * inside[..., 3:]
    if layers:
        bad.append(f"no part for {sorted(layers)}")
    if orders != sorted(orders):
        bad.append("not nearest first")
    covered = alpha[..., 0] > 0.999
    off = numpy.abs(stored(light) - plate).max(axis=2)[covered]
    share = float((off <= SAME_LIGHT).mean())
    if share < 0.9999:
        bad.append(f"{100 * share:.2f} % of the pixels are the photo's")
    for problem in bad:
        print(f"  {problem}")
    print(f"{len(parts)} parts; laid over each other {100 * share:.3f} % of {100 * covered.mean():.1f} % covered pixels are the photo's")
    sys.exit(1 if bad else 0)


main()
