// SPDX-License-Identifier: MIT
// How every program takes its command line: one line for what is wrong, exit code 2, numbers that NaN fails.
// For main() alone.
#pragma once

#include "ig/base/result.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <optional>
#include <string>

namespace ig::app {

// The command line of a program whose options have defaults: --help shows them.
class Program : public CLI::App {
public:
    Program(const std::string& description, const std::string& name) : CLI::App(description, name)
    {
        option_defaults()->always_capture_default();
    }
};

// A number from least to most. CLI::Range lets NaN through.
inline CLI::Validator within(double least, double most)
{
    const std::string limits = CLI::detail::to_string(least) + " to " + CLI::detail::to_string(most);
    const auto check = [=](const std::string& text) {
        double value = 0;
        const bool good = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
        return good ? std::string() : '\'' + text + "' is not a number from " + limits;
    };
    return CLI::Validator(check, limits);
}

// How many frames to stop after.
inline CLI::Validator frameCount()
{
    return within(1, 1e12);
}

// A name: an empty one is a variable of the shell's that was not set, not a wish for the default.
inline CLI::Validator named()
{
    return CLI::Validator([](const std::string& text) { return text.empty() ? "is empty" : std::string(); },
                          "");
}

// Parses. Nothing: go on; else the exit code to end with, and what there was to say has been said. The app
// has the program's name.
inline std::optional<int> parseCommandLine(CLI::App& app, int argc, char** argv)
{
    try {
        app.parse(argc, argv);
        return std::nullopt;
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0)
            return app.exit(error); // --help, --version
        std::fprintf(stderr, "%s: %s; see %s --help\n", app.get_name().c_str(), error.what(),
                     app.get_name().c_str());
        return exitCode(ErrorKind::usage);
    }
}

} // namespace ig::app
