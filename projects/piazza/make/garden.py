"""The detailed ground, fountain, trees, climbing plants and stone benches."""

import random
from math import cos, pi, sin, sqrt

from mathutils import Vector

import plan
from meshes import Builder
from shapes import Frame, circle


def ground(scene, m):
    b, reach, rng = Builder(), 90.0, random.Random(5)
    b.poly([(-reach, -reach, 0), (reach, -reach, 0), (reach, reach, 0), (-reach, reach, 0)], m["cobbles"])
    for band in rings_and_spokes():
        slab_row(b, m, rng, *band)
    for x0, y0, x1, y1 in ((-15, -12.6, -14.1, 11.4), (14.1, -11.1, 15, 10.8), (-8, 13.2, 10.5, 14)):
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        long_in_x = x1 - x0 > y1 - y0
        slab_row(b, m, rng, *(corners if long_in_x else corners[1:] + corners[:1]), 0.004)
    slab_row(b, m, rng, (-10, -12), (15, -12), (15, -11.1), (-10, -11.1), 0.004)
    scene.add("ground", b)


def slab_row(b, m, rng, p0, p1, q1, q0, z):
    """Slabs of about 0.9 m between the edges p0-p1 and q0-q1, with open joints."""
    length = sqrt((p1[0] - p0[0]) ** 2 + (p1[1] - p0[1]) ** 2)
    count = max(1, round(length / 0.9))
    joint = 0.005 / length
    between = lambda a, c, t: (a[0] + (c[0] - a[0]) * t, a[1] + (c[1] - a[1]) * t, z)
    cuts = [0.0] + [(k + rng.uniform(-0.2, 0.2)) / count for k in range(1, count)] + [1.0]
    for t0, t1 in zip(cuts, cuts[1:]):
        ends = (
            between(p0, p1, t0 + joint),
            between(p0, p1, t1 - joint),
            between(q0, q1, t1 - joint),
            between(q0, q1, t0 + joint),
        )
        b.poly(ends, m["band"], rng.random())


def rings_and_spokes():
    """Travertine bands in the cobbles: octagons about the fountain, and spokes between them and beyond."""
    cx, cy = plan.FOUNTAIN.centre
    for inner, outer in ((4.7, 5.15), (5.55, 5.7), (8.1, 8.25), (8.6, 9.1)):
        low, high = circle((cx, cy), inner, 8, pi / 8), circle((cx, cy), outer, 8, pi / 8)
        for i in range(8):
            j = (i + 1) % 8
            yield high[i], high[j], low[j], low[i], 0.005
    for i in range(8):
        a = pi / 8 + pi / 4 * i
        u, n = (cos(a), sin(a)), (-sin(a) * 0.21, cos(a) * 0.21)
        for r0, r1 in ((5.1, 8.65), (9.05, 13.0 if u[1] > -0.5 else 11.2)):
            corner = lambda r, s: (cx + u[0] * r + s * n[0], cy + u[1] * r + s * n[1])
            yield corner(r0, -1), corner(r1, -1), corner(r1, 1), corner(r0, 1), 0.0035


# --- fountain --------------------------------------------------------------------------------------------


def octagons(rings):
    return [[(x, y, z) for x, y in circle(plan.FOUNTAIN.centre, r, 8, pi / 8)] for r, z in rings]


def fountain(scene, m, c):
    (step, rise), (basin, rim) = c.step, c.basin
    inner = basin - c.wall
    b = Builder()
    b.polygon_prism(
        octagons([(step - 0.02, 0), (step, rise - 0.03), (step - 0.03, rise), (basin - 0.1, rise)]), m["step"]
    )
    scene.add("fountain.step", b)
    b = Builder()
    b.polygon_prism(
        octagons(
            [
                (basin + 0.06, rise),
                (basin + 0.06, rise + 0.1),
                (basin - 0.02, rise + 0.14),
                (basin - 0.05, rim - 0.18),
                (basin, rim - 0.15),
                (basin + 0.045, rim - 0.09),
                (basin + 0.045, rim - 0.02),
                (basin + 0.02, rim),
                (inner + 0.02, rim),
                (inner, rim - 0.03),
                (inner, 0.1),
            ]
        ),
        m["marble"],
    )
    panels(b, m, basin, rise, rim)
    b.polygon_prism(octagons([(inner, 0.2), (0.0, 0.2)]), m["marble"])
    scene.add("fountain.basin", b)
    b = Builder()
    b.poly(octagons([(inner + 0.01, c.water)])[0], m["water"])
    scene.add("fountain.water", b)
    pedestal(scene, m, c)
    jets(scene, m, c)


