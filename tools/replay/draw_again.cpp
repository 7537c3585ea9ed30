// SPDX-License-Identifier: MIT
#include "tools/replay/draw_again.h"

#include "ig/app/flush_denormals.h"
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/output_files.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/out/png_file.h"
#include "tools/replay/frame_hashes.h"
#include "tools/replay/report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

namespace replay {

namespace {

// Keeps the newest frame.
class NewestFrame final : public ig::out::FrameSink {
public:
    ig::Result<void> write(const ig::out::Frame& frame) override
    {
        picture.widthPx = frame.widthPx;
        picture.heightPx = frame.heightPx;
        picture.rgba.assign(frame.rgba.begin(), frame.rgba.end());
        what = {frame.number, frame.receipt->view_id, frame.receipt->host_frame, {}};
        ++_stats.written;
        return {};
    }
    ig::out::SinkStats stats() const override { return _stats; }
    ig::Result<ig::out::SinkStats> close() override { return _stats; }

    ig::out::Picture picture;
    FrameHash what; // but for the hash

private:
    ig::out::SinkStats _stats;
};

// Settings that have no part in the pixels of a replay.
bool mattersHere(const std::string& key)
{
    constexpr std::array<std::string_view, 10> kOthers{"terrain.file",
                                                       "terrain.frame_time_ms",
                                                       "terrain.smallest_triangle_budget",
                                                       "terrain.page_loads_per_frame",
                                                       "terrain.wait_for_pages",
                                                       "view.rate_hz",
                                                       "host.listen",
                                                       "host.record",
                                                       "host.peer",
                                                       "host.database"};
    return !key.starts_with("output.") && !key.starts_with("log.") && !key.starts_with("graphics.") &&
           std::find(kOthers.begin(), kOthers.end(), key) == kOthers.end();
}

constexpr std::string_view kPictures = "pictures";
constexpr std::string_view kDataset = "dataset";
constexpr std::string_view kSize = "size";

// The directory of a sink png:DIR, from anywhere; empty when there is none.
std::string pictureDirectory(const config::Settings& settings)
{
    constexpr std::string_view kPng = "png:";
    for (const std::string& sink : settings.output.sinks) {
        if (sink.starts_with(kPng))
            return std::filesystem::absolute(sink.substr(kPng.size())).string();
    }
    return {};
}

FrameHashes circumstancesOf(const config::Settings& settings, const ig::app::RunSummary& run)
{
    std::array<char, 17> checksum{};
    std::snprintf(checksum.data(), checksum.size(), "%016llx",
                  static_cast<unsigned long long>(run.dataset.checksum));
    FrameHashes out;
    const auto add = [&](std::string_view name, std::string value) {
        out.circumstances.emplace_back(name, std::move(value));
    };
    add("mesa", run.graphics.version);
    add("renderer", run.graphics.renderer);
    add(kDataset, checksum.data());
    add(kSize, std::to_string(settings.view.width) + " x " + std::to_string(settings.view.height));
    if (const std::string pictures = pictureDirectory(settings); !pictures.empty())
        add(kPictures, pictures);
    for (const config::Value& value : config::values(settings)) {
        if (mattersHere(value.name))
            add(value.name, value.text);
    }
    return out;
}

std::string pictureName(uint64_t frame)
{
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "frame_%06llu.png", static_cast<unsigned long long>(frame));
    return name.data();
}

// Compares a run with a reference as it goes.
class Verification {
public:
    // Errors (failed): the reference is of another dataset or size, nothing can be equal; circumstances that
    // may matter are said on standard error.
    static ig::Result<Verification> begin(const DrawOptions& options, const FrameHashes& now)
    {
        auto reference = readFrameHashes(options.verify);
        if (!reference)
            return ig::Unexpected{reference.error()};
        constexpr std::array<std::string_view, 1> kNotCompared{kPictures};
        std::string fatal;
        for (const std::string& difference : differences(*reference, now, kNotCompared)) {
            if (difference.starts_with(kDataset) || difference.starts_with(kSize))
                fatal += (fatal.empty() ? "" : "; ") + difference;
            else
                std::fprintf(stderr, "eyepoint-replay: %s: %s\n", options.verify.c_str(), difference.c_str());
        }
        if (!fatal.empty())
            return ig::fail(ig::ErrorKind::failed, options.verify + " cannot be compared with: " + fatal);
        return Verification(options, std::move(*reference));
    }

    // Error (failed): the frame differs.
    ig::Result<void> look(const FrameHash& now, const ig::out::Picture& picture)
    {
        if (now.hash.empty())
            return {};
        if (_next == _reference.frames.size())
            return ig::fail(ig::ErrorKind::failed, named(now) + " is one more than " + _file + " has");
        const FrameHash& expected = _reference.frames[_next++];
        if (expected.hash == now.hash)
            return {};
        return ig::fail(ig::ErrorKind::failed, named(now) + " differs from frame " +
                                                   std::to_string(expected.frame) + " of " + _file + ", " +
                                                   now.hash + " instead of " + expected.hash + "; " +
                                                   keep(now, expected, picture));
    }

    // Error (failed): the reference goes on.
    ig::Result<void> finish() const
    {
        if (_next < _reference.frames.size())
            return ig::fail(ig::ErrorKind::failed,
                            _file + " goes on where this recording ends, with host frame " +
                                std::to_string(_reference.frames[_next].hostFrame) + " and " +
                                std::to_string(_reference.frames.size() - _next - 1) + " more");
        return {};
    }

private:
    Verification(const DrawOptions& options, FrameHashes reference)
        : _file(options.verify), _directory(options.differenceIn), _reference(std::move(reference)),
          _next(_reference.firstHashed())
    {
    }

