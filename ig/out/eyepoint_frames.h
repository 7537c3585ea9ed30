/* SPDX-License-Identifier: MIT */
/*
 * eyepoint_frames.h: frames of an Eyepoint image generator (sink shm:NAME) through shared memory.
 *
 * Header only, C99 or C++, Linux, GCC or Clang; needs nothing but the C library. Include it first, or define
 * _GNU_SOURCE. A reader maps the ring read-only: whatever it does, stopping and dying included, it neither
 * delays the image generator nor disturbs other readers.
 *
 *     struct eyepoint_frames ring;
 *     char why[256];
 *     if (eyepoint_frames_open(&ring, "NAME", why, sizeof why) != EYEPOINT_OK) ...say why...
 *     uint64_t index = eyepoint_frames_newest(&ring);
 *     while (eyepoint_frames_wait(&ring, index, 1000) == EYEPOINT_OK) {   (time-out: another value)
 *         if (eyepoint_frames_copy(&ring, index, &receipt, pixels, NULL) == EYEPOINT_OK) ...use them...
 *         index = eyepoint_frames_following(&ring, index);
 *     }
 *     eyepoint_frames_close(&ring);
 *
 * Layout, version 1, byte order of the machine; every offset is in the header and no other is to be assumed:
 *
 *     0            struct eyepoint_frames_header
 *     first_slot   slot 0: struct eyepoint_frames_slot, its planes at colour_offset and depth_offset
 *     + slot_bytes slot 1 ...
 *
 * Frames are published one after another; the one of index i (from 0) stands in slot i % slot_count until
 * index i + slot_count is begun. The sequence lock of its slot: 2 i + 1 while it is written, 2 i + 2 when it
 * is whole. A reader looks at the sequence before and after copying; a copy between two equal, even values is
 * whole.
 *
 * Planes: colour is RGBA8, top row first, rows packed, alpha 255 where terrain is drawn and 0 where there is
 * sky. Depth, if there is one, is float metres along the viewing axis (not along the ray of the pixel), same
 * order of pixels, infinity for sky.
 *
 * The image generator holds a write lock (fcntl, open file description) on the shared-memory file while it
 * lives. A later one takes the name over only when nobody holds that lock.
 */
#ifndef EYEPOINT_FRAMES_H
#define EYEPOINT_FRAMES_H

#if !defined(_GNU_SOURCE)
#define _GNU_SOURCE 1 /* syscall(), F_OFD_GETLK */
#endif

