// SPDX-License-Identifier: MIT
#include "tools/report/page_need.h"

#include <algorithm>

namespace report {

using namespace ig;

namespace {

constexpr uint32_t kFewestSlots = 512;
constexpr uint32_t kStep = lod::Prefetch::kMaxMissing; // what one plan brings

uint32_t roundedUp(uint32_t pages)
{
    return (pages + kStep - 1) / kStep * kStep;
}

} // namespace

Result<uint32_t> slotsNeeded(const Scene& scene, Setting setting, std::span<const ViewState> flight,
                             LogSink& log, size_t views)
{
    const auto dataset = data::Dataset::open(scene.terrain);
    if (!dataset) {
        return Unexpected{dataset.error()};
    }
    const auto pages = static_cast<uint32_t>(dataset->pages().size());
    if (pages <= kFewestSlots) {
        return pages;
    }
    // One fewer than there are: where all fit, nobody notes which are in use.
    setting.pageSlots = std::min(kMostSlots, pages - 1);
    if (setting.method == "soar") {
        setting.method = "bintree"; // the same pages, in less time
    }
    auto run = EngineRun::createBlind(scene, setting, log, views);
    if (!run) {
        return Unexpected{run.error()};
    }
    for (size_t view = 0; view < std::min(views, flight.size()); ++view) {
        if (auto warm = run->warmUp(flight[view], view); !warm) {
            return Unexpected{warm.error()};
        }
    }
    uint32_t most = 0;
    for (size_t i = 0; i < flight.size(); ++i) {
        (void)run->frame(flight[i], i % views);
        most = std::max(most, run->pagesInUse());
    }
    return std::min({std::max(roundedUp(most) + kStep, kFewestSlots), kMostSlots, pages});
}

} // namespace report
