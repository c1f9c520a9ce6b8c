#!/usr/bin/env python3
"""Fills holes whose content is known, and says how near to it each way comes.

Holes are cut into the photos of a site (their alpha becomes 0), the site is built and filled, and what stands in
the holes then is compared with the photos as they were: by where it comes from, and beside OpenCV's inpainting
of the same holes, which knows one photo and no model. What would be invented where no photo helps is measured on
sites of one photo each.

    against_truth.py QUADRATURA PHOTOS SPARSE MODEL WORK [--first N] [--ignore NAME]... [--seed S]

SPARSE holds COLMAP's text files. WORK is a new or empty folder. Needs numpy, Pillow, opencv-python-headless.
"""

import argparse
import json
import math
import pathlib
import random
import shutil
import subprocess

import cv2
import numpy as np
from PIL import Image

# Radii of holes as shares of the longer side: a flower pot, a person, a car.
RADII = [0.01, 0.02, 0.04]
HOLES_OF_EACH = 6


def holes(size, seed):
    """A mask of discs, True where the photo is cut out."""
    dice = random.Random(seed)
    width, height = size
    y, x = np.mgrid[0:height, 0:width]
    mask = np.zeros((height, width), bool)
    for share in RADII:
        radius = share * max(size)
        for _ in range(HOLES_OF_EACH):
            cx, cy = dice.uniform(radius, width - radius), dice.uniform(radius, height - radius)
            mask |= (x - cx) ** 2 + (y - cy) ** 2 < radius**2
    return mask


def one_camera(sparse, name, folder):
    """The cameras with one photo alone."""
    folder.mkdir(parents=True)
    shutil.copy(sparse / "cameras.txt", folder)
    (folder / "points3D.txt").write_text("")
    lines = [line for line in (sparse / "images.txt").read_text().splitlines() if not line.startswith("#")]
    poses = [line for line in lines if line.split() and line.split()[-1] == name and len(line.split()) == 10]
    (folder / "images.txt").write_text(poses[0] + "\n\n")


def run(program, *typed):
    subprocess.run([program, "-q", *map(str, typed)], check=True, stdout=subprocess.DEVNULL)


def filled(project, photo, ignore):
    """The picture that the filled stack of a photo gives, and where its pixels come from: 0 for the photo itself."""
    folder = project / "stacks" / photo
    stack = json.loads((folder / "stack.json").read_text())
    size = (stack["photo"]["height"], stack["photo"]["width"])
    picture, origin = np.zeros((*size, 3), np.uint8), np.full(size, -1)
    ignored = np.zeros(size, bool)
    for layer in reversed(stack["image_layers"]):
        x, y, w, h = layer["rect"]
        x0, y0, x1, y1 = max(x, 0), max(y, 0), min(x + w, size[1]), min(y + h, size[0])
        inner = (slice(y0 - y, y1 - y), slice(x0 - x, x1 - x))
        place = (slice(y0, y1), slice(x0, x1))

        def lay(file, of):
            texels = np.array(Image.open(folder / file).convert("RGBA"))[inner]
            there = texels[..., 3] > 0
            picture[place][there] = texels[there][:, :3]
            origin[place][there] = of[there] if isinstance(of, np.ndarray) else of
            ignored[place][there] = any(layer["name"].startswith(name) for name in ignore)

        if "filled_file" in layer:
            lay(layer["filled_file"], np.array(Image.open(folder / layer["provenance_file"])).astype(int)[inner])
        lay(layer["file"], 0)
    origin[ignored] = -1
    return picture, origin, stack.get("fill", {}).get("origins", [])


def psnr(error, count):
    return 10 * math.log10(255**2 * 3 * count / error) if count and error else float("nan")


