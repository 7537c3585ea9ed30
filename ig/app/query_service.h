// SPDX-License-Identifier: MIT
// Answers what the host asks: height above and of terrain, lines of sight, positions, the weather at a point.
//
// Rules
//   when       A request is answered in the frame that takes it if the terrain at hand allows, else when the
//   finest
//              has been read, but after kMostFrames with the best there is, and a line of sight that is
//              longer than kLastFrame allows to walk meets nothing: an answer always comes. Points on
//              entities are where the entities are in the frame that answers. Work per frame is bounded; what
//              is left is next in the following frame.
//   repeated   A period of n answers every n-th frame, until the same id is asked again or its entity is
//   gone. ground     Only terrain is hit: no entities, one intersection, material code 0. Heights are those
//   of the
//              terrain as drawn, in the datum of the host's altitudes.
//   valid      0 outside the terrain, in its holes, about an entity that is not there, or when nothing is
//   hit. positions  Of entities and views, geodetic. Articulated parts, groups, trackers and other frames get
//   no answer. weather    Air as ig/scene/environment.h blends it. Water, ground and aerosols get no answer.
#pragma once

#include "hostif/session.h"
#include "ig/geo/ground_queries.h"
#include "ig/scene/world.h"

#include <variant>
#include <vector>

namespace ig::app {

struct QueryStats {
    uint64_t requests = 0;
    uint64_t answers = 0;
    uint64_t coarse = 0;     // answers from other than the finest posts
    uint64_t unanswered = 0; // too many at once, or of a kind that is not answered
};

class QueryService {
public:
    static constexpr size_t kMostRequests = 2048; // waiting or repeated
    static constexpr int kMostFrames = 30;        // that an answer may take
    static constexpr int kLastFrame = 600;
    static constexpr int kHeightsPerFrame = 512;
    static constexpr int kSightsPerFrame = 4; // calls, each of bounded work

    QueryService();

    // What is asked from now on; null: no ground, all answers about it are invalid.
    void setGround(GroundQueries* ground) noexcept { _ground = ground; }

    // Takes a request; everything else passes by.
    void take(const hostif::SessionEvent& event);
    // Hands this frame's answers to the session. timeS: of the world that is drawn.
    void answer(const scene::World& world, double timeS, hostif::Session& session);

    const QueryStats& stats() const noexcept { return _stats; }

private:
    using Request = std::variant<hostif::HatHotRequest, hostif::LosSegmentRequest, hostif::LosVectorRequest,
                                 hostif::PositionRequest, hostif::EnvironmentRequest>;
    struct Waiting {
        Request request;
        int period = 0;       // frames, 0: once
        int frames = 0;       // until it is due
        int waited = 0;       // frames since it was due
        double progressM = 0; // of a line of sight
    };
    enum class Outcome : uint8_t { answered, later, gone };
    struct Context {
        const scene::World& world;
        double timeS;
        hostif::Session& session;
    };

    void add(const Request& request, int period);
    bool hasBudget(const Request& request);
    Outcome serve(Waiting& waiting, const Context& in);
    Outcome serveOne(const hostif::HatHotRequest& request, Waiting& waiting, const Context& in);
    Outcome serveOne(const hostif::LosSegmentRequest& request, Waiting& waiting, const Context& in);
    Outcome serveOne(const hostif::LosVectorRequest& request, Waiting& waiting, const Context& in);
    Outcome serveOne(const hostif::PositionRequest& request, Waiting& waiting, const Context& in);
    Outcome serveOne(const hostif::EnvironmentRequest& request, Waiting& waiting, const Context& in);
    Known firstHit(const EcefPos& from, const EcefPos& to, Waiting& waiting, GroundHit& hit);
    void note(const Ground& ground);

    GroundQueries* _ground = nullptr;
    std::vector<Waiting> _waiting; // in the order taken
    size_t _next = 0;              // whose turn it is
    int _heightsLeft = 0, _sightsLeft = 0;
    QueryStats _stats;
};

} // namespace ig::app
