// Pass pairs: every ordered pair of items of which the first is nearer by more than the tolerance,
// with the number of those pixels, in a hash table.
// Rust: gpu/pairs.rs, which also undoes the hash.

// Pixels of a row that one invocation looks at. Neighbours mostly hold the same few pairs: these
// are counted in registers, and the table is touched when a pair makes room for another.
const RUN: u32 = 64u;
// Slots tried for a pair before the table counts as full.
const PROBES: u32 = 128u;
// A pair is a number of 40 bits: two numbers of the working set.
const HALF_BITS: u32 = 20u;
const HALF: u32 = 0xfffffu;

@group(1) @binding(0) var<storage, read> places: array<u32>;
@group(1) @binding(1) var<storage, read> entries: array<u32>;
// 0: free, else 1 + (the pair's bits that its first slot does not tell, then 7 bits of probes).
@group(1) @binding(2) var<storage, read_write> tags: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> pixels: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> overflow: atomic<u32>;

// The last four pairs of an invocation, the newest first.
struct Recent {
    front: vec4<u32>,
    back: vec4<u32>,
    pixels: vec4<u32>,
}

fn stir(half: u32, turn: u32) -> u32 {
    var h = (half + turn * 0x9e3779b9u) * 0x85ebca6bu;
    h = (h ^ (h >> 15u)) * 0xc2b2ae35u;
    return (h ^ (h >> 13u)) & HALF;
}

// A Feistel network: it scatters, and can be undone.
fn scatter(front: u32, back: u32) -> vec2<u32> {
    var pair = vec2(front, back);
    for (var turn = 0u; turn < 4u; turn++) {
        pair = vec2(pair.y, pair.x ^ stir(pair.y, turn));
    }
    return pair;
}

fn add(front: u32, back: u32, count: u32) {
    let bits = firstTrailingBit(arrayLength(&tags));
    let pair = scatter(planes[front].number, planes[back].number);
    var slot: u32;
    var rest: u32;
    if bits <= HALF_BITS {
        let left = HALF_BITS - bits;
        slot = pair.x >> left;
        rest = ((pair.x & ((1u << left) - 1u)) << HALF_BITS) | pair.y;
    } else {
        let taken = bits - HALF_BITS;
        slot = (pair.x << taken) | (pair.y >> (HALF_BITS - taken));
        rest = pair.y & ((1u << (HALF_BITS - taken)) - 1u);
    }
    var probe = 0u;
    while probe < PROBES {
        let at = (slot + probe) & (arrayLength(&tags) - 1u);
        let tag = ((rest << 7u) | probe) + 1u;
        var found = atomicLoad(&tags[at]);
        if found == 0u {
            let swap = atomicCompareExchangeWeak(&tags[at], 0u, tag);
            found = select(swap.old_value, tag, swap.exchanged);
        }
        if found == tag {
            atomicAdd(&pixels[at], count);
            return;
        }
        // A weak exchange may fail without reason: then the slot is still free, try it again.
        probe += select(1u, 0u, found == 0u);
    }
    atomicStore(&overflow, 1u);
}

fn see(recent: ptr<function, Recent>, front: u32, back: u32) {
    let same = ((*recent).front == vec4(front)) & ((*recent).back == vec4(back));
    if any(same) {
        (*recent).pixels += select(vec4(0u), vec4(1u), same);
        return;
    }
    if (*recent).pixels.w != 0u {
        add((*recent).front.w, (*recent).back.w, (*recent).pixels.w);
    }
    (*recent).front = vec4(front, (*recent).front.xyz);
    (*recent).back = vec4(back, (*recent).back.xyz);
    (*recent).pixels = vec4(1u, (*recent).pixels.xyz);
}

fn depth_of(item: u32, centre: vec2<f32>) -> f32 {
    let plane = planes[item];
    return inverse_depth(vec3(plane.a, plane.b, plane.c), vec2(plane.u0, plane.v0), centre);
}

@compute @workgroup_size(64)
fn pairs(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = frame.row + id.y;
    var x = id.x * RUN;
    if row >= frame.row_end || x >= frame.width {
        return;
    }
    let x_end = min(x + RUN, frame.width);
    let first = (row - frame.y0) * frame.width;
    var recent = Recent(vec4(0u), vec4(0u), vec4(0u));
    var end = places[first + x] - frame.first_entry;
    for (; x < x_end; x++) {
        let begin = end;
        end = places[first + x + 1u] - frame.first_entry;
        let centre = vec2(f32(x) + 0.5, f32(row) + 0.5);
        for (var i = begin; i + 1u < end; i++) {
            let one = entries[i] & ~VISIBLE;
            let one_depth = depth_of(one, centre);
            for (var j = i + 1u; j < end; j++) {
                let other = entries[j] & ~VISIBLE;
                let other_depth = depth_of(other, centre);
                if is_behind(other_depth, one_depth) {
                    see(&recent, one, other);
                } else if is_behind(one_depth, other_depth) {
                    see(&recent, other, one);
                }
            }
        }
    }
    for (var i = 0u; i < 4u; i++) {
        if recent.pixels[i] != 0u {
            add(recent.front[i], recent.back[i], recent.pixels[i]);
        }
    }
}
