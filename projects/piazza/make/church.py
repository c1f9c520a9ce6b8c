"""The detailed church front, its body and the campanile."""

from math import cos, pi, sin

from coarse import campanile_frames, church_outline, step_faces
from facades import CORNICE, STRING, door_leaves, lifted
from meshes import Builder
from shapes import arch_opening, circle, hip_roof, rectangle

ENTABLATURE = [
    (0.0, 0.0),
    (0.20, 0.0),
    (0.20, 0.10),
    (0.22, 0.10),
    (0.22, 0.22),
    (0.26, 0.26),
    (0.18, 0.28),
    (0.18, 0.52),
    (0.24, 0.54),
    (0.26, 0.60),
    (0.30, 0.62),
    (0.46, 0.66),
    (0.50, 0.74),
    (0.56, 0.80),
    (0.58, 0.88),
    (0.0, 0.92),
]
RAKING = [
    (0.0, 0.0),
    (0.0, 0.18),
    (-0.10, 0.22),
    (-0.16, 0.42),
    (-0.24, 0.46),
    (-0.28, 0.54),
    (-0.36, 0.54),
    (-0.38, 0.0),
]


def church(scene, m, c):
    front = Builder()
    front_wall(front, m, c)
    lower_order(front, m, c)
    upper_order(front, m, c)
    portal(front, m, c)
    rose_frame(front, m, c)
    volutes(front, m, c)
    scene.add("church.facade", front)
    scene.add("church.rose", rose_glass(m, c))
    scene.add("church.door", church_door(m, c))
    scene.add("church.portal", portal_reveal(m, c))
    scene.add("church.returns", returns(m, c))
    scene.add("church.steps", steps(m, c))
    body(scene, m, c)


def front_wall(b, m, c):
    height, radius, depth = c.rose
    niches = [arch_opening(c.axis() + s * 3.4, 0.9, 2.0, 4.0, 16) for s in (-1, 1)]
    outline = church_outline(c, 24)
    b.sheet(c.frame, outline, [circle((c.axis(), height), radius, 64)] + niches, m["church"])
    b.reveal(c.frame, circle((c.axis(), height), radius, 64)[::-1], depth + 0.1, m["stone"])
    for s, niche in zip((-1, 1), niches):
        niche_with_saint(b, m, c, c.axis() + s * 3.4, niche)
    b.sweep(
        c.frame,
        [(0.0, 0.0), (0.16, 0.0), (0.16, 0.85), (0.1, 0.98), (0.0, 1.0)],
        0,
        c.axis() - c.steps_half,
        m["stone"],
        1,
        0,
    )
    b.sweep(
        c.frame,
        [(0.0, 0.0), (0.16, 0.0), (0.16, 0.85), (0.1, 0.98), (0.0, 1.0)],
        c.axis() + c.steps_half,
        c.width,
        m["stone"],
        0,
        1,
    )


def niche_with_saint(b, m, c, u, opening):
    f = c.frame
    b.reveal(f, opening, 0.34, m["church"], closed=False)
    b.poly([f.at(*p, -0.34) for p in opening[::-1]], m["church"])
    line = [(u + 0.47 * cos(pi * i / 20), 4.0 + 0.47 * sin(pi * i / 20)) for i in range(21)]
    line = [(u + 0.47, 2.0)] + line + [(u - 0.47, 2.0)]
    b.moulded_line(f, line, [(0.0, 0.0), (0.0, 0.07), (-0.1, 0.09), (-0.14, 0.07), (-0.16, 0.0)], m["marble"])
    b.box(f, u - 0.62, u + 0.62, 1.84, 2.0, -0.34, 0.16, m["marble"], bevel=0.03)
    b.box(f, u - 0.3, u + 0.3, 2.0, 2.14, -0.3, 0.04, m["marble"], bevel=0.02)
    x, y, _ = f.at(u, 0, -0.13)
    robe = [
        (0.24, 2.14),
        (0.26, 2.25),
        (0.21, 2.7),
        (0.19, 3.1),
        (0.22, 3.4),
        (0.235, 3.55),
        (0.16, 3.68),
        (0.07, 3.74),
    ]
    b.revolve((x, y), robe, m["marble"], 40, lobes=9, lobe_depth=0.16)
    head = [(0.05, 3.72), (0.09, 3.78), (0.12, 3.88), (0.115, 3.97), (0.075, 4.05), (0.0, 4.09)]
    b.revolve((x, y), head, m["marble"], 20)
    b.box(f, u - 0.22, u + 0.1, 3.15, 3.27, -0.12, 0.1, m["marble"], bevel=0.05)


