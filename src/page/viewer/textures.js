// The pictures on the device: coarse and fine photos, what is known of their pixels, and pages of tiles. Every photo is there coarsely
// before any is fine; fine ones take slots, and the one that the view needs least gives its slot away.
quadratura.textures = (() => {
  "use strict";

  // What the device may spend on all pictures, in bytes: computers, and phones and others that say little of themselves.
  const LARGE = 1280e6, SMALL = 256e6;
  // The most of it for pages of tiles.
  const FOR_PAGES = 0.4;
  // So many fine photos are the fewest; where they do not fit, they are taken at half their size.
  const FEWEST = 8;
  // Bytes a pixel: colours with their levels, one byte, and weights at half the size.
  const COLOURS = 4 * 4 / 3, FINE = COLOURS + 1 + 1, COARSE = COLOURS + 1, HIDDEN = 4 * 5 / 4 + 1, CUT = 4 * 5 / 4 + 2 * 5 / 4;
  const PAGE = 2048;
  // A finer picture fades in over this time.
  const FADE_MS = 300;
  const WEIGHTS = ["trust", "agreement", "outlines"];

  function budget() {
    const coarse = matchMedia("(pointer: coarse)").matches;
    return coarse || (navigator.deviceMemory || 8) < 4 ? SMALL : LARGE;
  }

  const picture = (bytes, options) => quadratura.pictureOf(bytes, "image/jpeg", options);
  // The size of a photo's picture as it is stored.
  const stored = (photo, size) => (photo.turned ? [size[1], size[0]] : size);
  // Returns how many of several chunks could not be read.
  const lost = async (all) => (await Promise.allSettled(all)).filter(({ status }) => status === "rejected").length;
  const halved = (size) => size.map((side) => Math.ceil(side / 2));
  const largest = (sizes) => sizes.reduce((a, b) => [Math.max(a[0], b[0]), Math.max(a[1], b[1])], [1, 1]);

  // Returns up to four planes as one of four values a pixel.
  function mixed(planes) {
    const out = new Uint8Array(4 * planes[0].length);
    planes.forEach((plane, c) => { for (let i = 0; i < plane.length; i++) out[4 * i + c] = plane[i]; });
    return out;
  }

  // Returns a plane with fewer pixels: those in the middle.
  function sampled(plane, [width, height], [w, h]) {
    const out = new Uint8Array(w * h);
    for (let y = 0; y < h; y++) {
      const row = width * Math.floor((y + 0.5) * height / h);
      for (let x = 0; x < w; x++) out[y * w + x] = plane[row + Math.floor((x + 0.5) * width / w)];
    }
    return out;
  }

  class Textures {
    constructor(gl, site, reducer, changed) {
      Object.assign(this, { gl, site, reducer, changed, budget: budget() });
      this.anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
      this.frames = new Map();
      this.state = site.photos.map(() => ({ slot: -1, since: 0, loading: false, failed: false }));
      this.sizes = {
        near: largest(site.photos.map((photo) => stored(photo, photo.stored))),
        far: largest(site.photos.map((photo) => stored(photo, photo.far))),
      };
      this.make();
    }

    array(format, [width, height], layers, levels, filter) {
      const gl = this.gl, texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels, format, width, height, Math.max(1, layers));
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, side, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, levels > 1 ? gl.LINEAR_MIPMAP_LINEAR : filter);
      if (levels > 1 && this.anisotropic) gl.texParameterf(gl.TEXTURE_2D_ARRAY, this.anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, 8);
      return Object.assign(texture, { size: [width, height], levels });
    }

    make() {
      const gl = this.gl, { near, far } = this.sizes;
      const levels = ([width, height]) => 1 + Math.floor(Math.log2(Math.max(width, height)));
      const most = gl.getParameter(gl.MAX_TEXTURE_SIZE), layers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS);
      // How many photos the device holds at all.
      this.held = Math.min(this.site.photos.length, layers);
      const forPages = FOR_PAGES * this.budget / (PAGE * PAGE);
      const cut = Math.min(this.site.cut.length, layers, Math.floor(forPages / CUT));
      const hidden = Math.min(this.site.hidden.length, layers, Math.floor((forPages - cut * CUT) / HIDDEN));
      const taken = (cut * CUT + hidden * HIDDEN) * PAGE * PAGE + far[0] * far[1] * COARSE * this.held;
      const left = Math.max(this.budget - taken, 0.2 * this.budget), bytes = near[0] * near[1] * FINE;
      this.scale = Math.max(...near) > most || bytes * Math.min(this.held, FEWEST) > left ? 0.5 : 1;
      const size = near.map((side) => Math.ceil(side * this.scale));
      this.slots = Math.max(1, Math.min(this.held, Math.floor(left / (bytes * this.scale * this.scale))));
      this.holders = new Array(this.slots).fill(-1);
      const pages = (format, count, levels) => this.array(format, count ? [PAGE, PAGE] : [1, 1], count, count ? levels : 1, gl.LINEAR);
      this.near = this.array(gl.SRGB8_ALPHA8, size, this.slots, levels(size), gl.LINEAR);
      this.labels = this.array(gl.R8UI, size, this.slots, 1, gl.NEAREST);
      this.trusts = this.array(gl.RGBA8, halved(size), this.slots, 1, gl.LINEAR);
      this.far = this.array(gl.SRGB8_ALPHA8, far, this.held, levels(far), gl.LINEAR);
      this.coarse = this.array(gl.RGBA8, halved(far), this.held, 1, gl.LINEAR);
      this.hidden = pages(gl.SRGB8_ALPHA8, hidden, 2);
      this.hiddenTrusts = pages(gl.R8, hidden, 1);
      this.cut = pages(gl.SRGB8_ALPHA8, cut, 2);
      this.cutMattes = pages(gl.RG8, cut, 2);
      this.pages = { cut, hidden };
    }

    put(texture, layer, format, width, height, source) {
      const gl = this.gl;
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, width, height, 1, format, gl.UNSIGNED_BYTE, source);
      for (let level = 1; level < texture.levels; level++) this.reducer.halve(texture, layer, level);
    }

    // Reads the coarse photos, with what is known of their pixels. Returns when those near the start are there; `all` tells how many
    // chunks were lost when all are.
    loadFar() {
      const load = async ({ chunk, first, photos }, rank) => {
        const parts = await quadratura.load(chunk, () => rank - 1000);
        for (let number = first; number < Math.min(first + photos, this.held); number++) await this.putFar(number, parts);
        this.changed();
      };
      const chunks = this.site.far.map(load);
      this.all = lost(chunks).then((count) => {
        this.hasFar = true;
        this.changed();
        return count;
      });
      return chunks[0];
    }

    async putFar(number, parts) {
      const photo = this.site.photos[number], part = (name) => parts[photo.name + "/" + name];
      const size = halved(stored(photo, photo.far));
      this.put(this.coarse, number, this.gl.RGBA, ...size, mixed([...WEIGHTS, "labels"].map((name) => quadratura.summed(part(name), size[0]))));
      const bitmap = await picture(part("far"));
      this.put(this.far, number, this.gl.RGBA, bitmap.width, bitmap.height, bitmap);
      bitmap.close();
      this.frameOf(number).firstChild.src = URL.createObjectURL(new Blob([part("far")], { type: "image/jpeg" }));
    }

    // Returns a small picture of a photo, which stands upright; it is empty until the coarse photo is there.
    frameOf(number) {
      if (this.frames.has(number)) return this.frames.get(number);
      const frame = document.createElement("span"), image = new Image();
      frame.className = this.site.photos[number].turned ? "thumbnail turned" : "thumbnail";
      image.alt = "";
      frame.append(image);
      this.frames.set(number, frame);
      return frame;
    }

    // Reads the pages of tiles: those of layers that one sees through first.
    loadPages() {
      const gl = this.gl, { hidden, cut } = this.site;
      const load = async ({ chunk, rows }, layer, rank, colours, others, format, mix) => {
        const parts = await quadratura.load(chunk, () => rank);
        const planes = Object.entries(parts).filter(([name]) => name !== "colours").map(([, bytes]) => quadratura.summed(bytes, PAGE));
        const bitmap = await picture(parts.colours);
        this.put(colours, layer, gl.RGBA, PAGE, rows, bitmap);
        // Colours have a say once it is known how far they are to be trusted.
        this.put(others, layer, format, PAGE, rows, mix(planes));
        bitmap.close();
        this.changed();
      };
      const interleaved = ([a, b]) => { const out = new Uint8Array(2 * a.length); for (let i = 0; i < a.length; i++) { out[2 * i] = a[i]; out[2 * i + 1] = b[i]; } return out; };
      const all = [...cut.slice(0, this.pages.cut).map((page, i) => load(page, i, -1, this.cut, this.cutMattes, gl.RG, interleaved)),
        ...hidden.slice(0, this.pages.hidden).map((page, i) => load(page, i, 0.3, this.hidden, this.hiddenTrusts, gl.RED, (planes) => planes[0]))];
      return lost(all);
    }

    // Asks for the fine photos that a view needs most; `apart` tells how far a photo is from the view.
    want(apart) {
      this.apart = apart;
      if (!this.hasFar) return;
      const order = this.state.slice(0, this.held).map((_, i) => i).sort((a, b) => apart(a) - apart(b)).slice(0, this.slots);
      for (const i of order) {
        const state = this.state[i];
        if (state.slot >= 0 || state.loading || state.failed) continue;
        state.loading = true;
        quadratura.load("near-" + (i + 1), () => this.apart(i)).then((parts) => this.putNear(i, parts))
          .catch((error) => { state.failed = true; this.trouble(error); }).finally(() => { state.loading = false; });
      }
    }

    async putNear(number, parts) {
      const gl = this.gl, photo = this.site.photos[number], whole = stored(photo, photo.stored);
      const size = whole.map((side) => Math.ceil(side * this.scale));
      const bitmap = await picture(parts.colours, this.scale < 1 ? { resizeWidth: size[0], resizeHeight: size[1], resizeQuality: "high" } : {});
      const free = this.holders.indexOf(-1);
      const slot = free >= 0 ? free : this.holders.reduce((worst, holder, i) => (this.apart(holder) > this.apart(this.holders[worst]) ? i : worst), 0);
      if (free < 0) this.state[this.holders[slot]].slot = -1;
      const plane = (name, from, to) => sampled(quadratura.summed(parts[name], from[0]), from, to);
      this.put(this.labels, slot, gl.RED_INTEGER, ...size, plane("labels", whole, size));
      this.put(this.trusts, slot, gl.RGBA, ...halved(size), mixed(WEIGHTS.map((name) => plane(name, halved(whole), halved(size)))));
      this.put(this.near, slot, gl.RGBA, bitmap.width, bitmap.height, bitmap);
      bitmap.close();
      this.holders[slot] = number;
      Object.assign(this.state[number], { slot, since: performance.now() });
      this.changed();
    }

    // Says how many photos could not be read.
    trouble() {
      const failed = this.state.filter((state) => state.failed).length;
      quadratura.say(failed + " of " + this.state.length + " photos could not be loaded finely.");
    }

    // How far the fine picture of a photo is shown, 0 to 1.
    fade(number, now) {
      const { slot, since } = this.state[number];
      return slot < 0 ? 0 : quadratura.instant ? 1 : Math.min(1, (now - since) / FADE_MS);
    }

    isFading(now) { return this.state.some((_, i) => { const fade = this.fade(i, now); return fade > 0 && fade < 1; }); }

    isComplete() { return this.hasFar && this.state.filter((state) => state.slot >= 0 || state.failed).length >= this.slots; }
  }

  return { Textures, stored };
})();
