// Pass project: projects the photos' layer textures onto the model and blends them for the viewpoint.
// Rust: gpu/renderer/project.rs (pipelines, declaration of the photos), gpu/renderer/program.rs (generated
// text), gpu/renderer/tables.rs (tables).
//
// Generated before this text: the constants MODE and BEST, DEBEVEC, LUMIGRAPH, SMOOTH, ANISOTROPIC,
// MOST_TAPS, COUNTS_ALL, STORED, UNDOES_OPTICS, PINS, IMPOSTORS, AGREEMENT, MATTES, OUTLINES, SEE_THROUGH, CUT_OUT and UNSERVED; `Shade`, a
// colour, for see-through surfaces one that is multiplied by its matte, with the matte, with `shade`; `struct Best`, which keeps the
// k best penalties with their shades and the next penalty, with `no_best`, `is_any`, `next_of`, `join`, `fewer`,
// `blended` and `covered`; and the functions of the display mode, `mixed`, `mixed_with`, `display_color` and `finished`, with
// `palette` and `ramp`. Then `darkened`: shadows.wgsl, or the light as it is.

struct Photo {
    // Rows that give photo pixels (times depth) and depth, from positions relative to the viewpoint.
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    // The camera's centre relative to the viewpoint, and fx * fy.
    center: vec3f,
    density: f32,
    // The size in pixels, 1 over the width of the border ramp, and the offset, light added everywhere.
    size: vec2f,
    per_border: f32,
    offset: f32,
    // The exposure factor on the photo's linear colours, and how far the view has left the photo's own camera, 0 to 1.
    gain: vec3f,
    left: f32,
    // The principal point, and the coefficients of the falloff, the logarithm of the light: for the squared
    // distance in pixels, and for its square.
    axis: vec2f,
    falloff: vec2f,
    // The factor of the photo's penalties, 1 where the view leans to its group of light, and the number of that group.
    leaning: f32,
    group: u32,
    // The place of its factors to one sky in `sky_factors`, one more than its number there, 0 without any; and how far they are in
    // effect.
    sky: u32,
    sky_share: f32,
}

@group(0) @binding(3) var<PHOTO_SPACE> photos: array<Photo, PHOTO_COUNT>;
// The index at which each cell's candidates begin, and one more.
@group(0) @binding(4) var<storage, read> cells: array<u32>;
// x: lower bound of the penalty; y: photo, log2 of the layer texture's sides, flags; z: the layer texture; w: its corner. The
// candidate's half planes follow, if it has any: normal and offset. After all candidates: the factors of groups of light on faces.
@group(0) @binding(5) var<storage, read> candidates: array<vec4u>;

// The factor that brings photos of a group of light to the light of the view on a face.
fn light_on(face: u32, group: u32) -> vec3f {
    if frame.light_groups == 0u {
        return vec3f(1.0);
    }
    return bitcast<vec4f>(candidates[frame.light_first + face * frame.light_groups + group]).rgb;
}

const FLAG_BACK: u32 = 1u << 24u;
const SIDES_SHIFT: u32 = 25u;
const SIDES_MASK: u32 = 63u;
const FLAG_PINNED: u32 = 1u << 31u;

// The heights of faces over their planes, in world units: the relief, packed into one texture.
@group(0) @binding(6) var heights: texture_2d<f32>;
@group(0) @binding(7) var<storage, read> grids: array<FaceGrids>;
// The colours with which faces continue where no photo shows them, in the common exposure, packed into one texture.
@group(0) @binding(11) var continued_colors: texture_2d<f32>;
// The factors that bring photos' surroundings to one sky, as logarithms: a square of SKY_GRID x SKY_GRID cells for each photo that has
// some, in rows of SKY_COLUMNS.
@group(0) @binding(12) var sky_factors: texture_2d<f32>;

// The grids in the plane of a face: that of its relief, in `heights`, and that of its colours, in `continued_colors`.
struct FaceGrids {
    relief: FaceGrid,
    continued: FaceGrid,
}

// A grid in the plane of a face: the mapping from positions relative to the site's origin to cells (rows: direction,
// and offset as a sum of two f32), and its position in the texture. A width of 0 means that the face has none.
struct FaceGrid {
    across: vec3f,
    across_high: f32,
    up: vec3f,
    up_high: f32,
    across_low: f32,
    up_low: f32,
    corner: vec2f,
    size: vec2f,
    pad0: vec2f,
}

