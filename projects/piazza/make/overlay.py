"""Draws the coarse model's edges over the photos, to see by eye that model, cameras and photos belong together.

python overlay.py PROJECT OUT        (needs Pillow; reads piazza.obj, sparse/, photos/ and heldout/)
"""

import sys
from pathlib import Path

from PIL import Image, ImageDraw


def read_obj(path):
    vertices, faces = [], []
    for line in open(path):
        word, *rest = line.split()
        if word == "v":
            vertices.append(tuple(map(float, rest)))
        elif word == "f":
            faces.append([int(i) - 1 for i in rest])
    return vertices, faces


def read_cameras(folder):
    """[(name, (fx, fy, cx, cy), rotation rows, translation)]"""
    lines = [l.split() for l in open(folder / "cameras.txt") if l.strip() and l[0] != "#"]
    intrinsics = {l[0]: tuple(map(float, l[4:8])) for l in lines}
    lines = [l for l in open(folder / "images.txt") if l[0] != "#"]
    for words in (l.split() for l in lines[::2]):
        w, x, y, z, *t = map(float, words[1:8])
        rotation = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
        yield words[9], intrinsics[words[8]], rotation, t


def draw_edge(draw, a, b, k):
    """An edge between two points of the camera frame, cut at a plane just before the lens."""
    near = 0.05
    if a[2] < near and b[2] < near:
        return
    if a[2] < near or b[2] < near:
        s = (near - a[2]) / (b[2] - a[2])
        cut = tuple(p + s * (q - p) for p, q in zip(a, b))
        a, b = (cut, b) if a[2] < near else (a, cut)
    fx, fy, cx, cy = k
    draw.line([(fx * p[0] / p[2] + cx, fy * p[1] / p[2] + cy) for p in (a, b)], fill=(255, 0, 80), width=1)


def main():
    project, out = map(Path, sys.argv[1:3])
    out.mkdir(parents=True, exist_ok=True)
    vertices, faces = read_obj(project / "piazza.obj")
    for part in (project, project / "heldout"):
        for name, k, rotation, t in read_cameras(part / "sparse"):
            image = Image.open(part / "photos" / name).convert("RGB")
            draw = ImageDraw.Draw(image)
            seen = [tuple(sum(r[i] * v[i] for i in range(3)) + s for r, s in zip(rotation, t)) for v in vertices]
            for face in faces:
                for i, j in zip(face, face[1:] + face[:1]):
                    draw_edge(draw, seen[i], seen[j], k)
            image.save(out / name)


if __name__ == "__main__":
    main()
