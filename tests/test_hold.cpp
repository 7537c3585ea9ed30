// SPDX-License-Identifier: MIT
// Frames that are held (output.hold_ms): when they are handed out, what for, and that nothing else changes.
#include "hostif/udp_socket.h"
#include "ig/app/steady_clock.h"
#include "process.h"
#include "small_hills.h"

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

using namespace test;

namespace {

using ig::app::FrameStats;
using ig::app::ImageGenerator;
using ig::app::steadyNs;

constexpr int64_t kNsPerMs = 1'000'000;
constexpr int64_t kNsPerS = 1'000'000'000;

// Keeps the receipts, and when they came.
struct Receipts : ig::out::FrameSink {
    struct Taken {
        ig::out::Receipt receipt;
        int64_t atNs = 0;
    };
    explicit Receipts(std::vector<Taken>& into) : taken(into) {}
    ig::Result<void> write(const ig::out::Frame& frame) override
    {
        taken.push_back({*frame.receipt, steadyNs()});
        return {};
    }
    ig::out::SinkStats stats() const override { return {}; }
    ig::Result<ig::out::SinkStats> close() override { return ig::out::SinkStats(); }
    std::vector<Taken>& taken;
};

std::vector<nlohmann::json> linesOf(const std::string& file)
{
    std::vector<nlohmann::json> lines;
    std::istringstream text(readFile(file));
    for (std::string line; std::getline(text, line);) {
        lines.push_back(nlohmann::json::parse(line));
    }
    return lines;
}

int64_t at(const nlohmann::json& receipt, const char* key)
{
    return receipt[key].get<int64_t>();
}

// Two views over the hills, at the same rate.
struct TwoViews : SmallHills {
    TwoViews()
    {
        settings.views.resize(2);
        for (size_t i = 0; i < 2; ++i) {
            settings.views[i].id = static_cast<int64_t>(i);
            settings.views[i].yawDeg = 40.0 * static_cast<double>(i);
        }
    }

    // So many slots from one on, each started when the one before has ended.
    static void fly(ImageGenerator& generator, uint64_t from, uint64_t frames)
    {
        for (uint64_t slot = from; slot < from + frames; ++slot) {
            const int64_t startNs = steadyNs();
            REQUIRE(generator.frame(startNs, slot).size() == 2);
            generator.prepare(startNs);
        }
    }
};

} // namespace

TEST_CASE_METHOD(SmallHills,
                 "no frame is handed out before its hold, counted from where its slot was to start")
{
    if (!hasDriver()) {
        return;
    }
    settings.output.holdMs = 20;
    const auto generator = generatorOf(settings, log);
    std::vector<Receipts::Taken> taken;
    generator->addSink("taken", std::make_unique<Receipts>(taken));
    for (uint64_t slot = 0; slot < 4; ++slot) {
        const int64_t startNs = steadyNs();
        const int64_t slotStartNs = startNs - static_cast<int64_t>(slot) * kNsPerMs; // awake the later
        const int64_t dueNs = slotStartNs + 20 * kNsPerMs;
        const FrameStats stats = generator->frame(startNs, slot, slotStartNs).front();
        CHECK(stats.handedOutNs >= 20 * kNsPerMs);
        REQUIRE(taken.size() == slot + 1);
        const ig::out::Receipt& receipt = taken.back().receipt;
        CHECK(taken.back().atNs >= dueNs);
        CHECK(stats.handedOutNs >= taken.back().atNs - slotStartNs);
        CHECK(receipt.publish_ns >= dueNs);
        CHECK(receipt.display_ns == dueNs);
        CHECK(receipt.start_ns == startNs);
        CHECK(receipt.render_end_ns <= receipt.publish_ns);
    }
}

TEST_CASE_METHOD(SmallHills,
                 "a frame that is later than its hold is handed out at once, and drawn for no time past")
{
    if (!hasDriver()) {
        return;
    }
    settings.output.holdMs = 10'000;
    const auto generator = generatorOf(settings, log);
    std::vector<Receipts::Taken> taken;
    generator->addSink("taken", std::make_unique<Receipts>(taken));
    const int64_t startNs = steadyNs();
    const FrameStats stats = generator->frame(startNs, 0, startNs - 15 * kNsPerS).front();
    CHECK(steadyNs() - startNs < 10 * kNsPerS); // what another hold would take
    CHECK(stats.handedOutNs >= 15 * kNsPerS);
    REQUIRE(taken.size() == 1);
    CHECK(taken.front().receipt.display_ns == startNs);
}

