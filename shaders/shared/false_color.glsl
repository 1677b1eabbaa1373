// Values in [0, 1] to colours, and values over a range to [0, 1].
// Common subset of GLSL and C++ with GLM (render/views/false_color.cpp).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Turbo, display-encoded sRGB. Source: Mikhailov 2019, "Turbo, An Improved Rainbow Colormap for Visualization"; polynomial of degree 5
// by Ruofei Du (Google AI Blog).
MAQUETTE_FN vec3 false_color_turbo(float t) {
  float x = clamp(t, 0.0f, 1.0f);
  float r = 0.13572138f + x * (4.61539260f + x * (-42.66032258f + x * (132.13108234f + x * (-152.94239396f + x * 59.28637943f))));
  float g = 0.09140261f + x * (2.19418839f + x * (4.84296658f + x * (-14.18503333f + x * (4.27729857f + x * 2.82956604f))));
  float b = 0.10667330f + x * (12.64194608f + x * (-60.58204836f + x * (110.36276771f + x * (-89.90310912f + x * 27.34824973f))));
  return clamp(vec3(r, g, b), vec3(0.0f), vec3(1.0f));
}

// 0 at `low`, 1 at `high`.
MAQUETTE_FN float false_color_linear(float value, float low, float high) {
  return clamp((value - low) / max(high - low, 1.0e-20f), 0.0f, 1.0f);
}

// Display colour of a value in [0, 1]; magenta for NaN and infinity. Negative inputs have become 0 by the functions above.
MAQUETTE_FN vec3 false_color(float t) {
  bool valid = t >= 0.0f && t <= 1.0f;
  return valid ? false_color_turbo(t) : vec3(1.0f, 0.0f, 1.0f);
}
