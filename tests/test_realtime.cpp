// SPDX-License-Identifier: MIT
// Real-time scheduling of an image generator: who has it, and what happens where the system refuses it.
#include "ig/app/realtime.h"
#include "process.h"
#include "small_hills.h"

#include <linux/capability.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <thread>

using namespace test;

namespace {

constexpr int kPriority = 5;

struct Lines : ig::LogSink {
    void write(ig::LogLevel, std::string_view line) override { text += std::string(line) + "\n"; }
    std::string text;
};

struct Thread {
    std::string name;
    int policy = 0;
};

std::vector<Thread> threadsOf(const std::string& process, pid_t but)
{
    std::vector<Thread> found;
    for (const auto& task : std::filesystem::directory_iterator("/proc/" + process + "/task")) {
        const pid_t id = std::stoi(task.path().filename());
        if (id != but) {
            found.push_back({readFile(task.path() / "comm"), sched_getscheduler(id)});
        }
    }
    return found;
}

bool isRealtime(const Thread& thread)
{
    return (thread.policy & ~SCHED_RESET_ON_FORK) == SCHED_RR;
}

// Of this thread alone, as capabilities are.
void giveUpRealtime()
{
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3]{};
    REQUIRE(syscall(SYS_capget, &header, data) == 0);
    data[CAP_TO_INDEX(CAP_SYS_NICE)].effective &= ~CAP_TO_MASK(CAP_SYS_NICE);
    REQUIRE(syscall(SYS_capset, &header, data) == 0);
}

void inThread(const std::function<void()>& work)
{
    std::thread(work).join(); // its priority ends with it
}

} // namespace

TEST_CASE_METHOD(SmallHills, "the frame thread has the priority, what is started beside it has not")
{
    if (!hasDriver()) { // whose threads are there from here on
        return;
    }
    settings.terrain.waitForPages = false; // with threads that load
    for (const int priority : {kPriority, 0}) {
        settings.graphics.realtimePriority = priority;
        inThread([&] {
            const size_t before = threadsOf("self", gettid()).size();
            Lines lines;
            const auto generator = generatorOf(settings, lines);
            if (lines.text.find("event=realtime_refused") != std::string::npos) {
                WARN("skipped: this process may have no real-time priority");
                return;
            }
            CHECK((lines.text.find("event=realtime priority=5") != std::string::npos) == (priority > 0));
            sched_param mine{};
            REQUIRE(sched_getparam(0, &mine) == 0);
            CHECK(mine.sched_priority == priority);
            CHECK(sched_getscheduler(0) == (priority > 0 ? SCHED_RR | SCHED_RESET_ON_FORK : SCHED_OTHER));
            const std::vector<Thread> beside = threadsOf("self", gettid());
            CHECK(beside.size() > before);
            CHECK(std::none_of(beside.begin(), beside.end(), isRealtime));
            pictureOf(*generator);
        });
    }
}

TEST_CASE_METHOD(SmallHills, "threads that a software driver draws with have the priority", "[program]")
{
    if (!hasDriver()) {
        return;
    }
    const std::string err = dir.file("err");
    const Process process({"eyepoint-ig", "--terrain", settings.terrain.file, "--set", "host.listen=\"\"",
                           "--set", "graphics.realtime_priority=5"},
                          dir.file("out"), err);
    REQUIRE(waitForText(err, "no host; terrain", 60));
    if (readFile(err).find("event=realtime_refused") != std::string::npos) {
        WARN("skipped: this process may have no real-time priority");
        return;
    }
    for (const Thread& thread : threadsOf(std::to_string(process.pid()), process.pid())) {
        INFO(thread.name);
        CHECK((thread.name.find("llvmpipe") == std::string::npos || isRealtime(thread)));
    }
}

TEST_CASE_METHOD(SmallHills,
                 "where the system refuses a priority frames are drawn as usual, and the log says why")
{
    if (!hasDriver()) {
        return;
    }
    rlimit limit{};
    REQUIRE(getrlimit(RLIMIT_RTPRIO, &limit) == 0);
    if (limit.rlim_cur >= kPriority) {
        WARN("skipped: everybody may have a real-time priority here");
        return;
    }
    settings.graphics.realtimePriority = kPriority;
    inThread([&] {
        giveUpRealtime();
        const auto taken = ig::app::takePriority(kPriority, ig::app::Heirs::none);
        REQUIRE_FALSE(taken);
        CHECK(taken.error().message == "real-time priority 5: Operation not permitted");
        Lines lines;
        const auto generator = generatorOf(settings, lines);
        CHECK_THAT(lines.text, Catch::Contains("event=realtime_refused reason=\"real-time priority 5"));
        CHECK_THAT(lines.text, Catch::Contains("remedy=\"drawn as usual; give it CAP_SYS_NICE"));
        CHECK(sched_getscheduler(0) == SCHED_OTHER);
        pictureOf(*generator);
    });
}
