// The levels of array textures, made one by one.
quadratura.levels = (() => {
  "use strict";
  const { program } = quadratura.target;

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

  return { Reducer };
})();