def pilaster(b, m, frame, u, foot, top, width, d=0.13):
    """Base, shaft with a sunk panel, and a capital of three leaves of stone."""
    half = width / 2
    b.box(frame, u - half - 0.09, u + half + 0.09, foot, foot + 0.28, 0, d + 0.09, m["stone"], bevel=0.03)
    b.sweep(
        frame,
        [
            (0.0, foot + 0.28),
            (d + 0.08, foot + 0.28),
            (d + 0.09, foot + 0.34),
            (d + 0.03, foot + 0.4),
            (d + 0.05, foot + 0.46),
            (d, foot + 0.5),
            (0.0, foot + 0.5),
        ],
        u - half - 0.05,
        u + half + 0.05,
        m["stone"],
    )
    b.box(frame, u - half, u + half, foot + 0.5, top - 0.62, 0, d, m["stone"], bevel=0.012)
    line = [
        (u - half + 0.1, foot + 0.75),
        (u - half + 0.1, top - 0.85),
        (u + half - 0.1, top - 0.85),
        (u + half - 0.1, foot + 0.75),
    ]
    b.moulded_line(
        frame,
        line,
        [(0.0, d - 0.002), (0.0, d + 0.025), (0.035, d + 0.025), (0.035, d - 0.002)],
        m["stone"],
        closed=True,
    )
    capital(b, m, frame, u, top - 0.62, top, half, d)


def capital(b, m, frame, u, low, top, half, d):
    h = top - low
    b.sweep(
        frame,
        [(0.0, low), (d + 0.05, low), (d + 0.05, low + 0.06), (0.0, low + 0.06)],
        u - half - 0.04,
        u + half + 0.04,
        m["stone"],
    )
    b.box(frame, u - half, u + half, low + 0.06, top - 0.1, 0, d, m["stone"])
    for row, (v, size) in enumerate(((low + 0.08, 0.5), (low + 0.28 * h, 0.5))):
        count = 4 if row == 0 else 3
        for i in range(count):
            x = u - half + (i + 0.5) * 2 * half / count
            leaf_relief(b, m, frame, x, v, 2 * half / count * 0.9, h * size, d)
    for s in (-1, 1):
        spiral(b, m, frame, u + s * (half - 0.02), top - 0.2, 0.115, s, d, d + 0.07)
    b.sweep(
        frame,
        [(0.0, top - 0.1), (d + 0.08, top - 0.1), (d + 0.12, top - 0.04), (d + 0.12, top), (0.0, top)],
        u - half - 0.12,
        u + half + 0.12,
        m["stone"],
    )


def leaf_relief(b, m, frame, u, v, width, height, d):
    """An acanthus leaf reduced to what a lens resolves: a bent tongue."""
    steps = 5
    rows = []
    for i in range(steps + 1):
        t = i / steps
        w = width / 2 * (1 - 0.55 * t * t)
        out = d + 0.02 + 0.08 * t * t
        y = v + height * (t if t < 0.85 else 0.85 - (t - 0.85))
        rows.append([frame.at(u - w, y, out - 0.02), frame.at(u, y, out), frame.at(u + w, y, out - 0.02)])
    for low, high in zip(rows, rows[1:]):
        for k in (0, 1):
            b.poly([low[k], low[k + 1], high[k + 1], high[k]], m["stone"], smooth=True)


def spiral(b, m, frame, u, v, radius, side, d0, d1, turns=1.6, material="stone"):
    """A scroll: a spiral band that stands out from d0 to d1, and its eye."""
    count = 40
    line = []
    for i in range(count + 1):
        t = i / count
        a = pi / 2 - side * 2 * pi * turns * t
        r = radius * (1 - 0.78 * t)
        line.append((u + r * cos(a), v + r * sin(a)))
    w = radius * 0.14
    b.moulded_line(frame, line, [(w, d0), (w, d1), (-w, d1), (-w, d0)], m[material])
    b.poly([frame.at(*p, d0 + (d1 - d0) * 0.4) for p in circle((u, v), radius * 0.9, 24)], m[material])
    b.poly([frame.at(*p, d1 + 0.01) for p in circle((u, v), radius * 0.22, 12)], m[material])


