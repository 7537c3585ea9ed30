// SPDX-License-Identifier: MIT
#include "ig/app/metrics.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace ig::app {

namespace {

class Text {
public:
    void head(const char* name, const char* type, const char* help)
    {
        fmt::format_to(end(), "# HELP eyepoint_{} {}\n# TYPE eyepoint_{} {}\n", name, help, name, type);
    }
    template <class Number>
    void value(const char* name, Number number, const std::string& labels = "")
    {
        fmt::format_to(end(), "eyepoint_{}{} {}\n", name, labels.empty() ? labels : "{" + labels + "}",
                       number);
    }
    template <class Number>
    void counter(const char* name, Number number, const char* help)
    {
        head(name, "counter", help);
        value(name, number);
    }
    template <class Number>
    void gauge(const char* name, Number number, const char* help)
    {
        head(name, "gauge", help);
        value(name, number);
    }
    void histogram(const char* name, const StepHistogram& steps, const std::string& label)
    {
        uint64_t sum = 0;
        for (size_t i = 0; i < steps.count.size(); ++i) {
            sum += steps.count[i];
            const std::string edge =
                i < StepHistogram::kUpToS.size() ? fmt::format("{}", StepHistogram::kUpToS[i]) : "+Inf";
            fmt::format_to(end(), "eyepoint_{}_bucket{{{},le=\"{}\"}} {}\n", name, label, edge, sum);
        }
        fmt::format_to(end(), "eyepoint_{0}_sum{{{1}}} {2}\neyepoint_{0}_count{{{1}}} {3}\n", name, label,
                       steps.sumS, sum);
    }
    std::string take() { return std::move(_text); }

private:
    std::back_insert_iterator<std::string> end() { return std::back_inserter(_text); }
    std::string _text;
};

std::string viewLabel(uint16_t id)
{
    return fmt::format("view=\"{}\"", id);
}

std::string sinkLabel(const MetricsLabels::Sink& sink)
{
    std::string label = viewLabel(sink.view) + ",sink=\"";
    for (const char c : sink.name) {
        if (c == '\n') {
            label += "\\n";
            continue;
        }
        if (c == '"' || c == '\\') {
            label += '\\';
        }
        label += c;
    }
    return label + "\"";
}

uint64_t residentBytes()
{
    unsigned long pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
        if (std::fscanf(file, "%*s %lu", &pages) != 1) {
            pages = 0;
        }
        std::fclose(file);
    }
    return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

} // namespace

void StepHistogram::add(int64_t durationNs) noexcept
{
    const double durationS = static_cast<double>(std::max<int64_t>(durationNs, 0)) * 1e-9;
    const auto* step = std::lower_bound(kUpToS.begin(), kUpToS.end(), durationS);
    ++count[static_cast<size_t>(step - kUpToS.begin())];
    sumS += durationS;
}

void ViewMetrics::add(const FrameStats& frame) noexcept
{
    ++frames;
    frameTime.add(frame.frameNs);
    sinkTime.add(frame.sinkNs);
    if (frame.transportDelayNs >= 0) {
        transportDelay.add(frame.transportDelayNs);
    }
    handedOut.add(frame.handedOutNs);
    framesWithMissingTiles += frame.lod.tilesMissing > 0 ? 1 : 0;
    pageIns += frame.pageIns;
    bytesUploaded += frame.bytesUploaded;
    triangles = frame.lod.triangles;
    tauPx = frame.lod.tauPx;
    errorPx = frame.lod.errorPx;
}

void Metrics::note(const hostif::SessionStats& host) noexcept
{
    datagrams = host.datagrams;
    accepted = host.accepted;
    lost = host.lost;
    late = host.late;
    refused = host.datagrams - host.accepted;
}

Metrics metricsFor(const MetricsLabels& labels)
{
    Metrics metrics;
    metrics.views.resize(labels.views.size());
    metrics.sinks.resize(labels.sinks.size());
    return metrics;
}

