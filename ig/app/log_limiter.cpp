// SPDX-License-Identifier: MIT
#include "ig/app/log_limiter.h"

#include <utility>

namespace ig::app {

LogLimiter::Verdict LogLimiter::admit(std::string_view kind, int64_t nowNs)
{
    auto place = _kinds.find(kind);
    if (place == _kinds.end()) {
        const std::string name(_kinds.size() < kKinds - 1 ? kind : "other");
        place = _kinds.try_emplace(name, Kind{nowNs, 0, 0}).first;
    }
    Kind& k = place->second;
    if (nowNs - k.sinceNs >= kPeriodNs) {
        k.sinceNs = nowNs;
        k.written = 0;
    }
    if (k.written == kBurst) {
        ++k.suppressed;
        ++_suppressed;
        return {};
    }
    ++k.written;
    return {true, std::exchange(k.suppressed, 0)};
}

void LogLimiter::drain(const std::function<void(const std::string& kind, uint64_t suppressed)>& tell)
{
    for (auto& [name, kind] : _kinds) {
        if (kind.suppressed > 0) {
            tell(name, std::exchange(kind.suppressed, 0));
        }
    }
}

std::string logKind(std::string_view line)
{
    constexpr std::string_view kEvent = "event=";
    if (line.starts_with(kEvent)) {
        line.remove_prefix(kEvent.size());
        return std::string(line.substr(0, line.find(' ')));
    }
    std::string kind(line);
    std::erase_if(kind, [](char c) { return c >= '0' && c <= '9'; });
    return kind;
}

} // namespace ig::app
