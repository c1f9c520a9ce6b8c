// Data as scripts: a chunk is asked for by appending its script, which calls `quadratura.chunk` with its name, the number of its bytes,
// their checksum, and the bytes in base64. So a page opens from disk, where nothing can be fetched, and under a strict policy.
(() => {
  "use strict";

  // Two scripts are loaded at a time, so that what is wanted more can overtake what is wanted less.
  const AT_ONCE = 2;
  const given = new Map();
  let loading = 0;
  let queue = [];

  quadratura.chunk = (name, count, sum, base64) => given.set(name, { count, sum, base64 });

  function bytesOf(base64) {
    if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);
    const text = atob(base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return bytes;
  }

  // Adler-32, as in the program.
  function checksum(bytes) {
    let a = 1, b = 0;
    for (let from = 0; from < bytes.length; from += 5552) {
      const to = Math.min(bytes.length, from + 5552);
      for (let i = from; i < to; i++) { a += bytes[i]; b += a; }
      a %= 65521;
      b %= 65521;
    }
    return b * 65536 + a;
  }

  // Unpacks what was deflated without a header.
  async function inflated(bytes, count) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
    const found = new Uint8Array(await new Response(stream).arrayBuffer());
    if (found.length !== count) throw new Error("a part has another length");
    return found;
  }

  // Returns the parts of a chunk by their names.
  async function partsOf(name) {
    const chunk = given.get(name);
    given.delete(name);
    if (!chunk) throw new Error("data/" + name + ".js is no data of this page");
    const bytes = bytesOf(chunk.base64);
    if (bytes.length !== chunk.count || checksum(bytes) !== chunk.sum) throw new Error("data/" + name + ".js is damaged");
    const end = bytes.indexOf(10);
    const listed = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    const parts = {};
    let at = end + 1;
    for (const part of listed) {
      const own = bytes.slice(at, at + part.bytes);
      parts[part.name] = part.unpacked === undefined ? own : await inflated(own, part.unpacked);
      at += part.bytes;
    }
    return parts;
  }

  // Runs the script of this name; what went wrong once may have been the network.
  quadratura.script = (name) => script(name).catch(() => script(name));

  function script(name) {
    return new Promise((resolve, reject) => {
      const element = document.createElement("script");
      element.src = "data/" + name + ".js";
      element.onload = () => { element.remove(); resolve(); };
      element.onerror = () => { element.remove(); reject(new Error("data/" + name + ".js is missing")); };
      document.head.append(element);
    });
  }

  async function read(name) {
    await script(name);
    return partsOf(name);
  }

  function next() {
    while (loading < AT_ONCE && queue.length) {
      const best = queue.reduce((a, b) => (b.rank() < a.rank() ? b : a));
      queue = queue.filter((wanted) => wanted !== best);
      loading++;
      // What went wrong once may have been the network.
      read(best.name).catch(() => read(best.name)).then(best.resolve, best.reject).finally(() => { loading--; next(); });
    }
  }

  // Returns the parts of a chunk as bytes. Of those that wait, the one of the smallest rank comes next.
  quadratura.load = (name, rank = () => 0) => new Promise((resolve, reject) => {
    queue.push({ name, rank, resolve, reject });
    next();
  });

  // Returns what a picture of a chunk shows, its values as they are in the file.
  quadratura.pictureOf = (bytes, type, options) =>
    createImageBitmap(new Blob([bytes], { type }), { colorSpaceConversion: "none", premultiplyAlpha: "none", ...options });

  // Returns bytes as numbers of a type, from a copy, since parts begin anywhere.
  quadratura.numbers = (type, bytes) => new type(bytes.slice().buffer);

  // Adds up rows, each of which is stored less the one before.
  quadratura.summed = (bytes, width) => {
    for (let at = width; at < bytes.length; at++) bytes[at] += bytes[at - width];
    return bytes;
  };
})();
