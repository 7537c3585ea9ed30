// SPDX-License-Identifier: MIT
#include "ig/app/settings_arguments.h"

#include "ig/app/command_line.h"
#include "ig/app/output_files.h"

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
    app.add_option("--config", arguments.config, "settings, TOML; config/eyepoint.toml lists every key")
        ->check(named());
    app.add_option("--terrain", arguments.terrain, "terrain dataset, .ept (terrain.file)")->check(named());
    // One value each, so that file names may follow.
    app.add_option("--sink", arguments.sinks,
                   "png:DIR, y4m:FILE, raw:FILE, gst:PIPELINE, shm:NAME or null, FILE - is standard output; "
                   "may be repeated (output.sinks); with several views each has its own in the configuration")
        ->allow_extra_args(false);
    app.add_option("--receipts", arguments.receipts,
                   "write a JSON line per frame to this file (output.receipts)")
        ->check(named());
    app.add_option("--stats", arguments.stats,
                   "write statistics as JSON to this file at the end (output.stats)")
        ->check(named());
    app.add_option("--set", arguments.assignments, "section.key=value, over the file; may be repeated")
        ->allow_extra_args(false);
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
    std::vector<NamedFile> written = filesWritten(settings);
    written.push_back({arguments.json, "--json"});
    const NamedFile read[] = {{arguments.config, "--config"}, {settings.terrain.file, "terrain.file"}};
    if (auto apart = checkApart(read, written); !apart) {
        return Unexpected{apart.error()};
    }
    // Statistics and JSON; the others are opened before the flight.
    for (const NamedFile& stored : {written.front(), written.back()}) {
        if (auto writable = checkWritable(stored); !writable) {
            return Unexpected{writable.error()};
        }
    }
    return settings;
}

} // namespace ig::app
