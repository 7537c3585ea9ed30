// SPDX-License-Identifier: MIT
#include "ig/app/frame_receipt.h"

#include "ig/geo/attitude.h"

#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig::app {

namespace {

// Inverse of eyeFromEcefOfView.
glm::dmat3 ecefFromView(const glm::dmat3& eyeFromEcef)
{
    const glm::dmat3 ecefFromEye = glm::transpose(eyeFromEcef); // columns right, up, backward
    return glm::dmat3(-ecefFromEye[2], ecefFromEye[0], -ecefFromEye[1]);
}

void noteEye(out::Receipt& out, const ViewState& view, const Ellipsoid& ellipsoid)
{
    out.eye_ecef_m[0] = view.eye.m.x;
    out.eye_ecef_m[1] = view.eye.m.y;
    out.eye_ecef_m[2] = view.eye.m.z;
    const Geodetic eye = toGeodetic(view.eye, ellipsoid);
    out.eye_latitude_deg = eye.latitudeRad * kDegPerRad;
    out.eye_longitude_deg = eye.longitudeRad * kDegPerRad;
    out.eye_height_m = eye.heightM;
    const glm::dmat3 nedFromEcef = glm::transpose(ecefFromNed(eye.latitudeRad, eye.longitudeRad));
    const YawPitchRoll attitude = yawPitchRoll(nedFromEcef * ecefFromView(view.eyeFromEcef));
    out.yaw_deg = attitude.yawRad * kDegPerRad;
    out.pitch_deg = attitude.pitchRad * kDegPerRad;
    out.roll_deg = attitude.rollRad * kDegPerRad;
}

} // namespace

out::Receipt receiptOf(const FrameStats& stats, const ViewState& view, const Ellipsoid& ellipsoid,
                       const FrameTimes& times, const std::optional<hostif::HostFrame>& host, bool isNew)
{
    out::Receipt out{};
    out.frame = stats.number;
    out.width_px = static_cast<uint32_t>(view.widthPx);
    out.height_px = static_cast<uint32_t>(view.heightPx);
    out.start_ns = times.startNs;
    out.render_start_ns = times.renderStartNs;
    out.render_end_ns = times.renderEndNs;
    out.display_ns = times.displayNs;
    out.extrapolation_ns = -1;
    if (host) {
        out.flags = EYEPOINT_RECEIPT_HOST;
        if (isNew) {
            out.flags |= EYEPOINT_RECEIPT_NEW_HOST;
        }
        if (host->control.timestampValid) {
            out.flags |= EYEPOINT_RECEIPT_HOST_TIME;
        }
        out.host_frame = host->control.hostFrameNumber;
        out.host_time_ticks = host->control.timestampTicks;
        out.arrival_ns = std::llround(host->arrivalS * 1e9);
        out.extrapolation_ns = std::max<int64_t>(0, times.startNs - out.arrival_ns);
    }
    noteEye(out, view, ellipsoid);
    out.frustum_left = view.frustum.left;
    out.frustum_right = view.frustum.right;
    out.frustum_bottom = view.frustum.bottom;
    out.frustum_top = view.frustum.top;
    out.near_m = view.frustum.nearM;
    out.tau_px = static_cast<double>(stats.lod.tauPx);
    out.error_px = static_cast<double>(stats.lod.errorPx);
    out.triangles = stats.lod.triangles;
    out.missing_tiles = stats.lod.tilesMissing;
    return out;
}

} // namespace ig::app
