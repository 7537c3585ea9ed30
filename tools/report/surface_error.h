// SPDX-License-Identifier: MIT
// The geometric error of what is drawn, in pixels, measured post by post against the terrain as it is: the
// distance on the screen between a full-resolution post and the point of the drawn, morphed surface that has
// its grid coordinates. And how far points of the surface move from one frame to the next although the eye's
// motion does not move them. Independent of the selection and its bounds.
//
// A post is in view where its true place is inside the frustum (hidden by hills or not). Measured are all of
// them, or a sample: one post at random of each block of N x N, the same ones in every frame, so that mean
// and quantiles are unbiased and the largest is a lower limit. Posts of the grid's last column and row belong
// to no block. Posts for which nothing is drawn (behind the horizon, where pages are left out) do not count;
// a hole in the picture does, see picture_error.h.
#pragma once

#include "tools/report/drawn_surface.h"
#include "tools/report/full_terrain.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace report {

// Where a point of the world is in the picture; nothing at or behind the eye. Pixels from the top left.
std::optional<glm::dvec2> pixelOf(const ig::ViewState& view, const glm::dvec3& relativeToEye) noexcept;

struct SurfaceError {
    uint64_t posts = 0; // measured
    double maxPx = 0;   // infinite where a post is in view and its drawn point behind the eye
    double p99Px = 0;
    double rmsPx = 0;
    uint32_t worstColumn = 0, worstRow = 0; // of the grid
};

// Motion of drawn points since the frame before, both seen from the eye of this one.
struct SurfaceMotion {
    uint64_t posts = 0; // in view and drawn in both frames
    double maxPx = 0;
    uint32_t worstColumn = 0, worstRow = 0;
};

class SurfaceMeter {
public:
    // terrain must outlive it. blockPosts: N, 1, 2, 4, ... 64.
    SurfaceMeter(FullTerrain& terrain, int blockPosts);

    // The next frame has none before it.
    void startFlight();

    // A frame: the sample, and its motion since the last frame that was measured. pagesInView: of the view,
    // by terrain.
    struct Frame {
        SurfaceError error;
        SurfaceMotion motion;
    };
    Frame measure(const std::vector<DrawnTriangle>& triangles, const ig::ViewState& view,
                  const std::vector<uint32_t>& pagesInView);

    // All posts; leaves motion alone.
    SurfaceError measureAll(const std::vector<DrawnTriangle>& triangles, const ig::ViewState& view,
                            const std::vector<uint32_t>& pagesInView);

private:
    // The sampled posts of a page.
    struct Sample {
        uint8_t column = 0, row = 0; // of the page
        int64_t frame = -1;          // that drawn is of
        glm::dvec3 truth{0.0};       // ECEF
        glm::dvec3 drawn{0.0};
    };
    struct Page {
        const FullPage* full = nullptr; // nullptr: not in view
        std::vector<Sample> samples;    // by block, rows of blocks
    };
    void enter(const std::vector<uint32_t>& pagesInView, bool sampled);
    void leave(const std::vector<uint32_t>& pagesInView);
    template <class Visit>
    void forBlocks(const DrawnTriangle& triangle, int blockPosts, Visit&& visit);
    SurfaceError summary();

    FullTerrain& _terrain;
    int _block;
    uint32_t _across;           // deepest pages per row of them
    std::vector<uint32_t> _at;  // by place of a deepest page: its number
    std::vector<Page> _pages;   // by the same place
    std::vector<float> _errors; // scratch
    int64_t _frame = 0;
    SurfaceError _worst; // of the frame at hand
};

} // namespace report