// The agreement of image layers with other photos, and what of their texels shows their faces rather than the sky within outlines,
// packed into one texture. Places of all agreements precede those of all outlines.
@group(0) @binding(8) var agreements: texture_2d<f32>;
@group(0) @binding(9) var<storage, read> agreement_places: array<AgreementPlace>;

// The grid of an image layer's agreement: cells per photo pixel, the first cell of the photo, the number of columns and
// rows, and the position in `agreements`. A width of 0 means that the agreement is 1 throughout.
struct AgreementPlace {
    cells_per_px: vec2f,
    origin: vec2f,
    size: vec2f,
    corner: vec2f,
}

// The least cosine of the angle to the normal that is used; points of faces seen more edge-on are not moved
// farther.
const LEAST_FACING: f32 = 0.1;

// The least matte at which something of a see-through surface is there (projection/sources.rs).
const LEAST_MATTE: f32 = 0.03125;

// The matte from which on nothing is seen through a surface: half a step of 8 bits less than 1.
const WHOLE: f32 = 0.998;

// The darkest channel of stored linear light from where on a colour begins to count as clipped, and where it is for certain.
const WHITE_FROM: f32 = 0.88;
const WHITE_CERTAIN: f32 = 0.97;

// The width of the stripes that show weights, in pixels: wide enough to show an eighth, narrow enough for small faces.
const STRIPE_PX: f32 = 8.0;

struct Drawn {
    @builtin(position) position: vec4f,
    // The plane: its normal, and its distance from the viewpoint along the normal.
    @location(0) @interpolate(flat) plane: vec4f,
    // Index of the face, and its cells' corner, size and first range.
    @location(1) @interpolate(flat) cells: vec4u,
    @location(2) @interpolate(flat) flags: u32,
    // The mapping from positions relative to the viewpoint to cells of the relief, and its corner and size.
    @location(3) @interpolate(flat) across: vec4f,
    @location(4) @interpolate(flat) up: vec4f,
    @location(5) @interpolate(flat) relief: vec4f,
    // Index of the surface.
    @location(6) @interpolate(flat) surface: u32,
}

@vertex
fn drawn(corner: Corner) -> Drawn {
    return drawn_with(corner, 0.0);
}

@vertex
fn peeled_drawn(corner: Corner) -> Drawn {
    return drawn_with(corner, frame.reach);
}

fn drawn_with(corner: Corner, reach_of_skirts: f32) -> Drawn {
    let surface = surfaces[corner.surface];
    let of_face = face_cells[surface.face];
    let relief = grids[surface.face].relief;
    return Drawn(
        clip_from_corner(corner, frame.reach, reach_of_skirts),
        vec4f(surface.normal, distance_to_plane(surface)),
        vec4u(surface.face, of_face.corner, of_face.size, of_face.first),
        surface.flags,
        vec4f(relief.across, cells_at_eye(relief.across, relief.across_high, relief.across_low)),
        vec4f(relief.up, cells_at_eye(relief.up, relief.up_high, relief.up_low)),
        // Skirts are flat.
        vec4f(relief.corner, select(relief.size * frame.relief, vec2f(0.0), (surface.flags & FLAG_SKIRT) != 0u)),
        corner.surface,
    );
}

fn cells_at_eye(direction: vec3f, high: f32, low: f32) -> f32 {
    return (dot(direction, frame.eye_high) + high) + (dot(direction, frame.eye_low) + low);
}

// The height over the face's plane at a position relative to the viewpoint.
fn height_at(drawn: Drawn, p: vec3f) -> f32 {
    let cell = vec2f(dot(drawn.across.xyz, p) + drawn.across.w, dot(drawn.up.xyz, p) + drawn.up.w);
    let at = clamp(cell, vec2f(0.5), drawn.relief.zw - 0.5) + drawn.relief.xy;
    return textureSampleLevel(heights, bilinear, at / vec2f(textureDimensions(heights)), 0.0).x;
}

// The colour with which a face continues at a position relative to the viewpoint, and 1; 0 where it does not
// (projection/continuation.rs).
fn continued_at(face: u32, p: vec3f) -> vec4f {
    let grid = grids[face].continued;
    if frame.continues == 0u || grid.size.x == 0.0 {
        return vec4f(0.0);
    }
    let cell = vec2f(
        dot(grid.across, p) + cells_at_eye(grid.across, grid.across_high, grid.across_low),
        dot(grid.up, p) + cells_at_eye(grid.up, grid.up_high, grid.up_low),
    );
    let at = clamp(cell, vec2f(0.5), grid.size - 0.5) + grid.corner;
    let light = textureSampleLevel(continued_colors, bilinear, at / vec2f(textureDimensions(continued_colors)), 0.0).rgb;
    return vec4f(continued_color(light * frame.of_common), 1.0);
}

