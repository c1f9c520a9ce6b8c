// Pass *flaked*: the samples that *flakes* found are lit, or give colours and numbers, with their depths: they hide faces, and faces
// hide them, sample by sample. Entry points as in plants.wgsl: `lit`, `plain`, `numbered` and `shadow`.
// Rust: gpu/renderer/plants/flaked.rs. Before this text: surfaces.wgsl, daylight.wgsl, flake.wgsl.

// 1 + the nearest sample of each sub-pixel, and the bits of its nearness.
@group(1) @binding(2) var<storage, read> kept: array<vec2u>;
// The trees in view.
@group(1) @binding(3) var<storage, read> shown: array<Shown>;
// The species whose samples are bound.
@group(2) @binding(1) var<uniform> species: vec4u;

// A triangle over the whole picture.
@vertex
fn everywhere(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4f(2.0 * corner - 1.0, 0.0, 1.0);
}

// What is kept at a sub-pixel; nothing where it is another species'.
struct Found {
    image: u32,
    sample: u32,
    depth: f32,
    is_any: bool,
}

// The last image before which there are no more samples than this.
fn image_of(number: u32) -> u32 {
    var low = 0u;
    var high = arrayLength(&images);
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if images[middle].before <= number {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn found_at(position: vec4f, sub_pixel: u32) -> Found {
    let pixel = vec2u(position.xy);
    var found: Found;
    if pixel.y < rows.first || pixel.y >= rows.first + rows.count {
        return found;
    }
    let it = kept[((pixel.y - rows.first) * rows.width + pixel.x) * SAMPLES + sub_pixel];
    if it.x == 0u {
        return found;
    }
    found.image = image_of(it.x - 1u);
    found.sample = images[found.image].first + (it.x - 1u - images[found.image].before);
    found.depth = min(frame.near * bitcast<f32>(it.y), 1.0);
    found.is_any = images[found.image].species == species.x;
    return found;
}

struct Colour {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
}

struct Number {
    @location(0) number: u32,
    @builtin(frag_depth) depth: f32,
}

fn linear(colour: vec3f) -> vec3f {
    return select(pow((colour + 0.055) / 1.055, vec3f(2.4)), colour / 12.92, colour <= vec3f(0.04045));
}

@fragment
fn lit(@builtin(position) position: vec4f, @builtin(sample_index) sub_pixel: u32) -> Colour {
    let found = found_at(position, sub_pixel);
    if !found.is_any {
        discard;
    }
    let image = images[found.image];
    let flake = flake_of(found.sample);
    let scaled = normal_in_view(image, flake);
    var normal = scaled * inverseSqrt(max(dot(scaled, scaled), 1e-37));
    let point = point_of(image, flake);
    if flake.is_leaf && dot(normal, point) > 0.0 {
        normal = -normal;
    }
    let reflected = linear(flake.colour);
    let reach = reach_at(shown[image.tree], point, normal);
    var light = vec3f(0.0);
    if flake.is_leaf {
        let viewer = normalize(-point);
        let spread = Spread(image.length, viewer, image.normal_right, image.normal_down, image.normal_forward);
        light = light_of_leaves(normal, spread, reflected, reflected * image.through, reach);
    } else {
        light = light_of(normal, reflected, vec3f(0.0), false, reach);
    }
    let tree = image.tree;
    light *= image.gain * shown[tree].tint * photographed(shown[tree].first_ratio, shown[tree].ratio_count, point);
    return Colour(vec4f(light * darkening(position.xy), 1.0), found.depth);
}

@fragment
fn plain(@builtin(position) position: vec4f, @builtin(sample_index) sub_pixel: u32) -> Colour {
    let found = found_at(position, sub_pixel);
    if !found.is_any {
        discard;
    }
    return Colour(shown[images[found.image].tree].plain, found.depth);
}

@fragment
fn numbered(@builtin(position) position: vec4f, @builtin(sample_index) sub_pixel: u32) -> Number {
    let found = found_at(position, sub_pixel);
    if !found.is_any {
        discard;
    }
    return Number(shown[images[found.image].tree].number, found.depth);
}

@fragment
fn shadow(@builtin(position) position: vec4f, @builtin(sample_index) sub_pixel: u32) -> @builtin(frag_depth) f32 {
    let pixel = vec2u(position.xy);
    if pixel.y < rows.first || pixel.y >= rows.first + rows.count {
        discard;
    }
    let it = kept[((pixel.y - rows.first) * rows.width + pixel.x) * SAMPLES + sub_pixel];
    if it.x == 0u {
        discard;
    }
    return min(frame.near * bitcast<f32>(it.y), 1.0);
}
