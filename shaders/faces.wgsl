// Pass faces: 1 + the index of the face that owns a pixel. Rust: gpu/renderer/passes.rs.

struct Owner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) face: u32,
}

@vertex
fn owner(corner: Corner) -> Owner {
    return Owner(clip_from_corner(corner, frame.reach), surfaces[corner.surface].face);
}

@fragment
fn faces(owner: Owner) -> @location(0) u32 {
    return owner.face + 1u;
}