// The direction in which the view looks at a position relative to the viewpoint, of any length.
fn view_direction(p: vec3f) -> vec3f {
    if frame.parallel != 0u {
        return frame.forward;
    }
    return p;
}

// Intersects the ray through a point of the plane with the relief: two steps of a fixed-point iteration. The
// point stays on its ray, so that a photo's own camera sees the photo's own pixels whatever the relief.
fn on_relief(drawn: Drawn, p: vec3f) -> vec3f {
    let ray = normalize(view_direction(p));
    let facing = dot(drawn.plane.xyz, ray);
    let slope = select(-1.0, 1.0, facing >= 0.0) * max(abs(facing), LEAST_FACING);
    let near = p + ray * (height_at(drawn, p) / slope);
    return p + ray * (height_at(drawn, near) / slope);
}

// Looks up the agreement of an image layer's texel at a photo position (AgreementGrid::at of view/agreement.rs).
fn agreement_at(layer_texture: u32, px: vec2f) -> f32 {
    if !AGREEMENT {
        return 1.0;
    }
    return value_at(agreement_places[layer_texture], px);
}

// Looks up how much of an image layer's texel at a photo position shows its face, as far as the view has left the photo's camera.
fn outline_at(layer_texture: u32, px: vec2f, left: f32) -> f32 {
    if !OUTLINES {
        return 1.0;
    }
    return mix(1.0, value_at(agreement_places[arrayLength(&agreement_places) / 2u + layer_texture], px), left);
}

fn value_at(place: AgreementPlace, px: vec2f) -> f32 {
    if place.size.x == 0.0 {
        return 1.0;
    }
    let cell = clamp(px * place.cells_per_px - place.origin, vec2f(0.5), place.size - 0.5) + place.corner;
    return textureSampleLevel(agreements, bilinear, cell / vec2f(textureDimensions(agreements)), 0.0).x;
}

// A filtered texel: its light, times the matte for see-through surfaces; the matte, 1 for others; the confidence.
struct Texel {
    light: vec3f,
    matte: f32,
    confidence: f32,
}

// Looks up the layer texture's texel at a photo position.
fn texture_texel(place: TexturePlacement, photo: Photo, px: vec2f, z: f32, octaves: f32, dx: vec3f, dy: vec3f) -> Texel {
    var matte = NOTHING;
    if MATTES {
        matte = matte_texture(place.layer_texture);
    }
    let at = px - place.corner;
    var texel = Texel(vec3f(0.0), 1.0, 0.0);
    if ANISOTROPIC {
        texel = anisotropic(place, matte, photo, at, px, z, dx, dy);
    } else {
        // Level 0 alone is used up to a footprint of 1.1 texels.
        texel = texel_and_matte(place, matte, at, max(0.0, -octaves - 0.1375));
    }
    if MATTES && !SEE_THROUGH {
        // Where an outline crosses a filter, the surface has the colour of what is there of it.
        return Texel(texel.light / max(texel.matte, 1e-3), 1.0, texel.confidence);
    }
    return texel;
}

fn texel_and_matte(place: TexturePlacement, matte: u32, at: vec2f, level: f32) -> Texel {
    let texel = texel_at(place, at, level);
    if !MATTES || matte == NOTHING {
        return Texel(texel.rgb, 1.0, texel.w);
    }
    return Texel(texel.rgb, matte_at(TexturePlacement(matte, place.corner, place.log_size), at, level), texel.w);
}

