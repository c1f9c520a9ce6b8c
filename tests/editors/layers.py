"""Reads layered files with psd-tools, which shares no code with this project, and compares them.

    layers.py stack FILE PROJECT PHOTO PHOTO-FILE
        FILE (PSD, PSB) is exactly the stack of PHOTO in PROJECT: groups, names, places, locks, every pixel
    layers.py same BEFORE AFTER [--painted TOKEN] [--cropped] [--key]
        AFTER, which an editor saved, is BEFORE but for the layer that was painted on; with --cropped
        layers may have lost transparent surroundings, with --key the document key has to be there
    layers.py picture FILE PHOTO-FILE [--about]
        the PNG that an editor made of all visible layers is the photo; --about where the editor converted
        it to a colour profile of its own: within a thousandth
    layers.py name FILE
        prints the name of a layer that is fit to be painted on: visible, at least 20 x 20 pixels

Exit status 0 and one line when all is well, else what is wrong.
"""

import argparse
import json
import pathlib
import re
import struct
import sys
import urllib.parse
import zlib

import numpy as np
from PIL import Image
from psd_tools import PSDImage
from psd_tools.constants import Resource, Tag

REFERENCE = "photo - reference, do not paint here"
LEFTOVERS = "leftovers - do not paint here"
MARGIN = 8
LOCK_ALL = 0x80000000
JPEG = 8  # what two decoders of JPEG may differ by, of 255


def require(condition, message):
    if not condition:
        sys.exit(f"wrong: {message}")


# --- pictures as integers ---------------------------------------------------------------------


def read_png16(data):
    """RGBA, 16 bits, not interlaced. (Pillow reduces these to 8 bits.)"""
    width, height = struct.unpack(">II", data[16:24])
    packed, at = b"", 8
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        packed += data[at + 8 : at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * 8)
    rows, above = [], np.zeros(width * 8, np.uint8)
    for line in lines:
        above = unfiltered(line[0], line[1:].copy(), above)
        rows.append(above)
    return np.stack(rows).view(">u2").astype(np.uint16).reshape(height, width, 4)


def unfiltered(kind, line, above, step=8):
    """PNG, section 9.2, pixel by pixel."""
    line, above = line.reshape(-1, step).astype(int), above.reshape(-1, step).astype(int)
    left, corner = np.zeros(step, int), np.zeros(step, int)
    for pixel, up in zip(line, above):
        if kind == 1:
            pixel += left
        elif kind == 2:
            pixel += up
        elif kind == 3:
            pixel += (left + up) // 2
        elif kind == 4:
            a, b, c = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
            pixel += np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))
        pixel %= 256
        left, corner = pixel, up
    return line.astype(np.uint8).reshape(-1)


def read_picture(path):
    """Height x width x 4, 8 or 16 bits; opaque where the file has no alpha."""
    data = pathlib.Path(path).read_bytes()
    if data[1:4] == b"PNG" and data[24:26] == b"\x10\x06":
        return read_png16(data)
    return np.asarray(Image.open(path).convert("RGBA"))


def integers(values, depth):
    """psd-tools gives 0..1 in single precision, which holds 16 bits exactly."""
    full = 2**depth - 1
    return np.rint(values.astype(np.float64) * full).astype(np.uint16 if depth == 16 else np.uint8)


