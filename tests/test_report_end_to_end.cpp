// SPDX-License-Identifier: MIT
// eyepoint-report as it is run, and the surface that it measures against the one that is drawn.
#include "ig/app/terrain_view.h"
#include "process.h"
#include "rolling_land.h"
#include "temp_dir.h"
#include "tools/report/drawn_surface.h"
#include "tools/report/engine_run.h"
#include "tools/report/flight.h"
#include "tools/report/parts.h"
#include "tools/report/scaling_part.h"
#include "tools/report/surface_error.h"
#include "tools/terrain/compile.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <limits>
#include <thread>

using test::Process;
using test::readFile;

namespace {

using Json = nlohmann::json;

class SilentLog final : public ig::LogSink {
public:
    void write(ig::LogLevel, std::string_view) override {}
};

// Distances along the viewing axis that these triangles give, drawn one by one.
std::vector<float> depthOf(const std::vector<report::DrawnTriangle>& triangles, const ig::ViewState& view)
{
    const auto width = static_cast<size_t>(view.widthPx);
    std::vector<float> depth(width * static_cast<size_t>(view.heightPx),
                             std::numeric_limits<float>::infinity());
    std::vector<std::array<glm::dvec3, 3>> pieces; // in front of the near plane
    for (const report::DrawnTriangle& triangle : triangles) {
        const auto inFront = [&](const glm::dvec3& place) {
            return -(view.eyeFromEcef * place).z - view.frustum.nearM;
        };
        std::vector<glm::dvec3> polygon;
        for (size_t k = 0; k < 3; ++k) {
            const glm::dvec3& a = triangle.place[k];
            const glm::dvec3& b = triangle.place[(k + 1) % 3];
            if (inFront(a) > 0) {
                polygon.push_back(a);
            }
            if ((inFront(a) > 0) != (inFront(b) > 0)) {
                polygon.push_back(a + (b - a) * (inFront(a) / (inFront(a) - inFront(b))));
            }
        }
        for (size_t k = 2; k < polygon.size(); ++k) {
            pieces.push_back({polygon[0], polygon[k - 1], polygon[k]});
        }
    }
    for (const std::array<glm::dvec3, 3>& piece : pieces) {
        std::array<glm::dvec2, 3> pixel;
        std::array<double, 3> nearness{}; // 1 / distance: linear on the screen
        for (size_t k = 0; k < 3; ++k) {
            nearness[k] = -1 / (view.eyeFromEcef * piece[k]).z;
            pixel[k] = report::pixelOf(view, piece[k]).value_or(glm::dvec2(0));
        }
        const auto cross = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
            return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        };
        const double area = cross(pixel[0], pixel[1], pixel[2]);
        if (area >= 0) {
            continue; // seen from below
        }
        const auto [x0, x1] = std::minmax({pixel[0].x, pixel[1].x, pixel[2].x});
        const auto [y0, y1] = std::minmax({pixel[0].y, pixel[1].y, pixel[2].y});
        for (int y = std::max(0, static_cast<int>(y0)); y < std::min<double>(view.heightPx, y1 + 1); ++y) {
            for (int x = std::max(0, static_cast<int>(x0)); x < std::min<double>(view.widthPx, x1 + 1); ++x) {
                const glm::dvec2 centre(x + 0.5, y + 0.5);
                const double a = cross(centre, pixel[1], pixel[2]) / area;
                const double b = cross(centre, pixel[2], pixel[0]) / area;
                if (a < 0 || b < 0 || a + b > 1) {
                    continue;
                }
                float& here = depth[static_cast<size_t>(y) * width + static_cast<size_t>(x)];
                here = std::min(here, static_cast<float>(1 / (a * nearness[0] + b * nearness[1] +
                                                              (1 - a - b) * nearness[2])));
            }
        }
    }
    return depth;
}

// Share of the pixels whose distance is not within a ten thousandth.
double shareOff(const std::vector<float>& a, const std::vector<float>& b)
{
    size_t off = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        off += a[i] == b[i] || std::abs(a[i] - b[i]) < 1e-4F * b[i] ? 0 : 1;
    }
    return static_cast<double>(off) / static_cast<double>(a.size());
}

} // namespace

