// The visitor with a headset: the head moves from where the walker stands, and a hand that points at the ground goes there.
quadratura.walkInHeadset = (() => {
  "use strict";
  const { add, sub, times, dot, cross } = quadratura.math;
  // The height of a visitor's eyes in metres, which is the walker's height of the eye in the site.
  const EYES_M = 1.6;

  class Visitor {
    constructor(walker, left) { Object.assign(this, { walker, left, head: [0, 0, 0] }); }

    // Returns a direction of the headset (right, up, back) in the site. Ahead is where the walker looked.
    directed(vector) {
      const { axes: { up, ahead, left }, heading } = this.walker;
      const level = add(times(ahead, Math.cos(heading)), times(left, Math.sin(heading)));
      return add(add(times(cross(level, up), vector[0]), times(up, vector[1])), times(level, -vector[2]));
    }

    // Returns a place of the headset, in metres, in the site.
    placed(vector) {
      return add(this.walker.eye, times(this.directed(vector), this.walker.eyeHeight / EYES_M));
    }

    drawEye({ lens, place }) {
      const { painter, site } = this.walker, column = (i) => [place[4 * i], place[4 * i + 1], place[4 * i + 2]];
      this.head = column(3);
      const rotation = [this.directed(column(0)), times(this.directed(column(1)), -1), times(this.directed(column(2)), -1)].flat();
      // Both eyes have one exposure: that by nearness.
      const view = { ...lens, eye: this.placed(this.head), rotation, isEye: true };
      painter.textures.want((i) => quadratura.exposure.apart(view, site.photos[i], Math.max(site.extent, 1e-6)));
      painter.drawOnTarget(view, 1, performance.now());
    }

    // Goes to the ground at which a hand points, the head above it.
    point(place) {
      const { walker } = this, { up } = walker.axes;
      const hit = walker.ground.hit(this.placed([place[12], place[13], place[14]]), this.directed([-place[8], -place[9], -place[10]]));
      if (!hit || Math.abs(dot(hit.surface.normal, up)) < 0.7) return;
      const centre = add(hit.point, times(up, walker.eyeHeight));
      const head = sub(this.placed([this.head[0], 0, this.head[2]]), walker.eye);
      if (walker.free || walker.isSafe(centre)) walker.eye = sub(centre, head);
    }
  }

  return { Visitor };
})();
