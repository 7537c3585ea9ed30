// SPDX-License-Identifier: MIT
#include "ig/selftest/selftest.h"

#include "ig/selftest/cases.h"
#include "ig/selftest/screen.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace ig::selftest {

namespace {

class Folder {
public:
    explicit Folder(std::string path) : _path(std::move(path)) {}
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(_path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

private:
    std::string _path;
};

} // namespace

Result<Outcome> run(const Settings& settings)
{
    using Clock = std::chrono::steady_clock;
    std::error_code error;
    std::string folder = (std::filesystem::temp_directory_path(error) / "eyepoint-selftest-XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr) {
        return fail(ErrorKind::failed, "cannot make " + folder + ": " + std::strerror(errno) +
                                           "; set TMPDIR to a folder with a few MiB of room");
    }
    const Folder removed(folder);
    Outcome outcome;
    std::unique_ptr<Screen> screen;
    if (settings.graphics) {
        auto made = Screen::create(settings.deviceIndex);
        if (!made) {
            return Unexpected{made.error()};
        }
        screen = *std::move(made);
        outcome.target = screen->info().renderer + " / " + screen->info().version;
    }
    Bench bench{outcome.report, screen.get(), folder, settings.rounds};
    constexpr double kRoundS = 60;
    const Clock::time_point begun = Clock::now();
    const auto reportTime = [&](const char* area, Clock::time_point since) {
        const std::chrono::duration<double> taken = Clock::now() - since;
        outcome.report.atMost(area, "all", "time taken", "s", kRoundS * settings.rounds, taken.count());
    };
    using Cases = Result<void> (*)(Bench&);
    for (const auto& [area, cases] :
         std::array<std::pair<const char*, Cases>, 7>{{{"geodesy", geodesyCases},
                                                       {"precision", precisionCases},
                                                       {"attitude", attitudeCases},
                                                       {"terrain", terrainCases},
                                                       {"eyes", eyeCases},
                                                       {"motion", motionCases},
                                                       {"budgets", budgetCases}}}) {
        const Clock::time_point start = Clock::now();
        if (auto done = cases(bench); !done) {
            return fail(done.error().kind, std::string(area) + ": " + done.error().message);
        }
        reportTime(area, start);
    }
    reportTime("all", begun);
    if (screen) {
        outcome.report.atMost("graphics", "all", "errors that the driver reported", "", 0,
                              screen->driverErrors());
    }
    return outcome;
}

} // namespace ig::selftest
