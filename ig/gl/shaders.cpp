// SPDX-License-Identifier: MIT
#include "ig/gl/shaders.h"

#include "ig/gl/page_store.h"
#include "ig/gl/tile_indices.h"
#include "ig/lod/vertex_error.h"

#include <fmt/format.h>

#include <cmath>

namespace ig::gl {
namespace {

// Shared by terrain and sky, so that distant terrain fades into the sky behind it.
std::string hazeColour()
{
    const auto& haze = kSkyBelowHorizon;
    return fmt::format("precision highp float;\nconst vec3 kHazeColour = vec3({:.3f}, {:.3f}, {:.3f});\n",
                       haze[0], haze[1], haze[2]);
}

constexpr const char* kTerrainVertex = R"(
precision highp float;
precision highp int;
layout(location = ATTRIBUTE_HIGH) in vec3 a_high;
layout(location = ATTRIBUTE_LOW) in vec3 a_low;
layout(location = ATTRIBUTE_POST) in vec2 a_post;
uniform mat4 u_clipFromRelative;
uniform vec3 u_eyeHigh;
uniform vec3 u_eyeLow;
#ifndef UNIFORM_COLOUR
uniform int u_layer;
out vec2 v_place;
flat out float v_layer;
#endif
// Keeps a compiler from changing the order of the sums below, and from doing so in one variant only.
invariant gl_Position;
#ifdef HAZE
uniform vec4 u_along; // 0 0 0 1; in parallel projection the viewing axis and 0
out float v_distanceM;
#endif
#if defined(MORPH_LISTS) || defined(MORPH_TILES)
uniform float u_shortestM; // parallel projection: every distance
layout(location = ATTRIBUTE_TO_MIDDLE) in vec3 a_toMiddle; // in shares of the error, or of the radius
layout(location = ATTRIBUTE_CODES) in vec2 a_codes;        // error, radius
// Code 0 gives 0.9 mm where it should be 0: as an error that spares a division by 0, and the way is 0.
vec2 metres()
{
    return exp2(a_codes * (1.0 / CODES_PER_OCTAVE)) * CODE_0_M;
}
#endif
#ifdef MORPH_LISTS
uniform vec2 u_morph; // 1 / reach, cut
// Offset of a vertex that is at weight w (see bintree.h). With reach kappa and error e,
//   (kappa e + r - d) / (b kappa e) = (1 + (r - d) / kappa / e) / b   and
//   (e - cut) / (b e)               = (1 - cut / e) / b
vec3 morphed(float distanceM)
{
    vec2 sizeM = metres();
    float radiusM = a_codes.y > 254.5 ? 1e9 : a_codes.y > 0.0 ? sizeM.y : 0.0; // as decodeRadiusM()
    float behind = min((radiusM - distanceM) * u_morph.x, -u_morph.y);
    float w = clamp((1.0 + behind / sizeM.x) * (1.0 / MORPH_BAND), 0.0, 1.0);
    return ((1.0 - w) * (a_post.x < 0.0 ? sizeM.y : sizeM.x)) * a_toMiddle;
}
#endif
#ifdef MORPH_TILES
uniform vec4 u_tile;  // column and row of the north-west post, 1 / stride, weight
uniform vec4 u_sides; // weights north, east, south, west
vec3 morphed(float distanceM)
{
    vec2 at = (a_post - u_tile.xy) * u_tile.z; // 0 .. TILE_INTERVALS
    float w = u_tile.w;
    w = at.y < 0.5 ? u_sides.x : at.y > TILE_INTERVALS - 0.5 ? u_sides.z : w;
    w = at.x < 0.5 ? u_sides.w : at.x > TILE_INTERVALS - 0.5 ? u_sides.y : w;
    vec2 odd = fract(at * 0.5);
    return odd.x + odd.y > 0.25 ? ((1.0 - w) * metres().x) * a_toMiddle : vec3(0.0);
}
#endif
void main()
{
    // High parts first: their difference is exact near the eye.
    vec3 relative = (a_high - u_eyeHigh) + (a_low * LOW_FULL_SCALE_M - u_eyeLow);
#if defined(MORPH_LISTS) || defined(MORPH_TILES)
    relative += morphed(max(length(relative), u_shortestM));
#endif
    gl_Position = u_clipFromRelative * vec4(relative, 1.0);
#ifndef UNIFORM_COLOUR
#ifdef MORPH_LISTS
    vec2 post = vec2(abs(a_post.x + 0.5) - 0.5, a_post.y); // -1 - column is the column, too
#else
    vec2 post = a_post;
#endif
    v_place = post * (1.0 / PAGE_INTERVALS);
    v_layer = float(gl_VertexID / PAGE_VERTICES + u_layer);
#endif
#ifdef HAZE
    v_distanceM = u_along.w * length(relative) + dot(u_along.xyz, relative);
#endif
}
)";

constexpr const char* kTerrainFragment = R"(
precision mediump sampler2DArray;
uniform sampler2DArray u_pages;
#ifndef UNIFORM_COLOUR
in vec2 v_place;
flat in float v_layer;
#endif
#ifdef HAZE
uniform float u_hazePerM;
in float v_distanceM;
#endif
#ifdef FRAGMENT_DEPTH
uniform vec3 u_depth;
#endif
layout(location = 0) out vec4 o_colour;
void main()
{
#ifdef UNIFORM_COLOUR
    // Through the sampler, whose precision is its own: the same colour to the last bit as that of textures.
    vec4 texel = texture(u_pages, vec3(0.5, 0.5, 0.0));
#else
    vec4 texel = texture(u_pages, vec3(v_place, v_layer));
#endif
#ifdef HOLES
    if (texel.a < 0.5)
        discard;
#endif
    vec3 colour = texel.rgb;
#ifdef HAZE
    colour = mix(kHazeColour, colour, exp2(u_hazePerM * -v_distanceM));
#endif
    o_colour = vec4(colour, 1.0);
#ifdef FRAGMENT_DEPTH
    // What the reversed projection gives with a 0..1 clip range, 0 behind the far plane.
    gl_FragDepth = u_depth.x * gl_FragCoord.w + u_depth.y * gl_FragCoord.z + u_depth.z;
#endif
}
)";

