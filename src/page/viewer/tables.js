// The tables that shaders read (tables.glsl): what stays, and what changes with the viewpoint.
quadratura.tables = (() => {
  "use strict";
  const { sub, dot, row, times } = quadratura.math;
  const WIDTH = 1024, SURFACES = 128, SURFACE_WORDS = 10, PHOTO_WORDS = 11;
  // The width of the ramp at a photo's border, as a share of its shorter side.
  const BORDER_SHARE = 0.05;

  // Words of four numbers, one after the other.
  class Words {
    constructor() { this.numbers = new Uint32Array(1 << 16); this.count = 1; }
    // Adds words and returns the place of the first one.
    add(numbers) {
      const place = this.count, end = 4 * place + numbers.length;
      if (end > this.numbers.length) {
        const larger = new Uint32Array(Math.max(2 * this.numbers.length, end));
        larger.set(this.numbers);
        this.numbers = larger;
      }
      this.numbers.set(numbers, 4 * place);
      this.count = place + Math.ceil(numbers.length / 4);
      return place;
    }
  }

  // Writes layers and servers, and tells each server its place.
  function serverWords(geometry, parts) {
    const words = new Words(), numbers = quadratura.numbers;
    const sets = numbers(Uint32Array, parts.layer_labels);
    const labels = Array.from({ length: sets.length / 8 }, (_, layer) => words.add(sets.subarray(8 * layer, 8 * layer + 8)));
    const tiles = ["hidden", "cut"].map((name) => {
      const places = numbers(Uint32Array, parts[name + "_tiles"]), slots = numbers(Uint32Array, parts[name + "_slots"]), of = new Map();
      for (let i = 0, at = 0; i < places.length; i += 6) {
        const [layer, pixels, x, y, columns, rows] = places.subarray(i, i + 6), count = columns * rows;
        of.set(layer, words.add([pixels, columns, rows, 0, x, y, 0, 0, ...slots.subarray(at, at + count)]));
        at += count;
      }
      return of;
    });
    for (const server of geometry.all) {
      const sides = server.sides.length / 3;
      const halfPlanes = new Float32Array(4 * sides);
      for (let i = 0; i < sides; i++) halfPlanes.set(server.sides.subarray(3 * i, 3 * i + 3), 4 * i);
      const flags = (server.back ? 1 << 16 : 0) | (server.pinned ? 2 << 16 : 0);
      server.place = words.add([(server.photo | flags | (sides << 24)) >>> 0, labels[server.layer], tiles[0].get(server.layer) || 0, tiles[1].get(server.layer) || 0,
        ...new Uint32Array(halfPlanes.buffer)]);
    }
    return words;
  }

  class Tables {
    constructor(gl, site, geometry, parts) {
      Object.assign(this, { gl, site, geometry });
      const words = serverWords(geometry, parts);
      this.servers = this.texture();
      this.write(this.servers, gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, WIDTH, words.count, words.numbers, 4);
      [this.candidates, this.patches, this.surfaces, this.photos] = [0, 0, 0, 0].map(() => this.texture());
      this.surfaceRows = Math.max(1, Math.ceil(geometry.surfaces.length / SURFACES));
      this.surfaceWords = new Float32Array(4 * SURFACES * SURFACE_WORDS * this.surfaceRows);
      this.photoWords = new Float32Array(4 * PHOTO_WORDS * Math.max(1, site.photos.length));
    }

    texture() {
      const gl = this.gl, texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      return texture;
    }

    // Writes `count` words of `parts` numbers into rows of a texture.
    write(texture, kept, given, type, width, count, numbers, parts) {
      const gl = this.gl, rows = Math.max(1, Math.ceil(count / width)), need = parts * width * rows;
      let all = numbers;
      if (all.length < need) { all = new numbers.constructor(need); all.set(numbers); }
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, kept, width, rows, 0, given, type, all.subarray(0, need));
    }

    writeLists(lists) {
      const gl = this.gl;
      this.write(this.candidates, gl.RG32F, gl.RG, gl.FLOAT, WIDTH, lists.count, lists.values, 2);
    }

    writePatches(lists) {
      const gl = this.gl;
      this.write(this.patches, gl.RGBA32F, gl.RGBA, gl.FLOAT, WIDTH, this.geometry.patches.length, lists.ranges, 4);
    }

    // Writes the surfaces as seen from a viewpoint.
    writeSurfaces(eye) {
      const gl = this.gl, words = this.surfaceWords;
      this.geometry.surfaces.forEach((surface, i) => {
        const at = 4 * SURFACE_WORDS * i;
        words.set(surface.normal, at);
        words[at + 3] = surface.offset - dot(surface.normal, eye);
        if (surface.relief) this.grid(at + 4, surface.relief, eye);
        if (surface.continued) this.grid(at + 16, surface.continued, eye);
        words[at + 28] = surface.kind === 0 ? 0 : surface.kind;
        words[at + 29] = surface.billboard || surface.impostor ? 1 : 0;
        if (surface.impostor) {
          words.set([...sub(surface.impostor.foot, eye), surface.impostor.halfWidth, ...surface.impostor.axis, 0], at + 32);
        }
      });
      gl.bindTexture(gl.TEXTURE_2D, this.surfaces);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, SURFACES * SURFACE_WORDS, this.surfaceRows, 0, gl.RGBA, gl.FLOAT, words);
    }

    grid(at, { mapping: m, place }, eye) {
      this.surfaceWords.set([m[0], m[1], m[2], m[3] + m[0] * eye[0] + m[1] * eye[1] + m[2] * eye[2],
        m[4], m[5], m[6], m[7] + m[4] * eye[0] + m[5] * eye[1] + m[6] * eye[2], ...place], at);
    }

    // Writes the photos as seen from a viewpoint, with what the exposure says of each.
    writePhotos(eye, exposure, textures, now) {
      const gl = this.gl, { near, far } = textures;
      let sky = 0;
      this.site.photos.forEach((photo, i) => {
        const [fx, fy, cx, cy] = photo.lens, [width, height] = photo.size;
        const centre = sub(photo.centre, eye), [r1, r2, r3] = [0, 1, 2].map((k) => row(photo.rotation, k));
        const rows = [quadratura.math.add(times(r1, fx), times(r3, cx)), quadratura.math.add(times(r2, fy), times(r3, cy)), r3];
        const scale = (size, texture, by) => {
          const reduction = size[0] / width * by;
          return [reduction / texture.size[0], reduction / texture.size[1]];
        };
        const [added, ...falloff] = exposure.isRaw ? [0, 0, 0] : photo.optics;
        const state = textures.state[i], fade = textures.fade(i, now);
        // The shares of the photo's pixels along a side that the loaded pictures have.
        const fine = Math.min(1, photo.stored[0] / width) * textures.scale, coarse = photo.far[0] / width;
        const [storedWidth, storedHeight] = quadratura.textures.stored(photo, photo.size);
        this.photoWords.set([
          ...rows.flatMap((r) => [...r, -dot(r, centre)]), ...centre, fx * fy,
          width, height, (photo.turned ? -1 : 1) / (BORDER_SHARE * Math.min(width, height)), added,
          ...exposure.factors[i], exposure.left[i],
          cx, cy, ...falloff,
          photo.sky ? ++sky : 0, photo.sky ? exposure.skyShare * exposure.left[i] : 0, fade, 0,
          ...scale(photo.stored, near, textures.scale), Math.max(state.slot, 0), photo.stored[0] / width * textures.scale,
          ...scale(photo.far, far, 1), i < textures.held ? i : -1, Math.ceil(photo.far[0] / 2) / width,
          storedWidth, storedHeight, fade, -Math.log2(fine * fade + coarse * (1 - fade)),
        ], 4 * PHOTO_WORDS * i);
      });
      gl.bindTexture(gl.TEXTURE_2D, this.photos);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, PHOTO_WORDS, Math.max(1, this.site.photos.length), 0, gl.RGBA, gl.FLOAT, this.photoWords);
    }
  }

  return { Tables };
})();
