// Vectors and cameras. Vectors are arrays of three numbers, in doubles; a rotation is the nine numbers of its rows, from world to camera
// (x right, y down, z forward).
quadratura.math = (() => {
  "use strict";

  const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const length = (a) => Math.sqrt(dot(a, a));
  const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const mix = (a, b, t) => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t];
  const unit = (a) => {
    const l = length(a);
    return l > 0 ? times(a, 1 / l) : [0, 0, 0];
  };
  const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
  const smooth = (t) => { const s = clamp(t, 0, 1); return s * s * (3 - 2 * s); };
  // A row of a rotation.
  const row = (rotation, i) => [rotation[3 * i], rotation[3 * i + 1], rotation[3 * i + 2]];
  const rotated = (rotation, v) => [dot(row(rotation, 0), v), dot(row(rotation, 1), v), dot(row(rotation, 2), v)];
  const rotatedBack = (rotation, v) => add(add(times(row(rotation, 0), v[0]), times(row(rotation, 1), v[1])), times(row(rotation, 2), v[2]));

  // Returns the horizontal axes of a site for which this direction is up: [ahead, left], and up.
  function frame(up) {
    const u = unit(up), side = Math.abs(u[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0];
    const ahead = unit(cross(cross(u, side), u));
    return { up: u, ahead, left: cross(u, ahead) };
  }

  // Returns the rotation that looks into the direction of a heading (radians from ahead to the left) and a tilt (upwards), turned about
  // the line of sight by a roll (clockwise).
  function rotationOf({ up, ahead, left }, { heading, tilt, roll }) {
    const level = add(times(ahead, Math.cos(heading)), times(left, Math.sin(heading)));
    const forward = add(times(level, Math.cos(tilt)), times(up, Math.sin(tilt)));
    const right = cross(level, up), down = cross(forward, right);
    const c = Math.cos(roll), s = Math.sin(roll);
    return [...add(times(right, c), times(down, s)), ...sub(times(down, c), times(right, s)), ...forward];
  }

  // The inverse.
  function anglesOf({ up, ahead, left }, rotation) {
    const forward = row(rotation, 2);
    const tilt = Math.asin(clamp(dot(forward, up), -1, 1));
    const heading = Math.atan2(dot(forward, left), dot(forward, ahead));
    const flat = rotationOf({ up, ahead, left }, { heading, tilt, roll: 0 });
    const right = row(rotation, 0);
    return { heading, tilt, roll: Math.atan2(dot(right, row(flat, 1)), dot(right, row(flat, 0))) };
  }

  return { add, sub, times, dot, cross, length, distance, mix, unit, clamp, smooth, row, rotated, rotatedBack, frame, rotationOf, anglesOf };
})();
