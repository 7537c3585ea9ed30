// SPDX-License-Identifier: MIT
// Threads that read pages, decode them and make them into meshes, most urgent first, into a fixed number of
// buffers. Who draws says in each frame what it lacks, and takes what is finished: it never waits for the
// disk, unless it asks to.
//
// A page is decoded on top of its parent. The parent's heights are the caller's, who lends them with the
// request: they have to stay until the page has been taken or is no longer held (see request).
#pragma once

#include "ig/base/result.h"
#include "ig/data/dataset.h"
#include "ig/data/page_mesh.h"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

namespace ig::data {

struct PageLoaderSettings {
    ShadingSettings shading;
    bool texels = true;    // fill PageMesh::texel
    bool morph = true;     // fill PageMesh::morph
    uint32_t threads = 2;  // at least 1
    uint32_t buffers = 16; // pages being read, or finished and not taken yet; at least 1
};

// What a loader makes of a page's heights: mesh.texel and mesh.morph are empty where the settings leave them
// out.
void buildPage(const DatasetInfo& dataset, const lod::PageNode& page, const PageHeights& heights,
               const PageLoaderSettings& settings, PageMesh& mesh);

struct PageRequest {
    uint32_t page = 0;
    const PageHeights* parent = nullptr; // of the page above; nullptr for the root, and only there
};

// A finished page. Swap its vectors with others of the same kind rather than copying them.
struct LoadedPage {
    uint32_t page = 0;
    std::optional<Error> error; // why there is nothing
    PageHeights heights;
    PageMesh mesh;
};

class PageLoader {
public:
    using Clock = std::chrono::steady_clock;
    static constexpr size_t kMaxRequests = 128;

    // source, with the pages of this dataset, must outlive the loader. The threads start with the first
    // request, and run below the priority of the caller: they wait for a core that nobody needs, or for a
    // small share of one.
    PageLoader(const PageSource& source, const DatasetInfo& dataset, std::span<const lod::PageNode> pages,
               const PageLoaderSettings& settings);
    ~PageLoader(); // as stop()
    PageLoader(const PageLoader&) = delete;
    PageLoader& operator=(const PageLoader&) = delete;

    // What is wanted now, most urgent first, each page once, at most kMaxRequests: what was asked for before
    // and is not among it is dropped. Returns the pages that are being read all the same, whose parents are
    // still needed; valid until the next call. Nothing after stop(). Allocates nothing.
    std::span<const uint32_t> request(std::span<const PageRequest> requests);

    // The most urgent page that is finished of the first so many requested, nullptr when there is none. It is
    // the caller's until giveBack().
    LoadedPage* take(size_t amongFirst = kMaxRequests);
    // The most urgent requested page, waited for; nullptr when all have been taken, or at the deadline.
    LoadedPage* waitAndTake(Clock::time_point deadline = Clock::time_point::max());
    void giveBack(LoadedPage* page);
    // Waits until the threads have nothing left to do: then the most urgent requests are finished, as many as
    // there are buffers, and which ones does not depend on how long anything took.
    void waitUntilIdle();

    // Ends the threads, after the pages that are being read; what is finished is dropped.
    void stop();
    bool isRunning() const noexcept { return !_threads.empty(); }

private:
    enum class State : uint8_t { free, reading, finished, taken };
    struct Job {
        State state = State::free;
        PageRequest request;
        LoadedPage loaded;
    };
    struct Wish {
        PageRequest request;
        Job* job = nullptr; // that makes it
        bool taken = false;
    };

    void run();
    Job* startNext();
    bool isIdle() const;
    Job* jobFor(uint32_t page);
    void load(Job& job) const;

    const PageSource& _source;
    const DatasetInfo& _dataset;
    std::span<const lod::PageNode> _pages;
    PageLoaderSettings _settings;

    std::mutex _mutex;                 // of all below but _threads
    std::condition_variable _work;     // for the threads
    std::condition_variable _finished; // for waitAndTake() and waitUntilIdle()
    std::vector<Job> _jobs;
    std::vector<Wish> _wishes; // most urgent first
    std::vector<uint32_t> _orphans;
    bool _stop = false;
    std::vector<std::thread> _threads; // the caller's
};

} // namespace ig::data
