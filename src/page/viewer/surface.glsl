// What the photos show of a surface in a pixel (shaders/project.wgsl).
flat in ivec2 row;
flat in vec2 range;
out vec4 color;

uniform highp sampler2D surfaces;
uniform highp sampler2D heights;
uniform mediump sampler2D continued_colors;

const float LEAST_FACING = 0.1, WHOLE = 0.998, MIRRORED = 0.5, ON_AXIS = 1e-3;
const float BILLBOARD = 1.0, IMPOSTOR = 2.0, SKIRT = 3.0;

vec4 surface_word(int word) {
    return texelFetch(surfaces, ivec2(row.x * 10 + word, row.y), 0);
}

// A grid in the plane: mappings to cells, corner and size in its sheet; no width without one.
struct Grid { vec4 across; vec4 up; vec4 place; };

vec2 sheet_place(Grid grid, vec3 p) {
    vec2 cell = vec2(dot(grid.across.xyz, p) + grid.across.w, dot(grid.up.xyz, p) + grid.up.w);
    return clamp(cell, vec2(0.5), grid.place.zw - 0.5) + grid.place.xy;
}

float height_at(Grid grid, vec3 p) {
    return textureLod(heights, sheet_place(grid, p) / vec2(textureSize(heights, 0)), 0.0).r;
}

// Intersects the ray through a point of the plane with the relief, by two steps.
vec3 on_relief(Grid grid, vec3 normal, vec3 p) {
    vec3 ray = normalize(p);
    float facing = dot(normal, ray);
    float slope = (facing >= 0.0 ? 1.0 : -1.0) * max(abs(facing), LEAST_FACING);
    vec3 nearer = p + ray * (height_at(grid, p) / slope);
    return p + ray * (height_at(grid, nearer) / slope);
}

// A point as a photo sees it, its movements for a step of one pixel of the view, the camera's distance from the plane that it sees, and
// the direction to the camera.
struct Place { vec3 p; vec3 dx; vec3 dy; float height; vec3 towards; };

// Takes a point of the rectangle that faces the viewpoint to the one that faces the photo.
Place place_of(Place at, vec3 normal, Camera photo, vec2 axis_px, bool mirrored) {
    vec4 foot = surface_word(8);
    vec3 axis = surface_word(9).xyz;
    vec3 across = cross(axis, normal);
    vec3 center = photo.center.xyz - foot.xyz;
    vec3 own = cross(axis, center);
    if (length(own) < ON_AXIS * foot.w) {
        vec3 to_right = photo.row_x.xyz - axis_px.x * photo.row_z.xyz;
        own = to_right - axis * dot(axis, to_right);
    }
    own = normalize(own);
    vec3 shift = (mirrored ? -own : own) - across;
    vec3 p = at.p + dot(at.p - foot.xyz, across) * shift;
    vec3 other = foot.xyz + 2.0 * dot(center, axis) * axis - center;
    return Place(p, at.dx + dot(at.dx, across) * shift, at.dy + dot(at.dy, across) * shift,
        abs(dot(cross(own, axis), center)), (mirrored ? other : photo.center.xyz) - p);
}

// How much of a texel of the surroundings stands on the outlines of the model.
float standing(float agreement) { return 1.0 - smoothstep(0.25, 0.75, agreement); }

