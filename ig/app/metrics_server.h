// SPDX-License-Identifier: MIT
// Answers GET /metrics over HTTP/1.1 on a loopback port, on a thread of its own. Bounded: one connection at a
// time, requests up to 4 KiB, a quarter of a second for each; what is slower or larger is closed. Small
// enough to be our own: an HTTP library would bring TLS and compression into the program for one page of
// text.
#pragma once

#include "hostif/address.h"
#include "ig/app/metrics.h"
#include "ig/base/result.h"

#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace ig::app {

class MetricsServer {
public:
    // address: "127.0.0.1:9464" or "[::1]:9464"; port 0 takes any free one. Errors: (usage) not an address,
    // not one of the loopback; (addressInUse) the port is taken.
    static Result<std::unique_ptr<MetricsServer>> start(const std::string& address, MetricsLabels labels);
    ~MetricsServer();
    MetricsServer(const MetricsServer&) = delete;
    MetricsServer& operator=(const MetricsServer&) = delete;

    // Hands over a state of the counters; never waits: while one is being read, this one is left out.
    void offer(const Metrics& metrics) noexcept;

    const hostif::Address& local() const noexcept { return _local; }

private:
    MetricsServer(int listener, int stopEvent, const hostif::Address& local, MetricsLabels labels);
    void run();
    void serve(int connection);
    std::string answer(const std::string& request);

    const int _listener;
    const int _stopEvent; // eventfd, readable at the end
    const hostif::Address _local;
    const MetricsLabels _labels;
    std::mutex _mutex; // held for a copy
    Metrics _metrics;
    std::thread _thread;
};

} // namespace ig::app
