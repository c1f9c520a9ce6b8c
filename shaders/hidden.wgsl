// Pass *hidden*: which blocks of samples of trees are behind what was drawn before them, so that pass *flakes* leaves them out. What was
// drawn is reduced to the depth of the farthest sub-pixel of each tile (a z-pyramid of one level: Greene, Kass & Miller 1993). Entry
// points: `reduce` writes the tiles, `hide` tests blocks against them.
// Rust: gpu/renderer/plants/hidden.rs (Tested). Before this text: surfaces.wgsl, flake.wgsl, and `depths`, the depth buffer with SAMPLES
// samples a pixel.

const WORKGROUP = 64u;
// The side of a tile in pixels.
const TILE = 4u;
// A block in more tiles than this is not tested: an invocation would take long, and hardly all of them are covered.
const MOST_TILES = 256u;
// A block must be farther by this share of its depth to count as hidden. Depths of the box and of samples are rounded by a few units
// in the last place, of 6e-8; the sun is a thousand times as far away as its view is wide, where this is two thousandths of the width.
const ROUNDING = 2e-6;

// The jobs that are tested.
struct Tested {
    first: u32,
    count: u32,
    pad0: u32,
    pad1: u32,
}

// 1 + the nearest sample of each sub-pixel, and the bits of its nearness.
@group(1) @binding(2) var<storage, read> kept: array<vec2u>;
// The bits of the least nearness in each tile of the rows; 0 where a sub-pixel is empty.
@group(1) @binding(3) var<storage, read_write> tiles: array<u32>;
// 1 for each job whose block is hidden.
@group(1) @binding(4) var<storage, read_write> is_hidden: array<u32>;
// Image and first sample of each block.
@group(1) @binding(5) var<storage, read> jobs: array<vec2u>;
// In place of the samples, which this pass does not read. Three words a block, of columns, rows and depths: the lowest in the lower half
// of a word, the highest in the upper.
@group(2) @binding(0) var<storage, read> blocks: array<u32>;
@group(2) @binding(1) var<uniform> tested: Tested;

fn tiles_in_view() -> vec2u {
    return (vec2u(rows.width, rows.count) + TILE - 1u) / TILE;
}

// The bits of numbers that are not negative are in the order of the numbers.
fn nearness_at(pixel: vec2u, sub_pixel: u32) -> u32 {
    let of_samples = kept[(pixel.y * rows.width + pixel.x) * SAMPLES + sub_pixel].y;
    // The last argument is the sample, or where there is one alone, the level.
    let of_surfaces = textureLoad(depths, vec2u(pixel.x, rows.first + pixel.y), sub_pixel) / frame.near;
    return max(of_samples, bitcast<u32>(of_surfaces));
}

@compute @workgroup_size(64)
fn reduce(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let count = tiles_in_view();
    let tile = WORKGROUP * (group.y * groups.x + group.x) + index;
    if tile >= count.x * count.y {
        return;
    }
    let low = TILE * vec2u(tile % count.x, tile / count.x);
    let high = min(low + TILE, vec2u(rows.width, rows.count));
    var least = 0xffffffffu;
    for (var y = low.y; y < high.y && least > 0u; y++) {
        for (var x = low.x; x < high.x && least > 0u; x++) {
            for (var sub_pixel = 0u; sub_pixel < SAMPLES; sub_pixel++) {
                least = min(least, nearness_at(vec2u(x, y), sub_pixel));
            }
        }
    }
    tiles[tile] = least;
}

// Whether nothing of a block can be seen: in the image's frame it lies in a box.
fn is_covered(image: FlakeImage, block: u32) -> bool {
    let words = vec3u(blocks[3u * block], blocks[3u * block + 1u], blocks[3u * block + 2u]);
    let steps = vec3f(image.delta, image.delta, image.depth_step);
    let origin = vec3f(-image.half * image.delta, -image.half * image.delta, image.first_depth);
    let from_low = origin + steps * vec3f(words & vec3u(0xffffu));
    let to_high = origin + steps * vec3f((words >> vec3u(16u)) + vec3u(1u, 1u, 0u));
    let of_box = vec4f(0.5 * (from_low + to_high), 1.0);
    let half_box = 0.5 * (to_high - from_low);
    let middle = vec3f(dot(image.right, of_box), dot(image.down, of_box), dot(image.forward, of_box));
    let half_sides = vec3f(
        dot(abs(image.right.xyz), half_box),
        dot(abs(image.down.xyz), half_box),
        dot(abs(image.forward.xyz), half_box),
    );
    let nearest = (middle.z - half_sides.z) * (1.0 - ROUNDING);
    if !(nearest > 0.0) {
        return false;
    }
    let farthest = middle.z + half_sides.z;
    let low = middle.xy - half_sides.xy;
    let high = middle.xy + half_sides.xy;
    let focal = vec2f(frame.focal_x, frame.focal_y);
    let center = frame.center - vec2f(0.0, f32(rows.first));
    // A sample reaches at most rows.reach pixels beside the pixel of its point: less than one more, since the point lies anywhere in that.
    let reach_px = f32(rows.reach + 1u);
    let from_px = focal * min(low / nearest, low / farthest) + center - reach_px;
    let to_px = focal * max(high / nearest, high / farthest) + center + reach_px;
    let size = vec2f(vec2u(rows.width, rows.count));
    if any(to_px < vec2f(0.0)) || any(from_px >= size) {
        return true;
    }
    let from_tile = vec2u(max(from_px, vec2f(0.0))) / TILE;
    let to_tile = vec2u(min(to_px, size - 1.0)) / TILE;
    let sides = to_tile - from_tile + 1u;
    if sides.x * sides.y > MOST_TILES {
        return false;
    }
    let nearness = bitcast<u32>(1.0 / nearest);
    let across = tiles_in_view().x;
    for (var y = from_tile.y; y <= to_tile.y; y++) {
        for (var x = from_tile.x; x <= to_tile.x; x++) {
            if tiles[y * across + x] <= nearness {
                return false;
            }
        }
    }
    return true;
}

@compute @workgroup_size(64)
fn hide(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) index: u32,
) {
    let place = WORKGROUP * (group.y * groups.x + group.x) + index;
    if place >= tested.count {
        return;
    }
    let number = tested.first + place;
    let job = jobs[number];
    let image = images[job.x];
    is_hidden[number] = u32(is_covered(image, image.first_block + job.y / BLOCK));
}