// Averages taps along the footprint's longer axis; each is as wide as the shorter axis.
fn anisotropic(place: TexturePlacement, matte: u32, photo: Photo, at: vec2f, px: vec2f, z: f32, dx: vec3f, dy: vec3f) -> Texel {
    let a = (vec2f(dot(photo.row_x.xyz, dx), dot(photo.row_y.xyz, dx)) - px * dot(photo.row_z.xyz, dx)) / z;
    let b = (vec2f(dot(photo.row_x.xyz, dy), dot(photo.row_y.xyz, dy)) - px * dot(photo.row_z.xyz, dy)) / z;
    // Axes of the ellipse that (a, b) makes of the unit circle.
    let sum = 0.5 * (dot(a, a) + dot(b, b));
    let difference = 0.5 * (dot(a, a) - dot(b, b));
    let mixed = dot(a, b);
    let root = sqrt(difference * difference + mixed * mixed);
    let longer = sqrt(sum + root);
    let shorter = max(sqrt(max(sum - root, 0.0)), longer / MOST_TAPS);
    let angle = 0.5 * atan2(mixed, difference);
    let axis = a * cos(angle) + b * sin(angle);
    let taps = select(clamp(ceil(longer / max(shorter, 1.0) - 0.1), 1.0, MOST_TAPS), 1.0, longer < 1.1);
    let level = max(0.0, log2(max(shorter, longer / MOST_TAPS)) - 0.1375);
    // Outside of what a photo shows there is no valid colour, so taps are weighted by their confidence.
    var color = vec3f(0.0);
    var covered = 0.0;
    var confidence = 0.0;
    for (var tap = 0.0; tap < taps; tap += 1.0) {
        let texel = texel_and_matte(place, matte, at + axis * ((tap + 0.5) / taps - 0.5), level);
        let trust = max(texel.confidence, 0.0);
        color += texel.light * trust;
        covered += texel.matte * trust;
        confidence += trust;
    }
    let all = max(confidence, 1e-6);
    return Texel(color / all, select(1.0, covered / all, MATTES), confidence / taps);
}

// Removes offset and falloff of the photo's camera from light (Optics::undone of
// view/optics.rs).
fn undone(texel: Texel, photo: Photo, px: vec2f) -> vec3f {
    if !UNDOES_OPTICS {
        return texel.light;
    }
    let from_axis = px - photo.axis;
    let r2 = dot(from_axis, from_axis);
    // Light that is multiplied by a matte has as much less of the offset.
    let almost_black = min(texel.light, vec3f(1.5e-4 * texel.matte));
    let without = max(texel.light - photo.offset * texel.matte, almost_black);
    return without * exp(-(photo.falloff.x + photo.falloff.y * r2) * r2);
}

// The light that a view shows of a texel, `exposed` from `stored`: what is stored as white, which was at least as bright, stays so
// (projection/exposure/white.rs).
fn kept_white(stored: Texel, exposed: vec3f) -> vec3f {
    let darkest = min(min(stored.light.r, stored.light.g), stored.light.b) / max(stored.matte, 1e-3);
    return exposed + smoothstep(WHITE_FROM, WHITE_CERTAIN, darkest) * max(stored.light - exposed, vec3f(0.0));
}

// The factor by which the view's lens darkens a pixel (ViewLens::factor of view/optics.rs).
fn lens_at(px: vec2f) -> f32 {
    if !UNDOES_OPTICS {
        return 1.0;
    }
    let from_axis = px - frame.center;
    let t2 = min(dot(from_axis, from_axis) / (frame.focal_x * frame.focal_y), frame.widest);
    return exp((frame.falloff.x + frame.falloff.y * t2) * t2);
}

// The place of a pixel across its diagonal stripe, 0 to 1. It goes by the principal point, so that the bands of a
// picture continue one another.
fn across_stripe(px: vec2f) -> f32 {
    let along = px - frame.center;
    return fract((along.x + along.y) / STRIPE_PX);
}

// A point of a face as a photo sees it, and its movement for a step of one pixel of the view.
struct Place {
    p: vec3f,
    dx: vec3f,
    dy: vec3f,
    // The distance of the camera from the plane that the photo sees.
    height: f32,
    // The direction from which the photo sees the point, as the view has it.
    towards: vec3f,
}

// The angle that is added where an impostor shows the mirror image of a photo.
const MIRRORED: f32 = 0.5;

// What the mirror image of a photo counts for where photos are counted: next to nothing, but more than none.
const MIRROR_SERVES: f32 = 1e-3;

// The distance of a camera from the axis, in half widths, below which it has no side of its own.
const ON_AXIS: f32 = 1e-3;

