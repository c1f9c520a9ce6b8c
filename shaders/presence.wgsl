// Pass presence: which items are nearest somewhere (`nearer` is the tie's), and where the others are hidden first.
// Rust: gpu/presence.rs.

struct Sighting {
    // Not 0 when some fragment of the item is nearest.
    visible: atomic<u32>,
    // Complement of the first pixel of the photo, in row order, where the item is hidden; 0: none.
    hidden: atomic<u32>,
}

@group(1) @binding(0) var nearest: texture_depth_2d;
@group(1) @binding(1) var<storage, read_write> sightings: array<Sighting>;

@fragment
fn presence(fragment: Fragment) {
    let depth = scaled_depth(fragment);
    if depth <= 0.0 {
        return;
    }
    let item = fragment.item;
    if is_behind(depth, textureLoad(nearest, vec2<u32>(fragment.position.xy), 0)) {
        // The plain reads keep nearly all fragments from the atomic writes.
        let pixel = ~(frame.y0 * frame.width + pixel_of(fragment));
        if atomicLoad(&sightings[item].hidden) < pixel {
            atomicMax(&sightings[item].hidden, pixel);
        }
    } else if atomicLoad(&sightings[item].visible) == 0u {
        atomicStore(&sightings[item].visible, 1u);
    }
}
