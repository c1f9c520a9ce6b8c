// The data common to all passes: the rows being processed, and the items' planes.
// Rust: gpu/frame.rs. This text is put before every other one.

struct Frame {
    // Width of the photo in pixels.
    width: u32,
    // First row of the band, at which textures and per-pixel buffers begin.
    y0: u32,
    // Rows of the photo that this run of the pass processes: [row, row_end).
    row: u32,
    row_end: u32,
    // Index, among the whole band's entries, of the first entry in the buffer.
    first_entry: u32,
    // 1 + tolerance.
    nearer: f32,
    // A power of two that scales inverse depths into 0..1.
    depth_scale: f32,
    // Always 0, which the compiler cannot know.
    zero: u32,
}

// The inverse depth of an item over the image: (a (x - u0) + b (y - v0)) + c.
struct Plane {
    a: f32,
    b: f32,
    c: f32,
    u0: f32,
    v0: f32,
    // The item's index in the working set.
    number: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> planes: array<Plane>;

// The bit of an entry that marks the item as visible: no item at this pixel is nearer by more than the
// tolerance.
const VISIBLE: u32 = 0x80000000u;

// Prevents that a product becomes part of a fused multiply-add, which would round differently on some
// devices: its bits pass through an integer operation whose result the compiler cannot predict.
fn rounded(product: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(product) ^ frame.zero);
}

// `slope` is (a, b, c), `anchor` is (u0, v0), `centre` is the pixel centre in the photo.
fn inverse_depth(slope: vec3<f32>, anchor: vec2<f32>, centre: vec2<f32>) -> f32 {
    let d = centre - anchor;
    return (rounded(slope.x * d.x) + rounded(slope.y * d.y)) + slope.z;
}

// Compares inverse depths, or both multiplied with the same power of two.
fn is_behind(back: f32, front: f32) -> bool {
    return rounded(back * frame.nearer) < front;
}
