"""The coarse model: few large polygons with names, as somebody would draw the square over the photographs.

Faces are wound counter-clockwise as seen from their visible side. Openings are concave outlines or holes that
are bridged to the outline, windows of the palazzi lie in the plane of their wall, trees are upright quads.
"""

from math import pi

import plan
from shapes import arcade_outline, arch_opening, box, bridged, circle, hip_roof, rectangle, tube


class Model:
    def __init__(self):
        self.objects = {}

    def add(self, name, *faces):
        self.objects.setdefault(name, []).extend(faces)

    def count(self):
        return sum(len(faces) for faces in self.objects.values())


def build():
    model = Model()
    model.add("ground", [(x, y, 0.0) for x, y in plan.GROUND])
    for arcade in plan.ARCADES:
        add_arcade(model, arcade)
    add_loggia(model, plan.ARCADE_SOUTH, **plan.LOGGIA_ROOF)
    for house in plan.HOUSES:
        add_house(model, house)
    add_awning(model, **plan.AWNING)
    add_garden_wall(model, **plan.GARDEN_WALL)
    add_church(model, plan.CHURCH)
    add_campanile(model, plan.CAMPANILE)
    add_fountain(model, plan.FOUNTAIN)
    for name, frame, length in plan.BENCHES:
        faces = box(frame, 0, length, 0, plan.BENCH["height"], -plan.BENCH["depth"], 0)
        model.add(name, *faces)
    for name, x, y, _, height, radius in plan.TREES:
        model.add(f"{name}.billboard", *crossed_quads(x, y, height, radius))
    for name, x, y, _, height, radius in plan.CYPRESSES:
        model.add(f"{name}.billboard", facing_quad(x, y, height, radius))
    return model


def reveal(frame, opening, depth):
    """The sides of an opening: jambs and arch, from the front of a wall to `depth` behind it."""
    pairs = zip(opening, opening[1:])
    return [[frame.at(*p), frame.at(*p, -depth), frame.at(*q, -depth), frame.at(*q)] for p, q in pairs]


def add_arcade(model, a):
    openings = [arch_opening(c, a.opening, 0, a.spring, plan.ARCH_SEGMENTS) for c in a.centres()]
    model.add(f"{a.name}.arches", a.frame.ring(arcade_outline(a.width, a.top, openings)))
    for opening in openings:
        model.add(f"{a.name}.soffits", *reveal(a.frame, opening, a.thickness))
    inside = a.frame.back(a.width, a.thickness)
    model.add(f"{a.name}.arches_inside", inside.ring(arcade_outline(a.width, a.ceiling, openings)))
    far = -a.thickness - a.depth
    at = a.frame.at
    w, c, near = a.width, a.ceiling, -a.thickness
    model.add(f"{a.name}.back_wall", [at(0, 0, far), at(w, 0, far), at(w, c, far), at(0, c, far)])
    e, g = a.end_wall, a.width - a.end_wall
    model.add(f"{a.name}.ends", [at(e, 0, near), at(e, 0, far), at(e, c, far), at(e, c, near)])
    model.add(f"{a.name}.ends", [at(g, 0, far), at(g, 0, near), at(g, c, near), at(g, c, far)])
    model.add(f"{a.name}.ceiling", [at(0, c, near), at(0, c, far), at(w, c, far), at(w, c, near)])
    model.add(f"{a.name}.floor", [at(0, 0, far), at(0, 0, 0), at(w, 0, 0), at(w, 0, far)])


def add_loggia(model, a, overhang, eaves, rise):
    at, w, far = a.frame.at, a.width, -a.thickness - a.depth
    ridge = eaves + rise
    slope = rise / (overhang - far)
    o = overhang
    model.add(
        f"{a.name}.roof", [at(-0.3, eaves, o), at(w + 0.3, eaves, o), at(w + 0.3, ridge, far), at(-0.3, ridge, far)]
    )
    wall_top = eaves + slope * o
    model.add(f"{a.name}.outside", [at(0, 0, far), at(0, 0, 0), at(0, wall_top, 0), at(0, ridge, far)])
    model.add(f"{a.name}.outside", [at(w, 0, 0), at(w, 0, far), at(w, ridge, far), at(w, wall_top, 0)])


