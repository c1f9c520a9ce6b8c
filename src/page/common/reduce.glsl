// Shows a picture in linear light on the canvas, which keeps values as they are given. A finer picture is reduced by Lanczos' filter with
// three lobes, on values as they are shown, as the program reduces its pictures.
uniform sampler2D drawn;
// Pixels of the picture per pixel of the canvas.
uniform float finer;
// The corner of the part of the canvas that is drawn.
uniform vec2 corner;
out vec4 color;

vec3 encoded(vec3 light) {
    vec3 low = light * 12.92, high = 1.055 * pow(max(light, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055;
    return mix(low, high, step(vec3(0.0031308), light));
}

float lanczos(float x) {
    float at = 3.14159265 * abs(x);
    return at < 1e-4 ? 1.0 : at >= 9.42477796 ? 0.0 : 3.0 * sin(at) * sin(at / 3.0) / (at * at);
}

void main() {
    vec2 middle = (gl_FragCoord.xy - corner) * finer;
    ivec2 size = textureSize(drawn, 0);
    if (finer == 1.0) { color = vec4(encoded(texelFetch(drawn, ivec2(middle), 0).rgb), 1.0); return; }
    int reach = int(ceil(3.0 * finer));
    ivec2 first = ivec2(floor(middle)) - reach;
    vec3 sum = vec3(0.0);
    float all = 0.0;
    for (int y = 0; y <= 2 * reach; y++) {
        float down = lanczos((float(first.y + y) + 0.5 - middle.y) / finer);
        if (down == 0.0) continue;
        for (int x = 0; x <= 2 * reach; x++) {
            float weight = down * lanczos((float(first.x + x) + 0.5 - middle.x) / finer);
            if (weight == 0.0) continue;
            sum += weight * encoded(texelFetch(drawn, clamp(first + ivec2(x, y), ivec2(0), size - 1), 0).rgb);
            all += weight;
        }
    }
    color = vec4(clamp(sum / all, 0.0, 1.0), 1.0);
}
