// Mouse, touch and keys on the canvas.
quadratura.input = (() => {
  "use strict";
  const { times, clamp } = quadratura.math;
  const MOVING = ["w", "a", "s", "d", "q", "e", "ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Shift"];
  // A pointer that moves less, in pixels, was pressed in one place.
  const STILL = 6;

  function listen(walker, canvas) {
    const fingers = new Map();
    let pressed = null;

    const apart = () => {
      const [a, b] = [...fingers.values()];
      return { distance: Math.hypot(a.x - b.x, a.y - b.y), x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
    };
    const radians = () => 2 * walker.tangent / canvas.getBoundingClientRect().height;

    canvas.addEventListener("pointerdown", (event) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      pressed = fingers.size === 1 ? { x: event.clientX, y: event.clientY } : null;
    });

    canvas.addEventListener("pointermove", (event) => {
      const last = fingers.get(event.pointerId);
      if (!last) return;
      const before = fingers.size === 2 ? apart() : null;
      const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      if (pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > STILL) pressed = null;
      if (before) {
        const now = apart(), forward = walker.rotation().slice(6), right = walker.rotation().slice(0, 3), pace = 0.02 * walker.eyeHeight;
        walker.move(times(forward, (now.distance - before.distance) * pace));
        walker.move(times(right, (before.x - now.x) * pace));
      } else if (!pressed) {
        // What is seen follows the finger.
        walker.turn(dx * radians(), dy * radians());
      }
    });

    const end = (event) => {
      fingers.delete(event.pointerId);
      if (pressed && event.type === "pointerup") walker.goWhere(pressed.x, pressed.y, false);
      pressed = null;
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("dblclick", (event) => walker.goWhere(event.clientX, event.clientY, true));

    canvas.addEventListener("wheel", (event) => {
      // In a page around this one the wheel scrolls that page until the picture has the focus.
      if (window.parent !== window && document.activeElement !== canvas) return;
      event.preventDefault();
      const by = clamp(-event.deltaY * (event.deltaMode === 1 ? 30 : 1), -200, 200) / 100;
      walker.move(times(walker.ray(event.clientX, event.clientY), 0.35 * by * walker.eyeHeight));
    }, { passive: false });

    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
      if (!MOVING.includes(key)) return;
      if (walker.tour) walker.tour.stop();
      walker.keys.add(key);
      walker.last = walker.last || performance.now();
      walker.ask();
      if (key !== "Shift") event.preventDefault();
    });
    canvas.addEventListener("keyup", (event) => walker.keys.delete(event.key.length === 1 ? event.key.toLowerCase() : event.key));
    canvas.addEventListener("blur", () => walker.keys.clear());
  }

  return { listen };
})();
