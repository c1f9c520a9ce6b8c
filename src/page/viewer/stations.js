// Where one can go at once: viewpoints, photos and texts; the tour; buttons and keys of the page.
(() => {
  "use strict";
  const { rotationOf, distance } = quadratura.math;
  const { byId, setPressed } = quadratura;

  // The view of a photo: all of it, as its camera saw it.
  function viewOf(photo, canvas) {
    const [fx, fy] = photo.lens, [width, height] = photo.size;
    return { centre: photo.centre, rotation: photo.rotation, tangent: Math.max(height / 2 / fy, width / 2 / fx * canvas.height / Math.max(1, canvas.width)) };
  }

  class Tour {
    constructor(walker, { times, views }) { Object.assign(this, { walker, times, views }); }
    toggle() {
      if (this.began !== undefined) return this.stop();
      this.began = performance.now();
      quadratura.say("The tour plays. Space stops it.");
      this.walker.ask();
    }
    stop() {
      if (this.began === undefined) return;
      this.began = undefined;
      quadratura.say("The tour has stopped.");
    }
    // Returns whether the tour plays, and takes the visitor along.
    advance(now) {
      if (this.began === undefined) return false;
      const seconds = (now - this.began) / 1000, next = this.times.findIndex((time) => time > seconds);
      if (next < 0) { this.walker.set(this.views[this.views.length - 1]); this.stop(); return false; }
      const at = Math.max(1, next), t = (seconds - this.times[at - 1]) / (this.times[at] - this.times[at - 1]);
      const [a, b] = [this.views[at - 1], this.views[at]].map((view) => ({ ...view, ...quadratura.math.anglesOf(this.walker.axes, view.rotation) }));
      const turned = a.heading + Math.atan2(Math.sin(b.heading - a.heading), Math.cos(b.heading - a.heading)) * t;
      Object.assign(this.walker, { eye: quadratura.math.mix(a.centre, b.centre, t), heading: turned, tilt: a.tilt + (b.tilt - a.tilt) * t,
        roll: a.roll + (b.roll - a.roll) * t, tangent: a.tangent + (b.tangent - a.tangent) * t });
      return true;
    }
  }

  quadratura.visit = (painter, site, geometry) => {
    const canvas = byId("view"), ground = new quadratura.ground.Ground(geometry);
    canvas.hidden = false;
    byId("stage").classList.add("open");
    const walker = quadratura.walker = new quadratura.walk.Walker(painter, site, ground, canvas);
    walker.tour = site.tour && new Tour(walker, site.tour);
    let current = 0;

    const remember = (hash, jump) => history[jump ? "pushState" : "replaceState"](null, "", hash);
    const station = (view, hash, text) => { if (walker.tour) walker.tour.stop(); walker.goTo(view); remember(hash, true); quadratura.say(text); };
    const goToPhoto = (i) => {
      current = (i + site.photos.length) % site.photos.length;
      station(viewOf(site.photos[current], canvas), "#photo=" + (current + 1), "Photo " + (current + 1) + " of " + site.photos.length);
    };
    const goToView = (i) => station(site.viewpoints[i], "#view=" + (i + 1), site.viewpoints[i].name);

    // Goes to what the address asks for; returns whether it asks for something that there is.
    function follow(hash) {
      const asked = quadratura.share.read(hash);
      if (!asked) return false;
      if (site.photos[asked.photo - 1]) walker.goTo(viewOf(site.photos[asked.photo - 1], canvas));
      else if (site.viewpoints[asked.view - 1]) walker.goTo(site.viewpoints[asked.view - 1]);
      else if (site.texts[asked.text - 1]) quadratura.texts.open(asked.text - 1);
      else if (asked.eye) walker.goTo({ centre: asked.eye, rotation: rotationOf(walker.axes, asked), tangent: asked.tangent });
      else { quadratura.say("This address names no place here that is known. You are at the start."); return false; }
      return true;
    }

    const button = (list, label, act, picture) => {
      const item = document.createElement("li"), made = document.createElement("button");
      made.type = "button";
      if (picture) made.append(picture);
      made.append(label);
      made.onclick = act;
      item.append(made);
      byId(list).append(item);
      byId(list).hidden = byId(list + "-title").hidden = false;
    };
    site.viewpoints.forEach((view, i) => button("viewpoints", view.name, () => goToView(i)));
    site.photos.forEach((photo, i) => button("photos", (/^p\d+$/.test(photo.name) ? "Photo " + (i + 1) : photo.name), () => goToPhoto(i), painter.textures.frameOf(i)));

    quadratura.input.listen(walker, canvas);
    if (quadratura.texts) quadratura.texts.start(walker, site);
    new ResizeObserver(() => walker.ask()).observe(byId("stage"));
    window.addEventListener("popstate", () => follow(location.hash) || walker.goTo(site.start));
    walker.rested = () => { if (location.hash.startsWith("#v=")) remember(quadratura.share.of(walker), false); };

    quadratura.survive(canvas, () => remember(quadratura.share.of(walker), false));
    byId("places-button").onclick = () => {
      const open = byId("places").hidden;
      byId("places").hidden = !open;
      byId("places-button").setAttribute("aria-expanded", open);
    };
    byId("share").onclick = () => {
      remember(quadratura.share.of(walker), false);
      const done = () => quadratura.say("The address of this view is copied.");
      navigator.clipboard ? navigator.clipboard.writeText(location.href).then(done, () => quadratura.say("The address of this view: " + location.href)) : quadratura.say("The address of this view: " + location.href);
    };
    byId("everything").hidden = !site.safe;
    byId("everything").onclick = () => { walker.free = !walker.free; setPressed("everything", walker.free); };
    byId("play").hidden = !site.tour;
    byId("play").onclick = () => walker.tour.toggle();
    quadratura.offerFullScreen(byId("full"), document.documentElement);
    quadratura.headset.offer(byId("vr"), painter.target, new quadratura.walkInHeadset.Visitor(walker, () => walker.ask()));

    // Says where one is: people who do not see the picture are told on request.
    const where = () => {
      const nearest = site.photos.reduce((best, photo, i) => (distance(photo.centre, walker.eye) < distance(site.photos[best].centre, walker.eye) ? i : best), 0);
      const away = distance(site.photos[nearest].centre, walker.eye);
      const turn = Math.round((((walker.heading - quadratura.math.anglesOf(walker.axes, site.start.rotation).heading) * 180 / Math.PI) % 360 + 540) % 360 - 180);
      const side = turn === 0 ? "as at the start" : Math.abs(turn) + " degrees to the " + (turn > 0 ? "left" : "right") + " of the start";
      quadratura.say((away < 0.01 * site.extent ? "At" : away.toFixed(1) + " units from") + " photo " + (nearest + 1) + ", looking " + side + ".");
    };
    const commands = { "[": () => goToPhoto(current - 1), "]": () => goToPhoto(current + 1), p: where, f: () => byId("full").click(),
      " ": () => walker.tour && walker.tour.toggle(), Home: () => walker.goTo(site.start), Escape: () => canvas.blur() };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|TEXTAREA)$/.test(event.target.tagName)) return;
      if (event.key === " " && event.target.tagName === "BUTTON") return;
      const command = commands[event.key];
      if (!command) return;
      command();
      event.preventDefault();
    });
    byId("tools").hidden = false;
    quadratura.say("");
    if (!follow(location.hash)) walker.ask();
  };
})();
