"""Building blocks of the detailed scene: a mesh builder and the parts that facades and roofs are made of."""

import random
from math import cos, pi, sin

import bpy
from mathutils import Vector
from mathutils.geometry import tessellate_polygon

from shapes import rectangle


class Builder:
    """Collects polygons with a material, a tint (0..1, read by some materials) and smoothness; makes one mesh."""

    def __init__(self):
        self.vertices, self.faces, self.slots, self.tints, self.smooths, self.materials = [], [], [], [], [], []

    def poly(self, points, material, tint=0.5, smooth=False):
        first = len(self.vertices)
        self.vertices.extend(points)
        self.face(range(first, first + len(points)), material, tint, smooth)

    def face(self, indices, material, tint=0.5, smooth=False):
        if material not in self.materials:
            self.materials.append(material)
        self.faces.append(tuple(indices))
        self.slots.append(self.materials.index(material))
        self.tints.append(tint)
        self.smooths.append(smooth)

    def polys(self, faces, material, tint=0.5):
        for face in faces:
            self.poly(face, material, tint)

    def mesh(self, name):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata(self.vertices, [], self.faces)
        for material in self.materials:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", self.slots)
        mesh.polygons.foreach_set("use_smooth", self.smooths)
        mesh.attributes.new("tint", "FLOAT", "FACE").data.foreach_set("value", self.tints)
        mesh.update()
        return mesh

    # --- parts in a wall's coordinates -------------------------------------------------------------------

    def sheet(self, frame, outline, holes, material, d=0.0):
        """A wall's face with holes in it; `outline` counter-clockwise, any order for the holes."""
        rings = [outline] + holes
        flat = [p for ring in rings for p in ring]
        for triangle in tessellate_polygon([[Vector((u, v, 0)) for u, v in ring] for ring in rings]):
            a, b, c = (flat[i] for i in triangle)
            if (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0:
                b, c = c, b
            self.poly([frame.at(*p, d) for p in (a, b, c)], material)

    def reveal(self, frame, ring, depth, material, closed=True, d=0.0):
        """The sides of a hole, going clockwise around it (closed) or along an open line."""
        nxt = ring[1:] + ring[:1] if closed else ring[1:]
        for p, q in zip(ring, nxt):
            self.poly([frame.at(*p, d), frame.at(*p, d - depth), frame.at(*q, d - depth), frame.at(*q, d)], material)

    def box(self, frame, u0, u1, v0, v1, d0, d1, material, tint=0.5, bevel=0.0):
        """With `bevel` the front edges are chamfered, which catches light as worn stone does."""
        b = min(bevel, (u1 - u0) / 3, (v1 - v0) / 3, (d1 - d0))
        at = frame.at
        back = [at(u, v, d0) for u, v in rectangle(u0, v0, u1, v1)]
        side = [at(u, v, d1 - b) for u, v in rectangle(u0, v0, u1, v1)]
        front = [at(u, v, d1) for u, v in rectangle(u0 + b, v0 + b, u1 - b, v1 - b)]
        rings = [back, side, front] if b > 0 else [back, side]
        for near, far in zip(rings[1:], rings):
            for i in range(4):
                self.poly([far[i], far[(i + 1) % 4], near[(i + 1) % 4], near[i]], material, tint)
        self.poly(rings[-1], material, tint)
        self.poly(back[::-1], material, tint)

    def sweep(self, frame, profile, u0, u1, material, mitre0=0, mitre1=0):
        """A moulding: `profile` [(d, v)] from below to above, drawn from u0 to u1.

        A mitre of 1 lets the end grow with the projection d (an outer corner), 0 cuts it square and closes it.
        """
        start = [frame.at(u0 - mitre0 * d, v, d) for d, v in profile]
        end = [frame.at(u1 + mitre1 * d, v, d) for d, v in profile]
        for i in range(len(profile) - 1):
            self.poly([start[i], end[i], end[i + 1], start[i + 1]], material)
        if not mitre0:
            self.poly(start[::-1], material)
        if not mitre1:
            self.poly(end, material)

    def moulded_line(self, frame, centreline, profile, material, closed=False):
        """A moulding that follows a line in the wall plane; `profile` [(offset to the left of it, d)]."""
        count = len(centreline)
        sides = []
        for i, (u, v) in enumerate(centreline):
            before = centreline[i - 1] if i or closed else None
            after = centreline[(i + 1) % count] if i + 1 < count or closed else None
            sides.append(mitre_normal(before, (u, v), after))
        rings = [[frame.at(u + n[0] * o, v + n[1] * o, d) for o, d in profile] for (u, v), n in zip(centreline, sides)]
        pairs = list(zip(rings, rings[1:] + rings[:1])) if closed else list(zip(rings, rings[1:]))
        for a, b in pairs:
            for i in range(len(profile) - 1):
                self.poly([a[i], b[i], b[i + 1], a[i + 1]], material)
        if not closed:
            self.poly(rings[0][::-1], material)
            self.poly(rings[-1], material)

    # --- round things -------------------------------------------------------------------------------------

    def revolve(self, centre, profile, material, count=48, lobes=0, lobe_depth=0.0, smooth=True, tint=0.5):
        """`profile` [(radius, z)] from below to above, about an upright axis."""
        first = len(self.vertices)
        for radius, z in profile:
            for i in range(count):
                a = 2 * pi * i / count
                r = radius * (1 + lobe_depth * abs(cos(lobes * a / 2))) if lobes else radius
                self.vertices.append((centre[0] + r * cos(a), centre[1] + r * sin(a), z))
        for k in range(len(profile) - 1):
            for i in range(count):
                j = (i + 1) % count
                a, b = first + k * count, first + (k + 1) * count
                self.face((a + i, a + j, b + j, b + i), material, tint, smooth)

    def polygon_prism(self, rings, material, tint=0.5):
        """Side faces through a list of rings [(x, y, z)] from below to above."""
        for low, high in zip(rings, rings[1:]):
            n = len(low)
            for i in range(n):
                self.poly([low[i], low[(i + 1) % n], high[(i + 1) % n], high[i]], material, tint)

    # --- roofs --------------------------------------------------------------------------------------------

    def tiles(self, slope, material, seed, pitch=0.235, course=0.36):
        """Round clay tiles over a planar slope whose first edge is the eaves (left to right from outside)."""
        rng = random.Random(seed)
        points = [Vector(p) for p in slope]
        along = (points[1] - points[0]).normalized()
        normal = (points[1] - points[0]).cross(points[-1] - points[0]).normalized()
        up = normal.cross(along)
        local = [((p - points[0]).dot(along), (p - points[0]).dot(up)) for p in points]
        height = max(y for _, y in local)
        place = lambda x, y, z: tuple(points[0] + along * x + up * y + normal * z)
        self.poly([tuple(p - normal * 0.03) for p in points], material, 0.2)
        for row in range(int(height / course) + 1):
            y0 = row * course - 0.06
            span = extent(local, min(max(y0 + course / 2, 0.01), height - 0.01))
            if span is None:
                continue
            drift = rng.uniform(-0.01, 0.01)
            for column in range(int((span[1] - span[0]) / pitch) + 1):
                x = span[0] + (column + 0.5) * pitch + drift
                if x < span[1]:
                    self.tile(place, x, y0, pitch, course, rng, material)

    def tile(self, place, x, y, pitch, course, rng, material):
        """One cover tile: a half pipe, a little wider and higher at its lower end."""
        tint, lift = rng.random(), rng.uniform(0.0, 0.018)
        x += rng.uniform(-0.012, 0.012)
        arcs = []
        for end, (along, radius, base) in enumerate(((0, 0.105, 0.035), (course * 1.12, 0.085, 0.0))):
            arcs.append([])
            for k in range(6):
                a = pi - pi * k / 5
                z = base + lift + radius * 0.85 * sin(a) - 0.03
                arcs[-1].append(place(x + radius * cos(a), y + along, z))
        for k in range(5):
            self.poly([arcs[0][k + 1], arcs[0][k], arcs[1][k], arcs[1][k + 1]][::-1], material, tint)
        self.poly(arcs[0], material, tint * 0.3)

    def ridge(self, a, b, material, seed, radius=0.12, course=0.4):
        """Larger half pipes along an edge between two slopes."""
        rng = random.Random(seed)
        a, b = Vector(a), Vector(b)
        along = (b - a).normalized()
        side = along.cross(Vector((0, 0, 1))).normalized()
        up = side.cross(along)
        count = max(1, int((b - a).length / course))
        for i in range(count):
            tint = rng.random()
            ends = [a + (b - a) * (i / count), a + (b - a) * ((i + 1.12) / count)]
            arcs = []
            for centre, r in zip(ends, (radius, radius * 0.85)):
                arcs.append(
                    [tuple(centre + side * r * cos(pi * k / 6) + up * (r * sin(pi * k / 6) + 0.02)) for k in range(7)]
                )
            for k in range(6):
                self.poly([arcs[0][k], arcs[0][k + 1], arcs[1][k + 1], arcs[1][k]], material, tint)


def mitre_normal(before, here, after):
    """The offset direction to the left of a line at one of its points, lengthened at corners."""

    def left(p, q):
        dx, dy = q[0] - p[0], q[1] - p[1]
        n = (dx * dx + dy * dy) ** 0.5
        return (-dy / n, dx / n)

    normals = [left(before, here)] if before else []
    normals += [left(here, after)] if after else []
    x, y = sum(n[0] for n in normals), sum(n[1] for n in normals)
    length = x * x + y * y
    scale = len(normals) / length if len(normals) == 2 else 1.0
    return (x * scale, y * scale)


def extent(polygon, y):
    """Where a horizontal line at y cuts a convex polygon."""
    cuts = []
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y0 <= y) != (y1 <= y):
            cuts.append(x0 + (x1 - x0) * (y - y0) / (y1 - y0))
    return (min(cuts), max(cuts)) if len(cuts) > 1 else None
