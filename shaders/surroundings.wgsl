// Pass surroundings: draws the surroundings where no face is. It follows project.wgsl, whose photos, candidates, texels
// and light it uses.
// Rust: gpu/renderer/project.rs (pipelines).

// The penalty of the dome, in every direction (PENALTY of projection/dome.rs).
const DOME_PENALTY: f32 = 2.0;

// The share of the view's reach over which photos fade (FADING of projection/surroundings.rs).
const REACH_FADING: f32 = 0.2;

// The cells of a photo's factors along both sides (GRID of projection/exposure/surroundings.rs), and the number of photos in a row of
// `sky_factors` (gpu/renderer/sky.rs).
const SKY_GRID: u32 = 32u;
const SKY_COLUMNS: u32 = 64u;

// The factors that bring what a photo shows at a position to the sky of the view; those of the dome are in its gain.
fn to_one_sky(photo: Photo, px: vec2f, is_dome: bool) -> vec3f {
    if photo.sky == 0u {
        return select(frame.of_sky, vec3f(1.0), is_dome);
    }
    let grid = f32(SKY_GRID);
    let number = photo.sky - 1u;
    let corner = vec2f(vec2u(number % SKY_COLUMNS, number / SKY_COLUMNS) * SKY_GRID);
    let cell = clamp(px / photo.size * grid, vec2f(0.5), vec2f(grid - 0.5)) + corner;
    let logs = textureSampleLevel(sky_factors, bilinear, cell / vec2f(textureDimensions(sky_factors)), 0.0).rgb;
    return frame.of_sky * exp(logs);
}

struct Behind {
    @builtin(position) position: vec4f,
}

// A triangle over the whole view, behind all faces.
@vertex
fn behind(@builtin(vertex_index) index: u32) -> Behind {
    let at = vec2f(f32((index << 1u) & 2u), f32(index & 2u)) * 2.0 - 1.0;
    return Behind(vec4f(at, 0.0, 1.0));
}

// The surroundings, where no face is.
@fragment
fn surroundings(behind: Behind) -> @location(0) vec4f {
    return around_at(behind.position.xy);
}

// What the photos show of the surroundings in a pixel: at infinite depth, so that a direction decides. The dome is one more server,
// everywhere. CPU reference: projection/surroundings.rs.
fn around_at(position: vec2f) -> vec4f {
    let ray = ray_through(position);
    let ray_x = frame.right / frame.focal_x;
    let ray_y = frame.down / frame.focal_y;
    let lens = lens_at(position);
    let cell = vec2u(position) / frame.cell_px;
    let range = frame.surroundings_first + cell.y * frame.surroundings_columns + cell.x;
    var best = no_best();
    var most_confident = 0.0;
    var served = 0.0;
    var at = cells[range];
    let end = cells[range + 1u];
    loop {
        if at >= end {
            break;
        }
        let candidate = candidates[at];
        if bitcast<f32>(candidate.x) >= next_of(best) && !COUNTS_ALL {
            break;
        }
        let photo = photos[candidate.y & 0xffffu];
        let z = dot(photo.row_z.xyz, ray);
        let px = vec2f(dot(photo.row_x.xyz, ray), dot(photo.row_y.xyz, ray)) / z;
        var inside = z > 0.0;
        let sides = (candidate.y >> SIDES_SHIFT) & SIDES_MASK;
        for (var side = 1u; side <= sides; side += 1u) {
            let half_plane = bitcast<vec4f>(candidates[at + side]);
            inside = inside && dot(half_plane.xy, px) >= half_plane.z;
        }
        at += 1u + sides;
        let edge = min(min(px.x, photo.size.x - px.x), min(px.y, photo.size.y - px.y));
        let border = border_ramp(edge * photo.per_border);
        // Pixels per radian grow by cos^-1.5 of the angle to the axis; the ray has a depth of 1 in the view.
        let octaves = 0.5 * log2(frame.density * z * z * z / photo.density);
        let corner = vec2f(f32(i32(candidate.w << 16u) >> 16u), f32(i32(candidate.w) >> 16u));
        let log_size = vec2u((candidate.y >> 16u) & 15u, (candidate.y >> 20u) & 15u);
        let place = TexturePlacement(candidate.z, corner, log_size);
        let texel = texture_texel(place, photo, px, z, octaves, ray_x, ray_y);
        let within = all(px > corner - 0.5) && all(px < corner + vec2f(vec2u(1u) << log_size) + 0.5);
        if inside && within && border > 0.0 && texel.confidence > 0.002 {
            let agreement = agreement_at(candidate.z, px);
            let is_dome = (candidate.y & 0xffffu) >= frame.dome_first;
            let distance = length(photo.center);
            let nearness = clamp((1.0 - distance / frame.surroundings_reach) / REACH_FADING, 1e-12, 1.0);
            var q = select(distance * frame.per_surroundings_scale / nearness, DOME_PENALTY, is_dome);
            if MODE != DEBEVEC && !is_dome {
                q += frame.lambda * max(octaves, 0.0);
            }
            if AGREEMENT_WEIGHS {
                q = q / agreement + frame.transient_angle * (1.0 - agreement);
            }
            q += LEAST_ANGLE;
            if MODE != DEBEVEC {
                q /= border * texel.confidence;
            }
            q *= photo.leaning;
            served += 1.0;
            most_confident = max(most_confident, texel.confidence);
            let exposed = undone(texel, photo, px) * (lens * photo.gain);
            let light = mix(kept_white(texel, exposed), exposed * to_one_sky(photo, px, is_dome), photo.sky_share);
            let color = display_color(light, candidate, octaves, agreement);
            best = join(best, q, shade(color, 1.0));
        }
    }
    return finished(mixed(best, across_stripe(position)), 1.0, served, most_confident, 0u);
}
