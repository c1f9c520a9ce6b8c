// What photos show: labels and confidence, tiles beside them, and colours.

// Of fine photos: labels, and at half the size confidence, agreement and outlines. Of coarse ones: all
// four at half the size, labels last.
uniform highp usampler2DArray labels;
uniform mediump sampler2DArray trusts;
uniform highp sampler2DArray coarse_known;
uniform mediump sampler2DArray near_photos;
uniform mediump sampler2DArray far_photos;
uniform mediump sampler2DArray hidden_pages;
uniform mediump sampler2DArray hidden_trusts;
#ifdef SEE_THROUGH
uniform mediump sampler2DArray cut_pages;
uniform mediump sampler2DArray cut_mattes;
#endif

const uint OWN = 0u, HIDDEN = 1u, CUT = 2u;
// Tiles of 60 cells in slots of 64, of which a page has 32 x 32.
const float TILE = 60.0, GUTTER = 2.0, SLOT = 64.0, PAGE = 2048.0;

// A position in the photo as its picture is stored.
vec2 turned(Camera photo, vec2 px) {
    return photo.size.z < 0.0 ? vec2(photo.size.y - px.y, px.x) : px;
}

vec2 turned_step(Camera photo, vec2 by) {
    return photo.size.z < 0.0 ? vec2(-by.y, by.x) : by;
}

// What a server has at a position.
struct Known {
    // Confidence; 0 for nothing.
    float confidence;
    float agreement;
    // How much of the texel shows its face.
    float outline;
    uint kind;
    // The octaves by which the picture that is loaded of the photo is coarser than the photo.
    float lost;
};

// The least of what a photo says of itself where it shows something.
const vec3 LEAST = vec3(0.004, 0.004, 0.0);

// The place in a page of tiles: uv, page, and uv per photo pixel; page below 0 where there is no tile.
vec4 tile_place(uint at, vec2 px) {
    uvec4 head = server_word(at);
    uvec4 more = server_word(at + 1u);
    vec2 cell = (px - vec2(ivec2(more.xy))) / float(head.x);
    ivec2 tile = ivec2(floor(cell / TILE));
    vec2 end = vec2(head.yz) * TILE;
    if (cell.x < -0.5 || cell.y < -0.5 || cell.x >= end.x || cell.y >= end.y) return vec4(0.0, 0.0, -1.0, 0.0);
    tile = max(tile, ivec2(0));
    uint number = uint(tile.y) * head.y + uint(tile.x);
    uint slot = server_word(at + 2u + number / 4u)[number % 4u];
    if (slot == 0u) return vec4(0.0, 0.0, -1.0, 0.0);
    slot -= 1u;
    vec2 corner = vec2(float(slot & 31u), float((slot >> 5) & 31u)) * SLOT;
    vec2 within = clamp(cell - vec2(tile) * TILE, vec2(-1.5), vec2(TILE + 1.5));
    return vec4((corner + GUTTER + within) / PAGE, float(slot >> 10), 1.0 / (float(head.x) * PAGE));
}

// Whether there is a tile, and its page is on the device.
bool is_held(float page, int pages) {
    return page >= 0.0 && page < float(pages);
}

bool shows(uint at, uint label) {
    uvec4 bits = server_word(at + (label >> 7));
    return label != 0u && ((bits[(label >> 5) & 3u] >> (label & 31u)) & 1u) == 1u;
}

// What a photo says of itself at a cell of its planes: confidence, agreement and outline; zeros where it does not show these labels.
vec3 known_finely(uint set, vec2 cell, float slot) {
    if (!shows(set, texelFetch(labels, ivec3(cell, slot), 0).r)) return vec3(0.0);
    return max(textureLod(trusts, vec3(cell / (2.0 * vec2(textureSize(trusts, 0).xy)), slot), 0.0).rgb, LEAST);
}

vec3 known_coarsely(uint set, vec2 cell, float number) {
    if (!shows(set, uint(texelFetch(coarse_known, ivec3(cell, number), 0).a * 255.0 + 0.5))) return vec3(0.0);
    return max(textureLod(coarse_known, vec3(cell / vec2(textureSize(coarse_known, 0).xy), number), 0.0).rgb, LEAST);
}

