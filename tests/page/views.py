"""Makes views of a page that no photo was taken from: python3 tests/page/views.py PAGE HELD_OUT OUT

Writes cameras for `render` to OUT/sparse, and the same for the page, whose photos are p001 and so on, to OUT/views.json: those of
HELD_OUT (COLMAP's text) and some between two photos ("between"), those of the photos themselves ("own"), and a walk of small steps
("step"). The page has to keep the coordinates of the world (--keep-coordinates).
"""

import json
import math
import os
import re
import sys

SIZE, FOCAL = (480, 270), 380
LENS = [FOCAL, FOCAL, SIZE[0] / 2, SIZE[1] / 2]
BETWEEN = [(0, 1, 0.5), (0, 2, 0.4), (1, 8, 0.3), (2, 4, 0.35), (3, 5, 0.3), (1, 2, 0.6)]
# A walk from one photo towards another: the steps, and their length in the world's units.
WALK, STEPS, STEP = (0, 1), 24, 0.01


def rotation(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def quaternion(r):
    w = math.sqrt(max(0, 1 + r[0][0] + r[1][1] + r[2][2])) / 2
    part = lambda a, b, c, sign: math.copysign(math.sqrt(max(0, 1 + a * r[0][0] + b * r[1][1] + c * r[2][2])) / 2, sign)
    return [w, part(1, -1, -1, r[2][1] - r[1][2]), part(-1, 1, -1, r[0][2] - r[2][0]), part(-1, -1, 1, r[1][0] - r[0][1])]


def centre_of(r, t):
    return [-sum(r[i][k] * t[i] for i in range(3)) for k in range(3)]


def held_out_poses(folder):
    for line in open(os.path.join(folder, "images.txt")):
        fields = line.split()
        if len(fields) == 10 and not line.startswith("#"):
            r = rotation([float(v) for v in fields[1:5]])
            yield r, centre_of(r, [float(v) for v in fields[5:8]])


def between(one, other, share):
    (ra, ca), (rb, cb) = one, other
    qa, qb = quaternion(ra), quaternion(rb)
    if sum(x * y for x, y in zip(qa, qb)) < 0:
        qb = [-v for v in qb]
    q = [x * (1 - share) + y * share for x, y in zip(qa, qb)]
    long = math.sqrt(sum(v * v for v in q))
    return rotation([v / long for v in q]), [x * (1 - share) + y * share for x, y in zip(ca, cb)]


def view(kind, name, pose, lens=LENS, size=SIZE):
    return {"kind": kind, "name": name, "centre": pose[1], "rotation": sum(pose[0], []), "lens": lens, "size": size}


def of_photo(name, photo, pose):
    """The photo's own camera, as wide as the other views."""
    scale = SIZE[0] / photo["size"][0]
    size = [SIZE[0], round(photo["size"][1] * scale)]
    return view("own", name, pose, [v * scale for v in photo["lens"]], size)


def views_of(site, held_out):
    photos = [([p["rotation"][0:3], p["rotation"][3:6], p["rotation"][6:9]], p["centre"]) for p in site["photos"]]
    yield from (view("between", f"h{i + 1}", pose) for i, pose in enumerate(held_out_poses(held_out)))
    yield from (view("between", f"m{i + 1}", between(photos[a], photos[b], share)) for i, (a, b, share) in enumerate(BETWEEN))
    yield from (of_photo(f"o{i + 1}", photo, pose) for i, (photo, pose) in enumerate(zip(site["photos"], photos)))
    start, end = photos[WALK[0]], photos[WALK[1]]
    far = math.dist(start[1], end[1])
    yield from (view("step", f"s{i + 1:02}", between(start, end, i * STEP / far)) for i in range(STEPS + 1))


def write_cameras(folder, views):
    """Cameras and poses as COLMAP's text."""
    os.makedirs(folder, exist_ok=True)
    open(os.path.join(folder, "points3D.txt"), "w").write("")
    with open(os.path.join(folder, "cameras.txt"), "w") as cameras, open(os.path.join(folder, "images.txt"), "w") as images:
        for number, of in enumerate(views, 1):
            r, c = [of["rotation"][i:i + 3] for i in (0, 3, 6)], of["centre"]
            t = [-sum(r[i][k] * c[k] for k in range(3)) for i in range(3)]
            cameras.write(" ".join(str(v) for v in [number, "PINHOLE", *of["size"], *of["lens"]]) + "\n")
            images.write(" ".join(str(v) for v in [number, *quaternion(r), *t, number, of["name"] + ".jpg"]) + "\n\n")


def main(page, held_out, out):
    text = open(os.path.join(page, "data/site.js")).read()
    site = json.loads(re.match(r"quadratura\.describe\((.*)\);\n$", text, re.S).group(1))
    views = list(views_of(site, held_out))
    write_cameras(os.path.join(out, "sparse"), views)
    json.dump(views, open(os.path.join(out, "views.json"), "w"))


if __name__ == "__main__":
    main(*sys.argv[1:])
