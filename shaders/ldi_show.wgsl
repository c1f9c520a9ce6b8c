// Pass show: the colours of single pixels, of the depth pixels of one part of the level.
// Rust: gpu/ldi/show.rs.

@compute @workgroup_size(256)
fn show(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= pixel_count() {
        return;
    }
    // The complement of the index, 0 where there is nothing: the low word of WIDE ones, else in the second plane.
    let word = depths[select(pixel_count() + id.x, 2u * id.x, WIDE)];
    let at = ~word - part.x;
    if word == 0u || at >= arrayLength(&pixels) {
        return;
    }
    let colour = pixels[at].z;
    var shown = colour & 0xff000000u;
    for (var channel = 0u; channel < 3u; channel++) {
        let byte = (colour >> (8u * channel)) & 0xffu;
        shown |= exposed[256u * channel + byte] << (8u * channel);
    }
    picture[id.x] = shown;
}
