// SPDX-License-Identifier: MIT
// GLSL ES 3.00 sources, put together from what a scene needs. Internal to ig/gl.
#pragma once

#include "ig/gl/renderer.h"

#include <array>
#include <cstddef>
#include <string>

namespace ig::gl {

// Every field that is false leaves its code out.
struct TerrainVariant {
    bool haze = false;
    bool holes = false;         // discards texels of holes
    bool uniformColour = false; // one texel for all
    bool fragmentDepth = false; // no clip control: the fragment shader writes the reversed depth
    Morph morph = Morph::none;
};

struct ShaderPair {
    std::string vertex;
    std::string fragment;
};

// Attributes as in PageStore. Uniforms: u_clipFromRelative (mat4), u_eyeHigh and u_eyeLow (vec3), u_layer
// (int, not with uniformColour: added to the slot that gl_VertexID gives), u_pages (sampler); u_hazePerM
// (float) and u_along (vec4: what gives the distance that haze covers: 0 0 0 1 for that to the eye, axis and
// 0 for that along the axis) with haze; u_depth (vec3: factors of 1 / w and window depth, and what is added)
// with fragmentDepth; with any morph u_shortestM (float: what is nearer counts as that far); of lists u_morph
// (vec2: 1 / reach and cut of lod::MorphState, zeros for vertices that stay in place), of tiles u_tile (vec4:
// column and row of the north-west post, 1 / stride, weight) and u_sides (vec4: weights north, east, south,
// west).
ShaderPair terrainShaders(const TerrainVariant& variant);

// Red, green, blue and alpha of the sky below the horizon, which is also the haze that terrain fades into.
inline constexpr std::array<float, 4> kSkyBelowHorizon{0.760F, 0.835F, 0.902F, 0.0F};

// A rectangle cut by a line.
inline constexpr size_t kMostSkyCorners = 5;

// A polygon above the horizon, at infinite depth, no attributes. Uniforms: u_corners (vec2[kMostSkyCorners],
// 0 to 1 over the target), u_sides (vec4: left, right, bottom, top tangents), u_up (vec3: away from the
// Earth's centre, eye frame).
ShaderPair skyShaders(bool clipControl);

// Copies the depth of a pixel, as bits, into an R32UI target. Uniforms: u_depth (sampler), u_pixel (ivec2).
ShaderPair depthProbeShaders();

} // namespace ig::gl
