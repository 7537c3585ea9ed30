// SPDX-License-Identifier: MIT
#include "tools/report/extrapolation_error.h"

#include "ig/geo/attitude.h"
#include "ig/scene/motion.h"
#include "tools/report/statistics.h"
#include "tools/report/surface_error.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace report {

using namespace ig;

namespace {

constexpr double kPictureHz = 60;
constexpr double kStepS = 1.0 / 1920; // of the true flight: a divisor of every packet interval used here
constexpr double kPointM = 1000;

using State = TrueFlight::State;

struct Manoeuvre {
    double speedMps, rollDegPerS, pitchDegPerS, yawDegPerS;
    double periodS; // of the slowest of them
};
constexpr std::array<Manoeuvre, 3> kManoeuvres{{
    {120, 3, 1, 1, 12},     // an airliner in light air
    {180, 40, 12, 5, 5},    // hard turns
    {250, 200, 40, 25, 2.5} // aerobatics
}};

State extrapolated(Integrator integrator, const State& from, double overS)
{
    State to = from;
    switch (integrator) {
    case Integrator::hold:
        break;
    case Integrator::linear:
        to.placeM += from.nedFromBody * from.velocityMps * overS;
        break;
    case Integrator::eulerRates: {
        to.placeM += from.nedFromBody * from.velocityMps * overS;
        // Rates of the angles from those of the body (kinematic equation of yaw, pitch, roll).
        YawPitchRoll angles = yawPitchRoll(from.nedFromBody);
        const glm::dvec3& w = from.turnRadPerS;
        const double around = w.y * std::sin(angles.rollRad) + w.z * std::cos(angles.rollRad);
        const double cosPitch = std::max(std::abs(std::cos(angles.pitchRad)), 1e-6);
        const double yawRate = around / std::copysign(cosPitch, std::cos(angles.pitchRad));
        const double rollRate = w.x + yawRate * std::sin(angles.pitchRad);
        const double pitchRate = w.y * std::cos(angles.rollRad) - w.z * std::sin(angles.rollRad);
        angles.yawRad += yawRate * overS;
        angles.pitchRad += pitchRate * overS;
        angles.rollRad += rollRate * overS;
        to.nedFromBody = parentFromChild(angles);
        break;
    }
    case Integrator::exponential: {
        const scene::Motion motion =
            scene::motionOver(overS, {true, from.velocityMps, from.turnRadPerS}, from.nedFromBody);
        to.placeM += motion.offsetM;
        to.nedFromBody = motion.parentFromBody;
        break;
    }
    }
    return to;
}

// A number in [0, 1) of a packet, the same on every machine (SplitMix64).
double randomOf(uint64_t packet, uint64_t purpose)
{
    uint64_t value = packet * 2 + purpose + 0x9e3779b97f4a7c15U;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9U;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebU;
    value ^= value >> 31;
    return static_cast<double>(value >> 11) * 0x1p-53;
}

struct Packet {
    double sentS, arrivesS;
};

std::vector<Packet> packetsOf(const Link& link, double durationS)
{
    std::vector<Packet> packets;
    const auto count = static_cast<uint64_t>(durationS * link.packetHz) + 1;
    for (uint64_t i = 0; i < count; ++i) {
        if (i > 0 && randomOf(i, 0) < link.loss) {
            continue;
        }
        const double sentS = static_cast<double>(i) / link.packetHz;
        packets.push_back({sentS, sentS + link.delayS + link.jitterS * randomOf(i, 1)});
    }
    return packets;
}

} // namespace