constexpr const char* kSkyVertex = R"(
precision highp float;
uniform vec4 u_sides;
uniform vec2 u_corners[MOST_CORNERS];
out vec2 v_tangent;
void main()
{
    vec2 corner = u_corners[gl_VertexID]; // 0 .. 1 is the target
    v_tangent = vec2(mix(u_sides.x, u_sides.y, corner.x), mix(u_sides.w, u_sides.z, corner.y));
    gl_Position = vec4(corner * 2.0 - 1.0, INFINITE_DEPTH, 1.0);
}
)";

constexpr const char* kSkyFragment = R"(
const vec3 kZenithColour = vec3(0.235, 0.435, 0.745);
uniform vec3 u_up;
in vec2 v_tangent;
layout(location = 0) out vec4 o_colour;
void main()
{
    vec3 ray = vec3(v_tangent, -1.0);
    float sine = dot(ray, u_up) * inversesqrt(dot(ray, ray)); // of the elevation
    o_colour = vec4(mix(kZenithColour, kHazeColour, exp2(-5.0 * sine)), 0.0);
}
)";

constexpr const char* kProbeVertex = R"(
void main()
{
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
    gl_Position = vec4(corner, 0.0, 1.0);
}
)";

constexpr const char* kProbeFragment = R"(
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D u_depth;
uniform ivec2 u_pixel;
layout(location = 0) out highp uint o_bits;
void main()
{
    o_bits = floatBitsToUint(texelFetch(u_depth, u_pixel, 0).r);
}
)";

constexpr const char* kVersion = "#version 300 es\n";

} // namespace

ShaderPair terrainShaders(const TerrainVariant& variant)
{
    std::string head = kVersion;
    const auto define = [&head](bool wanted, const char* name) {
        if (wanted)
            head += fmt::format("#define {}\n", name);
    };
    define(variant.haze, "HAZE");
    define(variant.holes, "HOLES");
    define(variant.uniformColour, "UNIFORM_COLOUR");
    define(variant.fragmentDepth, "FRAGMENT_DEPTH");
    define(variant.morph == Morph::lists, "MORPH_LISTS");
    define(variant.morph == Morph::tiles, "MORPH_TILES");
    std::string vertexHead =
        head + fmt::format(
                   "#define ATTRIBUTE_HIGH {}\n#define ATTRIBUTE_LOW {}\n#define ATTRIBUTE_POST {}\n"
                   "#define LOW_FULL_SCALE_M {:.6f}\n#define PAGE_INTERVALS {}.0\n#define PAGE_VERTICES {}\n",
                   int{kAttributeHigh}, int{kAttributeLow}, int{kAttributePost}, kLowFullScaleM,
                   lod::kPageIntervals, kPageVertices);
    if (variant.morph != Morph::none)
        vertexHead += fmt::format(
            "#define ATTRIBUTE_TO_MIDDLE {}\n#define ATTRIBUTE_CODES {}\n"
            "#define TILE_INTERVALS {}.0\n#define CODES_PER_OCTAVE {}.0\n#define CODE_0_M {:.9e}\n"
            "#define MORPH_BAND {:.9e}\n",
            int{kAttributeToMiddle}, int{kAttributeCodes}, lod::kTileIntervals, lod::kCodesPerOctave,
            lod::kSmallestCodeM * std::exp2(-1.0 / lod::kCodesPerOctave), lod::kMorphBand);
    return {vertexHead + kTerrainVertex, head + hazeColour() + kTerrainFragment};
}

ShaderPair skyShaders(bool clipControl)
{
    // Window depth 0 either way.
    const std::string vertexHead =
        kVersion + fmt::format("#define INFINITE_DEPTH {}\n#define MOST_CORNERS {}\n",
                               clipControl ? "0.0" : "-1.0", kMostSkyCorners);
    return {vertexHead + kSkyVertex, kVersion + hazeColour() + kSkyFragment};
}

ShaderPair depthProbeShaders()
{
    return {std::string(kVersion) + kProbeVertex, std::string(kVersion) + kProbeFragment};
}

} // namespace ig::gl