def lower_order(b, m, c):
    axis, foot = c.axis(), 0.5
    for distance in c.pilasters:
        for s in (-1, 1):
            start = c.floor if distance < c.steps_half else foot
            if distance >= c.steps_half:
                b.box(
                    c.frame,
                    axis + s * distance - 0.42,
                    axis + s * distance + 0.42,
                    0,
                    1.05,
                    0,
                    0.24,
                    m["stone"],
                    bevel=0.03,
                )
                start = 1.05
            pilaster(b, m, c.frame, axis + s * distance, start, c.lower, 0.62)
    b.sweep(c.frame, lifted(ENTABLATURE, c.lower, 1.0), 0, c.width, m["stone"], 1, 1)
    dentils(b, m, c.frame, 0.0, c.width, c.lower + 0.55, 0.30)


def dentils(b, m, frame, u0, u1, v, d, size=0.09):
    count = int((u1 - u0) / (2 * size))
    for i in range(count):
        u = u0 + (i + 0.25) * (u1 - u0) / count
        b.box(frame, u, u + size, v, v + size, d - 0.12, d, m["stone"])


def upper_order(b, m, c):
    axis, foot = c.axis(), c.ledge
    wide = c.shoulder + 0.12
    b.box(c.frame, axis - wide, axis + wide, foot, foot + 0.42, 0, 0.22, m["stone"], bevel=0.02)
    for distance in c.upper_pilasters:
        for s in (-1, 1):
            pilaster(b, m, c.frame, axis + s * distance, foot + 0.42, c.upper - 0.72, 0.5, 0.11)
    b.sweep(c.frame, lifted(ENTABLATURE, c.upper - 0.72, 0.8), axis - c.shoulder, axis + c.shoulder, m["stone"], 1, 1)
    dentils(b, m, c.frame, axis - c.shoulder, axis + c.shoulder, c.upper - 0.28, 0.25, 0.08)
    line = [(axis + c.shoulder + 0.5, c.upper + 0.02), (axis, c.apex), (axis - c.shoulder - 0.5, c.upper + 0.02)]
    b.moulded_line(c.frame, line, [(o + 0.34, d) for o, d in RAKING], m["stone"])
    ring = circle((axis, c.upper + 0.85), 0.5, 40)
    b.moulded_line(c.frame, ring, [(0.0, 0.0), (0.0, 0.08), (-0.09, 0.1), (-0.12, 0.0)], m["marble"], closed=True)
    cross_on_top(b, m, c)
    for s in (-1, 1):
        for distance, low in ((c.width / 2 - 0.42, c.ledge), (c.shoulder + 0.1, c.upper + 0.2)):
            urn(b, m, *c.frame.at(axis + s * distance, 0, -0.15)[:2], low, 0.9 if distance > 5 else 0.72)


def cross_on_top(b, m, c):
    axis, f, top = c.axis(), c.frame, c.apex
    b.box(f, axis - 0.28, axis + 0.28, top - 0.1, top + 0.35, -0.3, 0.3, m["stone"], bevel=0.03)
    b.box(f, axis - 0.04, axis + 0.04, top + 0.35, top + 1.45, -0.04, 0.04, m["iron"])
    b.box(f, axis - 0.32, axis + 0.32, top + 1.02, top + 1.1, -0.04, 0.04, m["iron"])


def urn(b, m, x, y, z, size):
    shape = [
        (0.30, 0),
        (0.30, 0.2),
        (0.14, 0.24),
        (0.10, 0.36),
        (0.26, 0.55),
        (0.33, 0.8),
        (0.30, 0.98),
        (0.20, 1.04),
        (0.24, 1.1),
        (0.14, 1.2),
        (0.16, 1.32),
        (0.08, 1.5),
        (0.0, 1.62),
    ]
    b.revolve((x, y), [(r * size, z + v * size) for r, v in shape], m["marble"], 28)