// Both, while a fine picture fades in.
vec3 known_of_photo(uint number, uint set, vec2 at) {
    vec4 place = photo_word(number, 10), fine = photo_word(number, 8), coarse = photo_word(number, 9);
    at = clamp(at, vec2(0.0), place.xy - 1.0);
    if (coarse.z < 0.0) return vec3(0.0);
    vec3 a = place.z < 1.0 ? known_coarsely(set, at * coarse.w, coarse.z) : vec3(0.0);
    vec3 b = place.z > 0.0 ? known_finely(set, at * fine.w, fine.z) : vec3(0.0);
    return vec3(mix(a.x, b.x, place.z), a.x == 0.0 ? b.yz : b.x == 0.0 ? a.yz : mix(a.yz, b.yz, place.z));
}

// Looks up what a server has at a position in its photo.
Known known_at(uint photo_number, Camera photo, uvec4 server, vec2 px) {
#ifdef SEE_THROUGH
    if (server.w != 0u) {
        vec4 place = tile_place(server.w, px);
        float found = is_held(place.z, textureSize(cut_mattes, 0).z) ? textureLod(cut_mattes, place.xyz, 0.0).r : 0.0;
        return Known(found, 1.0, 1.0, CUT, 0.0);
    }
#endif
    vec3 known = known_of_photo(photo_number, server.y, turned(photo, px));
    if (known.x > 0.0) return Known(known.x, known.y, known.z, OWN, photo_word(photo_number, 10).w);
    if (server.z != 0u) {
        vec4 tile = tile_place(server.z, px);
        return Known(is_held(tile.z, textureSize(hidden_trusts, 0).z) ? textureLod(hidden_trusts, tile.xyz, 0.0).r : 0.0, 1.0, 1.0, HIDDEN, 0.0);
    }
    return Known(0.0, 1.0, 1.0, OWN, 0.0);
}

// The light that a server shows at a position; a and b are the position's movements for a step of one pixel to the right, and down. Of
// what one sees through it is multiplied by the matte, which is the last value.
vec4 light_at(uint photo_number, Camera photo, float fine_share, uvec4 server, uint kind, vec2 px, vec2 a, vec2 b) {
    if (kind == HIDDEN) {
        vec4 place = tile_place(server.z, px);
        return vec4(textureGrad(hidden_pages, place.xyz, a * place.w, b * place.w).rgb, 1.0);
    }
#ifdef SEE_THROUGH
    if (kind == CUT) {
        vec4 place = tile_place(server.w, px);
        return vec4(textureGrad(cut_pages, place.xyz, a * place.w, b * place.w).rgb, textureGrad(cut_mattes, place.xyz, a * place.w, b * place.w).g);
    }
#endif
    vec2 at = turned(photo, px);
    a = turned_step(photo, a);
    b = turned_step(photo, b);
    vec4 fine = photo_word(photo_number, 8), coarse = photo_word(photo_number, 9);
    vec3 light = vec3(0.0);
    if (fine_share < 1.0) light = textureGrad(far_photos, vec3(at * coarse.xy, coarse.z), a * coarse.xy, b * coarse.xy).rgb;
    if (fine_share > 0.0) {
        vec3 finer = textureGrad(near_photos, vec3(at * fine.xy, fine.z), a * fine.xy, b * fine.xy).rgb;
        light = mix(light, finer, fine_share);
    }
    return vec4(light, 1.0);
}

// What is stored from the first of these shares of white on may be white, and is from the second on.
const float WHITE_FROM = 0.88, WHITE_CERTAIN = 0.97;

// Removes what the photo's camera adds and takes, and exposes as the view.
vec3 exposed(Camera photo, Look look, vec4 texel, vec2 px) {
    vec2 from_axis = px - look.optics.xy;
    float r2 = dot(from_axis, from_axis);
    vec3 light = texel.rgb;
    if (photo.size.w != 0.0) light = max(light - photo.size.w * texel.a, min(light, vec3(1.5e-4 * texel.a)));
    return light * exp(-(look.optics.z + look.optics.w * r2) * r2) * (look.gain.rgb * lens_here());
}

// What is stored as white, which was at least as bright, stays so.
vec3 kept_white(vec4 texel, vec3 light) {
    float darkest = min(min(texel.r, texel.g), texel.b) / max(texel.a, 1e-3);
    return light + smoothstep(WHITE_FROM, WHITE_CERTAIN, darkest) * max(texel.rgb - light, vec3(0.0));
}
