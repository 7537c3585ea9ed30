// SPDX-License-Identifier: MIT
// Encodes a host message and reads it back, through the installed headers and library alone.
#include <hostif/cigi33.h>

#include <cstdio>
#include <vector>

int main()
{
    hostif::IgControl control;
    control.hostFrameNumber = 42;
    std::vector<std::byte> bytes;
    hostif::cigi33::append(bytes, hostif::ByteOrder::big, control);
    hostif::HostDatagram datagram;
    if (!hostif::cigi33::decodeHost(bytes, datagram) || datagram.control.hostFrameNumber != 42) {
        std::puts("the installed library does not read what it writes");
        return 1;
    }
    std::puts("the installed package works");
    return 0;
}
