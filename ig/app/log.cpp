// SPDX-License-Identifier: MIT
#include "ig/app/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

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

class StandardError final : public LogSink {
public:
    explicit StandardError(const std::string& level)
        : _logger("eyepoint-ig", std::make_shared<spdlog::sinks::stderr_sink_mt>())
    {
        _logger.set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
        _logger.set_level(spdlog::level::from_str(level));
    }
    void write(LogLevel level, std::string_view line) override { _logger.log(levelOf(level), line); }

private:
    spdlog::logger _logger;
};

} // namespace

std::unique_ptr<LogSink> makeLog(const std::string& level)
{
    return std::make_unique<StandardError>(level);
}

} // namespace ig::app
