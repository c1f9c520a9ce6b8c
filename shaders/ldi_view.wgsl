// What all passes of the warp of layered depth images share: the view, the depth pixels, and the picture's rows.
// Rust: gpu/ldi/view.rs. This text is put before every pass's; before it: the types Depth and Sum, atomic ones where a pass
// writes from many depth pixels.

struct View {
    // The change of the homogeneous position from one column of the frame to the next.
    step: vec3f,
    // Always 0, which the compiler cannot know.
    zero: u32,
    // Its change with the inverse depth.
    depth: vec3f,
    // Runs in a row of the frame.
    runs: u32,
    // Half the picture's sides, and the sides, in pixels.
    half: vec2f,
    size: vec2u,
    // The rows of the picture that are drawn, [x, y), and the depth pixels that can be on them.
    rows: vec2u,
    within: vec2u,
}

// A surface in the view.
struct Surface {
    // The factor of the spacing, negative where the surface is not drawn.
    factor: f32,
    // How much its inverse depth changes from pixel to pixel of the picture.
    slope: f32,
    // The same along u and v, 0 where that is unlimited.
    gradient: vec2f,
    // The columns x and y of its plane's map, by rows u, v and omega; u and v from the picture's centre. All zeros where the plane
    // is unknown.
    of_u: vec2f,
    of_v: vec2f,
    of_omega: vec2f,
}

@group(0) @binding(0) var<uniform> view: View;
// By row and run of the frame, the homogeneous position of the first column at inverse depth 0.
@group(0) @binding(1) var<storage, read> starts: array<vec4f>;
// By number.
@group(0) @binding(2) var<storage, read> surfaces: array<Surface>;
// By stored value, R, G, B: linear light for sums, the value itself for single pixels, at the picture's exposure.
@group(0) @binding(3) var<storage, read> exposed: array<u32>;

// A part of the level. x: the index of its first depth pixel.
@group(1) @binding(0) var<uniform> part: vec4u;
// x: column, and row from bit 16 on; y: inverse depth; z: sRGB and opacity from bit 0 on; w: surface.
@group(1) @binding(1) var<storage, read> pixels: array<vec4u>;

// What passes find at each pixel of the rows that are drawn: see the passes.
@group(2) @binding(0) var<storage, read_write> depths: array<Depth>;
@group(2) @binding(1) var<storage, read_write> sums: array<Sum>;
// The picture's rows: sRGB and opacity, R in the lowest byte.
@group(2) @binding(2) var<storage, read_write> picture: array<u32>;

fn opacity_of(colour: u32) -> f32 {
    return f32(colour >> 24u) / 255.0;
}

// Returns the index of a pixel of the picture among the rows that are drawn.
fn index_of(x: u32, y: u32) -> u32 {
    return (y - view.rows.x) * view.size.x + x;
}

// Returns the number of pixels of the rows that are drawn.
fn pixel_count() -> u32 {
    return (view.rows.y - view.rows.x) * view.size.x;
}
