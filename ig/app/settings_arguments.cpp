// SPDX-License-Identifier: MIT
#include "ig/app/settings_arguments.h"

#include <CLI/CLI.hpp>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

namespace ig::app {

namespace {

void setUnlessEmpty(std::string& setting, const std::string& argument)
{
    if (!argument.empty()) {
        setting = argument;
    }
}

} // namespace

void addSettingsOptions(CLI::App& app, SettingsArguments& arguments)
{
    app.add_option("--config", arguments.config, "settings, TOML; config/eyepoint.toml lists every key");
    app.add_option("--terrain", arguments.terrain, "terrain dataset, .ept (terrain.file)");
    // One value each, so that file names may follow.
    app.add_option("--sink", arguments.sinks,
                   "png:DIR, y4m:FILE, raw:FILE, gst:PIPELINE, shm:NAME or null, FILE - is standard output; "
                   "may be repeated (output.sinks); with several views each has its own in the configuration")
        ->allow_extra_args(false);
    app.add_option("--receipts", arguments.receipts,
                   "write a JSON line per frame to this file (output.receipts)");
    app.add_option("--stats", arguments.stats,
                   "write statistics as JSON to this file at the end (output.stats)");
    app.add_option("--set", arguments.assignments, "section.key=value, over the file; may be repeated")
        ->allow_extra_args(false);
}

Result<void> checkDirectoryOf(const std::string& path, const std::string& option)
{
    const auto directory = std::filesystem::absolute(path).parent_path();
    if (access(directory.c_str(), W_OK | X_OK) != 0) {
        return fail(ErrorKind::usage, "cannot write " + path + " (" + option + "): " + directory.string() +
                                          ": " + std::strerror(errno));
    }
    return {};
}

Result<config::Settings> settingsOf(const SettingsArguments& arguments)
{
    config::Settings settings;
    if (!arguments.config.empty()) {
        auto loaded = config::load(arguments.config);
        if (!loaded) {
            return loaded;
        }
        settings = std::move(*loaded);
    }
    for (const std::string& assignment : arguments.assignments) {
        if (auto assigned = config::assign(settings, assignment); !assigned) {
            return Unexpected{assigned.error()};
        }
    }
    setUnlessEmpty(settings.terrain.file, arguments.terrain);
    setUnlessEmpty(settings.host.listen, arguments.listen);
    setUnlessEmpty(settings.host.record, arguments.record);
    setUnlessEmpty(settings.output.stats, arguments.stats);
    setUnlessEmpty(settings.output.receipts, arguments.receipts);
    settings.output.skipIdentical = settings.output.skipIdentical || arguments.skipIdentical;
    if (!arguments.sinks.empty()) {
        settings.output.sinks = arguments.sinks;
    }
    if (auto checked = config::check(settings); !checked && arguments.withTerrain) {
        return Unexpected{checked.error()};
    }
    if (!settings.output.stats.empty()) {
        if (auto writable = checkDirectoryOf(settings.output.stats, "--stats, output.stats"); !writable) {
            return Unexpected{writable.error()};
        }
    }
    return settings;
}

} // namespace ig::app
