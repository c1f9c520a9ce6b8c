// Texts at places: numbered buttons over the picture, hidden where something is before the place, and a panel that shows one.
quadratura.texts = (() => {
  "use strict";
  const { sub, rotated, length, rotationOf, dot } = quadratura.math;
  const { byId } = quadratura;
  let walker, site, markers = [];

  function open(i) {
    const { title, text, link, view, language } = site.texts[i];
    if (view !== null) walker.goTo(site.viewpoints[view]);
    else {
      // Without a viewpoint one turns to the place.
      const { up, ahead, left } = walker.axes, to = sub(site.texts[i].at, walker.eye), far = length(to);
      const heading = Math.atan2(dot(to, left), dot(to, ahead)), tilt = Math.asin(dot(to, up) / far);
      walker.goTo({ centre: walker.eye, rotation: rotationOf(walker.axes, { heading, tilt, roll: 0 }), tangent: walker.tangent });
    }
    byId("text").lang = language || "";
    byId("text-title").textContent = title;
    byId("text-body").textContent = text;
    const more = byId("text-link");
    more.hidden = !link;
    if (link) [more.href, more.textContent] = [link, link];
    byId("text").hidden = false;
    byId("text").focus();
    history.pushState(null, "", "#text=" + (i + 1));
  }

  // Puts the buttons where their places are in the view.
  function place(view, moves) {
    const box = walker.canvas.getBoundingClientRect();
    site.texts.forEach(({ at }, i) => {
      const p = rotated(view.rotation, sub(at, view.eye));
      const x = view.fx * p[0] / p[2] + view.cx, y = view.fy * p[1] / p[2] + view.cy;
      const marker = markers[i], isInside = p[2] > 0 && x > 0 && y > 0 && x < view.width && y < view.height;
      if (isInside) {
        marker.style.left = x / view.width * box.width + "px";
        marker.style.top = y / view.height * box.height + "px";
      }
      // A ray takes long where there are many patches; while one moves, what was hidden stays so.
      if (!moves || !isInside) {
        const hit = isInside && walker.ground.hit(view.eye, sub(at, view.eye));
        marker.hidden = !isInside || Boolean(hit && hit.t < 0.98);
      }
    });
  }

  function start(visitor, described) {
    [walker, site] = [visitor, described];
    site.texts.forEach(({ title }, i) => {
      const marker = document.createElement("button"), item = document.createElement("li"), listed = document.createElement("button");
      marker.type = listed.type = "button";
      marker.className = "marker";
      marker.textContent = i + 1;
      marker.setAttribute("aria-label", i + 1 + ": " + title);
      listed.textContent = i + 1 + ". " + title;
      marker.onclick = listed.onclick = () => open(i);
      byId("stage").append(marker);
      item.append(listed);
      byId("texts").append(item);
      markers.push(marker);
    });
    byId("texts").hidden = byId("texts-title").hidden = !site.texts.length;
    byId("text-close").onclick = () => { byId("text").hidden = true; walker.canvas.focus(); };
    if (site.texts.length) walker.listeners.push(place);
  }

  return { open, start };
})();
