// SPDX-License-Identifier: MIT
// The command line of programs that draw, as settings: what --config reads, then --set, then the options with
// names of their own.
#pragma once

#include "config/settings.h"

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace ig::app {

struct SettingsArguments {
    std::string config, terrain, stats, receipts;
    std::vector<std::string> sinks, assignments;
    std::string listen, record; // options of eyepoint-ig alone
    std::string json;           // of its --explain and --selftest; empty: the table on standard output
    bool skipIdentical = false;
    bool withTerrain = true; // false: the program brings its own, whatever the settings lack
};

// --config, --terrain, --sink, --receipts, --stats and --set. arguments must outlive app's parsing.
void addSettingsOptions(CLI::App& app, SettingsArguments& arguments);

// Checked settings. Errors (usage): as config::load, assign and check; statistics or JSON that cannot be
// written, a file that is to be written but is read, or written twice.
Result<config::Settings> settingsOf(const SettingsArguments& arguments);

} // namespace ig::app
