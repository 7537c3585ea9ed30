// SPDX-License-Identifier: MIT
#include "config/settings.h"

#include <toml++/toml.h>

#include <algorithm>
#include <functional>
#include <sstream>

namespace config {

namespace {

using ig::ErrorKind;
using ig::fail;
using ig::Result;

// One key of the file: how it is described, and how a value gets into the settings.
struct Key {
    std::string name;
    std::string expected;
    std::function<bool(const toml::node&, Settings&)> store; // false: not what is expected
    std::function<bool(const Settings&, const Settings&)> same;
    std::function<void(const Settings& from, Settings& to)> copy;
    bool live = false; // may change while the program runs
};

// The parts of a key that follow from where its value is kept.
template <class Access>
Key reachedBy(Access access, Key key)
{
    key.same = [=](const Settings& a, const Settings& b) { return access(a) == access(b); };
    key.copy = [=](const Settings& from, Settings& to) { access(to) = access(from); };
    return key;
}

Key live(Key key)
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

template <class Access>
Key number(const char* name, double low, double high, const char* unit, Access access)
{
    return reachedBy(access, {name,
                              "a number, " + range(low, high, unit),
                              [=](const toml::node& node, Settings& settings) {
                                  const auto value = node.value<double>();
                                  if (!value || node.is_boolean() || !(*value >= low && *value <= high)) {
                                      return false;
                                  }
                                  access(settings) = *value;
                                  return true;
                              },
                              {},
                              {}});
}

template <class Access>
Key integer(const char* name, int64_t low, int64_t high, const char* unit, Access access)
{
    return reachedBy(access, {name,
                              "an integer, " + std::to_string(low) + " to " + std::to_string(high) +
                                  (*unit != '\0' ? " " : "") + unit,
                              [=](const toml::node& node, Settings& settings) {
                                  const auto* value = node.as_integer();
                                  if (value == nullptr || value->get() < low || value->get() > high) {
                                      return false;
                                  }
                                  access(settings) = value->get();
                                  return true;
                              },
                              {},
                              {}});
}

template <class Access>
Key flag(const char* name, Access access)
{
    return reachedBy(access, {name,
                              "true or false",
                              [=](const toml::node& node, Settings& settings) {
                                  const auto* value = node.as_boolean();
                                  if (value == nullptr) {
                                      return false;
                                  }
                                  access(settings) = value->get();
                                  return true;
                              },
                              {},
                              {}});
}

template <class Access>
Key text(const char* name, const char* what, Access access)
{
    return reachedBy(access, {name,
                              what,
                              [=](const toml::node& node, Settings& settings) {
                                  const auto* value = node.as_string();
                                  if (value == nullptr) {
                                      return false;
                                  }
                                  access(settings) = value->get();
                                  return true;
                              },
                              {},
                              {}});
}

template <class Access>
Key choice(const char* name, std::vector<std::string> words, Access access)
{
    std::string expected = "one of";
    for (const std::string& word : words) {
        expected += " \"" + word + "\"";
    }
    return reachedBy(access, {name,
                              expected,
                              [=](const toml::node& node, Settings& settings) {
                                  const auto* value = node.as_string();
                                  if (value == nullptr ||
                                      std::find(words.begin(), words.end(), value->get()) == words.end()) {
                                      return false;
                                  }
                                  access(settings) = value->get();
                                  return true;
                              },
                              {},
                              {}});
}

Key sinkList()
{
    return reachedBy([](auto& s) -> auto& { return s.output.sinks; },
                     {"output.sinks",
                      "a list of \"png:DIR\", \"y4m:FILE\", \"raw:FILE\", \"shm:NAME\" or \"null\"",
                      [](const toml::node& node, Settings& settings) {
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
                          settings.output.sinks = std::move(sinks);
                          return true;
                      },
                      {},
                      {}});
}

const std::vector<Key>& allKeys()
{
    static const std::vector<Key> keys = [] {
        std::vector<Key> k;
        k.push_back(text(
            "terrain.file", "a string, path of an .ept dataset",
            [](auto& s) -> auto& { return s.terrain.file; }));
        k.push_back(choice(
            "terrain.method", {"hybrid", "bintree", "geomip"},
            [](auto& s) -> auto& { return s.terrain.method; }));
        k.push_back(live(integer(
            "terrain.triangle_budget", 512, 1'000'000, "triangles per frame",
            [](auto& s) -> auto& { return s.terrain.triangleBudget; })));
        k.push_back(number(
            "terrain.frame_time_ms", 0, 10'000, "milliseconds, 0 for a fixed budget",
            [](auto& s) -> auto& { return s.terrain.frameTimeMs; }));
        k.push_back(integer(
            "terrain.smallest_triangle_budget", 512, 1'000'000, "triangles per frame",
            [](auto& s) -> auto& { return s.terrain.smallestTriangleBudget; }));
        k.push_back(live(number(
            "terrain.tolerance_px", 0, 1000, "pixels",
            [](auto& s) -> auto& { return s.terrain.tolerancePx; })));
        k.push_back(integer(
            "terrain.page_slots", 16, 16'384, "pages on the GPU",
            [](auto& s) -> auto& { return s.terrain.pageSlots; }));
        k.push_back(live(integer(
            "terrain.page_loads_per_frame", 1, 1'024, "pages",
            [](auto& s) -> auto& { return s.terrain.pageLoadsPerFrame; })));
        k.push_back(flag(
            "terrain.morph", [](auto& s) -> auto& { return s.terrain.morph; }));
        k.push_back(integer(
            "view.id", 0, 65'535, "", [](auto& s) -> auto& { return s.view.id; }));
        k.push_back(integer(
            "view.width", 1, 16'384, "pixels", [](auto& s) -> auto& { return s.view.width; }));
        k.push_back(integer(
            "view.height", 1, 16'384, "pixels", [](auto& s) -> auto& { return s.view.height; }));
        k.push_back(number(
            "view.rate_hz", 0.1, 1000, "frames per second", [](auto& s) -> auto& { return s.view.rateHz; }));
        k.push_back(number(
            "view.fov_horizontal_deg", 0.001, 179, "degrees",
            [](auto& s) -> auto& { return s.view.fovHorizontalDeg; }));
        k.push_back(number(
            "view.fov_vertical_deg", 0.001, 179, "degrees",
            [](auto& s) -> auto& { return s.view.fovVerticalDeg; }));
        k.push_back(number(
            "view.near_m", 0.001, 1'000, "metres", [](auto& s) -> auto& { return s.view.nearM; }));
        k.push_back(choice(
            "shading.tint", {"hypsometric", "slope"}, [](auto& s) -> auto& { return s.shading.tint; }));
        k.push_back(number(
            "shading.sun_azimuth_deg", 0, 360, "degrees from north, clockwise",
            [](auto& s) -> auto& { return s.shading.sunAzimuthDeg; }));
        k.push_back(number(
            "shading.sun_elevation_deg", -90, 90, "degrees above the horizon",
            [](auto& s) -> auto& { return s.shading.sunElevationDeg; }));
        k.push_back(number(
            "shading.ambient", 0, 1, "", [](auto& s) -> auto& { return s.shading.ambient; }));
        k.push_back(number(
            "shading.visibility_m", 0, 1e9, "metres, 0 for no haze",
            [](auto& s) -> auto& { return s.shading.visibilityM; }));
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
        k.push_back(integer(
            "host.database", 1, 127, "", [](auto& s) -> auto& { return s.host.database; }));
        k.push_back(sinkList());
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
            "output.ring_slots", 2, 64, "frames in a shm:NAME",
            [](auto& s) -> auto& { return s.output.ringSlots; }));
        k.push_back(flag(
            "output.depth", [](auto& s) -> auto& { return s.output.depth; }));
        k.push_back(flag(
            "output.skip_identical", [](auto& s) -> auto& { return s.output.skipIdentical; }));
        k.push_back(integer(
            "graphics.device", -1, 255, "EGL device, -1 for the first that works",
            [](auto& s) -> auto& { return s.graphics.device; }));
        k.push_back(live(choice(
            "log.level", {"debug", "info", "warning", "error"},
            [](auto& s) -> auto& { return s.log.level; })));
        return k;
    }();
    return keys;
}

std::string place(const std::string& source, const toml::source_region& region)
{
    return region.begin.line > 0 ? source + ":" + std::to_string(region.begin.line) : source;
}

Result<void> store(const std::string& name, const toml::node& node, const std::string& source,
                   Settings& settings)
{
    const auto& keys = allKeys();
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const Key& k) { return k.name == name; });
    if (key == keys.end()) {
        return fail(ErrorKind::usage, place(source, node.source()) + ": unknown key '" + name +
                                          "'; config/eyepoint.toml lists every key");
    }
    if (!key->store(node, settings)) {
        return fail(ErrorKind::usage,
                    place(source, node.source()) + ": key '" + name + "': expected " + key->expected);
    }
    return {};
}

Result<void> apply(const toml::table& file, const std::string& source, Settings& settings)
{
    for (const auto& [section, node] : file) {
        const std::string sectionName(section.str());
        const toml::table* table = node.as_table();
        if (table == nullptr) {
            return fail(ErrorKind::usage, place(source, node.source()) + ": key '" + sectionName +
                                              "' is outside a section such as [terrain]");
        }
        for (const auto& [key, value] : *table) {
            if (auto stored = store(sectionName + "." + std::string(key.str()), value, source, settings);
                !stored) {
                return stored;
            }
        }
    }
    return {};
}

} // namespace

Result<Settings> load(const std::string& path)
{
    try {
        const toml::table file = toml::parse_file(path);
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
        return store(name, *table->get("value"), source, settings);
    }
    toml::table unquoted;
    unquoted.insert("value", value);
    return store(name, *unquoted.get("value"), source, settings);
}

Result<void> check(const Settings& settings)
{
    if (settings.terrain.file.empty()) {
        return fail(
            ErrorKind::usage,
            "no terrain: give --terrain FILE.ept or terrain.file; make one with eyepoint-terrain build");
    }
    if (settings.terrain.frameTimeMs > 0) {
        if (settings.terrain.smallestTriangleBudget > settings.terrain.triangleBudget) {
            return fail(ErrorKind::usage, "terrain.smallest_triangle_budget is " +
                                              std::to_string(settings.terrain.smallestTriangleBudget) +
                                              ", above terrain.triangle_budget, " +
                                              std::to_string(settings.terrain.triangleBudget) + ": lower it");
        }
        if (settings.terrain.frameTimeMs > 1000.0 / settings.view.rateHz) {
            return fail(ErrorKind::usage, "terrain.frame_time_ms is " +
                                              shortNumber(settings.terrain.frameTimeMs) +
                                              ", longer than a frame at view.rate_hz, " +
                                              shortNumber(settings.view.rateHz) + ": lower one of them");
        }
    }
    return {};
}

std::vector<Change> changes(const Settings& from, const Settings& to)
{
    std::vector<Change> out;
    for (const Key& key : allKeys()) {
        if (!key.same(from, to)) {
            out.push_back({key.name, key.live});
        }
    }
    return out;
}

void applyLive(const Settings& from, Settings& to)
{
    for (const Key& key : allKeys()) {
        if (key.live) {
            key.copy(from, to);
        }
    }
}

std::vector<KeyInfo> keys()
{
    std::vector<KeyInfo> out;
    for (const Key& key : allKeys()) {
        out.push_back({key.name, key.expected, key.live});
    }
    return out;
}

} // namespace config
