// Pass presence: finds the items that are nearest somewhere, and the first pixel at which each of the others
// is hidden. In this pass `frame.nearer` is 1 + the tie's tolerance (TIE of layers/rasteriser.rs), not that
// of occlusion.
// Rust: gpu/presence.rs.

struct Sighting {
    // Nonzero when some fragment of the item is nearest.
    visible: atomic<u32>,
    // The complement of the index of the first pixel of the photo, in row order, at which the item is hidden;
    // 0 when there is none.
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
        // The plain reads avoid the atomic writes for nearly all fragments.
        let pixel = ~(frame.y0 * frame.width + pixel_of(fragment));
        if atomicLoad(&sightings[item].hidden) < pixel {
            atomicMax(&sightings[item].hidden, pixel);
        }
    } else if atomicLoad(&sightings[item].visible) == 0u {
        atomicStore(&sightings[item].visible, 1u);
    }
}