TrueFlight::TrueFlight(Violence violence, double durationS) : _durationS(durationS)
{
    const Manoeuvre& m = kManoeuvres[static_cast<size_t>(violence)];
    const auto steps = static_cast<size_t>(std::ceil(durationS / kStepS));
    _states.resize(steps + 1);
    for (size_t i = 0; i <= steps; ++i) {
        const double timeS = static_cast<double>(i) * kStepS;
        // Incommensurable sines: nothing repeats within a run.
        const auto wave = [&](double factor, double phase) {
            return std::sin(2 * kPi * timeS / m.periodS * factor + phase);
        };
        State& state = _states[i];
        state.turnRadPerS =
            kRadPerDeg * glm::dvec3(m.rollDegPerS * wave(1.618, 0.3), m.pitchDegPerS * wave(1.0, 1.1),
                                    m.yawDegPerS * wave(1.272, 2.0));
        state.velocityMps = {m.speedMps * (1 + 0.05 * wave(0.5, 0.0)), 0.02 * m.speedMps * wave(0.9, 0.7), 0};
        if (i > 0) {
            const State& last = _states[i - 1];
            const scene::Rates rates{true, 0.5 * (last.velocityMps + state.velocityMps),
                                     0.5 * (last.turnRadPerS + state.turnRadPerS)};
            const scene::Motion motion = scene::motionOver(kStepS, rates, last.nedFromBody);
            state.placeM = last.placeM + motion.offsetM;
            state.nedFromBody = motion.parentFromBody;
        }
    }
}

const TrueFlight::State& TrueFlight::at(double timeS) const noexcept
{
    return _states[std::min(static_cast<size_t>(std::lround(timeS / kStepS)), _states.size() - 1)];
}

ExtrapolationError extrapolationError(Integrator integrator, const TrueFlight& flight, const Link& link,
                                      const ViewState& view)
{
    const std::vector<Packet> packets = packetsOf(link, flight.durationS());
    const Frustum& f = view.frustum;
    std::vector<glm::dvec3> rays; // eye frame
    for (const double x : {f.left, 0.5 * (f.left + f.right), f.right}) {
        for (const double y : {f.bottom, 0.5 * (f.bottom + f.top), f.top}) {
            rays.push_back(kPointM * glm::dvec3(0.98 * x, 0.98 * y, -1));
        }
    }
    std::vector<double> position, angle, pixel;
    for (double timeS = 1; timeS < flight.durationS(); timeS += 1 / kPictureHz) {
        // The newest packet that has come by now, as the image generator sees it.
        const Packet* newest = nullptr;
        for (const Packet& packet : packets) {
            if (packet.sentS > timeS) {
                break;
            }
            newest = packet.arrivesS <= timeS ? &packet : newest;
        }
        if (newest == nullptr) {
            continue;
        }
        const State& truth = flight.at(timeS);
        const State shown = extrapolated(integrator, flight.at(newest->sentS),
                                         std::min(timeS - newest->sentS, link.horizonS));
        position.push_back(glm::length(shown.placeM - truth.placeM));
        const glm::dmat3 off = glm::transpose(truth.nedFromBody) * shown.nedFromBody;
        const glm::dvec3 axis{off[1][2] - off[2][1], off[2][0] - off[0][2], off[0][1] - off[1][0]};
        angle.push_back(std::atan2(glm::length(axis), off[0][0] + off[1][1] + off[2][2] - 1));
        ViewState right = view;
        right.eyeFromEcef = eyeFromEcefOfView(truth.nedFromBody);
        ViewState wrong = view;
        wrong.eyeFromEcef = eyeFromEcefOfView(shown.nedFromBody);
        for (const glm::dvec3& ray : rays) {
            const glm::dvec3 point = truth.placeM + glm::transpose(right.eyeFromEcef) * ray;
            const auto a = pixelOf(right, point - truth.placeM);
            const auto b = pixelOf(wrong, point - shown.placeM);
            if (a && b) {
                pixel.push_back(glm::length(*a - *b));
            }
        }
    }
    const auto rms = [](const std::vector<double>& values) {
        double squares = 0;
        for (const double value : values) {
            squares += value * value;
        }
        return values.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(values.size()));
    };
    const Quantiles pixels = quantilesOf(pixel);
    return {
        rms(position), quantilesOf(position).max, rms(angle), quantilesOf(angle).max, rms(pixel), pixels.p99,
        pixels.max};
}

} // namespace report
