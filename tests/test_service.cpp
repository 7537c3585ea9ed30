// SPDX-License-Identifier: MIT
// How the image generator behaves as a service: notifications, log lines, metrics.
#include "ig/app/log.h"
#include "ig/app/log_limiter.h"
#include "ig/app/log_writer.h"
#include "ig/app/metrics_server.h"
#include "ig/app/service_notifier.h"
#include "ig/app/statistics_file.h"
#include "ig/app/steady_clock.h"
#include "process.h"
#include "temp_dir.h"

#include <arpa/inet.h>
#include <catch2/catch.hpp>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <atomic>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>

using namespace ig;
using Catch::Contains;

namespace {

// The service manager's end.
struct Manager {
    explicit Manager(const std::string& name)
    {
        socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::memcpy(address.sun_path, name.data(), name.size());
        if (name[0] == '@') {
            address.sun_path[0] = '\0';
        }
        REQUIRE(bind(socket, reinterpret_cast<const sockaddr*>(&address),
                     static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size())) == 0);
        setenv("NOTIFY_SOCKET", name.c_str(), 1);
    }
    ~Manager()
    {
        close(socket);
        for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) {
            unsetenv(name);
        }
    }
    Manager(const Manager&) = delete;
    Manager& operator=(const Manager&) = delete;

    std::string next() const
    {
        std::array<char, 1024> bytes{};
        const ssize_t got = recv(socket, bytes.data(), bytes.size(), MSG_DONTWAIT);
        return got > 0 ? std::string(bytes.data(), static_cast<size_t>(got)) : "";
    }
    int socket;
};

int connectTo(uint16_t port)
{
    const int client = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    return client;
}

