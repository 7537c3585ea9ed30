// SPDX-License-Identifier: MIT
#include "counted_new.h"

#include <cstdlib>
#include <new>

namespace {

thread_local size_t count = 0;

void* allocate(size_t size, size_t alignment) noexcept
{
    ++count;
    // aligned_alloc wants a multiple of the alignment.
    const size_t rounded = (size + alignment - 1) / alignment * alignment;
    return std::aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
}

void* allocateOrThrow(size_t size, size_t alignment)
{
    void* memory = allocate(size, alignment);
    if (memory == nullptr) {
        throw std::bad_alloc();
    }
    return memory;
}

constexpr size_t kDefault = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

} // namespace

namespace test {
size_t allocations() noexcept
{
    return count;
}
} // namespace test

void* operator new(size_t size)
{
    return allocateOrThrow(size, kDefault);
}
void* operator new[](size_t size)
{
    return allocateOrThrow(size, kDefault);
}
void* operator new(size_t size, const std::nothrow_t&) noexcept
{
    return allocate(size, kDefault);
}
void* operator new[](size_t size, const std::nothrow_t&) noexcept
{
    return allocate(size, kDefault);
}
void* operator new(size_t size, std::align_val_t a)
{
    return allocateOrThrow(size, size_t(a));
}
void* operator new[](size_t size, std::align_val_t a)
{
    return allocateOrThrow(size, size_t(a));
}
void* operator new(size_t size, std::align_val_t a, const std::nothrow_t&) noexcept
{
    return allocate(size, size_t(a));
}
void* operator new[](size_t size, std::align_val_t a, const std::nothrow_t&) noexcept
{
    return allocate(size, size_t(a));
}
void operator delete(void* p) noexcept
{
    std::free(p);
}
void operator delete[](void* p) noexcept
{
    std::free(p);
}
void operator delete(void* p, size_t) noexcept
{
    std::free(p);
}
void operator delete[](void* p, size_t) noexcept
{
    std::free(p);
}
void operator delete(void* p, const std::nothrow_t&) noexcept
{
    std::free(p);
}
void operator delete[](void* p, const std::nothrow_t&) noexcept
{
    std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept
{
    std::free(p);
}
void operator delete[](void* p, std::align_val_t) noexcept
{
    std::free(p);
}
void operator delete(void* p, size_t, std::align_val_t) noexcept
{
    std::free(p);
}
void operator delete[](void* p, size_t, std::align_val_t) noexcept
{
    std::free(p);
}
void operator delete(void* p, std::align_val_t, const std::nothrow_t&) noexcept
{
    std::free(p);
}
void operator delete[](void* p, std::align_val_t, const std::nothrow_t&) noexcept
{
    std::free(p);
}
