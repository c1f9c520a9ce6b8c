// Draws the site: depths first, then what photos show of the nearest surfaces, what is around, what stands on outlines, and what one sees
// through, from back to front.
quadratura.painter = (() => {
  "use strict";
  const { sub, dot, row, distance } = quadratura.math;
  const { program, Target } = quadratura.target;

  // Surfaces within this share of the nearest depth count as one, of which the last is shown.
  const TOLERANCE = 1e-4;
  const SHOWN = ["weights", "tables", "texels", "blend"];

  class Painter {
    constructor(canvas, changed) {
      this.gl = quadratura.deviceOf(canvas);
      this.changed = changed;
      this.pixel = new Uint8Array(4);
      this.target = new Target(this.gl);
      this.reducer = new quadratura.levels.Reducer(this.gl);
      this.depths = program(this.gl, ["surface_vertex"], ["depth"]);
      this.opaque = program(this.gl, ["surface_vertex"], [...SHOWN, "around", "surface"]);
      this.behind = program(this.gl, ["whole"], [...SHOWN, "around", "behind"]);
      this.through = program(this.gl, ["surface_vertex"], [...SHOWN, "surface"], "#define SEE_THROUGH\n");
    }

    prepare(site, geometry, parts, sheets) {
      Object.assign(this, { site, geometry });
      this.textures = new quadratura.textures.Textures(this.gl, site, this.reducer, this.changed);
      this.tables = new quadratura.tables.Tables(this.gl, site, geometry, parts);
      this.lists = new quadratura.lists.Lists(site, geometry);
      this.meter = new quadratura.meter.Meter(this.gl, site);
      this.loadSheets(sheets);
      this.loadCorners();
    }

    sheet(kept, given, type, width, height, values) {
      const gl = this.gl, texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texImage2D(gl.TEXTURE_2D, 0, kept, width, height, 0, given, type, values);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      return texture;
    }

    loadSheets(sheets) {
      const gl = this.gl, { width, height, values } = this.geometry.heights, numbers = quadratura.numbers;
      this.heights = this.sheet(gl.R16F, gl.RED, gl.FLOAT, width, height, values);
      const [w, h] = numbers(Uint32Array, sheets.continued_size);
      const rgb = quadratura.summed(sheets.continued_colours, 3), rgba = new Uint8Array(4 * w * h);
      for (let i = 0; i < w * h; i++) rgba.set([rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255], 4 * i);
      this.continued = this.sheet(gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, w, h, rgba);
      // 32 x 32 cells of three logarithms a photo, in steps of 1 / 4096.
      const logs = numbers(Int16Array, sheets.sky), grids = logs.length / 3072, rows = Math.max(1, Math.ceil(grids / 16));
      const sky = new Float32Array(4 * 512 * 32 * rows);
      for (let i = 0; i < logs.length / 3; i++) {
        const grid = Math.floor(i / 1024), cell = i % 1024, x = grid % 16 * 32 + cell % 32, y = Math.floor(grid / 16) * 32 + Math.floor(cell / 32);
        for (let c = 0; c < 3; c++) sky[4 * (y * 512 + x) + c] = logs[3 * i + c] / 4096;
      }
      quadratura.exposure.readMeter(this.site, numbers(Float32Array, sheets.meter));
      this.sky = this.sheet(gl.RGBA16F, gl.RGBA, gl.FLOAT, 512, 32 * rows, sky);
      this.dome = gl.createTexture();
    }

    // Reads what is around. The picture has the six sides below each other, the map has them in another order and turned.
    async loadDome() {
      if (this.site.dome === null) return;
      const gl = this.gl, { sides } = await quadratura.load("dome", () => -1);
      const whole = await quadratura.pictureOf(sides, "image/jpeg"), side = whole.width;
      const faces = [gl.TEXTURE_CUBE_MAP_POSITIVE_X, gl.TEXTURE_CUBE_MAP_NEGATIVE_X, gl.TEXTURE_CUBE_MAP_POSITIVE_Z, gl.TEXTURE_CUBE_MAP_NEGATIVE_Z,
        gl.TEXTURE_CUBE_MAP_POSITIVE_Y, gl.TEXTURE_CUBE_MAP_NEGATIVE_Y];
      const pictures = await Promise.all(faces.map((_, i) => createImageBitmap(whole, 0, i * side, side, side)));
      gl.bindTexture(gl.TEXTURE_CUBE_MAP, this.dome);
      pictures.forEach((picture, i) => gl.texImage2D(faces[i], 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, picture));
      gl.generateMipmap(gl.TEXTURE_CUBE_MAP);
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
      this.domeWhite = this.site.dome;
      this.changed();
    }

    // Puts the corners of all patches on the device: opaque ones, then each surface that one sees through and each skirt.
    loadCorners() {
      const gl = this.gl, { surfaces, patches } = this.geometry, { OPAQUE, IMPOSTOR } = quadratura.geometry;
      const values = [];
      this.ranges = surfaces.map(() => [0, 0]);
      const push = ({ corners }, number) => corners.forEach((corner) => values.push(...corner, number));
      patches.forEach((patch, i) => { if (surfaces[patch.surface].kind === OPAQUE) push(patch, i); });
      this.opaqueCorners = values.length / 4;
      this.layered = [];
      patches.forEach((patch, i) => {
        const { kind } = surfaces[patch.surface];
        if (kind === OPAQUE) return;
        const first = values.length / 4;
        if (kind === IMPOSTOR) for (let k = 0; k < 6; k++) values.push(0, 0, 0, i);
        else push(patch, i);
        this.layered.push({ kind, surface: surfaces[patch.surface], number: i, first, count: values.length / 4 - first, centre: patch.centre });
      });
      this.corners = gl.createVertexArray();
      gl.bindVertexArray(this.corners);
      this.buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(values), gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 16, 0);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 1, gl.FLOAT, false, 16, 12);
      gl.bindVertexArray(null);
    }

    turnImpostors(view) {
      const gl = this.gl;
      for (const { kind, surface, number, first } of this.layered) {
        if (kind !== quadratura.geometry.IMPOSTOR) continue;
        const { corners: [a, b, c, d], normal, offset } = quadratura.geometry.rectangle(surface.impostor, view.eye, row(view.rotation, 0));
        Object.assign(surface, { normal, offset });
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
        gl.bufferSubData(gl.ARRAY_BUFFER, 16 * first, new Float32Array([a, b, c, a, c, d].flatMap((corner) => [...corner, number])));
      }
    }

    // Returns a near plane before everything that may be seen, and as far as that allows: depths are the finer. No point of a patch is
    // nearer than its plane and its ball.
    nearOf({ eye, fx, fy, cx, cy, width, height }) {
      const { surfaces, patches } = this.geometry;
      let least = Infinity;
      for (const { surface: i, centre, radius } of patches) {
        const { normal, offset, kind } = surfaces[i];
        if (kind === quadratura.geometry.SKIRT) continue;
        const away = distance(eye, centre) - radius;
        if (away < least) least = Math.min(least, Math.max(away, Math.abs(dot(normal, eye) - offset)));
      }
      const aside = Math.hypot(Math.max(cx, width - cx) / fx, Math.max(cy, height - cy) / fy, 1);
      return Math.max(0.9 * least / aside, 1e-4 * Math.max(this.site.extent, 1e-3));
    }

    // Draws a view on the canvas: eye, rotation, fx, fy, cx, cy, width, height in pixels, the rule of exposure and whether there is
    // anything around; with so many times as many pixels along both sides, which are reduced. Returns how long it took, in
    // milliseconds.
    draw(asked, finer, now) {
      const gl = this.gl;
      if (gl.isContextLost()) return 0;
      const began = performance.now();
      this.drawOnTarget(asked, finer, now);
      this.target.show();
      // A pixel that is read waits for the device.
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, this.pixel);
      return performance.now() - began;
    }

    drawOnTarget(asked, wanted, now) {
      const gl = this.gl, finer = this.target.fit([asked.width, asked.height], [wanted, Math.min(1, wanted), 0.5 * Math.min(1, wanted)]);
      const scaled = Object.fromEntries(["fx", "fy", "cx", "cy"].map((name) => [name, asked[name] * finer]));
      const view = { ...asked, ...scaled, width: this.target.width, height: this.target.height };
      this.turnImpostors(view);
      const isNew = this.lists.update(view.eye);
      const around = this.lists.addAround(view.eye);
      if (isNew) this.tables.writePatches(this.lists);
      this.tables.writeLists(this.lists);
      this.tables.writeSurfaces(view.eye);
      const near = this.nearOf(view), nearer = near * (1 + TOLERANCE);
      this.exposure = quadratura.exposure.of(view, this.site, view.exposure, this.meter.of(view, this, { near, nearer, around, now }));
      this.tables.writePhotos(view.eye, this.exposure, this.textures, now);
      this.target.begin();
      this.bindTextures();
      const set = (which, plane) => this.use(which, view, plane, around);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LEQUAL);
      gl.disable(gl.BLEND);
      gl.bindVertexArray(this.corners);
      set(this.depths, near);
      gl.colorMask(false, false, false, false);
      gl.drawArrays(gl.TRIANGLES, 0, this.opaqueCorners);
      gl.colorMask(true, true, true, true);
      gl.depthMask(false);
      set(this.opaque, nearer);
      gl.drawArrays(gl.TRIANGLES, 0, this.opaqueCorners);
      if (view.around !== false) {
        set(this.behind, near);
        gl.bindVertexArray(this.target.empty);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
      }
      gl.bindVertexArray(this.corners);
      set(this.through, near);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      this.drawLayered(view);
      gl.disable(gl.BLEND);
      gl.depthMask(true);
    }

    drawLayered(view) {
      const gl = this.gl, { SKIRT } = quadratura.geometry, forward = row(view.rotation, 2);
      const all = this.layered.map((part) => ({ ...part, far: distance(part.centre, view.eye) }));
      const isBefore = (part) => dot(sub(part.centre, view.eye), forward) + part.far > 0;
      const draw = (parts) => parts.sort((a, b) => b.far - a.far).forEach(({ first, count }) => gl.drawArrays(gl.TRIANGLES, first, count));
      gl.uniform1i(this.through.uniforms.at_infinity, 1);
      if (view.around !== false) draw(all.filter((part) => part.kind === SKIRT && isBefore(part)));
      gl.uniform1i(this.through.uniforms.at_infinity, 0);
      draw(all.filter((part) => part.kind !== SKIRT && isBefore(part)));
    }

    bindTextures() {
      const gl = this.gl, { textures: t, tables } = this, array = gl.TEXTURE_2D_ARRAY, flat = gl.TEXTURE_2D;
      this.units = { photos: [flat, tables.photos], servers: [flat, tables.servers], candidates: [flat, tables.candidates], patches: [flat, tables.patches],
        surfaces: [flat, tables.surfaces], labels: [array, t.labels], trusts: [array, t.trusts], coarse_known: [array, t.coarse], near_photos: [array, t.near], far_photos: [array, t.far],
        hidden_pages: [array, t.hidden], hidden_trusts: [array, t.hiddenTrusts], cut_pages: [array, t.cut], cut_mattes: [array, t.cutMattes],
        heights: [flat, this.heights], continued_colors: [flat, this.continued], dome: [gl.TEXTURE_CUBE_MAP, this.dome], sky_factors: [flat, this.sky] };
    }

    use({ made, uniforms: u }, view, near, around) {
      const gl = this.gl;
      gl.useProgram(made);
      let unit = 0;
      for (const [name, [kind, texture]] of Object.entries(this.units)) {
        if (!u[name]) continue;
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(kind, texture);
        gl.uniform1i(u[name], unit++);
      }
      const [right, down, forward] = [0, 1, 2].map((i) => row(view.rotation, i));
      const high = view.eye.map(Math.fround), low = sub(view.eye, high);
      gl.uniform3fv(u.right, right);
      gl.uniform3fv(u.down, down);
      gl.uniform3fv(u.forward, forward);
      gl.uniform4f(u.lens, view.fx, view.fy, view.cx, view.cy);
      gl.uniform2f(u.view_size, view.width, view.height);
      gl.uniform3fv(u.eye_high, high);
      gl.uniform3fv(u.eye_low, low);
      gl.uniform1f(u.near, near);
      gl.uniform1f(u.finer, view.finer || 1);
      gl.uniform1i(u.at_infinity, 0);
      gl.uniform3fv(u.falloff, this.exposure.falloff);
      gl.uniform1f(u.lambda, this.site.blend.lambda);
      gl.uniform3fv(u.of_common, this.exposure.ofCommon);
      gl.uniform3fv(u.of_sky, this.exposure.ofSky);
      gl.uniform4f(u.around_list, ...around, 1 / Math.max(this.site.surroundings_scale, 1e-30), view.around === false ? 0 : 1);
      gl.uniform1f(u.dome_white, this.domeWhite || 0);
    }
  }

  return { Painter };
})();
