// The light on trees, what of it reaches a point of a crown, what a surface makes of it, and what photos show of it there.
// Rust: gpu/renderer/plants/daylight.rs. Before this text: surfaces.wgsl.
// CPU reference: foliage/shade.rs, foliage/openness.rs, foliage/ratio.rs.

// The light in the camera's frame: what a white surface reflects that faces each source.
struct Daylight {
    towards_sun: vec3f,
    pad0: f32,
    up: vec3f,
    pad1: f32,
    sun: vec3f,
    pad2: f32,
    sky: vec3f,
    pad3: f32,
    ground: vec3f,
    pad4: f32,
}

// A tree's crown in the view.
struct Crown {
    // Rows of the map from the camera's frame to cells of the grid.
    x: vec4f,
    y: vec4f,
    z: vec4f,
    // The directions around that to the sun, and their weights.
    suns: vec4u,
    weights: vec4f,
}

// What is shown of a tree in view.
struct Shown {
    // The factor on its light: its tint and the view's exposure.
    tint: vec3f,
    // What stands for the tree where faces have numbers.
    number: u32,
    // Its colour where views show no light: linear, with alpha.
    plain: vec4f,
    crown: Crown,
    // Its ratio images in the view: the index of the first in `ratios`, and their number.
    first_ratio: u32,
    ratio_count: u32,
    // 1 + the number of its block in `sunlit`; 0 where all sunlight reaches it.
    sunlit: u32,
    pad0: u32,
}

// What a photo shows of a tree over what is drawn of it, in a view.
struct Ratio {
    // Rows of the map from the camera's frame to its cells: a point is in the cell (x, y) / w.
    x: vec4f,
    y: vec4f,
    w: vec4f,
    // The corner of its cells in `ratio_cells`.
    corner: vec2f,
    // How much it counts in the view.
    weight: f32,
    pad0: f32,
}

// The grid of a species in which it is known how open the crown is.
struct Grid {
    // The number of cells along x, y, z.
    size: vec3f,
    pad0: f32,
}

@group(3) @binding(0) var<uniform> daylight: Daylight;
@group(3) @binding(1) var<uniform> grid: Grid;
// For each cell the mean over all directions, and the vector that the normal multiplies, in halves.
@group(3) @binding(2) var openness: texture_3d<f32>;
// For each cell how open it is in each of the 22 directions: blocks of cells, ACROSS of them in a row.
@group(3) @binding(3) var open_towards: texture_3d<f32>;
@group(3) @binding(4) var grid_sampler: sampler;
@group(3) @binding(5) var<storage, read> ratios: array<Ratio>;
// The logarithms of the ratios of all ratio images, each a square of RATIO_CELLS cells.
@group(3) @binding(6) var ratio_cells: texture_2d<f32>;

// The share of sunlight that reaches the trees past everything else: blocks of cells, SUNLIT_ACROSS of them in a row and a layer.
@group(3) @binding(7) var sunlit: texture_3d<f32>;

const ACROSS = 5u;
// gpu/renderer/plants/sunlit.rs, foliage/sunlit.rs
const SUNLIT_ACROSS = 16u;
const SUNLIT_CELLS = 8.0;
// foliage/ratio.rs
const RATIO_CELLS = 16.0;

// The shares of light that reach a point.
struct Reach {
    sun: f32,
    front: f32,
    back: f32,
}

// Of a place in the space of a crown, 0 to 1 along each axis.
fn sunlit_at(block: u32, place: vec3f) -> f32 {
    if block == 0u {
        return 1.0;
    }
    let number = block - 1u;
    let corner = vec3u(number, number / SUNLIT_ACROSS, number / (SUNLIT_ACROSS * SUNLIT_ACROSS));
    let first = SUNLIT_CELLS * vec3f(vec3u(corner.xy % SUNLIT_ACROSS, corner.z));
    // Beyond the middles of cells at the border all is as there.
    let at = first + clamp(SUNLIT_CELLS * place, vec3f(0.5), vec3f(SUNLIT_CELLS - 0.5));
    return textureSampleLevel(sunlit, grid_sampler, at / vec3f(textureDimensions(sunlit)), 0.0).r;
}

fn reach_at(shown: Shown, point: vec3f, normal: vec3f) -> Reach {
    let crown = shown.crown;
    let place = vec4f(point, 1.0);
    let at = vec3f(dot(crown.x, place), dot(crown.y, place), dot(crown.z, place));
    // Beyond the middles of cells at the border all is as there.
    let held = clamp(at, vec3f(0.5), grid.size - 0.5);
    let around = textureSampleLevel(openness, grid_sampler, held / grid.size, 0.0);
    // Normals go by the inverse transpose, up to a positive factor.
    let map = transpose(mat3x3f(crown.x.xyz, crown.y.xyz, crown.z.xyz));
    let cofactors = mat3x3f(cross(map[1], map[2]), cross(map[2], map[0]), cross(map[0], map[1]));
    let in_plant = cofactors * normal * select(1.0, -1.0, dot(map[0], cofactors[0]) < 0.0);
    let facing = 0.5 * dot(around.yzw, in_plant * inverseSqrt(max(dot(in_plant, in_plant), 1e-37)));
    var sun = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let block = vec2f(vec2u(crown.suns[i] % ACROSS, crown.suns[i] / ACROSS)) * grid.size.xy;
        let size = vec3f(f32(ACROSS) * grid.size.xy, grid.size.z);
        let place = vec3f(block + held.xy, held.z) / size;
        sun += crown.weights[i] * textureSampleLevel(open_towards, grid_sampler, place, 0.0).r;
    }
    sun *= sunlit_at(shown.sunlit, at / grid.size);
    return Reach(sun, clamp(around.x + facing, 0.0, 1.0), clamp(around.x - facing, 0.0, 1.0));
}

