"""The detailed houses and arcades: walls with real openings, windows with shutters, mouldings, tiled roofs."""

import random
from math import cos, pi, radians, sin

import plan
from meshes import Builder
from shapes import arcade_outline, arch_opening, hip_roof, rectangle

FINE = 28  # segments of an arch

CORNICE = [
    (0.0, -0.42),
    (0.07, -0.42),
    (0.07, -0.32),
    (0.12, -0.30),
    (0.16, -0.24),
    (0.16, -0.17),
    (0.30, -0.13),
    (0.33, -0.05),
    (0.33, 0.0),
    (0.0, 0.0),
]
STRING = [(0.0, -0.16), (0.05, -0.16), (0.06, -0.07), (0.11, -0.03), (0.11, 0.04), (0.0, 0.07)]
PLINTH = [(0.0, 0.0), (0.07, 0.0), (0.07, 0.62), (0.03, 0.68), (0.0, 0.68)]


def lifted(profile, v, scale=1.0):
    return [(d * scale, v + dv * scale) for d, dv in profile]


# --- windows ---------------------------------------------------------------------------------------------


def window(b, m, frame, w, shutters, rng):
    """Fills one opening of a wall (the hole itself is cut by the caller)."""
    u0, u1, v0, v1 = w.u - w.width / 2, w.u + w.width / 2, w.sill, w.sill + w.height
    depth = 0.2 if w.kind != "door" else 0.3
    b.reveal(frame, rectangle(u0, v0, u1, v1)[::-1], depth, m["stone"])
    if w.kind == "door":
        door_leaves(b, m, frame, u0, u1, v0, v1, -depth)
    else:
        panes(b, m, frame, u0, u1, v0, v1, -depth)
        sill(b, m, frame, u0, u1, v0)
    surround(b, m, frame, u0, u1, v0, v1, w.kind)
    if w.kind in ("plain", "noble"):
        shutter_pair(b, m["shutter_" + shutters], frame, u0, u1, v0, v1, rng)


def panes(b, m, frame, u0, u1, v0, v1, d):
    b.poly([frame.at(u, v, d + 0.02) for u, v in rectangle(u0, v0, u1, v1)], m["glass"])
    bar = lambda a, c, e, f: b.box(frame, a, c, e, f, d + 0.02, d + 0.07, m["frame"], bevel=0.01)
    middle = (u0 + u1) / 2
    for a, c in ((u0, u0 + 0.06), (u1 - 0.06, u1), (middle - 0.045, middle + 0.045)):
        bar(a, c, v0, v1)
    for v in (v0, v1 - 0.06):
        bar(u0, u1, v, v + 0.06)
    count = 2 if v1 - v0 < 1.8 else 3
    for i in range(1, count):
        v = v0 + (v1 - v0) * i / count
        b.box(frame, u0, u1, v - 0.015, v + 0.015, d + 0.02, d + 0.055, m["frame"])


def sill(b, m, frame, u0, u1, v0):
    b.box(frame, u0 - 0.2, u1 + 0.2, v0 - 0.09, v0, -0.2, 0.14, m["stone"], bevel=0.02)
    for u in (u0 - 0.06, u1 - 0.06):
        b.box(frame, u, u + 0.12, v0 - 0.24, v0 - 0.09, 0, 0.09, m["stone"], bevel=0.02)


def surround(b, m, frame, u0, u1, v0, v1, kind):
    """A flat moulded frame; noble windows have a hood on brackets above it."""
    line = [(u1, v0), (u1, v1), (u0, v1), (u0, v0)]
    profile = [(0.0, 0.0), (0.0, 0.05), (-0.03, 0.07), (-0.1, 0.055), (-0.12, 0.085), (-0.16, 0.085), (-0.17, 0.0)]
    b.moulded_line(frame, line, profile, m["stone"])
    if kind == "noble":
        top = v1 + 0.17
        b.box(frame, u0 - 0.15, u1 + 0.15, top, top + 0.16, 0, 0.06, m["stone"])
        b.sweep(
            frame,
            [(0.0, top + 0.16), (0.08, top + 0.17), (0.2, top + 0.25), (0.22, top + 0.31), (0.0, top + 0.34)],
            u0 - 0.3,
            u1 + 0.3,
            m["stone"],
        )
        for u in (u0 - 0.14, u1 + 0.02):
            b.box(frame, u, u + 0.12, top - 0.1, top + 0.16, 0, 0.15, m["stone"], bevel=0.04)


