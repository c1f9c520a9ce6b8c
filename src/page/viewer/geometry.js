// The model: surfaces in planes, cut into small patches for which photos are listed, and the photos that serve each face.
quadratura.geometry = (() => {
  "use strict";
  const { add, sub, times, dot, distance } = quadratura.math;

  // What a surface is.
  const OPAQUE = 0, SEE_THROUGH = 1, IMPOSTOR = 2, SKIRT = 3;
  // A patch spans a sixteenth of what cameras span, and there are so many at most.
  const PATCHES_ACROSS = 16, MOST_PATCHES = 16000;

  // Cuts a triangle until no side is longer than a limit. Sides are halved, so that the neighbour across a side is cut at the same
  // points and no crack opens.
  function cut(a, b, c, limit, out) {
    const sides = [distance(a, b), distance(b, c), distance(c, a)];
    const longest = Math.max(...sides);
    if (!(longest > limit)) { out.push([a, b, c]); return; }
    const half = (p, q) => times(add(p, q), 0.5);
    if (sides[0] === longest) { const m = half(a, b); cut(a, m, c, limit, out); cut(m, b, c, limit, out); }
    else if (sides[1] === longest) { const m = half(b, c); cut(a, b, m, limit, out); cut(a, m, c, limit, out); }
    else { const m = half(c, a); cut(a, b, m, limit, out); cut(m, b, c, limit, out); }
  }

  // Returns the ball around points.
  function ball(points) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const p of points) for (let i = 0; i < 3; i++) { low[i] = Math.min(low[i], p[i]); high[i] = Math.max(high[i], p[i]); }
    const centre = times(add(low, high), 0.5);
    return { centre, radius: points.reduce((most, p) => Math.max(most, distance(p, centre)), 0) };
  }

  // Groups triangles of a surface by cells of a grid in space.
  function patchesOf(surface, triangles, cell) {
    const groups = new Map();
    for (const triangle of triangles) {
      const middle = times(add(add(triangle[0], triangle[1]), triangle[2]), 1 / 3);
      const key = middle.map((value) => Math.floor(value / cell)).join();
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(...triangle);
    }
    return [...groups.values()].map((corners) => ({ surface, corners, ...ball(corners) }));
  }

  // Returns points around all rectangles of an impostor.
  function around({ foot, axis, height, halfWidth }) {
    const out = [halfWidth, halfWidth, halfWidth], top = add(foot, times(axis, height));
    return [sub(foot, out), add(foot, out), sub(top, out), add(top, out)];
  }

  function surfacesOf(parts) {
    const numbers = quadratura.numbers;
    const vertices = numbers(Float32Array, parts.vertices), planes = numbers(Float64Array, parts.surface_planes);
    const faces = numbers(Uint32Array, parts.surface_faces), counts = numbers(Uint32Array, parts.surface_triangles);
    const corners = numbers(Uint32Array, parts.corners);
    const point = (vertex) => [vertices[3 * vertex], vertices[3 * vertex + 1], vertices[3 * vertex + 2]];
    let at = 0;
    return [...faces].map((face, i) => {
      const triangles = [];
      for (let k = 0; k < counts[i]; k++, at += 3) triangles.push([point(corners[at]), point(corners[at + 1]), point(corners[at + 2])]);
      return {
        face, kind: parts.surface_kinds[i], normal: [...planes.subarray(4 * i, 4 * i + 3)], offset: planes[4 * i + 3], triangles,
        billboard: parts.face_billboards[face] === 1,
      };
    });
  }

  function addImpostors(surfaces, parts) {
    const faces = quadratura.numbers(Uint32Array, parts.impostor_faces), values = quadratura.numbers(Float64Array, parts.impostors);
    faces.forEach((face, i) => {
      const [fx, fy, fz, ax, ay, az, height, halfWidth] = values.subarray(8 * i, 8 * i + 8);
      const surface = surfaces.find((other) => other.face === face);
      surface.impostor = { foot: [fx, fy, fz], axis: [ax, ay, az], height, halfWidth };
    });
  }

  // Gives surfaces the grid of a kind in the plane of their face.
  function addGrids(surfaces, parts, name, set) {
    const faces = quadratura.numbers(Uint32Array, parts[name + "_faces"]);
    const mappings = quadratura.numbers(Float64Array, parts[name + "_mappings"]), places = quadratura.numbers(Uint16Array, parts[name + "_places"]);
    const grids = new Map();
    faces.forEach((face, i) => grids.set(face, { number: i, mapping: mappings.subarray(8 * i, 8 * i + 8), place: places.subarray(4 * i, 4 * i + 4) }));
    for (const surface of surfaces) if (grids.has(surface.face)) set(surface, grids.get(surface.face));
  }

  // Returns the heights of all faces, in world units, as a sheet; and tells each surface its largest height.
  function heightsOf(surfaces, sheets) {
    const [width, height] = quadratura.numbers(Uint32Array, sheets.relief_size);
    const packed = quadratura.numbers(Int16Array, sheets.relief_heights), steps = quadratura.numbers(Float32Array, sheets.relief_steps);
    for (let i = 1; i < packed.length; i++) packed[i] += packed[i - 1];
    const values = new Float32Array(width * height);
    const done = new Set();
    for (const { relief } of surfaces) {
      if (!relief || done.has(relief.number)) continue;
      done.add(relief.number);
      const [x, y, w, h] = relief.place, step = steps[relief.number];
      relief.largest = 0;
      for (let row = y; row < y + h; row++) {
        for (let at = row * width + x; at < row * width + x + w; at++) {
          values[at] = packed[at] * step;
          relief.largest = Math.max(relief.largest, Math.abs(values[at]));
        }
      }
    }
    return { width, height, values };
  }

  // Returns the servers of each face, and of the surroundings.
  function serversOf(parts) {
    const numbers = quadratura.numbers;
    const counts = numbers(Uint32Array, parts.server_counts), photos = numbers(Uint16Array, parts.server_photos);
    const layers = numbers(Uint32Array, parts.server_layers), halfPlanes = numbers(Float32Array, parts.half_planes);
    let side = 0;
    const all = [...photos].map((photo, i) => {
      const sides = halfPlanes.subarray(3 * side, 3 * (side + parts.server_sides[i]));
      side += parts.server_sides[i];
      return { photo, layer: layers[i], back: (parts.server_flags[i] & 1) !== 0, pinned: (parts.server_flags[i] & 2) !== 0, sides };
    });
    let at = 0;
    const ofFace = [...counts].map((count) => all.slice(at, at += count));
    return { all, ofFace, around: ofFace.pop() };
  }

  // Reads the chunks of geometry and of sheets.
  function read(parts, sheets, site) {
    const surfaces = surfacesOf(parts);
    addImpostors(surfaces, parts);
    addGrids(surfaces, sheets, "relief", (surface, grid) => { surface.relief = surface.kind === SKIRT ? undefined : grid; });
    addGrids(surfaces, sheets, "continued", (surface, grid) => { surface.continued = grid; });
    const heights = heightsOf(surfaces, sheets);
    let cell = Math.max(site.extent * 2 / PATCHES_ACROSS, 1e-6), patches;
    do {
      patches = surfaces.flatMap((surface, i) => {
        if (surface.impostor) return [{ surface: i, corners: [], ...ball(around(surface.impostor)) }];
        const triangles = [];
        for (const [a, b, c] of surface.triangles) cut(a, b, c, cell, triangles);
        return patchesOf(i, triangles, cell);
      });
      cell *= 1.5;
    } while (patches.length > MOST_PATCHES);
    return { surfaces, patches, heights, ...serversOf(parts) };
  }

  // Returns the rectangle of an impostor that faces a viewpoint, counter-clockwise from the lower left, and its plane.
  function rectangle({ foot, axis, height, halfWidth }, eye, right) {
    const { cross, unit, length } = quadratura.math;
    let across = cross(axis, sub(eye, foot));
    across = length(across) < 1e-3 * halfWidth ? unit(sub(right, times(axis, dot(axis, right)))) : unit(across);
    const side = times(across, halfWidth), top = add(foot, times(axis, height));
    const normal = cross(across, axis);
    return { corners: [sub(foot, side), add(foot, side), add(top, side), sub(top, side)], normal, offset: dot(normal, foot) };
  }

  return { read, rectangle, ball, OPAQUE, SEE_THROUGH, IMPOSTOR, SKIRT };
})();
