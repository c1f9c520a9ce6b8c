// Opens the page: what is needed for the first picture, then everything else.
(() => {
  "use strict";
  const { byId } = quadratura;

  // A view that is asked for exactly, for tests: JSON with centre, rotation, lens, size and more after #exact=.
  quadratura.exactView = ({ centre, rotation, lens: [fx, fy, cx, cy], size: [width, height], exposure, around }) =>
    ({ eye: centre, rotation, fx, fy, cx, cy, width, height, exposure, around });
  const exactView = () => (location.hash.startsWith("#exact=") ? quadratura.exactView(JSON.parse(decodeURIComponent(location.hash.slice(7)))) : null);

  // Draws exact views when all pictures are there; returns how long one took, in milliseconds.
  async function drawExactly(painter, first) {
    quadratura.instant = true;
    document.documentElement.classList.add("exact");
    const canvas = byId("view");
    canvas.hidden = false;
    const apart = (i) => quadratura.exposure.apart(first, quadratura.site.photos[i], quadratura.site.extent);
    await Promise.all([painter.textures.all, painter.textures.loadPages()]);
    painter.textures.want(apart);
    while (!painter.textures.isComplete()) await new Promise((resolve) => setTimeout(resolve, 20));
    quadratura.drawExactly = (view, finer) => {
      [canvas.width, canvas.height] = [view.width, view.height];
      [canvas.style.width, canvas.style.height] = [view.width / devicePixelRatio + "px", view.height / devicePixelRatio + "px"];
      return painter.draw(view, finer, performance.now());
    };
    quadratura.drawExactly(first, quadratura.FINEST);
    document.documentElement.dataset.state = "drawn";
  }

  // Where people save data, nothing is loaded before they ask for it.
  function asked() {
    if (!(navigator.connection && navigator.connection.saveData)) return Promise.resolve();
    byId("open").hidden = false;
    quadratura.say("");
    return new Promise((resolve) => { byId("open").onclick = () => { byId("open").hidden = true; quadratura.say("Loading"); resolve(); }; });
  }

  async function open() {
    await asked();
    const painter = new quadratura.painter.Painter(byId("view"), () => quadratura.walker && quadratura.walker.ask());
    const site = await quadratura.loadSite();
    const [parts, sheets] = await Promise.all([quadratura.load("geometry", () => -4), quadratura.load("sheets", () => -3)]);
    const geometry = quadratura.geometry.read(parts, sheets, site);
    painter.prepare(site, geometry, parts, sheets);
    await Promise.all([painter.textures.loadFar(), painter.loadDome().catch(() => quadratura.say("What is around could not be loaded."))]);
    const exact = exactView();
    if (exact) return drawExactly(painter, exact);
    quadratura.visit(painter, site, geometry);
    const lost = await Promise.all([painter.textures.all, painter.textures.loadPages()]);
    const { held } = painter.textures, count = site.photos.length;
    if (lost[0] || lost[1]) quadratura.say("Some pictures could not be loaded.");
    else if (held < count) quadratura.say("This device shows " + held + " of " + count + " photos.");
  }

  function fail(error) {
    quadratura.say("This place cannot be shown for walking here: " + error.message + ". You see pictures of it.");
    byId("open").hidden = true;
    document.documentElement.dataset.state = "failed";
    document.documentElement.dataset.reason = error.message;
  }

  open().catch(fail);
})();