def portal(b, m, c):
    """Door frame, two columns, entablature, and a broken pediment with a shell between its halves."""
    axis, f, half, top = c.axis(), c.frame, c.door[0] / 2, c.floor + c.door[1]
    line = [(axis + half, c.floor), (axis + half, top), (axis - half, top), (axis - half, c.floor)]
    b.moulded_line(
        f,
        line,
        [(0.0, 0.0), (0.0, 0.08), (-0.05, 0.11), (-0.16, 0.09), (-0.19, 0.14), (-0.26, 0.14), (-0.28, 0.0)],
        m["marble"],
    )
    for s in (-1, 1):
        column(b, m, *f.at(axis + s * (half + 0.62), 0, 0.34)[:2], c.floor, top + 0.15, 0.19)
        b.box(
            f,
            axis + s * (half + 0.62) - 0.26,
            axis + s * (half + 0.62) + 0.26,
            c.floor,
            top + 0.15,
            0,
            0.12,
            m["stone"],
        )
    reach = half + 1.0
    lintel = lifted([(d * 1.25 + (0.28 if d > 0 else 0), v) for d, v in ENTABLATURE], top + 0.15, 0.62)
    b.sweep(f, lintel, axis - reach, axis + reach, m["marble"])
    base, rise = top + 0.15 + 0.58, 0.95
    for s in (-1, 1):
        line = [(axis + s * (reach + 0.15), base + 0.02), (axis + s * 0.55, base + rise * 0.72)]
        profile = [(0.0, 0.0), (0.0, 0.42), (0.08, 0.5), (0.14, 0.62), (0.24, 0.66), (0.24, 0.0)]
        b.moulded_line(f, line, [(-s * o, d) for o, d in profile], m["marble"])
        b.poly(
            [f.at(axis + s * u, v, 0.3) for u, v in ((reach, base), (0.55, base), (0.55, base + rise * 0.62))][::s],
            m["church"],
        )
    shell(b, m, f, axis, base + 0.12, 0.52)


def shell(b, m, f, u, v, radius):
    ribs = 11
    for i in range(ribs):
        a0, a1 = pi * i / ribs, pi * (i + 1) / ribs
        am = (a0 + a1) / 2
        p = lambda a, r, d: f.at(u + r * cos(a), v + r * sin(a), d)
        tip = p(am, radius, 0.30)
        b.poly([f.at(u, v, 0.2), p(a0, radius * 0.93, 0.2), tip], m["marble"])
        b.poly([f.at(u, v, 0.2), tip, p(a1, radius * 0.93, 0.2)], m["marble"])
    b.box(f, u - radius, u + radius, v - 0.12, v, 0, 0.42, m["marble"], bevel=0.03)
    urn(b, m, *f.at(u, 0, 0.2)[:2], v + radius * 0.95, 0.4)


def column(b, m, x, y, foot, top, r):
    b.revolve(
        (x, y),
        [
            (r * 1.5, foot),
            (r * 1.5, foot + 0.14),
            (r * 1.35, foot + 0.16),
            (r * 1.4, foot + 0.22),
            (r * 1.12, foot + 0.27),
            (r * 1.2, foot + 0.32),
            (r, foot + 0.36),
        ],
        m["marble"],
        32,
    )
    b.revolve((x, y), [(r, foot + 0.36), (r * 1.02, foot + 1.5), (r * 0.86, top - 0.42)], m["marble"], 32)
    b.revolve(
        (x, y),
        [
            (r * 0.95, top - 0.42),
            (r * 0.95, top - 0.38),
            (r * 0.86, top - 0.36),
            (r * 0.95, top - 0.28),
            (r * 1.35, top - 0.14),
            (r * 1.2, top - 0.12),
            (r * 1.45, top - 0.08),
            (r * 1.45, top),
            (0.0, top),
        ],
        m["marble"],
        32,
        lobes=8,
        lobe_depth=0.08,
    )


def rose_frame(b, m, c):
    height, radius, _ = c.rose
    ring = circle((c.axis(), height), radius, 72)
    b.moulded_line(
        c.frame,
        ring,
        [(0.0, 0.0), (0.0, 0.06), (-0.08, 0.12), (-0.2, 0.08), (-0.26, 0.14), (-0.34, 0.14), (-0.38, 0.0)],
        m["marble"],
        closed=True,
    )


