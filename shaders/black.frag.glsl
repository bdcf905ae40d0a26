#version 330 core
// The inner side of the skin: hides what is behind it, and shows nothing.
out vec4 pixel;

void main() {
  pixel = vec4(0.0, 0.0, 0.0, 1.0);
}
