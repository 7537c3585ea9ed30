// SPDX-License-Identifier: MIT
#include "ig/out/shm_ring.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace ig::out {
namespace {

constexpr uint64_t kPage = 4096;
constexpr int kOpenTries = 10;

constexpr uint64_t wholePages(uint64_t bytes)
{
    return (bytes + kPage - 1) / kPage * kPage;
}

class Descriptor {
public:
    explicit Descriptor(int number = -1) noexcept : _number(number) {}
    Descriptor(Descriptor&& other) noexcept : _number(std::exchange(other._number, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept
    {
        std::swap(_number, other._number);
        return *this;
    }
    ~Descriptor()
    {
        if (_number >= 0)
            ::close(_number);
    }
    int number() const noexcept { return _number; }

private:
    int _number;
};

// Of the open file description: it ends with the last descriptor of this process, however that ends.
bool takeLock(int descriptor)
{
    struct flock lock {};
    lock.l_type = F_WRLCK;
    lock.l_whence = SEEK_SET;
    return fcntl(descriptor, F_OFD_SETLK, &lock) == 0;
}

// The name still leads to the file that is open here.
bool namesFile(const std::string& path, int descriptor)
{
    const Descriptor named(shm_open(path.c_str(), O_RDONLY | O_CLOEXEC, 0));
    struct stat here {};
    struct stat there {};
    return named.number() >= 0 && fstat(descriptor, &here) == 0 && fstat(named.number(), &there) == 0 &&
           here.st_ino == there.st_ino && here.st_dev == there.st_dev;
}

std::string ownerOf(int descriptor)
{
    eyepoint_frames_header header{};
    const bool known = pread(descriptor, &header, sizeof header, 0) == sizeof header &&
                       std::memcmp(header.magic, EYEPOINT_FRAMES_MAGIC, sizeof header.magic) == 0;
    return known ? fmt::format(" (process {})", header.writer_pid) : "";
}

// A ring, or one that was still being made: the magic is written last.
bool isRing(int descriptor)
{
    std::array<char, sizeof eyepoint_frames_header::magic> magic{};
    const ssize_t size = pread(descriptor, magic.data(), magic.size(), 0);
    const bool unmade = std::all_of(magic.begin(), magic.end(), [](char byte) { return byte == 0; });
    return size >= 0 && (unmade || std::memcmp(magic.data(), EYEPOINT_FRAMES_MAGIC, magic.size()) == 0);
}

Unexpected<Error> failed(const std::string& name, const std::string& why)
{
    return fail(ErrorKind::usage, fmt::format("sink shm:{}: {}", name, why));
}

// A new, empty, locked file under this name.
Result<Descriptor> claim(const std::string& name)
{
    const std::string path = "/" + name;
    for (int i = 0; i < kOpenTries; ++i) {
        Descriptor file(shm_open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
        if (file.number() < 0)
            return failed(name, fmt::format("cannot make the ring: {}", std::strerror(errno)));
        if (!takeLock(file.number()))
            return failed(name, fmt::format("another image generator{} publishes under this name; choose "
                                            "another name or end it",
                                            ownerOf(file.number())));
        struct stat status {};
        // Between opening and locking another one may have replaced the file.
        if (fstat(file.number(), &status) != 0 || !namesFile(path, file.number()))
            continue;
        if (status.st_size == 0)
            return file;
        if (!isRing(file.number()))
            return failed(name, "another program's shared memory has this name; choose another name");
        // Left behind by one that died. Readers may still have it mapped: a new file, not this one cut short.
        // The lock on this one is held until the new one is locked, so that nobody comes in between.
        if (shm_unlink(path.c_str()) != 0)
            return failed(name, fmt::format("cannot replace a ring left behind: {}", std::strerror(errno)));
        Descriptor fresh(shm_open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
        if (fresh.number() >= 0 && takeLock(fresh.number()))
            return fresh;
    }
    return failed(name, "another image generator is starting under this name; choose another name");
}

eyepoint_frames_header layout(const SinkFormat& format)
{
    const uint64_t plane = static_cast<uint64_t>(format.widthPx) * static_cast<uint64_t>(format.heightPx) * 4;
    eyepoint_frames_header header{};
    std::memcpy(header.magic, EYEPOINT_FRAMES_MAGIC, sizeof header.magic);
    header.version = EYEPOINT_FRAMES_VERSION;
    header.header_bytes = sizeof(eyepoint_frames_header);
    header.receipt_bytes = sizeof(eyepoint_receipt);
    header.first_slot = kPage;
    header.colour_offset = wholePages(sizeof(eyepoint_frames_slot));
    header.depth_offset = format.depth ? header.colour_offset + wholePages(plane) : 0;
    header.slot_bytes = header.colour_offset + wholePages(plane) * (format.depth ? 2 : 1);
    header.slot_count = static_cast<uint32_t>(format.ringSlots);
    header.total_bytes = header.first_slot + header.slot_bytes * header.slot_count;
    header.planes = EYEPOINT_PLANE_COLOUR | (format.depth ? EYEPOINT_PLANE_DEPTH : 0);
    header.width_px = static_cast<uint32_t>(format.widthPx);
    header.height_px = static_cast<uint32_t>(format.heightPx);
    header.rate_hz = format.rateHz;
    header.made_ns = format.clockNs();
    header.writer_pid = getpid();
    header.state = EYEPOINT_RING_LIVE;
    return header;
}

class ShmRing final : public FrameSink {
public:
    // Owns file and mapping from here on; writes the header.
    ShmRing(std::string name, Descriptor file, std::byte* memory, const eyepoint_frames_header& header,
            int64_t (*clockNs)())
        : _name(std::move(name)), _file(std::move(file)), _memory(memory), _layout(header), _clockNs(clockNs)
    {
        uint64_t magic = 0;
        std::memcpy(&magic, header.magic, sizeof magic);
        auto* bytes = reinterpret_cast<const std::byte*>(&header);
        std::memcpy(_memory + sizeof magic, bytes + sizeof magic, sizeof header - sizeof magic);
        __atomic_store_n(reinterpret_cast<uint64_t*>(_memory), magic, __ATOMIC_RELEASE);
    }
    ~ShmRing() override { end(); }

    FrameMemory memoryForNext() override
    {
        std::byte* start = beginSlot();
        const size_t pixels = planeBytes() / 4;
        return {
            {start + _layout.colour_offset, planeBytes()},
            {reinterpret_cast<float*>(start + _layout.depth_offset), _layout.depth_offset != 0 ? pixels : 0}};
    }

    Result<void> write(const Frame& frame) override
    {
        if (static_cast<uint32_t>(frame.widthPx) != _layout.width_px ||
            static_cast<uint32_t>(frame.heightPx) != _layout.height_px || frame.rgba.size() < planeBytes() ||
            (_layout.depth_offset != 0 && frame.depthM.size_bytes() < planeBytes()))
            return failed(_name,
                          fmt::format("a frame of {} x {} pixels does not fit a ring of {} x {}",
                                      frame.widthPx, frame.heightPx, _layout.width_px, _layout.height_px));
        const uint64_t index = _written;
        std::byte* start = beginSlot();
        auto& slot = *reinterpret_cast<eyepoint_frames_slot*>(start);
        if (frame.rgba.data() != start + _layout.colour_offset)
            std::memcpy(start + _layout.colour_offset, frame.rgba.data(), planeBytes());
        const auto* depth = reinterpret_cast<const std::byte*>(frame.depthM.data());
        if (_layout.depth_offset != 0 && depth != start + _layout.depth_offset)
            std::memcpy(start + _layout.depth_offset, depth, planeBytes());
        if (frame.receipt != nullptr)
            slot.receipt = *frame.receipt;
        else
            slot.receipt = {};
        slot.receipt.frame = frame.number;
        slot.receipt.publish_ns = _clockNs();
        __atomic_store_n(&slot.sequence, 2 * index + 2, __ATOMIC_RELEASE);
        __atomic_store_n(&shared().published, index + 1, __ATOMIC_RELEASE);
        _written = index + 1;
        wake();
        return {};
    }

    SinkStats stats() const override { return {_written, 0}; }

    Result<SinkStats> close() override
    {
        end();
        return stats();
    }

private:
    size_t planeBytes() const { return size_t{_layout.width_px} * _layout.height_px * 4; }
    eyepoint_frames_header& shared() const { return *reinterpret_cast<eyepoint_frames_header*>(_memory); }

    // The slot of the next frame, marked as being written.
    std::byte* beginSlot()
    {
        std::byte* start = _memory + _layout.first_slot + _written % _layout.slot_count * _layout.slot_bytes;
        __atomic_store_n(&reinterpret_cast<eyepoint_frames_slot*>(start)->sequence, 2 * _written + 1,
                         __ATOMIC_RELAXED);
        fence();
        return start;
    }

    // Nothing of the frame may be seen before the odd sequence. A full one: memcpy may use stores that pass
    // earlier ones, which a release fence leaves alone on x86.
    static void fence()
    {
#if defined(__SANITIZE_THREAD__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wtsan" // it pairs with another process
#endif
        __atomic_thread_fence(__ATOMIC_SEQ_CST);
#if defined(__SANITIZE_THREAD__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
    }

    void wake() const
    {
        __atomic_fetch_add(&shared().signal, 1, __ATOMIC_RELEASE);
        syscall(SYS_futex, &shared().signal, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
    }

    void end()
    {
        if (_memory == nullptr)
            return;
        __atomic_store_n(&shared().state, uint32_t{EYEPOINT_RING_ENDED}, __ATOMIC_RELEASE);
        wake();
        munmap(std::exchange(_memory, nullptr), _layout.total_bytes);
        if (namesFile("/" + _name, _file.number()))
            shm_unlink(("/" + _name).c_str());
        _file = Descriptor();
    }

    const std::string _name;
    Descriptor _file; // holds the lock
    std::byte* _memory;
    const eyepoint_frames_header _layout; // our own: readers cannot write, but other writers might
    int64_t (*const _clockNs)();
    uint64_t _written = 0;
};

bool isName(const std::string& name)
{
    return name.size() <= EYEPOINT_FRAMES_MAX_NAME && name.front() != '.' &&
           std::all_of(name.begin(), name.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '_' || c == '-' || c == '.';
           });
}

} // namespace

Result<std::unique_ptr<FrameSink>> makeShmRing(const std::string& name, const SinkFormat& format)
{
    if (!isName(name))
        return fail(ErrorKind::usage,
                    "sink shm:NAME: not a name: 1 to 200 letters, digits, '_', '-' and '.', "
                    "not beginning with '.'"); // not repeated: it may not be printable
    if (format.ringSlots < 2 || format.ringSlots > static_cast<int>(EYEPOINT_FRAMES_MAX_SLOTS))
        return failed(name, fmt::format("{} slots are not possible: 2 to {}", format.ringSlots,
                                        EYEPOINT_FRAMES_MAX_SLOTS));
    if (format.widthPx > static_cast<int>(EYEPOINT_FRAMES_MAX_SIDE_PX) ||
        format.heightPx > static_cast<int>(EYEPOINT_FRAMES_MAX_SIDE_PX) ||
        !(format.rateHz > 0 && format.rateHz <= 1e6))
        return failed(name, fmt::format("frames of {} x {} pixels at {} Hz are not possible", format.widthPx,
                                        format.heightPx, format.rateHz));
    auto file = claim(name);
    if (!file)
        return Unexpected{file.error()};
    const eyepoint_frames_header header = layout(format);
    const auto giveUp = [&](const std::string& why) {
        shm_unlink(("/" + name).c_str());
        return failed(name, why);
    };
    // All pages now: later, a full /dev/shm would end the process with SIGBUS.
    if (const int code = posix_fallocate(file->number(), 0, static_cast<off_t>(header.total_bytes));
        code != 0)
        return giveUp(fmt::format("{:.1f} MB for {} slots of {} x {} pixels in /dev/shm: {}; lower "
                                  "output.ring_slots or the picture's size, or enlarge /dev/shm",
                                  static_cast<double>(header.total_bytes) * 1e-6, header.slot_count,
                                  header.width_px, header.height_px, std::strerror(code)));
    void* memory = mmap(nullptr, header.total_bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE,
                        file->number(), 0);
    if (memory == MAP_FAILED)
        return giveUp(fmt::format("cannot map the ring: {}", std::strerror(errno)));
    return std::unique_ptr<FrameSink>(std::make_unique<ShmRing>(
        name, std::move(*file), static_cast<std::byte*>(memory), header, format.clockNs));
}

} // namespace ig::out