def shutter_pair(b, material, frame, u0, u1, v0, v1, rng):
    width = (u1 - u0) / 2
    mood = rng.random()
    for mirror, hinge in ((False, u1), (True, u0)):
        angle = radians(rng.choice([3, 5, 7, 9, 14]))
        if mood < 0.12:  # closed
            leaf = frame.turned(u0 if not mirror else u1, -0.05, 0.0, mirror)
        else:
            if mood > 0.9 and mirror:
                angle = radians(rng.uniform(30, 60))
            leaf = frame.turned(hinge, 0.09, angle, mirror)
        shutter(b, material, leaf, width - 0.01, v0 + 0.01, v1 - 0.01)


def shutter(b, material, f, width, v0, v1):
    """A louvred leaf in its own frame, from u = 0 to `width`."""
    rail = 0.065
    for a, c in ((0, rail), (width - rail, width)):
        b.box(f, a, c, v0, v1, 0, 0.04, material, 0.9, 0.006)
    for v in (v0, (v0 + v1) / 2 - rail / 2, v1 - rail):
        b.box(f, rail, width - rail, v, v + rail, 0, 0.04, material, 0.9)
    v = v0 + rail + 0.02
    while v < v1 - rail:
        b.poly(
            [
                f.at(rail, v, 0.042),
                f.at(width - rail, v, 0.042),
                f.at(width - rail, v + 0.05, 0.004),
                f.at(rail, v + 0.05, 0.004),
            ],
            material,
            0.75,
        )
        b.poly(
            [
                f.at(rail, v + 0.05, 0.004),
                f.at(width - rail, v + 0.05, 0.004),
                f.at(width - rail, v + 0.058, 0.004),
                f.at(rail, v + 0.058, 0.004),
            ],
            material,
            0.0,
        )
        v += 0.058


def door_leaves(b, m, frame, u0, u1, v0, v1, d):
    """Two panelled leaves under a fanlight."""
    light = v1 - 0.42
    b.poly([frame.at(u, v, d) for u, v in rectangle(u0, v0, u1, v1)], m["dark"])
    b.poly([frame.at(u, v, d + 0.02) for u, v in rectangle(u0, light, u1, v1)], m["glass"])
    b.box(frame, u0, u1, light - 0.05, light + 0.05, d, d + 0.09, m["door"])
    middle = (u0 + u1) / 2
    for a, c in ((u0, middle - 0.008), (middle + 0.008, u1)):
        b.box(frame, a, c, v0 + 0.02, light - 0.05, d, d + 0.04, m["door"])
        low, rows = v0 + 0.15, 3
        step = (light - 0.2 - low) / rows
        for i in range(rows):
            b.box(
                frame,
                a + 0.09,
                c - 0.09,
                low + i * step,
                low + (i + 1) * step - 0.1,
                d + 0.04,
                d + 0.07,
                m["door"],
                bevel=0.03,
            )


# --- walls and roofs -------------------------------------------------------------------------------------


def wall(b, m, frame, outline, windows, material, shutters, rng):
    holes = [rectangle(w.u - w.width / 2, w.sill, w.u + w.width / 2, w.sill + w.height) for w in windows if w.sill > 0]
    doors = [
        rectangle(w.u - w.width / 2, w.sill + 0.001, w.u + w.width / 2, w.sill + w.height)
        for w in windows
        if w.sill <= 0
    ]
    b.sheet(frame, outline, holes + doors, material)
    for w in windows:
        window(b, m, frame, w, shutters, rng)


def quoins(b, m, frame, u, foot, top, side):
    """Corner stones, long and short in turn; `side` is +1 where the wall lies towards +u."""
    v, long = foot, True
    while v + 0.36 < top:
        reach = 0.72 if long else 0.42
        u0, u1 = (u - 0.035, u + reach) if side > 0 else (u - reach, u + 0.035)
        b.box(frame, u0, u1, v + 0.008, v + 0.352, -0.05, 0.035, m["stone"], bevel=0.018)
        v, long = v + 0.36, not long


