// SPDX-License-Identifier: MIT
#include "ig/app/explain.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ig::app {

std::string Explanation::table() const
{
    std::string text = fmt::format("{:<38} {:<9} {:>9} {:>9} {:>11} {:>8} {:>9} {:>8}  {}\n", "part", "",
                                   "ms/frame", "ms/page", "bytes", "threads", "triangles", "pixels", "why");
    const auto cell = [](const auto& value, const char* format) {
        return value ? fmt::format(fmt::runtime(format), *value) : std::string("-");
    };
    for (const Part& part : parts) {
        text += fmt::format("{:<38} {:<9} {:>9} {:>9} {:>11} {:>8} {:>9} {:>8}  {}\n", part.name,
                            part.used ? "used" : "left out", cell(part.cost.frameMs, "{:+.4f}"),
                            cell(part.cost.pageMs, "{:+.3f}"), cell(part.cost.bytes, "{:+}"),
                            cell(part.cost.threads, "{:+}"), cell(part.cost.triangles, "{:+}"),
                            cell(part.cost.changedPixels, "{}"), part.why);
    }
    return text +
           fmt::format(
               "with the part less without it, the fastest of some frames each: a frame less itself comes to "
               "{:.3f} ms; depth, control, host, queries, sinks, metrics and log are what their calls "
               "take of a frame, and a copy of a picture less itself comes to {:.3f} ms; pixels: of the "
               "first picture, that it changes\n"
               "the first view looks at {} tiles; the dataset has {} pages\n{}\n",
               noiseMs, callNoiseMs, tilesVisited, tiles, target);
}

std::string Explanation::json() const
{
    using Json = nlohmann::ordered_json;
    const auto number = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
    Json list = Json::array();
    for (const Part& part : parts) {
        list.push_back({{"part", part.name},
                        {"used", part.used},
                        {"why", part.why},
                        {"frame_ms", number(part.cost.frameMs)},
                        {"page_ms", number(part.cost.pageMs)},
                        {"bytes", number(part.cost.bytes)},
                        {"threads", number(part.cost.threads)},
                        {"triangles", number(part.cost.triangles)},
                        {"changed_pixels", number(part.cost.changedPixels)}});
    }
    const Json json{{"target", target}, {"noise_ms", noiseMs},           {"call_noise_ms", callNoiseMs},
                    {"pages", tiles},   {"tiles_visited", tilesVisited}, {"parts", list}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace ig::app
