// Trees as polygons: every triangle of every instance, hidden by faces and hiding them. Entry points: `lit` (colours), `plain`
// (one colour a tree), `numbered` (the numbers of trees) and `shadow` (nothing but depths, for shadows).
// Rust: gpu/renderer/plants/pipeline.rs (Placement), gpu/renderer/plants/species.rs (corners, instances, Matter). Before this text: surfaces.wgsl,
// daylight.wgsl, stipple.wgsl, and the constants CUT, true where pictures are cut out, and STIPPLE, true where
// instances are drawn in part of the sub-pixels.
// CPU reference: foliage/brute.rs, foliage/view.rs (normal_map).

// How instances are placed in the view.
struct Placement {
    // Rows of the map from the frame of instances to the camera's.
    right: vec4f,
    down: vec4f,
    forward: vec4f,
    // The index in `trees` of what instances call 0.
    first: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

// How a surface answers light.
struct Matter {
    reflected: vec3f,
    // 1: a leaf, lit from both sides.
    leaf: u32,
    through: vec3f,
    // The alpha of the picture below which there is nothing.
    cutout: f32,
    // The size of the picture in pixels.
    size: vec2f,
    pad0: vec2f,
}

struct PlantCorner {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) texture: vec2f,
    // Rows of the map from the sub-object's frame to that of instances.
    @location(3) x: vec4f,
    @location(4) y: vec4f,
    @location(5) z: vec4f,
    // The factors by which paint changes light plus DARK.
    @location(6) change: vec3f,
    // The sub-pixels in which the instance is drawn.
    @location(7) stipple: u32,
    // The index of its tree in `trees`, counted from `placement.first`.
    @location(8) tree: u32,
}

// foliage/paint/change.rs
const DARK = 0.01;

@group(1) @binding(0) var<uniform> placement: Placement;
// The trees in view.
@group(1) @binding(1) var<storage, read> trees: array<Shown>;
@group(2) @binding(0) var<uniform> matter: Matter;
// Linear light times alpha, and alpha.
@group(2) @binding(1) var picture: texture_2d<f32>;
@group(2) @binding(2) var picture_sampler: sampler;

// A point of a surface, in the camera's frame. All but `stipple` and `tree` is interpolated at the sample: devices would be free to choose
// another place in the pixel, and the triangles are so small that the pixel's centre is mostly beyond them.
struct Lit {
    @invariant @builtin(position) clip: vec4f,
    @location(0) @interpolate(perspective, sample) point: vec3f,
    @location(1) @interpolate(perspective, sample) normal: vec3f,
    @location(2) @interpolate(perspective, sample) texture: vec2f,
    @location(3) @interpolate(perspective, sample) change: vec3f,
    @location(4) @interpolate(flat) stipple: u32,
    @location(5) @interpolate(flat) tree: u32,
}

@vertex
fn grown(corner: PlantCorner) -> Lit {
    let object = vec4f(corner.position, 1.0);
    let placed = vec4f(dot(corner.x, object), dot(corner.y, object), dot(corner.z, object), 1.0);
    let camera = vec3f(dot(placement.right, placed), dot(placement.down, placed), dot(placement.forward, placed));
    // The columns of the linear map from the sub-object's frame to the camera's.
    let placed_from_object = transpose(mat3x3f(corner.x.xyz, corner.y.xyz, corner.z.xyz));
    let camera_from_placed = transpose(mat3x3f(placement.right.xyz, placement.down.xyz, placement.forward.xyz));
    let map = camera_from_placed * placed_from_object;
    // Its inverse transpose up to a positive factor, which also exists where the map is singular.
    let cofactors = mat3x3f(cross(map[1], map[2]), cross(map[2], map[0]), cross(map[0], map[1]));
    let side = select(1.0, -1.0, dot(map[0], cofactors[0]) < 0.0);
    var lit: Lit;
    let x = 2.0 * (frame.focal_x * camera.x + frame.center.x * camera.z) / frame.size.x - camera.z;
    let y = camera.z - 2.0 * (frame.focal_y * camera.y + frame.center.y * camera.z) / frame.size.y;
    lit.clip = vec4f(x, y, frame.near, camera.z);
    lit.point = camera;
    lit.normal = side * (cofactors * corner.normal);
    lit.texture = corner.texture;
    lit.change = corner.change;
    lit.stipple = corner.stipple;
    lit.tree = placement.first + corner.tree;
    return lit;
}

// Leaves out what the picture cuts out, and sub-pixels in which something else is drawn.
fn cut_out(surface: Lit, sub_pixel: u32) {
    if STIPPLE {
        if !is_open(surface.stipple, vec2u(surface.clip.xy), sub_pixel) {
            discard;
        }
    }
    if CUT {
        if textureSampleLevel(picture, picture_sampler, surface.texture, 0.0).a < matter.cutout {
            discard;
        }
    }
}

@fragment
fn lit(surface: Lit, @builtin(sample_index) sub_pixel: u32) -> @location(0) vec4f {
    // Averaged over about as much of the picture as a pixel shows; each copy has a fourth of the pixels.
    let right = dpdx(surface.texture) * matter.size;
    let down = dpdy(surface.texture) * matter.size;
    let area = abs(right.x * down.y - right.y * down.x);
    let shown = textureSampleLevel(picture, picture_sampler, surface.texture, 0.5 * log2(max(area, 1.0)));
    cut_out(surface, sub_pixel);
    var normal = surface.normal * inverseSqrt(max(dot(surface.normal, surface.normal), 1e-37));
    if matter.leaf != 0u && dot(normal, surface.point) > 0.0 {
        normal = -normal;
    }
    let bare = matter.reflected * shown.rgb / max(shown.a, 1e-6);
    var reflected = bare;
    var through = matter.through;
    // Without paint, where interpolation gives 1 but for its last bits, nothing changes.
    if any(abs(surface.change - 1.0) > vec3f(1e-4)) {
        reflected = clamp((bare + DARK) * surface.change - DARK, vec3f(0.0), vec3f(1.0));
        through = clamp(through * (reflected + 1e-4) / (bare + 1e-4), vec3f(0.0), 1.0 - reflected);
    }
    let reach = reach_at(trees[surface.tree], surface.point, normal);
    var light = light_of(normal, reflected, through, matter.leaf != 0u, reach);
    let tree = surface.tree;
    light *= trees[tree].tint * photographed(trees[tree].first_ratio, trees[tree].ratio_count, surface.point);
    return vec4f(light * darkening(surface.clip.xy), 1.0);
}

@fragment
fn plain(surface: Lit, @builtin(sample_index) sub_pixel: u32) -> @location(0) vec4f {
    cut_out(surface, sub_pixel);
    return trees[surface.tree].plain;
}

@fragment
fn numbered(surface: Lit, @builtin(sample_index) sub_pixel: u32) -> @location(0) u32 {
    cut_out(surface, sub_pixel);
    return trees[surface.tree].number;
}

@fragment
fn shadow(surface: Lit, @builtin(sample_index) sub_pixel: u32) {
    cut_out(surface, sub_pixel);
}
