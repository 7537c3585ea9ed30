// SPDX-License-Identifier: MIT
// The sky behind the terrain, from haze at the horizon to blue overhead. Below the horizon all is haze: what
// lies beyond the terrain's edge must not stand out behind it. Internal to ig/gl.
#pragma once

#include "ig/geo/view_state.h"
#include "ig/gl/context.h"
#include "ig/gl/gl_objects.h"

namespace ig::gl {

class SkyPass {
public:
    // Error (graphics): a shader that does not compile.
    static Result<SkyPass> create(const Context& context);

    // Before the ground, or after it where nothing stands before the sky.
    enum class Order : uint8_t { first, last };
    // Fills what lies above the horizon. The rest of the sky has the colour that the target was cleared to:
    // kSkyBelowHorizon.
    void draw(const ViewState& view, Order order) const;

private:
    Program _program;
    GLint _sides = -1, _up = -1, _corners = -1;
    VertexArray _noAttributes;
};

} // namespace ig::gl
