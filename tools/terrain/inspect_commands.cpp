// SPDX-License-Identifier: MIT
// info and verify: the commands that read a dataset.
#include "ig/data/dataset.h"
#include "tools/terrain/commands.h"
#include "tools/terrain/parallel.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <vector>

namespace ig::terrain {

namespace {

// Names come from files: bytes that are no UTF-8 are replaced.
void printJson(const nlohmann::ordered_json& json)
{
    std::puts(json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
}

std::string hex(uint64_t value)
{
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

void printInfoJson(const data::Dataset& dataset, const std::string& file)
{
    const data::DatasetInfo& info = dataset.info();
    const lod::TerrainShape& shape = info.shape;
    printJson({{"file", file},
               {"bytes", info.fileBytes},
               {"checksum", hex(info.checksum)},
               {"source", info.source},
               {"cols", shape.cols},
               {"rows", shape.rows},
               {"north_deg", shape.northRad * kDegPerRad},
               {"west_deg", shape.westRad * kDegPerRad},
               {"south_deg", (shape.northRad - (shape.rows - 1) * shape.latitudeStepRad) * kDegPerRad},
               {"east_deg", (shape.westRad + (shape.cols - 1) * shape.longitudeStepRad) * kDegPerRad},
               {"latitude_step_deg", shape.latitudeStepRad * kDegPerRad},
               {"longitude_step_deg", shape.longitudeStepRad * kDegPerRad},
               {"ellipsoid",
                {{"semi_major_m", shape.ellipsoid.semiMajorM}, {"flattening", shape.ellipsoid.flattening}}},
               {"vertical_datum", info.verticalDatum},
               {"height_scale_m", info.heightScaleM},
               {"height_offset_m", info.heightOffsetM},
               {"min_height_m", info.minHeightM},
               {"max_height_m", info.maxHeightM},
               {"holes", info.hasHoles},
               {"deepest_page", shape.deepestPage},
               {"pages", dataset.pages().size()},
               {"root_error_m", dataset.pages()[0].errorM}});
}

void printInfoText(const data::Dataset& dataset, const std::string& file)
{
    const data::DatasetInfo& info = dataset.info();
    const lod::TerrainShape& shape = info.shape;
    const double south = (shape.northRad - (shape.rows - 1) * shape.latitudeStepRad) * kDegPerRad;
    const double east = (shape.westRad + (shape.cols - 1) * shape.longitudeStepRad) * kDegPerRad;
    const double rawBytes = 2.0 * shape.cols * shape.rows;
    std::printf("file            %s, %llu bytes, %.3f of the raw 16-bit grid\n", file.c_str(),
                static_cast<unsigned long long>(info.fileBytes),
                static_cast<double>(info.fileBytes) / rawBytes);
    std::printf("source          %s\n", info.source.c_str());
    std::printf("posts           %u x %u, every %.9g x %.9g degrees (longitude x latitude)\n", shape.cols,
                shape.rows, shape.longitudeStepRad * kDegPerRad, shape.latitudeStepRad * kDegPerRad);
    std::printf("extent          %.6f to %.6f north, %.6f to %.6f east\n", south, shape.northRad * kDegPerRad,
                shape.westRad * kDegPerRad, east);
    std::printf("ellipsoid       %.3f m, flattening %.12g\n", shape.ellipsoid.semiMajorM,
                shape.ellipsoid.flattening);
    std::printf("heights         %.2f to %.2f m, steps of %g m, vertical datum %s%s\n", info.minHeightM,
                info.maxHeightM, info.heightScaleM, info.verticalDatum.c_str(),
                info.hasHoles ? ", with holes" : "");
    std::printf("pages           %zu, depths 0 to %d, error of the coarsest %.1f m\n", dataset.pages().size(),
                shape.deepestPage, static_cast<double>(dataset.pages()[0].errorM));
    std::printf("checksum        %s\n", hex(info.checksum).c_str());
}

// Standard output may be a pipe that nobody reads any more.
Result<int> written(int code)
{
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        return fail(ErrorKind::failed, "cannot write to standard output");
    return code;
}

struct BadPage {
    uint32_t page;
    std::string error;
};

std::vector<BadPage> badPages(const data::Dataset& dataset)
{
    const auto count = static_cast<uint32_t>(dataset.pages().size());
    std::vector<std::vector<BadPage>> found(workerCount());
    parallelFor(count, [&](size_t page, unsigned worker) {
        const auto number = static_cast<uint32_t>(page);
        if (const Result<void> sound = dataset.checkPage(number); !sound)
            found[worker].push_back({number, sound.error().message});
    });
    std::vector<BadPage> all;
    for (const std::vector<BadPage>& some : found)
        all.insert(all.end(), some.begin(), some.end());
    std::sort(all.begin(), all.end(), [](const BadPage& a, const BadPage& b) { return a.page < b.page; });
    return all;
}

} // namespace

Result<int> runInfo(const InspectCommand& command)
{
    const Result<data::Dataset> dataset = data::Dataset::open(command.file);
    if (!dataset)
        return Unexpected{dataset.error()};
    if (command.asJson)
        printInfoJson(*dataset, command.file);
    else
        printInfoText(*dataset, command.file);
    return written(0);
}

Result<int> runVerify(const InspectCommand& command)
{
    const Result<data::Dataset> dataset = data::Dataset::open(command.file);
    if (!dataset)
        return Unexpected{dataset.error()};
    const std::vector<BadPage> bad = badPages(*dataset);
    if (command.asJson) {
        auto list = nlohmann::ordered_json::array();
        for (const BadPage& page : bad) {
            const lod::PageNode& node = dataset->pages()[page.page];
            list.push_back({{"page", page.page},
                            {"depth", node.depth},
                            {"x", node.x},
                            {"y", node.y},
                            {"error", page.error}});
        }
        printJson(
            {{"file", command.file}, {"pages", dataset->pages().size()}, {"ok", bad.empty()}, {"bad", list}});
    } else {
        for (const BadPage& page : bad)
            std::printf("%s\n", page.error.c_str());
        std::printf("%s: %zu pages, %zu bad\n", command.file.c_str(), dataset->pages().size(), bad.size());
    }
    return written(bad.empty() ? 0 : exitCode(ErrorKind::dataset));
}

} // namespace ig::terrain
