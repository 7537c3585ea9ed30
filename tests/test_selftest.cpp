// SPDX-License-Identifier: MIT
// The extreme cases of --selftest, with more eyes and frames than on the target.
#include "ig/gl/context.h"
#include "ig/selftest/selftest.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <limits>

using namespace ig::selftest;

TEST_CASE("every extreme case holds its limit")
{
    Settings settings;
    settings.rounds = 3;
    settings.graphics = static_cast<bool>(ig::gl::Context::create({}));
    if (!settings.graphics) {
        WARN("without pictures: no usable EGL");
    }
    const auto outcome = run(settings);
    REQUIRE(outcome);
    for (const Measurement& m : outcome->report.measurements()) {
        INFO(m.area << ": " << m.name << ": " << m.quantity << ": " << m.measured << " against " << m.limit);
        CHECK(m.passes());
    }
    CHECK(outcome->report.measurements().size() > 500);
    CHECK(outcome->report.passes());
}

TEST_CASE("a report passes when every measurement does, and not by what is no number or by nothing")
{
    Report report;
    CHECK_FALSE(report.passes());
    report.atMost("a", "b", "c", "m", 1.0, 1.0);
    report.atLeast("a", "b", "c", "m", 1.0, 1.0);
    CHECK(report.passes());
    CHECK(report.table().find("FAIL") == std::string::npos);
    report.atMost("a", "b", "c", "m", 1.0, 1.0000001);
    report.atLeast("a", "b", "c", "m", 1.0, 0.9999999);
    report.atMost("a", "b", "c", "m", 1.0, std::numeric_limits<double>::quiet_NaN());
    report.atLeast("a", "b", "c", "m", 1.0, std::numeric_limits<double>::quiet_NaN());
    CHECK(report.failures() == 4);
    CHECK_FALSE(report.passes());
    CHECK(report.table().find("FAIL") != std::string::npos);
    const auto json = nlohmann::json::parse(report.json("a driver"));
    CHECK(json["passes"] == false);
    CHECK(json["failed"] == 4);
    CHECK(json["cases"].size() == 6);
    CHECK(json["cases"][0]["passes"] == true);
    CHECK(json["cases"][2]["passes"] == false);
    CHECK(json["cases"][4]["measured"].is_string()); // JSON has no such number
    CHECK(json["target"] == "a driver");
}
