// Pass nearness: the depth buffer of the shot. Rust: gpu/renderer/passes.rs.

@vertex
fn nearness(corner: Corner) -> @invariant @builtin(position) vec4f {
    return clip_from_corner(corner, 1.0);
}