// Everything that comes until the other end closes.
std::string readToEnd(int client)
{
    std::string all;
    std::array<char, 4096> part{};
    pollfd waited{client, POLLIN, 0};
    while (poll(&waited, 1, 10'000) > 0) {
        const ssize_t got = recv(client, part.data(), part.size(), 0);
        if (got <= 0) {
            break;
        }
        all.append(part.data(), static_cast<size_t>(got));
    }
    close(client);
    return all;
}

std::string ask(uint16_t port, const std::string& request)
{
    const int client = connectTo(port);
    REQUIRE(send(client, request.data(), request.size(), MSG_NOSIGNAL) ==
            static_cast<ssize_t>(request.size()));
    return readToEnd(client);
}

// Whoever passes waits until it is open.
class Gate {
public:
    void open()
    {
        const std::lock_guard lock(_mutex);
        _open = true;
        _changed.notify_all();
    }
    void pass()
    {
        std::unique_lock lock(_mutex);
        _changed.wait(lock, [this] { return _open; });
    }

private:
    std::mutex _mutex;
    std::condition_variable _changed;
    bool _open = false;
};

long threadsOfProcess()
{
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

class CollectedLog final : public LogSink {
public:
    void write(LogLevel, std::string_view line) override { lines.emplace_back(line); }
    std::vector<std::string> lines;
};

} // namespace

TEST_CASE("a service manager hears of readiness, life and the end, on a path or an abstract name")
{
    const test::TempDir dir;
    for (const std::string& name : {dir.file("notify"), "@eyepoint-test-" + std::to_string(getpid())}) {
        CAPTURE(name);
        const Manager manager(name);
        setenv("WATCHDOG_USEC", "4000000", 1);
        setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
        app::ServiceNotifier notifier;
        REQUIRE(notifier.wanted());
        CHECK(manager.next().empty()); // nothing before the first frame
        notifier.ready("1 frame");
        CHECK(manager.next() == "READY=1");
        CHECK(manager.next() == "STATUS=1 frame");
        const int64_t start = 1'000'000'000'000;
        int lives = 0;
        for (int frame = 0; frame < 600; ++frame) { // ten seconds at 60 Hz
            if (notifier.tick(start + frame * 16'666'667LL)) {
                notifier.status("flying");
            }
            for (std::string said = manager.next(); !said.empty(); said = manager.next()) {
                lives += said == "WATCHDOG=1" ? 1 : 0;
                CHECK((said == "WATCHDOG=1" || said == "STATUS=flying"));
            }
        }
        CHECK(lives == 5); // every two seconds, half of the watchdog's four
        notifier.reloading(5'000'000);
        CHECK(manager.next() == "RELOADING=1\nMONOTONIC_USEC=5000");
        notifier.reloaded();
        CHECK(manager.next() == "READY=1");
        notifier.stopping();
        CHECK(manager.next() == "STOPPING=1");
    }
}

TEST_CASE("without a manager, with a bad address or a watchdog of another process nothing is sent")
{
    CHECK_FALSE(app::ServiceNotifier().wanted());
    for (const std::string& bad : {std::string("relative/path"), std::string(), std::string(200, '/')}) {
        setenv("NOTIFY_SOCKET", bad.c_str(), 1);
        CHECK_FALSE(app::ServiceNotifier().wanted());
    }
    const Manager manager("@eyepoint-test-other-" + std::to_string(getpid()));
    for (const auto& [usec, pid] : {std::pair{"1000", "1"}, std::pair{"soon", ""}, std::pair{"-5", ""}}) {
        setenv("WATCHDOG_USEC", usec, 1);
        if (*pid != '\0') {
            setenv("WATCHDOG_PID", pid, 1);
        } else {
            unsetenv("WATCHDOG_PID");
        }
        app::ServiceNotifier notifier;
        notifier.tick(1'000'000'000'000);
        CHECK(manager.next().empty());
    }
    app::ServiceNotifier notifier;
    close(manager.socket); // a manager that is gone is no trouble
    notifier.ready("");
}

TEST_CASE("a flood of one kind of message is cut to a burst per period, and what was left out is told")
{
    app::LogLimiter limiter;
    int64_t nowNs = 50'000'000'000;
    int written = 0;
    for (int i = 0; i < 1000; ++i) {
        written += limiter.admit("flood", nowNs += 1'000'000).write ? 1 : 0;
    }
    CHECK(written == static_cast<int>(app::LogLimiter::kBurst));
    CHECK(limiter.admit("other kind", nowNs).write);
    CHECK(limiter.suppressed() == 995);
    const auto next = limiter.admit("flood", nowNs + app::LogLimiter::kPeriodNs);
    CHECK(next.write);
    CHECK(next.suppressed == 995);
    CHECK(limiter.admit("flood", nowNs + app::LogLimiter::kPeriodNs).suppressed == 0);
    for (int i = 0; i < 10; ++i) {
        limiter.admit("flood", nowNs + app::LogLimiter::kPeriodNs);
    }
    int told = 0;
    limiter.drain([&](const std::string& kind, uint64_t count) {
        CHECK(kind == "flood");
        CHECK(count == 7);
        ++told;
    });
    limiter.drain([&](const std::string&, uint64_t) { ++told; });
    CHECK(told == 1);
}

TEST_CASE("endless new kinds of messages share one place")
{
    app::LogLimiter limiter;
    uint64_t written = 0;
    for (int i = 0; i < 5000; ++i) {
        written += limiter.admit("kind " + std::to_string(i), 1).write ? 1U : 0U;
    }
    CHECK(written == app::LogLimiter::kKinds - 1 + app::LogLimiter::kBurst);
    CHECK(app::logKind("event=sink_ended sink=a") == "sink_ended");
    CHECK(app::logKind("page 17 is damaged") == app::logKind("page 4711 is damaged"));
    CHECK(app::logKind("page 17 is damaged") != app::logKind("page 17 is missing"));
}

TEST_CASE("a log line is keys and values on one line, whatever the values hold")
{
    CHECK(app::logLine("sink_ended", {{"sink", "png:x"}, {"reason", "No space left"}}) ==
          "event=sink_ended sink=png:x reason=\"No space left\"");
    CHECK(app::logLine("e", {{"a", ""}, {"b", "x=\"1\"\n\\"}}) == "event=e a=\"\" b=\"x=\\\"1\\\" \\\\\"");
}

TEST_CASE("log lines beyond the queue are dropped and counted, the others come out in order")
{
    constexpr int kLines = 2'000; // each of two threads
    Gate gate;
    std::vector<std::string> stored;
    uint64_t dropped = 0;
    {
        app::LogWriter writer([&](const app::LogEntry& entry) {
            gate.pass();
            stored.push_back(entry.text);
        });
        const auto talk = [&](char who) {
            for (int i = 0; i < kLines; ++i) {
                writer.offer({{}, LogLevel::info, who + std::to_string(i)});
            }
        };
        std::thread other([&] { talk('a'); });
        talk('b');
        other.join(); // both came back although nothing has been stored
        dropped = writer.dropped();
        // One line may be in the thread's hands already.
        CHECK(dropped >= 2 * kLines - app::LogWriter::kQueuedLines - 1);
        gate.open();
        writer.flush();
        writer.offer({{}, LogLevel::info, "a9999"});
    }
    std::map<char, int> last{{'a', -1}, {'b', -1}};
    uint64_t lines = 0;
    uint64_t told = 0;
    for (const std::string& line : stored) {
        if (line.starts_with("event=log_dropped count=")) {
            told += std::stoull(line.substr(std::strlen("event=log_dropped count=")));
            continue;
        }
        const int number = std::stoi(line.substr(1));
        CHECK(number > last[line[0]]);
        last[line[0]] = number;
        ++lines;
    }
    CHECK(last['a'] == 9999); // at the end all that was taken is stored
    CHECK(lines + dropped == 2 * kLines + 1);
    CHECK(told == dropped);
}

TEST_CASE("a log that hangs for good does not hold up the end")
{
    const auto gate = std::make_shared<Gate>(); // kept by the thread that is left behind
    const auto done = std::make_shared<std::atomic<bool>>(false);
    const auto before = threadsOfProcess();
    {
        app::LogWriter writer([gate, done](const app::LogEntry&) {
            gate->pass();
            *done = true;
        });
        writer.offer({{}, LogLevel::info, "x"});
    }
    CHECK_FALSE(*done);
    gate->open();
    while (!*done || threadsOfProcess() > before) { // nobody joins it, and others count threads
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

TEST_CASE("the log has a thread only once it has said something, and at its end all is written")
{
    const test::TempDir dir;
    const int kept = dup(STDERR_FILENO);
    const int file = ::open(dir.file("err").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    REQUIRE(dup2(file, STDERR_FILENO) == STDERR_FILENO);
    auto log = app::makeLog("warning");
    const auto before = threadsOfProcess();
    log->write(LogLevel::info, "event=quiet");
    const auto quiet = threadsOfProcess();
    log->write(LogLevel::error, "event=loud reason=\"no space\"");
    const auto loud = threadsOfProcess();
    for (int i = 0; i < 100; ++i) {
        log->write(LogLevel::warning, "event=flood");
    }
    log->finish();
    const std::string finished = test::readFile(dir.file("err"));
    log->write(LogLevel::warning, "event=last");
    log.reset();
    dup2(kept, STDERR_FILENO);
    close(kept);
    close(file);
    CHECK(quiet == before);
    CHECK(loud == before + 1);
    CHECK_THAT(finished, Contains("level=error event=loud reason=\"no space\"\n"));
    CHECK_THAT(finished, Contains("kind=flood count=95\n")); // the limiter's, as ever
    CHECK_THAT(test::readFile(dir.file("err")), Contains("level=warning event=last\n"));
}

TEST_CASE("metrics count every frame once, in its step")
{
    const app::MetricsLabels labels{{3, 4}, {{3, "png:a\"b"}, {4, "null"}}};
    app::Metrics metrics = app::metricsFor(labels);
    app::FrameStats frame;
    for (const int64_t ms : {0, 1, 3, 15, 16, 40, 5000}) {
        frame.frameNs = ms * 1'000'000;
        frame.handedOutNs = 12'000'000;
        frame.transportDelayNs = ms == 15 ? 20'000'000 : -1;
        frame.lod.tilesMissing = ms == 40 ? 2 : 0;
        metrics.views[0].add(frame);
    }
    metrics.sinks = {{{5, 2}, true}, {{0, 0}, false}};
    const std::string text = app::metricsText(metrics, labels);
    for (const char* line : {"eyepoint_frames_total{view=\"3\"} 7\n", "eyepoint_frames_total{view=\"4\"} 0\n",
                             "eyepoint_frame_seconds_bucket{view=\"3\",le=\"0.001\"} 2\n",
                             "eyepoint_frame_seconds_bucket{view=\"3\",le=\"0.004\"} 3\n",
                             "eyepoint_frame_seconds_bucket{view=\"3\",le=\"0.0167\"} 5\n",
                             "eyepoint_frame_seconds_bucket{view=\"3\",le=\"0.1\"} 6\n",
                             "eyepoint_frame_seconds_bucket{view=\"3\",le=\"+Inf\"} 7\n",
                             "eyepoint_frame_seconds_count{view=\"3\"} 7\n",
                             "eyepoint_transport_delay_seconds_count{view=\"3\"} 1\n",
                             "eyepoint_handed_out_seconds_bucket{view=\"3\",le=\"0.01\"} 0\n",
                             "eyepoint_handed_out_seconds_bucket{view=\"3\",le=\"0.0125\"} 7\n",
                             "eyepoint_frames_with_missing_tiles_total{view=\"3\"} 1\n",
                             "eyepoint_sink_dropped_total{view=\"3\",sink=\"png:a\\\"b\"} 2\n",
                             "eyepoint_sink_up{view=\"4\",sink=\"null\"} 0\n",
                             "eyepoint_sink_up{view=\"3\",sink=\"png:a\\\"b\"} 1\n"}) {
        CHECK_THAT(text, Contains(line));
    }
    // Every sample has its TYPE, every TYPE stands once.
    std::set<std::string> typed;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("# TYPE ")) {
            CHECK(typed.insert(line.substr(7, line.find(' ', 7) - 7)).second);
        } else if (!line.starts_with("#")) {
            std::string name = line.substr(0, line.find_first_of(" {"));
            for (const char* part : {"_bucket", "_sum", "_count"}) {
                if (name.ends_with(part) &&
                    typed.count(name.substr(0, name.size() - std::strlen(part))) == 1) {
                    name.resize(name.size() - std::strlen(part));
                }
            }
            CHECK(typed.count(name) == 1);
        }
    }
}

TEST_CASE("metrics are answered on the loopback; everything else is refused in words")
{
    auto server = app::MetricsServer::start("127.0.0.1:0", {{0}, {{0, "null"}}});
    REQUIRE(server);
    const uint16_t port = (*server)->local().port;
    app::Metrics metrics = app::metricsFor({{0}, {{0, "null"}}});
    metrics.views[0].frames = 4711;
    (*server)->offer(metrics);
    const std::string page = ask(port, "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
    CHECK(page.starts_with("HTTP/1.1 200 OK\r\n"));
    CHECK_THAT(page, Contains("text/plain; version=0.0.4") && Contains("\r\n\r\n# HELP eyepoint_"));
    CHECK_THAT(page, Contains("eyepoint_frames_total{view=\"0\"} 4711\n"));
    const size_t body = page.find("\r\n\r\n") + 4;
    CHECK_THAT(page, Contains("Content-Length: " + std::to_string(page.size() - body) + "\r\n"));
    CHECK_THAT(ask(port, "GET / HTTP/1.1\r\n\r\n"), Contains(" 404 "));
    CHECK_THAT(ask(port, "POST /metrics HTTP/1.1\r\n\r\n"), Contains(" 405 "));
    CHECK_THAT(ask(port, "\r\n\r\n"), Contains(" 405 "));
    CHECK(ask(port, std::string(4096, 'x')).empty());

    const auto taken = app::MetricsServer::start("127.0.0.1:" + std::to_string(port), {});
    REQUIRE_FALSE(taken);
    CHECK(taken.error().kind == ErrorKind::addressInUse);
    for (const char* bad : {"0.0.0.0:0", "[::]:0", "nowhere", "192.0.2.1:9464"}) {
        const auto refused = app::MetricsServer::start(bad, {});
        REQUIRE_FALSE(refused);
        CHECK(refused.error().kind == ErrorKind::usage);
        CHECK_THAT(refused.error().message, Contains("output.metrics"));
    }
}

TEST_CASE("clients that say nothing are let go, and handing over never waits for one")
{
    auto server = app::MetricsServer::start("127.0.0.1:0", {{0}, {}});
    REQUIRE(server);
    const uint16_t port = (*server)->local().port;
    const int silent = connectTo(port);
    app::Metrics metrics = app::metricsFor({{0}, {}});
    for (uint64_t i = 0; i < 1000; ++i) {
        metrics.views[0].frames = i;
        (*server)->offer(metrics);
    }
    CHECK_THAT(ask(port, "GET /metrics HTTP/1.1\r\n\r\n"),
               Contains("eyepoint_frames_total{view=\"0\"} 999\n"));
    CHECK(readToEnd(silent).empty()); // closed by the server
    const int last = connectTo(port);
    server->reset(); // ends in spite of an open connection
    close(last);
}

TEST_CASE("statistics are stored beside the frames, one at a time, and failures are said")
{
    const test::TempDir dir;
    CollectedLog log;
    app::StatisticsFile file(log);
    REQUIRE(file.write(dir.file("s.json"), "{}\n"));
    file.finish();
    CHECK(test::readFile(dir.file("s.json")) == "{}\n");
    REQUIRE(file.write(dir.file("none/s.json"), "{}\n"));
    file.finish();
    REQUIRE(log.lines.size() == 2);
    CHECK_THAT(log.lines[0], Contains("event=statistics_written"));
    CHECK_THAT(log.lines[1],
               Contains("event=statistics_failed") && Contains("none/s.json") && Contains("remedy="));
}