#include <errno.h>
#include <fcntl.h>
#include <linux/futex.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#if defined(__cplusplus)
extern "C" {
#endif

#define EYEPOINT_FRAMES_MAGIC "EYEPTFRM"
#define EYEPOINT_FRAMES_VERSION 1U
#define EYEPOINT_FRAMES_MAX_SLOTS 64U
#define EYEPOINT_FRAMES_MAX_SIDE_PX 16384U
#define EYEPOINT_FRAMES_MAX_NAME 200U

enum { EYEPOINT_PLANE_COLOUR = 1, EYEPOINT_PLANE_DEPTH = 2 };

enum {
    EYEPOINT_RING_LIVE = 1,
    EYEPOINT_RING_ENDED = 2 /* closed in order: nothing follows */
};

enum {
    EYEPOINT_RECEIPT_HOST = 1,      /* a host has spoken: host_frame and arrival_ns are known */
    EYEPOINT_RECEIPT_HOST_TIME = 2, /* host_time_ticks is known */
    EYEPOINT_RECEIPT_NEW_HOST = 4   /* its newest message came in since the frame before */
};

/*
 * What there is to know about one frame. Times are CLOCK_MONOTONIC, nanoseconds, the clock of every process
 * of the machine; 0 where unknown. Delays follow by subtraction, for example
 *
 *     host to pixels     publish_ns - arrival_ns       (of a frame with EYEPOINT_RECEIPT_NEW_HOST)
 *     rendering          render_end_ns - render_start_ns
 *     hand-over          own clock - publish_ns
 */
struct eyepoint_receipt {
    uint64_t frame;      /* frames rendered before this one */
    uint64_t host_frame; /* host's number of the newest message that the picture shows */
    uint32_t flags;      /* EYEPOINT_RECEIPT_... */
    uint32_t view_id;
    uint32_t width_px, height_px;
    uint32_t host_time_ticks; /* time stamp in that message, 10 us, origin of the host's choice, wraps */
    uint32_t reserved0;
    int64_t arrival_ns;       /* the kernel had that message */
    int64_t start_ns;         /* the frame began; the host's messages up to here count */
    int64_t render_start_ns;  /* host applied, view known */
    int64_t render_end_ns;    /* picture read back */
    int64_t publish_ns;       /* ring: the slot was whole; elsewhere: all sinks had taken the frame */
    int64_t display_ns;       /* end of the frame's period, when a display at the fixed rate shows it; with */
                              /* output.hold_ms when it is due to be handed out */
    int64_t extrapolation_ns; /* age of the host's state at start_ns, the pose is held so long; -1 no host */
    double eye_ecef_m[3];
    double eye_latitude_deg, eye_longitude_deg, eye_height_m; /* on the dataset's ellipsoid */
    /* Of the view, from the local horizon: clockwise from north, up, right wing down. */
    double yaw_deg, pitch_deg, roll_deg;
    /* Tangents from the viewing axis, signed. */
    double frustum_left, frustum_right, frustum_bottom, frustum_top;
    double near_m;
    double tau_px;   /* tolerance that the triangle budget allowed */
    double error_px; /* bound of the largest projected error */
    uint32_t triangles, triangle_budget;
    uint32_t missing_tiles; /* drawn by an ancestor because pages were not loaded yet */
    uint32_t reserved1;
    uint64_t dropped;   /* frames that this image generator's sinks had no room for, so far */
    uint64_t missed;    /* periods without a frame of their own, so far */
    uint64_t host_lost; /* host messages that never came, so far */
    uint64_t host_late; /* host messages that came too late to count, so far */
    uint64_t dataset_checksum;
};

struct eyepoint_frames_header {
    char magic[8]; /* written last, in one store */
    uint32_t version;
    uint32_t header_bytes; /* sizeof(struct eyepoint_frames_header) of the writer */
    uint64_t total_bytes;
    uint64_t first_slot;                  /* bytes from the start */
    uint64_t slot_bytes;                  /* from one slot to the next */
    uint64_t colour_offset, depth_offset; /* from the start of a slot; depth_offset 0: no depth */
    uint32_t slot_count;
    uint32_t planes; /* EYEPOINT_PLANE_... */
    uint32_t width_px, height_px;
    double rate_hz;
    int64_t made_ns; /* CLOCK_MONOTONIC: tells one run from the next */
    int32_t writer_pid;
    uint32_t receipt_bytes; /* sizeof(struct eyepoint_receipt) of the writer */
    /* What changes while the ring lives; atomic. */
    uint32_t state;     /* EYEPOINT_RING_... */
    uint32_t signal;    /* +1 with every frame and at the end; readers wait on it with FUTEX_WAIT */
    uint64_t published; /* frames so far: the newest has the index published - 1 */
};

struct eyepoint_frames_slot {
    uint64_t sequence; /* 0 never used; 2 i + 1 frame of index i is being written; 2 i + 2 it is whole */
    struct eyepoint_receipt receipt;
};

enum eyepoint_status {
    EYEPOINT_OK = 0,
    EYEPOINT_TIMEOUT = 1,     /* nothing new yet, the image generator lives */
    EYEPOINT_ENDED = 2,       /* it closed the ring */
    EYEPOINT_GONE = 3,        /* it died */
    EYEPOINT_OVERWRITTEN = 4, /* the frame is no longer, or not yet, in the ring */
    EYEPOINT_FAILED = 5       /* no such ring, or not a whole one */
};

/* An open ring. Everything but `header` is the reader's own, checked copy. */
struct eyepoint_frames {
    const struct eyepoint_frames_header* header; /* for the atomic fields alone */
    int descriptor;
    size_t total_bytes;
    uint64_t first_slot, slot_bytes, colour_offset, depth_offset;
    uint32_t slot_count, planes, width_px, height_px;
    double rate_hz;
    int64_t made_ns;
    int32_t writer_pid;
};

/* A frame where it lies; what is read through it counts only if eyepoint_frames_whole() says so after. */
struct eyepoint_frames_view {
    uint64_t index;
    const struct eyepoint_frames_slot* slot;
    const unsigned char* colour;
    const float* depth_m; /* NULL: the ring has no depth */
};

#if defined(__SANITIZE_THREAD__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wtsan" /* the fence pairs with another process */
#endif

static inline uint64_t eyepoint_colour_bytes(const struct eyepoint_frames* ring)
{
    return (uint64_t)ring->width_px * ring->height_px * 4U;
}

static inline int eyepoint_refuse_(char* why, size_t size, const char* name, const char* what)
{
    if (why != NULL && size > 0) {
        (void)snprintf(why, size, "frames of \"%s\": %s", name, what);
    }
    return EYEPOINT_FAILED;
}

/* NULL, or what is wrong with the header. `bytes` is the size of the file. */
static inline const char* eyepoint_header_fault_(const struct eyepoint_frames_header* h, uint64_t bytes)
{
    uint64_t plane;
    uint64_t end;
    if (memcmp(h->magic, EYEPOINT_FRAMES_MAGIC, sizeof h->magic) != 0) {
        return "not a ring of Eyepoint frames, or one that is still being made";
    }
    if (h->version != EYEPOINT_FRAMES_VERSION) {
        return "the ring has another layout version; use the eyepoint_frames.h of that image generator";
    }
    if (h->header_bytes != sizeof(struct eyepoint_frames_header) ||
        h->receipt_bytes != sizeof(struct eyepoint_receipt)) {
        return "corrupt header: structures of another size";
    }
    if (h->slot_count < 2 || h->slot_count > EYEPOINT_FRAMES_MAX_SLOTS) {
        return "corrupt header: number of slots";
    }
    if (h->width_px < 1 || h->height_px < 1 || h->width_px > EYEPOINT_FRAMES_MAX_SIDE_PX ||
        h->height_px > EYEPOINT_FRAMES_MAX_SIDE_PX) {
        return "corrupt header: size of the picture";
    }
    if ((h->planes & ~(uint32_t)(EYEPOINT_PLANE_COLOUR | EYEPOINT_PLANE_DEPTH)) != 0 ||
        (h->planes & EYEPOINT_PLANE_COLOUR) == 0 ||
        ((h->planes & EYEPOINT_PLANE_DEPTH) != 0) != (h->depth_offset != 0)) {
        return "corrupt header: planes";
    }
    if (!(h->rate_hz > 0.0 && h->rate_hz <= 1e6)) {
        return "corrupt header: frame rate";
    }
    /* No sum below can wrap: offsets are compared with the size first. */
    plane = (uint64_t)h->width_px * h->height_px * 4U;
    if (h->total_bytes != bytes || h->slot_bytes > bytes || h->first_slot > bytes ||
        h->colour_offset > bytes || h->depth_offset > bytes || plane > bytes) {
        return "corrupt header: sizes beyond the file";
    }
    if (h->first_slot < sizeof *h || h->first_slot % 64U != 0 || h->slot_bytes % 64U != 0 ||
        h->colour_offset < sizeof(struct eyepoint_frames_slot) || h->colour_offset % 64U != 0 ||
        h->depth_offset % 64U != 0) {
        return "corrupt header: offsets";
    }
    end = h->colour_offset + plane;
    if (end > h->slot_bytes) {
        return "corrupt header: colour beyond the slot";
    }
    if (h->depth_offset != 0 && (h->depth_offset < end || h->depth_offset + plane > h->slot_bytes)) {
        return "corrupt header: depth beyond the slot";
    }
    if (h->slot_bytes > (bytes - h->first_slot) / h->slot_count) {
        return "corrupt header: slots beyond the file";
    }
    return NULL;
}

/*
 * Opens and maps the ring of this name ("NAME" as in shm:NAME) and checks every field that is used
 * afterwards. EYEPOINT_OK, or EYEPOINT_FAILED with one line in `why`.
 */
static inline int eyepoint_frames_open(struct eyepoint_frames* ring, const char* name, char* why,
                                       size_t why_size)
{
    char path[EYEPOINT_FRAMES_MAX_NAME + 2];
    struct eyepoint_frames_header copy;
    struct stat status;
    const char* fault;
    void* mapped;
    uint64_t magic;
    int descriptor;
    const size_t length = strlen(name);
    memset(ring, 0, sizeof *ring);
    ring->descriptor = -1;
    if (length < 1 || length > EYEPOINT_FRAMES_MAX_NAME || strchr(name, '/') != NULL) {
        return eyepoint_refuse_(why, why_size, name, "not a name of 1 to 200 characters without a slash");
    }
    path[0] = '/';
    memcpy(path + 1, name, length + 1);
    descriptor = shm_open(path, O_RDONLY | O_CLOEXEC, 0);
    if (descriptor < 0) {
        return eyepoint_refuse_(why, why_size, name,
                                errno == ENOENT ? "no image generator publishes it (sink shm:NAME)"
                                                : strerror(errno));
    }
    if (fstat(descriptor, &status) != 0 || status.st_size < (off_t)sizeof copy) {
        (void)close(descriptor);
        return eyepoint_refuse_(why, why_size, name, "too short for a ring, or one that is still being made");
    }
    mapped = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_SHARED, descriptor, 0);
    if (mapped == MAP_FAILED) {
        const int code = errno;
        (void)close(descriptor);
        return eyepoint_refuse_(why, why_size, name, strerror(code));
    }
    /* Judged and kept is one copy: what changes under us later changes nothing. The magic first. */
    magic = __atomic_load_n((const uint64_t*)mapped, __ATOMIC_ACQUIRE);
    memcpy(&copy, mapped, sizeof copy);
    memcpy(copy.magic, &magic, sizeof copy.magic);
    fault = eyepoint_header_fault_(&copy, (uint64_t)status.st_size);
    if (fault != NULL) {
        (void)munmap(mapped, (size_t)status.st_size);
        (void)close(descriptor);
        return eyepoint_refuse_(why, why_size, name, fault);
    }
#if defined(MADV_POPULATE_READ)
    /* Page tables now, not with the first frames; a kernel before 5.14 says no, which does no harm. */
    (void)madvise(mapped, (size_t)status.st_size, MADV_POPULATE_READ);
#endif
    ring->header = (const struct eyepoint_frames_header*)mapped;
    ring->descriptor = descriptor;
    ring->total_bytes = (size_t)status.st_size;
    ring->first_slot = copy.first_slot;
    ring->slot_bytes = copy.slot_bytes;
    ring->colour_offset = copy.colour_offset;
    ring->depth_offset = copy.depth_offset;
    ring->slot_count = copy.slot_count;
    ring->planes = copy.planes;
    ring->width_px = copy.width_px;
    ring->height_px = copy.height_px;
    ring->rate_hz = copy.rate_hz;
    ring->made_ns = copy.made_ns;
    ring->writer_pid = copy.writer_pid;
    return EYEPOINT_OK;
}