def house(scene, m, h):
    rng = random.Random(h.name)
    b = Builder()
    colour = m[h.colour]
    wall(b, m, h.frame, rectangle(0, h.foot, h.width, h.eaves), h.windows, colour, h.shutters, rng)
    if h.foot == 0:
        plinth(b, m, h)
    floors = sorted({w.sill for w in h.windows if w.sill > 2})
    for v in floors[1:]:
        b.sweep(h.frame, lifted(STRING, v - 0.55, 0.8), 0, h.width, m["stone"], 1, 1)
    b.sweep(h.frame, lifted(CORNICE, h.eaves, 1.25), 0, h.width, m["stone"], 1, 1)
    scene.add(f"{h.name}.facade", b)
    trim = Builder()
    quoins(trim, m, h.frame, 0, max(h.foot, 0.68), h.eaves - 0.55, 1)
    quoins(trim, m, h.frame, h.width, max(h.foot, 0.68), h.eaves - 0.55, -1)
    downpipe(trim, m, h, 0.95)
    scene.add(f"{h.name}.facade", trim)
    if not h.backdrop:
        house_sides(scene, m, h, rng)
    house_roof(scene, m, h)
    for number, chimney in enumerate(h.chimneys, 1):
        scene.add(f"{h.name}.chimney_{number}", chimney_mesh(m, h, *chimney))


def plinth(b, m, h):
    doors = sorted((w.u - w.width / 2 - 0.18, w.u + w.width / 2 + 0.18) for w in h.windows if w.kind == "door")
    edges = [0] + [e for door in doors for e in door] + [h.width]
    for u0, u1 in zip(edges[::2], edges[1::2]):
        b.sweep(h.frame, PLINTH, u0, u1, m["stone"])


def downpipe(b, m, h, u):
    x, y, _ = h.frame.at(u, 0, 0.1)
    b.revolve((x, y), [(0.05, max(h.foot, 0.1)), (0.05, h.eaves - 0.1)], m["copper"], 10)


def house_sides(scene, m, h, rng):
    b = Builder()
    for side in (h.frame.left_side(h.depth), h.frame.right_side(h.width)):
        wall(b, m, side, rectangle(0, 0, h.depth, h.eaves), h.side_windows, m[h.colour], h.shutters, rng)
        b.sweep(side, lifted(CORNICE, h.eaves, 1.25), 0, h.depth, m["stone"], 1, 1)
        quoins(b, m, side, 0, 0.2, h.eaves - 0.55, 1)
        quoins(b, m, side, h.depth, 0.2, h.eaves - 0.55, -1)
    b.poly(h.frame.back(h.width, h.depth).ring(rectangle(0, 0, h.width, h.eaves)), m[h.colour])
    scene.add(f"{h.name}.sides", b)


def house_roof(scene, m, h):
    b = Builder()
    slopes = hip_roof(h.frame, h.width, h.depth, h.eaves, h.rise, h.overhang)
    kept = slopes[:1] if h.backdrop else slopes
    for number, slope in enumerate(kept):
        b.tiles(slope, m["clay"], f"{h.name}{number}")
    for slope in slopes:
        b.ridge(slope[0], slope[-1], m["clay"], h.name)
    if len(slopes[0]) == 4:
        b.ridge(slopes[0][2], slopes[0][3], m["clay"], h.name + "ridge")
    scene.add(f"{h.name}.roof", b)
    e, o = Builder(), h.overhang
    under = [(-o, o), (-o, -h.depth - o), (h.width + o, -h.depth - o), (h.width + o, o)]
    e.poly([h.frame.at(u, h.eaves + 0.005, d) for u, d in under], m["beam"])
    rafters(e, m, h.frame, h.width, h.eaves, o)
    if not h.backdrop:
        rafters(e, m, h.frame.left_side(h.depth), h.depth, h.eaves, o)
        rafters(e, m, h.frame.right_side(h.width), h.depth, h.eaves, o)
    gutter = (
        [(o - 0.02, h.eaves + 0.02)]
        + [(o + 0.05 - 0.07 * cos(a), h.eaves + 0.02 - 0.07 * sin(a)) for a in (0.6, 1.2, 1.8, 2.4)]
        + [(o + 0.12, h.eaves + 0.03)]
    )
    e.sweep(h.frame, gutter, 0, h.width, m["copper"], 1, 1)
    scene.add(f"{h.name}.roof" if h.backdrop else f"{h.name}.eaves", e)


