#version 300 es
// Programs in one: DECODE makes numbers of the bytes of one light group, once; RELIGHT makes XYZ of them; SHOW adds the
// groups up as a picture. PLACE is the one triangle that covers the picture in all of them.
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
precision highp sampler3D;

#ifdef PLACE
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
#endif

#ifdef DECODE
uniform sampler2DArray planes; // bytes, one layer for each of p planes
uniform sampler2D tables;      // what a byte of a plane means, (256, p)
uniform int first;             // of the four planes that go into one layer
uniform int count;
uniform sampler2DArray bright; // the plane of brightness of every light group, and what its bytes mean
uniform sampler2D means;
uniform int groups;
uniform float base;
uniform float part;          // of the brightness of all that counts as that of each
out vec4 values;

float value(ivec2 at, int plane) {
  if (plane >= count) return 0.0;
  int code = int(texelFetch(planes, ivec3(at, plane), 0).r * 255.0 + 0.5);
  return texelFetch(tables, ivec2(code, plane), 0).r;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  float total = 0.0;
  for (int g = 0; g < groups; g++) total += texelFetch(means, ivec2(int(texelFetch(bright, ivec3(at, g), 0).r * 255.0 + 0.5), g), 0).r;
  float scale = value(at, 0) + base + part * total;
  values = scale * vec4(value(at, first), value(at, first + 1), value(at, first + 2), value(at, first + 3));
  if (first == 0) values.r = value(at, 0);
}
#endif

#ifdef RELIGHT
uniform sampler2DArray values; // brightness and what is left, four of p in a layer
uniform vec3 white;            // XYZ of coefficients of 1
uniform mat4x3 axes[MOST];     // XYZ of the axes of what is left, in fours; the first column is empty
uniform int layers;
out vec4 xyz;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 each = texelFetch(values, ivec3(at, 0), 0);
  vec3 sum = each.r * white + axes[0] * each;
  for (int k = 1; k < layers; k++) sum += axes[k] * texelFetch(values, ivec3(at, k), 0);
  xyz = vec4(sum, 1.0);
}
#endif

#ifdef SHOW
uniform sampler2DArray left;   // XYZ, one layer for each light group
uniform sampler2DArray right;  // the mix to compare with
uniform sampler2D coverage;
uniform sampler3D lut;
uniform float gains[2 * GROUPS];
uniform mat3 display[2];       // XYZ to the display's linear RGB, or to what the table takes
uniform float gamma;
uniform int groups;
uniform int wipe;              // the first column of the other mix
uniform bool hasLut;
uniform bool hasAlpha;
uniform vec2 range;            // of the table, in stops
out vec4 colour;

vec3 shown(vec3 rgb) {
  if (hasLut) {
    float size = float(textureSize(lut, 0).x);
    vec3 at = clamp((log2(max(rgb, 0.0) + exp2(range.x)) - range.x) / (range.y - range.x), 0.0, 1.0);
    return texture(lut, at * (size - 1.0) / size + 0.5 / size).rgb;
  }
  rgb = clamp(rgb, 0.0, 1.0);
  vec3 encoded = mix(1.055 * pow(rgb, vec3(1.0 / 2.4)) - 0.055, 12.92 * rgb, vec3(lessThanEqual(rgb, vec3(0.0031308))));
  return pow(encoded, vec3(1.0 / gamma));
}

void main() {
  ivec2 size = textureSize(left, 0).xy;
  ivec2 at = ivec2(int(gl_FragCoord.x), size.y - 1 - int(gl_FragCoord.y));
  bool other = at.x >= wipe;
  vec3 xyz = vec3(0.0);
  for (int g = 0; g < groups; g++) {
    vec3 each = other ? texelFetch(right, ivec3(at, g), 0).rgb : texelFetch(left, ivec3(at, g), 0).rgb;
    xyz += gains[other ? GROUPS + g : g] * each;
  }
  float alpha = hasAlpha ? texelFetch(coverage, at, 0).r : 1.0;
  vec3 rgb = (other ? display[1] : display[0]) * (alpha > 0.0 ? xyz / alpha : xyz);
  if (at.x == wipe) colour = vec4(1.0);
  else colour = vec4(shown(rgb), alpha);
}
#endif