namespace {

// A series of each view.
template <class Value>
void ofViews(Text& text, const Metrics& m, const MetricsLabels& labels, const char* name, const char* type,
             const char* help, Value value)
{
    text.head(name, type, help);
    for (size_t i = 0; i < std::min(m.views.size(), labels.views.size()); ++i) {
        text.value(name, value(m.views[i]), viewLabel(labels.views[i]));
    }
}

void ofViews(Text& text, const Metrics& m, const MetricsLabels& labels, const char* name, const char* help,
             StepHistogram ViewMetrics::*steps)
{
    text.head(name, "histogram", help);
    for (size_t i = 0; i < std::min(m.views.size(), labels.views.size()); ++i) {
        text.histogram(name, m.views[i].*steps, viewLabel(labels.views[i]));
    }
}

void viewsText(Text& text, const Metrics& m, const MetricsLabels& labels)
{
    const auto counter = [&](const char* name, auto member, const char* help) {
        ofViews(text, m, labels, name, "counter", help, [=](const ViewMetrics& v) { return v.*member; });
    };
    const auto gauge = [&](const char* name, auto member, const char* help) {
        ofViews(text, m, labels, name, "gauge", help, [=](const ViewMetrics& v) { return v.*member; });
    };
    counter("frames_total", &ViewMetrics::frames, "Frames drawn.");
    counter("missed_frames_total", &ViewMetrics::missedFrames, "Periods without a frame of their own.");
    ofViews(text, m, labels, "frame_seconds", "Time a frame took.", &ViewMetrics::frameTime);
    ofViews(text, m, labels, "sink_seconds", "Time a frame took to be handed out.", &ViewMetrics::sinkTime);
    ofViews(text, m, labels, "transport_delay_seconds",
            "From the kernel's receipt of a host message to its frame handed out.",
            &ViewMetrics::transportDelay);
    ofViews(text, m, labels, "handed_out_seconds", "From the start of its slot to a frame handed out.",
            &ViewMetrics::handedOut);
    gauge("triangles", &ViewMetrics::triangles, "Triangles of the newest frame.");
    gauge("triangle_budget", &ViewMetrics::triangleBudget, "Triangles that a frame may have.");
    gauge("tolerance_pixels", &ViewMetrics::tauPx, "Tolerance that the budget allowed, newest frame.");
    gauge("error_pixels", &ViewMetrics::errorPx, "Bound of the projected error, newest frame.");
    counter("frames_with_missing_tiles_total", &ViewMetrics::framesWithMissingTiles,
            "Frames with tiles drawn by an ancestor.");
    counter("page_ins_total", &ViewMetrics::pageIns, "Terrain pages loaded.");
    counter("uploaded_bytes_total", &ViewMetrics::bytesUploaded, "Bytes handed to the GPU for pages.");
}

} // namespace

std::string metricsText(const Metrics& m, const MetricsLabels& labels)
{
    Text text;
    viewsText(text, m, labels);
    text.counter("host_datagrams_total", m.datagrams, "Datagrams received.");
    text.counter("host_accepted_total", m.accepted, "Datagrams accepted.");
    text.counter("host_refused_total", m.refused, "Datagrams not accepted.");
    text.counter("host_lost_total", m.lost, "Host messages that never came.");
    text.counter("host_late_total", m.late, "Host messages that came too late.");
    text.counter("log_suppressed_total", m.logSuppressed, "Log lines left out for their rate.");
    text.counter("log_dropped_total", m.logDropped, "Log lines lost because standard error was slow.");
    text.gauge("resident_bytes", residentBytes(), "Memory held.");
    const size_t sinks = std::min(m.sinks.size(), labels.sinks.size());
    text.head("sink_written_total", "counter", "Frames that a sink stored or published.");
    for (size_t i = 0; i < sinks; ++i) {
        text.value("sink_written_total", m.sinks[i].stats.written, sinkLabel(labels.sinks[i]));
    }
    text.head("sink_dropped_total", "counter", "Frames that a sink had no room for.");
    for (size_t i = 0; i < sinks; ++i) {
        text.value("sink_dropped_total", m.sinks[i].stats.dropped, sinkLabel(labels.sinks[i]));
    }
    text.head("sink_up", "gauge", "1 while a sink works, 0 once it has ended.");
    for (size_t i = 0; i < sinks; ++i) {
        text.value("sink_up", m.sinks[i].lives ? 1 : 0, sinkLabel(labels.sinks[i]));
    }
    return text.take();
}

} // namespace ig::app
