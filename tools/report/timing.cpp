// SPDX-License-Identifier: MIT
#include "tools/report/timing.h"

#include "tools/report/machine.h"

#include <malloc.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <utility>

namespace report {

using namespace ig;

namespace {

constexpr size_t kMostAtOnce = 32; // about 80 MB each

// A setting on its way. Memory that the process gains while it is at work counts as its own.
class TimedFlight {
public:
    static Result<TimedFlight> create(const gl::Context& context, const Scene& scene, const Setting& setting,
                                      const ViewState& first, LogSink& log)
    {
        const uint64_t before = residentBytes();
        auto run = EngineRun::create(context, scene, setting, log);
        if (!run) {
            return Unexpected{run.error()};
        }
        if (auto warm = run->warmUp(first); !warm) {
            return Unexpected{warm.error()};
        }
        TimedFlight flight(*std::move(run), setting, first);
        flight.countMemory(before);
        return flight;
    }

    void fly(std::span<const ViewState> views, EnergyMeter& energy)
    {
        const uint64_t before = residentBytes();
        _run.drawAgain(_last);
        _last = views.back();
        for (const ViewState& view : views) {
            const double joules = energy.joules();
            const EngineRun::Cost cost = _run.frame(view);
            _frames.push_back({cost.stats, cost.cpuMs, energy.joules() - joules, hashOf(_run.drawList())});
        }
        countMemory(before);
    }

    Json json() const { return timedFlightJson(_setting, _frames, {_run.gpuBytes(), _grownBytes}); }

private:
    TimedFlight(EngineRun run, Setting setting, const ViewState& first)
        : _run(std::move(run)), _setting(std::move(setting)), _last(first)
    {
    }

    void countMemory(uint64_t residentBefore)
    {
        const uint64_t now = residentBytes();
        _grownBytes += now > residentBefore ? now - residentBefore : 0;
    }

    EngineRun _run;
    Setting _setting;
    ViewState _last; // of the frame before
    std::vector<TimedFrame> _frames;
    uint64_t _grownBytes = 0;
};

} // namespace

Result<std::vector<Json>> timePass(const gl::Context& context, const Scene& scene,
                                   std::span<const Setting> settings, const std::vector<ViewState>& views,
                                   unsigned pass, LogSink& log, const Progress& progress)
{
    std::mt19937 random(pass);
    EnergyMeter energy;
    std::vector<Json> flown;
    size_t framesDone = 0;
    for (size_t first = 0; first < settings.size(); first += kMostAtOnce) {
        malloc_trim(0); // what was freed before is not to be taken for a flight's
        std::vector<TimedFlight> flights;
        for (const Setting& setting :
             settings.subspan(first, std::min(kMostAtOnce, settings.size() - first))) {
            auto flight = TimedFlight::create(context, scene, setting, views.front(), log);
            if (!flight) {
                return Unexpected{flight.error()};
            }
            flights.push_back(*std::move(flight));
        }
        std::vector<size_t> order(flights.size());
        std::iota(order.begin(), order.end(), size_t{0});
        for (size_t frame = 0; frame < views.size(); frame += kBlockFrames) {
            const auto block = std::span(views).subspan(frame, std::min(kBlockFrames, views.size() - frame));
            std::shuffle(order.begin(), order.end(), random);
            for (const size_t i : order) {
                flights[i].fly(block, energy);
                framesDone += block.size();
                progress(static_cast<double>(framesDone) /
                         static_cast<double>(settings.size() * views.size()));
            }
        }
        for (const TimedFlight& flight : flights) {
            flown.push_back(flight.json());
        }
    }
    return flown;
}

} // namespace report