// Takes a point of the rectangle that faces the viewpoint to the one that faces the photo (projection/turned.rs).
fn place_of(drawn: Drawn, at: Place, photo: Photo, mirrored: bool) -> Place {
    let surface = surfaces[drawn.surface];
    let foot = (surface.foot_high - frame.eye_high) + (surface.foot_low - frame.eye_low);
    let across = cross(surface.axis, drawn.plane.xyz);
    let center = photo.center - foot;
    var own = cross(surface.axis, center);
    if length(own) < ON_AXIS * surface.half_width {
        let right = photo.row_x.xyz - photo.axis.x * photo.row_z.xyz;
        own = right - surface.axis * dot(surface.axis, right);
    }
    own = normalize(own);
    let shift = select(own, -own, mirrored) - across;
    let p = at.p + dot(at.p - foot, across) * shift;
    // The camera on the other side sees the mirror image.
    let other = foot + 2.0 * dot(center, surface.axis) * surface.axis - center;
    return Place(
        p,
        at.dx + dot(at.dx, across) * shift,
        at.dy + dot(at.dy, across) * shift,
        abs(dot(cross(own, surface.axis), center)),
        select(photo.center, other, mirrored) - p,
    );
}

@fragment
fn project(drawn: Drawn) -> @location(0) vec4f {
    return shown(drawn);
}

// What the photos show of a surface of the layer that is peeled off next.
@fragment
fn peeled(drawn: Drawn) -> @location(0) vec4f {
    if is_peeled(drawn.position, frame.reach) {
        discard;
    }
    return shown(drawn);
}

// The face of a see-through surface, where something of it is there (faces that are seen, Renders::seen_faces of
// projection/renders.rs). It is drawn with the program of DisplayMode::Matte, whose alpha is the matte.
@fragment
fn seen(drawn: Drawn) -> @location(0) u32 {
    if shown(drawn).a < LEAST_MATTE {
        discard;
    }
    return drawn.cells.x + 1u;
}