    static std::string named(const FrameHash& now)
    {
        return "frame " + std::to_string(now.frame) + " of view " + std::to_string(now.view) +
               " (host frame " + std::to_string(now.hostFrame) + ")";
    }

    // Stores both pictures and says where, or why not.
    std::string keep(const FrameHash& now, const FrameHash& expected, const ig::out::Picture& picture) const
    {
        const auto in = [&](const std::string& name) {
            return (std::filesystem::path(_directory) / name).string();
        };
        const std::string actualPath = in("actual_" + pictureName(now.frame));
        const std::string expectedPath = in("expected_" + pictureName(now.frame));
        std::error_code error;
        std::filesystem::create_directories(_directory, error);
        if (const auto written =
                ig::out::writePng(actualPath, picture.widthPx, picture.heightPx, picture.rgba);
            !written)
            return written.error().message;
        const std::string directory = _reference.circumstance(std::string(kPictures));
        if (directory.empty())
            return "see " + actualPath +
                   "; the reference kept no pictures, which --sink png:DIR beside "
                   "--hashes does";
        const auto from = std::filesystem::path(directory) / pictureName(expected.frame);
        std::filesystem::copy_file(from, expectedPath, std::filesystem::copy_options::overwrite_existing,
                                   error);
        if (error)
            return "see " + actualPath + "; the reference's picture is not at " + from.string() + " (" +
                   error.message() + ")";
        return "see " + expectedPath + " and " + actualPath;
    }

    std::string _file, _directory;
    FrameHashes _reference;
    size_t _next;
};

ig::Result<void> checkOutputs(const DrawOptions& options)
{
    std::vector<ig::app::NamedFile> read{{options.verify, "--verify"}};
    for (const std::string& file : options.files)
        read.push_back({file, "the recording"});
    read.push_back({options.settings.terrain.file, "terrain.file"});
    config::Settings settings = options.settings;
    settings.host.record.clear(); // nothing is recorded of a replay
    std::vector<ig::app::NamedFile> written = ig::app::filesWritten(settings);
    written.push_back({options.hashes, "--hashes"});
    if (auto apart = ig::app::checkApart(read, written); !apart)
        return apart;
    return ig::app::checkWritable(written.back());
}

} // namespace

ig::Result<void> drawAgain(const DrawOptions& options)
{
    if (auto writable = checkOutputs(options); !writable)
        return writable;
    auto recording = Recording::open(options.files, options.port);
    if (!recording)
        return ig::Unexpected{recording.error()};
    ig::app::installSignals();
    ig::app::flushDenormals();
    const auto log = ig::app::makeLog(options.settings.log.level);
    auto made = ig::app::ImageGenerator::createForReplay(options.settings, *log);
    if (!made)
        return ig::Unexpected{made.error()};
    ig::app::ImageGenerator& generator = **made;
    auto owned = std::make_unique<NewestFrame>();
    const NewestFrame& newest = *owned;
    generator.addSink("newest", std::move(owned));

    FrameHashes hashes = circumstancesOf(options.settings, generator.summary(0));
    std::optional<Verification> verification;
    if (!options.verify.empty()) {
        auto begun = Verification::begin(options, hashes);
        if (!begun)
            return ig::Unexpected{begun.error()};
        verification = std::move(*begun);
    }

    const bool hashing = verification || !options.hashes.empty();
    const int64_t startNs = ig::app::steadyNs();
    RecordedDatagram datagram;
    bool placed = false;
    bool ended = true; // at the end of the recording, not before
    ig::Result<void> compared;
    uint64_t frames = 0;
    while (compared && recording->next(datagram)) {
        if (!generator.feed(datagram.payload, datagram.source, datagram.timeNs))
            continue;
        placed = generator.replayFrame(datagram.timeNs).placed || placed;
        ++frames;
        if (hashing) {
            hashes.frames.push_back(newest.what);
            if (placed)
                hashes.frames.back().hash = hashOf(newest.picture.rgba);
            if (verification)
                compared = verification->look(hashes.frames.back(), newest.picture);
        }
        if (ig::app::stopRequested() || frames == options.frames) {
            ended = false;
            break;
        }
    }
    const double drawnInS = static_cast<double>(ig::app::steadyNs() - startNs) * ig::app::kSecondsPerNs;
    const ig::app::RunSummary summary = generator.finish(drawnInS);
    log->finish();
    for (const std::string& line : complaints(*recording))
        std::fprintf(stderr, "eyepoint-replay: %s\n", line.c_str());
    if (frames == 0)
        return nothingThere(options.files);
    const double flightS = static_cast<double>(recording->lengthNs()) * ig::app::kSecondsPerNs;
    std::fprintf(
        stderr,
        "%llu frames of %llu datagrams to %s, %.3f s of flight drawn in %.3f s (%.1f times as fast)\n",
        static_cast<unsigned long long>(frames), static_cast<unsigned long long>(recording->datagrams()),
        hostif::toString(recording->destination().value_or(hostif::Address{})).c_str(), flightS, drawnInS,
        drawnInS > 0 ? flightS / drawnInS : 0.0);
    if (const auto& stats = options.settings.output.stats; !stats.empty()) {
        if (auto written = ig::app::writeFile(stats, generator.statistics().json(summary)); !written)
            return written;
    }
    if (!compared)
        return compared;
    if (ig::app::stopRequested())
        return ig::fail(ig::ErrorKind::failed, "interrupted; no hashes are written");
    if (verification) {
        if (auto finished = ended ? verification->finish() : ig::Result<void>(); !finished)
            return finished;
        std::fprintf(stderr, "every frame is as in %s\n", options.verify.c_str());
    }
    return options.hashes.empty() ? ig::Result<void>() : ig::app::writeFile(options.hashes, toText(hashes));
}

} // namespace replay
