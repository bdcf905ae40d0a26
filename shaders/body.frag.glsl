#version 330 core
// Marks where the body is: no colour, a little alpha (kBodyAlpha in composition.h).
out vec4 pixel;

void main() {
  pixel = vec4(0.0, 0.0, 0.0, 16.0 / 255.0);
}
