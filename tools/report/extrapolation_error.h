// SPDX-License-Identifier: MIT
// How wrong a picture's pose is when it is extrapolated from a host's packets: integrators against packet
// rate, jitter, loss and the largest time that is extrapolated, over flights from calm to violent. Pure
// arithmetic, deterministic, no terrain.
#pragma once

#include "ig/geo/view_state.h"

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace report {

enum class Integrator {
    hold,        // pose of the last packet
    linear,      // its velocity; attitude held
    eulerRates,  // velocity, and yaw, pitch and roll move on at their rates
    exponential, // velocity and rotation as the image generator has them (ig/scene/motion.h)
};
inline constexpr std::array<std::string_view, 4> kIntegratorNames{"hold", "linear", "euler rates",
                                                                  "exponential map"};

enum class Violence { calm, brisk, violent };
inline constexpr std::array<std::string_view, 3> kViolenceNames{"calm", "brisk", "violent"};

// The network between host and image generator.
struct Link {
    double packetHz = 60;
    double jitterS = 0;   // packets arrive up to this much later than the steady delay, uniformly
    double loss = 0;      // share of packets that never come
    double horizonS = 0;  // time that is extrapolated at most; then the pose holds
    double delayS = 0.02; // steady, from the pose to the packet's arrival
};

struct ExtrapolationError {
    double positionRmsM = 0, positionMaxM = 0;
    double angleRmsRad = 0, angleMaxRad = 0;
    // Of points 1,000 m ahead in the middle and the corners of the picture.
    double pixelRms = 0, pixelP99 = 0, pixelMax = 0;
};

// The true flight, in a flat frame (north, east, down).
class TrueFlight {
public:
    struct State {
        glm::dvec3 placeM{0.0};
        glm::dmat3 nedFromBody{1.0};
        glm::dvec3 velocityMps{0.0}; // of the body's axes
        glm::dvec3 turnRadPerS{0.0}; // body axes
    };
    explicit TrueFlight(Violence violence, double durationS = 30);
    double durationS() const noexcept { return _durationS; }
    const State& at(double timeS) const noexcept; // of the nearest step

private:
    double _durationS;
    std::vector<State> _states;
};

// 60 pictures a second over the flight. view: size and frustum.
ExtrapolationError extrapolationError(Integrator integrator, const TrueFlight& flight, const Link& link,
                                      const ig::ViewState& view);

} // namespace report
