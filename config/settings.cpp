// SPDX-License-Identifier: MIT
#include "config/settings.h"

#include "ig/base/system_error.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <type_traits>

namespace config {

namespace {

using ig::ErrorKind;
using ig::fail;
using ig::Result;

// One key of the file: how it is described, and how a value gets into the settings, or into an entry of
// [[views]].
template <class Target>
struct Key {
    std::string name;
    std::string expected;
    std::function<bool(const toml::node&, Target&)> store; // false: not what is expected
    std::function<bool(const Target&, const Target&)> same;
    std::function<void(const Target& from, Target& to)> copy;
    bool live = false;                                   // may change while the program runs
    std::function<std::string(const Settings&)> print{}; // of keys of the settings
};

std::string printed(const toml::node& node)
{
    std::ostringstream text;
    node.visit([&](const auto& value) { text << value; });
    return text.str();
}

std::string tomlOf(const std::vector<std::string>& values)
{
    toml::array array;
    for (const std::string& value : values) {
        array.push_back(value);
    }
    return printed(array);
}

// The fewest digits that give the same number again.
std::string tomlOf(double value)
{
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

template <class T>
std::string tomlOf(const T& value)
{
    return printed(toml::value<T>(value));
}

// The parts of a key that follow from where its value is kept.
template <class Target, class Access>
Key<Target> reachedBy(Access access, Key<Target> key)
{
    key.same = [=](const Target& a, const Target& b) { return access(a) == access(b); };
    key.copy = [=](const Target& from, Target& to) { access(to) = access(from); };
    if constexpr (std::is_same_v<Target, Settings>) {
        key.print = [=](const Settings& settings) { return tomlOf(access(settings)); };
    }
    return key;
}

template <class Target>
Key<Target> live(Key<Target> key)
{
    key.live = true;
    return key;
}

std::string shortNumber(double value)
{
    std::ostringstream text;
    text << value;
    return text.str();
}

std::string range(double low, double high, const char* unit)
{
    return shortNumber(low) + " to " + shortNumber(high) + (*unit != '\0' ? " " : "") + unit;
}

template <class Target = Settings, class Access>
Key<Target> number(const char* name, double low, double high, const char* unit, Access access)
{
    return reachedBy<Target>(access,
                             {name,
                              "a number, " + range(low, high, unit),
                              [=](const toml::node& node, Target& target) {
                                  const auto value = node.value<double>();
                                  if (!value || node.is_boolean() || !(*value >= low && *value <= high)) {
                                      return false;
                                  }
                                  access(target) = *value;
                                  return true;
                              },
                              {},
                              {}});
}

template <class Target = Settings, class Access>
Key<Target> integer(const char* name, int64_t low, int64_t high, const char* unit, Access access)
{
    return reachedBy<Target>(access, {name,
                                      "an integer, " + std::to_string(low) + " to " + std::to_string(high) +
                                          (*unit != '\0' ? " " : "") + unit,
                                      [=](const toml::node& node, Target& target) {
                                          const auto* value = node.as_integer();
                                          if (value == nullptr || value->get() < low || value->get() > high) {
                                              return false;
                                          }
                                          access(target) = value->get();
                                          return true;
                                      },
                                      {},
                                      {}});
}

template <class Target = Settings, class Access>
Key<Target> flag(const char* name, Access access)
{
    return reachedBy<Target>(access, {name,
                                      "true or false",
                                      [=](const toml::node& node, Target& target) {
                                          const auto* value = node.as_boolean();
                                          if (value == nullptr) {
                                              return false;
                                          }
                                          access(target) = value->get();
                                          return true;
                                      },
                                      {},
                                      {}});
}

template <class Target = Settings, class Access>
Key<Target> text(const char* name, const char* what, Access access)
{
    return reachedBy<Target>(access, {name,
                                      what,
                                      [=](const toml::node& node, Target& target) {
                                          const auto* value = node.as_string();
                                          if (value == nullptr) {
                                              return false;
                                          }
                                          access(target) = value->get();
                                          return true;
                                      },
                                      {},
                                      {}});
}

template <class Target = Settings, class Access>
Key<Target> choice(const char* name, std::vector<std::string> words, Access access)
{
    std::string expected = "one of";
    for (const std::string& word : words) {
        expected += " \"" + word + "\"";
    }
    return reachedBy<Target>(access, {name,
                                      expected,
                                      [=](const toml::node& node, Target& target) {
                                          const auto* value = node.as_string();
                                          if (value == nullptr || std::find(words.begin(), words.end(),
                                                                            value->get()) == words.end()) {
                                              return false;
                                          }
                                          access(target) = value->get();
                                          return true;
                                      },
                                      {},
                                      {}});
}

template <class Target, class Access>
Key<Target> sinkList(const char* name, Access access)
{
    return reachedBy<Target>(
        access, {name,
                 "a list of \"png:DIR\", \"y4m:FILE\", \"raw:FILE\", \"gst:PIPELINE\", \"shm:NAME\" "
                 "or \"null\"",
                 [=](const toml::node& node, Target& target) {
                     const auto* list = node.as_array();
                     if (list == nullptr) {
                         return false;
                     }
                     std::vector<std::string> sinks;
                     for (const toml::node& item : *list) {
                         if (!item.is_string()) {
                             return false;
                         }
                         sinks.push_back(item.as_string()->get());
                     }
                     access(target) = std::move(sinks);
                     return true;
                 },
                 {},
                 {}});
}

// Limits that [view] and an entry of [[views]] share.
constexpr int64_t kMostPixels = 16'384;
constexpr double kLowestRateHz = 0.1, kHighestRateHz = 1000;
constexpr double kNarrowestDeg = 0.001, kWidestDeg = 179;
constexpr double kNearestM = 0.001, kFarthestNearM = 1'000;
constexpr int64_t kFewestTriangles = 512, kMostTriangles = 1'000'000;
constexpr int64_t kFewestRingSlots = 2, kMostRingSlots = 64;

const std::vector<Key<Settings>>& allKeys()
{
    static const std::vector<Key<Settings>> keys = [] {
        std::vector<Key<Settings>> k;
        k.push_back(text(
            "terrain.file", "a string, path of an .ept dataset",
            [](auto& s) -> auto& { return s.terrain.file; }));
        k.push_back(live(choice(
            "terrain.method", {"hybrid", "bintree", "geomip"},
            [](auto& s) -> auto& { return s.terrain.method; })));
        k.push_back(live(integer(
            "terrain.triangle_budget", kFewestTriangles, kMostTriangles, "triangles per frame",
            [](auto& s) -> auto& { return s.terrain.triangleBudget; })));
        k.push_back(live(number(
            "terrain.frame_time_ms", 0, 10'000, "milliseconds, 0 for a fixed budget",
            [](auto& s) -> auto& { return s.terrain.frameTimeMs; })));
        k.push_back(live(integer(
            "terrain.smallest_triangle_budget", kFewestTriangles, kMostTriangles, "triangles per frame",
            [](auto& s) -> auto& { return s.terrain.smallestTriangleBudget; })));
        k.push_back(live(number(
            "terrain.tolerance_px", 0, 1000, "pixels",
            [](auto& s) -> auto& { return s.terrain.tolerancePx; })));
        k.push_back(live(integer(
            "terrain.page_cache_mib", 4, 65'536, "MiB",
            [](auto& s) -> auto& { return s.terrain.pageCacheMib; })));
        k.push_back(live(integer(
            "terrain.page_loads_per_frame", 1, 1'024, "pages",
            [](auto& s) -> auto& { return s.terrain.pageLoadsPerFrame; })));
        k.push_back(live(flag(
            "terrain.wait_for_pages", [](auto& s) -> auto& { return s.terrain.waitForPages; })));
        k.push_back(live(flag(
            "terrain.morph", [](auto& s) -> auto& { return s.terrain.morph; })));
        k.push_back(integer(
            "view.id", 0, 65'535, "", [](auto& s) -> auto& { return s.view.id; }));
        k.push_back(integer(
            "view.width", 1, kMostPixels, "pixels", [](auto& s) -> auto& { return s.view.width; }));
        k.push_back(integer(
            "view.height", 1, kMostPixels, "pixels", [](auto& s) -> auto& { return s.view.height; }));
        k.push_back(number(
            "view.rate_hz", kLowestRateHz, kHighestRateHz, "frames per second",
            [](auto& s) -> auto& { return s.view.rateHz; }));
        k.push_back(number(
            "view.fov_horizontal_deg", kNarrowestDeg, kWidestDeg, "degrees",
            [](auto& s) -> auto& { return s.view.fovHorizontalDeg; }));
        k.push_back(number(
            "view.fov_vertical_deg", kNarrowestDeg, kWidestDeg, "degrees",
            [](auto& s) -> auto& { return s.view.fovVerticalDeg; }));
        k.push_back(number(
            "view.near_m", kNearestM, kFarthestNearM, "metres",
            [](auto& s) -> auto& { return s.view.nearM; }));
        k.push_back(number(
            "view.yaw_deg", -180, 180, "degrees to the right",
            [](auto& s) -> auto& { return s.view.yawDeg; }));
        k.push_back(number(
            "view.pitch_deg", -90, 90, "degrees up", [](auto& s) -> auto& { return s.view.pitchDeg; }));
        k.push_back(number(
            "view.roll_deg", -180, 180, "degrees, right side down",
            [](auto& s) -> auto& { return s.view.rollDeg; }));
        k.push_back(live(choice(
            "shading.tint", {"hypsometric", "slope"}, [](auto& s) -> auto& { return s.shading.tint; })));
        k.push_back(live(number(
            "shading.sun_azimuth_deg", 0, 360, "degrees from north, clockwise",
            [](auto& s) -> auto& { return s.shading.sunAzimuthDeg; })));
        k.push_back(live(number(
            "shading.sun_elevation_deg", -90, 90, "degrees above the horizon",
            [](auto& s) -> auto& { return s.shading.sunElevationDeg; })));
        k.push_back(live(number(
            "shading.ambient", 0, 1, "", [](auto& s) -> auto& { return s.shading.ambient; })));
        k.push_back(live(number(
            "shading.visibility_m", 0, 1e9, "metres, 0 for no haze",
            [](auto& s) -> auto& { return s.shading.visibilityM; })));
        k.push_back(text(
            "host.listen", "a string, ADDRESS:PORT to receive on",
            [](auto& s) -> auto& { return s.host.listen; }));
        k.push_back(text(
            "host.peer", "a string, ADDRESS:PORT of the only host to believe, empty for any",
            [](auto& s) -> auto& { return s.host.peer; }));
        k.push_back(choice(
            "host.protocol", {"auto", "cigi3", "cigi4", "fgnet"},
            [](auto& s) -> auto& { return s.host.protocol; }));
        k.push_back(choice(
            "host.timing", {"async", "sync", "lockstep"}, [](auto& s) -> auto& { return s.host.timing; }));
        k.push_back(number(
            "host.extrapolation_s", 0, 10, "seconds",
            [](auto& s) -> auto& { return s.host.extrapolationS; }));
        k.push_back(number(
            "host.timeout_s", 0.01, 3600, "seconds", [](auto& s) -> auto& { return s.host.timeoutS; }));
        k.push_back(number(
            "host.fade_s", 0, 3600, "seconds, 0 for a picture that stays",
            [](auto& s) -> auto& { return s.host.fadeS; }));
        k.push_back(integer(
            "host.database", 1, 127, "", [](auto& s) -> auto& { return s.host.database; }));
        k.push_back(text(
            "host.record", "a string, path of a pcap file, empty for none",
            [](auto& s) -> auto& { return s.host.record; }));
        k.push_back(sinkList<Settings>(
            "output.sinks", [](auto& s) -> auto& { return s.output.sinks; }));
        k.push_back(live(text(
            "output.stats", "a string, path of a JSON file, empty for none",
            [](auto& s) -> auto& { return s.output.stats; })));
        k.push_back(text(
            "output.receipts", "a string, path of a JSON lines file, empty for none",
            [](auto& s) -> auto& { return s.output.receipts; }));
        k.push_back(text(
            "output.metrics", "a string, loopback ADDRESS:PORT, empty for none",
            [](auto& s) -> auto& { return s.output.metrics; }));
        k.push_back(integer(
            "output.ring_slots", kFewestRingSlots, kMostRingSlots, "frames in a shm:NAME",
            [](auto& s) -> auto& { return s.output.ringSlots; }));
        k.push_back(flag(
            "output.depth", [](auto& s) -> auto& { return s.output.depth; }));
        k.push_back(live(flag(
            "output.skip_identical", [](auto& s) -> auto& { return s.output.skipIdentical; })));
        k.push_back(live(number(
            "output.hold_ms", 0, 10'000, "milliseconds, 0 for as soon as they are there",
            [](auto& s) -> auto& { return s.output.holdMs; })));
        k.push_back(integer(
            "graphics.device", -1, 255, "EGL device, -1 for the first that works",
            [](auto& s) -> auto& { return s.graphics.device; }));
        k.push_back(integer(
            "graphics.realtime_priority", 0, 99, "of SCHED_RR, 0 for the usual scheduling",
            [](auto& s) -> auto& { return s.graphics.realtimePriority; }));
        k.push_back(live(choice(
            "log.level", {"debug", "info", "warning", "error"},
            [](auto& s) -> auto& { return s.log.level; })));
        return k;
    }();
    return keys;
}

const std::vector<Key<ViewEntry>>& allViewKeys()
{
    static const std::vector<Key<ViewEntry>> keys = [] {
        std::vector<Key<ViewEntry>> k;
        k.push_back(integer<ViewEntry>(
            "id", 0, 65'535, "", [](auto& v) -> auto& { return v.id; }));
        k.push_back(integer<ViewEntry>(
            "width", 1, kMostPixels, "pixels", [](auto& v) -> auto& { return v.width; }));
        k.push_back(integer<ViewEntry>(
            "height", 1, kMostPixels, "pixels", [](auto& v) -> auto& { return v.height; }));
        k.push_back(number<ViewEntry>(
            "rate_hz", kLowestRateHz, kHighestRateHz, "frames per second",
            [](auto& v) -> auto& { return v.rateHz; }));
        k.push_back(number<ViewEntry>(
            "fov_horizontal_deg", kNarrowestDeg, kWidestDeg, "degrees",
            [](auto& v) -> auto& { return v.fovHorizontalDeg; }));
        k.push_back(number<ViewEntry>(
            "fov_vertical_deg", kNarrowestDeg, kWidestDeg, "degrees",
            [](auto& v) -> auto& { return v.fovVerticalDeg; }));
        k.push_back(number<ViewEntry>(
            "near_m", kNearestM, kFarthestNearM, "metres", [](auto& v) -> auto& { return v.nearM; }));
        k.push_back(number<ViewEntry>(
            "yaw_deg", -180, 180, "degrees to the right", [](auto& v) -> auto& { return v.yawDeg; }));
        k.push_back(number<ViewEntry>(
            "pitch_deg", -90, 90, "degrees up", [](auto& v) -> auto& { return v.pitchDeg; }));
        k.push_back(number<ViewEntry>(
            "roll_deg", -180, 180, "degrees, right side down", [](auto& v) -> auto& { return v.rollDeg; }));
        k.push_back(live(integer<ViewEntry>(
            "triangle_budget", kFewestTriangles, kMostTriangles, "triangles per frame",
            [](auto& v) -> auto& { return v.triangleBudget; })));
        k.push_back(live(number<ViewEntry>(
            "tolerance_px", 0, 1000, "pixels", [](auto& v) -> auto& { return v.tolerancePx; })));
        k.push_back(sinkList<ViewEntry>(
            "sinks", [](auto& v) -> auto& { return v.sinks; }));
        k.push_back(text<ViewEntry>(
            "receipts", "a string, path of a JSON lines file, empty for none",
            [](auto& v) -> auto& { return v.receipts; }));
        k.push_back(integer<ViewEntry>(
            "ring_slots", kFewestRingSlots, kMostRingSlots, "frames in a shm:NAME",
            [](auto& v) -> auto& { return v.ringSlots; }));
        k.push_back(flag<ViewEntry>(
            "depth", [](auto& v) -> auto& { return v.depth; }));
        return k;
    }();
    return keys;
}

std::string entryName(size_t index)
{
    return "views[" + std::to_string(index) + "]";
}

std::string place(const std::string& source, const toml::source_region& region)
{
    return region.begin.line > 0 ? source + ":" + std::to_string(region.begin.line) : source;
}

// prefix: before the key's name in messages.
template <class Target>
Result<void> store(const std::vector<Key<Target>>& keys, const std::string& name, const std::string& prefix,
                   const toml::node& node, const std::string& source, Target& target)
{
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const auto& k) { return k.name == name; });
    if (key == keys.end()) {
        return fail(ErrorKind::usage, place(source, node.source()) + ": unknown key '" + prefix + name +
                                          "'; config/eyepoint.toml lists every key");
    }
    if (!key->store(node, target)) {
        return fail(ErrorKind::usage, place(source, node.source()) + ": key '" + prefix + name +
                                          "': expected " + key->expected);
    }
    return {};
}

Result<void> applyViews(const toml::node& node, const std::string& source, Settings& settings)
{
    const toml::array* list = node.as_array();
    if (list == nullptr || !list->is_array_of_tables() || list->size() > kMostViews) {
        return fail(ErrorKind::usage, place(source, node.source()) + ": key 'views': expected up to " +
                                          std::to_string(kMostViews) + " sections [[views]]");
    }
    for (const toml::node& item : *list) {
        ViewEntry entry;
        const std::string prefix = entryName(settings.views.size()) + ".";
        for (const auto& [key, value] : *item.as_table()) {
            if (auto stored = store(allViewKeys(), std::string(key.str()), prefix, value, source, entry);
                !stored) {
                return stored;
            }
        }
        settings.views.push_back(std::move(entry));
    }
    return {};
}

Result<void> apply(const toml::table& file, const std::string& source, Settings& settings)
{
    for (const auto& [section, node] : file) {
        const std::string sectionName(section.str());
        if (sectionName == "views") {
            if (auto applied = applyViews(node, source, settings); !applied) {
                return applied;
            }
            continue;
        }
        const toml::table* table = node.as_table();
        if (table == nullptr) {
            return fail(ErrorKind::usage, place(source, node.source()) + ": key '" + sectionName +
                                              "' is outside a section such as [terrain]");
        }
        for (const auto& [key, value] : *table) {
            if (auto stored =
                    store(allKeys(), sectionName + "." + std::string(key.str()), "", value, source, settings);
                !stored) {
                return stored;
            }
        }
    }
    return {};
}

// The key that says something of a view, as the file has it.
std::string keyOf(const Settings& settings, const View& view, const char* section, const char* key)
{
    return (settings.views.empty() ? std::string(section) : view.name) + "." + key;
}

// Whose rate is that of the schedule.
const View& fastestOf(const std::vector<View>& views)
{
    return *std::max_element(views.begin(), views.end(),
                             [](const View& a, const View& b) { return a.rateHz < b.rateHz; });
}

Result<void> checkRates(const Settings& settings, const std::vector<View>& views)
{
    const double highestHz = fastestOf(views).rateHz;
    for (const View& view : views) {
        const double periods = highestHz / view.rateHz;
        if (!(std::abs(periods - std::round(periods)) <= 1e-6 * periods)) {
            return fail(ErrorKind::usage,
                        keyOf(settings, view, "view", "rate_hz") + " is " + shortNumber(view.rateHz) +
                            ", which does not divide the highest rate, " + shortNumber(highestHz) +
                            ": take " + shortNumber(highestHz / std::floor(periods)) + " or " +
                            shortNumber(highestHz / std::ceil(periods)));
        }
    }
    return {};
}

Result<void> checkFrameTime(const Settings& settings, const std::vector<View>& views)
{
    if (!(settings.terrain.frameTimeMs > 0)) {
        return {};
    }
    for (const View& view : views) {
        if (settings.terrain.smallestTriangleBudget > view.triangleBudget) {
            return fail(ErrorKind::usage, "terrain.smallest_triangle_budget is " +
                                              std::to_string(settings.terrain.smallestTriangleBudget) +
                                              ", above " +
                                              keyOf(settings, view, "terrain", "triangle_budget") + ", " +
                                              std::to_string(view.triangleBudget) + ": lower it");
        }
        if (settings.terrain.frameTimeMs > 1000.0 / view.rateHz) {
            return fail(ErrorKind::usage,
                        "terrain.frame_time_ms is " + shortNumber(settings.terrain.frameTimeMs) +
                            ", longer than a frame at " + keyOf(settings, view, "view", "rate_hz") + ", " +
                            shortNumber(view.rateHz) + ": lower one of them");
        }
    }
    return {};
}

// Frames are handed out, and the next slot of the schedule begins.
Result<void> checkHold(const Settings& settings, const std::vector<View>& views)
{
    constexpr double kLargestShare = 0.9;
    const View& fastest = fastestOf(views);
    const double longestMs = kLargestShare * 1000.0 / fastest.rateHz;
    if (settings.output.holdMs > longestMs) {
        return fail(ErrorKind::usage, "output.hold_ms is " + shortNumber(settings.output.holdMs) +
                                          ", longer than 90 % of a frame at " +
                                          keyOf(settings, fastest, "view", "rate_hz") + ", " +
                                          shortNumber(fastest.rateHz) + ": take " + shortNumber(longestMs) +
                                          " at most, or lower the rate");
    }
    return {};
}

// What several views may not share.
Result<void> checkApart(const Settings& settings, const std::vector<View>& views)
{
    if (settings.views.empty()) {
        return {};
    }
    if (!settings.output.sinks.empty() || !settings.output.receipts.empty()) {
        return fail(ErrorKind::usage,
                    "output.sinks and output.receipts (--sink, --receipts) are those of a single view: with "
                    "[[views]] give each entry its own sinks and receipts");
    }
    std::map<std::string, std::string> takenBy; // what only one may have
    for (const View& view : views) {
        std::vector<std::string> own{"id " + std::to_string(view.id)};
        if (!view.receipts.empty()) {
            own.push_back("the receipts file \"" + view.receipts + "\"");
        }
        for (const std::string& sink : view.sinks) {
            if (sink != "null") {
                own.push_back("the sink \"" + sink + "\"");
            }
        }
        for (const std::string& what : own) {
            const auto [taken, isFree] = takenBy.emplace(what, view.name);
            if (!isFree) {
                return fail(ErrorKind::usage, taken->second + " and " + view.name + " both have " + what +
                                                  ": give one of them another");
            }
        }
    }
    return {};
}

} // namespace

Result<Settings> load(const std::string& path)
{
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) { // would be read as an empty file
        return fail(ErrorKind::usage, path + ": is a directory; expected a TOML file");
    }
    std::ifstream text(path, std::ios::binary);
    if (!text) {
        return fail(ErrorKind::usage, path + ": cannot open: " + ig::systemError(errno));
    }
    try {
        const toml::table file = toml::parse(text, path);
        Settings settings;
        if (auto applied = apply(file, path, settings); !applied) {
            return fail(applied.error().kind, applied.error().message);
        }
        return settings;
    } catch (const toml::parse_error& e) {
        return fail(ErrorKind::usage, place(path, e.source()) + ": " + std::string(e.description()));
    }
}

Result<void> assign(Settings& settings, std::string_view assignment)
{
    const std::string source = "'" + std::string(assignment) + "'";
    const size_t equals = assignment.find('=');
    if (equals == std::string_view::npos) {
        return fail(ErrorKind::usage, source + ": expected section.key=value");
    }
    const std::string name(assignment.substr(0, equals));
    const std::string value(assignment.substr(equals + 1));
    const auto parse = [](const std::string& text) -> std::optional<toml::table> {
        try {
            return toml::parse("value = " + text);
        } catch (const toml::parse_error&) {
            return std::nullopt;
        }
    };
    if (const auto table = parse(value)) {
        return store(allKeys(), name, "", *table->get("value"), source, settings);
    }
    toml::table unquoted;
    unquoted.insert("value", value);
    return store(allKeys(), name, "", *unquoted.get("value"), source, settings);
}

Result<void> check(const Settings& settings)
{
    if (settings.terrain.file.empty()) {
        return fail(
            ErrorKind::usage,
            "no terrain: give --terrain FILE.ept or terrain.file; make one with eyepoint-terrain build");
    }
    const std::vector<View> views = viewsOf(settings);
    if (auto apart = checkApart(settings, views); !apart) {
        return apart;
    }
    if (auto rates = checkRates(settings, views); !rates) {
        return rates;
    }
    if (auto frameTime = checkFrameTime(settings, views); !frameTime) {
        return frameTime;
    }
    return checkHold(settings, views);
}

std::vector<View> viewsOf(const Settings& settings)
{
    View only;
    only.name = "view";
    only.id = settings.view.id;
    only.width = settings.view.width;
    only.height = settings.view.height;
    only.rateHz = settings.view.rateHz;
    only.fovHorizontalDeg = settings.view.fovHorizontalDeg;
    only.fovVerticalDeg = settings.view.fovVerticalDeg;
    only.nearM = settings.view.nearM;
    only.yawDeg = settings.view.yawDeg;
    only.pitchDeg = settings.view.pitchDeg;
    only.rollDeg = settings.view.rollDeg;
    only.triangleBudget = settings.terrain.triangleBudget;
    only.tolerancePx = settings.terrain.tolerancePx;
    only.sinks = settings.output.sinks;
    only.receipts = settings.output.receipts;
    only.ringSlots = settings.output.ringSlots;
    only.depth = settings.output.depth;
    if (settings.views.empty()) {
        return {only};
    }
    std::vector<View> views;
    for (const ViewEntry& entry : settings.views) {
        View view = only;
        view.name = entryName(views.size());
        view.id = entry.id.value_or(view.id);
        view.width = entry.width.value_or(view.width);
        view.height = entry.height.value_or(view.height);
        view.rateHz = entry.rateHz.value_or(view.rateHz);
        view.fovHorizontalDeg = entry.fovHorizontalDeg.value_or(view.fovHorizontalDeg);
        view.fovVerticalDeg = entry.fovVerticalDeg.value_or(view.fovVerticalDeg);
        view.nearM = entry.nearM.value_or(view.nearM);
        view.yawDeg = entry.yawDeg.value_or(view.yawDeg);
        view.pitchDeg = entry.pitchDeg.value_or(view.pitchDeg);
        view.rollDeg = entry.rollDeg.value_or(view.rollDeg);
        view.triangleBudget = entry.triangleBudget.value_or(view.triangleBudget);
        view.tolerancePx = entry.tolerancePx.value_or(view.tolerancePx);
        view.sinks = entry.sinks;
        view.receipts = entry.receipts;
        view.ringSlots = entry.ringSlots.value_or(view.ringSlots);
        view.depth = entry.depth.value_or(view.depth);
        views.push_back(std::move(view));
    }
    return views;
}

std::vector<Change> changes(const Settings& from, const Settings& to)
{
    std::vector<Change> out;
    for (const auto& key : allKeys()) {
        if (!key.same(from, to)) {
            out.push_back({key.name, key.live});
        }
    }
    if (from.views.size() != to.views.size()) {
        out.push_back({"views", false});
        return out;
    }
    for (size_t i = 0; i < from.views.size(); ++i) {
        for (const auto& key : allViewKeys()) {
            if (!key.same(from.views[i], to.views[i])) {
                out.push_back({entryName(i) + "." + key.name, key.live});
            }
        }
    }
    return out;
}

void applyLive(const Settings& from, Settings& to)
{
    for (const auto& key : allKeys()) {
        if (key.live) {
            key.copy(from, to);
        }
    }
    if (from.views.size() != to.views.size()) {
        return;
    }
    for (size_t i = 0; i < from.views.size(); ++i) {
        for (const auto& key : allViewKeys()) {
            if (key.live) {
                key.copy(from.views[i], to.views[i]);
            }
        }
    }
}

std::vector<KeyInfo> keys()
{
    std::vector<KeyInfo> out;
    for (const auto& key : allKeys()) {
        out.push_back({key.name, key.expected, key.live});
    }
    return out;
}

std::vector<KeyInfo> viewKeys()
{
    std::vector<KeyInfo> out;
    for (const auto& key : allViewKeys()) {
        out.push_back({"views." + key.name, key.expected, key.live});
    }
    return out;
}

std::vector<Value> values(const Settings& settings)
{
    std::vector<Value> out;
    for (const auto& key : allKeys()) {
        out.push_back({key.name, key.print(settings)});
    }
    return out;
}

} // namespace config