def rafters(b, m, frame, width, eaves, overhang):
    count = int(width / 0.55)
    for i in range(count + 1):
        u = width * i / count
        b.box(frame, u - 0.06, u + 0.06, eaves - 0.11, eaves, 0, overhang - 0.06, m["beam"], bevel=0.03)


def chimney_mesh(m, h, u, d, width, height):
    """A plastered shaft with a little roof of tiles on four posts."""
    b, half, top = Builder(), width / 2, h.eaves + height
    f = h.frame
    b.box(f, u - half, u + half, h.eaves, top - 0.5, d - half, d + half, m["brick" if width < 0.8 else h.colour])
    b.box(f, u - half - 0.06, u + half + 0.06, top - 0.56, top - 0.48, d - half - 0.06, d + half + 0.06, m["stone"])
    for su in (-1, 1):
        for sd in (-1, 1):
            b.box(
                f,
                u + su * (half - 0.08) - 0.08,
                u + su * (half - 0.08) + 0.08,
                top - 0.5,
                top - 0.18,
                d + sd * (half - 0.08) - 0.08,
                d + sd * (half - 0.08) + 0.08,
                m["brick"],
            )
    out = half + 0.08
    left = [
        f.at(u - out, top - 0.2, d + out),
        f.at(u + out, top - 0.2, d + out),
        f.at(u + out, top + 0.02, d),
        f.at(u - out, top + 0.02, d),
    ]
    right = [
        f.at(u + out, top - 0.2, d - out),
        f.at(u - out, top - 0.2, d - out),
        f.at(u - out, top + 0.02, d),
        f.at(u + out, top + 0.02, d),
    ]
    for slope in (left, right):
        b.tiles(slope, m["clay"], f"{u}", 0.2, 0.26)
    return b


# --- arcades ---------------------------------------------------------------------------------------------


def arcade(scene, m, a):
    openings = [arch_opening(c, a.opening, 0, a.spring, FINE) for c in a.centres()]
    front, inside = Builder(), Builder()
    front.sheet(a.frame, arcade_outline(a.width, a.top, openings), [], m["ashlar"])
    soffits = Builder()
    for opening in openings:
        soffits.reveal(a.frame, opening, a.thickness, m["ashlar"], closed=False)
    arch_mouldings(front, m, a)
    inside.sheet(a.frame.back(a.width, a.thickness), arcade_outline(a.width, a.ceiling, openings), [], m["vault"])
    scene.add(f"{a.name}.arches", front)
    scene.add(f"{a.name}.soffits", soffits)
    scene.add(f"{a.name}.arches_inside", inside)
    imposts = Builder()
    for c in a.centres():
        left, right = c - a.opening / 2, c + a.opening / 2
        for u0, u1 in ((left - 0.001, left + 0.045), (right - 0.045, right + 0.001)):
            imposts.box(a.frame, u0, u1, a.spring - 0.2, a.spring, -a.thickness - 0.03, 0.06, m["stone"])
    scene.add(f"{a.name}.soffits", imposts)
    arcade_room(scene, m, a)
    arcade_floor(scene, m, a)