def rose_glass(m, c):
    """Glass and tracery: twelve spokes, an inner ring, and a wreath of small circles."""
    b = Builder()
    height, radius, depth = c.rose
    f, axis = c.frame, c.axis()
    b.poly([f.at(*p, -depth - 0.04) for p in circle((axis, height), radius + 0.02, 64)], m["rose_glass"])
    bar = lambda w, d: [(w, -depth - 0.04), (w, -depth + d), (-w, -depth + d), (-w, -depth - 0.04)]
    for r, w in ((0.34, 0.05), (radius - 0.05, 0.05)):
        b.moulded_line(f, circle((axis, height), r, 48), bar(w, 0.06), m["marble"], closed=True)
    for i in range(12):
        a = 2 * pi * i / 12
        inner, outer = 0.34, radius - 0.36
        line = [(axis + r * cos(a), height + r * sin(a)) for r in (inner, outer)]
        b.moulded_line(f, line, bar(0.028, 0.05), m["marble"])
        a += pi / 12
        centre = (axis + (radius - 0.27) * cos(a), height + (radius - 0.27) * sin(a))
        b.moulded_line(f, circle(centre, 0.21, 20), bar(0.026, 0.05), m["marble"], closed=True)
    return b


def volutes(b, m, c):
    """The two scrolls that lead from the narrow upper storey down to the wide lower one."""
    for s in (-1, 1):
        line = [(c.axis() + s * d, v) for d, v in c.volute(24)[:-1]]
        profile = [(-0.05, 0.0), (-0.05, 0.16), (0.07, 0.2), (0.16, 0.12), (0.26, 0.12), (0.26, 0.0)]
        b.moulded_line(c.frame, line, [(-o * s, d) for o, d in profile], m["stone"])
        low = c.volute(24)[-2]
        spiral(b, m, c.frame, c.axis() + s * (low[0] - 0.55), c.ledge + 0.62, 0.5, -s, 0.0, 0.2, 1.8)
        high = c.volute(24)[0]
        spiral(b, m, c.frame, c.axis() + s * (high[0] + 0.02), high[1] + 0.12, 0.3, s, 0.0, 0.2, 1.5)


def church_door(m, c):
    b, half = Builder(), c.door[0] / 2
    door_leaves(b, m, c.frame, c.axis() - half, c.axis() + half, c.floor, c.floor + c.door[1], -c.door_depth)
    return b


def portal_reveal(m, c):
    b, half, high = Builder(), c.door[0] / 2, c.floor + c.door[1]
    ring = [(c.axis() - half, c.floor), (c.axis() - half, high), (c.axis() + half, high), (c.axis() + half, c.floor)]
    b.reveal(c.frame, ring, c.door_depth + 0.02, m["marble"], closed=False)
    return b


def returns(m, c):
    """The thickness of the front, seen from the side streets, and its back."""
    b, f, t = Builder(), c.frame, c.thickness
    outline = church_outline(c, 24)
    b.reveal(f, outline, t, m["church"])
    b.sheet(f.back(c.width, t), [(c.width - u, v) for u, v in outline][::-1], [], m["church"])
    for side in (f.left_side(t), f.right_side(c.width)):
        b.sweep(side, lifted(ENTABLATURE, c.lower), 0, t, m["stone"], 1, 1)
    return b


def steps(m, c):
    b = Builder()
    for k in range(c.steps):
        for face in step_faces(c, k):
            b.poly(face, m["step"])
        half, reach = c.steps_half + k * c.tread, c.landing + k * c.tread
        top = c.floor * (1 - k / c.steps)
        b.sweep(
            c.frame,
            [
                (reach - 0.01, top - 0.05),
                (reach + 0.025, top - 0.045),
                (reach + 0.035, top - 0.02),
                (reach + 0.025, top + 0.001),
                (reach - 0.1, top + 0.001),
            ],
            c.axis() - half,
            c.axis() + half,
            m["step"],
        )
    return b


