#pragma once

namespace aula {

// Shaders of the picture. Room: surfaces; edge: lines between them; line: coloured lines and
// triangles; pick: stripes over the selected surface.

inline constexpr const char* kRoomVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 colour;
layout(location = 3) in vec3 sides_pattern_depth;
uniform mat4 matrix;
out vec3 p;
flat out vec3 n;
flat out vec3 c;
flat out int s;
flat out int pattern;
void main() {
    p = position;
    n = normal;
    c = colour;
    s = int(sides_pattern_depth.x + 0.5);
    pattern = int(sides_pattern_depth.y + 0.5);
    gl_Position = matrix * vec4(position, 1.0);
    // More than the rounding of the depth, and a centimetre at 10 m.
    gl_Position.z += 1e-5 * sides_pattern_depth.z * gl_Position.w;
}
)";

// Light comes from the eye and from above, and differs between walls of different directions. Far
// walls are darker in first person. Patterns are in metres, and fade where a period takes few
// pixels. The energy of a patch is looked up by position and by the facing direction of the visible
// side.
inline constexpr const char* kRoomFragment = R"(#version 330 core
in vec3 p;
flat in vec3 n;
flat in vec3 c;
flat in int s;
flat in int pattern;
uniform vec3 eye;
uniform bool cut_away;
uniform float dimming;
uniform float overlay;
uniform sampler3D field;
uniform sampler2D palette;
uniform vec3 origin;
uniform float cell;
uniform vec3 size;
out vec4 shown;
float visible(float period, float pixel) { return smoothstep(2.0, 6.0, period / pixel); }
float joint(float at, float period, float width, float pixel) {
    float away = abs(fract(at / period + 0.5) - 0.5) * period;
    return clamp((0.5 * width - away) / pixel + 0.5, 0.0, 1.0) * visible(period, pixel);
}
float courses(vec2 at, vec2 brick, float width, vec2 pixel) {
    float row = floor(at.y / brick.y);
    return max(joint(at.y, brick.y, width, pixel.y),
               joint(at.x + 0.5 * brick.x * mod(row, 2.0), brick.x, width, pixel.x) *
                   visible(brick.y, pixel.y));
}
float grain(vec2 at, float period, vec2 pixel) {
    vec2 i = floor(at / period);
    float random = fract(sin(dot(i, vec2(12.9898, 78.233))) * 43758.5453);
    return (random - 0.5) * visible(period, max(pixel.x, pixel.y));
}
float relief(vec2 at, vec2 pixel) {
    if (pattern == 1) return -0.28 * courses(at, vec2(0.36, 0.12), 0.012, pixel);
    if (pattern == 2) return -0.25 * courses(at, vec2(0.60, 0.30), 0.012, pixel);
    if (pattern == 3)
        return -0.22 * max(joint(at.x, 0.20, 0.008, pixel.x), joint(at.y, 0.20, 0.008, pixel.y));
    // Boards stand on walls.
    if (pattern == 4 && abs(n.z) < 0.7) {
        at = at.yx;
        pixel = pixel.yx;
    }
    if (pattern == 4)
        return -0.20 * courses(at, vec2(1.6, 0.14), 0.006, pixel) +
               0.10 * grain(vec2(floor(at.y / 0.14), 0.0), 1.0, vec2(pixel.y / 0.14));
    if (pattern == 5)
        return -0.18 * max(joint(at.x, 0.60, 0.012, pixel.x), joint(at.y, 0.60, 0.012, pixel.y));
    if (pattern == 6) return 0.14 * sin(at.x * 34.9) * visible(0.18, pixel.x);
    if (pattern == 7) return 0.16 * grain(at, 0.03, pixel);
    if (pattern == 8)
        return 0.10 * smoothstep(0.35, 0.5, abs(fract((at.x + at.y) / 1.6) - 0.5));
    if (pattern == 9) return -0.16 * joint(at.x, 0.10, 0.02, pixel.x);
    return 0.0;
}
void main() {
    vec3 to_eye = normalize(eye - p);
    bool front = dot(n, to_eye) > 0.0;
    vec2 along = abs(n.z) > 0.7 ? vec2(1.0, 0.0) : normalize(vec2(-n.y, n.x));
    vec2 at = abs(n.z) > 0.7 ? p.xy : vec2(dot(p.xy, along), p.z);
    vec2 pixel = max(fwidth(at), vec2(1e-5));
    if (cut_away && (s & (front ? 1 : 2)) == 0) discard;
    vec3 f = front ? n : -n;
    float light = 0.66 + 0.14 * dot(f, to_eye) + 0.10 * f.z + 0.12 * f.x + 0.07 * f.y;
    light *= 1.0 - dimming * smoothstep(2.0, 30.0, distance(eye, p));
    vec3 lit = c * light * (1.0 + relief(at, pixel));
    if (overlay > 0.0) {
        vec3 a = abs(f);
        float d = a.x >= a.y && a.x >= a.z ? (f.x > 0.0 ? 0.0 : 1.0)
                : a.y >= a.z ? (f.y > 0.0 ? 2.0 : 3.0) : (f.z > 0.0 ? 4.0 : 5.0);
        vec3 q = (p + 0.002 * f - origin) / cell;
        q.z = clamp(q.z, 0.5, size.z - 0.5) + d * size.z;
        vec2 t = texture(field, q / vec3(size.xy, 6.0 * size.z)).rg;
        float level = t.g > 0.02 ? t.r / t.g : 0.0;
        vec3 glow = texture(palette, vec2(level, 0.5)).rgb * (0.75 + 0.25 * light);
        lit = mix(lit, mix(lit * 0.35, glow, 0.85), overlay);
    }
    shown = vec4(lit, 1.0);
}
)";

inline constexpr const char* kEdgeVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal1;
layout(location = 2) in vec3 normal2;
layout(location = 3) in vec2 sides;
uniform mat4 matrix;
uniform vec3 eye;
uniform bool cut_away;
uniform float strength;
uniform vec3 tint;
out vec4 c;
bool seen(vec3 n, float s) {
    return (int(s + 0.5) & (dot(n, eye - position) > 0.0 ? 1 : 2)) != 0;
}
void main() {
    bool visible = !cut_away || seen(normal1, sides.x) || seen(normal2, sides.y);
    c = visible ? vec4(tint, strength) : vec4(0.62, 0.68, 0.76, 0.3 * strength);
    gl_Position = matrix * vec4(position, 1.0);
    gl_Position.z -= 0.0001 * gl_Position.w;
}
)";

inline constexpr const char* kLineVertex = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 colour;
uniform mat4 matrix;
out vec4 c;
void main() {
    c = colour;
    gl_Position = matrix * vec4(position, 1.0);
    gl_Position.z -= 0.0002 * gl_Position.w;
}
)";

inline constexpr const char* kLineFragment = R"(#version 330 core
in vec4 c;
out vec4 shown;
void main() { shown = c; }
)";

// The surface stays visible between the stripes.
inline constexpr const char* kPickFragment = R"(#version 330 core
in vec4 c;
uniform float period;
out vec4 shown;
void main() {
    if (fract((gl_FragCoord.x + gl_FragCoord.y) / period) > 0.16) discard;
    shown = c;
}
)";

}  // namespace aula