def arch_mouldings(b, m, a):
    """Archivolts, keystones, imposts, bases and the string course over the arches."""
    r = a.opening / 2
    for c in a.centres():
        arc = [
            (c + (r + 0.02) * cos(pi * i / FINE), a.spring + (r + 0.02) * sin(pi * i / FINE)) for i in range(FINE + 1)
        ]
        profile = [(0.0, 0.0), (0.0, 0.05), (-0.12, 0.06), (-0.14, 0.09), (-0.24, 0.10), (-0.27, 0.0)]
        b.moulded_line(a.frame, arc, profile, m["stone"])
        top = a.spring + r
        b.poly(
            [
                a.frame.at(c + du, v, 0.17)
                for du, v in ((-0.12, top - 0.03), (0.12, top - 0.03), (0.19, top + 0.42), (-0.19, top + 0.42))
            ],
            m["marble"],
        )
        for s in (-1, 1):
            lower, upper = c + s * 0.12, c + s * 0.19
            edge = [
                a.frame.at(lower, top - 0.03, 0),
                a.frame.at(lower, top - 0.03, 0.17),
                a.frame.at(upper, top + 0.42, 0.17),
                a.frame.at(upper, top + 0.42, 0),
            ]
            b.poly(edge[::-s], m["marble"])
        b.poly(
            [
                a.frame.at(c - 0.12, top - 0.03, 0),
                a.frame.at(c + 0.12, top - 0.03, 0),
                a.frame.at(c + 0.12, top - 0.03, 0.17),
                a.frame.at(c - 0.12, top - 0.03, 0.17),
            ],
            m["marble"],
        )
    edges = [0] + [e for c in a.centres() for e in (c - r, c + r)] + [a.width]
    for u0, u1 in zip(edges[::2], edges[1::2]):
        middle = (u0 + u1) / 2
        b.box(a.frame, u0, u1, 0, 0.42, 0, 0.08, m["stone"], bevel=0.03)
        b.sweep(
            a.frame,
            lifted([(0.0, -0.2), (0.05, -0.18), (0.05, -0.1), (0.1, -0.04), (0.1, 0.0), (0.0, 0.0)], a.spring),
            u0,
            u1,
            m["stone"],
        )
        if u1 - u0 > 0.8:  # a flat pilaster over the pier, up to the string course
            b.box(a.frame, middle - 0.24, middle + 0.24, a.spring, a.top - 0.45, 0, 0.06, m["ashlar"], bevel=0.01)
            b.box(a.frame, middle - 0.3, middle + 0.3, a.top - 0.45, a.top - 0.2, 0, 0.10, m["stone"], bevel=0.03)
    b.sweep(a.frame, lifted(CORNICE, a.top, 0.62), 0, a.width, m["stone"], 1, 1)


def arcade_room(scene, m, a):
    """Back wall with shop doors, ends, and a ceiling of beams."""
    rng = random.Random(a.name)
    w, near, far = a.width, -a.thickness, -a.thickness - a.depth
    back = a.frame.moved(0, far)
    doors = [
        plan.Window(c, 0.0 if i % 2 else 0.85, 1.5, 2.7 if i % 2 else 1.7, "door" if i % 2 else "small")
        for i, c in enumerate(a.centres())
    ]
    b = Builder()
    wall(b, m, back, rectangle(0, 0, w, a.ceiling), doors, m["vault"], "brown", rng)
    scene.add(f"{a.name}.back_wall", b)
    ends = Builder()
    at, c, e, g = a.frame.at, a.ceiling, a.end_wall, w - a.end_wall
    ends.poly([at(e, 0, near), at(e, 0, far), at(e, c, far), at(e, c, near)], m["vault"])
    ends.poly([at(g, 0, far), at(g, 0, near), at(g, c, near), at(g, c, far)], m["vault"])
    scene.add(f"{a.name}.ends", ends)
    ceiling = Builder()
    ceiling.poly([at(0, c, near), at(0, c, far), at(w, c, far), at(w, c, near)], m["beam"])
    for i in range(int(w / 0.6) + 1):
        u = i * 0.6
        ceiling.box(a.frame, u - 0.06, u + 0.06, c - 0.12, c, far, near, m["beam"])
    for i in range(1, a.count):
        u = i * a.pitch
        ceiling.box(a.frame, u - 0.14, u + 0.14, c - 0.3, c - 0.12, far, near, m["beam"], bevel=0.02)
    scene.add(f"{a.name}.ceiling", ceiling)
    lanterns = Builder()
    for u in a.centres()[1::2]:
        lantern(lanterns, m, *at(u, 0, (near + far) / 2)[:2], c - 0.35)
    scene.add(f"{a.name}.ceiling", lanterns)


def lantern(b, m, x, y, z):
    """A small glazed lantern that hangs from z."""
    b.revolve((x, y), [(0.012, z - 0.5), (0.012, z + 0.3)], m["iron"], 6)
    b.revolve((x, y), [(0.0, z - 0.98), (0.09, z - 0.95), (0.09, z - 0.93)], m["iron"], 6, smooth=False)
    b.revolve((x, y), [(0.08, z - 0.93), (0.13, z - 0.62)], m["lamp"], 6, smooth=False)
    b.revolve((x, y), [(0.15, z - 0.62), (0.15, z - 0.6), (0.03, z - 0.5), (0.0, z - 0.48)], m["iron"], 6, smooth=False)


