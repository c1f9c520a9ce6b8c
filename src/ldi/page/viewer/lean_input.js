// Pointers, keys and the tilt of a device, by which one leans.
quadratura.leanInput = (() => {
  "use strict";
  const { byId } = quadratura;
  const STEP = 0.15;

  function listenToPointers(viewer, canvas) {
    const fingers = new Map();
    let apart = 0;
    const distance = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (fingers.size === 2) apart = distance();
      viewer.greeting = false;
    });
    canvas.addEventListener("pointermove", (event) => {
      const box = canvas.getBoundingClientRect(), last = fingers.get(event.pointerId), [x, y, z] = viewer.target;
      if (!last) {
        // A pointer that passes leans towards where it is.
        const at = [2 * (event.clientX - box.left) / box.width - 1, 2 * (event.clientY - box.top) / box.height - 1];
        if (event.pointerType !== "touch") viewer.goTo([...at, z]);
        return;
      }
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (fingers.size === 2) {
        const now = distance();
        viewer.goTo([x, y, z + 2 * (now - apart) / box.width]);
        apart = now;
      } else {
        // What is near follows the finger, so the viewpoint goes the other way.
        viewer.goTo([x - 3 * dx / box.width, y - 3 * dy / box.height, z]);
      }
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      viewer.goTo([viewer.target[0], viewer.target[1], viewer.target[2] - Math.sign(event.deltaY) * 0.1]);
    }, { passive: false });
  }

  function listenToKeys(viewer, reset) {
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const [x, y, z] = viewer.target;
      const leans = {
        ArrowLeft: [x - STEP, y, z], ArrowRight: [x + STEP, y, z], ArrowUp: [x, y - STEP, z], ArrowDown: [x, y + STEP, z],
        "+": [x, y, z + STEP], "=": [x, y, z + STEP], "-": [x, y, z - STEP],
      };
      const commands = { Home: reset, s: () => byId("stereo").click(), f: () => byId("full").click() };
      if (leans[event.key]) {
        viewer.goTo(leans[event.key]);
        viewer.tell();
      } else if (commands[event.key]) {
        commands[event.key]();
      } else {
        return;
      }
      event.preventDefault();
    });
  }

  // Devices that can be tilted; some ask before they tell, after a press of a button only. Returns what forgets how a device was held.
  function offerTilt(viewer, button) {
    let from = null;
    const tilted = ({ beta, gamma }) => {
      if (beta === null || gamma === null) return;
      from = from || [beta, gamma];
      const [y, x] = [(beta - from[0]) / 20, (gamma - from[1]) / 20], turned = ((screen.orientation && screen.orientation.angle) || 0) * Math.PI / 180;
      viewer.goTo([x * Math.cos(turned) + y * Math.sin(turned), y * Math.cos(turned) - x * Math.sin(turned), viewer.target[2]]);
    };
    const events = window.DeviceOrientationEvent;
    button.hidden = !events || !window.matchMedia("(pointer: coarse)").matches;
    button.onclick = async () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      if (on && events.requestPermission && await events.requestPermission().catch(() => "denied") !== "granted") {
        quadratura.say("The device does not allow the page to notice its tilt.");
        return;
      }
      from = null;
      button.setAttribute("aria-pressed", on);
      (on ? window.addEventListener : window.removeEventListener)("deviceorientation", tilted);
    };
    return () => { from = null; };
  }

  function listen(viewer, canvas) {
    const forgetTilt = offerTilt(viewer, byId("motion"));
    const reset = () => { forgetTilt(); viewer.goTo([0, 0, 0]); viewer.tell(); };
    listenToPointers(viewer, canvas);
    listenToKeys(viewer, reset);
    byId("reset").onclick = reset;
    byId("stereo").onclick = () => viewer.toggleStereo();
    quadratura.offerFullScreen(byId("full"), byId("figure"));
    quadratura.headset.offer(byId("vr"), viewer.painter.target, viewer);
    quadratura.survive(canvas);
    new ResizeObserver(() => { viewer.resize(); viewer.render(); }).observe(byId("stage"));
  }

  return { listen };
})();
