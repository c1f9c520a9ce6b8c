// What a ray from the viewpoint meets, and the ground below.
quadratura.ground = (() => {
  "use strict";
  const { add, sub, times, dot, cross, length } = quadratura.math;

  // Returns the distance along a ray, in lengths of its direction, at which it meets a triangle; infinity where it does not.
  function met(origin, direction, a, b, c) {
    const ab = sub(b, a), ac = sub(c, a), p = cross(direction, ac), area = dot(ab, p);
    if (area === 0) return Infinity;
    const from = sub(origin, a), u = dot(from, p) / area;
    if (u < 0 || u > 1) return Infinity;
    const q = cross(from, ab), v = dot(direction, q) / area;
    if (v < 0 || u + v > 1) return Infinity;
    const t = dot(ac, q) / area;
    return t > 1e-6 ? t : Infinity;
  }

  class Ground {
    constructor(geometry) {
      this.geometry = geometry;
      this.patches = geometry.patches.filter((patch) => geometry.surfaces[patch.surface].kind !== quadratura.geometry.SKIRT && patch.corners.length);
    }

    // Returns what a ray meets first: distance in lengths of the direction, point and surface; null for nothing.
    hit(origin, direction) {
      let t = Infinity, number = -1;
      const along = length(direction);
      for (const patch of this.patches) {
        const to = sub(patch.centre, origin), ahead = dot(to, direction) / along;
        if (ahead < -patch.radius || dot(to, to) - ahead * ahead > patch.radius * patch.radius) continue;
        for (let i = 0; i < patch.corners.length; i += 3) {
          const at = met(origin, direction, patch.corners[i], patch.corners[i + 1], patch.corners[i + 2]);
          if (at < t) [t, number] = [at, patch.surface];
        }
      }
      return number < 0 ? null : { t, point: add(origin, times(direction, t)), surface: this.geometry.surfaces[number] };
    }

    // Returns the height of a point over the ground; null where there is none.
    over(point, up) {
      const found = this.hit(point, times(up, -1));
      return found && found.t;
    }
  }

  return { Ground };
})();
