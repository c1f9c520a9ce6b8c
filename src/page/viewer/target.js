// Programs, what is drawn on before it is shown, and the levels of textures.
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

  // Makes levels of array textures one by one.
  class Reducer {
    constructor(gl) {
      this.gl = gl;
      this.halving = program(gl, ["whole"], ["halve"]);
      this.framebuffer = gl.createFramebuffer();
      this.empty = gl.createVertexArray();
    }

    halve(texture, layer, level) {
      const gl = this.gl, size = texture.size.map((side) => Math.max(1, side >> level));
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
      gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, texture, level, layer);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_BASE_LEVEL, level - 1);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAX_LEVEL, level - 1);
      for (const option of [gl.DEPTH_TEST, gl.BLEND, gl.CULL_FACE, gl.SAMPLE_ALPHA_TO_COVERAGE]) gl.disable(option);
      gl.colorMask(true, true, true, true);
      gl.viewport(0, 0, ...size);
      gl.useProgram(this.halving.made);
      gl.uniform1i(this.halving.uniforms.finer, 0);
      gl.uniform1f(this.halving.uniforms.layer, layer);
      gl.uniform2f(this.halving.uniforms.size, ...size);
      gl.bindVertexArray(this.empty);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_BASE_LEVEL, 0);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAX_LEVEL, texture.levels - 1);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }
  }

  // A picture with several samples a pixel, in linear light, since that is what an eye and a camera mix, and its mean.
  class Target {
    constructor(gl) {
      this.gl = gl;
      this.reducing = program(gl, ["whole"], ["reduce"]);
      this.empty = gl.createVertexArray();
    }

    // Takes a size. A picture that is finer than the canvas has one sample a pixel: several of its pixels become one.
    resize(width, height, finer) {
      const gl = this.gl;
      if (this.width === width && this.height === height && this.finer === finer) return;
      this.free();
      Object.assign(this, { width, height, finer });
      const samples = finer > 1 ? 0 : Math.min(4, gl.getParameter(gl.MAX_SAMPLES));
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
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    }

    free() {
      const gl = this.gl;
      if (!this.drawn) return;
      this.buffers.forEach((buffer) => gl.deleteRenderbuffer(buffer));
      [this.drawn, this.read].forEach((framebuffer) => gl.deleteFramebuffer(framebuffer));
      gl.deleteTexture(this.texture);
    }

    // Begins a picture.
    begin() {
      const gl = this.gl;
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn);
      gl.viewport(0, 0, this.width, this.height);
      gl.colorMask(true, true, true, true);
      gl.depthMask(true);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    }

    // Shows the picture on the canvas.
    show() {
      const gl = this.gl, { width, height } = gl.canvas;
      gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.drawn);
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.read);
      gl.blitFramebuffer(0, 0, this.width, this.height, 0, 0, this.width, this.height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
      gl.invalidateFramebuffer(gl.READ_FRAMEBUFFER, [gl.COLOR_ATTACHMENT0, gl.DEPTH_ATTACHMENT]);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      for (const option of [gl.DEPTH_TEST, gl.BLEND]) gl.disable(option);
      gl.viewport(0, 0, width, height);
      gl.useProgram(this.reducing.made);
      gl.uniform1i(this.reducing.uniforms.drawn, 0);
      gl.uniform1f(this.reducing.uniforms.finer, this.width / width);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.bindVertexArray(this.empty);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  return { program, Reducer, Target };
})();
