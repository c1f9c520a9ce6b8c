// A photo with depth, seen through its frame as through a window, and where the eye may go.
quadratura.lean = (() => {
  "use strict";
  const { byId } = quadratura;

  // Returns how far one may go in a direction across the axis.
  function limitAcross(across, angle) {
    const turn = ((angle / (2 * Math.PI)) % 1 + 1) % 1 * across.length;
    const i = Math.floor(turn) % across.length, t = turn - Math.floor(turn);
    const a = across[i], b = across[(i + 1) % across.length], middle = Math.min(a, b);
    return t < 0.5 ? a + (middle - a) * 2 * t : middle + (b - middle) * (2 * t - 1);
  }

  // Comes to 1 ever more slowly.
  function soft(length) {
    return length < 0.7 ? length : 0.7 + 0.3 * Math.tanh((length - 0.7) / 0.3);
  }

  // Returns the offset for a lean: (x, y) in shares of the limit, which is less by a margin, z from -1 to 1.
  function offsetOf(lean, safe, margin) {
    const length = Math.hypot(lean[0], lean[1]);
    const z = Math.sign(lean[2]) * soft(Math.abs(lean[2]));
    const across = limitAcross(safe.across, Math.atan2(lean[1], lean[0]));
    const limit = Math.max(0, across * (1 - Math.abs(z)) - margin);
    const share = length > 0 ? soft(length) * limit / length : 0;
    return [lean[0] * share, lean[1] * share, z * (z < 0 ? safe.along[0] : safe.along[1])];
  }

  class Viewer {
    // `exact` is a view that is asked for exactly, for tests, after which nothing moves; null for visitors.
    constructor(photo, canvas, painter, exact) {
      Object.assign(this, { photo, canvas, painter, exact, stereo: false, waiting: false });
      this.target = [0, 0, 0];
      this.lean = [0, 0, 0];
      this.greeting = !quadratura.reducedMotion.matches;
      this.began = this.last = performance.now();
    }

    eyes() {
      if (!this.stereo) return [0];
      const { pivot, safe } = this.photo;
      // A thirtieth of the distance, as photographers do it, and no farther than the safe region allows.
      const half = Math.min(pivot / 60, 0.7 * Math.min(safe.across[0], safe.across[safe.across.length / 2]));
      return [-half, half];
    }

    resize() {
      const { width, height } = this.photo.seen, views = this.stereo ? 2 : 1;
      if (this.exact) {
        [this.canvas.width, this.canvas.height] = this.exact.size;
        this.canvas.style.width = this.exact.size[0] / devicePixelRatio + "px";
        this.canvas.style.height = this.exact.size[1] / devicePixelRatio + "px";
        return;
      }
      const stage = byId("stage").getBoundingClientRect(), aspect = views * width / height;
      const shown = Math.max(1, Math.min(stage.width, stage.height * aspect));
      this.canvas.style.width = shown + "px";
      this.canvas.style.height = shown / aspect + "px";
      // Small pictures are drawn larger and reduced by the browser, since textures have two sizes only.
      const pixels = Math.round(Math.min(4096, Math.max(shown * devicePixelRatio, 0.4 * width * views)));
      this.canvas.width = pixels;
      this.canvas.height = Math.max(1, Math.round(pixels / aspect));
    }

    ask() {
      if (this.waiting || quadratura.inHeadset) return;
      this.waiting = true;
      requestAnimationFrame((now) => {
        this.waiting = false;
        this.move(now);
        this.render();
      });
    }

    move(now) {
      const seconds = Math.min(0.1, (now - this.last) / 1000), since = (now - this.began) / 1000;
      this.last = now;
      if (this.greeting) {
        const size = 0.45 * Math.sin(Math.PI * Math.min(1, since / 9));
        this.target = [size * Math.sin(since * 1.4), 0.5 * size * Math.sin(since * 0.9), 0];
        if (since >= 9) this.greeting = false;
      }
      const share = quadratura.reducedMotion.matches ? 1 : 1 - Math.exp(-7 * seconds);
      this.lean = this.lean.map((value, i) => value + (this.target[i] - value) * share);
      const rest = Math.max(...this.lean.map((value, i) => Math.abs(value - this.target[i])));
      if (this.greeting || rest > 1e-4) this.ask();
    }

    render() {
      const { painter, photo } = this;
      if (painter.gl.isContextLost()) return;
      const zoom = this.exact ? this.exact.zoom : photo.zoom, eyes = this.eyes();
      const offset = this.exact ? this.exact.at : offsetOf(this.lean, photo.safe, Math.abs(eyes[0]));
      painter.show(([width, height]) => {
        const each = width / eyes.length;
        eyes.forEach((eye, i) => {
          const matrix = quadratura.frame.ofWindow(photo, painter.nearest, [offset[0] + eye, offset[1], offset[2]], [each, height], zoom);
          painter.draw(matrix, [Math.round(i * each), 0, Math.round(each), height], true);
        });
      });
      document.documentElement.dataset.state = "drawn";
    }

    // Draws an eye of a headset. The middle of the picture is four metres away.
    drawEye({ lens: { width, height }, projection, worldToEye }) {
      const size = this.painter.begin([width, height], [1, 0.5]);
      const matrix = quadratura.frame.ofEye(this.photo, this.painter.nearest, projection, worldToEye, 4 / this.photo.pivot);
      this.painter.draw(matrix, [0, 0, ...size], false);
    }

    left() { this.ask(); }

    // Goes to a lean by hand, which ends the first movement.
    goTo(lean) {
      this.greeting = false;
      this.target = lean.map((value) => Math.max(-1.6, Math.min(1.6, value)));
      this.last = performance.now();
      this.ask();
    }

    // Says where the eye is.
    tell() {
      const [x, y, z] = this.target.map((value) => Math.round(100 * soft(Math.abs(value))) * Math.sign(value));
      const words = [];
      if (x) words.push(Math.abs(x) + " % to the " + (x < 0 ? "left" : "right"));
      if (y) words.push(Math.abs(y) + " % " + (y < 0 ? "up" : "down"));
      if (z) words.push(Math.abs(z) + " % " + (z < 0 ? "back" : "nearer"));
      quadratura.say(words.length ? "Viewpoint: " + words.join(", ") : "Viewpoint: the camera's");
    }

    toggleStereo() {
      this.stereo = !this.stereo;
      quadratura.setPressed("stereo", this.stereo);
      quadratura.say(this.stereo ? "Two pictures side by side, left eye on the left." : "One picture.");
      this.resize();
      this.render();
    }
  }

  return { Viewer };
})();
