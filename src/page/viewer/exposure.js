// The exposure of a view: that of the photos that it shows (meter.js), or a blend of the photos' by nearness; so a photo's own camera has the photo's.
quadratura.exposure = (() => {
  "use strict";
  const { sub, distance, row, rotated, rotatedBack, smooth, length } = quadratura.math;

  // A photo counts by the third power of the inverse of its distance, in radians; the common exposure as one that is a radian away.
  const FADES_AT = 1, POWER = 3;
  // The distance, in scales of the surroundings, and the share of the longer side beyond a photo's frame, from which on a view has left it.
  const AWAY = 0.1, BEYOND = 0.1;
  // The share of a view from which on a photo's own exposure counts under any rule.
  const OWN_FROM = 0.9;
  // The standard deviations beyond which a meter sees nothing (projection::exposure::meter).
  const REACH = 3;

  // The distance of a photo from a view, in radians: its movement as seen at the distance `reach`, and its turn.
  function apart(view, photo, reach) {
    const step = distance(view.eye, photo.centre) / reach;
    const chord = length(sub(row(view.rotation, 2), row(photo.rotation, 2)));
    return Math.hypot(step, 2 * Math.asin(Math.min(1, chord / 2)));
  }

  // The shares of photos by nearness.
  function shares(view, photos, reach) {
    const distances = photos.map((photo) => apart(view, photo, reach));
    const nearest = Math.min(FADES_AT, ...distances);
    const weight = (d) => (d <= nearest ? 1 : (nearest / d) ** POWER);
    const weights = distances.map(weight), all = weight(FADES_AT) + weights.reduce((a, b) => a + b, 0);
    return weights.map((w) => w / all);
  }

  // How far a direction is beyond a photo's frame, as a share of its longer side.
  function beyond(photo, direction) {
    const p = rotated(photo.rotation, direction);
    if (p[2] <= 0) return 1;
    const x = photo.lens[0] * p[0] / p[2] + photo.lens[2], y = photo.lens[1] * p[1] / p[2] + photo.lens[3], [w, h] = photo.size;
    return Math.min(1, Math.max(0, x - w, -x, y - h, -y) / Math.max(w, h));
  }

  function left(view, photo, scale) {
    const away = distance(photo.centre, view.eye) / scale, { fx, fy, cx, cy, width, height } = view;
    const corners = [[0, 0], [width, 0], [0, height], [width, height]];
    const off = corners.map(([x, y]) => beyond(photo, rotatedBack(view.rotation, [(x - cx) / fx, (y - cy) / fy, 1])));
    return smooth(away / AWAY + Math.max(...off) / BEYOND);
  }

  // The falloff of the lenses of near photos, which the view keeps: by the squared tangent of the angle to the axis and by its square, and
  // the largest such tangent.
  function lensOf(near, photos) {
    const all = near.reduce((sum, share) => sum + share, 0);
    return photos.reduce((sum, { lens: [fx, fy, cx, cy], size: [w, h], optics: [, a, b] }, i) => {
      const widest = (Math.max(cx, w - cx) / fx) ** 2 + (Math.max(cy, h - cy) / fy) ** 2;
      return quadratura.math.add(sum, quadratura.math.times([a * fx * fy, b * (fx * fy) ** 2, widest], near[i] / all));
    }, [0, 0, 0]);
  }

  // Reads the points of the meter: position, area times normal, and the photos that see it with the light there.
  function readMeter(site, numbers) {
    const points = [];
    for (let at = 0; at < numbers.length;) {
      const [position, area] = [numbers.slice(at, at + 3), numbers.slice(at + 3, at + 6)], seen = [];
      let [light, count] = [0, numbers[at + 6]];
      for (at += 7; seen.length < count; at += 2) { seen.push(numbers[at]); light += numbers[at + 1] / count; }
      points.push({ position, area, seen, light });
    }
    if (site.exposure.meter) Object.assign(site.exposure.meter, { points });
  }

  // How much brighter than the photos near it, with these shares, a meter in the view would read the site; or than usual. Where
  // photos' exposures followed their meters, so does that of the view.
  function brighter(view, { meter }, near, thanUsual) {
    const all = near.reduce((a, b) => a + b, 0), mean = (values) => near.reduce((sum, share, i) => sum + share * values[i], 0) / all;
    const [right, down] = meter.support, lowest = Math.exp(-0.5 * REACH * REACH), usual = mean(meter.usual);
    let [light, weight] = [meter.least * Math.exp(usual), meter.least];
    for (const { position, area, seen, light: own } of meter.points) {
      const towards = sub(view.eye, position), [x, y, z] = rotated(view.rotation, towards).map((value) => -value);
      const squared = (x / (z * right)) ** 2 + (y / (z * down)) ** 2;
      if (z <= 0 || squared >= REACH * REACH) continue;
      const size = Math.min(Math.max(quadratura.math.dot(area, towards) / z ** 3, 0), right * down);
      const w = (Math.exp(-0.5 * squared) - lowest) * size * seen.reduce((sum, i) => sum + near[i] / all, 0);
      light += w * own;
      weight += w;
    }
    return Math.log(light / weight) - (thanUsual ? usual : mean(meter.readings));
  }

  // Returns, from the exposure that was read of the view or by nearness, the factors on photos, on light in the common exposure and on the sky, the falloff of the view, and how far it has left each photo.
  function of(view, site, rule = site.exposure.rule, metered = null) {
    const { photos } = site, scale = Math.max(site.surroundings_scale, 1e-300);
    const near = shares(view, photos, scale);
    const mean = (value, c) => near.reduce((sum, share, i) => sum + share * value(photos[i], c), 0);
    const all = { left: photos.map((photo) => left(view, photo, scale)), skyShare: 1, falloff: [0, 0, 0] };
    if (rule === "raw") return { ...all, isRaw: true, factors: photos.map(() => [1, 1, 1]), ofCommon: [1, 1, 1], ofSky: [1, 1, 1], skyShare: 0 };
    let own = metered || [0, 1, 2].map((c) => mean((photo) => photo.gain[c], c));
    const { meter } = site.exposure, follow = (than) => (meter ? meter.follows.map((follows) => -follows * than) : [0, 0, 0]);
    if (rule === "common" || rule === "metered") {
      const base = follow(rule === "metered" && meter ? brighter(view, site.exposure, near, true) : 0);
      own = base.map((by, c) => near.reduce((sum, share, i) => sum + smooth((share - OWN_FROM) / (1 - OWN_FROM)) * (photos[i].gain[c] - by), by));
    } else {
      own = quadratura.math.add(own, follow(meter ? brighter(view, site.exposure, near, false) : 0));
    }
    return {
      ...all,
      falloff: site.exposure.keeps_vignetting ? lensOf(near, photos) : all.falloff,
      factors: photos.map((photo) => own.map((gain, c) => Math.exp(gain - photo.gain[c]))),
      ofCommon: own.map(Math.exp),
      ofSky: [0, 1, 2].map((c) => Math.exp(-mean((photo) => (photo.sky ? photo.sky[c] : 0), c))),
    };
  }

  return { of, apart, readMeter };
})();
