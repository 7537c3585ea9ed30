// SPDX-License-Identifier: MIT
#include "tools/host/report.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

namespace host {

namespace {

// Events per second between the first and the last of `count`.
double rateHz(uint64_t count, double firstS, double lastS)
{
    return count > 1 && lastS > firstS ? double(count - 1) / (lastS - firstS) : 0;
}

template <class... Args>
void addLine(std::string& text, const char* format, Args... args)
{
    char line[200];
    std::snprintf(line, sizeof line, format, args...);
    text.append(line).push_back('\n');
}

using Count = unsigned long long;

} // namespace

RoundTrip summarize(std::vector<double> roundTripsS)
{
    if (roundTripsS.empty())
        return {};
    std::sort(roundTripsS.begin(), roundTripsS.end());
    // Nearest rank: the smallest value that at least this share of all does not exceed.
    const auto quantileMs = [&](size_t percent) {
        const size_t rank = (roundTripsS.size() * percent + 99) / 100;
        return 1e3 * roundTripsS[std::max<size_t>(rank, 1) - 1];
    };
    return {quantileMs(50), quantileMs(95), 1e3 * roundTripsS.back(), roundTripsS.size()};
}

std::string textReport(const RunSetup& setup, const RunResult& result)
{
    const LinkStats& link = result.link;
    const RoundTrip trip = summarize(link.roundTripsS);
    std::string text;
    addLine(text, "%s, %s, %s-endian%s", setup.target.c_str(), setup.protocol.c_str(),
            setup.bigEndian ? "big" : "little", result.interrupted ? ", interrupted" : "");
    addLine(text, "ready after   %.2f s, flown %.2f s", result.readyAfterS, result.flownS);
    addLine(text, "sent          %llu frames at %.2f Hz (asked %.2f), %llu skipped", Count(link.framesSent),
            rateHz(link.framesSent, link.firstSentS, link.lastSentS), setup.rateHz,
            Count(result.framesSkipped));
    addLine(text, "received      %llu Start Of Frames at %.2f Hz", Count(link.startOfFrames),
            rateHz(link.startOfFrames, link.firstSofS, link.lastSofS));
    addLine(text,
            "lost          %llu to here (%llu duplicate, %llu late), %llu of ours unacknowledged, %llu "
            "passed over",
            Count(link.sofLost), Count(link.sofDuplicate), Count(link.sofLate),
            Count(link.framesUnacknowledged), Count(link.framesPassedOver));
    addLine(text, "faults        %llu malformed, %llu bad acknowledgements, %llu restarts",
            Count(link.malformed), Count(link.badEchoes), Count(link.igRestarts));
    addLine(text, "round trip    p50 %.2f ms, p95 %.2f ms, max %.2f ms of %zu", trip.p50Ms, trip.p95Ms,
            trip.maxMs, trip.count);
    if (setup.hostileSent > 0)
        addLine(text, "hostile       %llu datagrams", Count(setup.hostileSent));
    return text;
}

std::string jsonReport(const RunSetup& setup, const RunResult& result)
{
    const LinkStats& link = result.link;
    const RoundTrip trip = summarize(link.roundTripsS);
    const nlohmann::ordered_json report = {
        {"target", setup.target},
        {"protocol", setup.protocol},
        {"byte_order", setup.bigEndian ? "big" : "little"},
        {"interrupted", result.interrupted},
        {"ready_after_s", result.readyAfterS},
        {"flown_s", result.flownS},
        {"frames_sent", link.framesSent},
        {"frames_skipped", result.framesSkipped},
        {"frames_unacknowledged", link.framesUnacknowledged},
        {"frames_passed_over", link.framesPassedOver},
        {"rate_hz", rateHz(link.framesSent, link.firstSentS, link.lastSentS)},
        {"sof_received", link.startOfFrames},
        {"sof_lost", link.sofLost},
        {"sof_duplicate", link.sofDuplicate},
        {"sof_late", link.sofLate},
        {"sof_rate_hz", rateHz(link.startOfFrames, link.firstSofS, link.lastSofS)},
        {"malformed", link.malformed},
        {"bad_acknowledgements", link.badEchoes},
        {"hostile_sent", setup.hostileSent},
        {"ig_restarts", link.igRestarts},
        {"round_trip_ms",
         {{"count", trip.count}, {"p50", trip.p50Ms}, {"p95", trip.p95Ms}, {"max", trip.maxMs}}},
    };
    return report.dump();
}

} // namespace host
