// For each patch the servers that may show it from a place, by rising lower bound of their penalty. A list holds for all viewpoints in a
// ball, so that it is not made anew for each step.
quadratura.lists = (() => {
  "use strict";
  const { sub, dot, length, distance, rotated } = quadratura.math;

  const LEAST_ANGLE = 1e-6, OTHER_SIDE = 1000, MIRRORED = 0.5;
  // The least cosine of the angle to the normal for which points of a relief are moved.
  const LEAST_FACING = 0.1;
  // Viewpoints that are nearer to the middle of a ball than this share of the cameras' extent use its lists.
  const BALL = 0.02;

  // Returns a lower bound of the angle between the directions to two points, from anywhere in a ball around the origin; `slack` is how far
  // the first point may move.
  function leastAngle(a, b, radius, slack) {
    const x = length(a), y = length(b);
    if (x <= radius + slack || y <= radius) return 0;
    const cosine = dot(a, b) / (x * y);
    const angle = Math.acos(Math.min(1, Math.max(-1, cosine)));
    const change = radius * Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / ((x - radius) * (y - radius)) + slack / (x - radius - slack);
    return Math.max(0, angle - change);
  }

  // Returns whether some point of a ball may be in a photo.
  function meets(photo, centre, radius) {
    const p = rotated(photo.rotation, sub(centre, photo.centre));
    if (p[2] + radius <= 0) return false;
    const [fx, fy, cx, cy] = photo.lens, [width, height] = photo.size;
    // The distances from the four planes through the camera and the picture's sides.
    const planes = [[fx * p[0] + cx * p[2], fx, cx], [(width - cx) * p[2] - fx * p[0], fx, width - cx],
      [fy * p[1] + cy * p[2], fy, cy], [(height - cy) * p[2] - fy * p[1], fy, height - cy]];
    return planes.every(([value, f, c]) => value / Math.hypot(f, c) > -radius);
  }

  class Lists {
    constructor(site, geometry) {
      Object.assign(this, { site, geometry });
      this.slack = BALL * Math.max(site.extent, 1e-6);
      this.values = new Float32Array(1 << 14);
      // Which servers may show a patch does not depend on the viewpoint.
      this.servers = geometry.patches.map((patch) => this.serving(patch.surface, patch.centre, patch.radius));
      this.ranges = new Float32Array(4 * Math.max(1, geometry.patches.length));
    }

    serving(number, centre, radius) {
      const surface = this.geometry.surfaces[number];
      const reach = radius + (surface.relief ? surface.relief.largest / LEAST_FACING : 0);
      return this.geometry.ofFace[surface.face].filter((server) => meets(this.site.photos[server.photo], centre, reach));
    }

    // Makes the lists for viewpoints around this one, unless those that there are serve it. Returns whether they are new.
    update(eye) {
      if (this.eye && distance(eye, this.eye) <= this.slack) {
        this.count = this.ofPatches;
        return false;
      }
      this.eye = eye;
      this.count = 0;
      this.geometry.patches.forEach((patch, i) => {
        const first = this.count;
        this.list(this.servers[i], this.geometry.surfaces[patch.surface], patch, eye, this.slack);
        this.ranges.set([patch.surface, first, this.count - first, 0], 4 * i);
      });
      this.ofPatches = this.count;
      return true;
    }

    // Adds the list of a part of a surface: the candidates that may be seen from a ball of viewpoints.
    list(servers, surface, { centre, radius }, eye, slack) {
      const height = dot(surface.normal, eye) - surface.offset;
      const toEye = sub(eye, centre), apart = length(toEye);
      const facing = Math.max(LEAST_FACING, Math.abs(height) / (apart + radius));
      const reach = radius + (surface.relief ? surface.relief.largest / facing : 0);
      const found = [];
      for (const server of servers) {
        const other = server.back !== (height < 0);
        // Within the ball the viewpoint may be on either side.
        if (other && Math.abs(height) > slack && !surface.billboard && !surface.impostor) continue;
        const photo = this.site.photos[server.photo];
        const least = surface.impostor ? 0 : leastAngle(toEye, sub(photo.centre, centre), reach, slack);
        const aside = other && (surface.billboard || surface.impostor) ? (surface.impostor ? MIRRORED : OTHER_SIDE) : 0;
        found.push([server.pinned ? 0 : least + aside + LEAST_ANGLE, server.place]);
      }
      found.sort((a, b) => a[0] - b[0]);
      this.add(found);
    }

    // Adds the servers of the surroundings for a viewpoint, by the distance of their cameras. Returns their range.
    addAround(eye) {
      const found = this.geometry.around.map((server) => {
        const away = distance(this.site.photos[server.photo].centre, eye) / Math.max(this.site.surroundings_scale, 1e-300);
        return [away + LEAST_ANGLE, server.place];
      });
      found.sort((a, b) => a[0] - b[0]);
      const first = this.count;
      this.add(found);
      return [first, found.length];
    }

    add(found) {
      if (2 * (this.count + found.length) > this.values.length) {
        const larger = new Float32Array(2 * this.values.length + 2 * found.length);
        larger.set(this.values);
        this.values = larger;
      }
      for (const [least, place] of found) {
        // Rounded down, so that it stays a lower bound.
        this.values[2 * this.count] = least * (1 - 1e-6);
        this.values[2 * this.count + 1] = place;
        this.count++;
      }
    }
  }

  return { Lists };
})();
