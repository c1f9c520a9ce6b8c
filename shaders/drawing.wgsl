// The vertex stage of every drawing pass, and the depth of its fragments.
// Rust: gpu/drawing.rs. This text is put between frame.wgsl and that of the pass.

struct Fragment {
    // Invariant: the same bits in every pass, so that every pass covers the same pixels.
    @builtin(position) @invariant position: vec4<f32>,
    @location(0) @interpolate(flat, either) item: u32,
    @location(1) @interpolate(flat, either) slope: vec3<f32>,
    @location(2) @interpolate(flat, either) anchor: vec2<f32>,
}

// `corner` is (x, y, w) in clip coordinates. With z = w / 2, the near and far planes both lie at w = 0:
// clipping is homogeneous, and there is no near distance.
@vertex
fn corner(@location(0) corner: vec3<f32>, @location(1) item: u32) -> Fragment {
    let plane = planes[item];
    var out: Fragment;
    out.position = vec4(corner.xy, 0.5 * corner.z, corner.z);
    out.item = item;
    out.slope = vec3(plane.a, plane.b, plane.c);
    out.anchor = vec2(plane.u0, plane.v0);
    return out;
}

// Inverse depth in the unit of the depth buffer; not positive where rounding at an outline carried the plane
// past its horizon, where the item is not drawn.
fn scaled_depth(fragment: Fragment) -> f32 {
    let centre = vec2(fragment.position.x, fragment.position.y + f32(frame.y0));
    return inverse_depth(fragment.slope, fragment.anchor, centre) * frame.depth_scale;
}

// The index of the fragment's pixel within the band.
fn pixel_of(fragment: Fragment) -> u32 {
    return u32(fragment.position.y) * frame.width + u32(fragment.position.x);
}
