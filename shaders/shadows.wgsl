// The shadows of trees on faces: the share of the sun that trees cover at a point, and what that leaves of the point's light.
// Percentages are of depths that are compared (Reeves, Salesin & Cook 1987), over a disc as wide as the sun's penumbra (Fernando
// 2005).
// Rust: gpu/renderer/shadows.rs. Before this text: surfaces.wgsl. After it: project.wgsl, with Drawn.
// CPU reference: foliage/cast.rs.

// A view from the sun, which is so far away that its rays are parallel.
struct SunView {
    // Rows that give u and v times depth, from the middle of the map, and depth, from positions relative to the viewpoint.
    row_u: vec4f,
    row_v: vec4f,
    row_z: vec4f,
    // The depth of the near plane, as in Frame.
    near: f32,
    // It serves points at depths below this.
    until: f32,
    // The side of a texel, in world units.
    texel: f32,
    // The radius of the widest penumbra, in texels.
    widest: f32,
}

struct Shadows {
    views: array<SunView, 3>,
    // The direction to the sun in the world, and what is up there.
    towards_sun: vec3f,
    // The number of views.
    count: u32,
    up: vec3f,
    pad0: f32,
    // What a white surface reflects that faces each source.
    sun: vec3f,
    pad1: f32,
    sky: vec3f,
    pad2: f32,
    ground: vec3f,
    pad3: f32,
}

@group(2) @binding(0) var<uniform> shadows: Shadows;
// near / z of what is nearest to the sun, of the trees that cast shadows and of the faces; a layer for each view.
@group(2) @binding(1) var tree_depths: texture_depth_2d_array;
@group(2) @binding(2) var face_depths: texture_depth_2d_array;
// Gives the share of what is nearer to the sun.
@group(2) @binding(3) var is_nearer: sampler_comparison;

// The tangent of half the angle at which the sun is seen (foliage/cast.rs).
const SUN_TANGENT: f32 = 0.00465;
// The radius of the narrowest filter, in texels: over the steps of texels.
const NARROWEST = 1.0;
// The share of a view's depths over which the next one takes over.
const TAKES_OVER: f32 = 0.15;
// How much nearer to the sun than a face something must be to cast a shadow on it, in texels, for trees and at least for faces;
// more for each unit of the slope of the face to the sun, and at most.
const NEARER = 1.0;
const NEARER_BY_SLOPE = 2.5;
const NEAREST = 12.0;

const TAPS = 16u;

// Evenly over a disc (Vogel 1979): of any number of taps, the first ones are in the middle.
fn on_disc(tap: u32, taps: u32) -> vec2f {
    let angle = 2.399963 * f32(tap);
    return sqrt((f32(tap) + 0.5) / f32(taps)) * vec2f(cos(angle), sin(angle));
}

// What is left of the light of a point of a face in one view, per channel. `pixel` is the size of the picture's pixel there.
fn left_in(number: u32, p: vec3f, normal: vec3f, facing: f32, pixel: f32) -> vec3f {
    let view = shadows.views[number];
    let place = vec4f(p, 1.0);
    let z = dot(view.row_z, place);
    let uv = vec2f(dot(view.row_u, place), dot(view.row_v, place)) / z + 0.5;
    if any(uv < vec2f(0.0)) || any(uv > vec2f(1.0)) {
        return vec3f(1.0);
    }
    let side = f32(textureDimensions(tree_depths).x);
    let last = vec2i(i32(side) - 1);
    // How far above the point trees are, so that their shadows are as soft as that makes them.
    let reference = view.near / (z - NEARER * view.texel);
    var above = 0.0;
    var found = 0.0;
    for (var tap = 0u; tap < TAPS; tap += 1u) {
        let at = vec2i(floor(uv * side + max(view.widest, NARROWEST) * on_disc(tap, TAPS)));
        let depth = textureLoad(tree_depths, clamp(at, vec2i(0), last), number, 0);
        if depth > reference {
            above += z - view.near / depth;
            found += 1.0;
        }
    }
    if found == 0.0 {
        return vec3f(1.0);
    }
    let penumbra = max(SUN_TANGENT * above / found, 0.5 * pixel) / view.texel;
    let radius = clamp(penumbra, NARROWEST, max(view.widest, NARROWEST)) / side;
    // What faces keep from the sun is dark in the photos already.
    let slope = sqrt(max(1.0 - facing * facing, 0.0)) / facing;
    let nearer = min(NEARER + NEARER_BY_SLOPE * slope, NEAREST) * view.texel;
    let reference_of_faces = view.near / (z - nearer);
    var covered = 0.0;
    var hidden = 0.0;
    for (var tap = 0u; tap < TAPS; tap += 1u) {
        let at = on_disc(tap, TAPS);
        covered += textureSampleCompareLevel(tree_depths, is_nearer, uv + radius * at, number, reference);
        // Farther from the point its own face may be nearer to the sun by more.
        let beside = uv + NARROWEST / side * at;
        hidden += textureSampleCompareLevel(face_depths, is_nearer, beside, number, reference_of_faces);
    }
    covered /= f32(TAPS);
    let sun = (1.0 - hidden / f32(TAPS)) * facing * shadows.sun;
    let up = dot(normal, shadows.up);
    let around = shadows.sky * (0.5 * (1.0 + up)) + shadows.ground * (0.5 * (1.0 - up));
    return (around + (1.0 - covered) * sun + 1e-6) / (around + sun + 1e-6);
}

// The light of a point of a face without what trees keep from it. `depth` is the point's depth in the picture.
fn darkened(light: vec3f, drawn: Drawn, p: vec3f, depth: f32) -> vec3f {
    // What is on a billboard is round, and the sun shines on it from wherever it is.
    let is_flat = (drawn.flags & FLAG_BILLBOARD) == 0u;
    let normal = select(shadows.towards_sun, select(drawn.plane.xyz, -drawn.plane.xyz, drawn.plane.w > 0.0), is_flat);
    let facing = dot(normal, shadows.towards_sun);
    if !(facing > 0.0) {
        return light;
    }
    var number = 0u;
    while number + 1u < shadows.count && depth > shadows.views[number].until {
        number += 1u;
    }
    let pixel = depth / min(frame.focal_x, frame.focal_y);
    let until = shadows.views[number].until;
    var left = left_in(number, p, normal, facing, pixel);
    let share = clamp((depth / until - 1.0 + TAKES_OVER) / TAKES_OVER, 0.0, 1.0);
    if number + 1u < shadows.count && share > 0.0 {
        left = mix(left, left_in(number + 1u, p, normal, facing, pixel), share);
    }
    return light * left;
}
