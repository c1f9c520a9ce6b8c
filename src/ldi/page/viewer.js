// Shows a photo with depth: a layered depth image, seen through the photo's frame as through a window. Opens from disk: nothing is fetched, pictures come as data.
//
// For tests, the address may end in #at=X,Y,Z&size=WxH&zoom=N: the viewpoint's offset from the photo's camera (right, down,
// ahead, in world units), the size of the picture in device pixels, and the magnification (1 shows the frame to its sides). Then
// nothing moves, nothing else is shown, and data-state of the root element becomes "drawn".
window.QuadraturaViewer = (() => {
  "use strict";

  const Painter = window.QuadraturaPainter;

  // --- The safe region ----------------------------------------------------------------------------------------------

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

  // --- The viewer ---------------------------------------------------------------------------------------------------

  const REDUCED = window.matchMedia("(prefers-reduced-motion: reduce)");
  const byId = (id) => document.getElementById(id);

  class Viewer {
    constructor(photo, canvas, painter) {
      Object.assign(this, { photo, canvas, painter });
      this.target = [0, 0, 0];
      this.lean = [0, 0, 0];
      this.stereo = false;
      this.greeting = !REDUCED.matches;
      this.began = this.last = performance.now();
      this.waiting = false;
      this.exact = exactView();
    }

    start() {
      this.canvas.hidden = false;
      if (this.exact) {
        document.documentElement.classList.add("exact");
      } else {
        byId("tools").hidden = false;
        this.listen();
      }
      this.resize();
      this.render();
      if (this.painter.gl.isContextLost()) {
        this.canvas.hidden = true;
        byId("tools").hidden = true;
        throw new Error("the graphics device was lost");
      }
      byId("poster").hidden = true;
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
      if (this.waiting || this.session) return;
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
      const share = REDUCED.matches ? 1 : 1 - Math.exp(-7 * seconds);
      this.lean = this.lean.map((value, i) => value + (this.target[i] - value) * share);
      const rest = Math.max(...this.lean.map((value, i) => Math.abs(value - this.target[i])));
      if (this.greeting || rest > 1e-4) this.ask();
    }

    render() {
      if (this.painter.gl.isContextLost()) return;
      const zoom = this.exact ? this.exact.zoom : this.photo.zoom;
      const eyes = this.eyes();
      const offset = this.exact ? this.exact.at : offsetOf(this.lean, this.photo.safe, Math.abs(eyes[0]));
      this.painter.show(([width, height]) => {
        const size = [width / eyes.length, height];
        eyes.forEach((eye, i) => {
          this.painter.gl.viewport(Math.round(i * size[0]), 0, Math.round(size[0]), height);
          this.painter.draw(this.painter.windowMatrix([offset[0] + eye, offset[1], offset[2]], size, zoom), true);
        });
      });
      document.documentElement.dataset.state = "drawn";
    }

    // Goes to a lean by hand, which ends the first movement.
    goTo(lean) {
      this.greeting = false;
      const within = (value) => Math.max(-1.6, Math.min(1.6, value));
      this.target = lean.map(within);
      this.last = performance.now();
      this.ask();
    }

    tell() {
      const [x, y, z] = this.target.map((value) => Math.round(100 * soft(Math.abs(value))) * Math.sign(value));
      const words = [];
      if (x) words.push(Math.abs(x) + " % to the " + (x < 0 ? "left" : "right"));
      if (y) words.push(Math.abs(y) + " % " + (y < 0 ? "up" : "down"));
      if (z) words.push(Math.abs(z) + " % " + (z < 0 ? "back" : "nearer"));
      byId("status").textContent = words.length ? "Viewpoint: " + words.join(", ") : "Viewpoint: the camera's";
    }

    // --- Input ------------------------------------------------------------------------------------------------------

    listen() {
      new ResizeObserver(() => { this.resize(); this.render(); }).observe(byId("stage"));
      this.listenToPointers();
      document.addEventListener("keydown", (event) => this.key(event));
      this.canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        this.goTo([this.target[0], this.target[1], this.target[2] - Math.sign(event.deltaY) * 0.1]);
      }, { passive: false });
      byId("reset").onclick = () => this.reset();
      byId("stereo").onclick = () => this.toggleStereo();
      this.listenToFullScreen();
      this.offerTilt();
      this.offerVr();
      this.canvas.addEventListener("webglcontextlost", () => {
        byId("poster").hidden = false;
        this.canvas.hidden = true;
        byId("status").textContent = "The graphics device was lost. Reload the page to lean again.";
      });
      this.ask();
    }

    listenToPointers() {
      const canvas = this.canvas, fingers = new Map();
      let apart = 0;
      const distance = () => {
        const [a, b] = [...fingers.values()];
        return Math.hypot(a.x - b.x, a.y - b.y);
      };
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
        if (fingers.size === 2) apart = distance();
        this.greeting = false;
      });
      canvas.addEventListener("pointermove", (event) => {
        const box = canvas.getBoundingClientRect(), last = fingers.get(event.pointerId);
        if (!last) {
          if (event.pointerType === "touch") return;
          // A pointer that passes leans towards where it is.
          const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
          this.goTo([2 * x - 1, 2 * y - 1, this.target[2]]);
          return;
        }
        const [dx, dy] = [event.clientX - last.x, event.clientY - last.y];
        fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
        if (fingers.size === 2) {
          const now = distance();
          this.goTo([this.target[0], this.target[1], this.target[2] + 2 * (now - apart) / box.width]);
          apart = now;
        } else {
          // What is near follows the finger, so the viewpoint goes the other way.
          this.goTo([this.target[0] - 3 * dx / box.width, this.target[1] - 3 * dy / box.height, this.target[2]]);
        }
      });
      for (const end of ["pointerup", "pointercancel"]) {
        canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
      }
    }

    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const [x, y, z] = this.target, step = 0.15;
      const leans = {
        ArrowLeft: [x - step, y, z], ArrowRight: [x + step, y, z], ArrowUp: [x, y - step, z], ArrowDown: [x, y + step, z],
        "+": [x, y, z + step], "=": [x, y, z + step], "-": [x, y, z - step],
      };
      const commands = { Home: () => this.reset(), s: () => byId("stereo").click(), f: () => byId("full").click() };
      if (leans[event.key]) {
        this.goTo(leans[event.key]);
        this.tell();
      } else if (commands[event.key]) {
        commands[event.key]();
      } else {
        return;
      }
      event.preventDefault();
    }

    reset() {
      this.tiltFrom = null;
      this.goTo([0, 0, 0]);
      this.tell();
    }

    toggleStereo() {
      this.stereo = !this.stereo;
      byId("stereo").setAttribute("aria-pressed", this.stereo);
      byId("status").textContent = this.stereo ? "Two pictures side by side, left eye on the left." : "One picture.";
      this.resize();
      this.render();
    }

    listenToFullScreen() {
      const figure = byId("figure"), button = byId("full");
      button.hidden = !figure.requestFullscreen;
      const failed = () => { byId("status").textContent = "Full screen is not allowed here."; };
      button.onclick = () => document.fullscreenElement ? document.exitFullscreen() : figure.requestFullscreen().catch(failed);
      document.addEventListener("fullscreenchange", () => {
        button.setAttribute("aria-pressed", Boolean(document.fullscreenElement));
      });
    }

    // Devices that can be tilted; some ask before they tell, after a press of a button only.
    offerTilt() {
      const events = window.DeviceOrientationEvent;
      if (!events || !window.matchMedia("(pointer: coarse)").matches) return;
      const button = byId("motion");
      button.hidden = false;
      const tilted = (event) => this.tilt(event);
      button.onclick = async () => {
        const on = button.getAttribute("aria-pressed") !== "true";
        if (on && events.requestPermission && await events.requestPermission().catch(() => "denied") !== "granted") {
          byId("status").textContent = "The device does not allow the page to notice its tilt.";
          return;
        }
        this.tiltFrom = null;
        button.setAttribute("aria-pressed", on);
        (on ? window.addEventListener : window.removeEventListener)("deviceorientation", tilted);
      };
    }

    tilt({ beta, gamma }) {
      if (beta === null || gamma === null) return;
      this.tiltFrom = this.tiltFrom || [beta, gamma];
      const [down, right] = [beta - this.tiltFrom[0], gamma - this.tiltFrom[1]];
      const turned = (screen.orientation && screen.orientation.angle || 0) * Math.PI / 180;
      const [x, y] = [right / 20, down / 20];
      const across = x * Math.cos(turned) + y * Math.sin(turned), along = y * Math.cos(turned) - x * Math.sin(turned);
      this.goTo([across, along, this.target[2]]);
    }

    // --- Headsets ---------------------------------------------------------------------------------------------------

    async offerVr() {
      if (!navigator.xr) return;
      const button = byId("vr");
      button.hidden = !await navigator.xr.isSessionSupported("immersive-vr").catch(() => false);
      button.onclick = () => this.enterVr().catch((error) => {
        byId("status").textContent = "The headset does not start: " + error.message;
      });
    }

    async enterVr() {
      const gl = this.painter.gl, session = await navigator.xr.requestSession("immersive-vr");
      await gl.makeXRCompatible();
      const layer = new XRWebGLLayer(session, gl);
      session.updateRenderState({ baseLayer: layer });
      const space = await session.requestReferenceSpace("local");
      this.session = session;
      session.addEventListener("end", () => {
        this.session = null;
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        this.ask();
      });
      // The middle of the picture is four metres away.
      const metres = 4 / this.photo.pivot;
      let origin = null;
      const draw = (time, frame) => {
        session.requestAnimationFrame(draw);
        const pose = frame.getViewerPose(space);
        if (!pose) return;
        // The photo's camera is where the head is first.
        const { x, y, z } = pose.transform.position;
        origin = origin || space.getOffsetReferenceSpace(new XRRigidTransform({ x, y, z }));
        const seen = frame.getViewerPose(origin);
        if (!seen) return;
        gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
        this.painter.begin(true);
        for (const eye of seen.views) {
          const at = layer.getViewport(eye);
          gl.viewport(at.x, at.y, at.width, at.height);
          this.painter.draw(this.painter.eyeMatrix(eye.projectionMatrix, eye.transform.inverse.matrix, metres), false);
        }
      };
      session.requestAnimationFrame(draw);
    }
  }

  // Returns what the address asks for exactly, for tests; null where it asks for nothing.
  function exactView() {
    const asked = new URLSearchParams(location.hash.slice(1));
    if (!asked.has("at")) return null;
    const numbers = (text, parter) => text.split(parter).map(Number);
    const size = asked.has("size") ? numbers(asked.get("size"), "x") : [innerWidth, innerHeight];
    return { at: numbers(asked.get("at"), ","), size, zoom: Number(asked.get("zoom") || 1) };
  }

  async function start(photo) {
    try {
      if (!photo) throw new Error("data.js is missing or incomplete");
      const painter = new Painter(byId("view"), photo);
      await painter.load();
      new Viewer(photo, byId("view"), painter).start();
    } catch (error) {
      byId("help").textContent = "This picture has depth, but cannot be shown with it here: " + error.message + ". You see the photo.";
      document.documentElement.dataset.state = "failed";
    }
  }

  return { start };
})();
