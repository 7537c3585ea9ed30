// SPDX-License-Identifier: MIT
// Errors as values. Result<T, E> holds a T or an E; member names follow std::expected so that the
// standard type can replace it one day.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace ig {

// What failed, in the terms of the program's exit code (see exitCode).
enum class ErrorKind {
    failed,       // the run failed: a write, a send, an inner limit
    usage,        // an option, a config key or an input file of the caller's is wrong
    graphics,     // no usable EGL / OpenGL ES
    dataset,      // terrain unreadable or damaged
    addressInUse, // a UDP port is taken
};

// An error for a person: one line that says what, where, and what to do.
struct Error {
    ErrorKind kind = ErrorKind::failed;
    std::string message;
};

// Exit code of a program that ends with this kind of error; 0 is success.
constexpr int exitCode(ErrorKind kind) noexcept
{
    switch (kind) {
    case ErrorKind::failed:
        return 1;
    case ErrorKind::usage:
        return 2;
    case ErrorKind::graphics:
        return 3;
    case ErrorKind::dataset:
        return 4;
    case ErrorKind::addressInUse:
        return 5;
    }
    return 1;
}

template <class E>
struct Unexpected {
    E error;
};
template <class E>
Unexpected(E) -> Unexpected<E>;

// fail(ErrorKind::dataset, "...") is what a function returns instead of a value.
inline Unexpected<Error> fail(ErrorKind kind, std::string message)
{
    return {Error{kind, std::move(message)}};
}

template <class T, class E = Error>
class [[nodiscard]] Result {
public:
    Result(T value) : _state(std::in_place_index<0>, std::move(value)) {}
    template <class F>
    Result(Unexpected<F> failure) : _state(std::in_place_index<1>, std::move(failure.error))
    {
    }
    explicit operator bool() const noexcept { return _state.index() == 0; }
    T& operator*() & noexcept { return value(); }
    const T& operator*() const& noexcept { return const_cast<Result*>(this)->value(); }
    T&& operator*() && noexcept { return std::move(value()); }
    T* operator->() noexcept { return &value(); }
    const T* operator->() const noexcept { return &**this; }
    const E& error() const noexcept
    {
        assert(_state.index() == 1);
        return *std::get_if<1>(&_state);
    }

private:
    T& value() noexcept
    {
        assert(_state.index() == 0);
        return *std::get_if<0>(&_state);
    }
    std::variant<T, E> _state;
};

// Success without a value.
template <class E>
class [[nodiscard]] Result<void, E> {
public:
    Result() = default;
    template <class F>
    Result(Unexpected<F> failure) : _error(std::move(failure.error)), _failed(true)
    {
    }
    explicit operator bool() const noexcept { return !_failed; }
    const E& error() const noexcept
    {
        assert(_failed);
        return _error;
    }

private:
    E _error{};
    bool _failed = false;
};

} // namespace ig