def add_house(model, h):
    model.add(f"{h.name}.facade", h.frame.ring(rectangle(0, h.foot, h.width, h.eaves)))
    front, right, _, left = hip_roof(h.frame, h.width, h.depth, h.eaves, h.rise, h.overhang)
    model.add(f"{h.name}.roof", front)
    if h.backdrop:
        return
    model.add(f"{h.name}.roof", right, left)
    for side in (h.frame.left_side(h.depth), h.frame.right_side(h.width)):
        model.add(f"{h.name}.sides", side.ring(rectangle(0, 0, h.depth, h.eaves)))
    o = h.overhang
    under = [(-o, o), (-o, -h.depth - o), (h.width + o, -h.depth - o), (h.width + o, o)]
    model.add(f"{h.name}.eaves", [h.frame.at(u, h.eaves, d) for u, d in under])
    for number, (u, d, width, height) in enumerate(h.chimneys, 1):
        half = width / 2
        faces = box(h.frame, u - half, u + half, h.eaves + 0.2, h.eaves + height, d - half, d + half, back=False)
        model.add(f"{h.name}.chimney_{number}", *faces)
    if h.modelled_windows:
        for w in h.windows:
            ring = rectangle(w.u - w.width / 2, w.sill, w.u + w.width / 2, w.sill + w.height)
            model.add(f"{h.name}.{'doors' if w.kind == 'door' else 'windows'}", h.frame.ring(ring))


def add_awning(model, house, u0, u1, top, drop, reach, valance):
    at, low = house.frame.at, top - drop
    model.add(
        f"{house.name}.awning",
        [at(u0, low, reach), at(u1, low, reach), at(u1, top), at(u0, top)],
        [at(u0, low - valance, reach), at(u1, low - valance, reach), at(u1, low, reach), at(u0, low, reach)],
    )


def add_garden_wall(model, name, frame, width, height, thickness):
    model.add(name, frame.ring(rectangle(0, 0, width, height)))


def church_outline(c, volute_points):
    """The whole front as one ring, without the rose: steps, door, volutes and pediment are in its outline."""
    m, half, door, high = c.axis(), c.steps_half, c.door[0] / 2, c.floor + c.door[1]
    right = c.volute(volute_points)
    ring = [(0, 0), (m - half, 0), (m - half, c.floor), (m - door, c.floor), (m - door, high)]
    ring += [(m + door, high), (m + door, c.floor), (m + half, c.floor), (m + half, 0), (c.width, 0)]
    ring += [(c.width, c.ledge)]
    ring += [(m + d, v) for d, v in right[::-1]]
    ring += [(m + c.shoulder + 0.35, c.upper - 0.35), (m + c.shoulder + 0.35, c.upper), (m, c.apex)]
    ring += [(m - c.shoulder - 0.35, c.upper), (m - c.shoulder - 0.35, c.upper - 0.35)]
    ring += [(m - d, v) for d, v in right]
    return ring + [(0, c.ledge)]


def add_church(model, c):
    f, m = c.frame, c.axis()
    height, radius, depth = c.rose
    rose = circle((m, height), radius, 12)
    model.add("church.facade", f.ring(bridged(church_outline(c, 4), rose)))
    model.add("church.rose", f.ring(rose, -depth))
    half, high = c.door[0] / 2, c.floor + c.door[1]
    opening = [(m - half, c.floor), (m - half, high), (m + half, high), (m + half, c.floor)]
    model.add("church.portal", *reveal(f, opening, c.door_depth))
    model.add("church.door", f.ring(rectangle(m - half, c.floor, m + half, high), -c.door_depth))
    t, low, up = c.thickness, c.ledge, c.upper
    s = m + c.shoulder, m - c.shoulder
    v = c.volute(4)[0][1]
    model.add(
        "church.returns",
        [f.at(0, 0, -t), f.at(0, 0, 0), f.at(0, low, 0), f.at(0, low, -t)],
        [f.at(c.width, 0, 0), f.at(c.width, 0, -t), f.at(c.width, low, -t), f.at(c.width, low, 0)],
        [f.at(s[1], v, -t), f.at(s[1], v, 0), f.at(s[1], up, 0), f.at(s[1], up, -t)],
        [f.at(s[0], v, 0), f.at(s[0], v, -t), f.at(s[0], up, -t), f.at(s[0], up, 0)],
    )
    for k in range(c.steps):
        faces = step_faces(c, k)
        model.add("church.steps", *faces)
    add_church_body(model, c)


def step_faces(c, k):
    """Step k counted from the landing: top, front and sides."""
    half, reach = c.steps_half + k * c.tread, c.landing + k * c.tread
    top = c.floor * (1 - k / c.steps)
    foot = c.floor * (1 - (k + 1) / c.steps)
    return box(c.frame, c.axis() - half, c.axis() + half, foot, top, 0, reach, back=False)


def add_church_body(model, c):
    f, m, t, far = c.frame, c.axis(), c.thickness, c.thickness + c.length
    out, low, high = c.width / 2 - 0.3, *c.aisle
    n, eaves, ridge = c.shoulder - 0.3, *c.nave
    at = lambda side, distance, v, d: f.at(m + side * distance, v, -d)
    for side in (-1, 1):
        turn = 1 if side > 0 else -1
        wall = [at(side, out, 0, t), at(side, out, 0, far), at(side, out, low, far), at(side, out, low, t)]
        slope = [at(side, out, low, t), at(side, out, low, far), at(side, n, high, far), at(side, n, high, t)]
        clerestory = [at(side, n, high, t), at(side, n, high, far), at(side, n, eaves, far), at(side, n, eaves, t)]
        roof = [
            at(side, n + 0.35, eaves, t),
            at(side, n + 0.35, eaves, far),
            at(side, 0, ridge, far),
            at(side, 0, ridge, t),
        ]
        model.add("church.aisles", wall[::turn])
        model.add("church.aisle_roofs", slope[::turn])
        model.add("church.nave", clerestory[::turn])
        model.add("church.nave_roof", roof[::turn])


