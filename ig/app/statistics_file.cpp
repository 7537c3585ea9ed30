// SPDX-License-Identifier: MIT
#include "ig/app/statistics_file.h"

#include "ig/app/log.h"
#include "ig/app/output_files.h"
#include "ig/base/thread_signals.h"

#include <utility>

namespace ig::app {

bool StatisticsFile::write(const std::string& path, std::string text)
{
    if (_busy) {
        return false;
    }
    finish();
    _busy = true;
    _thread = std::thread([this, path, content = std::move(text)] {
        leaveSignalsToMain();
        if (const auto written = writeFile(path, content)) {
            _log.write(LogLevel::info, logLine("statistics_written", {{"file", path}}));
        } else {
            _log.write(LogLevel::error,
                       logLine("statistics_failed", {{"reason", written.error().message},
                                                     {"remedy", "make room or change output.stats"}}));
        }
        _busy = false;
    });
    return true;
}

void StatisticsFile::finish()
{
    if (_thread.joinable()) {
        _thread.join();
    }
}

} // namespace ig::app
