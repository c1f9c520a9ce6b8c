// Programs, and what is drawn on before it is shown.
quadratura.target = (() => {
  "use strict";

  // Compiles a program. `names` are shaders (quadratura.shaders) that follow each other.
  function program(gl, vertex, fragment, defines = "") {
    const made = gl.createProgram();
    const head = "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\nprecision highp sampler2DArray;\n" + defines;
    for (const [kind, names] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, head + names.map((name) => quadratura.shaders[name]).join("\n"));
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = gl.getAttachedShaders(made).map((shader) => gl.getShaderInfoLog(shader));
      throw new Error("the shaders do not link: " + gl.getProgramInfoLog(made) + logs.join(" "));
    }
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(made, i);
      uniforms[name] = gl.getUniformLocation(made, name);
    }
    return { made, uniforms };
  }

  // A picture with several samples a pixel, in linear light, since that is what an eye and a camera mix, and its mean.
  class Target {
    constructor(gl) {
      this.gl = gl;
      this.reducing = program(gl, ["whole"], ["reduce"]);
      this.empty = gl.createVertexArray();
    }

    // Takes a size, for a canvas of so many pixels: times the first of these factors for which the device has memory, which is returned.
    // Each pixel has several samples, or one where several of them become one.
    fit([width, height], factors, most = (factor) => (factor > 1 ? 0 : 4)) {
      const gl = this.gl, longest = Math.min(gl.getParameter(gl.MAX_RENDERBUFFER_SIZE), gl.getParameter(gl.MAX_TEXTURE_SIZE));
      for (const wanted of factors) {
        const factor = Math.min(wanted, longest / Math.max(width, height));
        const size = [width, height].map((side) => Math.max(1, Math.round(side * factor)));
        if (this.make(...size, Math.min(most(factor), gl.getParameter(gl.MAX_SAMPLES)))) return factor;
        this.free();
      }
      throw new Error("the graphics device has too little memory");
    }

    // Returns whether there is memory for this size. A lost device has as much as is asked for.
    make(width, height, samples) {
      const gl = this.gl;
      if (this.drawn && this.width === width && this.height === height && this.samples === samples) return true;
      this.free();
      while (gl.getError() !== gl.NO_ERROR && !gl.isContextLost());
      Object.assign(this, { width, height, samples });
      const buffer = (format) => {
        const made = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, made);
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
        return made;
      };
      this.buffers = [buffer(gl.SRGB8_ALPHA8), buffer(gl.DEPTH_COMPONENT24)];
      this.drawn = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, this.buffers[0]);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.buffers[1]);
      this.texture = gl.createTexture();
      this.read = gl.createFramebuffer();
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.SRGB8_ALPHA8, width, height);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.read);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
      const isWhole = (framebuffer) => {
        gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
        return gl.checkFramebufferStatus(gl.FRAMEBUFFER) === gl.FRAMEBUFFER_COMPLETE;
      };
      const fits = isWhole(this.drawn) && isWhole(this.read) && gl.getError() === gl.NO_ERROR;
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      return fits || gl.isContextLost();
    }

    free() {
      const gl = this.gl;
      if (!this.drawn) return;
      this.buffers.forEach((buffer) => gl.deleteRenderbuffer(buffer));
      [this.drawn, this.read].forEach((framebuffer) => gl.deleteFramebuffer(framebuffer));
      gl.deleteTexture(this.texture);
      this.drawn = null;
    }

    // Begins a picture before a ground in linear light.
    begin(ground = [0, 0, 0]) {
      const gl = this.gl;
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn);
      gl.viewport(0, 0, this.width, this.height);
      gl.colorMask(true, true, true, true);
      gl.depthMask(true);
      gl.clearColor(...ground, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    }

    // Shows the picture on the canvas, or in a part of another framebuffer that keeps values as they are given.
    show(framebuffer = null, [x, y, width, height] = [0, 0, this.gl.canvas.width, this.gl.canvas.height]) {
      const gl = this.gl;
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.drawn);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.read);
      gl.blitFramebuffer(0, 0, this.width, this.height, 0, 0, this.width, this.height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
      gl.invalidateFramebuffer(gl.READ_FRAMEBUFFER, [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT]);
      gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
      for (const option of [gl.DEPTH_TEST, gl.BLEND, gl.CULL_FACE, gl.SAMPLE_ALPHA_TO_COVERAGE]) gl.disable(option);
      gl.viewport(x, y, width, height);
      gl.useProgram(this.reducing.made);
      gl.uniform1i(this.reducing.uniforms.drawn, 0);
      gl.uniform1f(this.reducing.uniforms.finer, this.width / width);
      gl.uniform2f(this.reducing.uniforms.corner, x, y);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.bindVertexArray(this.empty);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  return { program, Target };
})();
