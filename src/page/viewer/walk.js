// The visitor: where the eye is and where it looks, how it moves, and when pictures are drawn.
quadratura.FINEST = 2;

quadratura.walk = (() => {
  "use strict";
  const { add, sub, times, dot, mix, clamp, smooth, frame, rotationOf, anglesOf, distance, unit } = quadratura.math;

  // Frames that take longer than this are drawn with fewer pixels.
  const SLOW_MS = 24, LEAST_SCALE = 0.2;
  // A picture with more pixels is drawn where it takes no longer than this.
  const LONGEST_MS = 1500;
  // A picture is drawn finely when nothing has moved for this time.
  const REST_MS = 250;
  // A step that is climbed, in heights of the eye.
  const STEP = 0.3;

  class Walker {
    constructor(painter, site, ground, canvas) {
      Object.assign(this, { painter, site, ground, canvas });
      this.axes = frame(site.up);
      this.keys = new Set();
      Object.assign(this, { scale: 0.5, cost: 0 });
      this.free = !site.safe;
      this.eyeHeight = site.safe ? site.safe.eye : this.usualHeight();
      this.set(site.start);
      this.listeners = [];
    }

    usualHeight() {
      const over = this.site.photos.map((photo) => this.ground.over(photo.centre, this.axes.up)).filter((height) => height !== null).sort((a, b) => a - b);
      return over.length ? over[over.length >> 1] : Math.max(this.site.extent / 10, 1e-3);
    }

    // Takes a described view.
    set({ centre, rotation, tangent }) {
      Object.assign(this, { eye: [...centre], tangent }, anglesOf(this.axes, rotation));
      this.flight = null;
    }

    rotation() { return rotationOf(this.axes, this); }

    // Returns the view of the canvas, or of one with another size.
    view(width = this.canvas.width, height = this.canvas.height) {
      // A narrow window shows more above and below rather than too little beside.
      const tangent = this.tangent * clamp(0.8 * height / width, 1, 1.5);
      const f = height / 2 / tangent;
      return { eye: this.eye, rotation: this.rotation(), fx: f, fy: f, cx: width / 2, cy: height / 2, width, height };
    }

    // Goes to a described view, in so many milliseconds; with reduced motion at once.
    goTo(target, ms = 600) {
      const to = { eye: [...target.centre], tangent: target.tangent, ...anglesOf(this.axes, target.rotation) };
      to.heading = this.heading + Math.atan2(Math.sin(to.heading - this.heading), Math.cos(to.heading - this.heading));
      if (quadratura.reducedMotion.matches || quadratura.instant) ms = 0;
      const { eye, heading, tilt, roll, tangent } = this;
      this.flight = { from: { eye, heading, tilt, roll, tangent }, to, ms, began: performance.now() };
      this.ask();
    }

    turn(heading, tilt) {
      this.flight = null;
      this.heading += heading;
      this.tilt = clamp(this.tilt + tilt, -1.5, 1.5);
      this.ask();
    }

    // Moves by a vector, as far as one may go, and climbs steps on the way.
    move(by) {
      this.flight = null;
      const step = this.free ? by : times(by, this.room(by));
      const to = add(this.eye, step), { up } = this.axes;
      const before = this.ground.over(this.eye, up), after = this.ground.over(to, up);
      const flat = dot(unit(by), up);
      let lifted = to;
      if (before !== null && after !== null && Math.abs(flat) < 0.5 && Math.abs(before - after) < STEP * this.eyeHeight) lifted = add(to, times(up, before - after));
      this.eye = lifted;
      this.ask();
    }

    // Returns whether a place is in the safe region.
    isSafe(place) {
      const { axes: [a, b], corner, cell, size, heights } = this.site.safe;
      const [x, y] = [(dot(place, a) - corner[0]) / cell, (dot(place, b) - corner[1]) / cell].map(Math.floor);
      const range = x >= 0 && y >= 0 && x < size[0] && y < size[1] && heights[y * size[0] + x];
      if (!range) return false;
      const height = dot(place, this.axes.up), slack = this.eyeHeight / 2;
      return height >= range[0] - slack && height <= range[1] + slack;
    }

    // Returns how much of a step may be taken: all within the region, less and less towards its border. Outside of it one may go back.
    room(by) {
      const long = Math.hypot(...by);
      if (long === 0 || !this.isSafe(this.eye)) return 1;
      const ahead = Math.max(long, this.site.safe.cell / 2), tries = 8;
      for (let i = 1; i <= tries; i++) if (!this.isSafe(add(this.eye, times(by, ahead / long * i / tries)))) return smooth((i - 1) / tries);
      return 1;
    }

    // --- Frames -----------------------------------------------------------------------------------------------------

    ask() {
      if (this.waiting || quadratura.inHeadset) return;
      this.waiting = true;
      requestAnimationFrame((now) => { this.waiting = false; this.frame(performance.now()); });
      this.moved = performance.now();
    }

    advance(now) {
      const seconds = Math.min(0.1, (now - (this.last || now)) / 1000);
      this.last = now;
      if (this.flight) {
        const { from, to, ms, began } = this.flight, t = ms > 0 ? smooth((now - began) / ms) : 1;
        this.eye = mix(from.eye, to.eye, t);
        for (const name of ["heading", "tilt", "roll"]) this[name] = from[name] + (to[name] - from[name]) * t;
        this.tangent = Math.exp(Math.log(from.tangent) + (Math.log(to.tangent) - Math.log(from.tangent)) * t);
        if (t >= 1) this.flight = null;
        return true;
      }
      if (!this.keys.size) return false;
      const has = (...names) => (names.some((name) => this.keys.has(name)) ? 1 : 0), pace = 1.1 * this.eyeHeight * seconds * (has("Shift") ? 3 : 1);
      const [right, , forward] = [0, 1, 2].map((i) => this.rotation().slice(3 * i, 3 * i + 3)), { up } = this.axes;
      const level = unit(sub(forward, times(up, dot(forward, up))));
      const by = add(add(times(level, has("w") - has("s")), times(right, has("d") - has("a"))), times(up, has("e") - has("q")));
      if (Math.hypot(...by) > 0) this.move(times(by, pace));
      const turn = 1.2 * seconds * this.tangent / 0.55;
      if (has("ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown")) this.turn(turn * (has("ArrowLeft") - has("ArrowRight")), turn * (has("ArrowUp") - has("ArrowDown")));
      return true;
    }

    frame(now) {
      this.resize();
      const moves = this.advance(now) || (this.tour && this.tour.advance(now));
      const view = this.view(), photos = this.site.photos;
      this.painter.textures.want((i) => quadratura.exposure.apart(view, photos[i], Math.max(this.site.extent, 1e-6)));
      const isReady = this.painter.textures.isComplete() && !this.painter.textures.isFading(now), scale = moves || !isReady ? this.scale : 1;
      this.adapt(this.painter.draw(view, scale, now), scale);
      document.documentElement.dataset.state = "walking";
      this.listeners.forEach((told) => told(view, moves));
      if (moves || this.painter.textures.isFading(now)) this.ask();
      else this.rest();
    }

    // When nothing moves, the picture is drawn with more pixels.
    rest() {
      clearTimeout(this.resting);
      this.resting = setTimeout(() => {
        if (this.waiting || this.keys.size || this.flight) return;
        const view = this.view(), finest = quadratura.FINEST, often = finest * finest;
        if (view.width * view.height < 3e6 && this.cost * often < LONGEST_MS) this.painter.draw(view, finest, performance.now());
        this.last = 0;
        document.documentElement.dataset.state = "drawn";
        if (this.rested) this.rested();
      }, REST_MS);
    }

    // Draws with fewer pixels while pictures are slow. `took` is the time of one, drawn at a scale.
    adapt(took, scale) {
      this.cost = took / (scale * scale);
      const fits = Math.sqrt(SLOW_MS / Math.max(this.cost, 0.1));
      this.scale = clamp(fits < this.scale ? Math.max(fits, 0.6 * this.scale) : Math.min(fits, 1.1 * this.scale), LEAST_SCALE, 1);
    }

    resize() {
      const box = this.canvas.getBoundingClientRect(), ratio = Math.min(2, devicePixelRatio || 1);
      const [width, height] = [box.width, box.height].map((side) => Math.max(1, Math.round(side * ratio)));
      if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    }

    // Returns where the ray through a point of the window goes.
    ray(x, y) {
      const box = this.canvas.getBoundingClientRect(), view = this.view();
      const px = [(x - box.left) / box.width * view.width, (y - box.top) / box.height * view.height];
      return quadratura.math.rotatedBack(view.rotation, [(px[0] - view.cx) / view.fx, (px[1] - view.cy) / view.fy, 1]);
    }

    // Goes to a place on the ground that was pointed at; a surface that is no ground is looked at from in front if asked for.
    goWhere(x, y, faces) {
      const hit = this.ground.hit(this.eye, this.ray(x, y));
      if (!hit) return;
      const { up } = this.axes, side = dot(hit.surface.normal, sub(this.eye, hit.point)) < 0 ? -1 : 1, normal = times(hit.surface.normal, side);
      const rotation = this.rotation();
      if (dot(normal, up) > 0.7) {
        const centre = add(hit.point, times(up, this.eyeHeight));
        if (this.free || this.isSafe(centre)) this.goTo({ centre, rotation, tangent: this.tangent }, 800);
        else quadratura.say("No photo shows enough from there. Choose \"Show everything\" to go all the same.");
      } else if (faces) {
        const away = clamp(distance(this.eye, hit.point), 2 * this.eyeHeight, 8 * this.eyeHeight);
        const centre = add(hit.point, times(normal, away)), { ahead, left } = this.axes, towards = times(normal, -1);
        const heading = Math.atan2(dot(towards, left), dot(towards, ahead)), tilt = Math.asin(clamp(dot(towards, up), -1, 1));
        if (this.free || this.isSafe(centre)) this.goTo({ centre, rotation: rotationOf(this.axes, { heading, tilt, roll: 0 }), tangent: this.tangent }, 800);
      }
    }
  }

  return { Walker };
})();
