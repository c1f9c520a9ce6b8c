// Shows the photo once its data are there; without them the poster stays.
//
// For tests, the address may end in #at=X,Y,Z&size=WxH&zoom=N: the viewpoint's offset from the photo's camera (right, down, ahead, in
// world units), the size of the picture in device pixels, and the magnification (1 shows the frame to its sides). Then nothing moves,
// nothing else is shown, and data-state of the root element becomes "drawn".
(() => {
  "use strict";
  const { byId } = quadratura;

  function exactView() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (!asked.has("at")) return null;
    const numbers = (text, parter) => text.split(parter).map(Number);
    const size = asked.has("size") ? numbers(asked.get("size"), "x") : [innerWidth, innerHeight];
    return { at: numbers(asked.get("at"), ","), size, zoom: Number(asked.get("zoom") || 1) };
  }

  async function open() {
    const canvas = byId("view"), painter = new quadratura.painter.Painter(canvas), exact = exactView();
    const chunk = await quadratura.load("photo"), photo = JSON.parse(new TextDecoder().decode(chunk.photo));
    if (photo.version !== 2) throw new Error("the data are of another version than the viewer");
    await painter.load(photo, chunk);
    const viewer = new quadratura.lean.Viewer(photo, canvas, painter, exact);
    canvas.hidden = false;
    if (exact) document.documentElement.classList.add("exact");
    else byId("tools").hidden = false;
    viewer.resize();
    viewer.render();
    if (painter.gl.isContextLost()) throw new Error("the graphics device was lost");
    byId("poster").hidden = true;
    if (exact) return;
    quadratura.leanInput.listen(viewer, canvas);
    viewer.ask();
  }

  open().catch((error) => {
    byId("view").hidden = byId("tools").hidden = true;
    byId("help").textContent = "This picture has depth, but cannot be shown with it here: " + error.message + ". You see the photo.";
    document.documentElement.dataset.state = "failed";
  });
})();
