// Pass pairs: counts, in a hash table, the pixels of every ordered pair of items of which the first is nearer
// by more than the tolerance.
// Rust: gpu/pairs.rs, which also inverts the hash.

// Pixels of a row that one invocation processes.
const RUN: u32 = 64u;
// Slots tried for a pair before the table counts as full.
const PROBES: u32 = 128u;
// A pair is a number of 40 bits: two numbers of the working set.
const HALF_BITS: u32 = 20u;
const HALF: u32 = 0xfffffu;

@group(1) @binding(0) var<storage, read> places: array<u32>;
@group(1) @binding(1) var<storage, read> entries: array<u32>;
// 0: free, else 1 + (the bits of the pair that its first slot does not encode, then 7 bits of probes).
@group(1) @binding(2) var<storage, read_write> tags: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> pixels: array<atomic<u32>>;
@group(1) @binding(4) var<storage, read_write> overflow: atomic<u32>;

fn stir(half: u32, turn: u32) -> u32 {
    var h = (half + turn * 0x9e3779b9u) * 0x85ebca6bu;
    h = (h ^ (h >> 15u)) * 0xc2b2ae35u;
    return (h ^ (h >> 13u)) & HALF;
}

// A Feistel network, which scatters pairs invertibly.
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
        // A weak exchange may fail spuriously; the slot is then still free and tried again.
        probe += select(1u, 0u, found == 0u);
    }
    atomicStore(&overflow, 1u);
}

// Compares two fragments of one pixel: 1 when the first is nearer by more than the tolerance, 2 when the
// second is, 0 when neither.
fn nearer_of(one: f32, other: f32) -> u32 {
    return select(select(0u, 2u, is_behind(one, other)), 1u, is_behind(other, one));
}

fn depth_at(plane: Plane, x: u32, row: u32) -> f32 {
    let centre = vec2(f32(x) + 0.5, f32(row) + 0.5);
    return inverse_depth(vec3(plane.a, plane.b, plane.c), vec2(plane.u0, plane.v0), centre);
}

// Bounds the rounding errors of depth_at in columns [x, x_end) from above.
fn uncertainty(plane: Plane, x: u32, x_end: u32, row: u32) -> f32 {
    let dx = max(abs(f32(x) - plane.u0), abs(f32(x_end) - plane.u0));
    let dy = abs(f32(row) - plane.v0) + 1.0;
    return (abs(plane.a) * dx + abs(plane.b) * dy + abs(plane.c)) * 0x1p-20;
}

// Counts one pair of items over columns [x, x_end) of a row, all of which hold both.
fn count_pair(one: u32, other: u32, x: u32, x_end: u32, row: u32) {
    let p = planes[one];
    let q = planes[other];
    let p_left = depth_at(p, x, row);
    let q_left = depth_at(q, x, row);
    let p_right = depth_at(p, x_end - 1u, row);
    let q_right = depth_at(q, x_end - 1u, row);
    // Both sides of both comparisons are linear along the row. A result that holds at both ends, by more than
    // rounding could change, holds between them.
    let left = vec2(p_left * frame.nearer - q_left, q_left * frame.nearer - p_left);
    let right = vec2(p_right * frame.nearer - q_right, q_right * frame.nearer - p_right);
    let rounding_error = uncertainty(p, x, x_end, row) + uncertainty(q, x, x_end, row);
    let certain = (min(left, right) > vec2(rounding_error)) | (max(left, right) < vec2(-rounding_error));
    let wholly = all(certain);
    var front_is = vec2(0u);
    let at_left = nearer_of(p_left, q_left);
    front_is[0] = select(0u, x_end - x, wholly && at_left == 1u);
    front_is[1] = select(0u, x_end - x, wholly && at_left == 2u);
    for (var at = select(x, x_end, wholly); at < x_end; at++) {
        let here = nearer_of(depth_at(p, at, row), depth_at(q, at, row));
        front_is += vec2(select(0u, 1u, here == 1u), select(0u, 1u, here == 2u));
    }
    if front_is[0] > 0u {
        add(one, other, front_is[0]);
    }
    if front_is[1] > 0u {
        add(other, one, front_is[1]);
    }
}

// Neighbouring pixels mostly hold the same items, so a run of such pixels is counted at once. Workgroups are
// columns, because neighbouring rows take about the same steps.
@compute @workgroup_size(1, 64)
fn pairs(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = frame.row + id.y;
    var x = id.x * RUN;
    if row >= frame.row_end || x >= frame.width {
        return;
    }
    let x_end = min(x + RUN, frame.width);
    let first = (row - frame.y0) * frame.width;
    var place = places[first + x];
    while x < x_end {
        let x_begin = x;
        let begin = place - frame.first_entry;
        x += 1u;
        place = places[first + x];
        let size = place - frame.first_entry - begin;
        while x < x_end {
            let here = place - frame.first_entry;
            let next = places[first + x + 1u];
            let compared = select(size, 0u, size < 2u);
            var k = 0u;
            while k < compared && entries[begin + k] == entries[here + k] {
                k += 1u;
            }
            if k < compared || next - place != size {
                break;
            }
            place = next;
            x += 1u;
        }
        for (var i = 0u; i + 1u < size; i++) {
            for (var j = i + 1u; j < size; j++) {
                count_pair(entries[begin + i] & ~VISIBLE, entries[begin + j] & ~VISIBLE, x_begin, x, row);
            }
        }
    }
}
