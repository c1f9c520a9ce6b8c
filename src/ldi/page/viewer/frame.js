// Matrices, by columns, that take (x, y, 1, inverse depth) of the photo's frame to the clip space.
quadratura.frame = (() => {
  "use strict";

  // Returns a matrix from its rows of x, y and w; z is 1 - 2 q / nearest of w, q the inverse depth that is seen.
  function matrix(nearest, x, y, w) {
    const z = w.map((value) => value * 0.999999);
    z[3] -= 2 / nearest;
    return [0, 1, 2, 3].flatMap((column) => [x, y, z, w].map((row) => row[column]));
  }

  // Returns the matrix of the window from a viewpoint, for a picture of this size.
  function ofWindow({ camera, seen, pivot }, nearest, [ox, oy, oz], [width, height], zoom) {
    const scale = zoom * width / seen.width, fx = camera.fx * scale, fy = camera.fy * scale;
    const cx = (camera.cx - seen.x - seen.width / 2) * scale + width / 2 + fx * ox / pivot;
    const cy = (camera.cy - seen.y - seen.height / 2) * scale + height / 2 + fy * oy / pivot;
    // The rows of K2 (K1^-1 | -offset).
    const w = [0, 0, 1, -oz];
    const u = [fx / camera.fx, 0, cx - fx * camera.cx / camera.fx, -fx * ox - cx * oz];
    const v = [0, fy / camera.fy, cy - fy * camera.cy / camera.fy, -fy * oy - cy * oz];
    return matrix(nearest, w.map((row, i) => 2 * u[i] / width - row), w.map((row, i) => row - 2 * v[i] / height), w);
  }

  // Returns the matrix of an eye of a headset: its projection and view, by columns, and metres per world unit.
  function ofEye({ camera }, nearest, projection, view, metres) {
    const row = (m, i) => [m[i], m[4 + i], m[8 + i], m[12 + i]];
    const times = (p) => [0, 1, 2, 3].map((j) => p.reduce((sum, value, k) => sum + value * view[4 * j + k], 0));
    // From the frame: K1^-1, then axes to the right, up and back.
    const toFrame = ([x, y, z, one]) => {
      const [X, Y, Z] = [x * metres, -y * metres, -z * metres];
      return [X / camera.fx, Y / camera.fy, Z - X * camera.cx / camera.fx - Y * camera.cy / camera.fy, one];
    };
    const [x, y, w] = [0, 1, 3].map((i) => toFrame(times(row(projection, i))));
    return matrix(nearest, x, y, w);
  }

  return { ofWindow, ofEye };
})();
