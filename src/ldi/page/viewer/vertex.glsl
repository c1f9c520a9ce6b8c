// A corner: column and row in the frame, inverse depth. With 1 as third coordinate it is homogeneous, so the division that brings it to
// the picture also gives textures that are exact from every viewpoint.
layout(location = 0) in vec3 corner;
layout(location = 1) in vec2 texel;
uniform mat4 clip_from_frame;
uniform vec2 texture_size;
out vec2 place;

void main() {
    place = texel / texture_size;
    gl_Position = clip_from_frame * vec4(corner.xy, 1.0, corner.z);
}
