// SPDX-License-Identifier: MIT
#include "ig/app/log.h"

#include "ig/app/log_limiter.h"
#include "ig/app/log_writer.h"
#include "ig/app/steady_clock.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <mutex>

namespace ig::app {

namespace {

spdlog::level::level_enum levelOf(LogLevel level)
{
    switch (level) {
    case LogLevel::debug:
        return spdlog::level::debug;
    case LogLevel::info:
        return spdlog::level::info;
    case LogLevel::warning:
        return spdlog::level::warn;
    case LogLevel::error:
        return spdlog::level::err;
    }
    return spdlog::level::info;
}

// As it stands if it is one plain word, else in quotes, on one line.
std::string valueText(std::string_view value)
{
    const auto plain = [](char c) { return c > ' ' && c < '\x7f' && c != '"' && c != '=' && c != '\\'; };
    if (!value.empty() && std::all_of(value.begin(), value.end(), plain)) {
        return std::string(value);
    }
    std::string text = "\"";
    for (const char c : value) {
        if (c == '"' || c == '\\') {
            text += '\\';
        }
        text += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
    }
    return text + '"';
}

class StandardError final : public Log {
public:
    explicit StandardError(const std::string& level)
        : _logger(std::make_shared<spdlog::logger>("eyepoint-ig",
                                                   std::make_shared<spdlog::sinks::stderr_sink_mt>())),
          _writer([logger = _logger](const LogEntry& entry) {
              logger->log(entry.time, spdlog::source_loc{}, levelOf(entry.level), entry.text);
          })
    {
        _logger->set_pattern("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc);
        setLevel(level);
    }
    void setLevel(const std::string& level) override { _logger->set_level(spdlog::level::from_str(level)); }
    void write(LogLevel level, std::string_view line) override
    {
        if (!_logger->should_log(levelOf(level))) {
            return;
        }
        LogLimiter::Verdict verdict;
        {
            const std::lock_guard lock(_mutex);
            verdict = _limiter.admit(logKind(line), steadyNs());
        }
        if (!verdict.write) {
            return;
        }
        std::string text = line.starts_with("event=") ? std::string(line) : logLine("note", {{"msg", line}});
        if (verdict.suppressed > 0) {
            text += " suppressed=" + std::to_string(verdict.suppressed);
        }
        queue(level, std::move(text));
    }
    uint64_t suppressed() const override
    {
        const std::lock_guard lock(_mutex);
        return _limiter.suppressed();
    }
    uint64_t dropped() const override { return _writer.dropped(); }
    void finish() override
    {
        {
            const std::lock_guard lock(_mutex);
            _limiter.drain([&](const std::string& kind, uint64_t count) {
                queue(LogLevel::warning,
                      logLine("suppressed", {{"kind", kind}, {"count", std::to_string(count)}}));
            });
        }
        _writer.flush();
    }

private:
    void queue(LogLevel level, std::string text)
    {
        _writer.offer({std::chrono::system_clock::now(), level, std::move(text)});
    }

    const std::shared_ptr<spdlog::logger> _logger;
    mutable std::mutex _mutex; // held for a look-up
    LogLimiter _limiter;
    LogWriter _writer;
};

} // namespace

std::unique_ptr<Log> makeLog(const std::string& level)
{
    return std::make_unique<StandardError>(level);
}

std::string logLine(std::string_view event,
                    std::initializer_list<std::pair<std::string_view, std::string_view>> fields)
{
    std::string line = "event=" + std::string(event);
    for (const auto& [key, value] : fields) {
        line.append(" ").append(key).append("=") += valueText(value);
    }
    return line;
}

} // namespace ig::app
