// SPDX-License-Identifier: MIT
// Image generators over a little land and in a small picture, and what they show.
#pragma once

#include "hostif/codec.h"
#include "hostif/protocol.h"
#include "ig/app/image_generator.h"
#include "ig/gl/context.h"
#include "land_grid.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace test {

inline bool hasDriver()
{
    const bool has = static_cast<bool>(ig::gl::Context::create({}));
    if (!has) {
        WARN("skipped: no usable EGL");
    }
    return has;
}

using Height = std::function<double(uint32_t col, uint32_t row)>;

inline double hills(uint32_t col, uint32_t row)
{
    return 300 + 200 * std::sin(col * 0.11) * std::cos(row * 0.07);
}

inline double hillsWithAHole(uint32_t col, uint32_t row)
{
    return col / 40 == 3 && row / 40 == 2 ? std::nan("") : hills(col, row);
}

inline std::string makeDataset(const TempDir& dir, const std::string& name, const Height& heightM,
                               uint32_t posts = 257)
{
    const std::string path = dir.file(name + ".ept");
    REQUIRE(ig::terrain::compileHeights(posts, posts, landGrid(57.5, -5.0), heightM, path));
    return path;
}

inline config::Settings smallPicture(const std::string& terrain)
{
    config::Settings settings;
    settings.terrain.file = terrain;
    settings.terrain.pageCacheMib = 42;
    settings.view.width = 320;
    settings.view.height = 180;
    return settings;
}

struct Silent : ig::LogSink {
    void write(ig::LogLevel, std::string_view) override {}
};

// Keeps the newest picture.
struct Kept : ig::out::FrameSink {
    explicit Kept(std::vector<std::byte>& picture) : last(picture) {}
    ig::Result<void> write(const ig::out::Frame& frame) override
    {
        last.assign(frame.rgba.begin(), frame.rgba.end());
        return {};
    }
    ig::out::SinkStats stats() const override { return {}; }
    ig::Result<ig::out::SinkStats> close() override { return ig::out::SinkStats(); }
    std::vector<std::byte>& last;
};

// The frames of a slot at 60 Hz.
inline void drawSlot(ig::app::ImageGenerator& generator, uint64_t slot)
{
    generator.frame(1'000'000'000 + static_cast<int64_t>(slot) * 16'666'667, slot);
}

// What the first view shows after some frames of a run.
inline std::vector<std::byte> pictureOf(ig::app::ImageGenerator& generator, uint64_t firstSlot = 0)
{
    std::vector<std::byte> picture;
    generator.addSink("kept", std::make_unique<Kept>(picture));
    for (uint64_t slot = firstSlot; slot < firstSlot + 3; ++slot) {
        drawSlot(generator, slot);
    }
    generator.finish(0.05);
    REQUIRE_FALSE(picture.empty());
    return picture;
}

inline std::unique_ptr<ig::app::ImageGenerator> generatorOf(const config::Settings& settings,
                                                            ig::LogSink& log)
{
    auto made = ig::app::ImageGenerator::create(settings, log);
    REQUIRE(made);
    return *std::move(made);
}

// The messages of a host's frame: its ownship over the hills at a height, and what else it has to say.
class HostFrame {
public:
    HostFrame(uint32_t number, double altitudeM)
    {
        hostif::IgControl control;
        control.mode = hostif::IgMode::operate;
        control.hostFrameNumber = 100 + number;
        control.countsFrames = true;
        say(control);
        hostif::EntityControl ownship;
        ownship.state = hostif::EntityState::active;
        ownship.latitudeDegOrXM = 57.45 + 1e-4 * number;
        ownship.longitudeDegOrYM = -4.9;
        ownship.altitudeOrZM = altitudeM;
        ownship.pitchDeg = -10;
        say(hostif::HostMessage(ownship));
    }

    template <class Message>
    void say(const Message& message)
    {
        append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, message);
    }

    static constexpr hostif::Address kFrom{.port = 40'000, .ip = {10, 0, 0, 1}};
    std::vector<std::byte> bytes;
};

// Hills in a small picture that waits for its pages, and no host.
struct SmallHills {
    SmallHills()
    {
        settings.host.listen.clear();
        settings.terrain.waitForPages = true;
    }

    TempDir dir;
    Silent log;
    config::Settings settings = smallPicture(makeDataset(dir, "whole", hills));
};

} // namespace test