TEST_CASE_METHOD(TwoViews,
                 "of held views all are drawn before the first is handed out, then all are, in order")
{
    if (!hasDriver()) {
        return;
    }
    settings.output.holdMs = 20;
    settings.views[0].receipts = dir.file("0.jsonl");
    settings.views[1].receipts = dir.file("1.jsonl");
    const auto generator = generatorOf(settings, log);
    fly(*generator, 0, 3);
    // And handed out as soon as they are there again, one before the other is drawn, by a reload.
    config::Settings atOnce = settings;
    atOnce.output.holdMs = 0;
    REQUIRE(generator->apply(atOnce));
    fly(*generator, 3, 3);
    REQUIRE(generator->apply(settings));
    fly(*generator, 6, 3);
    generator->finish(1);
    const auto first = linesOf(dir.file("0.jsonl"));
    const auto second = linesOf(dir.file("1.jsonl"));
    REQUIRE(first.size() == 9);
    REQUIRE(second.size() == 9);
    for (size_t i = 0; i < 9; ++i) {
        INFO(i);
        CHECK(at(first[i], "start_ns") == at(second[i], "start_ns"));
        CHECK(at(first[i], "publish_ns") <= at(second[i], "publish_ns"));
        const bool isHeld = i / 3 != 1;
        if (isHeld) {
            CHECK(at(first[i], "publish_ns") - at(first[i], "start_ns") >= 20 * kNsPerMs);
            CHECK(at(second[i], "render_end_ns") <= at(first[i], "publish_ns"));
        } else {
            CHECK(at(first[i], "publish_ns") <= at(second[i], "render_start_ns"));
        }
        CHECK(at(first[i], "display_ns") - at(first[i], "start_ns") == (isHeld ? 20'000'000 : 16'666'667));
    }
}

TEST_CASE_METHOD(TwoViews, "what a slot's frames were held for is no part of what they cost together")
{
    if (!hasDriver()) {
        return;
    }
    settings.output.holdMs = 200; // which one of three costs less than on any machine
    const auto generator = generatorOf(settings, log);
    fly(*generator, 0, 3);
    const auto json = nlohmann::json::parse(generator->statistics().json(generator->summary(1)));
    CHECK(generator->statistics().frameTime().quantileNs(0.01) < 200 * kNsPerMs);
    CHECK(json["handed_out_ms"]["mean"].get<double>() >= 200);
    for (const auto& view : json["views"]) {
        CHECK(view["handed_out_ms"]["mean"].get<double>() >= 200);
    }
}

TEST_CASE_METHOD(TwoViews, "held frames show what others show, in every sink")
{
    if (!hasDriver()) {
        return;
    }
    const auto shown = [this](double holdMs, const std::string& name) {
        settings.output.holdMs = holdMs;
        std::string bytes;
        for (size_t i = 0; i < 2; ++i) {
            settings.views[i].sinks = {"raw:" + dir.file(name + std::to_string(i)), "null"};
        }
        {
            const auto generator = generatorOf(settings, log);
            fly(*generator, 0, 3);
            generator->finish(1);
        }
        for (size_t i = 0; i < 2; ++i) {
            bytes += readFile(dir.file(name + std::to_string(i)));
        }
        return bytes;
    };
    const std::string atOnce = shown(0, "at_once");
    CHECK(atOnce.size() == size_t{2} * 3 * 320 * 180 * 4);
    CHECK((shown(10, "held") == atOnce));
}

TEST_CASE_METHOD(SmallHills, "what is left until a frame is due goes to pages")
{
    if (!hasDriver()) {
        return;
    }
    // Which pages are resident when a frame is handed out.
    struct Counts : ig::out::FrameSink {
        Counts(const ImageGenerator& from, uint32_t& into) : generator(from), pages(into) {}
        ig::Result<void> write(const ig::out::Frame&) override
        {
            pages = generator.summary(0).residentPages;
            return {};
        }
        ig::out::SinkStats stats() const override { return {}; }
        ig::Result<ig::out::SinkStats> close() override { return ig::out::SinkStats(); }
        const ImageGenerator& generator;
        uint32_t& pages;
    };
    settings.terrain.file = makeDataset(dir, "larger", hills, 513); // 85 pages, loaded at leisure
    settings.terrain.waitForPages = false;
    settings.terrain.pageLoadsPerFrame = 4;
    settings.output.holdMs = 300; // of which a frame leaves some on any machine
    const auto generator = generatorOf(settings, log);
    uint32_t pages = 0, before = generator->summary(0).residentPages;
    REQUIRE(before < 80);
    generator->addSink("counts", std::make_unique<Counts>(*generator, pages));
    uint32_t early = 0; // that came after their frame was drawn and are the next one's
    for (uint64_t slot = 0; slot < 10 && early == 0; ++slot) {
        const FrameStats stats = generator->frame(steadyNs(), slot).front();
        early = pages - before - stats.pageIns;
        before = pages;
    }
    CHECK(early > 0);
    CHECK(early <= 4);
}

