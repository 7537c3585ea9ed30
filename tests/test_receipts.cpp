// SPDX-License-Identifier: MIT
// Receipts: what they say of a frame, and how they are stored.
#include "ig/app/frame_receipt.h"
#include "ig/geo/attitude.h"
#include "ig/out/receipt_sink.h"
#include "process.h"
#include "temp_dir.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>

using namespace ig;

namespace {

hostif::HostFrame hostFrame()
{
    hostif::HostFrame host;
    host.arrivalS = 100.25;
    host.control.hostFrameNumber = 4'000'000'000U;
    host.control.timestampValid = true;
    host.control.timestampTicks = 77;
    return host;
}

} // namespace

TEST_CASE("a receipt gives the eyepoint back that the view was made of")
{
    for (const auto& [yaw, pitch, roll] : {std::array{1.0, 0.0, 0.0}, std::array{90.0, -20.0, 5.0},
                                           std::array{301.5, 44.0, -170.0}, std::array{179.0, 80.0, 90.0}}) {
        for (const auto& [latitude, longitude] :
             {std::pair{57.0, -5.0}, std::pair{-33.0, 179.9}, std::pair{0.0, 0.0}}) {
            CAPTURE(yaw, pitch, roll, latitude, longitude);
            ViewState view;
            const Geodetic eye{latitude * kRadPerDeg, longitude * kRadPerDeg, 1234.5};
            view.eye = toEcef(eye);
            view.eyeFromEcef =
                eyeFromEcefOfView(ecefFromNed(eye.latitudeRad, eye.longitudeRad) *
                                  parentFromChild({yaw * kRadPerDeg, pitch * kRadPerDeg, roll * kRadPerDeg}));
            view.frustum = {-0.5, 0.75, -0.25, 0.3, 0.1};
            const out::Receipt receipt = app::receiptOf({}, view, kWgs84, {}, std::nullopt, false);
            CHECK(receipt.eye_latitude_deg == Approx(latitude).margin(1e-9));
            CHECK(receipt.eye_longitude_deg == Approx(longitude).margin(1e-9));
            CHECK(receipt.eye_height_m == Approx(1234.5).margin(1e-5));
            CHECK(receipt.yaw_deg == Approx(yaw).margin(1e-8));
            CHECK(receipt.pitch_deg == Approx(pitch).margin(1e-8));
            CHECK(receipt.roll_deg == Approx(roll).margin(1e-8));
            CHECK(receipt.eye_ecef_m[1] == view.eye.m.y);
            CHECK(receipt.frustum_right == 0.75);
            CHECK(receipt.near_m == 0.1);
        }
    }
}

TEST_CASE("a receipt tells whose data the picture shows and how old they were")
{
    app::FrameTimes times{100'300'000'000, 100'301'000'000, 100'310'000'000, 100'320'000'000};
    const out::Receipt with = app::receiptOf({}, {}, kWgs84, times, hostFrame(), true);
    CHECK(with.flags == (EYEPOINT_RECEIPT_HOST | EYEPOINT_RECEIPT_NEW_HOST | EYEPOINT_RECEIPT_HOST_TIME));
    CHECK(with.host_frame == 4'000'000'000U);
    CHECK(with.host_time_ticks == 77);
    CHECK(with.arrival_ns == 100'250'000'000);
    CHECK(with.extrapolation_ns == 50'000'000);
    CHECK(with.display_ns == 100'320'000'000);
    CHECK(app::receiptOf({}, {}, kWgs84, times, hostFrame(), false).flags ==
          (EYEPOINT_RECEIPT_HOST | EYEPOINT_RECEIPT_HOST_TIME));
    times.startNs = 100'200'000'000; // a clock that disagrees does not make data from the future
    CHECK(app::receiptOf({}, {}, kWgs84, times, hostFrame(), true).extrapolation_ns == 0);
    const out::Receipt without = app::receiptOf({}, {}, kWgs84, times, std::nullopt, false);
    CHECK(without.flags == 0);
    CHECK(without.arrival_ns == 0);
    CHECK(without.extrapolation_ns == -1);
}

TEST_CASE("a receipt's line is one JSON object, whatever the numbers are")
{
    out::Receipt receipt{};
    receipt.frame = std::numeric_limits<uint64_t>::max();
    receipt.flags = EYEPOINT_RECEIPT_HOST;
    receipt.eye_ecef_m[0] = 6378137.123456789;
    receipt.error_px = std::numeric_limits<double>::infinity();
    receipt.tau_px = std::nan("");
    receipt.dataset_checksum = 0xabc;
    const std::string line = out::receiptLine(receipt);
    CHECK(line.find('\n') == line.size() - 1);
    const auto json = nlohmann::json::parse(line);
    CHECK(json["frame"].get<uint64_t>() == std::numeric_limits<uint64_t>::max());
    CHECK(json["host"] == true);
    CHECK(json["host_new"] == false);
    CHECK(json["host_time_ticks"].is_null());
    CHECK(json["eye_ecef_m"][0].get<double>() == 6378137.123456789);
    CHECK(json["error_px"].is_null());
    CHECK(json["tau_px"].is_null());
    CHECK(json["dataset_checksum"] == "0000000000000abc");
}

TEST_CASE("every receipt is stored or counted as dropped, in order")
{
    const test::TempDir dir;
    constexpr uint64_t kFrames = 20'000;
    const auto sink = out::makeReceiptSink(dir.file("r.jsonl"));
    REQUIRE(sink);
    out::Receipt receipt{};
    for (uint64_t i = 0; i < kFrames; ++i) {
        receipt.frame = i;
        REQUIRE((*sink)->write({1, 1, {}, i, {}, &receipt}));
    }
    const auto stats = (*sink)->close();
    REQUIRE(stats);
    CHECK(stats->written + stats->dropped == kFrames);
    CHECK(stats->written >= out::kQueuedReceipts);
    std::istringstream lines(test::readFile(dir.file("r.jsonl")));
    uint64_t count = 0;
    int64_t last = -1;
    for (std::string line; std::getline(lines, line); ++count) {
        const int64_t frame = nlohmann::json::parse(line)["frame"].get<int64_t>();
        REQUIRE(frame > last);
        last = frame;
    }
    CHECK(count == stats->written);
}

TEST_CASE("receipts that cannot be stored end with one message that names them")
{
    const test::TempDir dir;
    const auto none = out::makeReceiptSink(dir.file("no/r.jsonl"));
    REQUIRE_FALSE(none);
    CHECK(none.error().kind == ErrorKind::usage);
    CHECK_THAT(none.error().message, Catch::Contains("no/r.jsonl"));
    const auto full = out::makeReceiptSink("/dev/full");
    REQUIRE(full);
    out::Receipt receipt{};
    Result<void> written;
    for (int i = 0; i < 5000 && written; ++i) {
        written = (*full)->write({1, 1, {}, 0, {}, &receipt});
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    REQUIRE_FALSE(written);
    CHECK_THAT(written.error().message, Catch::Contains("receipts /dev/full") && Catch::Contains("No space"));
    CHECK_FALSE((*full)->close());
}
