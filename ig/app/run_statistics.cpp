// SPDX-License-Identifier: MIT
#include "ig/app/run_statistics.h"

#include "hostif/protocol.h"

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>

namespace ig::app {

namespace {

using Json = nlohmann::ordered_json;

Json milliseconds(const Histogram& histogram)
{
    const auto ms = [](double ns) { return ns * 1e-6; };
    return {{"mean", ms(histogram.meanNs())},           {"p50", ms(histogram.quantileNs(0.5))},
            {"p95", ms(histogram.quantileNs(0.95))},    {"p99", ms(histogram.quantileNs(0.99))},
            {"p99.9", ms(histogram.quantileNs(0.999))}, {"max", ms(histogram.maxNs())}};
}

Json extentOf(const Extent& extent, uint64_t frames)
{
    return {{"mean", extent.sum / std::max<double>(1.0, static_cast<double>(frames))}, {"max", extent.max}};
}

Json packets(const RunSummary& run)
{
    const auto& protocol = run.session.protocol;
    Json json{{"protocol", protocol ? std::string(hostif::protocolName(*protocol)) : std::string()},
              {"datagrams", run.session.datagrams},
              {"accepted", run.session.accepted},
              {"lost", run.session.lost},
              {"duplicate", run.session.duplicate},
              {"late", run.session.late},
              {"host_restarts", run.session.restarts},
              {"host_losses", run.session.hostLosses},
              {"ignored_in_standby", run.session.ignoredInStandby},
              {"responses", run.session.responses},
              {"responses_dropped", run.session.responsesDropped},
              {"requests", run.queries.requests},
              {"requests_unanswered", run.queries.unanswered},
              {"answers_from_coarse_terrain", run.queries.coarse},
              {"refused_by_world", run.refusedByWorld},
              {"host_lag_frames", run.session.hostLagFrames},
              {"host_lag_frames_max", run.session.hostLagMaxFrames},
              {"sent", run.socket.sent},
              {"sends_failed", run.socket.sendsFailed},
              {"receive_errors", run.socket.receiveErrors},
              {"dropped_by_kernel", run.socket.dropped},
              {"shielded_frames", run.shieldedFrames}};
    if (run.recorded) {
        json["recorded"] = run.recorded->written;
        json["recording_dropped"] = run.recorded->dropped;
    }
    for (size_t i = 0; i < hostif::kReasonCount; ++i) {
        const auto reason = static_cast<hostif::Reason>(i);
        json[std::string(hostif::reasonName(reason))] = run.session.reasons[reason];
    }
    return json;
}

Json terrain(const RunSummary& run)
{
    char checksum[17];
    std::snprintf(checksum, sizeof checksum, "%016llx",
                  static_cast<unsigned long long>(run.dataset.checksum));
    return {{"source", run.dataset.source},
            {"checksum", checksum},
            {"cols", run.dataset.shape.cols},
            {"rows", run.dataset.shape.rows},
            {"vertical_datum", run.dataset.verticalDatum},
            {"damaged_pages", run.damagedPages}};
}

uint64_t peakResidentBytes()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<uint64_t>(usage.ru_maxrss) * 1024;
}

} // namespace

void RunStatistics::add(const FrameStats& frame) noexcept
{
    _frameTime.add(frame.frameNs);
    _host.add(frame.hostNs);
    _select.add(frame.selectNs);
    _draw.add(frame.drawNs);
    _readBack.add(frame.readBackNs);
    _sink.add(frame.sinkNs);
    _load.add(frame.loadNs);
    if (frame.transportDelayNs >= 0) {
        _transportDelay.add(frame.transportDelayNs);
    }
    _handedOut.add(frame.handedOutNs);
    _triangles.add(frame.lod.triangles);
    _tauPx.add(frame.lod.tauPx);
    _errorPx.add(frame.lod.errorPx);
    _verticesEvaluated += frame.lod.verticesEvaluated;
    _listsMade += frame.lod.listsMade;
    _tilesVisited += frame.lod.tilesVisited;
    _visitNs.add(static_cast<double>(frame.lod.visitNs));
    _evaluateNs.add(static_cast<double>(frame.lod.evaluateNs));
    _listsNs.add(static_cast<double>(frame.lod.listsNs));
    _gatherNs.add(static_cast<double>(frame.lod.gatherNs));
    _boundNs.add(static_cast<double>(frame.lod.boundNs));
    _trials += frame.lod.trials;
    _tilesCulled += frame.lod.tilesCulled;
    _listBytes += frame.listBytes;
    _selectionsKept += frame.selectionKept ? 1 : 0;
    _picturesKept += frame.pictureKept ? 1 : 0;
    _framesWithMissingTiles += frame.lod.tilesMissing > 0 ? 1 : 0;
    _pageIns += frame.pageIns;
    _bytesUploaded += frame.bytesUploaded;
    _overBudget += frame.lod.triangles > frame.triangleBudget ? 1 : 0;
    _budget.add(frame.triangleBudget);
    _smallestBudget = std::min(_smallestBudget, frame.triangleBudget);
    _reversals.add(frame.triangleBudget);
}