static inline void eyepoint_frames_close(struct eyepoint_frames* ring)
{
    if (ring->header != NULL) {
        (void)munmap((void*)(uintptr_t)ring->header, ring->total_bytes);
        (void)close(ring->descriptor);
        ring->header = NULL;
        ring->descriptor = -1;
    }
}

/* Frames published so far. */
static inline uint64_t eyepoint_frames_published(const struct eyepoint_frames* ring)
{
    return __atomic_load_n(&ring->header->published, __ATOMIC_ACQUIRE);
}

/* Index of the newest frame; 0 while there is none. */
static inline uint64_t eyepoint_frames_newest(const struct eyepoint_frames* ring)
{
    const uint64_t published = eyepoint_frames_published(ring);
    return published > 0 ? published - 1 : 0;
}

/* The index to ask for after `index`: the next one, or the newest if the ring has gone round meanwhile. */
static inline uint64_t eyepoint_frames_following(const struct eyepoint_frames* ring, uint64_t index)
{
    const uint64_t published = eyepoint_frames_published(ring);
    /* The slot after the newest may be in work: it is not counted on. */
    return published > index && published - index >= ring->slot_count ? published - 1 : index + 1;
}

/* 1 while the image generator that made the ring lives. */
static inline int eyepoint_frames_writer_lives(const struct eyepoint_frames* ring)
{
    struct flock lock;
    memset(&lock, 0, sizeof lock); /* open file description locks want l_pid 0 */
    lock.l_type = F_RDLCK;
    lock.l_whence = SEEK_SET;
#if defined(F_OFD_GETLK)
    return fcntl(ring->descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
#else
    return fcntl(ring->descriptor, 36, &lock) == 0 && lock.l_type != F_UNLCK;
#endif
}

/*
 * Waits, asleep, until the frame of this index is published, at most timeout_ms (< 0: for ever).
 * EYEPOINT_OK, _TIMEOUT, _ENDED or _GONE; a death is noticed within half a second. Signals do not end the
 * wait.
 */
static inline int eyepoint_frames_wait(const struct eyepoint_frames* ring, uint64_t index, int timeout_ms)
{
    const int64_t slice_ns = 500000000;
    struct timespec now;
    int64_t now_ns;
    int64_t deadline_ns;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    now_ns = (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
    deadline_ns = now_ns + (int64_t)timeout_ms * 1000000;
    for (;;) {
        const uint32_t signal = __atomic_load_n(&ring->header->signal, __ATOMIC_ACQUIRE);
        struct timespec slice;
        int64_t rest_ns = slice_ns;
        if (eyepoint_frames_published(ring) > index) {
            return EYEPOINT_OK;
        }
        if (__atomic_load_n(&ring->header->state, __ATOMIC_ACQUIRE) != EYEPOINT_RING_LIVE) {
            return EYEPOINT_ENDED;
        }
        if (timeout_ms >= 0) {
            if (now_ns >= deadline_ns) {
                return eyepoint_frames_writer_lives(ring) ? EYEPOINT_TIMEOUT : EYEPOINT_GONE;
            }
            rest_ns = deadline_ns - now_ns < slice_ns ? deadline_ns - now_ns : slice_ns;
        }
        slice.tv_sec = (time_t)(rest_ns / 1000000000);
        slice.tv_nsec = (long)(rest_ns % 1000000000);
        if (syscall(SYS_futex, &ring->header->signal, FUTEX_WAIT, signal, &slice, NULL, 0) != 0 &&
            errno == ETIMEDOUT && !eyepoint_frames_writer_lives(ring)) {
            return EYEPOINT_GONE;
        }
        (void)clock_gettime(CLOCK_MONOTONIC, &now);
        now_ns = (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
    }
}

/* The frame of this index in place: EYEPOINT_OK, or EYEPOINT_OVERWRITTEN. */
static inline int eyepoint_frames_begin(const struct eyepoint_frames* ring, uint64_t index,
                                        struct eyepoint_frames_view* view)
{
    const unsigned char* start =
        (const unsigned char*)ring->header + ring->first_slot + index % ring->slot_count * ring->slot_bytes;
    view->index = index;
    view->slot = (const struct eyepoint_frames_slot*)(const void*)start;
    view->colour = start + ring->colour_offset;
    view->depth_m = ring->depth_offset != 0 ? (const float*)(const void*)(start + ring->depth_offset) : NULL;
    return __atomic_load_n(&view->slot->sequence, __ATOMIC_ACQUIRE) == 2 * index + 2 ? EYEPOINT_OK
                                                                                     : EYEPOINT_OVERWRITTEN;
}

/* 1 if all that was read through the view since eyepoint_frames_begin() belongs to that one frame. */
static inline int eyepoint_frames_whole(const struct eyepoint_frames_view* view)
{
    __atomic_thread_fence(__ATOMIC_ACQUIRE);
    return __atomic_load_n(&view->slot->sequence, __ATOMIC_RELAXED) == 2 * view->index + 2;
}

/*
 * Copies a frame out: any of receipt, colour (width * height * 4 bytes) and depth (width * height floats) may
 * be NULL. EYEPOINT_OK, or EYEPOINT_OVERWRITTEN, when what was copied is to be thrown away; EYEPOINT_FAILED
 * when depth is asked for and the ring has none.
 */
static inline int eyepoint_frames_copy(const struct eyepoint_frames* ring, uint64_t index,
                                       struct eyepoint_receipt* receipt, void* colour, float* depth_m)
{
    struct eyepoint_frames_view view;
    if (depth_m != NULL && ring->depth_offset == 0) {
        return EYEPOINT_FAILED;
    }
    if (eyepoint_frames_begin(ring, index, &view) != EYEPOINT_OK) {
        return EYEPOINT_OVERWRITTEN;
    }
    if (receipt != NULL) {
        memcpy(receipt, &view.slot->receipt, sizeof *receipt);
    }
    if (colour != NULL) {
        memcpy(colour, view.colour, (size_t)eyepoint_colour_bytes(ring));
    }
    if (depth_m != NULL) {
        memcpy(depth_m, view.depth_m, (size_t)eyepoint_colour_bytes(ring));
    }
    return eyepoint_frames_whole(&view) ? EYEPOINT_OK : EYEPOINT_OVERWRITTEN;
}

#if defined(__SANITIZE_THREAD__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#if defined(__cplusplus)
} /* extern "C" */
#endif

#endif /* EYEPOINT_FRAMES_H */
