// SPDX-License-Identifier: MIT
// Runs the project's executables as a user would.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

extern char** environ;

namespace test {

inline std::string readFile(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

class Process {
public:
    // Starts BIN/arguments[0]; standard output and error go to files of these names.
    Process(std::vector<std::string> arguments, const std::string& outFile, const std::string& errFile)
    {
        arguments[0] = std::string(EYEPOINT_BIN_DIR) + "/" + arguments[0];
        std::vector<char*> argv;
        for (std::string& argument : arguments) {
            argv.push_back(argument.data());
        }
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 1, outFile.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
        posix_spawn_file_actions_addopen(&actions, 2, errFile.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
        if (posix_spawn(&_pid, argv[0], &actions, nullptr, argv.data(), environ) != 0) {
            _pid = -1;
        }
        posix_spawn_file_actions_destroy(&actions);
    }
    ~Process()
    {
        if (_pid > 0) {
            kill(_pid, SIGKILL);
            waitpid(_pid, nullptr, 0);
        }
    }
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;

    void signal(int number) const { kill(_pid, number); }
    pid_t pid() const noexcept { return _pid; }

    // Exit code; 128 + the signal's number when one ended it; -1 when it never ran or takes longer than
    // timeoutS, and is killed.
    int wait(double timeoutS)
    {
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeoutS);
        while (_pid > 0 && std::chrono::steady_clock::now() < deadline) {
            int status = 0;
            if (waitpid(_pid, &status, WNOHANG) == _pid) {
                _pid = -1;
                return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return -1;
    }

private:
    pid_t _pid = -1;
};

// Waits until the file contains the text; false after timeoutS.
inline bool waitForText(const std::string& path, const std::string& text, double timeoutS)
{
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeoutS);
    while (std::chrono::steady_clock::now() < deadline) {
        if (readFile(path).find(text) != std::string::npos) {
            return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
}

} // namespace test