nlohmann::ordered_json RunStatistics::triangles(uint32_t largestBudget) const
{
    Json triangles = extentOf(_triangles, frames());
    triangles["budget"] = largestBudget;
    triangles["budget_mean"] = extentOf(_budget, frames())["mean"];
    triangles["budget_min"] = frames() > 0 ? _smallestBudget : 0;
    triangles["frames_over_budget"] = _overBudget;
    return triangles;
}

nlohmann::ordered_json RunStatistics::ofView(const RunSummary::View& view) const
{
    return {{"id", view.id},
            {"width", view.widthPx},
            {"height", view.heightPx},
            {"rate_hz", view.rateHz},
            {"frames", frames()},
            {"missed", view.missedFrames},
            {"frame_ms", milliseconds(_frameTime)},
            {"select_ms", milliseconds(_select)},
            {"draw_ms", milliseconds(_draw)},
            {"read_back_ms", milliseconds(_readBack)},
            {"sink_ms", milliseconds(_sink)},
            {"transport_delay_ms", milliseconds(_transportDelay)},
            {"handed_out_ms", milliseconds(_handedOut)},
            {"triangles", triangles(view.triangleBudget)},
            {"tau_px", extentOf(_tauPx, frames())},
            {"error_px", extentOf(_errorPx, frames())},
            {"frames_with_missing_tiles", _framesWithMissingTiles},
            {"page_ins", _pageIns}};
}

std::string RunStatistics::json(const RunSummary& run) const
{
    const double count = std::max<double>(1.0, static_cast<double>(frames()));
    const auto perFrame = [&](uint64_t total) { return static_cast<double>(total) / count; };
    const auto extent = [&](const Extent& e) { return extentOf(e, frames()); };
    const auto stage = [&](const Extent& ns) {
        return Json{{"mean", ns.sum / count * 1e-6}, {"max", ns.max * 1e-6}};
    };
    Json sinks = Json::array();
    for (const RunSummary::Sink& sink : run.sinks) {
        sinks.push_back({{"name", sink.name},
                         {"view", sink.view},
                         {"written", sink.stats.written},
                         {"dropped", sink.stats.dropped}});
    }
    Json views = Json::array();
    for (const RunSummary::View& view : run.views) {
        views.push_back(view.statistics->ofView(view));
    }
    const double minutes = run.durationS / 60.0;
    const auto perMinute = [&](uint64_t n) { return minutes > 0 ? static_cast<double>(n) / minutes : 0.0; };
    const Json json{{"frames", frames()},
                    {"missed", run.missedFrames},
                    {"rate_hz", run.rateHz},
                    {"duration_s", run.durationS},
                    {"frame_ms", milliseconds(_frameTime)},
                    {"host_ms", milliseconds(_host)},
                    {"select_ms", milliseconds(_select)},
                    {"select_stages_ms",
                     {{"visit", stage(_visitNs)},
                      {"evaluate", stage(_evaluateNs)},
                      {"make_lists", stage(_listsNs)},
                      {"gather", stage(_gatherNs)},
                      {"bound", stage(_boundNs)}}},
                    {"budget_trials_per_frame", perFrame(_trials)},
                    {"draw_ms", milliseconds(_draw)},
                    {"read_back_ms", milliseconds(_readBack)},
                    {"sink_ms", milliseconds(_sink)},
                    {"load_ms", milliseconds(_load)},
                    {"transport_delay_ms", milliseconds(_transportDelay)},
                    {"handed_out_ms", milliseconds(_handedOut)},
                    {"triangles", triangles(run.triangleBudget)},
                    {"tau_px", extent(_tauPx)},
                    {"error_px", extent(_errorPx)},
                    {"vertices_evaluated_per_frame", perFrame(_verticesEvaluated)},
                    {"lists_made_per_frame", perFrame(_listsMade)},
                    {"tiles_visited_per_frame", perFrame(_tilesVisited)},
                    {"tiles_culled_per_frame", perFrame(_tilesCulled)},
                    {"list_bytes_per_frame", perFrame(_listBytes)},
                    {"frames_not_selected_again", _selectionsKept},
                    {"frames_not_drawn_again", _picturesKept},
                    {"frames_with_missing_tiles", _framesWithMissingTiles},
                    {"page_ins", _pageIns},
                    {"bytes_read", run.bytesRead},
                    {"bytes_uploaded", _bytesUploaded},
                    {"resident_pages", run.residentPages},
                    {"page_slots", run.pageSlots},
                    {"resident_bytes", peakResidentBytes()},
                    {"gpu_bytes", run.gpuBytes},
                    {"reversals_per_minute", perMinute(_reversals.reversals())},
                    {"turns_per_minute", perMinute(_reversals.turns())},
                    {"packets", packets(run)},
                    {"terrain", terrain(run)},
                    {"graphics",
                     {{"platform", run.graphics.platform},
                      {"vendor", run.graphics.vendor},
                      {"renderer", run.graphics.renderer},
                      {"version", run.graphics.version},
                      {"clip_control", run.graphics.clipControl}}},
                    {"sinks", sinks},
                    {"views", views}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace ig::app
