// SPDX-License-Identifier: MIT
// On which cores the driver's threads may run while the frame thread draws, and while it waits.
#include "ig/gl/driver_threads.h"
#include "stage.h"

#include <catch2/catch.hpp>
#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <latch>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace {

using ig::gl::DriverThreads;

cpu_set_t coresOf(pid_t thread)
{
    cpu_set_t cores{};
    REQUIRE(sched_getaffinity(thread, sizeof(cores), &cores) == 0);
    return cores;
}

bool same(const cpu_set_t& a, const cpu_set_t& b)
{
    return CPU_EQUAL(&a, &b) != 0;
}

// The first cores of those that this thread may run on; nothing where it may not run on so many.
std::optional<cpu_set_t> firstCores(int count)
{
    const cpu_set_t mine = coresOf(0);
    if (CPU_COUNT(&mine) < count)
        return {};
    cpu_set_t first{};
    for (int core = 0; CPU_COUNT(&first) < count; ++core)
        if (CPU_ISSET(core, &mine))
            CPU_SET(core, &first);
    return first;
}

// A thread that does nothing until it is destroyed.
class Idler {
public:
    Idler()
        : _thread([this] {
              _id = gettid();
              _started.count_down();
              _end.wait();
          })
    {
        _started.wait();
    }
    ~Idler()
    {
        _end.count_down();
        _thread.join();
    }
    pid_t id() const { return _id; }

private:
    std::latch _started{1};
    std::latch _end{1};
    pid_t _id = 0;
    std::thread _thread;
};

// In a thread of its own that may run on these cores alone.
template <class Work>
void onCores(const cpu_set_t& cores, Work&& work)
{
    std::thread([&] {
        REQUIRE(sched_setaffinity(0, sizeof(cores), &cores) == 0);
        work();
    }).join();
}

std::vector<pid_t> llvmpipesThreads()
{
    std::vector<pid_t> found;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::string name;
        std::ifstream(task.path() / "comm") >> name;
        if (name.starts_with("llvmpipe-"))
            found.push_back(std::stoi(task.path().filename()));
    }
    return found;
}

} // namespace

TEST_CASE("two threads are kept off the caller's core of two, and let back")
{
    const std::optional<cpu_set_t> two = firstCores(2);
    if (!two) {
        WARN("skipped: this process may run on one core alone");
        return;
    }
    onCores(*two, [&] {
        const Idler a, b;
        DriverThreads threads({a.id(), b.id()});
        int before = 0, after = 1;
        cpu_set_t off{};
        for (int tries = 0; before != after && tries < 1000; ++tries) { // until nothing moved this thread
            threads.letBack();
            before = sched_getcpu();
            threads.keepOff();
            after = sched_getcpu();
        }
        REQUIRE(before == after);
        off = coresOf(a.id());
        CHECK(CPU_COUNT(&off) == 1);
        CHECK(!CPU_ISSET(before, &off));
        CHECK(same(coresOf(b.id()), off));
        CHECK(same(coresOf(0), *two));
        threads.keepOff(); // once more is nothing new
        CHECK(same(coresOf(a.id()), off));
        threads.letBack();
        CHECK(same(coresOf(a.id()), *two));
        CHECK(same(coresOf(b.id()), *two));
        {
            DriverThreads others({a.id(), b.id()});
            others.keepOff();
        }
        CHECK(same(coresOf(a.id()), *two));
        CHECK(same(coresOf(b.id()), *two));
    });
}

TEST_CASE("neither one core, nor other than two threads, nor threads that have ended are moved")
{
    const std::optional<cpu_set_t> two = firstCores(2);
    if (!two) {
        WARN("skipped: this process may run on one core alone");
        return;
    }
    const Idler a, b, c;
    const cpu_set_t all = coresOf(a.id());
    const auto unmoved = [&](std::vector<pid_t> ids) {
        DriverThreads threads(std::move(ids));
        threads.keepOff();
        const bool kept = same(coresOf(a.id()), all);
        threads.letBack();
        return kept && same(coresOf(a.id()), all);
    };
    onCores(*firstCores(1), [&] { CHECK(unmoved({a.id(), b.id()})); });
    onCores(*two, [&] {
        CHECK(unmoved({a.id()}));
        CHECK(unmoved({a.id(), b.id(), c.id()}));
        pid_t ended = 0;
        std::thread([&] { ended = gettid(); }).join();
        DriverThreads gone({ended, ended});
        gone.keepOff();
        gone.letBack();
        CHECK(same(coresOf(0), *two));
    });
    if (CPU_COUNT(&all) > 2)
        CHECK(unmoved({a.id(), b.id()})); // with the cores that this thread has
}

TEST_CASE("llvmpipe's threads keep off the frame thread's core from the first draw to the wait", "[gl]")
{
    using namespace stage;
    const Terrain flat{makeTerrain({0, 0, 0}, 0, 30.0)};
    const ig::ViewState view = viewFrom({0, 0, 3000}, {0, -1.5, 0}, 1.0, 64, 64);
    for (const bool inParts : {true, false}) {
        Stage stage({.widthPx = 64, .heightPx = 64, .pageSlots = 1}, {.flushInParts = inParts});
        const std::vector<pid_t> threads = llvmpipesThreads();
        const cpu_set_t mine = coresOf(0);
        if (threads.size() != 2 || CPU_COUNT(&mine) != 2) {
            WARN("skipped: the driver has not two threads on two cores");
            return;
        }
        stage.renderer().upload(0, makePage(flat, 0, 0, 0));
        const std::vector<int32_t> slotOfPage{0};
        std::vector<std::byte> picture(64 * 64 * 4);
        const auto kept = [&] {
            const cpu_set_t cores = coresOf(threads[0]);
            CHECK(same(cores, coresOf(threads[1])));
            return CPU_COUNT(&cores) == 1;
        };
        const auto draw = [&] { stage.renderer().draw(view, onePage(), slotOfPage); };
        CHECK_FALSE(kept());
        stage.renderer().begin(view);
        CHECK(kept() == inParts);
        draw();
        CHECK(kept() == inParts);
        stage.renderer().read(picture);
        CHECK_FALSE(kept());
        draw();
        CHECK(kept() == inParts);
        stage.renderer().finish();
        CHECK_FALSE(kept());
        draw();
        stage.renderer().depthAt(1, 1);
        CHECK_FALSE(kept());
    }
}
