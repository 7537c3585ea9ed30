// SPDX-License-Identifier: MIT
// What it costs to hand frames out: a frame of 1280 x 720 into the ring and out of it again, torn reads under
// pressure, and whole frames with ring, receipts, metrics and log against whole frames into nothing: back to
// back, and in a soak at 60 Hz that hosts fly. Prints JSON.
#include "ig/app/command_line.h"
#include "ig/app/frame_schedule.h"
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/metrics_server.h"
#include "ig/app/signals.h"
#include "ig/app/steady_clock.h"
#include "ig/base/histogram.h"
#include "land_grid.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <new>
#include <random>
#include <span>
#include <string_view>
#include <thread>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

constexpr double kRateHz = 60;

struct Options {
    std::string terrain;
    int frames = 600;           // of the costs, each
    uint64_t reads = 1'000'000; // torn reads
    double seconds = 60;        // of the soak's flight, with and again without
    double timesFaster = 1;     // than at 60 Hz the soak goes by: the same flight, in as much less time
    bool soakOnly = false;
    bool alone = false; // the soak flies with all, and not without
    int widthPx = 1280;
    int heightPx = 720;
};

[[noreturn]] void giveUp(const std::string& why)
{
    std::fprintf(stderr, "eyepoint-frames-bench: %s\n", why.c_str());
    std::exit(1);
}

Json milliseconds(const Histogram& h)
{
    return {{"mean", h.meanNs() * 1e-6},
            {"p50", h.quantileNs(0.5) * 1e-6},
            {"p99", h.quantileNs(0.99) * 1e-6},
            {"max", h.maxNs() * 1e-6}};
}

template <class T>
T& sharedWithChildren()
{
    void* memory = mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) {
        giveUp("no shared memory");
    }
    return *new (memory) T();
}

