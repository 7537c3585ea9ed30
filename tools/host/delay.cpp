// SPDX-License-Identifier: MIT
#include "tools/host/delay.h"

#include "hostif/udp_socket.h"
#include "ig/out/eyepoint_frames.h" // first: it wants _GNU_SOURCE

#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

namespace host {

namespace {

// How long the picture may take to come to rest, and how long it must then have rested.
constexpr double kMostUnrestS = 30;
constexpr double kRestS = 0.5;
// After the last step: what takes longer is not seen.
constexpr double kLastFramesS = 10;
constexpr int kSliceMs = 100;
constexpr double kBinMs = 2;

int64_t nowNs()
{
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double nowS()
{
    return 1e-9 * static_cast<double>(nowNs());
}

// Numbers of host messages wrap: a is b or newer.
bool reached(uint32_t a, uint32_t b)
{
    return static_cast<int32_t>(a - b) >= 0;
}

// Takes every frame out of a ring on a thread of its own.
class Taker {
public:
    static ig::Result<std::unique_ptr<Taker>> open(const std::string& name)
    {
        std::unique_ptr<Taker> taker(new Taker);
        char why[256] = "";
        if (eyepoint_frames_open(&taker->_ring, name.c_str(), why, sizeof why) != EYEPOINT_OK)
            return ig::fail(ig::ErrorKind::failed, why);
        for (auto& picture : taker->_pictures)
            picture.resize(eyepoint_colour_bytes(&taker->_ring));
        taker->_thread = std::thread([t = taker.get()] { t->take(); });
        return taker;
    }
    ~Taker()
    {
        stop();
        eyepoint_frames_close(&_ring);
    }
    Taker(const Taker&) = delete;
    Taker& operator=(const Taker&) = delete;

    double frameMs() const { return 1e3 / _ring.rate_hz; }
    bool ended() const { return _ended; }
    int64_t lastChangeNs() const { return _lastChangeNs; }
    uint64_t taken() const { return _count; }
    uint32_t newestHostFrame() const { return _newestHostFrame; }
    // All frames; ends the taking.
    std::vector<TakenFrame> stop()
    {
        _stop = true;
        if (_thread.joinable())
            _thread.join();
        return std::move(_frames);
    }

private:
    Taker() = default;

    void take()
    {
        uint64_t index = eyepoint_frames_newest(&_ring);
        size_t current = 0;
        while (!_stop) {
            const int waited = eyepoint_frames_wait(&_ring, index, kSliceMs);
            if (waited == EYEPOINT_TIMEOUT)
                continue;
            if (waited != EYEPOINT_OK) {
                _ended = true;
                return;
            }
            eyepoint_receipt receipt{};
            auto& picture = _pictures[current];
            if (eyepoint_frames_copy(&_ring, index, &receipt, picture.data(), nullptr) == EYEPOINT_OK) {
                const int64_t takenNs = nowNs();
                const auto& before = _pictures[1 - current];
                const bool changed =
                    _count == 0 || std::memcmp(picture.data(), before.data(), picture.size()) != 0;
                _frames.push_back({static_cast<uint32_t>(receipt.host_frame), takenNs, changed});
                if (changed)
                    _lastChangeNs = takenNs;
                _newestHostFrame = static_cast<uint32_t>(receipt.host_frame);
                ++_count;
                current = 1 - current;
            }
            index = eyepoint_frames_following(&_ring, index);
        }
    }

    eyepoint_frames _ring{};
    std::array<std::vector<unsigned char>, 2> _pictures;
    std::vector<TakenFrame> _frames; // of the thread until it has ended
    std::atomic<uint64_t> _count{0};
    std::atomic<uint32_t> _newestHostFrame{0};
    std::atomic<int64_t> _lastChangeNs{0};
    std::atomic<bool> _stop{false};
    std::atomic<bool> _ended{false};
    std::thread _thread;
};

// The host's messages: at its rate, and one more whenever a step is due.
class Stepper {
public:
    Stepper(const RunOptions& options, hostif::UdpSocket& socket, const volatile std::sig_atomic_t& stop)
        : _options(options), _socket(socket), _link(options.link), _stop(stop), _pose(options.poseAt(0)),
          _level(_pose), _nextBeatS(nowS())
    {
    }

    LinkPhase phase() const { return _link.phase(); }

    // Keeps the rate until `endS`, or until `done`.
    template <class Done>
    void beat(double endS, Done done)
    {
        while (!_stop && !done() && nowS() < endS) {
            listenUntil(std::min(_nextBeatS, endS));
            if (nowS() < _nextBeatS)
                continue;
            send();
            const double periodS = 1 / _options.rateHz;
            _nextBeatS = std::max(_nextBeatS + periodS, nowS() - periodS); // no bursts after a stall
        }
    }

    // Sends the step that is due now.
    Step step(size_t axis, double stepDeg, double dueS)
    {
        const std::array<double Pose::*, kStepAxes.size()> members{&Pose::pitchDeg, &Pose::rollDeg,
                                                                   &Pose::yawDeg};
        double& angle = _pose.*members[axis];
        const double levelDeg = _level.*members[axis];
        // Away from the limit of a pitch and a yaw that must not become 360.
        const double awayDeg = levelDeg > 0 ? levelDeg - stepDeg : levelDeg + stepDeg;
        angle = angle == levelDeg ? awayDeg : levelDeg;
        send();
        return {axis, _frame, std::llround(1e9 * dueS)};
    }

private:
    void send()
    {
        ++_frame; // as the link counts
        _socket.send(_link.nextMessage(_pose, nowS()), _options.target);
    }

    void listenUntil(double deadlineS)
    {
        do {
            _socket.wait(deadlineS - nowS());
            hostif::UdpSocket::Received received;
            while (nowS() < deadlineS && _socket.receive(received)) {
                if (received.sender.sameHost(_options.target))
                    _link.receive(received.bytes, received.arrivalS);
            }
        } while (!_stop && nowS() < deadlineS);
    }

    const RunOptions& _options;
    hostif::UdpSocket& _socket;
    HostLink _link;
    const volatile std::sig_atomic_t& _stop;
    Pose _pose;
    const Pose _level;
    double _nextBeatS;
    uint32_t _frame = 0;
};

double quantileMs(const std::vector<double>& sorted, double q)
{
    if (sorted.empty())
        return 0;
    const auto rank = static_cast<size_t>(std::ceil(q * static_cast<double>(sorted.size())));
    return sorted[std::max<size_t>(rank, 1) - 1];
}

struct Summary {
    size_t count = 0;
    double meanMs = 0, p50Ms = 0, p95Ms = 0, p99Ms = 0, maxMs = 0;
};

Summary summaryOf(std::vector<double> delaysMs)
{
    std::sort(delaysMs.begin(), delaysMs.end());
    Summary out;
    out.count = delaysMs.size();
    for (const double delayMs : delaysMs)
        out.meanMs += delayMs / static_cast<double>(delaysMs.size());
    out.p50Ms = quantileMs(delaysMs, 0.5);
    out.p95Ms = quantileMs(delaysMs, 0.95);
    out.p99Ms = quantileMs(delaysMs, 0.99);
    out.maxMs = quantileMs(delaysMs, 1);
    return out;
}

std::vector<double> allOf(const DelayResult& result)
{
    std::vector<double> all;
    for (const auto& axis : result.delaysMs)
        all.insert(all.end(), axis.begin(), axis.end());
    return all;
}

// Counts per kBinMs, from 0 on.
std::vector<uint64_t> binsOf(const std::vector<double>& delaysMs)
{
    std::vector<uint64_t> bins;
    for (const double delayMs : delaysMs) {
        const auto bin = static_cast<size_t>(std::clamp(delayMs / kBinMs, 0.0, 1e5));
        bins.resize(std::max(bins.size(), bin + 1));
        ++bins[bin];
    }
    return bins;
}

nlohmann::ordered_json jsonOf(const Summary& s)
{
    return {{"count", s.count}, {"mean", s.meanMs}, {"p50", s.p50Ms},
            {"p95", s.p95Ms},   {"p99", s.p99Ms},   {"max", s.maxMs}};
}

} // namespace

DelayResult matchSteps(const std::vector<Step>& steps, const std::vector<TakenFrame>& frames)
{
    DelayResult out;
    out.frames = frames.size();
    size_t first = 0; // that knows the step
    std::vector<bool> prompted(frames.size(), false);
    for (size_t i = 0; i < steps.size(); ++i) {
        while (first < frames.size() && !reached(frames[first].hostFrame, steps[i].hostFrame))
            ++first;
        size_t end = first; // of the frames that know this step, and not the next one
        while (end < frames.size() && (i + 1 == steps.size() || end == first ||
                                       !reached(frames[end].hostFrame, steps[i + 1].hostFrame)))
            ++end;
        size_t shown = first;
        while (shown < end && !frames[shown].changed)
            ++shown;
        if (shown == end) {
            ++out.unseen;
            continue;
        }
        prompted[shown] = true;
        out.delaysMs[steps[i].axis].push_back(1e-6 *
                                              static_cast<double>(frames[shown].takenNs - steps[i].dueNs));
    }
    const uint32_t begin = steps.empty() ? 0 : steps.front().hostFrame;
    for (size_t i = 0; i < frames.size(); ++i)
        out.restless +=
            !steps.empty() && reached(frames[i].hostFrame, begin) && frames[i].changed && !prompted[i] ? 1
                                                                                                       : 0;
    return out;
}

ig::Result<DelayResult> measureDelay(const RunOptions& options, const DelayOptions& delay,
                                     const volatile std::sig_atomic_t& stop)
{
    auto socket = hostif::UdpSocket::open(localAddress(options));
    if (!socket)
        return ig::Unexpected{socket.error()};
    Stepper stepper(options, *socket, stop);
    stepper.beat(nowS() + options.waitS, [&] {
        return stepper.phase() == LinkPhase::ready || stepper.phase() == LinkPhase::refused;
    });
    if (stepper.phase() != LinkPhase::ready)
        return ig::Unexpected{handshakeFailure(options, stepper.phase())};
    auto taker = Taker::open(delay.ring);
    if (!taker)
        return ig::Unexpected{taker.error()};
    const auto rests = [&] {
        return (*taker)->taken() > 1 && nowNs() - (*taker)->lastChangeNs() > std::llround(kRestS * 1e9);
    };
    stepper.beat(nowS() + kMostUnrestS, [&] { return rests() || (*taker)->ended(); });
    if (!rests() && !stop)
        return ig::fail(ig::ErrorKind::failed, "the picture of \"" + delay.ring +
                                                   "\" did not come to rest in " +
                                                   std::to_string(int(kMostUnrestS)) +
                                                   " s, so no step would be told from it; is another host "
                                                   "flying, or another view in the ring?");

    // All times are known before the first step.
    constexpr uint64_t kSeed = 1;
    std::mt19937_64 random(kSeed);
    std::uniform_real_distribution<double> phase(-0.5, 0.5);
    const size_t count = static_cast<size_t>(delay.stepsPerAxis) * kStepAxes.size();
    const double startS = nowS() + delay.intervalS;
    std::vector<double> dueS;
    for (size_t i = 0; i < count; ++i)
        dueS.push_back(startS + delay.intervalS * (static_cast<double>(i) + 0.5 * phase(random)));
    std::vector<Step> steps;
    for (size_t i = 0; i < count && !stop && !(*taker)->ended(); ++i) {
        stepper.beat(dueS[i], [] { return false; });
        steps.push_back(stepper.step(i % kStepAxes.size(), delay.stepDeg, dueS[i]));
    }
    const uint32_t last = steps.empty() ? 0 : steps.back().hostFrame;
    stepper.beat(nowS() + kLastFramesS, [&] {
        return (*taker)->ended() || (reached((*taker)->newestHostFrame(), last) && rests());
    });
    const double frameMs = (*taker)->frameMs();
    DelayResult result = matchSteps(steps, (*taker)->stop());
    result.frameMs = frameMs;
    result.interrupted = steps.size() < count;
    return result;
}

bool delayIsFine(const DelayOptions& delay, const DelayResult& result)
{
    const double p99Ms = summaryOf(allOf(result)).p99Ms;
    return result.unseen == 0 && !result.interrupted &&
           (delay.limitFrames <= 0 || p99Ms <= delay.limitFrames * result.frameMs);
}

std::string delayText(const DelayOptions& delay, const DelayResult& result)
{
    std::string text;
    char line[200];
    const auto add = [&](const char* name, const Summary& s) {
        std::snprintf(line, sizeof line,
                      "%-6s %5zu steps, mean %6.2f, p50 %6.2f, p95 %6.2f, p99 %6.2f, max %6.2f ms\n", name,
                      s.count, s.meanMs, s.p50Ms, s.p95Ms, s.p99Ms, s.maxMs);
        text += line;
    };
    for (size_t axis = 0; axis < kStepAxes.size(); ++axis)
        add(kStepAxes[axis], summaryOf(result.delaysMs[axis]));
    const std::vector<double> delaysMs = allOf(result);
    const Summary all = summaryOf(delaysMs);
    add("all", all);
    std::snprintf(
        line, sizeof line, "p99 is %.2f frames of %.2f ms; %llu steps unseen, %llu restless frames%s\n",
        result.frameMs > 0 ? all.p99Ms / result.frameMs : 0, result.frameMs,
        static_cast<unsigned long long>(result.unseen), static_cast<unsigned long long>(result.restless),
        result.interrupted ? ", interrupted" : "");
    text += line;
    const std::vector<uint64_t> bins = binsOf(delaysMs);
    const uint64_t most = bins.empty() ? 1 : *std::max_element(bins.begin(), bins.end());
    for (size_t bin = 0; bin < bins.size(); ++bin) {
        if (bins[bin] == 0)
            continue;
        constexpr uint64_t kWidest = 50;
        std::snprintf(line, sizeof line, "%4.0f ms %5llu ", kBinMs * static_cast<double>(bin),
                      static_cast<unsigned long long>(bins[bin]));
        text.append(line).append((bins[bin] * kWidest + most - 1) / most, '#').push_back('\n');
    }
    if (delay.limitFrames > 0) {
        std::snprintf(line, sizeof line, "limit %.2f frames: %s\n", delay.limitFrames,
                      delayIsFine(delay, result) ? "kept" : "not kept");
        text += line;
    }
    return text;
}

std::string delayJson(const DelayOptions& delay, const DelayResult& result)
{
    const std::vector<double> delaysMs = allOf(result);
    const Summary all = summaryOf(delaysMs);
    nlohmann::ordered_json axes;
    for (size_t axis = 0; axis < kStepAxes.size(); ++axis)
        axes[kStepAxes[axis]] = jsonOf(summaryOf(result.delaysMs[axis]));
    const nlohmann::ordered_json report = {
        {"ring", delay.ring},
        {"frame_ms", result.frameMs},
        {"frames", result.frames},
        {"steps", all.count + result.unseen},
        {"unseen", result.unseen},
        {"restless_frames", result.restless},
        {"interrupted", result.interrupted},
        {"delay_ms", jsonOf(all)},
        {"axes_ms", axes},
        {"p99_frames", result.frameMs > 0 ? all.p99Ms / result.frameMs : 0},
        {"limit_frames", delay.limitFrames},
        {"fine", delayIsFine(delay, result)},
        {"histogram", {{"bin_ms", kBinMs}, {"counts", binsOf(delaysMs)}}},
    };
    return report.dump();
}

} // namespace host