void main() {
    vec2 at = position();
    vec3 ray = ray_through(at);
    vec4 plane = surface_word(0);
    vec4 kind = surface_word(7);
    bool is_impostor = kind.x == IMPOSTOR, is_skirt = kind.x == SKIRT;
    vec3 normal = plane.xyz;
    float facing = dot(normal, ray);
    float depth = plane.w / facing;
    vec3 on_plane = ray * depth;
    vec3 ray_x = right / lens.x, ray_y = down / lens.y;
    vec3 dx = depth * (ray_x - ray * (dot(normal, ray_x) / facing));
    vec3 dy = depth * (ray_y - ray * (dot(normal, ray_y) / facing));
    float in_view = finer * lens.x * lens.y * abs(plane.w) / (depth * depth * depth);
    bool from_behind = plane.w > 0.0;
    Grid relief = Grid(surface_word(1), surface_word(2), surface_word(3));
    bool has_relief = relief.place.z > 0.0;
    vec3 p = has_relief ? on_relief(relief, normal, on_plane) : on_plane;
    Best best = no_best();
    vec4 pinned = vec4(0.0);
    float pinned_matte = 0.0, pinned_share = 0.0;
    bool served = false;
    uint first = uint(range.x), end = depth > 0.0 ? first + uint(range.y) : first;
    for (int attempt = 0; attempt < 2; attempt++) {
        for (uint i = first; i < end; i++) {
            vec2 candidate = candidate_at(i);
            if (candidate.x >= best.next) break;
            uint place = uint(candidate.y);
            uvec4 server = server_word(place);
            uint number = server.x & 0xffffu;
            Camera photo = camera_at(number);
            bool other_side = ((server.x & BACK) != 0u) != from_behind;
            if (other_side && kind.y == 0.0) continue;
            Place seen = Place(p, dx, dy, abs(dot(normal, photo.center.xyz) - plane.w), photo.center.xyz - p);
            if (is_impostor) seen = place_of(seen, normal, photo, photo_word(number, 6).xy, other_side);
            float z = dot(photo.row_z.xyz, seen.p) + photo.row_z.w;
            if (z <= 0.0) continue;
            vec2 px = vec2(dot(photo.row_x.xyz, seen.p) + photo.row_x.w, dot(photo.row_y.xyz, seen.p) + photo.row_y.w) / z;
            float edge = min(min(px.x, photo.size.x - px.x), min(px.y, photo.size.y - px.y));
            float border = border_ramp(edge * abs(photo.size.z));
            if (border <= 0.0) continue;
            bool inside = true;
            for (uint side = 1u; side <= server.x >> 24; side++) {
                vec3 half_plane = uintBitsToFloat(server_word(place + side).xyz);
                inside = inside && dot(half_plane.xy, px) >= half_plane.z;
            }
            if (!inside) continue;
            Known known = known_at(number, photo, server, px);
            if (is_skirt && known.kind == HIDDEN) known.confidence *= 0.25;
            if (known.confidence <= 0.002) continue;
            float in_photo = photo.center.w * seen.height / (z * z * z);
            float octaves = 0.5 * log2(in_view / in_photo) + known.lost;
            float q = angle_between(seen.towards, -p) + (other_side ? (is_impostor ? MIRRORED : OTHER_SIDE) : 0.0);
            q += lambda * max(octaves, 0.0);
            // What stands on outlines counts fully where it is shown at its own place.
            q = (q / (is_skirt ? 1.0 : known.agreement) + LEAST_ANGLE) / (border * known.confidence);
            served = true;
            uvec3 kept = uvec3(known.kind, byte_of(known.agreement), byte_of(known.outline));
            if ((server.x & PINNED) != 0u && !other_side) {
                float trust = border * known.confidence;
                vec2 a = moved(photo, px, z, seen.dx), b = moved(photo, px, z, seen.dy);
                Look look = look_at(number);
                vec4 texel = light_at(number, photo, look.state.z, server, known.kind, px, a, b);
                pinned += vec4(kept_white(texel, exposed(photo, look, texel, px)) * trust, trust);
                pinned_matte += texel.a * trust;
                pinned_share = max(pinned_share, trust);
            } else {
                join(best, q, place, px, kept);
            }
        }
        if (served || !has_relief) break;
        p = on_plane;
    }
    if (is_impostor) fewer(best);
    vec3 sum = vec3(0.0);
    float all = 0.0, matte = 0.0;
    for (int i = 0; i < BEST; i++) {
        float share = share_of(best, i);
        if (best.q[i] >= INFINITE || (i > 0 && share <= 0.0)) continue;
        uvec4 server = server_word(best.server[i]);
        uint number = server.x & 0xffffu;
        Camera photo = camera_at(number);
        bool other_side = ((server.x & BACK) != 0u) != from_behind;
        Place seen = Place(p, dx, dy, 0.0, vec3(0.0));
        if (is_impostor) seen = place_of(seen, normal, photo, photo_word(number, 6).xy, other_side);
        float z = dot(photo.row_z.xyz, seen.p) + photo.row_z.w;
        vec2 a = moved(photo, best.px[i], z, seen.dx), b = moved(photo, best.px[i], z, seen.dy);
        Look look = look_at(number);
        vec4 texel = light_at(number, photo, look.state.z, server, best.known[i].x, best.px[i], a, b);
        vec3 light = kept_white(texel, exposed(photo, look, texel, best.px[i]));
        float agreement = float(best.known[i].y) / 255.0, outline = float(best.known[i].z) / 255.0;
        float shown = is_skirt ? (best.known[i].x == OWN ? standing(agreement) * outline : 0.0) : mix(1.0, outline, look.gain.w);
        float weight = share > 0.0 ? share : 1e-9;
        sum += weight * shown * light;
        matte += weight * shown * texel.a;
        all += weight;
    }
    vec3 light = all > 0.0 ? sum / all : vec3(0.0);
    matte = all > 0.0 ? matte / all : 0.0;
    if (pinned.a > 0.0) {
        float share = all > 0.0 ? pinned_share : 1.0;
        light = mix(light, pinned.rgb / pinned.a, share);
        matte = mix(matte, pinned_matte / pinned.a, share);
    }
#ifdef SEE_THROUGH
    if (!served) discard;
#else
    if (!served) {
        Grid continued = Grid(surface_word(4), surface_word(5), surface_word(6));
        if (continued.place.z == 0.0) discard;
        light = textureLod(continued_colors, sheet_place(continued, on_plane) / vec2(textureSize(continued_colors, 0)), 0.0).rgb * (of_common * lens_here());
        matte = 1.0;
    }
    // Within the outlines of the model a photo may show the sky: it is seen through.
    if (matte < WHOLE && around_list.w > 0.0) {
        vec4 around = around_at(at);
        light += (1.0 - matte) * min(around.rgb, vec3(1.0));
        matte += (1.0 - matte) * around.a;
    }
#endif
    color = vec4(min(light, vec3(1.0)), matte);
}
