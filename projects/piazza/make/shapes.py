"""Small geometry shared by the coarse model and the detailed scene. Metres; x east, y north, z up."""

from math import cos, hypot, pi, sin

FACINGS = {  # u as it runs to the right for somebody who looks at the wall, and the way out of the wall
    "south": ((1, 0), (0, -1)),
    "east": ((0, 1), (1, 0)),
    "north": ((-1, 0), (0, 1)),
    "west": ((0, -1), (-1, 0)),
}
TURN_LEFT = {"south": "west", "west": "north", "north": "east", "east": "south"}
TURN_BACK = {"south": "north", "north": "south", "east": "west", "west": "east"}


class Frame:
    """A wall's own coordinates: u along it, v up, d outwards; (0, 0, 0) is its lower left corner."""

    def __init__(self, x, y, facing):
        self.origin, self.facing = (x, y), facing
        self.u, self.out = FACINGS[facing]

    def at(self, u, v, d=0.0):
        return (
            self.origin[0] + u * self.u[0] + d * self.out[0],
            self.origin[1] + u * self.u[1] + d * self.out[1],
            v,
        )

    def ring(self, points, d=0.0):
        return [self.at(u, v, d) for u, v in points]

    def turned(self, u, d, angle, mirror=False):
        """A frame hinged at (u, d), turned out of the wall by `angle`; mirrored it runs to the left."""
        x, y, _ = self.at(u, 0, d)
        frame = Frame(x, y, self.facing)
        sign = -1 if mirror else 1
        frame.u = tuple(sign * cos(angle) * a + sin(angle) * b for a, b in zip(self.u, self.out))
        frame.out = tuple(-sign * sin(angle) * a + cos(angle) * b for a, b in zip(self.u, self.out))
        return frame

    def moved(self, u, d=0.0):
        x, y, _ = self.at(u, 0, d)
        return Frame(x, y, self.facing)

    def left_side(self, depth):
        """The wall that meets this one at u = 0, seen from outside (it ends at this wall's left corner)."""
        x, y, _ = self.at(0, 0, -depth)
        return Frame(x, y, TURN_LEFT[self.facing])

    def right_side(self, width):
        x, y, _ = self.at(width, 0)
        return Frame(x, y, TURN_BACK[TURN_LEFT[self.facing]])

    def back(self, width, depth):
        x, y, _ = self.at(width, 0, -depth)
        return Frame(x, y, TURN_BACK[self.facing])


def rectangle(u0, v0, u1, v1):
    """Counter-clockwise."""
    return [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]


def arch_opening(centre, width, foot, spring, segments):
    """Left foot, up, over and down to the right foot. The polygon lies half inside, half outside the circle."""
    radius = width / 2
    swell = 2 / (1 + cos(pi / (2 * segments)))
    points = [(centre - radius, foot), (centre - radius, spring)]
    for i in range(1, segments):
        angle = pi - pi * i / segments
        points.append((centre + swell * radius * cos(angle), spring + swell * radius * sin(angle)))
    return points + [(centre + radius, spring), (centre + radius, foot)]


def arcade_outline(width, top, openings):
    """A wall from (0, 0) to (width, top) whose openings start at its foot, as one concave ring."""
    ring = [(0, 0)]
    for opening in openings:
        ring += opening
    return ring + [(width, 0), (width, top), (0, top)]


def circle(centre, radius, count, turn=0.0):
    return [
        (centre[0] + radius * cos(turn + 2 * pi * i / count), centre[1] + radius * sin(turn + 2 * pi * i / count))
        for i in range(count)
    ]


def bridged(outer, hole):
    """One ring from a counter-clockwise outline and a counter-clockwise hole, joined by an edge walked twice."""
    hole = hole[::-1]
    i, j = min(
        ((i, j) for i in range(len(outer)) for j in range(len(hole))),
        key=lambda ij: hypot(outer[ij[0]][0] - hole[ij[1]][0], outer[ij[0]][1] - hole[ij[1]][1]),
    )
    return outer[: i + 1] + hole[j:] + hole[: j + 1] + outer[i:]


def hip_roof(frame, width, depth, eaves, rise, overhang):
    """Four slopes over a rectangle, each with its eaves edge first. Ridge along the longer side."""
    o = overhang
    u0, u1, d0, d1 = -o, width + o, o, -depth - o
    inset = min(u1 - u0, d0 - d1) / 2
    along = u1 - u0 >= d0 - d1
    top = eaves + rise
    if along:
        r0, r1 = (u0 + inset, (d0 + d1) / 2), (u1 - inset, (d0 + d1) / 2)
    else:
        r0, r1 = ((u0 + u1) / 2, d0 - inset), ((u0 + u1) / 2, d1 + inset)
    corner = lambda u, d: frame.at(u, eaves, d)
    ridge = [frame.at(r[0], top, r[1]) for r in (r0, r1)]
    front, right, back, left = (
        [corner(u0, d0), corner(u1, d0)],
        [corner(u1, d0), corner(u1, d1)],
        [corner(u1, d1), corner(u0, d1)],
        [corner(u0, d1), corner(u0, d0)],
    )
    if along:
        return [front + [ridge[1], ridge[0]], right + [ridge[1]], back + [ridge[0], ridge[1]], left + [ridge[0]]]
    return [front + [ridge[0]], right + [ridge[1], ridge[0]], back + [ridge[1]], left + [ridge[0], ridge[1]]]


def box(frame, u0, u1, v0, v1, d0, d1, bottom=False, top=True, back=True):
    """Faces of a box in a wall's coordinates, d0 < d1, all wound to be seen from outside."""
    f = frame.at
    faces = [
        [f(u0, v0, d1), f(u1, v0, d1), f(u1, v1, d1), f(u0, v1, d1)],
        [f(u1, v0, d1), f(u1, v0, d0), f(u1, v1, d0), f(u1, v1, d1)],
        [f(u0, v0, d0), f(u0, v0, d1), f(u0, v1, d1), f(u0, v1, d0)],
    ]
    if back:
        faces.append([f(u1, v0, d0), f(u0, v0, d0), f(u0, v1, d0), f(u1, v1, d0)])
    if top:
        faces.append([f(u0, v1, d1), f(u1, v1, d1), f(u1, v1, d0), f(u0, v1, d0)])
    if bottom:
        faces.append([f(u0, v0, d0), f(u1, v0, d0), f(u1, v0, d1), f(u0, v0, d1)])
    return faces


def tube(ring_below, ring_above):
    """Side faces between two counter-clockwise rings (seen from above) of equal length, seen from outside."""
    n = len(ring_below)
    return [[ring_below[i], ring_below[(i + 1) % n], ring_above[(i + 1) % n], ring_above[i]] for i in range(n)]
