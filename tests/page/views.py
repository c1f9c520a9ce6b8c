"""Makes views of a page that no photo was taken from: python3 tests/page/views.py PAGE HELD_OUT OUT

Writes cameras for `render` to OUT/sparse, and the same for the page, whose photos are p001 and so on, to OUT/views.json: those of
HELD_OUT (COLMAP's text), and some between two photos. The page has to keep the coordinates of the world (--keep-coordinates).
"""

import json
import math
import os
import re
import sys

SIZE, FOCAL = (480, 270), 380
BETWEEN = [(0, 1, 0.5), (0, 2, 0.4), (1, 8, 0.3), (2, 4, 0.35), (3, 5, 0.3), (1, 2, 0.6)]


def rotation(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def quaternion(r):
    w = math.sqrt(max(0, 1 + r[0][0] + r[1][1] + r[2][2])) / 2
    part = lambda a, b, c, sign: math.copysign(math.sqrt(max(0, 1 + a * r[0][0] + b * r[1][1] + c * r[2][2])) / 2, sign)
    return [w, part(1, -1, -1, r[2][1] - r[1][2]), part(-1, 1, -1, r[0][2] - r[2][0]), part(-1, -1, 1, r[1][0] - r[0][1])]


def main(page, held_out, out):
    text = open(os.path.join(page, "data/site.js")).read()
    site = json.loads(re.match(r"quadratura\.describe\((.*)\);\n$", text, re.S).group(1))
    views = []
    for line in open(os.path.join(held_out, "images.txt")):
        fields = line.split()
        if len(fields) == 10 and not line.startswith("#"):
            r, t = rotation([float(v) for v in fields[1:5]]), [float(v) for v in fields[5:8]]
            views.append((f"h{len(views) + 1}", r, [-sum(r[i][k] * t[i] for i in range(3)) for k in range(3)]))
    photos = [([p["rotation"][0:3], p["rotation"][3:6], p["rotation"][6:9]], p["centre"]) for p in site["photos"]]
    for number, (a, b, share) in enumerate(BETWEEN):
        (ra, ca), (rb, cb) = photos[a], photos[b]
        qa, qb = quaternion(ra), quaternion(rb)
        if sum(x * y for x, y in zip(qa, qb)) < 0:
            qb = [-v for v in qb]
        q = [x * (1 - share) + y * share for x, y in zip(qa, qb)]
        long = math.sqrt(sum(v * v for v in q))
        views.append((f"m{number + 1}", rotation([v / long for v in q]), [x * (1 - share) + y * share for x, y in zip(ca, cb)]))
    os.makedirs(os.path.join(out, "sparse"), exist_ok=True)
    width, height = SIZE
    open(os.path.join(out, "sparse/cameras.txt"), "w").write(f"1 PINHOLE {width} {height} {FOCAL} {FOCAL} {width / 2} {height / 2}\n")
    open(os.path.join(out, "sparse/points3D.txt"), "w").write("")
    with open(os.path.join(out, "sparse/images.txt"), "w") as images:
        for number, (name, r, c) in enumerate(views):
            t = [-sum(r[i][k] * c[k] for k in range(3)) for i in range(3)]
            images.write(" ".join(str(v) for v in [number + 1, *quaternion(r), *t, 1, name + ".jpg"]) + "\n\n")
    described = [{"name": n, "centre": c, "rotation": sum(r, []), "lens": [FOCAL, FOCAL, width / 2, height / 2], "size": SIZE} for n, r, c in views]
    json.dump(described, open(os.path.join(out, "views.json"), "w"))


if __name__ == "__main__":
    main(*sys.argv[1:])
