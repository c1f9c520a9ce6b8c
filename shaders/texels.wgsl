// Lookups of layer textures' texels in tiles. The including shader declares `const STORED`: whether the atlas is read
// as stored, in sRGB. Rust: gpu/renderer/texels.rs; the CPU reference of filtering is projection/twin.

@group(1) @binding(0) var atlas: texture_2d_array<f32>;
@group(1) @binding(1) var bilinear: sampler;
// Per layer texture and level the grid of tiles: the slot, and the number of levels by which the resident tile is
// coarser.
@group(1) @binding(2) var<storage, read> pages: array<u32>;
// TEXTURE_WORDS words per layer texture, of which the last 16 are the indices at which each level's grid begins in
// `pages`.
@group(1) @binding(3) var<storage, read> layer_textures: array<u32>;

const TILE: f32 = 64.0;
const GUTTER: f32 = 2.0;
const SLOT: f32 = 68.0;
const NOTHING: u32 = 0xffffffffu;
const SLOT_BITS: u32 = 24u;
const TEXTURE_WORDS: u32 = 21u;
const MATTE_WORD: u32 = 4u;
const FIRST_OFFSET: u32 = 5u;
// Levels whose longer side is at most 2^TAIL_LOG texels share one slot.
const TAIL_LOG: u32 = 5u;

// The distance from a texel's centre, as a share of its width, within which the texel is taken without
// interpolation. Positions are exact to a few ten-thousandths of a pixel; bilinear weights of 8 bits are less
// so.
const DEAD: f32 = 0.02;

// A layer texture for lookups: its index, the corner of its rectangle in photo pixels, and log2 of its sides.
struct TexturePlacement {
    layer_texture: u32,
    corner: vec2f,
    log_size: vec2u,
}

// The position of a level of the tail in its slot, by log2 of the level's longer side.
fn tail_spot(log_side: u32) -> vec2f {
    switch log_side {
        case 0u: { return vec2f(36.0, 32.0); }
        case 1u: { return vec2f(56.0, 20.0); }
        case 2u: { return vec2f(48.0, 20.0); }
        case 3u: { return vec2f(36.0, 20.0); }
        case 4u: { return vec2f(36.0, 0.0); }
        default: { return vec2f(0.0, 0.0); }
    }
}

fn floor_to_center(at: vec2f) -> vec2f {
    let base = floor(at - 0.5);
    let share = (at - 0.5) - base;
    return base + 0.5 + clamp((share - DEAD) / (1.0 - 2.0 * DEAD), vec2f(0.0), vec2f(1.0));
}

// Converts a position to texels of a level; sides that are one texel long are not halved any more.
fn in_level(layer_texture: TexturePlacement, at: vec2f, level: u32) -> vec2f {
    return at / vec2f(vec2u(1u) << min(vec2u(level), layer_texture.log_size));
}

// Converts sRGB to linear light by a quartic (fitted, error at most 0.7 steps of 255), for previews, which
// filter colours as stored: software adapters decode each of the four texels of a lookup, which takes longer
// than everything else.
fn linear_of_stored(v: vec3f) -> vec3f {
    return v * (0.059567 + v * (0.361799 + v * (0.899047 - v * 0.320413)));
}

// Looks up linear colour and confidence at `at`, in texels of the layer texture's level 0, in one level. w < 0 means
// that there is no tile.
fn texel_at_level(layer_texture: TexturePlacement, at: vec2f, level: u32) -> vec4f {
    let size = max(vec2u(1u), (vec2u(1u) << layer_texture.log_size) >> vec2u(level));
    let grid_width = (size.x + 63u) >> 6u;
    let held = clamp(at, vec2f(0.0), vec2f(vec2u(1u) << layer_texture.log_size));
    let position = in_level(layer_texture, held, level);
    let tile = min(vec2u(position / TILE), (size - 1u) >> vec2u(6u));
    let grid = layer_textures[layer_texture.layer_texture * TEXTURE_WORDS + FIRST_OFFSET + level];
    let entry = pages[grid + tile.y * grid_width + tile.x];
    if entry == NOTHING {
        return vec4f(0.0, 0.0, 0.0, -1.0);
    }
    // The resident tile may be an ancestor of the wanted one.
    let up = entry >> SLOT_BITS;
    let longer = max(layer_texture.log_size.x, layer_texture.log_size.y);
    var corner = vec2f((tile >> vec2u(up)) << vec2u(6u));
    if level + up + TAIL_LOG >= longer {
        corner = -tail_spot(longer - min(longer, level + up));
    }
    let local = floor_to_center(in_level(layer_texture, held, level + up)) - corner + GUTTER;
    let slot = vec2f(f32(entry & 31u), f32((entry >> 5u) & 31u)) * SLOT;
    let uv = (slot + local) / vec2f(textureDimensions(atlas));
    let texel = textureSampleLevel(atlas, bilinear, uv, i32((entry & 0xffffffu) >> 10u), 0.0);
    if STORED {
        return vec4f(linear_of_stored(texel.rgb), texel.a);
    }
    return texel;
}

// The part of an octave over which previews mix two levels; elsewhere they use one level.
const MIXED: f32 = 0.3;

// The sum of texels of two levels by their shares, and the sum of the shares of those that have a tile.
struct TwoLevels {
    sum: vec4f,
    present: f32,
}

fn two_levels(layer_texture: TexturePlacement, at: vec2f, level: f32) -> TwoLevels {
    let held = min(level, f32(max(layer_texture.log_size.x, layer_texture.log_size.y)));
    let lower = floor(held);
    var share = held - lower;
    if STORED {
        share = clamp((share - 0.5) / MIXED + 0.5, 0.0, 1.0);
    }
    var found = TwoLevels(vec4f(0.0), 1e-6);
    var next = select(lower, lower + 1.0, share == 1.0);
    var part = select(1.0 - share, 1.0, share == 1.0);
    loop {
        let texel = texel_at_level(layer_texture, at, u32(next));
        let there = select(0.0, part, texel.w >= 0.0);
        found.sum += there * texel;
        found.present += there;
        if next > lower || share == 0.0 {
            break;
        }
        next += 1.0;
        part = share;
    }
    return found;
}

// Looks up a texel between two levels. Where one has no tile, the other's colour is taken.
fn texel_at(layer_texture: TexturePlacement, at: vec2f, level: f32) -> vec4f {
    let found = two_levels(layer_texture, at, level);
    return vec4f(found.sum.rgb / found.present, select(found.sum.w, -1.0, found.present < 1e-5));
}

// Returns the texture with the matte of a layer texture; NOTHING where it has none.
fn matte_texture(layer_texture: u32) -> u32 {
    return layer_textures[layer_texture * TEXTURE_WORDS + MATTE_WORD];
}

// Looks up a matte between two levels: how much the surface covers. It is the last value of its texels. Where it has no tile
// its layer texture has none either.
fn matte_at(matte: TexturePlacement, at: vec2f, level: f32) -> f32 {
    let found = two_levels(matte, at, level);
    return found.sum.w / found.present;
}