// A child process that does the work; killed with this object, and with this process.
class Child {
public:
    template <class Work>
    explicit Child(Work work) : _pid(fork())
    {
        if (_pid == 0) {
            (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
            work();
            _exit(0);
        }
    }
    ~Child()
    {
        kill(_pid, SIGCONT);
        kill(_pid, SIGKILL);
        waitpid(_pid, nullptr, 0);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    void signal(int number) const { kill(_pid, number); }

private:
    pid_t _pid;
};

void openPatiently(eyepoint_frames& ring, const std::string& name)
{
    char why[256];
    while (eyepoint_frames_open(&ring, name.c_str(), why, sizeof why) != EYEPOINT_OK) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

out::SinkFormat formatOf(int widthPx, int heightPx, int slots)
{
    out::SinkFormat format{widthPx, heightPx, kRateHz};
    format.ringSlots = slots;
    format.clockNs = app::steadyNs;
    return format;
}

std::unique_ptr<out::FrameSink> ring(const std::string& name, const out::SinkFormat& format)
{
    auto sink = out::makeSink("shm:" + name, format);
    if (!sink) {
        giveUp(sink.error().message);
    }
    return std::move(*sink);
}

std::string freshName(const char* what)
{
    return std::string("eyepoint-bench-") + what + "-" + std::to_string(getpid());
}

// Read back -> published, -> seen and -> copied by a reader in another process. The picture is touched anew
// for each frame, as a read-back does. reader: none, reading, or stopped. straight: read back into the ring,
// as the image generator does; else copied there from elsewhere.
Json publishing(const Options& options, const char* reader, bool straight)
{
    struct Shared {
        Histogram seen, copied;
        std::atomic<uint64_t> frames{0};
        std::atomic<bool> open{false};
    };
    auto& shared = sharedWithChildren<Shared>();
    const std::string name = freshName("publish");
    std::optional<Child> child;
    if (std::strcmp(reader, "none") != 0) {
        child.emplace([&] {
            eyepoint_frames frames{};
            openPatiently(frames, name);
            shared.open = true;
            std::vector<std::byte> rgba(eyepoint_colour_bytes(&frames));
            uint64_t index = 0;
            while (eyepoint_frames_wait(&frames, index, -1) == EYEPOINT_OK) {
                const int64_t seenNs = app::steadyNs();
                eyepoint_receipt receipt{};
                if (eyepoint_frames_copy(&frames, index, &receipt, rgba.data(), nullptr) == EYEPOINT_OK) {
                    shared.seen.add(seenNs - receipt.render_end_ns);
                    shared.copied.add(app::steadyNs() - receipt.render_end_ns);
                    ++shared.frames;
                }
                index = eyepoint_frames_following(&frames, index);
            }
        });
    }
    const auto sink = ring(name, formatOf(options.widthPx, options.heightPx, 4));
    while (child && !shared.open) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (std::strcmp(reader, "stopped") == 0) {
        child->signal(SIGSTOP);
    }
    std::vector<std::byte> elsewhere(static_cast<size_t>(options.widthPx * options.heightPx) * 4);
    Histogram readBack, published;
    for (int i = 0; i < options.frames; ++i) {
        const int64_t start = app::steadyNs();
        const std::span<std::byte> picture = straight ? sink->memoryForNext().rgba : std::span(elsewhere);
        std::memset(picture.data(), i & 255, picture.size());
        out::Receipt receipt{};
        receipt.render_end_ns = app::steadyNs();
        if (!sink->write(
                {options.widthPx, options.heightPx, picture, static_cast<uint64_t>(i), {}, &receipt})) {
            giveUp("the ring does not take a frame");
        }
        published.add(app::steadyNs() - receipt.render_end_ns);
        readBack.add(receipt.render_end_ns - start);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    (void)sink->close();
    Json json{{"reader", reader},
              {"read_back_into", straight ? "ring" : "elsewhere"},
              {"filling_ms", milliseconds(readBack)},
              {"read_back_to_published_ms", milliseconds(published)}};
    if (shared.frames > 0) {
        json["read_back_to_seen_ms"] = milliseconds(shared.seen);
        json["read_back_to_copied_ms"] = milliseconds(shared.copied);
        json["frames_copied"] = shared.frames.load();
    }
    return json;
}

// Four readers against a writer that never pauses, two slots; one reader is killed at a random moment.
Json tornReads(const Options& options)
{
    constexpr int kWidthPx = 64;
    constexpr int kHeightPx = 36;
    struct Shared {
        std::array<std::atomic<uint64_t>, 4> accepted{};
        std::atomic<uint64_t> torn{0}, overtaken{0};
    };
    auto& shared = sharedWithChildren<Shared>();
    const std::string name = freshName("torn");
    std::vector<std::unique_ptr<Child>> children;
    for (size_t i = 0; i < shared.accepted.size(); ++i) {
        children.push_back(std::make_unique<Child>([&] {
            eyepoint_frames frames{};
            openPatiently(frames, name);
            std::vector<std::byte> rgba(eyepoint_colour_bytes(&frames));
            uint64_t index = 0;
            while (eyepoint_frames_wait(&frames, index, -1) == EYEPOINT_OK) {
                eyepoint_receipt receipt{};
                if (eyepoint_frames_copy(&frames, index, &receipt, rgba.data(), nullptr) == EYEPOINT_OK) {
                    const auto value = static_cast<uint32_t>(receipt.frame);
                    const bool whole = std::memcmp(rgba.data(), &value, 4) == 0 &&
                                       std::memcmp(rgba.data(), rgba.data() + 4, rgba.size() - 4) == 0;
                    shared.torn += whole ? 0U : 1U;
                    ++shared.accepted[i];
                } else {
                    ++shared.overtaken;
                }
                index = eyepoint_frames_following(&frames, index);
            }
        }));
    }
    const auto sink = ring(name, formatOf(kWidthPx, kHeightPx, 2));
    std::vector<std::byte> picture(size_t{kWidthPx} * kHeightPx * 4);
    const auto reads = [&] {
        uint64_t sum = 0;
        for (const auto& count : shared.accepted) {
            sum += count;
        }
        return sum;
    };
    std::mt19937_64 random(static_cast<uint64_t>(app::steadyNs()));
    const uint64_t killAt = random() % (options.reads / 2 + 1);
    uint64_t frame = 0;
    while (reads() < options.reads) {
        for (int burst = 0; burst < 16; ++burst, ++frame) {
            const auto value = static_cast<uint32_t>(frame);
            const std::span<std::byte> pixels =
                frame % 2 == 0 ? std::span(picture) : sink->memoryForNext().rgba;
            for (size_t i = 0; i < pixels.size(); i += 4) {
                std::memcpy(&pixels[i], &value, 4);
            }
            if (!sink->write({kWidthPx, kHeightPx, pixels, frame})) {
                giveUp("the ring does not take a frame");
            }
        }
        if (children.front() && reads() >= killAt) {
            children.front().reset();
        }
        std::this_thread::yield();
    }
    (void)sink->close();
    return {{"frames_written", frame},
            {"reads_accepted", reads()},
            {"reads_overtaken", shared.overtaken.load()},
            {"torn_frames_accepted", shared.torn.load()},
            {"readers_killed", 1}};
}

class PrintedErrors final : public LogSink {
public:
    void write(LogLevel level, std::string_view line) override
    {
        if (level == LogLevel::error) {
            std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
        }
    }
};

// An image generator on a thread of its own (a thread has one GL context), which makes a frame when asked.
class Flight {
public:
    Flight(const config::Settings& settings, LogSink& log, bool withMetrics)
        : _thread([this, settings, &log, withMetrics] { run(settings, log, withMetrics); })
    {
        wait();
    }
    ~Flight()
    {
        ask(Turn::end);
        _thread.join();
    }
    Flight(const Flight&) = delete;
    Flight& operator=(const Flight&) = delete;

    void frame()
    {
        ask(Turn::frame);
        wait();
    }
    // whole: the frame and what the program does after it; sinks: handing out alone.
    Histogram whole, readBack, sinks;
    uint16_t metricsPort = 0;
    std::string address; // where it listens

private:
    enum class Turn { done, frame, end };

    void ask(Turn turn)
    {
        const std::lock_guard lock(_mutex);
        _turn = turn;
        _changed.notify_all();
    }
    void wait()
    {
        std::unique_lock lock(_mutex);
        _changed.wait(lock, [this] { return _turn == Turn::done; });
    }

    void run(const config::Settings& settings, LogSink& log, bool withMetrics)
    {
        auto generator = app::ImageGenerator::create(settings, log);
        if (!generator) {
            giveUp(generator.error().message);
        }
        const app::MetricsLabels labels = (*generator)->metricsLabels();
        std::unique_ptr<app::MetricsServer> server;
        if (withMetrics) {
            auto started = app::MetricsServer::start("127.0.0.1:0", labels);
            if (!started) {
                giveUp(started.error().message);
            }
            server = std::move(*started);
            metricsPort = server->local().port;
        }
        const std::string said = (*generator)->description();
        const size_t begin = said.find("127.0.0.1:");
        address = said.substr(begin, said.find(' ', begin) - begin);
        app::Metrics metrics = app::metricsFor(labels);
        uint64_t slot = 0;
        std::unique_lock lock(_mutex);
        while (_turn != Turn::end) {
            _turn = Turn::done;
            _changed.notify_all();
            _changed.wait(lock, [this] { return _turn != Turn::done; });
            if (_turn == Turn::frame) {
                const int64_t start = app::steadyNs();
                const app::FrameStats stats = (*generator)->frame(start, slot++).front();
                if (server) {
                    metrics.views.front().add(stats);
                    (*generator)->note(metrics);
                    server->offer(metrics);
                    log.write(LogLevel::info,
                              app::logLine("frame", {{"number", std::to_string(stats.number)}}));
                }
                whole.add(app::steadyNs() - start);
                readBack.add(stats.readBackNs);
                sinks.add(stats.sinkNs);
            }
        }
    }

    std::mutex _mutex;
    std::condition_variable _changed;
    Turn _turn = Turn::frame; // the thread says when it is ready for the first
    std::thread _thread;
};

std::string rollingLand(const test::TempDir& dir)
{
    const std::string path = dir.file("land.ept");
    const auto compiled = terrain::compileHeights(
        1025, 1025, test::landGrid(57.25, -5.5, "rolling land"),
        [](uint32_t col, uint32_t row) {
            return 300.0 + 250.0 * std::sin(col * 0.031) * std::cos(row * 0.027) +
                   60.0 * std::sin(col * 0.21);
        },
        path);
    if (!compiled) {
        giveUp(compiled.error().message);
    }
    return path;
}

config::Settings settingsOf(const Options& options, const std::string& terrain)
{
    config::Settings settings;
    settings.view.rateHz = kRateHz * options.timesFaster;
    settings.terrain.file = terrain;
    settings.host.listen = "127.0.0.1:0";
    settings.view.width = options.widthPx;
    settings.view.height = options.heightPx;
    return settings;
}

uint64_t residentBytes()
{
    std::ifstream file("/proc/self/statm");
    uint64_t pages = 0;
    file >> pages >> pages;
    return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

long descriptors()
{
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}) - 1; // less its own
}

// True when the page came.
bool scrape(uint16_t port)
{
    const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    constexpr std::string_view kRequest = "GET /metrics HTTP/1.1\r\n\r\n";
    std::string answer;
    if (connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
        send(client, kRequest.data(), kRequest.size(), MSG_NOSIGNAL) ==
            static_cast<ssize_t>(kRequest.size())) {
        std::array<char, 4096> part{};
        for (ssize_t got = 1; got > 0;) {
            got = recv(client, part.data(), part.size(), 0);
            answer.append(part.data(), static_cast<size_t>(std::max<ssize_t>(got, 0)));
        }
    }
    close(client);
    return answer.starts_with("HTTP/1.1 200");
}

// A host that flies one image generator round the middle of the synthetic land, 2.5 m a frame.
std::unique_ptr<Child> hostFor(const std::string& address, double timesFaster)
{
    const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "eyepoint-host";
    if (!std::filesystem::exists(program)) {
        giveUp("needs " + program.string());
    }
    return std::make_unique<Child>([&] {
        const int nothing = ::open("/dev/null", O_WRONLY);
        dup2(nothing, STDOUT_FILENO);
        execl(program.c_str(), program.c_str(), "--target", address.c_str(), "--orbit", "57.02,-5.1,900,3000",
              "--duration", "1e6", "--rate", std::to_string(kRateHz * timesFaster).c_str(), "--speed",
              std::to_string(150 * timesFaster).c_str(), nullptr);
    });
}

// Slope of the line through the points that is nearest in the square mean.
double slopeOf(const std::vector<std::pair<double, double>>& points)
{
    double x = 0;
    double y = 0;
    for (const auto& [px, py] : points) {
        x += px / static_cast<double>(points.size());
        y += py / static_cast<double>(points.size());
    }
    double xx = 0;
    double xy = 0;
    for (const auto& [px, py] : points) {
        xx += (px - x) * (px - x);
        xy += (px - x) * (py - y);
    }
    return xx > 0 ? xy / xx : 0.0;
}

// At the rate, in blocks in turn with and without ring, receipts, metrics and log, each for so many seconds
// of flight in all. Memory is looked at from settled_s on, and its slope is that of a second of flight.
Json soak(const Options& options, Flight& with, Flight& without, const std::atomic<uint64_t>& visited)
{
    with.whole = {};
    without.whole = {};
    const double blockS = std::min(5.0, options.seconds / 6.0);
    const double settledS = std::min(60.0, options.seconds / 5.0);
    const auto withHost = hostFor(with.address, options.timesFaster);
    const auto withoutHost = hostFor(without.address, options.timesFaster);
    std::vector<std::pair<double, double>> residentKib;
    long fewestOpen = std::numeric_limits<long>::max();
    long mostOpen = 0;
    uint64_t missed = 0;
    uint64_t missedWithout = 0;
    uint64_t scrapes = 0;
    double goneS = 0;
    const auto fly = [&](Flight& flight, const Child& host, const Child& other) {
        other.signal(SIGSTOP);
        host.signal(SIGCONT);
        const int64_t start = app::steadyNs();
        app::FrameSchedule schedule(start, kRateHz * options.timesFaster);
        while (static_cast<double>(app::steadyNs() - start) * 1e-9 * options.timesFaster < blockS) {
            flight.frame();
            app::sleepUntil(schedule.nextStartNs(app::steadyNs()));
        }
        return schedule.missed();
    };
    while (goneS < options.seconds) {
        missedWithout += options.alone ? 0 : fly(without, *withoutHost, *withHost);
        missed += fly(with, *withHost, *withoutHost);
        goneS += blockS;
        scrapes += scrape(with.metricsPort) ? 1U : 0U;
        if (goneS >= settledS) {
            residentKib.emplace_back(goneS, static_cast<double>(residentBytes()) / 1024.0);
            fewestOpen = std::min(fewestOpen, descriptors());
            mostOpen = std::max(mostOpen, descriptors());
        }
    }
    Json json{{"seconds", goneS},
              {"times_faster", options.timesFaster},
              {"frames", with.whole.count()},
              {"missed", missed},
              {"frame_ms", milliseconds(with.whole)},
              {"settled_s", settledS},
              {"resident_kib_settled", residentKib.front().second},
              {"resident_kib_at_end", residentKib.back().second},
              {"resident_kib_per_s", slopeOf(residentKib)},
              {"descriptors_fewest", fewestOpen},
              {"descriptors_most", mostOpen},
              {"metrics_scrapes", scrapes},
              {"frames_taken_by_visitor", visited.load()}};
    if (!options.alone) {
        json["missed_null"] = missedWithout;
        json["frame_null_ms"] = milliseconds(without.whole);
        json["p99_ratio"] = with.whole.quantileNs(0.99) / without.whole.quantileNs(0.99);
    }
    return json;
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    ig::app::Program app{"Benchmarks the handing out of frames.", "eyepoint-frames-bench"};
    app.add_option("--terrain", options.terrain, "dataset, .ept; by default a synthetic one");
    app.add_option("--frames", options.frames, "frames of each cost")->check(ig::app::within(1, 1'000'000));
    app.add_option("--reads", options.reads, "reads of the search for torn ones");
    app.add_option("--seconds", options.seconds,
                   "length of the soak's flight at 60 Hz with ring, receipts, metrics and log, which watches "
                   "memory and descriptors; takes twice as long, in turn with flying into nothing")
        ->check(ig::app::within(0.1, 1e6));
    app.add_flag("--soak", options.soakOnly, "the soak alone");
    app.add_flag("--alone", options.alone, "the soak without its flights into nothing: half the time");
    app.add_option("--times-faster", options.timesFaster,
                   "the soak at so many times 60 Hz and 150 m/s: the same pictures in less time, if the "
                   "machine draws them as fast (see \"missed\"; choose a small picture)")
        ->check(ig::app::within(1.0, 16.0));
    app.add_option("--width", options.widthPx)->check(ig::app::within(1, 16384));
    app.add_option("--height", options.heightPx)->check(ig::app::within(1, 16384));
    app.set_version_flag("--version", "eyepoint-frames-bench " EYEPOINT_VERSION);
    if (const auto ended = ig::app::parseCommandLine(app, argc, argv)) {
        return *ended;
    }

    Json report;
    report["size"] = {options.widthPx, options.heightPx};
    if (!options.soakOnly) {
        for (const char* reader : {"none", "reading", "stopped"}) {
            for (const bool straight : {false, true}) {
                report["publish"].push_back(publishing(options, reader, straight));
            }
        }
        report["torn"] = tornReads(options);
    }

    // Comes and goes for the whole time: opens, takes ten frames, closes.
    const std::string name = freshName("flight");
    auto& taken = sharedWithChildren<std::atomic<uint64_t>>();
    const Child visitor([&] {
        while (true) {
            eyepoint_frames frames{};
            openPatiently(frames, name);
            std::vector<std::byte> rgba(eyepoint_colour_bytes(&frames));
            uint64_t index = eyepoint_frames_newest(&frames);
            for (int i = 0; i < 10 && eyepoint_frames_wait(&frames, index, 1000) == EYEPOINT_OK; ++i) {
                if (eyepoint_frames_copy(&frames, index, nullptr, rgba.data(), nullptr) == EYEPOINT_OK) {
                    ++taken;
                }
                index = eyepoint_frames_following(&frames, index);
            }
            eyepoint_frames_close(&frames);
        }
    });

    const test::TempDir dir;
    const std::string terrain = options.terrain.empty() ? rollingLand(dir) : options.terrain;
    config::Settings bare = settingsOf(options, terrain);
    bare.output.sinks = {"null"};
    config::Settings full = settingsOf(options, terrain);
    full.output.sinks = {"shm:" + name};
    full.output.receipts = dir.file("receipts.jsonl");
    PrintedErrors printed;
    const auto log = app::makeLog("info");
    {
        Flight without(bare, printed, false);
        Flight with(full, *log, true);
        if (!options.soakOnly) {
            for (int i = 0; i < options.frames; ++i) { // in turn, so that both see the same machine
                without.frame();
                with.frame();
            }
            report["frame"] = {
                {"null_ms", milliseconds(without.whole)},
                {"ring_receipts_metrics_log_ms", milliseconds(with.whole)},
                {"read_back_null_ms", milliseconds(without.readBack)},
                {"read_back_ms", milliseconds(with.readBack)},
                {"handing_out_ms", milliseconds(with.sinks)},
                {"p50_difference_ms", (with.whole.quantileNs(0.5) - without.whole.quantileNs(0.5)) * 1e-6},
                {"p99_ratio", with.whole.quantileNs(0.99) / without.whole.quantileNs(0.99)}};
        }

        report["soak"] = soak(options, with, without, taken);
    }
    std::puts(report.dump(2).c_str());
    return options.soakOnly || report["torn"]["torn_frames_accepted"] == 0 ? 0 : 1;
}