def arcade_floor(scene, m, a):
    b, at = Builder(), a.frame.at
    far = -a.thickness - a.depth
    b.poly(
        [at(0, 0.004, far), at(0, 0.004, -a.thickness), at(a.width, 0.004, -a.thickness), at(a.width, 0.004, far)],
        m["flags"],
    )
    b.poly(
        [at(0, 0.006, -a.thickness), at(0, 0.006, 0.0), at(a.width, 0.006, 0.0), at(a.width, 0.006, -a.thickness)],
        m["step"],
    )
    scene.add(f"{a.name}.floor", b)


def loggia_roof(scene, m, a, overhang, eaves, rise):
    """The single slope over the southern arcade, its end walls and the wall behind."""
    at, w, far = a.frame.at, a.width, -a.thickness - a.depth
    ridge, o = eaves + rise, overhang
    slope = [at(-0.3, eaves, o), at(w + 0.3, eaves, o), at(w + 0.3, ridge, far), at(-0.3, ridge, far)]
    b = Builder()
    b.tiles(slope, m["clay"], "loggia")
    b.ridge(slope[2], slope[3], m["clay"], "loggia ridge")
    b.poly(
        [
            at(-0.3, eaves - 0.04, o),
            at(-0.3, eaves - 0.04, -0.1),
            at(w + 0.3, eaves - 0.04, -0.1),
            at(w + 0.3, eaves - 0.04, o),
        ],
        m["beam"],
    )
    rafters(b, m, a.frame, w, eaves - 0.03, o)
    scene.add(f"{a.name}.roof", b)
    walls = Builder()
    top = eaves + rise / (o - far) * o
    walls.poly([at(0, 0, far), at(0, 0, 0), at(0, top, 0), at(0, ridge, far)], m["ochre"])
    walls.poly([at(w, 0, 0), at(w, 0, far), at(w, ridge, far), at(w, top, 0)], m["ochre"])
    behind = far - a.end_wall
    walls.poly([at(w, 0, behind), at(0, 0, behind), at(0, ridge - 0.1, behind), at(w, ridge - 0.1, behind)], m["ochre"])
    scene.add(f"{a.name}.outside", walls)


def awning(scene, m, house, u0, u1, top, drop, reach, valance):
    """Striped canvas, a little slack between its arms."""
    b, at, n = Builder(), house.frame.at, 24
    sag = lambda s, t: -0.05 * sin(pi * t) - 0.02 * abs(sin(pi * s * 6))
    point = lambda s, t: at(u0 + (u1 - u0) * s, top - drop * t + sag(s, t), reach * t)
    for i in range(n):
        for j in range(6):
            s0, s1, t0, t1 = i / n, (i + 1) / n, j / 6, (j + 1) / 6
            b.poly([point(s0, t1), point(s1, t1), point(s1, t0), point(s0, t0)], m["canvas"], smooth=True)
        a, c = u0 + (u1 - u0) * i / n, u0 + (u1 - u0) * (i + 1) / n
        low = top - drop - valance
        edge = [
            at(a, top - drop, reach),
            at(a, low + 0.06, reach + 0.01),
            at((a + c) / 2, low, reach + 0.015),
            at(c, low + 0.06, reach + 0.01),
            at(c, top - drop, reach),
        ]
        b.poly(edge, m["canvas"])
    for u in (u0 + 0.1, (u0 + u1) / 2, u1 - 0.1):
        b.box(house.frame, u - 0.015, u + 0.015, top - drop - 0.03, top - drop, 0, reach, m["iron"])
    scene.add(f"{house.name}.awning", b)


def garden_wall(scene, m, name, frame, width, height, thickness):
    b = Builder()
    b.box(frame, 0, width, 0, height - 0.12, -thickness, 0, m["brick"])
    slope = [
        frame.at(-0.05, height - 0.14, 0.12),
        frame.at(width + 0.05, height - 0.14, 0.12),
        frame.at(width + 0.05, height + 0.06, -thickness / 2),
        frame.at(-0.05, height + 0.06, -thickness / 2),
    ]
    b.tiles(slope, m["clay"], "garden", 0.2, 0.26)
    scene.add(name, b)