class Tally:
    def __init__(self):
        self.error, self.count = {}, {}

    def add(self, name, picture, truth, where):
        squared = (picture[where].astype(float) - truth[where]) ** 2
        self.error[name] = self.error.get(name, 0) + squared.sum()
        self.count[name] = self.count.get(name, 0) + int(where.sum())

    def table(self, title):
        print(f"\n{title}\n{'':32}{'pixels':>10}{'PSNR':>8}")
        for name, count in self.count.items():
            print(f"{name:32}{count:10}{psnr(self.error[name], count):8.2f}")


def measure(program, options, names, mask_of, work):
    """What fills the holes where all photos help, and where each is alone."""
    together, alone = Tally(), Tally()
    cut = work / "cut"
    cut.mkdir(parents=True)
    truth, mask, cv = {}, {}, {}
    sparse = work / "sparse"
    shutil.copytree(options.sparse, sparse)
    text = (sparse / "images.txt").read_text()
    for name in names:
        photo = Image.open(options.photos / name).convert("RGB")
        truth[name], mask[name] = np.array(photo), mask_of(photo.size, name)
        alpha = np.where(mask[name], 0, 255).astype(np.uint8)
        png = pathlib.Path(name).with_suffix(".png").name
        Image.fromarray(np.dstack([truth[name], alpha])).save(cut / png, compress_level=1)
        text = text.replace(name, png)
        bgr = truth[name][..., ::-1].copy()
        bgr[mask[name]] = 0
        for way, flag in [("OpenCV, Telea", cv2.INPAINT_TELEA), ("OpenCV, Navier-Stokes", cv2.INPAINT_NS)]:
            cv[name, way] = cv2.inpaint(bgr, mask[name].astype(np.uint8), 5, flag)[..., ::-1]
    (sparse / "images.txt").write_text(text)

    def site(folder, cameras):
        run(program, "new", folder, "--photos", cut, "--cameras", cameras, "--model", options.model)
        run(program, "build", folder)

    def compare(tally, project, name, title, parts):
        png = pathlib.Path(name).with_suffix(".png").name
        picture, origin, origins = filled(project, png, options.ignore)
        covered = mask[name] & (origin > 0)
        tally.add(title, picture, truth[name], covered)
        if parts:
            photos = np.isin(origin, [i for i, o in enumerate(origins) if not o.startswith("[")])
            for part, where in [("  from photos", photos), ("  by example", origin == 2), ("  diffused", origin == 3)]:
                tally.add(part, picture, truth[name], covered & where)
        return covered

    project = work / "together"
    site(project, sparse)
    run(program, "fill", project)
    for name in names:
        covered = compare(together, project, name, "filled", True)
        for way in ["OpenCV, Telea", "OpenCV, Navier-Stokes"]:
            together.add(way, cv[name, way], truth[name], covered)
    for name in names:
        png = pathlib.Path(name).with_suffix(".png").name
        project, cameras = work / "alone" / png, work / "cameras" / png
        one_camera(sparse, png, cameras)
        project.parent.mkdir(parents=True, exist_ok=True)
        site(project, cameras)
        run(program, "fill", project)
        covered = compare(alone, project, name, "filled", True)
        run(program, "fill", project, "--invent", "diffusion")
        compare(alone, project, name, "all by diffusion", False)
        for way in ["OpenCV, Telea", "OpenCV, Navier-Stokes"]:
            alone.add(way, cv[name, way], truth[name], covered)
    together.table("All photos: holes of a photo are seen by others")
    alone.table("Each photo alone: what is in the holes has to be invented")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("quadratura")
    for name in ["photos", "sparse", "model", "work"]:
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--first", type=int, help="only so many photos")
    parser.add_argument("--ignore", action="append", default=[], help="layers whose names begin so")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    suffixes = {".jpg", ".jpeg", ".png"}
    names = sorted(p.name for p in options.photos.iterdir() if p.suffix.lower() in suffixes)[: options.first]
    mask_of = lambda size, name: holes(size, f"{options.seed} {name}")
    measure(options.quadratura, options, names, mask_of, options.work)


if __name__ == "__main__":
    main()
