// SPDX-License-Identifier: MIT
#include "ig/scene/world.h"
#include "ig/selftest/cases.h"
#include "ig/selftest/surface.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>

namespace ig::selftest {

namespace {

constexpr const char* kArea = "motion";
constexpr uint32_t kBudget = 4'000;
constexpr double kRateHz = 60;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool same(const ViewState& a, const ViewState& b)
{
    return a.eye.m == b.eye.m && a.eyeFromEcef == b.eyeFromEcef;
}

ViewState over(const Ground& ground, double col, double row, double heightM, const YawPitchRoll& attitude)
{
    return viewOf(ground, {col, row, heightM, attitude});
}

bool same(const lod::DrawList& a, const lod::DrawList& b)
{
    return a.items == b.items && a.indices == b.indices && a.usedPages == b.usedPages &&
           a.morph.reach == b.morph.reach && a.morph.cutM == b.morph.cutM && a.stats.tauPx == b.stats.tauPx &&
           a.stats.errorPx == b.stats.errorPx;
}

// A selection that should not change.
struct Standing {
    Standing(const Ground& ground, const ViewState& first, lod::Method method, bool morph, int everyFrames)
        : name(std::string(nameOf(method)) + (morph ? "" : ", no morph")), every(everyFrames),
          selector(ground.selector({.method = method, .triangleBudget = kBudget, .morph = morph}))
    {
        // Tiles on the way arrive within a second or two.
        const int arriving = method == lod::Method::geomip && morph ? 300 : 1;
        for (int selection = 0; selection < arriving; ++selection) {
            selector->select(first, list);
        }
        firstList = list;
    }
    void frame(int number, const ViewState& view)
    {
        if (number % every != 0) {
            return;
        }
        selector->select(view, list);
        redrawn += same(list, firstList) ? 0 : 1;
        work += list.stats.verticesEvaluated + list.stats.listsMade;
    }