TEST_CASE("the triangles that the report measures are those that are drawn, morph and all")
{
    const test::TempDir dir;
    const std::string path = test::makeRollingLand(dir, 513);
    auto context = ig::gl::Context::create({});
    REQUIRE(context);
    if (!context->info().readDepth) {
        WARN("no depth to read back: skipped");
        return;
    }
    for (const char* method : {"hybrid", "geomip"}) {
        INFO(method);
        auto dataset = ig::data::Dataset::open(path);
        REQUIRE(dataset);
        report::Setting setting;
        setting.method = method;
        setting.widthPx = 320;
        setting.heightPx = 180;
        report::Scene scene;
        auto renderer = ig::gl::Renderer::create(*context, report::rendererSettings(scene, setting, false));
        REQUIRE(renderer);
        SilentLog log;
        ig::app::TerrainSettings settings;
        settings.selection.method = *ig::lod::methodOf(method);
        settings.selection.triangleBudget = 4000;
        ig::app::TerrainResidency terrain(*ig::data::Dataset::open(path), settings, **renderer, log);
        ig::app::TerrainView terrainView(terrain, settings.selection, **renderer);
        report::FlightPlan plan;
        report::Flight flight(*dataset, plan, report::middleOf(dataset->info()));
        report::DrawnSurface surface(*dataset);
        REQUIRE(terrainView.preload(flight.view(0, 320, 180)));
        double worst = 0;
        double unmorphed = 0;
        for (int frame = 0; frame < 12; ++frame) {
            const ig::ViewState view = flight.view(0.1 * frame, 320, 180);
            ig::app::FrameStats stats;
            terrainView.draw(view, stats);
            std::vector<float> drawn(320 * 180);
            (*renderer)->readDepth(drawn);
            const ig::gl::Morph morph =
                ig::app::rendererMorph(settings.selection.method, settings.selection.morph);
            worst = std::max(
                worst,
                shareOff(depthOf(surface.triangles(terrainView.drawList(), view, morph), view), drawn));
            unmorphed = std::max(
                unmorphed,
                shareOff(depthOf(surface.triangles(terrainView.drawList(), view, ig::gl::Morph::none), view),
                         drawn));
        }
        // Silhouettes fall into this or that pixel.
        CHECK(worst < 0.01);
        CHECK(unmorphed > 5 * worst); // which shows that it would be seen
    }
}