def on_white(pixels):
    full = int(np.iinfo(pixels.dtype).max)
    alpha = pixels[..., 3:].astype(np.uint64)
    mixed = (pixels[..., :3] * alpha + full * (full - alpha) + full // 2) // full
    return mixed.astype(pixels.dtype)


# --- layers -----------------------------------------------------------------------------------


class Layer:
    def __init__(self, layer, depth):
        self.name = layer.name.rstrip("\0")  # Krita appends one
        groups = []
        while layer.parent is not None and layer.parent.kind == "group":
            groups.append(layer.parent.name.rstrip("\0"))
            layer = layer.parent
        self.groups = groups

    @staticmethod
    def read(layer, depth):
        found = Layer(layer, depth)
        found.visible = layer.visible
        found.rect = (layer.left, layer.top, layer.width, layer.height)
        found.pixels = np.zeros((0, 0, 4), np.uint8)
        if layer.width and layer.height:
            found.pixels = integers(layer.numpy(), depth)
        found.locked = layer.tagged_blocks.get_data(Tag.PROTECTED_SETTING) == LOCK_ALL
        return found

    def cropped(self):
        """Place and pixels of all that is not fully transparent."""
        alpha = self.pixels[..., 3] if self.pixels.size else np.zeros((0, 0))
        rows, columns = np.flatnonzero(alpha.any(1)), np.flatnonzero(alpha.any(0))
        if not rows.size:
            return (0, 0, 0, 0), None
        top, left = rows[0], columns[0]
        pixels = self.pixels[top : rows[-1] + 1, left : columns[-1] + 1].copy()
        pixels[pixels[..., 3] == 0] = 0
        rect = (self.rect[0] + left, self.rect[1] + top, pixels.shape[1], pixels.shape[0])
        return tuple(int(number) for number in rect), pixels


class Document:
    def __init__(self, path):
        self.psd = PSDImage.open(path)
        self.depth = self.psd.depth
        self.size = (self.psd.width, self.psd.height)
        pixel_layers = [layer for layer in self.psd.descendants() if not layer.is_group()]
        self.layers = [Layer.read(layer, self.depth) for layer in pixel_layers]
        self.groups = [group.name.rstrip("\0") for group in self.psd.descendants() if group.is_group()]

    def resource(self, kind):
        return self.psd.image_resources.get_data(kind)

    def key(self):
        found = re.search(rb"<dc:identifier>(.*?)</dc:identifier>", self.resource(Resource.XMP_METADATA) or b"")
        found = found or re.search(rb'dc:identifier="(.*?)"', self.resource(Resource.XMP_METADATA) or b"")
        return found and found.group(1).decode()


# --- the commands -----------------------------------------------------------------------------


def check_stack(file, project, photo, photo_file):
    folder = pathlib.Path(project) / "stacks" / urllib.parse.quote(photo, safe="")
    stack = json.loads((folder / "stack.json").read_text())
    document, picture = Document(file), read_picture(photo_file)
    require(document.size == (stack["photo"]["width"], stack["photo"]["height"]), f"canvas {document.size}")
    orders = sorted({layer["order"] for layer in stack["image_layers"]}, reverse=True)
    found = [int(re.match(r"order (\d+)", name).group(1)) for name in document.groups]
    require(found == orders, f"groups {document.groups} for orders {orders}")
    for layer in stack["image_layers"]:
        check_image_layer(document, layer, folder)
    check_reference(document, picture, is_jpeg(photo_file))
    check_guides(document, stack, folder)
    helpers = sum(layer.name.startswith("guide ") for layer in document.layers) + 1
    helpers += check_leftovers(document, stack)
    require(len(document.layers) == len(stack["image_layers"]) + helpers, "number of layers")
    require(len({layer.name for layer in document.layers}) == len(document.layers), "names are not unique")
    require(document.key(), "no document key")
    return f"{len(stack['image_layers'])} image layers in {len(orders)} groups, {document.depth} bits"


def check_image_layer(document, layer, folder):
    found = [candidate for candidate in document.layers if candidate.name.endswith(f"[{layer['id']}]")]
    require(len(found) == 1, f"{len(found)} layers with the token {layer['id']}")
    found, (x, y, w, h), (nx, ny, nw, nh) = found[0], layer["rect"], layer["needed_rect"]
    left, top = max(x, nx - MARGIN), max(y, ny - MARGIN)
    right, bottom = min(x + w, nx + nw + MARGIN), min(y + h, ny + nh + MARGIN)
    require(found.rect == (left, top, right - left, bottom - top), f"{found.name} lies at {found.rect}")
    require(found.visible and len(found.name) <= 63, f"{found.name}: hidden, or its name is too long")
    require(found.groups[0].startswith(f"order {layer['order']}"), f"{found.name} is in {found.groups}")
    expected = read_picture(folder / layer["file"])[top - y : bottom - y, left - x : right - x].copy()
    # Beside what is shown a stack's layers keep the photo's colour, transparent; exports do not.
    expected[expected[..., 3] == 0] = 0
    require(np.array_equal(found.pixels, expected), f"{found.name}: other pixels than in the stack")


def check_leftovers(document, stack):
    """The number of layers of leftovers, which show the photo at exactly their pixels, in front of all others."""
    if not stack.get("leftovers"):
        return 0
    found = document.layers[-1]
    require((found.name, found.locked, found.groups) == (LEFTOVERS, True, []), "the leftovers")
    expected, shown = (np.zeros(document.size[::-1], bool) for _ in range(2))
    for y, x0, x1 in stack["leftovers"]:
        expected[y, x0:x1] = True
    paste(shown, found.pixels[..., 3] > 0, found.rect)
    require(np.array_equal(shown, expected), "the leftovers show other pixels")
    x, y, w, h = found.rect
    photo = document.layers[0].pixels[y : y + h, x : x + w]
    opaque = found.pixels[..., 3] > 0
    require(np.array_equal(found.pixels[opaque], photo[opaque]), "the leftovers are not the photo's pixels")
    return 1


def check_reference(document, picture, lossy):
    reference = document.layers[0]
    require((reference.name, reference.locked, reference.groups) == (REFERENCE, True, []), "the reference")
    require(reference.rect == (0, 0, *document.size), f"the reference lies at {reference.rect}")
    compare(reference.pixels, picture, JPEG * lossy, "the reference")
    merged = integers(document.psd.numpy("color"), document.depth)
    compare(merged, on_white(picture), JPEG * lossy, "the merged picture")


def is_jpeg(file):
    return pathlib.Path(file).suffix.lower() in (".jpg", ".jpeg")


def compare(found, expected, tolerance, what):
    require(found.dtype == expected.dtype, f"{what} has samples of {found.dtype}, not {expected.dtype}")
    difference = np.abs(found.astype(int) - expected.astype(int)).max()
    require(difference <= tolerance, f"{what} differs by {difference}")


def check_guides(document, stack, folder):
    """Each guide shows exactly what is needed and not visible in its group."""
    for order in {layer["order"] for layer in stack["image_layers"]}:
        hidden = np.zeros(document.size[::-1], bool)
        for layer in (layer for layer in stack["image_layers"] if layer["order"] == order):
            needed = np.asarray(Image.open(folder / layer["needed_file"]).convert("L")) > 0
            clear = read_picture(folder / layer["file"])[..., 3] == 0
            paste(hidden, needed & clear, layer["rect"])
        guides = [layer for layer in document.layers if layer.name.startswith(f"guide {order} ")]
        require(len(guides) == hidden.any(), f"{len(guides)} guides for order {order}")
        shown = np.zeros_like(hidden)
        for guide in guides:
            require(not guide.visible, f"{guide.name} is not hidden")
            paste(shown, guide.pixels[..., 3] > 0, guide.rect)
        require(np.array_equal(shown, hidden), f"the guide of order {order} shows something else")


def paste(canvas, part, rect):
    x, y, w, h = rect
    top, left = max(0, y), max(0, x)
    bottom, right = min(canvas.shape[0], y + h), min(canvas.shape[1], x + w)
    if top < bottom and left < right:
        canvas[top:bottom, left:right] |= part[top - y : bottom - y, left - x : right - x]


def check_same(before, after, painted, cropped, key):
    before, after = Document(before), Document(after)
    require(after.size == before.size and after.depth == before.depth, f"{after.size} of {after.depth} bits")
    require(after.groups == before.groups, f"groups {after.groups}, before {before.groups}")
    names = [[layer.name for layer in document.layers] for document in (before, after)]
    require(names[0] == names[1], f"layers {names[1]}, before {names[0]}")
    changed = 0
    for old, new in zip(before.layers, after.layers):
        require((new.visible, new.groups) == (old.visible, old.groups), f"{new.name} in {new.groups}")
        if cropped:
            (rect, pixels), (old_rect, old_pixels) = new.cropped(), old.cropped()
        else:
            rect, pixels, old_rect, old_pixels = new.rect, new.pixels, old.rect, old.pixels
        if painted and new.name.endswith(f"[{painted}]"):
            changed += not np.array_equal(pixels, old_pixels)
            continue
        require(rect == old_rect, f"{new.name} lies at {rect}, before at {old_rect}")
        require(np.array_equal(pixels, old_pixels), f"{new.name}: other pixels than before")
    require(changed == bool(painted), f"the painted layer {painted} is as before")
    require(not key or after.key() == before.key() != None, f"document key {after.key()}")
    return f"{len(after.layers)} layers came back" + (", all but the painted one unchanged" if painted else "")


def check_picture(file, photo_file, about):
    found, expected = read_picture(file), read_picture(photo_file)
    visible = expected[..., 3] > 0
    tolerance = np.iinfo(expected.dtype).max // 1000 if about else JPEG * is_jpeg(photo_file)
    compare(found[visible][:, :3], expected[visible][:, :3], tolerance, "the picture")
    return "all visible layers together are the photo"


def fit_to_be_painted_on(file):
    for layer in Document(file).layers:
        if layer.name.endswith("]") and min(layer.rect[2:]) >= 20 and min(layer.rect[:2]) >= 0:
            return layer.name
    sys.exit("no layer is large enough")


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(dest="command", required=True)
    for name, arguments in {
        "stack": ["file", "project", "photo", "photo_file"],
        "same": ["before", "after"],
        "picture": ["file", "photo_file"],
        "name": ["file"],
    }.items():
        command = commands.add_parser(name)
        for argument in arguments:
            command.add_argument(argument)
        if name == "picture":
            command.add_argument("--about", action="store_true")
        if name == "same":
            command.add_argument("--painted")
            command.add_argument("--cropped", action="store_true")
            command.add_argument("--key", action="store_true")
    arguments = vars(parser.parse_args())
    checks = {"stack": check_stack, "same": check_same, "picture": check_picture, "name": fit_to_be_painted_on}
    print(checks[arguments.pop("command")](**arguments))


if __name__ == "__main__":
    main()
