// SPDX-License-Identifier: MIT
#include "ig/data/page_loader.h"

#include "ig/data/page_codec.h"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>

namespace ig::data {

namespace {

// Frames come before what the next ones may need. A thread of this class does not push another from its core
// when there is work for it; with this nice value a tenth of a core is left to it where none is ever free.
// Linux keeps both for each thread.
constexpr int kPolicy = SCHED_BATCH;
constexpr int kNice = 10;

} // namespace

void buildPage(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
               const PageLoaderSettings& settings, PageMesh& mesh)
{
    if (settings.texels) {
        buildPageMesh(dataset, page, heights, settings.shading, mesh);
    } else {
        buildPageVertices(dataset, page, heights, mesh);
    }
    if (settings.morph) {
        addMorph(dataset, page, heights, mesh);
    }
}

PageLoader::PageLoader(const PageSource& source, const DatasetInfo& dataset,
                       std::span<const lod::PageNode> pages, const PageLoaderSettings& settings)
    : _source(source), _dataset(dataset), _pages(pages), _settings(settings),
      _jobs(std::max(settings.buffers, 1U))
{
    // Room for any page now, so that loading never allocates.
    for (Job& job : _jobs) {
        job.loaded.heights.reserve();
        job.loaded.mesh.vertex.reserve(kPagePostCount);
        job.loaded.mesh.texel.reserve(kPageCellCount);
        job.loaded.mesh.morph.reserve(settings.morph ? kPagePostCount : 0);
    }
    _wishes.reserve(kMaxRequests);
    _orphans.reserve(_jobs.size());
}

PageLoader::~PageLoader()
{
    stop();
}

void PageLoader::stop()
{
    {
        const std::scoped_lock lock(_mutex);
        _stop = true;
        _wishes.clear();
    }
    _work.notify_all();
    for (std::thread& thread : _threads) {
        thread.join();
    }
    _threads.clear();
}

std::span<const uint32_t> PageLoader::request(std::span<const PageRequest> requests)
{
    assert(requests.size() <= kMaxRequests);
    if (_threads.empty() && !requests.empty() && !_stop) {
        for (uint32_t i = 0; i < std::max(_settings.threads, 1U); ++i) {
            _threads.emplace_back([this] { run(); });
        }
    }
    bool isWork = false;
    {
        const std::scoped_lock lock(_mutex);
        _wishes.clear();
        _orphans.clear();
        if (_stop) {
            return {};
        }
        for (const PageRequest& request : requests) {
            _wishes.push_back({request, jobFor(request.page), false});
            isWork = isWork || _wishes.back().job == nullptr;
        }
        for (Job& job : _jobs) {
            const bool isWished = std::any_of(_wishes.begin(), _wishes.end(),
                                              [&job](const Wish& wish) { return wish.job == &job; });
            if (isWished) {
                continue;
            }
            if (job.state == State::reading) {
                _orphans.push_back(job.request.page);
            } else if (job.state == State::finished) {
                job.state = State::free;
            }
        }
    }
    if (isWork) {
        _work.notify_all();
    }
    return _orphans;
}

// The job that reads a page or has read it.
PageLoader::Job* PageLoader::jobFor(uint32_t page)
{
    const auto found = std::find_if(_jobs.begin(), _jobs.end(), [page](const Job& job) {
        return job.request.page == page && (job.state == State::reading || job.state == State::finished);
    });
    return found != _jobs.end() ? &*found : nullptr;
}

LoadedPage* PageLoader::take(size_t amongFirst)
{
    const std::scoped_lock lock(_mutex);
    for (Wish& wish : std::span(_wishes).first(std::min(amongFirst, _wishes.size()))) {
        if (!wish.taken && wish.job != nullptr && wish.job->state == State::finished) {
            wish.taken = true;
            wish.job->state = State::taken;
            return &wish.job->loaded;
        }
    }
    return nullptr;
}

LoadedPage* PageLoader::waitAndTake(Clock::time_point deadline)
{
    std::unique_lock lock(_mutex);
    const auto next = std::find_if(_wishes.begin(), _wishes.end(), [](const Wish& w) { return !w.taken; });
    if (next == _wishes.end()) {
        return nullptr;
    }
    // It is begun before all others: the caller holds no buffer for long, and less urgent ones make room.
    const auto isThere = [&next] { return next->job != nullptr && next->job->state == State::finished; };
    if (deadline == Clock::time_point::max()) {
        _finished.wait(lock, isThere);
    } else if (!_finished.wait_until(lock, deadline, isThere)) {
        return nullptr;
    }
    next->taken = true;
    next->job->state = State::taken;
    return &next->job->loaded;
}

void PageLoader::giveBack(LoadedPage* page)
{
    {
        const std::scoped_lock lock(_mutex);
        for (Job& job : _jobs) {
            if (&job.loaded == page) {
                assert(job.state == State::taken);
                job.state = State::free;
            }
        }
    }
    _work.notify_one();
}

void PageLoader::waitUntilIdle()
{
    std::unique_lock lock(_mutex);
    _finished.wait(lock, [this] { return _threads.empty() || isIdle(); });
}

// Nothing is read, and startNext() would find nothing to read: what has no buffer is less urgent than all
// that has one.
bool PageLoader::isIdle() const
{
    const auto isReading = [](const Job& job) { return job.state == State::reading; };
    const auto isFree = [](const Job& job) { return job.state == State::free; };
    if (std::any_of(_jobs.begin(), _jobs.end(), isReading)) {
        return false;
    }
    const auto next = std::find_if(_wishes.begin(), _wishes.end(),
                                   [](const Wish& w) { return w.job == nullptr && !w.taken; });
    return next == _wishes.end() ||
           (std::none_of(_jobs.begin(), _jobs.end(), isFree) &&
            std::none_of(next, _wishes.end(), [](const Wish& w) {
                return w.job != nullptr && !w.taken && w.job->state == State::finished;
            }));
}

// The most urgent page that nobody reads, if there is a buffer for it.
PageLoader::Job* PageLoader::startNext()
{
    const auto wish = std::find_if(_wishes.begin(), _wishes.end(),
                                   [](const Wish& w) { return w.job == nullptr && !w.taken; });
    if (wish == _wishes.end()) {
        return nullptr;
    }
    const auto free =
        std::find_if(_jobs.begin(), _jobs.end(), [](const Job& j) { return j.state == State::free; });
    Job* job = free != _jobs.end() ? &*free : nullptr;
    // What is finished and less urgent has to make room.
    for (auto last = _wishes.end(); job == nullptr && --last != wish;) {
        if (last->job != nullptr && !last->taken && last->job->state == State::finished) {
            std::swap(job, last->job);
        }
    }
    if (job != nullptr) {
        wish->job = job;
        job->state = State::reading;
        job->request = wish->request;
    }
    return job;
}

void PageLoader::run()
{
    const sched_param unused{};
    (void)pthread_setschedparam(pthread_self(), kPolicy, &unused);
    (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
    std::unique_lock lock(_mutex);
    for (;;) {
        Job* job = nullptr;
        _work.wait(lock, [&] { return _stop || (job = startNext()) != nullptr; });
        if (job == nullptr) {
            return;
        }
        lock.unlock();
        load(*job);
        lock.lock();
        const bool isWished =
            std::any_of(_wishes.begin(), _wishes.end(), [job](const Wish& wish) { return wish.job == job; });
        job->state = isWished ? State::finished : State::free;
        _finished.notify_one();
    }
}

void PageLoader::load(Job& job) const
{
    const PageRequest& request = job.request;
    LoadedPage& out = job.loaded;
    out.page = request.page;
    out.error.reset();
    if (const auto read = _source.readPage(request.page, request.parent, out.heights); !read) {
        out.error = read.error();
        return;
    }
    buildPage(_dataset, _pages[request.page], out.heights, _settings, out.mesh);
}

} // namespace ig::data