def body(scene, m, c):
    f, axis, t, far = c.frame, c.axis(), c.thickness, c.thickness + c.length
    out, low, high = c.width / 2 - 0.3, *c.aisle
    n, eaves, ridge = c.shoulder - 0.3, *c.nave
    walls, clerestory, low_roof, high_roof = Builder(), Builder(), Builder(), Builder()
    for side in (-1, 1):
        at = lambda distance, v, d: f.at(axis + side * distance, v, -d)
        walls.poly([at(out, 0, t), at(out, 0, far), at(out, low, far), at(out, low, t)], m["ochre"])
        clerestory.poly([at(n, high, t), at(n, high, far), at(n, eaves, far), at(n, eaves, t)], m["church"])
        slope = [at(out + 0.2, low - 0.1, t), at(out + 0.2, low - 0.1, far), at(n, high, far), at(n, high, t)]
        roof = [at(n + 0.35, eaves, t), at(n + 0.35, eaves, far), at(0, ridge, far), at(0, ridge, t)]
        if side < 0:
            slope, roof = [[q[1], q[0], q[3], q[2]] for q in (slope, roof)]
        low_roof.tiles(slope, m["clay"], f"aisle{side}")
        high_roof.tiles(roof, m["clay"], f"nave{side}")
    clerestory.poly(
        [
            f.at(axis - n, 0, -far),
            f.at(axis + n, 0, -far),
            f.at(axis + n, eaves, -far),
            f.at(axis, ridge, -far),
            f.at(axis - n, eaves, -far),
        ],
        m["church"],
    )
    high_roof.ridge(f.at(axis, ridge, -t), f.at(axis, ridge, -far), m["clay"], "nave ridge")
    scene.add("church.aisles", walls)
    scene.add("church.nave", clerestory)
    scene.add("church.aisle_roofs", low_roof)
    scene.add("church.nave_roof", high_roof)


# --- campanile -------------------------------------------------------------------------------------------


def campanile(scene, m, c):
    shaft, inner, soffits = Builder(), Builder(), Builder()
    opening = arch_opening(c.side / 2, c.opening[0], c.belfry, c.opening[1], 20)
    for frame in campanile_frames(c):
        shaft.sheet(frame, rectangle(0, 0, c.side, c.top), [opening], m["tower"])
        tower_trim(shaft, m, c, frame)
        inside = frame.back(c.side, c.thickness)
        inner.sheet(inside, rectangle(c.thickness, c.belfry, c.side - c.thickness, c.top - 0.3), [opening], m["vault"])
        soffits.reveal(frame, opening + [opening[0]], c.thickness, m["stone"], closed=False)
    clock(shaft, m, c.frame, c.side / 2, 12.6, 0.85)
    clock(shaft, m, campanile_frames(c)[3], c.side / 2, 12.6, 0.85)
    at, s, t = c.frame.at, c.side, c.thickness
    inner.poly(
        [at(t, c.top - 0.3, -t), at(t, c.top - 0.3, t - s), at(s - t, c.top - 0.3, t - s), at(s - t, c.top - 0.3, -t)],
        m["beam"],
    )
    inner.poly(
        [
            at(t, c.belfry - 0.02, -t),
            at(s - t, c.belfry - 0.02, -t),
            at(s - t, c.belfry - 0.02, t - s),
            at(t, c.belfry - 0.02, t - s),
        ],
        m["vault"],
    )
    scene.add("campanile.shaft", shaft)
    scene.add("campanile.belfry", inner)
    scene.add("campanile.soffits", soffits)
    bell = Builder()
    x, y, _ = at(s / 2, 0, -s / 2)
    shape = [(0.62, 0.0), (0.58, 0.08), (0.46, 0.3), (0.38, 0.6), (0.34, 0.8), (0.2, 0.92), (0.06, 0.96), (0.06, 1.3)]
    bell.revolve((x, y), [(r, 16.1 + z) for r, z in shape], m["bronze"], 32)
    bell.box(c.frame, t, s - t, 17.3, 17.5, -s / 2 - 0.1, -s / 2 + 0.1, m["beam"])
    scene.add("campanile.belfry", bell)
    tower_roof(scene, m, c)


