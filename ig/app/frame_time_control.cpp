// SPDX-License-Identifier: MIT
#include "ig/app/frame_time_control.h"

#include <algorithm>

namespace ig::app {

namespace {

// One pixel in kRowStep * kColumnStep; the columns shift from row to row.
constexpr int kRowStep = 4;
constexpr int kColumnStep = 28;
constexpr int kColumnShift = 11;

} // namespace

double terrainShare(std::span<const std::byte> rgba, int widthPx, int heightPx) noexcept
{
    size_t samples = 0;
    size_t terrain = 0;
    for (int y = 0, first = 0; y < heightPx; y += kRowStep) {
        for (int x = first; x < widthPx; x += kColumnStep) {
            const size_t alpha =
                (static_cast<size_t>(y) * static_cast<size_t>(widthPx) + static_cast<size_t>(x)) * 4 + 3;
            if (alpha >= rgba.size()) {
                break;
            }
            ++samples;
            terrain += rgba[alpha] != std::byte{0} ? 1 : 0;
        }
        first = (first + kColumnShift) % std::min(kColumnStep, std::max(widthPx, 1));
    }
    return samples > 0 ? static_cast<double>(terrain) / static_cast<double>(samples) : 0.0;
}

FrameTimeControl::FrameTimeControl(const lod::BudgetControllerSettings& settings,
                                   const Ellipsoid& ellipsoid) noexcept
    : _controller(settings), _ellipsoid(ellipsoid)
{
}

uint32_t FrameTimeControl::budgetFor(const ViewState& view) noexcept
{
    _belowHorizon = shareBelowHorizon(view, _ellipsoid);
    _share = _belowHorizon + _hillsAndEdges;
    return _controller.budgetFor(_share);
}

void FrameTimeControl::look(const ViewState& view, std::span<const std::byte> rgba) noexcept
{
    _share = terrainShare(rgba, view.widthPx, view.heightPx);
    _hillsAndEdges = _share - _belowHorizon;
}

void FrameTimeControl::observe(const FrameStats& frame) noexcept
{
    _controller.observe(static_cast<double>(frame.frameNs) * 1e-6, _share, frame.lod.triangles);
}

} // namespace ig::app