TEST_CASE("a report of a small terrain has its figures, its plots and its pictures, and keeps its word")
{
    const test::TempDir dir;
    const std::string terrain = test::makeRollingLand(dir, 513);
    const auto argumentsOf = [&](const std::string& out, const std::string& methods,
                                 const std::vector<std::string>& more) {
        std::vector<std::string> arguments{
            "eyepoint-report", "--terrain", terrain,     "-o",        dir.file(out), "--frames", "44",
            "--methods",       methods,     "--budgets", "2000,6000", "--tolerance", "0.1",      "--quiet",
            "--passes",        "2"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    const auto run = [&](const std::string& out, const std::string& methods,
                         const std::vector<std::string>& more) {
        Process process(argumentsOf(out, methods, more), dir.file("out"), dir.file("err"));
        return process.wait(120);
    };
    const int code = run("a", "hybrid,geomip", {"--sizes", "160x90"});
    INFO(readFile(dir.file("err")));
    REQUIRE(code == 0);
    const Json report = Json::parse(readFile(dir.file("a/report.json")));
    REQUIRE(report["settings"].size() == 4);
    CHECK(report["outcome"]["frames_with_broken_bound"] == 0);
    CHECK(report["outcome"]["crack_pixels"] == 0);
    CHECK(report["outcome"]["frames_over_budget"] == 0);
    for (const Json& setting : report["settings"]) {
        INFO(setting["name"]);
        const Json& summary = setting["summary"];
        CHECK(summary["total_ms"]["values"] == 44);
        CHECK(summary["total_ms"]["p50"].get<double>() > 0);
        CHECK(summary["psnr_db"]["values"] == 5);
        CHECK(summary["ssim"]["mean"].get<double>() > 0.5);
        CHECK(summary["posts_sampled"]["p50"].get<double>() > 500);
        CHECK(summary["all_posts"]["p50"].get<double>() > 10 * summary["posts_sampled"]["p50"].get<double>());
        CHECK(setting["counts"]["runs_that_differ"] == 0);
        CHECK(setting["counts"]["short_of_slots"] == 0);
        // Tiles of geomip may jump (ig/lod/geomip_morph.h).
        CHECK((setting["method"] == "geomip" || setting["counts"]["pops"] == 0));
    }
    // More triangles, less error.
    const Json& few = report["settings"][0]["summary"];
    const Json& many = report["settings"][1]["summary"];
    CHECK(many["error_rms_px"]["mean"].get<double>() < few["error_rms_px"]["mean"].get<double>());
    CHECK(many["flip"]["mean"].get<double>() < few["flip"]["mean"].get<double>());
    CHECK(report["motion"]["rows"].size() > 100);
    CHECK(report["verdict"].size() >= 5); // more where the methods have an error in common
    const std::string markdown = readFile(dir.file("a/report.md"));
    CHECK_THAT(markdown, Catch::Contains("| geomip-6000-160x90 |") &&
                             Catch::Contains("- met: no frame with a measured error above its bound. 0"));
    CHECK_THAT(markdown, Catch::Contains("Recommended here"));

    const std::string html = readFile(dir.file("a/report.html"));
    const auto countOf = [&html](const std::string& what) {
        size_t count = 0;
        for (size_t at = html.find(what); at != std::string::npos; at = html.find(what, at + 1)) {
            ++count;
        }
        return count;
    };
    CHECK(countOf("<svg ") == countOf("</svg>"));
    CHECK(countOf("<svg ") >= 8 + 6 + 15);
    CHECK(countOf("src=\"data:image/png;base64,iVBOR") == 12); // three of each setting
    CHECK(countOf("src=") == 12);                              // nothing else is fetched
    CHECK(countOf("href=") == 0);
    CHECK_THAT(html, Catch::Contains("prefers-color-scheme:dark") && !Catch::Contains("nan"));
    const std::string csv = readFile(dir.file("a/report.csv"));
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 4 * 44);

    // The same again: nothing is measured, everything is there, and no different from before.
    REQUIRE(run("a", "hybrid,geomip",
                {"--sizes", "160x90", "--resume", "--compare", dir.file("a/report.json"), "--no-motion"}) ==
            0);
    const Json again = Json::parse(readFile(dir.file("a/report.json")));
    CHECK(again["settings"] == report["settings"]);
    CHECK(again["compare"]["settings"][0]["total_ms"]["ratio"] == 1);
    CHECK(again["compare"]["settings"][0]["total_ms"]["pairs"] == 44);
    CHECK_THAT(readFile(dir.file("out")),
               Catch::Contains("Better: 0. Worse: 0. The same: 12. Undecided: 0."));
    // Another flight is refused before anything is measured.
    REQUIRE(run("a", "hybrid",
                {"--sizes", "160x90", "--compare", dir.file("a/report.json"), "--speed", "90"}) == 2);
    CHECK_THAT(readFile(dir.file("err")), Catch::Contains(dir.file("a/report.json") + ": of another path"));

    // Interrupted after the errors of its first setting: neither those nor the passes before are measured
    // again, the rest is, and without haze it is another setting. Against the first report, of which it has
    // half of the settings.
    {
        Process process(argumentsOf("k", "hybrid", {"--sizes", "160x90", "--no-motion"}), dir.file("out"),
                        dir.file("err"));
        const std::string part = dir.file("k/parts/hybrid-2000-160x90.json");
        for (int i = 0; i < 1200 && !std::filesystem::exists(part); ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
        }
        process.signal(SIGKILL);
        (void)process.wait(10);
    }
    const Json part = Json::parse(readFile(dir.file("k/parts/hybrid-2000-160x90.json")));
    const Json pass = Json::parse(readFile(dir.file("k/parts/pass-160x90-1.json")));
    REQUIRE_FALSE(std::filesystem::exists(dir.file("k/report.json")));
    REQUIRE(run("k", "hybrid",
                {"--sizes", "160x90", "--no-motion", "--resume", "--compare", dir.file("a/report.json")}) ==
            0);
    const Json resumed = Json::parse(readFile(dir.file("k/report.json")));
    REQUIRE(resumed["settings"].size() == 2);
    CHECK(resumed["settings"][0]["by_frame"]["motion_px"] == part["measured"]["by_frame"]["motion_px"]);
    CHECK(resumed["settings"][1]["by_pass"]["cpu_ms"][1] == pass["measured"][1]["by_frame"]["cpu_ms"]);
    CHECK(resumed["compare"]["only_before"].size() == 2);
    CHECK(resumed["compare"]["settings"][1]["error_max_px"]["ratio"] == 1); // the same path, the same errors
    REQUIRE(run("k", "hybrid", {"--sizes", "160x90", "--no-motion", "--resume", "--visibility", "0"}) == 0);
    const Json clear = Json::parse(readFile(dir.file("k/report.json")))["settings"][0];
    CHECK(clear["summary"]["flip"] != part["measured"]["summary"]["flip"]);
    CHECK(clear["by_pass"]["cpu_ms"][1] != pass["measured"][0]["by_frame"]["cpu_ms"]);

    // Far too few page slots: said so, and still the same pictures in the timed flights.
    CHECK(run("s", "hybrid", {"--sizes", "160x90", "--page-slots", "16", "--no-motion"}) == 0);
    CHECK_THAT(readFile(dir.file("out")), Catch::Contains("NOT MET     no frame short of page slots") &&
                                              Catch::Contains("met         every timed frame drew"));

    // A bound that is asked to have far more room than it has: broken, said so, and everything written.
    CHECK(run("b", "hybrid", {"--sizes", "160x90", "--bound-scale", "0.01", "--no-motion"}) == 1);
    CHECK(Json::parse(readFile(dir.file("b/report.json")))["outcome"]["frames_with_broken_bound"] == 88);
    CHECK_THAT(readFile(dir.file("out")), Catch::Contains("frames above their bound: 88"));
    CHECK(run("c", "hybrid", {"--sizes", "12"}) == 2);
    CHECK(run("c", "hybrid", {"--path", dir.file("none.csv")}) == 2);
}

TEST_CASE("a report follows a recorded host")
{
    const std::string capture = std::string(EYEPOINT_SHARED_DIR) + "/data/host/jsbsim_737_turn_scotland.pcap";
    if (!std::filesystem::exists(capture)) {
        WARN("no captures of hosts beside the source tree: skipped");
        return;
    }
    const test::TempDir dir;
    Process process({"eyepoint-report", "--terrain", test::makeRollingLand(dir), "-o", dir.file("p"),
                     "--path", capture, "--frames", "12", "--methods", "hybrid", "--budgets", "2000",
                     "--sizes", "160x90", "--passes", "1", "--no-motion", "--quiet"},
                    dir.file("out"), dir.file("err"));
    REQUIRE(process.wait(120) == 0);
    const Json report = Json::parse(readFile(dir.file("p/report.json")));
    CHECK(report["path"]["name"] == "jsbsim_737_turn_scotland.pcap");
    CHECK(report["path"]["frames"] == 12);
    CHECK(report["outcome"]["frames_with_broken_bound"] == 0);
    CHECK(report["settings"][0]["counts"]["runs_that_differ"] == 0);
    CHECK(report["settings"][0]["summary"]["posts_sampled"]["p50"].get<double>() > 500); // it sees the land
}

TEST_CASE("scaling is measured along every axis up to the whole terrain, and what is finished is kept")
{
    const test::TempDir dir;
    report::Scene scene;
    scene.terrain = test::makeRollingLand(dir, 513);
    auto context = ig::gl::Context::create({});
    REQUIRE(context);
    SilentLog log;
    const std::string partsDir = dir.file("parts");
    std::filesystem::create_directories(partsDir);
    const auto measure = [&](const char* key) {
        const report::Parts parts(partsDir, true, report::Json{{"run", key}});
        double share = 0;
        auto scaling = report::scalingJson(*context, scene, {.terrainPosts = {257, 129}, .frames = 2}, parts,
                                           log, [&share](double now) {
                                               CHECK(now >= share);
                                               share = now;
                                           });
        CHECK(share == Approx(1));
        REQUIRE(scaling);
        return *scaling;
    };
    const report::Json scaling = measure("a");
    std::vector<std::string> names;
    for (const report::Json& axis : scaling) {
        names.push_back(axis["axis"].get<std::string>());
        INFO(names.back());
        for (const char* slope : {"total_exponent", "total_ms_per_unit", "cpu_exponent", "cpu_ms_per_unit",
                                  "select_exponent", "select_ms_per_unit"}) {
            CHECK(axis[slope].is_number());
        }
        double before = 0;
        for (const report::Json& place : axis["places"]) {
            CHECK(place["value"].get<double>() > before);
            before = place["value"].get<double>();
            CHECK(place["total_ms_p50"].get<double>() > 0);
            CHECK(place["triangles_p50"].get<double>() > 0);
        }
    }
    CHECK(names == std::vector<std::string>{"triangle budget", "speed, m/s", "picture, million pixels",
                                            "horizontal field of view, degrees", "views",
                                            "synthetic terrain, million posts",
                                            "this terrain, million posts"});
    const report::Json& sizes = scaling.back()["places"];
    REQUIRE(sizes.size() == 3); // two crops, and all of it
    CHECK(sizes[2]["value"].get<double>() == Approx(1e-6 * 513 * 513).epsilon(1e-4));
    CHECK(sizes[0]["page_slots"] < sizes[1]["page_slots"]);
    for (const auto& file : std::filesystem::directory_iterator(partsDir)) {
        CHECK(file.path().extension() == ".json"); // no terrain is left
    }
    CHECK(measure("a") == scaling); // taken again, times and all
}
