// In place of the colours of photos, their exposures: the mean by weights is that of the view (projection::exposure). As in the program,
// everything that a piece of a photo holds counts as shown wholly.
struct Known { float confidence; float agreement; float outline; uint kind; float lost; };

const uint OWN = 0u, HIDDEN = 1u;

Known known_at(uint photo_number, Camera photo, uvec4 server, vec2 px) { return Known(1.0, 1.0, 1.0, OWN, 0.0); }

vec4 light_at(uint photo_number, Camera photo, float fine, uvec4 server, uint kind, vec2 px, vec2 dx, vec2 dy) {
    return vec4(photo_word(photo_number, 5).rgb, 1.0);
}

vec3 exposed(Camera photo, Look look, vec4 texel, vec2 px) { return texel.rgb; }

vec3 kept_white(vec4 texel, vec3 light) { return light; }
