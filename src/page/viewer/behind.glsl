// What is around, where nothing was drawn.
out vec4 color;

void main() {
    color = around_at(position());
    if (color.a == 0.0) discard;
}
