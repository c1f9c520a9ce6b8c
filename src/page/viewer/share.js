// Addresses of views: to a millimetre and a hundredth of a degree.
quadratura.share = (() => {
  "use strict";
  const DEGREES = 180 / Math.PI;
  const short = (value, digits) => String(Number(value.toFixed(digits)));

  // Returns the part of an address after # for where a visitor is.
  function of({ eye, heading, tilt, roll, tangent }) {
    const turned = [heading, tilt, roll].map((angle) => short(Math.atan2(Math.sin(angle), Math.cos(angle)) * DEGREES, 2));
    return "#v=1&p=" + eye.map((value) => short(value, 3)).join() + "&q=" + turned.join() + "&f=" + short(tangent, 4);
  }

  // Returns what an address asks for: {photo}, {view}, {text}, or a place; null for nothing, and {unknown} for what this viewer does not know.
  function read(hash) {
    if (hash.length < 2) return null;
    const asked = new URLSearchParams(hash.slice(1));
    for (const name of ["photo", "view", "text"]) if (asked.has(name)) return { [name]: Number(asked.get(name)) };
    const numbers = (name, count) => {
      const found = (asked.get(name) || "").split(",").map(Number);
      return found.length === count && found.every(Number.isFinite) ? found : null;
    };
    const eye = numbers("p", 3), turned = numbers("q", 3), lens = numbers("f", 1);
    if (asked.get("v") !== "1" || !eye || !turned || !lens || !(lens[0] > 0.01 && lens[0] < 10)) return { unknown: true };
    const [heading, tilt, roll] = turned.map((angle) => angle / DEGREES);
    return { eye, heading, tilt, roll, tangent: lens[0] };
  }

  return { of, read };
})();
