// Draws the segments of a layered depth image with one depth buffer. The corners of triangles are homogeneous: column and row in
// the photo's frame, 1, and inverse depth.
window.QuadraturaPainter = (() => {
  "use strict";

  // --- Data ---------------------------------------------------------------------------------------------------------

  function bytesOf(base64) {
    const text = atob(base64);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return bytes;
  }

  // Whole numbers of seven bits a byte, the lowest first; signed ones alternate: 0, -1, 1, -2, 2.
  function reader(bytes) {
    let at = 0;
    const number = () => {
      let value = 0, factor = 1, byte;
      do {
        byte = bytes[at++];
        value += (byte & 127) * factor;
        factor *= 128;
      } while (byte > 127);
      return value;
    };
    const signed = () => {
      const value = number();
      return value % 2 ? -(value + 1) / 2 : value / 2;
    };
    const bits = new DataView(new ArrayBuffer(4));
    const float = () => {
      bits.setUint32(0, number());
      return bits.getFloat32(0);
    };
    return { number, signed, float };
  }

  // Returns corners (x, y, inverse depth, column and row in the atlas) and triangles by atlas, and the largest inverse depth.
  function geometryOf(photo) {
    const { number, signed, float } = reader(bytesOf(photo.geometry));
    const parts = photo.atlases.map(() => ({ corners: [], triangles: [] }));
    let low = 0, step = 0, nearest = 0;
    for (let piece = 0; piece < photo.pieces; piece++) {
      if (number()) { low = float(); step = float(); }
      const part = parts[number()];
      const [dx, dy] = [signed(), signed()];
      const first = part.corners.length / 5;
      let x = 0, y = 0, depth = 0, corner = 0;
      for (let count = number(); count > 0; count--) {
        x += signed(); y += signed(); depth += signed();
        const inverse = Math.fround(low + depth * step);
        nearest = Math.max(nearest, inverse);
        part.corners.push(x, y, inverse, x + dx, y + dy);
      }
      for (let count = 3 * number(); count > 0; count--) {
        corner += signed();
        part.triangles.push(first + corner);
      }
    }
    return { parts, nearest };
  }

  // Returns the same, or says in words for people that data.js is not what was exported.
  function readGeometry(photo) {
    try {
      return geometryOf(photo);
    } catch {
      throw new Error("data.js is damaged (copy the folder again, or export it again)");
    }
  }

  function pictureOf(source) {
    return new Promise((resolve, reject) => {
      const picture = new Image();
      picture.onload = () => resolve(picture);
      picture.onerror = () => reject(new Error("a picture in data.js cannot be decoded"));
      picture.src = source;
    });
  }

  // --- Drawing ------------------------------------------------------------------------------------------------------

  const VERTICAL = 5 * 4;
  // The most places at which colours are looked up in a picture, unless it has more pixels than that.
  const MOST_PLACES = 5e6;

  class Painter {
    constructor(canvas, photo) {
      const options = { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" };
      this.gl = canvas.getContext("webgl2", options);
      if (!this.gl) throw new Error("WebGL 2 is not available");
      this.photo = photo;
      this.program = this.compiled("vertex", "fragment");
      this.reducing = this.compiled("whole", "reduce");
    }

    compiled(vertex, fragment) {
      const gl = this.gl, program = gl.createProgram();
      for (const [kind, id] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, document.getElementById(id).textContent.trim());
        gl.compileShader(shader);
        gl.attachShader(program, shader);
      }
      gl.bindAttribLocation(program, 0, "corner");
      gl.bindAttribLocation(program, 1, "texel");
      gl.linkProgram(program);
      if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
        throw new Error("the shaders do not link: " + gl.getProgramInfoLog(program));
      }
      return program;
    }

    async load() {
      const gl = this.gl, { parts, nearest } = readGeometry(this.photo);
      // What is more than four times nearer than everything was is before the near plane.
      this.nearest = 4 * nearest || 1;
      const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
      this.parts = [];
      for (const [i, atlas] of this.photo.atlases.entries()) {
        if (Math.max(atlas.width, atlas.height) > most) throw new Error("the pictures are too large for this device");
        const [colours, rims] = await Promise.all([pictureOf(atlas.colours), pictureOf(atlas.rims)]);
        this.parts.push({
          ...this.buffers(parts[i]),
          size: [atlas.width, atlas.height],
          colours: this.texture(colours, gl.SRGB8_ALPHA8, gl.RGBA),
          rims: this.texture(rims, gl.RG8, gl.RG),
        });
      }
      if (this.photo.backdrop) await this.loadBackdrop();
    }

    // Behind everything is the photo, out of focus, so that what nobody knows is no black hole.
    async loadBackdrop() {
      const gl = this.gl, { seen: { x: left, y: top, width, height }, pivot, backdrop } = this.photo;
      const corner = (x, y) => [left + x, top + y, 1 / pivot, x, y];
      const corners = [...corner(-width, -height), ...corner(2 * width, -height),
        ...corner(2 * width, 2 * height), ...corner(-width, 2 * height)];
      const white = new ImageData(new Uint8ClampedArray([255, 255, 255, 255]), 1, 1);
      this.backdrop = {
        ...this.buffers({ corners, triangles: [0, 1, 2, 0, 2, 3] }),
        size: [width, height],
        colours: this.texture(await pictureOf(backdrop), gl.SRGB8_ALPHA8, gl.RGBA),
        rims: this.texture(white, gl.RG8, gl.RG),
      };
    }

    buffers({ corners, triangles }) {
      const gl = this.gl, array = gl.createVertexArray();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.STATIC_DRAW);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, VERTICAL, 0);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 2, gl.FLOAT, false, VERTICAL, 12);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(triangles), gl.STATIC_DRAW);
      gl.bindVertexArray(null);
      return { array, count: triangles.length };
    }

    texture(picture, kept, given) {
      const gl = this.gl, texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texImage2D(gl.TEXTURE_2D, 0, kept, given, gl.UNSIGNED_BYTE, picture);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
      // Beyond half size, texels of the border would mix with those of other pieces.
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAX_LEVEL, 1);
      gl.generateMipmap(gl.TEXTURE_2D);
      return texture;
    }

    // --- The target --------------------------------------------------------------------------------------------------

    // Makes what is drawn on before it is reduced to the canvas: several samples a pixel, in linear light, since that is what an
    // eye and a camera mix. Returns null where the device has no memory for it.
    makeTarget([width, height]) {
      const gl = this.gl, old = this.target;
      if (old && old.width === width && old.height === height) return old;
      if (old) this.freeTarget(old);
      while (gl.getError() !== gl.NO_ERROR && !gl.isContextLost());
      const samples = Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
      const buffer = (format) => {
        const made = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, made);
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
        return made;
      };
      const [colours, depths] = [buffer(gl.SRGB8_ALPHA8), buffer(gl.DEPTH_COMPONENT24)];
      const drawn = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, drawn);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colours);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depths);
      const texture = gl.createTexture(), read = gl.createFramebuffer();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.SRGB8_ALPHA8, width, height);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
      gl.bindFramebuffer(gl.FRAMEBUFFER, read);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
      this.target = { width, height, colours, depths, drawn, texture, read };
      const isWhole = (framebuffer) => {
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        return gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
      };
      const fits = gl.getError() === gl.NO_ERROR && isWhole(drawn) && isWhole(read);
      if (!fits && !gl.isContextLost()) this.freeTarget(this.target);
      return this.target;
    }

    freeTarget({ colours, depths, drawn, texture, read }) {
      const gl = this.gl;
      for (const buffer of [colours, depths]) gl.deleteRenderbuffer(buffer);
      for (const framebuffer of [drawn, read]) gl.deleteFramebuffer(framebuffer);
      gl.deleteTexture(texture);
      this.target = null;
    }

    // Draws a picture of the canvas's size. Several samples are taken of each of its pixels along either axis; `draw` is told the
    // size that it draws in.
    show(draw) {
      const gl = this.gl, { width, height } = gl.canvas;
      const finest = Math.max(1, Math.min(2, Math.sqrt(MOST_PLACES / (width * height))));
      const most = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
      const sizeOf = (fineness) => {
        const factor = Math.min(fineness, most / Math.max(width, height));
        return [width, height].map((side) => Math.max(1, Math.round(side * factor)));
      };
      // What does not fit into the device's memory is drawn with fewer places.
      const target = [finest, 1, 0.5].reduce((made, fineness) => made || this.makeTarget(sizeOf(fineness)), null);
      if (!target) throw new Error("the graphics device has too little memory");
      const size = [target.width, target.height];
      gl.bindFramebuffer(gl.FRAMEBUFFER, target.drawn);
      gl.viewport(0, 0, ...size);
      this.begin(false);
      draw(size);
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, target.drawn);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, target.read);
      gl.blitFramebuffer(0, 0, ...size, 0, 0, ...size, gl.COLOR_BUFFER_BIT, gl.NEAREST);
      gl.invalidateFramebuffer(gl.READ_FRAMEBUFFER, [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT]);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      this.reduce(target);
    }

    reduce(target) {
      const gl = this.gl, { width, height } = gl.canvas;
      // The middles of four parts of a pixel, where it has four; its own middle, where it has one.
      const apart = [target.width / width, target.height / height].map((fineness) => 0.25 * Math.max(0, fineness - 1));
      for (const option of [gl.DEPTH_TEST, gl.CULL_FACE, gl.SAMPLE_ALPHA_TO_COVERAGE]) gl.disable(option);
      gl.viewport(0, 0, width, height);
      gl.useProgram(this.reducing);
      gl.uniform1i(gl.getUniformLocation(this.reducing, "drawn"), 0);
      gl.uniform2f(gl.getUniformLocation(this.reducing, "apart"), apart[0] / width, apart[1] / height);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, target.texture);
      gl.bindVertexArray(null);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    // --- Segments ----------------------------------------------------------------------------------------------------

    // Empties the framebuffer that is bound. `encodes` is true where that keeps values as they are given.
    begin(encodes) {
      const gl = this.gl;
      gl.clearColor(...(encodes ? [0.0627, 0.0627, 0.0667] : [0.0052, 0.0052, 0.0056]), 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.depthFunc(gl.LESS);
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      // Sides that the photo's camera does not see stay out, as in `ldi render`.
      gl.enable(gl.CULL_FACE);
      gl.frontFace(gl.CW);
      gl.useProgram(this.program);
      gl.uniform1i(gl.getUniformLocation(this.program, "encodes"), encodes);
      gl.uniform1i(gl.getUniformLocation(this.program, "colours"), 0);
      gl.uniform1i(gl.getUniformLocation(this.program, "rims"), 1);
    }

    // Draws with a matrix, by columns, that takes (x, y, 1, inverse depth) to the clip space.
    draw(matrix, withBackdrop) {
      const gl = this.gl;
      gl.uniformMatrix4fv(gl.getUniformLocation(this.program, "clip_from_frame"), false, matrix);
      if (withBackdrop && this.backdrop) {
        gl.disable(gl.DEPTH_TEST);
        this.drawParts([this.backdrop]);
        gl.enable(gl.DEPTH_TEST);
      }
      this.drawParts(this.parts);
    }

    drawParts(parts) {
      const gl = this.gl;
      for (const part of parts) {
        gl.uniform2fv(gl.getUniformLocation(this.program, "texture_size"), part.size);
        gl.activeTexture(gl.TEXTURE0);
        gl.bindTexture(gl.TEXTURE_2D, part.colours);
        gl.activeTexture(gl.TEXTURE1);
        gl.bindTexture(gl.TEXTURE_2D, part.rims);
        gl.bindVertexArray(part.array);
        gl.drawElements(gl.TRIANGLES, part.count, gl.UNSIGNED_INT, 0);
      }
    }

    // Returns a matrix by columns from its rows of x, y and w; z is 1 - 2 q / nearest of w, q the inverse depth that is seen.
    matrix(x, y, w) {
      const z = w.map((value) => value * 0.999999);
      z[3] -= 2 / this.nearest;
      return [0, 1, 2, 3].flatMap((column) => [x, y, z, w].map((row) => row[column]));
    }

    // Returns the matrix of the window from a viewpoint, for a picture of this size.
    windowMatrix([ox, oy, oz], [width, height], zoom) {
      const { camera, seen, pivot } = this.photo;
      const scale = zoom * width / seen.width, fx = camera.fx * scale, fy = camera.fy * scale;
      const cx = (camera.cx - seen.x - seen.width / 2) * scale + width / 2 + fx * ox / pivot;
      const cy = (camera.cy - seen.y - seen.height / 2) * scale + height / 2 + fy * oy / pivot;
      // The rows of K2 (K1^-1 | -offset).
      const w = [0, 0, 1, -oz];
      const u = [fx / camera.fx, 0, cx - fx * camera.cx / camera.fx, -fx * ox - cx * oz];
      const v = [0, fy / camera.fy, cy - fy * camera.cy / camera.fy, -fy * oy - cy * oz];
      return this.matrix(w.map((row, i) => 2 * u[i] / width - row), w.map((row, i) => row - 2 * v[i] / height), w);
    }

    // Returns the matrix of an eye of a headset: its projection and view, by columns, and metres per world unit.
    eyeMatrix(projection, view, metres) {
      const { camera } = this.photo;
      const row = (m, i) => [m[i], m[4 + i], m[8 + i], m[12 + i]];
      const times = (p) => [0, 1, 2, 3].map((j) => p.reduce((sum, value, k) => sum + value * view[4 * j + k], 0));
      // From the frame: K1^-1, then axes to the right, up and back.
      const toFrame = ([x, y, z, one]) => {
        const [X, Y, Z] = [x * metres, -y * metres, -z * metres];
        return [X / camera.fx, Y / camera.fy, Z - X * camera.cx / camera.fx - Y * camera.cy / camera.fy, one];
      };
      const [x, y, w] = [0, 1, 3].map((i) => toFrame(times(row(projection, i))));
      return this.matrix(x, y, w);
    }
  }

  return Painter;
})();
