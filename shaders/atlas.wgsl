// Texture memory: where a sheet's texels are (src/projection/tiles.rs says how they lie there).
// The including shader declares
//   var<storage, read> sheets: array<Sheet>;      per sheet, where its page tables are
//   var<storage, read> pages: array<u32>;         the page tables
//   var atlas: texture_2d_array<f32>;             the slots: linear light and confidence
//   var atlas_sampler: sampler;                   linear

const TILE: f32 = 64.0;
const GUTTER: f32 = 2.0;
const SLOT: f32 = 68.0;
const NOTHING: u32 = 0xffffffffu;
const SLOT_BITS: u32 = 24u;
const PAGE_LOG: u32 = 5u;
const TAIL_SPOTS = array<vec2f, 6>(
    vec2f(36.0, 32.0), vec2f(56.0, 20.0), vec2f(48.0, 20.0), vec2f(36.0, 20.0), vec2f(36.0, 0.0), vec2f(0.0, 0.0), 
);

struct Sheet {
    log: vec2u,
    levels: u32,
    // The first level in the tail.
    tail: u32,
    offsets: array<u32, 16>,
}

// A place in texture memory, in texels of a page. level: the one that it is in, coarser than asked for
// where memory is short. page: -1 where the sheet holds nothing.
struct Spot {
    texel: vec2f,
    page: i32,
    level: u32,
}

// Where the texels about `uv` (0..1 of the sheet, v down) are, at `level` or the nearest coarser one that
// is there. Lookups up to one texel around the spot stay among the sheet's own texels.
fn spot(sheet: u32, level: u32, uv: vec2f) -> Spot {
    let last = sheets[sheet].levels - 1u;
    let wanted = min(level, last);
    let log = sheets[sheet].log;
    let tile = tile_of(log, wanted, uv);
    let columns = max(1u, (1u << (max(log.x, wanted) - wanted)) >> 6u);
    let entry = pages[sheets[sheet].offsets[wanted] + tile.y * columns + tile.x];
    if entry == NOTHING {
        return Spot(vec2f(), -1, wanted);
    }
    let found = wanted + (entry >> SLOT_BITS);
    let slot = entry & ((1u << SLOT_BITS) - 1u);
    let size = level_size(log, found);
    var corner = vec2f(tile_of(log, found, uv)) * TILE;
    if found >= sheets[sheet].tail {
        corner = -TAIL_SPOTS[max(log.x, log.y) - found];
    }
    let place = vec2f(f32(slot & 31u), f32((slot >> PAGE_LOG) & 31u)) * SLOT + GUTTER - corner;
    let texel = clamp(uv * size, vec2f(-1.0), size + 1.0) + place;
    return Spot(texel, i32(slot >> (2u * PAGE_LOG)), found);
}

// Colour in linear light and confidence at `uv`, one level, bilinear. Nothing: 0.
fn sheet_texel(sheet: u32, level: u32, uv: vec2f) -> vec4f {
    let found = spot(sheet, level, uv);
    if found.page < 0 {
        return vec4f();
    }
    let scale = 1.0 / vec2f(textureDimensions(atlas));
    return textureSampleLevel(atlas, atlas_sampler, found.texel * scale, found.page, 0.0);
}

fn level_size(log: vec2u, level: u32) -> vec2f {
    return vec2f(vec2u(1u) << (max(log, vec2u(level)) - level));
}

fn tile_of(log: vec2u, level: u32, uv: vec2f) -> vec2u {
    let tiles = max(vec2u(1u), (vec2u(1u) << (max(log, vec2u(level)) - level)) >> vec2u(6u));
    let at = max(uv, vec2f()) * level_size(log, level) * (1.0 / TILE);
    return min(vec2u(at), tiles - 1u);
}
