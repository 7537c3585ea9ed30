// SPDX-License-Identifier: MIT
// The session: memory.
#include "counted_new.h"
#include "hostif_talk.h"

using namespace test;

TEST_CASE("a warm session allocates nothing")
{
    Talk t;
    const Bytes good = encode({.frame = 1, .entities = 50});
    std::vector<Bytes> later;
    for (uint32_t frame = 2; frame < 200; ++frame)
        later.push_back(encode({.frame = frame, .entities = frame % 50}));
    const Bytes bad = test::fromHex("01 18 03 00");
    t.session.receive(good, kHost, 100);
    t.session.takeEvents();
    t.session.startOfFrame(100);
    const size_t before = allocations();
    for (const Bytes& message : later) {
        t.session.receive(message, kHost, 100);
        t.session.receive(bad, kHost, 100);
        t.session.takeEvents();
        t.session.startOfFrame(100);
    }
    const size_t after = allocations();
    CHECK(after == before);
    CHECK(t.session.stats().accepted == 199);
}