def tower_trim(b, m, c, frame):
    s = c.side
    for v in (5.2, 10.4, c.belfry - 0.35):
        b.sweep(frame, lifted(STRING, v, 1.1), 0, s, m["stone"], 1, 1)
    b.sweep(frame, lifted(CORNICE, c.top, 1.05), 0, s, m["stone"], 1, 1)
    b.sweep(frame, [(0.0, 0.0), (0.12, 0.0), (0.12, 0.9), (0.0, 1.05)], 0, s, m["stone"], 1, 1)
    for u in (0.0, s - 0.55):
        b.box(frame, u, u + 0.55, 1.05, c.belfry - 0.55, 0, 0.07, m["stone"], bevel=0.01)
        b.box(frame, u, u + 0.55, c.belfry - 0.27, c.top - 0.45, 0, 0.09, m["stone"], bevel=0.01)
    r, middle, spring = c.opening[0] / 2, s / 2, c.opening[1]
    arc = [(middle + r * cos(pi * i / 20), spring + r * sin(pi * i / 20)) for i in range(21)]
    b.moulded_line(frame, arc, [(0.0, 0.0), (0.0, 0.07), (-0.14, 0.09), (-0.2, 0.11), (-0.24, 0.0)], m["stone"])
    for u in (middle - r - 0.26, middle + r):
        b.box(frame, u, u + 0.26, spring - 0.16, spring, -c.thickness, 0.12, m["stone"], bevel=0.02)
        b.box(frame, u, u + 0.26, c.belfry, spring - 0.16, 0, 0.05, m["stone"])
    b.box(
        frame,
        middle - r - 0.35,
        middle + r + 0.35,
        c.belfry - 0.12,
        c.belfry,
        -c.thickness,
        0.16,
        m["stone"],
        bevel=0.02,
    )
    for v in (3.0, 7.6):  # slits for the stairs
        b.box(frame, middle - 0.28, middle + 0.28, v - 0.1, v + 1.1, 0, 0.05, m["stone"], bevel=0.02)
        b.box(frame, middle - 0.13, middle + 0.13, v + 0.05, v + 0.95, 0, 0.055, m["dark"])


def clock(b, m, frame, u, v, radius):
    b.poly([frame.at(*p, 0.04) for p in circle((u, v), radius, 48)], m["church"])
    b.moulded_line(
        frame,
        circle((u, v), radius, 48),
        [(0.06, 0.04), (0.04, 0.10), (-0.1, 0.13), (-0.16, 0.0)],
        m["marble"],
        closed=True,
    )
    for i in range(12):
        a = pi / 6 * i
        line = [(u + r * cos(a), v + r * sin(a)) for r in (radius * 0.72, radius * 0.9)]
        b.moulded_line(frame, line, [(0.03, 0.04), (0.03, 0.055), (-0.03, 0.055), (-0.03, 0.04)], m["iron"])
    for a, length in ((pi / 2 - 2 * pi * 40 / 60, 0.78), (pi / 2 - 2 * pi * (17 + 2 / 3) / 12, 0.5)):  # twenty to six
        line = [(u, v), (u + radius * length * cos(a), v + radius * length * sin(a))]
        b.moulded_line(frame, line, [(0.03, 0.06), (0.03, 0.08), (-0.03, 0.08), (-0.03, 0.06)], m["iron"])


def tower_roof(scene, m, c):
    b, e = Builder(), Builder()
    slopes = [face[:3] for face in hip_roof(c.frame, c.side, c.side, c.top, c.rise, c.overhang)]
    for number, slope in enumerate(slopes):
        b.tiles(slope, m["clay"], f"tower{number}", 0.2, 0.3)
        b.ridge(slope[0], slope[2], m["clay"], f"tower ridge{number}")
    x, y, z = slopes[0][2]
    b.revolve(
        (x, y),
        [(0.16, z - 0.1), (0.16, z + 0.12), (0.22, z + 0.2), (0.16, z + 0.3), (0.03, z + 0.36), (0.03, z + 1.5)],
        m["copper"],
        16,
    )
    b.box(
        c.frame,
        c.side / 2 - 0.3,
        c.side / 2 + 0.3,
        z + 1.05,
        z + 1.12,
        -c.side / 2 - 0.03,
        -c.side / 2 + 0.03,
        m["iron"],
    )
    o, s = c.overhang, c.side
    e.poly(
        [c.frame.at(u, c.top + 0.004, d) for u, d in ((-o, o), (-o, -s - o), (s + o, -s - o), (s + o, o))], m["stone"]
    )
    scene.add("campanile.roof", b)
    scene.add("campanile.eaves", e)