// What the photos show of a surface in a pixel.
fn shown(drawn: Drawn) -> vec4f {
    let ray = ray_through(drawn.position.xy);
    let normal = drawn.plane.xyz;
    let facing = dot(normal, ray);
    let is_parallel = frame.parallel != 0u;
    let start = start_of_ray(drawn.position.xy);
    let depth = (drawn.plane.w - dot(normal, start)) / facing;
    let on_plane = start + ray * depth;
    // The movement of the point on the plane for a step of one pixel.
    let ray_x = frame.right / frame.focal_x;
    let ray_y = frame.down / frame.focal_y;
    let spread = select(depth, 1.0, is_parallel);
    let dx = spread * (ray_x - ray * (dot(normal, ray_x) / facing));
    let dy = spread * (ray_y - ray * (dot(normal, ray_y) / facing));
    // Pixels of the view per area of the surface.
    var in_view = frame.density * abs(drawn.plane.w) / (depth * depth * depth);
    if is_parallel {
        in_view = frame.density * abs(facing);
    }
    let seen_from_behind = is_seen_from_behind(normal, drawn.plane.w);

    let lens = lens_at(drawn.position.xy);
    var best = no_best();
    // For the photo that the face is pinned to: the sum of colours times trust, and of trust; below, the
    // largest trust.
    var pinned = vec4f(0.0);
    var pinned_cover = 0.0;
    var pinned_share = 0.0;
    var most_confident = 0.0;
    var served = 0.0;
    var at = 0u;
    var end = 0u;
    let extent = vec2u(drawn.cells.z & 0xffffu, drawn.cells.z >> 16u);
    // A pixel that a face covers partly may have its centre outside of the face's cells.
    let corner_cell = vec2i(vec2u(drawn.cells.y & 0xffffu, drawn.cells.y >> 16u));
    let column_row = vec2i(drawn.position.xy) / i32(frame.cell_px) - corner_cell;
    let cell = vec2u(clamp(column_row, vec2i(0), vec2i(max(extent, vec2u(1u))) - 1));
    if (depth > 0.0 || is_parallel) && extent.x > 0u {
        let range = drawn.cells.w + cell.y * extent.x + cell.x;
        at = cells[range];
        end = cells[range + 1u];
    }
    let begin = at;
    var p = on_plane;
    if drawn.relief.z > 0.0 {
        p = on_relief(drawn, on_plane);
    }
    var again = drawn.relief.z > 0.0;
    loop {
        // Where no photo shows the point on the relief, one may show the point on the plane.
        if at >= end && again && served == 0.0 {
            again = false;
            p = on_plane;
            at = begin;
        }
        if at >= end {
            break;
        }
        let candidate = candidates[at];
        if bitcast<f32>(candidate.x) >= next_of(best) && !COUNTS_ALL {
            break;
        }
        let photo = photos[candidate.y & 0xffffu];
        let other_side = ((candidate.y & FLAG_BACK) != 0u) != seen_from_behind;
        var seen = Place(p, dx, dy, abs(dot(normal, photo.center) - drawn.plane.w), photo.center - p);
        var apart = OTHER_SIDE;
        if IMPOSTORS && (drawn.flags & FLAG_IMPOSTOR) != 0u {
            seen = place_of(drawn, seen, photo, other_side);
            apart = MIRRORED;
        }
        let z = dot(photo.row_z.xyz, seen.p) + photo.row_z.w;
        let px = vec2f(
            dot(photo.row_x.xyz, seen.p) + photo.row_x.w,
            dot(photo.row_y.xyz, seen.p) + photo.row_y.w,
        ) / z;
        var inside = z > 0.0;
        let sides = (candidate.y >> SIDES_SHIFT) & SIDES_MASK;
        for (var side = 1u; side <= sides; side += 1u) {
            let half_plane = bitcast<vec4f>(candidates[at + side]);
            inside = inside && dot(half_plane.xy, px) >= half_plane.z;
        }
        at += 1u + sides;
        inside = inside && (!other_side || (drawn.flags & FLAG_BILLBOARD) != 0u);
        let edge = min(min(px.x, photo.size.x - px.x), min(px.y, photo.size.y - px.y));
        let border = border_ramp(edge * photo.per_border);
        let in_photo = photo.density * seen.height / (z * z * z);
        let octaves = 0.5 * log2(in_view / in_photo);
        let corner = vec2f(f32(i32(candidate.w << 16u) >> 16u), f32(i32(candidate.w) >> 16u));
        let log_size = vec2u((candidate.y >> 16u) & 15u, (candidate.y >> 20u) & 15u);
        let place = TexturePlacement(candidate.z, corner, log_size);
        let texel = texture_texel(place, photo, px, z, octaves, seen.dx, seen.dy);
        let within = all(px > corner - 0.5) && all(px < corner + vec2f(vec2u(1u) << log_size) + 0.5);
        let trust = border * texel.confidence;
        // Half a step of 8 bits; a smaller confidence counts as 0.
        if inside && within && border > 0.0 && texel.confidence > 0.002 {
            let agreement = agreement_at(candidate.z, px);
            var q = angle_between(seen.towards, -view_direction(p)) + select(0.0, apart, other_side);
            if MODE != DEBEVEC {
                q += frame.lambda * max(octaves, 0.0);
            }
            if AGREEMENT_WEIGHS {
                q = q / agreement + frame.transient_angle * (1.0 - agreement);
            }
            q += LEAST_ANGLE;
            if MODE != DEBEVEC {
                q /= trust;
            }
            q *= photo.leaning;
            served += select(1.0, MIRROR_SERVES, other_side && apart == MIRRORED);
            most_confident = max(most_confident, texel.confidence);
            let exposed = undone(texel, photo, px) * (lens * photo.gain) * light_on(drawn.cells.x, photo.group);
            let light = kept_white(texel, exposed);
            let outline = outline_at(candidate.z, px, photo.left);
            let color = outline * display_color(light, candidate, octaves, agreement);
            if PINS && !other_side && (candidate.y & FLAG_PINNED) != 0u {
                pinned += vec4f(color * trust, trust);
                pinned_cover += outline * texel.matte * trust;
                pinned_share = max(pinned_share, trust);
            } else {
                best = join(best, q, shade(color, outline * texel.matte));
            }
        }
    }
    if IMPOSTORS && (drawn.flags & FLAG_IMPOSTOR) != 0u {
        best = fewer(best);
    }
    let place = across_stripe(drawn.position.xy);
    var color = mixed(best, place);
    var matte = covered(best);
    if PINS && pinned.w > 0.0 {
        let share = select(1.0, pinned_share, is_any(best));
        color = mixed_with(color, pinned.rgb / pinned.w, share, place);
        matte = mix(matte, pinned_cover / pinned.w, share);
    }
    if CUT_OUT && (served == 0.0 || matte < 0.5) {
        discard;
    }
    if CONTINUES && served == 0.0 {
        let continued = continued_at(drawn.cells.x, on_plane);
        color = continued.rgb * lens;
        served = continued.a;
        matte = 1.0;
    }
    color = darkened(color, drawn, on_plane, depth);
    if OUTLINES && matte < WHOLE && frame.surroundings_columns > 0u {
        let around = around_at(drawn.position.xy);
        color += (1.0 - matte) * min(around.rgb, vec3f(1.0));
        matte += (1.0 - matte) * around.a;
    }
    return finished(color, matte, served, most_confident, drawn.cells.x);
}
