// SPDX-License-Identifier: MIT
// config/: the typed settings of the image generator and their TOML form. It knows nobody else; whoever
// uses a setting converts it from the units of the file (degrees, as people write them) once, on entry.
// eyepoint.toml beside this file lists every key with its unit, range and default.
#pragma once

#include "ig/base/result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace config {

// An entry of [[views]]: what it says over [view], [output] and [terrain]. Its sinks are its own.
struct ViewEntry {
    std::optional<int64_t> id, width, height;
    std::optional<double> rateHz, fovHorizontalDeg, fovVerticalDeg, nearM;
    std::optional<double> yawDeg, pitchDeg, rollDeg;
    std::optional<int64_t> triangleBudget;
    std::optional<double> tolerancePx;
    std::vector<std::string> sinks;
    std::string receipts;
    std::optional<int64_t> ringSlots;
    std::optional<bool> depth;
};

struct Settings {
    struct {
        std::string file;
        std::string method = "hybrid";
        int64_t triangleBudget = 14'000;
        double frameTimeMs = 0;
        int64_t smallestTriangleBudget = 4'000;
        double tolerancePx = 1.0;
        int64_t pageCacheMib = 104;
        int64_t pageLoadsPerFrame = 8;
        bool waitForPages = false;
        bool morph = true;
    } terrain;
    struct {
        int64_t id = 0;
        int64_t width = 1280;
        int64_t height = 720;
        double rateHz = 60.0;
        double fovHorizontalDeg = 72.0;
        double fovVerticalDeg = 45.0;
        double nearM = 0.5;
        double yawDeg = 0;
        double pitchDeg = 0;
        double rollDeg = 0;
    } view;
    std::vector<ViewEntry> views; // empty: the one that [view] and [output] describe
    struct {
        std::string tint = "hypsometric";
        double sunAzimuthDeg = 315.0;
        double sunElevationDeg = 35.0;
        double ambient = 0.35;
        double visibilityM = 60'000.0;
    } shading;
    struct {
        std::string listen = "127.0.0.1:8000";
        std::string peer;
        std::string protocol = "auto";
        std::string timing = "async";
        double extrapolationS = 0.25;
        double timeoutS = 1.0;
        double fadeS = 0;
        int64_t database = 1;
        std::string record;
    } host;
    struct {
        std::vector<std::string> sinks;
        std::string stats;
        std::string receipts;
        std::string metrics;
        int64_t ringSlots = 4;
        bool depth = false;
        bool skipIdentical = false;
        double holdMs = 0;
    } output;
    struct {
        int64_t device = -1;
        int64_t realtimePriority = 0;
    } graphics;
    struct {
        std::string level = "info";
    } log;
};

// Reads a file over the defaults. Errors (usage), one line "FILE:LINE: ...": unreadable, not TOML, an unknown
// key, a wrong type, a value out of its range; each says what was expected.
ig::Result<Settings> load(const std::string& path);

// Applies one "section.key=value" of the command line, the value as in TOML (strings may go unquoted).
// Errors (usage) as load, with the assignment in place of file and line.
ig::Result<void> assign(Settings& settings, std::string_view assignment);

// A view with all that it is made from.
struct View {
    std::string name; // in messages: "view", or "views[0]" for the first entry
    int64_t id = 0;
    int64_t width = 0, height = 0;
    double rateHz = 0;
    double fovHorizontalDeg = 0, fovVerticalDeg = 0, nearM = 0;
    double yawDeg = 0, pitchDeg = 0, rollDeg = 0;
    int64_t triangleBudget = 0;
    double tolerancePx = 0;
    std::vector<std::string> sinks;
    std::string receipts;
    int64_t ringSlots = 0;
    bool depth = false;
};
// All views, at least one, in the order of the file.
std::vector<View> viewsOf(const Settings& settings);

inline constexpr size_t kMostViews = 16;

// What holds between several keys: errors (usage) name the key to change.
ig::Result<void> check(const Settings& settings);

// A key whose value differs.
struct Change {
    std::string name;
    bool live = false; // see KeyInfo
};
std::vector<Change> changes(const Settings& from, const Settings& to);

// Copies what may change while the program runs.
void applyLive(const Settings& from, Settings& to);

// One key as documented: for a table of all keys and the test of the shipped file.
struct KeyInfo {
    std::string name;     // "section.key"
    std::string expected; // type, unit and range in words
    bool live = false;    // may change while the program runs
};
std::vector<KeyInfo> keys();
// The same of an entry of [[views]]; the names are "views.key".
std::vector<KeyInfo> viewKeys();

// One key as the file would have it, "section.key" and a TOML value, in the order of keys().
struct Value {
    std::string name;
    std::string text;
};
std::vector<Value> values(const Settings& settings);

} // namespace config
