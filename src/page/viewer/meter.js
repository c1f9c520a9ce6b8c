// The exposure of a view from what it shows: the mean of the photos' exposures by their weights, read from a small picture of them.
quadratura.meter = (() => {
  "use strict";

  // The size of the picture: a single pixel at an edge changes the mean by an imperceptible thousandth.
  const [WIDTH, HEIGHT] = [36, 24];

  class Meter {
    constructor(gl, { photos }) {
      this.gl = gl;
      this.program = quadratura.target.program(gl, ["surface_vertex"], ["weights", "tables", "meter", "blend", "surface"], "#define SEE_THROUGH\n");
      // The picture has values from 0 to 1.
      this.range = 2 * Math.max(1e-6, ...photos.flatMap(({ gain }) => gain.map(Math.abs)));
      const none = photos.map(() => 0), factors = photos.map(({ gain }) => gain.map((value) => value / this.range + 0.5));
      this.exposure = { factors, left: none, skyShare: 0, falloff: [0, 0, 0], ofCommon: [1, 1, 1], ofSky: [1, 1, 1] };
      this.framebuffer = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
      for (const [point, format] of [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]]) {
        const buffer = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
        gl.renderbufferStorage(gl.RENDERBUFFER, format, WIDTH, HEIGHT);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, point, gl.RENDERBUFFER, buffer);
      }
      this.pixels = new Uint8Array(4 * WIDTH * HEIGHT);
    }

    // Reads the exposure of a view with the lists and textures of a painter; null where it does not go by what the view shows.
    of(view, painter, { near, nearer, around, now }) {
      if ((view.exposure || painter.site.exposure.rule) !== "near" || view.isEye) return null;
      const gl = this.gl, small = this.begin(view);
      painter.exposure = this.exposure;
      painter.tables.writePhotos(view.eye, this.exposure, painter.textures, now);
      painter.bindTextures();
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LEQUAL);
      gl.disable(gl.BLEND);
      gl.bindVertexArray(painter.corners);
      painter.use(painter.depths, small, near, around);
      gl.colorMask(false, false, false, false);
      gl.drawArrays(gl.TRIANGLES, 0, painter.opaqueCorners);
      gl.colorMask(true, true, true, true);
      painter.use(this.program, small, nearer, around);
      gl.drawArrays(gl.TRIANGLES, 0, painter.opaqueCorners);
      for (const { kind, first, count } of painter.layered) if (kind !== quadratura.geometry.SKIRT) gl.drawArrays(gl.TRIANGLES, first, count);
      return this.read();
    }

    // Begins the picture; returns the view in its size.
    begin(view) {
      const gl = this.gl, [x, y] = [WIDTH / view.width, HEIGHT / view.height];
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
      gl.viewport(0, 0, WIDTH, HEIGHT);
      gl.colorMask(true, true, true, true);
      gl.depthMask(true);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      return { ...view, fx: view.fx * x, fy: view.fy * y, cx: view.cx * x, cy: view.cy * y, width: WIDTH, height: HEIGHT, finer: 1 / (x * y) };
    }

    // Returns the logarithm of the view's exposure over the common one, which it has where it shows nothing of the model.
    read() {
      const gl = this.gl, sum = [0, 0, 0];
      gl.readPixels(0, 0, WIDTH, HEIGHT, gl.RGBA, gl.UNSIGNED_BYTE, this.pixels);
      let count = 0;
      for (let at = 0; at < this.pixels.length; at += 4) {
        if (this.pixels[at + 3] < 128) continue;
        count++;
        for (let c = 0; c < 3; c++) sum[c] += this.pixels[at + c];
      }
      return sum.map((value) => (count ? (value / (255 * count) - 0.5) * this.range : 0));
    }
  }

  return { Meter };
})();
