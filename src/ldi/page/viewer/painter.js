// Draws the segments of a layered depth image with one depth buffer. The corners of triangles are homogeneous: column and row in the
// photo's frame, 1, and inverse depth.
quadratura.painter = (() => {
  "use strict";
  const { buffersOf, textureOf } = quadratura.segments;
  const { program, Target } = quadratura.target;

  // The most places at which colours are looked up in a picture, unless it has more pixels than that.
  const MOST_PLACES = 5e6;
  const SAMPLES = 4;
  // What is behind the picture, in linear light.
  const GROUND = [0.0052, 0.0052, 0.0056];

  class Painter {
    constructor(canvas) {
      this.gl = quadratura.deviceOf(canvas);
      this.target = new Target(this.gl);
      this.segments = program(this.gl, ["vertex"], ["fragment"]);
    }

    async load(photo, chunk) {
      const gl = this.gl, { parts, nearest } = quadratura.segments.read(chunk.geometry, photo.pieces, photo.atlases.length);
      // What is more than four times nearer than everything was is before the near plane.
      this.nearest = 4 * nearest || 1;
      const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
      this.parts = [];
      for (const [i, { width, height }] of photo.atlases.entries()) {
        if (Math.max(width, height) > most) throw new Error("the pictures are too large for this device");
        const colours = await quadratura.pictureOf(chunk["colours-" + i], "image/jpeg"), rims = await quadratura.pictureOf(chunk["rims-" + i], "image/png");
        this.parts.push(this.part(parts[i], [width, height], colours, rims));
      }
      if (chunk.backdrop) this.backdrop = this.behind(photo, await quadratura.pictureOf(chunk.backdrop, "image/jpeg"));
    }

    part(mesh, size, colours, rims) {
      const gl = this.gl;
      return { ...buffersOf(gl, mesh), size, colours: textureOf(gl, colours, gl.SRGB8_ALPHA8, gl.RGBA), rims: textureOf(gl, rims, gl.RG8, gl.RG) };
    }

    // Behind everything is the photo, out of focus, so that what nobody knows is no black hole.
    behind({ seen: { x: left, y: top, width, height }, pivot }, picture) {
      const corner = (x, y) => [left + x, top + y, 1 / pivot, x, y];
      const corners = [...corner(-width, -height), ...corner(2 * width, -height), ...corner(2 * width, 2 * height), ...corner(-width, 2 * height)];
      const white = new ImageData(new Uint8ClampedArray([255, 255, 255, 255]), 1, 1);
      return this.part({ corners, triangles: [0, 1, 2, 0, 2, 3] }, [width, height], picture, white);
    }

    // Begins a picture of this size, with several samples a pixel. Returns the size that is drawn in.
    begin([width, height], factors) {
      const gl = this.gl;
      this.target.fit([width, height], factors, () => SAMPLES);
      this.target.begin(GROUND);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LESS);
      gl.disable(gl.BLEND);
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      // Sides that the photo's camera does not see stay out, as in `ldi render`.
      gl.enable(gl.CULL_FACE);
      gl.frontFace(gl.CW);
      gl.useProgram(this.segments.made);
      gl.uniform1i(this.segments.uniforms.colours, 0);
      gl.uniform1i(this.segments.uniforms.rims, 1);
      return [this.target.width, this.target.height];
    }

    // Draws a picture of the canvas's size. `draw` is told the size that it draws in.
    show(draw) {
      const { width, height } = this.gl.canvas;
      const finest = Math.max(1, Math.min(2, Math.sqrt(MOST_PLACES / (width * height))));
      draw(this.begin([width, height], [finest, 1, 0.5]));
      this.target.show();
    }

    // Draws with a matrix (see frame.js) in a part of the picture.
    draw(matrix, [x, y, width, height], withBackdrop) {
      const gl = this.gl;
      gl.viewport(x, y, width, height);
      gl.uniformMatrix4fv(this.segments.uniforms.clip_from_frame, false, matrix);
      if (withBackdrop && this.backdrop) {
        gl.disable(gl.DEPTH_TEST);
        this.drawParts([this.backdrop]);
        gl.enable(gl.DEPTH_TEST);
      }
      this.drawParts(this.parts);
    }

    drawParts(parts) {
      const gl = this.gl;
      for (const { size, colours, rims, array, count } of parts) {
        gl.uniform2fv(this.segments.uniforms.texture_size, size);
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, colours);
        gl.activeTexture(gl.TEXTURE1);
        gl.bindTexture(gl.TEXTURE_2D, rims);
        gl.bindVertexArray(array);
        gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
      }
    }
  }

  return { Painter };
})();
