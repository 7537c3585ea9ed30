// SPDX-License-Identifier: MIT
// What a frame costs, learned from what frames have cost:
//
//   costMs = fixed + fill * terrainShare + perTriangle * triangles
//
// terrainShare: of the picture, 0 .. 1. Measured with a software rasteriser (two cores, 1280 x 720): what a
// triangle of the draw list costs varies by a factor of two with the share of them that is in view and faces
// the eye, over a second or so of flight; the other two hold still. So the fit is a Kalman filter of the
// three coefficients as random walks, perTriangle walking twenty times as far a frame as the others.
//
// Against a machine that does other things too: where a frame is off by more than three times the usual
// scatter, the median of the last five counts in its place, so one slow frame or two move nothing; when that
// median is off by more than a factor of 1.3, the machine has become slower or faster as a whole and all
// coefficients follow at once.
//
// Pure: no clock; the same observations give the same model.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ig::lod {

class FrameCostModel {
public:
    // Costs that are not finite, not above 0 or above a minute say nothing and are left out; shares are
    // clamped, what is not a number counts as 0.
    void observe(double costMs, double terrainShare, uint32_t triangles) noexcept;

    bool known() const noexcept { return _known; } // something has been observed

    // ms; 0 before anything is known.
    double predictMs(double terrainShare, double triangles) const noexcept;
    // Standard deviation of the prediction (not of the frame), ms.
    double uncertaintyMs(double terrainShare, double triangles) const noexcept;
    // Triangles for a frame of that cost; negative when not even none would fit.
    double affordableTriangles(double costMs, double terrainShare) const noexcept;

    // Scatter of single frames, as a share of their cost.
    double scatter() const noexcept { return _scatter; }

private:
    using Vector = std::array<double, 3>; // fixed, fill, per 1000 triangles

    static Vector regressors(double terrainShare, double triangles) noexcept;
    Vector covarianceTimes(const Vector& h) const noexcept;
    void rescale(double factor) noexcept;
    double followJump(double ratio) noexcept;
    void walk() noexcept;
    void keepSane() noexcept;

    Vector _ms{};
    std::array<Vector, 3> _covariance{};
    std::array<double, 5> _ratios{}; // cost / prediction of the last frames, in turn
    size_t _nextRatio = 0;
    double _scatter = 0;
    double _lastInnovation = 0; // share of the prediction
    bool _known = false;
};

} // namespace ig::lod
