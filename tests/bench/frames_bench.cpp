// SPDX-License-Identifier: MIT
// What it costs to hand frames out: a frame of 1280 x 720 into the ring and out of it again, torn reads under
// pressure, and whole frames with ring, receipts, metrics and log against whole frames into nothing. Prints
// JSON.
#include "ig/app/image_generator.h"
#include "ig/app/log.h"
#include "ig/app/metrics_server.h"
#include "ig/app/steady_clock.h"
#include "ig/base/histogram.h"
#include "temp_dir.h"
#include "tools/terrain/compile.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <new>
#include <random>
#include <thread>

namespace {

using namespace ig;
using Json = nlohmann::ordered_json;

struct Options {
    std::string terrain;
    int frames = 600;           // of the costs, each
    uint64_t reads = 1'000'000; // torn reads
    double seconds = 60;        // of the soak
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

// A child process that does the work; killed with this object.
class Child {
public:
    template <class Work>
    explicit Child(Work work) : _pid(fork())
    {
        if (_pid == 0) {
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
    out::SinkFormat format{widthPx, heightPx, 60};
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

// Read back -> published, and -> copied by a reader in another process. The picture is touched anew for each
// frame, as a read-back does. reader: none, reading, or stopped.
Json publishing(const Options& options, const char* reader)
{
    struct Shared {
        Histogram copied;
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
                eyepoint_receipt receipt{};
                if (eyepoint_frames_copy(&frames, index, &receipt, rgba.data(), nullptr) == EYEPOINT_OK) {
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
    std::vector<std::byte> picture(static_cast<size_t>(options.widthPx * options.heightPx) * 4);
    Histogram published;
    for (int i = 0; i < options.frames; ++i) {
        std::memset(picture.data(), i & 255, picture.size());
        out::Receipt receipt{};
        receipt.render_end_ns = app::steadyNs();
        if (!sink->write(
                {options.widthPx, options.heightPx, picture, static_cast<uint64_t>(i), {}, &receipt})) {
            giveUp("the ring does not take a frame");
        }
        published.add(app::steadyNs() - receipt.render_end_ns);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    (void)sink->close();
    Json json{{"reader", reader}, {"read_back_to_published_ms", milliseconds(published)}};
    if (shared.frames > 0) {
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
            for (size_t i = 0; i < picture.size(); i += 4) {
                std::memcpy(&picture[i], &value, 4);
            }
            if (!sink->write({kWidthPx, kHeightPx, picture, frame})) {
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
    Histogram whole, sinks; // whole: the frame and what the program does after it; sinks: handing out alone
    uint16_t metricsPort = 0;

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
    terrain::GridPlace place;
    place.northDeg = 57.25;
    place.westDeg = -5.5;
    place.latitudeStepDeg = 0.00045;
    place.longitudeStepDeg = 0.0008;
    place.heightScaleM = 0.1;
    place.source = "rolling land";
    const std::string path = dir.file("land.ept");
    const auto compiled = terrain::compileHeights(
        1025, 1025, place,
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

void scrape(uint16_t port)
{
    const auto address = "http://127.0.0.1:" + std::to_string(port) + "/metrics";
    const int code = std::system(("curl -s -o /dev/null --max-time 2 " + address).c_str());
    (void)code; // without curl the soak goes without scrapes
}

} // namespace

int main(int argc, char** argv)
{
    Options options;
    CLI::App app{"Benchmarks the handing out of frames."};
    app.add_option("--terrain", options.terrain, "dataset, .ept; by default a synthetic one");
    app.add_option("--frames", options.frames, "frames of each cost")->check(CLI::Range(1, 1'000'000));
    app.add_option("--reads", options.reads, "reads of the search for torn ones");
    app.add_option("--seconds", options.seconds, "length of the soak, which watches memory and descriptors");
    app.add_option("--width", options.widthPx)->check(CLI::Range(1, 16384));
    app.add_option("--height", options.heightPx)->check(CLI::Range(1, 16384));
    CLI11_PARSE(app, argc, argv);

    Json report;
    report["size"] = {options.widthPx, options.heightPx};
    for (const char* reader : {"none", "reading", "stopped"}) {
        report["publish"].push_back(publishing(options, reader));
    }
    report["torn"] = tornReads(options);

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
        for (int i = 0; i < options.frames; ++i) { // in turn, so that both see the same machine
            without.frame();
            with.frame();
        }
        report["frame"] = {
            {"null_ms", milliseconds(without.whole)},
            {"ring_receipts_metrics_log_ms", milliseconds(with.whole)},
            {"handing_out_ms", milliseconds(with.sinks)},
            {"p50_difference_ms", (with.whole.quantileNs(0.5) - without.whole.quantileNs(0.5)) * 1e-6},
            {"p99_ratio", with.whole.quantileNs(0.99) / without.whole.quantileNs(0.99)}};

        const int64_t start = app::steadyNs();
        const auto gone = [&] { return static_cast<double>(app::steadyNs() - start) * 1e-9; };
        uint64_t memoryAtFirst = 0;
        long openAtFirst = 0;
        uint64_t frames = 0;
        uint64_t scrapes = 0;
        while (gone() < options.seconds) {
            with.frame();
            ++frames;
            if (frames % 100 == 0) {
                scrape(with.metricsPort);
                ++scrapes;
            }
            if (memoryAtFirst == 0 && gone() > 0.2 * options.seconds) {
                memoryAtFirst = residentBytes();
                openAtFirst = descriptors();
            }
        }
        report["soak"] = {{"seconds", options.seconds},
                          {"frames", frames},
                          {"frames_taken_by_visitor", taken.load()},
                          {"metrics_scrapes", scrapes},
                          {"resident_bytes_after_a_fifth", memoryAtFirst},
                          {"resident_bytes_at_end", residentBytes()},
                          {"descriptors_after_a_fifth", openAtFirst},
                          {"descriptors_at_end", descriptors()}};
    }
    std::puts(report.dump(2).c_str());
    const bool good = report["torn"]["torn_frames_accepted"] == 0;
    return good ? 0 : 1;
}
