// The meshes of a layered depth image, and the device's copies of meshes and pictures.
quadratura.segments = (() => {
  "use strict";

  // Whole numbers of seven bits a byte, the lowest first; signed ones alternate: 0, -1, 1, -2, 2.
  function reader(bytes) {
    let at = 0;
    const number = () => {
      let value = 0, factor = 1, byte;
      do {
        if (at === bytes.length) throw new Error("the meshes end too early");
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
  function read(bytes, pieces, atlases) {
    const { number, signed, float } = reader(bytes);
    const parts = Array.from({ length: atlases }, () => ({ corners: [], triangles: [] }));
    let low = 0, step = 0, nearest = 0;
    for (let piece = 0; piece < pieces; piece++) {
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

  // Puts a mesh on the device.
  function buffersOf(gl, { corners, triangles }) {
    const array = gl.createVertexArray(), each = 5 * 4;
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, each, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 2, gl.FLOAT, false, each, 12);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(triangles), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { array, count: triangles.length };
  }

  // Puts a picture on the device.
  function textureOf(gl, picture, kept, given) {
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
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

  return { read, buffersOf, textureOf };
})();