def campanile_frames(c):
    front = c.frame
    return [front, front.right_side(c.side), front.back(c.side, c.side), front.left_side(c.side)]


def add_campanile(model, c):
    opening = arch_opening(c.side / 2, c.opening[0], c.belfry, c.opening[1], c.segments)
    t = c.thickness
    for frame in campanile_frames(c):
        model.add("campanile.shaft", frame.ring(bridged(rectangle(0, 0, c.side, c.top), opening[::-1])))
        inside = frame.back(c.side, t)
        model.add(
            "campanile.belfry", inside.ring(bridged(rectangle(t, c.belfry, c.side - t, c.top - 0.3), opening[::-1]))
        )
    for frame in (campanile_frames(c)[0], campanile_frames(c)[3]):
        model.add("campanile.soffits", *reveal(frame, opening, t))
    roof = hip_roof(c.frame, c.side, c.side, c.top, c.rise, c.overhang)
    at, s = c.frame.at, c.side
    model.add(
        "campanile.belfry",
        [at(t, c.top - 0.3, -t), at(t, c.top - 0.3, t - s), at(s - t, c.top - 0.3, t - s), at(s - t, c.top - 0.3, -t)],
    )
    model.add("campanile.roof", *[face[:3] for face in roof])
    o = c.overhang
    model.add("campanile.eaves", [at(u, c.top, d) for u, d in ((-o, o), (-o, -s - o), (s + o, -s - o), (s + o, o))])


def octagon(radius, z):
    return [(x, y, z) for x, y in circle(plan.FOUNTAIN.centre, radius, 8, pi / 8)]


def octagon_ring(outer, inner, z):
    flat = lambda radius: circle(plan.FOUNTAIN.centre, radius, 8, pi / 8)
    return [(x, y, z) for x, y in bridged(flat(outer), flat(inner))]


def add_fountain(model, c):
    (step, rise), (basin, rim) = c.step, c.basin
    inner = basin - c.wall
    model.add("fountain.step", *tube(octagon(step, 0), octagon(step, rise)), octagon_ring(step, basin, rise))
    model.add("fountain.basin", *tube(octagon(basin, rise), octagon(basin, rim)), octagon_ring(basin, inner, rim))
    model.add("fountain.basin", *tube(octagon(inner, c.water)[::-1], octagon(inner, rim)[::-1]))
    model.add("fountain.water", octagon(inner, c.water))
    radius, high = c.column
    model.add("fountain.column", *tube(octagon(radius, c.water), octagon(radius, high)))
    low, wide, z0, z1 = c.bowl
    model.add("fountain.bowl", *tube(octagon(low, z0), octagon(wide, z1)), octagon(wide, z1))
    radius, z0, z1 = c.top
    square = lambda r, z: [(x, y, z) for x, y in circle(c.centre, r, 4, pi / 4)]
    model.add("fountain.top", *tube(square(radius * 1.2, z0), square(radius * 0.8, z1)), square(radius * 0.8, z1))


def crossed_quads(x, y, height, radius):
    a = radius * 0.7071
    quad = lambda dx, dy: [
        (x - dx, y - dy, 0.0),
        (x + dx, y + dy, 0.0),
        (x + dx, y + dy, height),
        (x - dx, y - dy, height),
    ]
    return [quad(a, a), quad(a, -a)]


def facing_quad(x, y, height, radius):
    """Upright, turned to the middle of the square."""
    n = (x * x + y * y) ** 0.5
    dx, dy = -y / n * radius, x / n * radius
    return [(x + dx, y + dy, 0.0), (x - dx, y - dy, 0.0), (x - dx, y - dy, height), (x + dx, y + dy, height)]


def write_obj(path, model):
    numbers = {}
    vertices, text = [], []
    for name in sorted(model.objects):
        text.append(f"o {name}\n")
        for face in model.objects[name]:
            indices = []
            for point in face:
                key = tuple(round(v, 6) + 0.0 for v in point)
                if key not in numbers:
                    numbers[key] = len(numbers) + 1
                    vertices.append("v %.6f %.6f %.6f\n" % key)
                indices.append(str(numbers[key]))
            text.append("f " + " ".join(indices) + "\n")
    header = "# A small square: coarse model, metres, z up, faces counter-clockwise from their visible side\n"
    with open(path, "w") as file:
        file.writelines([header] + vertices + text)
