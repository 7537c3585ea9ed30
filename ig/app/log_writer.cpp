// SPDX-License-Identifier: MIT
#include "ig/app/log_writer.h"

#include "ig/base/thread_signals.h"

#include <array>
#include <atomic>
#include <system_error>
#include <utility>

namespace ig::app {

namespace {

// For the end only: it looks every millisecond. False: the time is over.
template <class Condition>
bool waitAtMost(std::chrono::seconds limit, Condition condition)
{
    const auto deadline = std::chrono::steady_clock::now() + limit;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline) {
            return false;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return true;
}

} // namespace

// A bounded queue of many producers and one consumer, after D. Vyukov's bounded MPMC queue: a cell's turn
// says whose it is, `at` for the producer of position `at`, `at + 1` for its consumer.
struct LogWriter::Shared {
    struct Cell {
        std::atomic<uint64_t> turn;
        LogEntry entry;
    };

    explicit Shared(std::function<void(const LogEntry&)> storeLine) : store(std::move(storeLine))
    {
        for (size_t i = 0; i < cells.size(); ++i) {
            cells[i].turn.store(i, std::memory_order_relaxed);
        }
    }

    bool push(LogEntry&& entry) noexcept
    {
        uint64_t at = tail.load(std::memory_order_relaxed);
        while (true) {
            Cell& cell = cells[at % kQueuedLines];
            const uint64_t turn = cell.turn.load(std::memory_order_acquire);
            if (turn == at) {
                if (tail.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) {
                    cell.entry = std::move(entry);
                    cell.turn.store(at + 1, std::memory_order_release);
                    return true;
                }
            } else if (turn < at) {
                return false; // a round behind: full
            } else {
                at = tail.load(std::memory_order_relaxed);
            }
        }
    }

    bool pop(LogEntry& entry) noexcept
    {
        Cell& cell = cells[head % kQueuedLines];
        if (cell.turn.load(std::memory_order_acquire) != head + 1) {
            return false;
        }
        entry = std::move(cell.entry);
        cell.turn.store(head + kQueuedLines, std::memory_order_release);
        ++head;
        return true;
    }

    void wake() noexcept
    {
        signal.fetch_add(1, std::memory_order_release);
        signal.notify_one();
    }

    void run()
    {
        leaveSignalsToMain();
        uint64_t told = 0;
        LogEntry entry;
        while (true) {
            const uint32_t seen = signal.load(std::memory_order_acquire);
            const bool last = ending.load(std::memory_order_acquire);
            while (pop(entry)) {
                store(entry);
                stored.fetch_add(1, std::memory_order_release);
            }
            if (const uint64_t lost = dropped.load(std::memory_order_relaxed); lost != told) {
                store({std::chrono::system_clock::now(), LogLevel::warning,
                       "event=log_dropped count=" + std::to_string(lost - told) +
                           " reason=\"standard error takes lines slower than they come\""});
                told = lost;
            }
            if (last) {
                break;
            }
            signal.wait(seen, std::memory_order_acquire);
        }
        done.store(true, std::memory_order_release);
    }

    const std::function<void(const LogEntry&)> store;
    std::array<Cell, kQueuedLines> cells;
    std::atomic<uint64_t> tail{0};
    uint64_t head = 0; // the thread's
    std::atomic<uint64_t> stored{0}, dropped{0};
    std::atomic<uint32_t> signal{0};
    std::atomic<bool> ending{false}, done{false};
};

LogWriter::LogWriter(std::function<void(const LogEntry&)> store)
    : _shared(std::make_shared<Shared>(std::move(store)))
{
}

LogWriter::~LogWriter()
{
    if (!_thread.joinable()) {
        return;
    }
    _shared->ending.store(true, std::memory_order_release);
    _shared->wake();
    if (waitAtMost(kDrainTime, [this] { return _shared->done.load(std::memory_order_acquire); })) {
        _thread.join();
    } else {
        _thread.detach();
    }
}

void LogWriter::offer(LogEntry entry) noexcept
{
    try {
        std::call_once(_started, [this] { _thread = std::thread([shared = _shared] { shared->run(); }); });
    } catch (const std::system_error&) {
        // No thread to be had: the lines wait for one that may be, until the queue is full.
    }
    if (_shared->push(std::move(entry))) {
        _shared->wake();
    } else {
        _shared->dropped.fetch_add(1, std::memory_order_relaxed);
    }
}

uint64_t LogWriter::dropped() const noexcept
{
    return _shared->dropped.load(std::memory_order_relaxed);
}

void LogWriter::flush() const noexcept
{
    const uint64_t taken = _shared->tail.load(std::memory_order_relaxed);
    waitAtMost(kDrainTime, [&] { return _shared->stored.load(std::memory_order_acquire) >= taken; });
}

} // namespace ig::app
