// SPDX-License-Identifier: MIT
#include "tools/frames/ring_reader.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace frames {

namespace {

using ig::ErrorKind;

int64_t monotonicNs()
{
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

struct OpenRing {
    ~OpenRing() { eyepoint_frames_close(&ring); }
    eyepoint_frames ring{};
};

constexpr int64_t kRetryNs = 50'000'000;

// Opens the ring, waiting for it to appear.
ig::Result<void> open(eyepoint_frames& ring, const Options& options, const volatile std::sig_atomic_t& stop)
{
    const int64_t deadlineNs = monotonicNs() + static_cast<int64_t>(options.waitS * 1e9);
    while (true) {
        char why[256] = "";
        if (eyepoint_frames_open(&ring, options.ring.c_str(), why, sizeof why) == EYEPOINT_OK) {
            if (eyepoint_frames_writer_lives(&ring) != 0)
                return {};
            eyepoint_frames_close(&ring);
            std::snprintf(why, sizeof why, "frames of \"%s\": left behind by an image generator that died",
                          options.ring.c_str());
        }
        if (stop != 0 || monotonicNs() >= deadlineNs)
            return ig::fail(ErrorKind::failed, why);
        const timespec pause{0, kRetryNs};
        nanosleep(&pause, nullptr);
    }
}

using Sinks = std::vector<std::unique_ptr<ig::out::FrameSink>>;

ig::Result<Sinks> makeSinks(const Options& options, const eyepoint_frames& ring)
{
    Sinks sinks;
    for (const std::string& name : options.sinks) {
        if (name.starts_with("shm:"))
            return ig::fail(ErrorKind::usage, fmt::format("--to {}: frames are in a ring already", name));
        auto sink = ig::out::makeSink(
            name, {static_cast<int>(ring.width_px), static_cast<int>(ring.height_px), ring.rate_hz});
        if (!sink)
            return ig::Unexpected{sink.error()};
        sinks.push_back(std::move(*sink));
    }
    return sinks;
}

void note(Report& report, const eyepoint_receipt& receipt, int64_t copiedNs)
{
    ++report.frames;
    report.newest = receipt;
    report.handOver.add(copiedNs - receipt.publish_ns);
    report.startToPublished.add(receipt.publish_ns - receipt.start_ns);
    if ((receipt.flags & EYEPOINT_RECEIPT_NEW_HOST) != 0)
        report.hostToPublished.add(receipt.publish_ns - receipt.arrival_ns);
}

const char* endingOf(int status)
{
    switch (status) {
    case EYEPOINT_TIMEOUT:
        return "no new frame in time";
    case EYEPOINT_ENDED:
        return "the image generator closed the ring";
    case EYEPOINT_GONE:
        return "the image generator died";
    default:
        return "stopped";
    }
}

nlohmann::ordered_json milliseconds(const ig::Histogram& histogram)
{
    return {{"mean", histogram.meanNs() * 1e-6},
            {"p50", histogram.quantileNs(0.5) * 1e-6},
            {"p99", histogram.quantileNs(0.99) * 1e-6},
            {"max", histogram.maxNs() * 1e-6}};
}

} // namespace

ig::Result<Report> follow(const Options& options, const volatile std::sig_atomic_t& stop)
{
    OpenRing owner;
    eyepoint_frames& ring = owner.ring;
    if (auto opened = open(ring, options, stop); !opened)
        return ig::Unexpected{opened.error()};
    auto sinks = makeSinks(options, ring);
    if (!sinks)
        return ig::Unexpected{sinks.error()};
    std::vector<std::byte> rgba(eyepoint_colour_bytes(&ring));
    Report report;
    const int64_t startNs = monotonicNs();
    // A slice at a time, so that a signal ends the wait.
    const int kSliceMs = 200;
    int64_t waitedMs = 0;
    int status = EYEPOINT_OK;
    uint64_t index = eyepoint_frames_newest(&ring);
    while (stop == 0 && (options.count == 0 || report.frames < options.count)) {
        status = eyepoint_frames_wait(&ring, index, kSliceMs);
        if (status == EYEPOINT_TIMEOUT && static_cast<double>(waitedMs += kSliceMs) < options.waitS * 1e3)
            continue;
        if (status != EYEPOINT_OK)
            break;
        waitedMs = 0;
        eyepoint_receipt receipt{};
        const uint64_t next = index;
        if (eyepoint_frames_copy(&ring, index, &receipt, rgba.data(), nullptr) == EYEPOINT_OK) {
            note(report, receipt, monotonicNs());
            for (auto& sink : *sinks) {
                if (auto written = sink->write({static_cast<int>(ring.width_px),
                                                static_cast<int>(ring.height_px),
                                                rgba,
                                                receipt.frame,
                                                {},
                                                &receipt});
                    !written)
                    return ig::Unexpected{written.error()};
            }
            index = eyepoint_frames_following(&ring, index);
            report.overtaken += index - next - 1;
        } else {
            index = eyepoint_frames_following(&ring, index);
            report.overtaken += index - next;
        }
    }
    report.ending = options.count > 0 && report.frames == options.count ? "all frames taken"
                                                                        : endingOf(stop != 0 ? -1 : status);
    report.durationS = static_cast<double>(monotonicNs() - startNs) * 1e-9;
    for (auto& sink : *sinks) {
        const auto closed = sink->close();
        if (!closed)
            return ig::Unexpected{closed.error()};
        report.sinkDropped += closed->dropped;
    }
    return report;
}

std::string jsonReport(const Report& report)
{
    const eyepoint_receipt& newest = report.newest;
    const nlohmann::ordered_json json{{"frames", report.frames},
                                      {"overtaken", report.overtaken},
                                      {"sink_dropped", report.sinkDropped},
                                      {"duration_s", report.durationS},
                                      {"ending", report.ending},
                                      {"published_to_copied_ms", milliseconds(report.handOver)},
                                      {"host_to_published_ms", milliseconds(report.hostToPublished)},
                                      {"start_to_published_ms", milliseconds(report.startToPublished)},
                                      {"newest",
                                       {{"frame", newest.frame},
                                        {"latitude_deg", newest.eye_latitude_deg},
                                        {"longitude_deg", newest.eye_longitude_deg},
                                        {"height_m", newest.eye_height_m},
                                        {"triangles", newest.triangles},
                                        {"tau_px", newest.tau_px},
                                        {"error_px", newest.error_px},
                                        {"missing_tiles", newest.missing_tiles}}}};
    return json.dump(2) + "\n";
}

} // namespace frames