    std::string name;
    int every;
    std::unique_ptr<lod::Selector> selector;
    lod::DrawList list, firstList;
    size_t redrawn = 0;
    uint64_t work = 0;
};

// A host that says the same sixty times a second, for an hour of a clock that does not wait.
void anHour(Report& report, const Ground& ground)
{
    constexpr const char* kName = "standing still for an hour";
    constexpr int kFrames = 60 * 60 * 60;
    scene::World world(ground.shape().ellipsoid, {});
    world.set(scene::Extrapolation{true, 0.25});
    world.allowExtrapolation(0, true);
    scene::EntityState entity;
    entity.position = toGeodetic(over(ground, 90, 100, ground.largestHeightM() + 300, {}).eye);
    entity.attitude = {1.0, -0.3, -0.2};
    (void)world.set(entity, 0);
    (void)world.set(0, scene::Rates{}, 0);
    const ViewState first = *world.viewState(0, 640, 480, 0.0);
    std::vector<Standing> all;
    all.emplace_back(ground, first, lod::Method::hybrid, true, 1);
    all.emplace_back(ground, first, lod::Method::bintree, true, 1);
    // Once a second: a method without live ranges begins anew in each frame.
    all.emplace_back(ground, first, lod::Method::geomip, true, 60);
    all.emplace_back(ground, first, lod::Method::geomip, false, 60);
    size_t moved = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        const double timeS = frame / kRateHz;
        (void)world.set(entity, timeS);
        const auto view = world.viewState(0, 640, 480, timeS + 1.5 / kRateHz);
        moved += view && same(*view, first) ? 0 : 1;
        for (Standing& each : all) {
            each.frame(frame, view.value_or(first));
        }
    }
    report.atMost(kArea, kName, "frames whose pose differs from the first", "", 0,
                  static_cast<double>(moved));
    for (const Standing& each : all) {
        report.atMost(kArea, std::string(kName) + ", " + each.name,
                      "frames that draw, or state, something else", "", 0, static_cast<double>(each.redrawn));
        report.atMost(kArea, std::string(kName) + ", " + each.name,
                      "vertices evaluated and lists made after the first", "", 0,
                      static_cast<double>(each.work));
    }
}

// What is drawn is examined, too.
void standing(Bench& bench, const Ground& ground)
{
    const ViewState view = over(ground, 90, 100, ground.largestHeightM() + 300, {0.5, -0.3, 0.0});
    Findings findings;
    lod::DrawList list;
    size_t changed = 0;
    uint32_t evaluated = 0;
    for (const lod::Method method : kMethods) {
        const auto selector = ground.selector({.method = method, .triangleBudget = kBudget});
        select(ground, *selector, view, list, findings);
        const lod::DrawList first = list;
        for (int frame = 1; frame < 600 * bench.rounds; ++frame) {
            select(ground, *selector, view, list, findings);
            changed += same(list, first) ? 0 : 1;
            evaluated += list.stats.verticesEvaluated + list.stats.listsMade;
        }
        findings.examine(ground, view, list, kBudget);
    }
    bench.report.atMost(kArea, "standing still", "frames that draw something else", "", 0,
                        static_cast<double>(changed));
    bench.report.atMost(kArea, "standing still", "vertices evaluated and lists made after the first", "", 0,
                        evaluated);
    findings.report(bench.report, kArea, "standing still");
}

// Frames of one way, examined now and then. morphs: something has to be on its way in some of them.
template <class ViewAt>
void fly(Bench& bench, const Ground& ground, const char* name, int frames, int examineEvery,
         const ViewAt& viewAt, bool morphs = false)
{
    lod::DrawList list;
    for (const lod::Method method : kMethods) {
        Findings findings;
        const auto selector = ground.selector({.method = method, .triangleBudget = kBudget});
        for (int frame = 0; frame < frames; ++frame) {
            const ViewState view = viewAt(frame);
            select(ground, *selector, view, list, findings);
            findings.budgetShare =
                std::max(findings.budgetShare, static_cast<double>(list.stats.triangles) / kBudget);
            if (frame % examineEvery == examineEvery - 1) {
                findings.examine(ground, view, list, kBudget);
            }
        }
        const std::string full = std::string(name) + ", " + nameOf(method);
        findings.report(bench.report, kArea, full);
        if (morphs) {
            bench.report.atLeast(kArea, full, "corners drawn on their way", "", 1,
                                 static_cast<double>(findings.onTheirWay));
        }
    }
}

// What is kept from frame to frame draws what a selection without a past draws.
void liveRanges(Bench& bench, const Ground& ground)
{
    for (const auto& [name, method] :
         {std::pair<const char*, lod::Method>{"turns at 250 m/s, hybrid", lod::Method::hybrid},
          std::pair<const char*, lod::Method>{"turns at 250 m/s, bintree", lod::Method::bintree}}) {
        const auto live = ground.selector({.method = method, .triangleBudget = kBudget});
        const auto plain =
            ground.selector({.method = method, .triangleBudget = kBudget, .liveRanges = false});
        lod::DrawList a, b;
        size_t differing = 0;
        uint64_t evaluated = 0, all = 0;
        for (int frame = 0; frame < 150 * bench.rounds; ++frame) {
            // A circle of 2 km; 4.2 m a frame.
            const double turn = frame * 4.2 / 1'000;
            const ViewState view = over(ground, 96 + 20 * std::sin(turn), 96 - 20 * std::cos(turn),
                                        ground.largestHeightM() + 150, {turn + 0.5 * kPi, -0.15, 0.4});
            live->select(view, a);
            plain->select(view, b);
            differing += a.indices == b.indices && a.morph.reach == b.morph.reach ? 0 : 1;
            if (frame > 0) {
                evaluated += a.stats.verticesEvaluated;
                all += b.stats.verticesEvaluated;
            }
        }
        bench.report.atMost(kArea, name, "frames that differ from everything evaluated", "", 0,
                            static_cast<double>(differing));
        bench.report.atMost(kArea, name, "vertices evaluated / everything", "", 0.2,
                            static_cast<double>(evaluated) / static_cast<double>(std::max<uint64_t>(all, 1)));
    }
}

// A tile is 16 posts of 50 m; forth and back in turn, frame by frame.
void vibration(Bench& bench, const Ground& ground)
{
    const auto viewAt = [&](int frame) {
        return over(ground, frame % 2 == 0 ? 80 : 96, 100, ground.largestHeightM() + 200, {0.5, -0.2, 0.0});
    };
    fly(bench, ground, "vibration of a tile's length", 120, 40, viewAt);
    for (const auto& [name, method] :
         {std::pair<const char*, lod::Method>{"vibration of a tile's length, hybrid", lod::Method::hybrid},
          std::pair<const char*, lod::Method>{"vibration of a tile's length, bintree",
                                              lod::Method::bintree}}) {
        const auto selector = ground.selector({.method = method, .triangleBudget = kBudget});
        lod::DrawList list;
        // Without live ranges all lists are made in each trial of tau.
        ground.selector({.method = method, .triangleBudget = kBudget, .liveRanges = false})
            ->select(viewAt(0), list);
        const double fromScratch = static_cast<double>(list.stats.listsMade) / list.stats.trials;
        selector->select(viewAt(0), list);
        constexpr int kSettling = 600;
        constexpr int kMeasured = 240; // tau comes round in less
        std::array<double, 2> least{1e30, 1e30};
        std::array<double, 2> most{0, 0};
        uint32_t lists = 0;
        for (int frame = 1; frame < kSettling + kMeasured; ++frame) {
            selector->select(viewAt(frame), list);
            if (frame >= kSettling) {
                const auto end = static_cast<size_t>(frame % 2);
                least[end] = std::min<double>(least[end], list.stats.tauPx);
                most[end] = std::max<double>(most[end], list.stats.tauPx);
                lists += list.stats.listsMade;
            }
        }
        // Ground that comes into view in one piece is a step of this size for the budget.
        bench.report.atMost(kArea, name, "spread of tau over the last four seconds", "", 0.1,
                            std::max(most[0] / least[0], most[1] / least[1]) - 1);
        // The eye does see another tile's length in each frame, but not another terrain.
        bench.report.atMost(kArea, name, "lists made in a frame, mean / from scratch", "", 0.75,
                            lists / (kMeasured * fromScratch));
    }
}

void flights(Bench& bench, const Ground& ground)
{
    const double top = ground.largestHeightM();
    constexpr bool kMorphs = true;
    fly(
        bench, ground, "1,000 m/s at 150 m", 180, 15,
        [&](int frame) {
            return over(ground, 40 + 0.333 * frame, 96, top + 150, {0.5 * kPi, -0.1, 0.0});
        },
        kMorphs);
    // Mach 25 is 8,575 m/s at sea level: 143 m or 2.9 posts a frame.
    fly(bench, ground, "Mach 25 at 100 m", 60, 6, [&](int frame) {
        return over(ground, 10 + 2.86 * frame, 96, top + 100, {0.5 * kPi, -0.1, 0.0});
    });
    std::mt19937 random(5);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<ViewState> places;
    for (int i = 0; i < 40 * bench.rounds; ++i) {
        places.push_back(over(ground, 192 * share(random), 192 * share(random),
                              top + 10 + std::pow(10.0, 4 * share(random)),
                              {2 * kPi * share(random), -1.5 * share(random), kPi * (share(random) - 0.5)}));
    }
    fly(bench, ground, "a teleport every frame", static_cast<int>(places.size()), 8,
        [&](int frame) { return places[static_cast<size_t>(frame)]; });
    fly(bench, ground, "turning at 1,000 deg/s", 108, 9, [&](int frame) {
        return over(ground, 96, 96, top + 150, {1'000 * kRadPerDeg * frame / kRateHz, -0.2, 0.3});
    });
    fly(bench, ground, "rolling at 1,000 deg/s", 36, 6, [&](int frame) {
        return over(ground, 96, 96, top + 150, {1.0, -0.3, 1'000 * kRadPerDeg * frame / kRateHz});
    });
}

// A host's entity that flies at 300 m/s over a ground, as it is drawn at times of the clock.
class Flown {
public:
    static constexpr double kHorizonS = 0.25;
    static constexpr double kSpeedMps = 300;

    explicit Flown(const Ground& ground) : _world(ground.shape().ellipsoid, {})
    {
        _world.set(scene::Extrapolation{true, kHorizonS});
        _world.allowExtrapolation(0, true);
        _entity.position = toGeodetic(over(ground, 60, 100, ground.largestHeightM() + 200, {}).eye);
        _entity.attitude = {0.5 * kPi, -0.15, 0};
    }
    // The host says where it is, so far from where it started.
    void place(double wayM, double timeS)
    {
        scene::EntityState entity = _entity;
        entity.position.longitudeRad += wayM / (kWgs84.semiMajorM * std::cos(_entity.position.latitudeRad));
        _start = toEcef(entity.position).m;
        (void)_world.set(entity, timeS);
        (void)_world.set(0, scene::Rates{false, {kSpeedMps, 0, 0}, {0, 0, 0}}, timeS);
    }
    ViewState at(double timeS) const
    {
        std::optional<ViewState> view = _world.viewState(0, 640, 480, timeS);
        if (!view) {
            view.emplace().eye.m = glm::dvec3(kNan);
        }
        return *view;
    }
    double wayM(double timeS) const { return glm::length(at(timeS).eye.m - _start); }

private:
    scene::World _world;
    scene::EntityState _entity;
    glm::dvec3 _start{0.0};
};

void timeGoingBackwards(Bench& bench, const Ground& ground)
{
    constexpr const char* kName = "time going backwards";
    constexpr double kStartS = 1'000;
    Flown flown(ground);
    flown.place(0, kStartS);
    double back = 0;
    for (const double timeS : {999.0, 1.0, 0.0, -1e9, kNan}) {
        const double wayM = flown.wayM(timeS);
        back = wayM <= back ? back : wayM;
    }
    bench.report.atMost(kArea, kName, "way from where the host put it", "m", 0, back);
    // Twice round the same times, and once more by each method.
    constexpr int kTurn = 20;
    const auto timeOf = [](int frame) {
        return kStartS + (frame < kTurn ? frame : 2 * kTurn - frame) / kRateHz;
    };
    size_t differing = 0;
    for (int frame = 0; frame < kTurn; ++frame) {
        differing += same(flown.at(timeOf(frame)), flown.at(timeOf(2 * kTurn - frame))) ? 0 : 1;
    }
    bench.report.atMost(kArea, kName, "poses that differ from those on the way there", "", 0,
                        static_cast<double>(differing));
    fly(bench, ground, kName, 3 * kTurn, 6, [&](int frame) { return flown.at(timeOf(frame)); });
}

void aGap(Bench& bench, const Ground& ground)
{
    constexpr const char* kName = "a gap of 10 s at 300 m/s";
    constexpr double kGapS = 10;
    Flown flown(ground);
    flown.place(0, 0);
    bench.report.atMost(kArea, kName, "way beyond the horizon of 0.25 s", "m", 1e-3,
                        std::abs(flown.wayM(kGapS) - Flown::kSpeedMps * Flown::kHorizonS));
    bench.report.atMost(kArea, kName, "way from second to second of the gap", "m", 0,
                        glm::length(flown.at(kGapS - 1).eye.m - flown.at(kGapS).eye.m));
    // The frames before it, two within, and those from the host's next word on, 3 km farther.
    constexpr int kBefore = 12;
    fly(bench, ground, kName, 3 * kBefore, 3, [&](int frame) {
        const double sinceS = (frame - kBefore - 2) / kRateHz;
        if (frame < kBefore) {
            flown.place(0, 0);
            return flown.at(frame / kRateHz);
        }
        if (sinceS < 0) {
            return flown.at(kGapS / 2);
        }
        flown.place(Flown::kSpeedMps * kGapS, kGapS);
        return flown.at(kGapS + sinceS);
    });
}

} // namespace

Result<void> motionCases(Bench& bench)
{
    const GroundPlan plan{"hills", 193, 193, placeAround(46.0, 9.0, 193, 193), [](uint32_t c, uint32_t r) {
                              return 500 + 400 * std::sin(c * 0.09) * std::cos(r * 0.07) +
                                     70 * std::sin(c * 0.7 + r * 0.5);
                          }};
    const auto ground = Ground::make(plan, bench.folder);
    if (!ground) {
        return Unexpected{ground.error()};
    }
    anHour(bench.report, *ground);
    standing(bench, *ground);
    flights(bench, *ground);
    liveRanges(bench, *ground);
    vibration(bench, *ground);
    timeGoingBackwards(bench, *ground);
    aGap(bench, *ground);
    return {};
}

} // namespace ig::selftest
