// SPDX-License-Identifier: MIT
#include "tools/report/motion_part.h"

#include "tools/report/extrapolation_error.h"

#include <string>
#include <vector>

namespace report {

namespace {

constexpr double kMs = 1e-3;

struct Sweep {
    const char* what;
    double Link::*member;
    double scale; // of the values
    std::vector<double> values;
};

} // namespace

Json motionJson(const ig::ViewState& view)
{
    Link base;
    base.packetHz = 60;
    base.horizonS = 100 * kMs;
    base.delayS = 20 * kMs;
    const std::vector<Sweep> sweeps{{"packet rate, Hz", &Link::packetHz, 1, {5, 10, 20, 30, 60, 120}},
                                    {"delay, ms", &Link::delayS, kMs, {0, 10, 20, 50, 100}},
                                    {"jitter, ms", &Link::jitterS, kMs, {0, 5, 10, 20, 50}},
                                    {"loss, %", &Link::loss, 0.01, {0, 1, 5, 10, 20}},
                                    {"horizon, ms", &Link::horizonS, kMs, {0, 10, 20, 50, 100}}};
    std::vector<TrueFlight> flights;
    for (size_t violence = 0; violence < kViolenceNames.size(); ++violence) {
        flights.emplace_back(static_cast<Violence>(violence));
    }
    Json rows = Json::array();
    for (const Sweep& sweep : sweeps) {
        for (const double value : sweep.values) {
            Link link = base;
            link.*sweep.member = value * sweep.scale;
            for (size_t violence = 0; violence < kViolenceNames.size(); ++violence) {
                for (size_t integrator = 0; integrator < kIntegratorNames.size(); ++integrator) {
                    const ExtrapolationError error = extrapolationError(static_cast<Integrator>(integrator),
                                                                        flights[violence], link, view);
                    rows.push_back({{"varied", sweep.what},
                                    {"value", value},
                                    {"flight", std::string(kViolenceNames[violence])},
                                    {"integrator", std::string(kIntegratorNames[integrator])},
                                    {"position_rms_m", rounded(error.positionRmsM)},
                                    {"position_max_m", rounded(error.positionMaxM)},
                                    {"angle_rms_deg", rounded(error.angleRmsRad * ig::kDegPerRad)},
                                    {"angle_max_deg", rounded(error.angleMaxRad * ig::kDegPerRad)},
                                    {"pixel_rms", rounded(error.pixelRms)},
                                    {"pixel_p99", rounded(error.pixelP99)},
                                    {"pixel_max", rounded(error.pixelMax)}});
                }
            }
        }
    }
    return {{"base",
             {{"packet_hz", base.packetHz},
              {"delay_ms", base.delayS / kMs},
              {"jitter_ms", base.jitterS / kMs},
              {"loss_percent", base.loss * 100},
              {"horizon_ms", base.horizonS / kMs},
              {"picture_hz", 60},
              {"points_ahead_m", 1000}}},
            {"rows", std::move(rows)}};
}

} // namespace report
