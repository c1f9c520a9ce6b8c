// The pictures on the device: coarse and fine photos, what they say of their pixels, and pages of tiles. Every photo is there coarsely
// before any is fine; fine ones take slots, and the one that the view needs least gives its slot away.
quadratura.textures = (() => {
  "use strict";

  // What the device may spend on fine photos, in bytes: computers, and phones and others that say little of themselves.
  const LARGE = 768e6, SMALL = 192e6;
  const PAGE = 2048;
  // A finer picture fades in over this time.
  const FADE_MS = 300;

  function budget() {
    const coarse = matchMedia("(pointer: coarse)").matches;
    return coarse || (navigator.deviceMemory || 8) < 4 ? SMALL : LARGE;
  }

  const picture = (bytes, options) => quadratura.pictureOf(bytes, "image/jpeg", options);
  // The size of a photo's picture as it is stored.
  const stored = (photo, size) => (photo.turned ? [size[1], size[0]] : size);
  const largest = (sizes) => sizes.reduce((a, b) => [Math.max(a[0], b[0]), Math.max(a[1], b[1])], [1, 1]);

  class Textures {
    constructor(gl, site, reducer, changed) {
      Object.assign(this, { gl, site, reducer, changed, budget: budget() });
      this.anisotropic = gl.getExtension("EXT_texture_filter_anisotropic");
      this.small = [];
      this.state = site.photos.map(() => ({ slot: -1, since: 0, loading: false, failed: false }));
      this.sizes = {
        near: largest(site.photos.map((photo) => stored(photo, photo.stored))),
        far: largest(site.photos.map((photo) => stored(photo, photo.far))),
        labels: largest(site.photos.map((photo) => stored(photo, photo.size))),
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
      const gl = this.gl, { near, far, labels } = this.sizes, count = this.site.photos.length;
      const levels = ([width, height]) => 1 + Math.floor(Math.log2(Math.max(width, height)));
      const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
      // Where not all fine photos find space, they are taken at half their size.
      const bytes = near[0] * near[1] * 4 * 4 / 3;
      this.scale = Math.max(...near) > most || bytes * Math.min(count, 8) > this.budget ? 0.5 : 1;
      const size = near.map((side) => Math.ceil(side * this.scale));
      this.slots = Math.max(1, Math.min(count, Math.floor(this.budget / (bytes * this.scale * this.scale)), gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS)));
      this.holders = new Array(this.slots).fill(-1);
      const half = labels.map((side) => Math.ceil(side / 2));
      const page = (pages) => [pages.length ? PAGE : 1, pages.length ? PAGE : 1];
      const { hidden, cut } = this.site;
      this.near = this.array(gl.SRGB8_ALPHA8, size, this.slots, levels(size), gl.LINEAR);
      this.far = this.array(gl.SRGB8_ALPHA8, far, count, levels(far), gl.LINEAR);
      this.labels = this.array(gl.R8UI, labels, count, 1, gl.NEAREST);
      this.trusts = this.array(gl.RGBA8, half, count, 1, gl.LINEAR);
      this.hidden = this.array(gl.SRGB8_ALPHA8, page(hidden), hidden.length, hidden.length ? 2 : 1, gl.LINEAR);
      this.hiddenTrusts = this.array(gl.R8, page(hidden), hidden.length, 1, gl.LINEAR);
      this.cut = this.array(gl.SRGB8_ALPHA8, page(cut), cut.length, cut.length ? 2 : 1, gl.LINEAR);
      this.cutMattes = this.array(gl.RG8, page(cut), cut.length, cut.length ? 2 : 1, gl.LINEAR);
    }

    put(texture, layer, format, width, height, source) {
      const gl = this.gl;
      gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, width, height, 1, format, gl.UNSIGNED_BYTE, source);
      for (let level = 1; level < texture.levels; level++) this.reducer.halve(texture, layer, level);
    }

    // Reads the coarse photos, with labels and confidence.
    async loadFar() {
      let number = 0;
      for (const chunk of this.site.far) {
        const parts = await quadratura.load(chunk, () => -2);
        for (; number < this.site.photos.length && parts[this.site.photos[number].name + "/far"]; number++) await this.putFar(number, parts);
      }
      if (number < this.site.photos.length) throw new Error("coarse photos are missing");
    }

    async putFar(number, parts) {
      const gl = this.gl, photo = this.site.photos[number], part = (name) => parts[photo.name + "/" + name];
      const [width, height] = stored(photo, photo.size), half = [width, height].map((side) => Math.ceil(side / 2));
      this.put(this.labels, number, gl.RED_INTEGER, width, height, quadratura.summed(part("labels"), width));
      const planes = ["trust", "agreement", "outlines"].map((name) => quadratura.summed(part(name), half[0]));
      const mixed = new Uint8Array(4 * half[0] * half[1]);
      planes.forEach((plane, c) => { for (let i = 0; i < plane.length; i++) mixed[4 * i + c] = plane[i]; });
      this.put(this.trusts, number, gl.RGBA, ...half, mixed);
      this.small[number] = new Blob([part("far")], { type: "image/jpeg" });
      const bitmap = await picture(part("far"));
      this.put(this.far, number, gl.RGBA, bitmap.width, bitmap.height, bitmap);
      bitmap.close();
    }

    // Returns a small picture of a photo, which stands upright.
    thumbnail(number) {
      const frame = document.createElement("span"), image = new Image();
      frame.className = this.site.photos[number].turned ? "thumbnail turned" : "thumbnail";
      image.alt = "";
      image.src = URL.createObjectURL(this.small[number]);
      frame.append(image);
      return frame;
    }

    // Reads the pages of tiles: those of layers that one sees through first.
    async loadPages() {
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
      const all = [...cut.map((page, i) => load(page, i, -1, this.cut, this.cutMattes, gl.RG, interleaved)),
        ...hidden.map((page, i) => load(page, i, 0.3, this.hidden, this.hiddenTrusts, gl.RED, (planes) => planes[0]))];
      return (await Promise.allSettled(all)).filter((page) => page.status === "rejected").length;
    }

    // Asks for the fine photos that a view needs most; `apart` tells how far a photo is from the view.
    want(apart) {
      this.apart = apart;
      const order = this.state.map((_, i) => i).sort((a, b) => apart(a) - apart(b)).slice(0, this.slots);
      for (const i of order) {
        const state = this.state[i];
        if (state.slot >= 0 || state.loading || state.failed) continue;
        state.loading = true;
        quadratura.load("near-" + (i + 1), () => this.apart(i)).then((parts) => this.putNear(i, parts))
          .catch((error) => { state.failed = true; this.trouble(error); }).finally(() => { state.loading = false; });
      }
    }

    async putNear(number, parts) {
      const photo = this.site.photos[number], [width, height] = stored(photo, photo.stored).map((side) => Math.max(1, Math.round(side * this.scale)));
      const bitmap = await picture(parts.colours, this.scale < 1 ? { resizeWidth: width, resizeHeight: height, resizeQuality: "high" } : {});
      const free = this.holders.indexOf(-1);
      const slot = free >= 0 ? free : this.holders.reduce((worst, holder, i) => (this.apart(holder) > this.apart(this.holders[worst]) ? i : worst), 0);
      if (free < 0) this.state[this.holders[slot]].slot = -1;
      this.put(this.near, slot, this.gl.RGBA, bitmap.width, bitmap.height, bitmap);
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

    isComplete() { return this.state.filter((state) => state.slot >= 0 || state.failed).length >= Math.min(this.slots, this.state.length); }
  }

  return { Textures, stored };
})();