def panels(b, m, basin, rise, rim):
    """A framed panel on each side of the basin."""
    corners = circle(plan.FOUNTAIN.centre, basin - 0.035, 8, pi / 8)
    for i in range(8):
        p, q = corners[i], corners[(i + 1) % 8]
        length = sqrt((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2)
        f = Frame(p[0], p[1], "south")
        f.u = ((q[0] - p[0]) / length, (q[1] - p[1]) / length)
        f.out = (f.u[1], -f.u[0])
        v0, v1 = rise + 0.2, rim - 0.22
        line = [(0.25, v0), (length - 0.25, v0), (length - 0.25, v1), (0.25, v1)]
        b.moulded_line(f, line, [(0.0, -0.02), (0.0, 0.03), (0.045, 0.03), (0.045, -0.02)], m["marble"], closed=True)


def pedestal(scene, m, c):
    radius, high = c.column
    b = Builder()
    b.revolve(
        c.centre,
        [
            (0.62, 0.3),
            (0.62, 0.78),
            (0.52, 0.84),
            (0.36, 0.9),
            (0.40, 0.98),
            (0.30, 1.06),
            (0.24, 1.2),
            (0.27, 1.42),
            (0.38, 1.62),
            (0.40, 1.72),
            (0.30, 1.8),
            (0.36, 1.88),
            (0.40, high),
        ],
        m["marble"],
        48,
    )
    scene.add("fountain.column", b)
    low, wide, z0, z1 = c.bowl
    b = Builder()
    b.revolve(
        c.centre,
        [
            (low * 0.95, z0),
            (low + 0.2, z0 + 0.03),
            (wide * 0.72, z0 + 0.14),
            (wide * 0.92, z0 + 0.27),
            (wide * 0.97, z1 - 0.05),
            (wide, z1 - 0.03),
            (wide, z1),
            (wide - 0.06, z1),
            (wide - 0.1, z1 - 0.06),
            (wide * 0.6, z1 - 0.08),
        ],
        m["marble"],
        64,
        lobes=16,
        lobe_depth=0.035,
    )
    b.poly([(x, y, z1 - 0.035) for x, y in circle(c.centre, wide - 0.07, 48)], m["water"])
    scene.add("fountain.bowl", b)
    r, z0, z1 = c.top
    b = Builder()
    h = z1 - z0
    b.revolve(
        c.centre,
        [
            (r * 1.25, z0 - 0.1),
            (r * 1.2, z0 + 0.08 * h),
            (r * 0.7, z0 + 0.2 * h),
            (r * 0.6, z0 + 0.34 * h),
            (r * 1.1, z0 + 0.5 * h),
            (r * 1.2, z0 + 0.62 * h),
            (r * 0.9, z0 + 0.8 * h),
            (r * 0.4, z0 + 0.95 * h),
            (0.0, z1),
        ],
        m["marble"],
        32,
        lobes=8,
        lobe_depth=0.1,
    )
    scene.add("fountain.top", b)


def jets(scene, m, c):
    """Eight thin streams that fall from the bowl, and the ring of foam where they land."""
    b = Builder()
    _, wide, _, z1 = c.bowl
    rng = random.Random(3)
    for i in range(16):
        a = 2 * pi * (i + 0.5) / 16
        points = []
        for k in range(15):
            t = k / 14 * 0.595
            r, z = wide - 0.01 + 0.42 * t, z1 - 4.905 * t * t
            points.append((c.centre[0] + r * cos(a), c.centre[1] + r * sin(a), max(z, c.water)))
        stream(b, m, points, 0.011 + 0.006 * rng.random())
    scene.add("fountain.bowl", b)


def stream(b, m, points, width):
    for k, (p, q) in enumerate(zip(points, points[1:])):
        w0, w1 = (width * (1 + 0.06 * (k + e)) for e in (0, 1))
        for dx, dy in ((1, 0), (0, 1)):
            b.poly(
                [
                    (p[0] - w0 * dx, p[1] - w0 * dy, p[2]),
                    (p[0] + w0 * dx, p[1] + w0 * dy, p[2]),
                    (q[0] + w1 * dx, q[1] + w1 * dy, q[2]),
                    (q[0] - w1 * dx, q[1] - w1 * dy, q[2]),
                ],
                m["spray"],
            )


# --- plants ----------------------------------------------------------------------------------------------


def random_direction(rng):
    z, a = rng.uniform(-1, 1), rng.uniform(0, 2 * pi)
    r = sqrt(1 - z * z)
    return Vector((r * cos(a), r * sin(a), z))


def leaf(b, material, centre, normal, size, rng, slender=0.55):
    """Four corners of a leaf, folded a little along its rib."""
    side = normal.cross(random_direction(rng)).normalized()
    tip = normal.cross(side)
    fold = normal * size * 0.12
    points = [
        centre - tip * size,
        centre + side * size * slender - fold,
        centre + tip * size,
        centre - side * size * slender - fold,
    ]
    first = len(b.vertices)
    b.vertices.extend(tuple(p) for p in points)
    tint = min(1.0, max(0.0, rng.gauss(0.5, 0.28)))
    b.face((first, first + 1, first + 2), material, tint)
    b.face((first, first + 2, first + 3), material, tint)


def limb(b, m, points, radii):
    """A tapered branch along a line."""
    rings = []
    for i, (p, r) in enumerate(zip(points, radii)):
        along = (points[min(i + 1, len(points) - 1)] - points[max(i - 1, 0)]).normalized()
        side = along.orthogonal().normalized()
        other = along.cross(side)
        rings.append([p + side * r * cos(2 * pi * k / 9) + other * r * sin(2 * pi * k / 9) for k in range(9)])
    for low, high in zip(rings, rings[1:]):
        for k in range(9):
            b.poly([tuple(v) for v in (low[k], low[(k + 1) % 9], high[(k + 1) % 9], high[k])], m["bark"], smooth=True)


def tree(scene, m, name, x, y, trunk, height, radius, leaves=60000):
    rng, b = random.Random(name), Builder()
    crown = Vector((x, y, (trunk + height) / 2 + 0.1))
    half = (height - trunk) / 2
    clumps = []
    while len(clumps) < 34:
        d = random_direction(rng) * rng.random() ** 0.4
        p = crown + Vector((d.x * radius * 0.78, d.y * radius * 0.78, d.z * half * 0.8))
        size = rng.uniform(0.42, 0.78) * radius / 2.2
        if all((p - q).length > 0.35 for q, _ in clumps):
            clumps.append((p, size))
    fork = Vector((x + rng.uniform(-0.1, 0.1), y + rng.uniform(-0.1, 0.1), trunk))
    limb(
        b,
        m,
        [Vector((x, y, 0)), Vector((x, y, 0.25)), Vector((x + 0.05, y - 0.03, trunk * 0.5)), fork],
        [0.24, 0.18, 0.15, 0.13],
    )
    for p, _ in clumps[::2]:
        bend = fork.lerp(p, 0.5) + Vector((0, 0, -0.25))
        limb(b, m, [fork - Vector((0, 0, 0.2)), bend, p], [0.09, 0.05, 0.015])
    weights = [size**2 for _, size in clumps]
    for p, size in rng.choices(clumps, weights, k=leaves):
        d = random_direction(rng)
        shell = rng.random() ** 0.33
        at = p + Vector((d.x, d.y, d.z * 0.75)) * size * shell * rng.uniform(0.85, 1.12)
        normal = (d + random_direction(rng) * 0.9 + Vector((0, 0, 0.35))).normalized()
        leaf(b, m["leaf"], at, normal, rng.uniform(0.03, 0.055), rng)
    tree_pit(b, m, x, y)
    scene.add(f"{name}.billboard", b, foliage=True)


def tree_pit(b, m, x, y):
    """A square of stone kerbs about the trunk."""
    f = Frame(x - 0.75, y - 0.75, "south")
    for u0, u1, d0, d1 in (
        (0, 1.5, -0.18, 0),
        (0, 1.5, -1.5, -1.32),
        (0, 0.18, -1.32, -0.18),
        (1.32, 1.5, -1.32, -0.18),
    ):
        b.box(f, u0, u1, 0, 0.035, d0, d1, m["step"], bevel=0.01)


def cypress(scene, m, name, x, y, trunk, height, radius, leaves=15000):
    rng, b = random.Random(name), Builder()
    limb(b, m, [Vector((x, y, 0)), Vector((x, y, height * 0.9))], [0.18, 0.03])
    for _ in range(leaves):
        t = 1 - sqrt(rng.random() * 0.995)
        z = trunk + (height - trunk) * t
        swell = (min(1.0, t / 0.12) ** 0.5) * (1 - t) ** 0.62 * 1.12
        a = rng.uniform(0, 2 * pi)
        bulge = 1 + 0.14 * sin(3 * a + z * 1.7) + 0.09 * sin(7 * a - z * 3.1)
        r = radius * swell * bulge * rng.uniform(0.72, 1.0)
        d = Vector((cos(a), sin(a), 0))
        at = Vector((x, y, z)) + d * r
        normal = (d + random_direction(rng) * 0.5).normalized()
        leaf(b, m["cypress"], at, normal, rng.uniform(0.07, 0.14), rng, 0.35)
    scene.add(f"{name}.billboard", b, foliage=True)


def climber(scene, m, part, frame, spots, material, leaves, seed, size=(0.04, 0.075)):
    """Leaves against a wall: `spots` are (u, v, radius across, radius up); thin, so that the wall plane still fits."""
    rng, b = random.Random(seed), Builder()
    weights = [a * c for _, _, a, c in spots]
    for u, v, a, c in rng.choices(spots, weights, k=leaves):
        angle, r = rng.uniform(0, 2 * pi), sqrt(rng.random()) * rng.uniform(0.8, 1.1)
        ragged = 1 + 0.18 * sin(5 * angle + u) + 0.12 * sin(9 * angle + v)
        du, dv = a * r * ragged * cos(angle), c * r * ragged * sin(angle)
        depth = 0.04 + 0.2 * max(0.0, 1 - r * r) * rng.random() ** 0.6
        if v + dv < 0.05:
            continue
        at = Vector(frame.at(u + du, v + dv, depth))
        out = Vector((*frame.out, 0.35))
        leaf(b, m[material], at, (out + random_direction(rng) * 0.8).normalized(), rng.uniform(*size), rng)
    scene.add(part, b, foliage=True)


def bougainvillea(scene, m):
    """Over the door of the south-western house and up its corner."""
    f = plan.HOUSE_SW.frame
    green = [
        (5.0, 3.3, 1.5, 0.42),
        (6.6, 2.9, 0.5, 1.2),
        (6.95, 1.2, 0.26, 1.2),
        (7.0, 4.6, 0.34, 1.2),
        (3.6, 3.45, 0.8, 0.3),
        (6.9, 5.9, 0.3, 0.6),
    ]
    pink = [
        (5.2, 3.45, 1.2, 0.36),
        (6.6, 3.4, 0.5, 0.8),
        (6.95, 4.8, 0.3, 0.9),
        (3.9, 3.5, 0.7, 0.24),
        (6.85, 2.2, 0.25, 0.5),
    ]
    climber(scene, m, "house_sw.facade", f, green, "ivy", 9000, "green")
    climber(scene, m, "house_sw.facade", f, pink, "bougainvillea", 9000, "pink", (0.03, 0.052))


def ivy(scene, m):
    wall = plan.GARDEN_WALL
    spots = [(1.2, 2.4, 1.3, 1.1), (3.6, 2.9, 1.6, 0.7), (6.4, 2.2, 1.4, 1.2), (8.4, 2.7, 0.9, 0.9)]
    climber(scene, m, "garden_wall", wall["frame"], spots, "ivy", 9000, "wall")


def window_boxes(scene, m):
    """Geraniums under some of the first-floor windows."""
    for h, chosen, sill in (
        (plan.PALAZZO_WEST, (0, 1, 3), 4.3),
        (plan.PALAZZO_EAST, (1, 2, 4), 6.25),
        (plan.HOUSE_SW, (0, 1), 4.3),
    ):
        windows = [w for w in h.windows if w.sill == sill]
        for number in chosen:
            w, b = windows[number], Builder()
            b.box(h.frame, w.u - w.width / 2, w.u + w.width / 2, sill, sill + 0.15, 0.0, 0.15, m["pot"], bevel=0.02)
            scene.add(f"{h.name}.facade", b)
            spots = [(w.u + w.width * (k / 4 - 0.5) * 0.9, sill + 0.2, 0.16, 0.15) for k in range(5)]
            hanging = [(u, sill - 0.02, 0.12, 0.2) for u, _, _, _ in spots[1::2]]
            climber(
                scene, m, f"{h.name}.facade", h.frame, spots + hanging, "ivy", 260, f"{h.name}{number}", (0.025, 0.045)
            )
            climber(scene, m, f"{h.name}.facade", h.frame, spots, "geranium", 320, f"{number}{h.name}", (0.02, 0.034))


def pigeons(scene, m):
    """A few on the paving by the fountain, too small for the coarse model."""
    rng, b, feet = random.Random(11), Builder(), []
    while len(feet) < 8:
        foot, a = Vector((rng.uniform(-5.0, -2.0), rng.uniform(-5.8, -2.6), 0.0)), rng.uniform(0, 2 * pi)
        if all((foot - other).length > 0.6 for other in feet):
            feet.append(foot)
            pigeon(b, m, foot, Vector((cos(a), sin(a), 0)), rng.random() < 0.5)
    scene.add("ground", b)


def pigeon(b, m, foot, ahead, feeding):
    """A body of rings about a bent spine."""
    side, up = ahead.cross(Vector((0, 0, 1))), Vector((0, 0, 1))
    head = (0.13, 0.07) if feeding else (0.115, 0.215)
    spine = [(-0.19, 0.075, 0.012), (-0.11, 0.095, 0.03), (-0.03, 0.115, 0.058), (0.05, 0.125, 0.056)]
    spine += [
        ((0.05 + head[0]) / 2 + 0.02, (0.125 + head[1]) / 2, 0.035),
        (head[0], head[1], 0.026),
        (head[0] + 0.03, head[1] - 0.008, 0.004),
    ]
    rings = []
    for along, height, r in spine:
        centre = foot + ahead * along + up * height
        rings.append(
            [tuple(centre + side * r * cos(2 * pi * k / 10) + up * r * sin(2 * pi * k / 10)) for k in range(10)]
        )
    for low, high in zip(rings, rings[1:]):
        for k in range(10):
            b.poly([low[k], low[(k + 1) % 10], high[(k + 1) % 10], high[k]], m["pigeon"], smooth=True)
    for s in (-0.025, 0.025):
        leg = foot + side * s + ahead * 0.01
        b.poly(
            [
                tuple(leg - side * 0.006),
                tuple(leg + side * 0.006),
                tuple(leg + side * 0.006 + up * 0.08),
                tuple(leg - side * 0.006 + up * 0.08),
            ],
            m["pot"],
        )


def pots(scene, m):
    """Lemon trees in clay pots beside the church steps."""
    for number, (x, y) in enumerate(((-7.15, 13.35), (4.1, 13.35))):
        b, rng = Builder(), random.Random(number)
        b.revolve(
            (x, y),
            [(0.2, 0), (0.22, 0.04), (0.3, 0.42), (0.33, 0.43), (0.33, 0.52), (0.28, 0.52), (0.26, 0.46), (0.0, 0.46)],
            m["pot"],
            32,
        )
        limb(b, m, [Vector((x, y, 0.4)), Vector((x + 0.02, y, 1.0))], [0.03, 0.02])
        for _ in range(1500):
            d = random_direction(rng)
            at = Vector((x, y, 1.25)) + d * 0.4 * rng.random() ** 0.35
            leaf(b, m["leaf"], at, (d + random_direction(rng)).normalized(), rng.uniform(0.03, 0.055), rng)
        for _ in range(14):
            d = random_direction(rng)
            at = Vector((x, y, 1.25)) + d * 0.38
            lemon(b, m, at)
        scene.add("church.facade", b, foliage=True)


def lemon(b, m, at):
    b.revolve(
        (at.x, at.y),
        [(0.0, at.z - 0.05), (0.03, at.z - 0.03), (0.037, at.z), (0.03, at.z + 0.03), (0.0, at.z + 0.05)],
        m["lemon"],
        10,
    )


def benches(scene, m):
    depth, height = plan.BENCH["depth"], plan.BENCH["height"]
    for name, f, length in plan.BENCHES:
        b = Builder()
        b.box(f, 0, length, height - 0.09, height, -depth, 0, m["marble"], bevel=0.02)
        for u in (0.0, length - 0.2):
            b.box(
                f,
                u + 0.03,
                u + 0.2 - 0.03 if u == 0 else u + 0.17,
                0,
                height - 0.09,
                -depth + 0.04,
                -0.04,
                m["marble"],
                bevel=0.02,
            )
        b.box(f, 0.17, length - 0.17, 0.0, height - 0.09, -depth + 0.1, -0.12, m["marble"])
        scene.add(name, b)
