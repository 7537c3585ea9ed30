// SPDX-License-Identifier: MIT
#include "tools/replay/report.h"

namespace replay {

std::vector<std::string> complaints(const Recording& recording)
{
    std::vector<std::string> lines;
    for (const std::string& damage : recording.damage())
        lines.push_back(damage + "; what is before that is used");
    const PassedOver& passed = recording.passedOver();
    const auto add = [&](uint64_t count, const std::string& what) {
        if (count > 0)
            lines.push_back(std::to_string(count) + " " + what);
    };
    add(passed.fragments, "fragments of IP packets passed over: capture where the host sends, or let it send "
                          "smaller datagrams");
    add(passed.cutShort, "datagrams passed over that were captured in part: capture with tcpdump -s 0");
    add(passed.others, "packets passed over that are not UDP");
    add(recording.elsewhere(), "datagrams passed over that went elsewhere");
    return lines;
}

ig::Unexpected<ig::Error> nothingThere(const std::vector<std::string>& files)
{
    std::string names;
    for (const std::string& file : files)
        names += (names.empty() ? "" : ", ") + file;
    return ig::fail(ig::ErrorKind::failed,
                    names +
                        ": no datagram of a host in it; look at it with tshark -r, and name the port that "
                        "the image generator listened on with --port");
}

} // namespace replay
