// The surroundings, where no face is: at infinite depth, so that a direction decides (shaders/surroundings.wgsl).

uniform highp samplerCube dome;
// The logarithms of the factors that bring photos' surroundings to one sky: 32 x 32 cells a photo, 16 photos in a row.
uniform highp sampler2D sky_factors;

const float DOME_PENALTY = 2.0;
const float SKY_GRID = 32.0, SKY_COLUMNS = 16.0;

vec3 to_one_sky(Camera photo, Look look, vec2 px) {
    float number = look.state.x - 1.0;
    if (number < 0.0) return of_sky;
    vec2 corner = vec2(mod(number, SKY_COLUMNS), floor(number / SKY_COLUMNS)) * SKY_GRID;
    vec2 cell = clamp(px / photo.size.xy * SKY_GRID, vec2(0.5), vec2(SKY_GRID - 0.5)) + corner;
    return of_sky * exp(textureLod(sky_factors, cell / vec2(textureSize(sky_factors, 0)), 0.0).rgb);
}

// What the photos show of the surroundings in a pixel, and 1; 0 where nothing is.
vec4 around_at(vec2 at) {
    vec3 ray = ray_through(at);
    vec3 ray_x = right / lens.x, ray_y = down / lens.y;
    Best best = no_best();
    uint first = uint(around_list.x), end = first + uint(around_list.y);
    for (uint i = first; i < end; i++) {
        vec2 candidate = candidate_at(i);
        if (candidate.x >= best.next) break;
        uint place = uint(candidate.y);
        uvec4 server = server_word(place);
        uint number = server.x & 0xffffu;
        Camera photo = camera_at(number);
        float z = dot(photo.row_z.xyz, ray);
        if (z <= 0.0) continue;
        vec2 px = vec2(dot(photo.row_x.xyz, ray), dot(photo.row_y.xyz, ray)) / z;
        float edge = min(min(px.x, photo.size.x - px.x), min(px.y, photo.size.y - px.y));
        float border = border_ramp(edge * abs(photo.size.z));
        if (border <= 0.0) continue;
        Known known = known_at(number, photo, server, px);
        if (known.confidence <= 0.002) continue;
        float octaves = 0.5 * log2(lens.x * lens.y * z * z * z / photo.center.w) + known.lost;
        float q = length(photo.center.xyz) * around_list.z + lambda * max(octaves, 0.0);
        q = (q / known.agreement + LEAST_ANGLE) / (border * known.confidence);
        join(best, q, place, px, uvec3(known.kind, 0u, 0u));
    }
    bool has_dome = dome_white > 0.0;
    if (has_dome) join(best, DOME_PENALTY + LEAST_ANGLE, 0u, vec2(0.0), uvec3(OWN, 0u, 0u));
    vec3 sum = vec3(0.0), color = vec3(0.0);
    float all = 0.0;
    for (int i = 0; i < BEST; i++) {
        float share = share_of(best, i);
        if (best.q[i] >= INFINITE || (i > 0 && share <= 0.0)) continue;
        if (best.server[i] == 0u) {
            color = texture(dome, ray.xzy).rgb * of_common * of_sky * (dome_white * lens_here());
        } else {
            uvec4 server = server_word(best.server[i]);
            uint number = server.x & 0xffffu;
            Camera photo = camera_at(number);
            Look look = look_at(number);
            float z = dot(photo.row_z.xyz, ray);
            vec2 a = moved(photo, best.px[i], z, ray_x), b = moved(photo, best.px[i], z, ray_y);
            vec4 texel = light_at(number, photo, look.state.z, server, best.known[i].x, best.px[i], a, b);
            vec3 light = exposed(photo, look, texel, best.px[i]);
            color = mix(kept_white(texel, light), light * to_one_sky(photo, look, best.px[i]), look.state.y);
        }
        // Where all shares vanish the first one counts.
        float weight = share > 0.0 ? share : 1e-9;
        sum += weight * color;
        all += weight;
    }
    return all > 0.0 ? vec4(sum / all, 1.0) : vec4(0.0);
}