// What sky and ground give to a surface of this normal.
fn around(normal: vec3f) -> vec3f {
    return around_at(dot(normal, daylight.up));
}

// The same of a normal that is so far upwards.
fn around_at(up: f32) -> vec3f {
    return daylight.sky * (0.5 * (1.0 + up)) + daylight.ground * (0.5 * (1.0 - up));
}

// The light of a surface with a normal of length 1: of leaves the one that looks to the viewer.
fn light_of(normal: vec3f, reflected: vec3f, through: vec3f, is_leaf: bool, reach: Reach) -> vec3f {
    let facing = dot(normal, daylight.towards_sun);
    let sun = reach.sun * daylight.sun;
    var light = reflected * (sun * max(facing, 0.0) + reach.front * around(normal));
    if is_leaf {
        light += through * (sun * max(-facing, 0.0) + reach.back * around(-normal));
    }
    return light;
}

// The mean of |n.l| over leaves in all directions, each counted by what it covers, for the cosine between viewer and sun.
fn in_all_directions(cosine: f32) -> f32 {
    let held = clamp(cosine, -1.0, 1.0);
    let half_turn = 3.14159265358979;
    let sum = 2.0 * sqrt(1.0 - held * held) + (half_turn - 2.0 * acos(held)) * held;
    return 2.0 / (3.0 * half_turn) * sum;
}

// How the normals of the leaves of a sample are spread: the length of their mean, the direction to the viewer, of length 1, and the rows of
// the map of normals from the frame of the image, up to a factor.
struct Spread {
    length: f32,
    towards_viewer: vec3f,
    right: vec3f,
    down: vec3f,
    forward: vec3f,
}

// Leaves that look in all directions in the frame of their image, from which the map stretches them, in the sun: the length of the vector
// that the map's transpose makes of the sun's direction, its cosine to the axis of the image, the squared lengths of a normal along the
// axis and of the other two together that the map makes, and the mean of |n.l|, nearly, as a viewer sees them.
struct LeavesInSun {
    to_sun: f32,
    to_axis: f32,
    squares: vec2f,
    in_all_directions: f32,
}

fn leaves_in_sun(spread: Spread) -> LeavesInSun {
    let transposed = mat3x3f(spread.right, spread.down, spread.forward);
    let sun = transposed * daylight.towards_sun;
    let viewer = transposed * spread.towards_viewer;
    let to_sun = max(sqrt(dot(sun, sun)), 1e-18);
    let to_viewer = max(sqrt(dot(viewer, viewer)), 1e-18);
    let squared = transposed[0] * transposed[0] + transposed[1] * transposed[1] + transposed[2] * transposed[2];
    let aside = squared.x + squared.y;
    let size = sqrt(max((aside + squared.z) / 3.0, 1e-36));
    let in_all = in_all_directions(dot(sun / to_sun, viewer / to_viewer));
    return LeavesInSun(to_sun, sun.z / to_sun, vec2f(squared.z, aside), to_sun / size * in_all);
}

// The mean of |m.l|, nearly, over the directions m of the mean normals of samples: those of one leaf each where the share is 0, of many
// where it is 1.
fn over_samples(leaves: LeavesInSun, share: f32) -> f32 {
    // The mean of (m.a)^2 along the axis a, and along a line at a right angle to it.
    let along = 0.5 + 0.5 * share * sqrt(share);
    let aside = 0.5 * (1.0 - along);
    let square = aside + (along - aside) * leaves.to_axis * leaves.to_axis;
    let mean = sqrt(square) * min(0.78 + 0.27 * square, 1.0);
    let size = sqrt(max(along * leaves.squares.x + aside * leaves.squares.y, 1e-36));
    return mean * leaves.to_sun / size;
}

// The light of the leaves of a sample, whose mean normal has this direction.
fn light_of_leaves(normal: vec3f, spread: Spread, reflected: vec3f, through: vec3f, reach: Reach) -> vec3f {
    let length = spread.length;
    let facing = dot(normal, daylight.towards_sun);
    let share = clamp(3.0 * (1.0 - length), 0.0, 1.0);
    let leaves = leaves_in_sun(spread);
    let lacking = over_samples(leaves, 0.0) - over_samples(leaves, share);
    let across = mix(abs(facing) + lacking, leaves.in_all_directions, share);
    let sun = 0.5 * reach.sun * daylight.sun;
    let up = length * dot(normal, daylight.up);
    return reflected * (sun * (across + length * facing) + reach.front * around_at(up))
        + through * (sun * (across - length * facing) + reach.back * around_at(-up));
}

// The factor by which photos change the light of a tree at a point in the camera's frame.
fn photographed(first: u32, count: u32, point: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = first; i < first + count; i++) {
        let ratio = ratios[i];
        let place = vec4f(point, 1.0);
        let cell = vec2f(dot(ratio.x, place), dot(ratio.y, place)) / max(dot(ratio.w, place), 1e-30);
        // Beyond the middles of cells at the border all is as there.
        let at = ratio.corner + clamp(cell, vec2f(0.5), vec2f(RATIO_CELLS - 0.5));
        let size = vec2f(textureDimensions(ratio_cells));
        sum += ratio.weight * textureSampleLevel(ratio_cells, grid_sampler, at / size, 0.0).rgb;
    }
    return exp(sum);
}

// The darkening of a pixel by the view's lens.
fn darkening(px: vec2f) -> f32 {
    let from_axis = px - frame.center;
    let t2 = min(dot(from_axis, from_axis) / (frame.focal_x * frame.focal_y), frame.widest);
    return exp((frame.falloff.x + frame.falloff.y * t2) * t2);
}
