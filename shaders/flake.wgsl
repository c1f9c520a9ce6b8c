// The images of plants in a view, and their samples: what the passes *flakes* and *flaked* share.
// Rust: gpu/renderer/plants/flake.rs. Before this text: surfaces.wgsl, and the constants SAMPLES, of a pixel, and BLOCK, the samples of a
// block of an image.
// CPU reference: foliage/normal.rs, foliage/images.rs.

// An image of a sub-object in the view. Its frame has its origin in the middle of the image, x right, y down, z away from its
// viewer.
struct FlakeImage {
    // Rows of the map from the image's frame to the camera's.
    right: vec4f,
    down: vec4f,
    forward: vec4f,
    // Rows of the map of normals, each followed by one number: the side of a pixel, the step of depths, and the depth of step 0.
    normal_right: vec3f,
    delta: f32,
    normal_down: vec3f,
    depth_step: f32,
    normal_forward: vec3f,
    first_depth: f32,
    // What leaves let through over what they reflect.
    through: vec3f,
    // Half of the image's columns.
    half: f32,
    // The factor on the light of its samples.
    gain: vec3f,
    // The length of the mean normals of its leaves.
    length: f32,
    // The first of its samples, and their number.
    first: u32,
    count: u32,
    // The number of samples of all images before it.
    before: u32,
    // The stipples of its direction and of the sub-object's images of this resolution: it draws where both are open.
    of_direction: u32,
    of_part: u32,
    // The tree among those in view, and its species.
    tree: u32,
    species: u32,
    // The first of its blocks of samples.
    first_block: u32,
}

// The rows of the picture that are drawn together.
struct FlakeRows {
    first: u32,
    count: u32,
    width: u32,
    // The most pixels that a sample reaches on each side of the pixel of its point.
    reach: u32,
}

// A sample of an image.
struct Flake {
    // Column and row.
    at: vec2f,
    // Steps of depth.
    depth: f32,
    // The sub-pixels that it covers, bit 4 y + x.
    covered: u32,
    normal: vec3f,
    is_leaf: bool,
    // The share of light that it reflects, as sRGB.
    colour: vec3f,
}

@group(1) @binding(0) var<uniform> rows: FlakeRows;
@group(1) @binding(1) var<storage, read> images: array<FlakeImage>;
// Three words a sample: column (12 bits), row (12), red; depth (16), normal (16); mask (16), green, blue.
@group(2) @binding(0) var<storage, read> samples: array<u32>;

const HALF_TURN = 3.14159265358979;

// The normal of a code of 15 bits.
fn normal_of(code: u32) -> vec3f {
    let latitude = (f32(code & 127u) / 127.0 - 0.5) * HALF_TURN;
    let longitude = f32((code >> 7u) & 255u) / 256.0 * (2.0 * HALF_TURN);
    return vec3f(cos(latitude) * vec2f(cos(longitude), sin(longitude)), sin(latitude));
}

fn flake_of(index: u32) -> Flake {
    let place = samples[3u * index];
    let shape = samples[3u * index + 1u];
    let rest = samples[3u * index + 2u];
    let colour = vec3u(place >> 24u, (rest >> 16u) & 0xffu, rest >> 24u);
    return Flake(
        vec2f(vec2u(place & 0xfffu, (place >> 12u) & 0xfffu)),
        f32(shape & 0xffffu),
        rest & 0xffffu,
        normal_of(shape >> 16u),
        (shape >> 31u) != 0u,
        vec3f(colour) / 255.0,
    );
}

// The point of a sample in the camera's frame.
fn point_of(image: FlakeImage, flake: Flake) -> vec3f {
    let across = (flake.at + 0.5 - image.half) * image.delta;
    let local = vec4f(across, image.first_depth + image.depth_step * flake.depth, 1.0);
    return vec3f(dot(image.right, local), dot(image.down, local), dot(image.forward, local));
}

// The normal of a sample in the camera's frame, of any length.
fn normal_in_view(image: FlakeImage, flake: Flake) -> vec3f {
    let normal = flake.normal;
    return vec3f(dot(image.normal_right, normal), dot(image.normal_down, normal), dot(image.normal_forward, normal));
}