TEST_CASE_METHOD(SmallHills, "the world moves on to when a held frame is handed out")
{
    if (!hasDriver()) {
        return;
    }
    settings.host.listen = "127.0.0.1:0";
    settings.host.extrapolationS = 10;
    settings.host.timeoutS = 3'600;
    const auto generator = generatorOf(settings, log);
    std::vector<Receipts::Taken> taken;
    generator->addSink("taken", std::make_unique<Receipts>(taken));

    constexpr float kSpeedMps = 100;
    std::vector<std::byte> bytes;
    const auto say = [&bytes](const auto& message) {
        append(hostif::Protocol::cigi3, bytes, hostif::ByteOrder::little, message);
    };
    hostif::IgControl control;
    control.mode = hostif::IgMode::operate;
    control.hostFrameNumber = 1;
    control.extrapolationEnable = true;
    say(control);
    hostif::EntityControl ownship;
    ownship.state = hostif::EntityState::active;
    ownship.extrapolationEnable = true;
    ownship.latitudeDegOrXM = 57.45;
    ownship.longitudeDegOrYM = -4.9;
    ownship.altitudeOrZM = 900;
    say(hostif::HostMessage(ownship));
    hostif::RateControl rate;
    rate.xMps = kSpeedMps;
    say(hostif::HostMessage(rate));
    const std::string said = generator->description();
    const size_t address = said.find("127.0.0.1:");
    REQUIRE(address != std::string::npos);
    auto socket = hostif::UdpSocket::open(*hostif::parseAddress("127.0.0.1:0"));
    REQUIRE(socket);
    socket->send(bytes, *hostif::parseAddress(said.substr(address, said.find(' ', address) - address)));

    uint64_t slot = 0;
    bool placed = false;
    for (int i = 0; i < 1'000 && !placed; ++i) {
        placed = generator->frame(steadyNs(), slot++).front().placed;
    }
    REQUIRE(placed);
    taken.clear();
    for (const double holdMs : {0.0, 40.0, 7.0}) {
        settings.output.holdMs = holdMs;
        REQUIRE(generator->apply(settings));
        generator->frame(steadyNs(), slot++);
    }
    REQUIRE(taken.size() == 3);
    const auto wayM = [&](size_t from, size_t to) {
        const auto& a = taken[from].receipt.eye_ecef_m;
        const auto& b = taken[to].receipt.eye_ecef_m;
        return glm::length(glm::dvec3(b[0], b[1], b[2]) - glm::dvec3(a[0], a[1], a[2]));
    };
    for (size_t i = 1; i < taken.size(); ++i) {
        const ig::out::Receipt& before = taken[i - 1].receipt;
        const ig::out::Receipt& now = taken[i].receipt;
        REQUIRE(now.host_frame == before.host_frame);
        CHECK(now.display_ns - now.start_ns == (i == 1 ? 40 : 7) * kNsPerMs);
        const double apartS = static_cast<double>(now.display_ns - before.display_ns) * 1e-9;
        CHECK(wayM(i - 1, i) == Approx(kSpeedMps * std::abs(apartS)).margin(1e-3));
    }
}

TEST_CASE_METHOD(SmallHills, "a recording is drawn again without waiting, whatever the hold")
{
    if (!hasDriver()) {
        return;
    }
    const auto shown = [this](double holdMs) {
        settings.output.holdMs = holdMs;
        auto made = ImageGenerator::createForReplay(settings, log);
        REQUIRE(made);
        REQUIRE((*made)->apply(settings)); // a reload brings none, either
        std::vector<std::byte> newest, pictures;
        (*made)->addSink("kept", std::make_unique<Kept>(newest));
        const int64_t startNs = steadyNs();
        for (uint32_t frame = 0; frame < 3; ++frame) {
            HostFrame host(frame, 900);
            const int64_t timeNs = startNs + frame * 20 * kNsPerMs;
            if ((*made)->feed(host.bytes, HostFrame::kFrom, timeNs)) {
                (*made)->replayFrame(timeNs);
                pictures.insert(pictures.end(), newest.begin(), newest.end());
            }
        }
        CHECK(steadyNs() - startNs < 10 * kNsPerS); // what one hold would take
        return pictures;
    };
    const std::vector<std::byte> without = shown(0);
    CHECK_FALSE(without.empty());
    CHECK((shown(10'000) == without));
}
