// The light on trees, and what a surface makes of it.
// Rust: gpu/renderer/plants/daylight.rs. Before this text: surfaces.wgsl.
// CPU reference: foliage/shade.rs.

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

@group(3) @binding(0) var<uniform> daylight: Daylight;

// What sky and ground give to a surface of this normal.
fn around(normal: vec3f) -> vec3f {
    let up = dot(normal, daylight.up);
    return daylight.sky * (0.5 * (1.0 + up)) + daylight.ground * (0.5 * (1.0 - up));
}

// The light of a surface with a normal of length 1: of leaves the one that looks to the viewer.
fn light_of(normal: vec3f, reflected: vec3f, through: vec3f, is_leaf: bool) -> vec3f {
    let facing = dot(normal, daylight.towards_sun);
    var light = reflected * (daylight.sun * max(facing, 0.0) + around(normal));
    if is_leaf {
        light += through * (daylight.sun * max(-facing, 0.0) + around(-normal));
    }
    return light;
}

// The darkening of a pixel by the view's lens.
fn darkening(px: vec2f) -> f32 {
    let from_axis = px - frame.center;
    let t2 = min(dot(from_axis, from_axis) / (frame.focal_x * frame.focal_y), frame.widest);
    return exp((frame.falloff.x + frame.falloff.y * t2) * t2);
}
