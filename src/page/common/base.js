// What all scripts of a page share: the name under which they find each other, elements, messages, and what every page does with its canvas.
window.quadratura = { shaders: {} };

(() => {
  "use strict";

  quadratura.byId = (id) => document.getElementById(id);
  quadratura.say = (text) => { quadratura.byId("status").textContent = text; };
  quadratura.setPressed = (id, on) => quadratura.byId(id).setAttribute("aria-pressed", on);

  // Whether people want nothing to move by itself.
  quadratura.reducedMotion = window.matchMedia("(prefers-reduced-motion: reduce)");

  // Returns the device of a canvas. What is drawn stays to be seen until the next picture, for pictures of the page.
  quadratura.deviceOf = (canvas) => {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance", preserveDrawingBuffer: true });
    if (!gl) throw new Error("WebGL 2 is not available");
    return gl;
  };

  // Hides a canvas whose device is lost, and opens the page again when there is one. `leave` is called in between.
  quadratura.survive = (canvas, leave = () => {}) => {
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      canvas.hidden = true;
      quadratura.byId("poster").hidden = false;
      quadratura.say("The graphics device was lost. The page comes back here as soon as it is there again.");
    });
    canvas.addEventListener("webglcontextrestored", () => { leave(); location.reload(); });
  };

  // Lets a button show an element on the full screen, where that is allowed.
  quadratura.offerFullScreen = (button, element) => {
    button.hidden = !document.fullscreenEnabled;
    const refused = () => quadratura.say("Full screen is not allowed here.");
    button.onclick = () => (document.fullscreenElement ? document.exitFullscreen() : element.requestFullscreen().catch(refused));
    document.addEventListener("fullscreenchange", () => quadratura.setPressed(button.id, Boolean(document.fullscreenElement)));
  };
})();
