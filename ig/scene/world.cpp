// SPDX-License-Identifier: MIT
#include "ig/scene/world.h"

#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace ig::scene {

namespace {

// Beyond this a tangent says nothing any more that a picture could show.
constexpr double kWidestRad = 89.9 * kRadPerDeg;
constexpr double kNarrowestRad = 1e-6;

void assignIf(double& target, const std::optional<double>& value)
{
    if (value) {
        target = *value;
    }
}

// Some hosts send the magnitudes of left and bottom: read them as what they must mean.
void orient(double& low, double high)
{
    if (low >= high) {
        low = -std::abs(low);
    }
}

// Columns forward, right and down of a body of that heading that lies flat on a slope, turned back by the
// heading: what is level on the slope becomes what it is from the horizon. normal: NED, upwards.
glm::dmat3 horizonFromSlope(double yawRad, const glm::dvec3& normal)
{
    const double c = std::cos(yawRad);
    const double s = std::sin(yawRad);
    const glm::dvec3 down = -normal;
    const glm::dvec3 forward = glm::normalize(glm::dvec3(c, s, -(normal.x * c + normal.y * s) / normal.z));
    const glm::dmat3 slope(forward, glm::cross(down, forward), down);
    return slope * glm::transpose(glm::dmat3{glm::dvec3{c, s, 0}, glm::dvec3{-s, c, 0}, glm::dvec3{0, 0, 1}});
}

bool drawable(double low, double high)
{
    return low >= -kWidestRad && high <= kWidestRad && high - low >= kNarrowestRad;
}

} // namespace

World::World(const Ellipsoid& ellipsoid, const ViewDefaults& defaults)
    : _ellipsoid(ellipsoid), _defaults(defaults), _slotOfEntity(65536, kNone), _mayMove(65536, false),
      _environment(ellipsoid, defaults.visibilityM)
{
    _entities.reserve(kEntities);
    _doomed.reserve(kEntities);
    _views.reserve(kViews);
}

void World::setDefaults(uint16_t view, const ViewDefaults& defaults)
{
    _ownDefaults.emplace_back(view, defaults);
}

void World::reset()
{
    for (const Entity& entity : _entities) {
        _slotOfEntity[entity.state.id] = kNone;
    }
    _entities.clear();
    _clamped = 0;
    _views.clear();
    std::fill(_mayMove.begin(), _mayMove.end(), false);
    _environment.reset();
}

Applied World::set(const EntityState& state, double timeS)
{
    const int16_t slot = slotOf(state.id);
    if (state.attached) {
        const int16_t parent = slotOf(state.parent);
        if (parent == kNone || state.parent == state.id || (slot != kNone && descends(parent, slot))) {
            return Applied::noParent;
        }
    }
    EntityState wanted = state;
    wanted.clamp = state.attached ? Clamp::none : state.clamp;
    if (slot != kNone) {
        Entity& entity = _entities[static_cast<size_t>(slot)];
        observe(entity, wanted, timeS);
        if ((entity.state.clamp == Clamp::none) != (wanted.clamp == Clamp::none)) {
            entity.footing.forget();
            _clamped += wanted.clamp == Clamp::none ? size_t(-1) : 1;
        }
        entity.state = wanted;
        entity.timeS = timeS;
        return Applied::yes;
    }
    if (_entities.size() == kEntities) {
        return Applied::full;
    }
    _slotOfEntity[state.id] = static_cast<int16_t>(_entities.size());
    Entity& entity = _entities.emplace_back();
    entity.state = wanted;
    entity.timeS = timeS;
    _clamped += wanted.clamp == Clamp::none ? 0 : 1;
    return Applied::yes;
}

Applied World::set(const GroundTrack& track, double timeS)
{
    const int16_t slot = slotOf(track.entity);
    if (slot == kNone) {
        return Applied::noEntity;
    }
    Entity& entity = _entities[static_cast<size_t>(slot)];
    if (entity.state.attached) {
        return Applied::outOfRange; // an offset is nowhere on the ground
    }
    EntityState next = entity.state;
    next.position.latitudeRad = track.latitudeRad;
    next.position.longitudeRad = track.longitudeRad;
    next.attitude.yawRad = track.yawRad;
    observe(entity, next, timeS);
    entity.state = next;
    entity.timeS = timeS;
    return Applied::yes;
}

Applied World::set(uint16_t id, const Rates& rates, double timeS)
{
    const int16_t slot = slotOf(id);
    if (slot == kNone) {
        return Applied::noEntity;
    }
    Entity& entity = _entities[static_cast<size_t>(slot)];
    rebase(entity, timeS);
    entity.rates = rates;
    entity.ratesGiven = true;
    return Applied::yes;
}

Applied World::set(uint16_t id, const Accelerations& accelerations, double timeS)
{
    const int16_t slot = slotOf(id);
    if (slot == kNone) {
        return Applied::noEntity;
    }
    Entity& entity = _entities[static_cast<size_t>(slot)];
    rebase(entity, timeS);
    entity.accelerations = accelerations;
    entity.ratesGiven = true;
    return Applied::yes;
}

// The rates with which the entity goes on from its next statement.
void World::observe(Entity& entity, const EntityState& next, double timeS) const
{
    if (entity.ratesGiven) {
        entity.rates = motion(entity, timeS).rates;
        return;
    }
    constexpr double kLongestS = 0.5;
    constexpr double kShortestS = 1e-3;
    const EntityState& last = entity.state;
    const double overS = timeS - entity.timeS;
    const bool one = last.attached == next.attached && last.parent == next.parent && last.clamp == next.clamp;
    const bool wanted = _extrapolation.enabled && _extrapolation.stamped && _mayMove[last.id];
    if (!wanted || !one || !(overS >= kShortestS && overS <= kLongestS)) {
        entity.rates = {};
        entity.seenOverS = 0;
        return;
    }
    Motion between{next.offsetM - last.offsetM, parentFromChild(next.attitude)};
    if (!last.attached) {
        const glm::dmat3 fromEcef =
            glm::transpose(ecefFromNed(last.position.latitudeRad, last.position.longitudeRad));
        between.offsetM =
            fromEcef * (toEcef(next.position, _ellipsoid).m - toEcef(last.position, _ellipsoid).m);
        between.parentFromBody = fromEcef *
                                 ecefFromNed(next.position.latitudeRad, next.position.longitudeRad) *
                                 between.parentFromBody;
    }
    const Rates seen = ratesOf(between, overS, parentFromChild(last.attitude));
    const double passedS = 0.5 * (overS + entity.seenOverS);
    // What does not agree is not believed before it has been seen twice: the rates so far stay.
    if (entity.seenOverS > 0 &&
        glm::length(seen.velocityMps - entity.seen.velocityMps) <= kHardestMps2 * passedS &&
        glm::length(seen.turnRadPerS - entity.seen.turnRadPerS) <= kQuickestRadPerS2 * passedS) {
        entity.rates = seen;
    }
    entity.seen = seen;
    entity.seenOverS = overS;
}

void World::rebase(Entity& entity, double timeS) const
{
    if (!_extrapolation.enabled || !_mayMove[entity.state.id] || !(timeS > entity.timeS)) {
        return;
    }
    EntityState& state = entity.state;
    const auto [so, rates] = motion(entity, timeS);
    if (state.attached) {
        state.offsetM += so.offsetM;
    } else if (state.clamp != Clamp::none) {
        state.position = clampedPlace(entity, so);
    } else {
        const glm::dmat3 axes = ecefFromNed(state.position.latitudeRad, state.position.longitudeRad);
        state.position = toGeodetic({toEcef(state.position, _ellipsoid).m + axes * so.offsetM}, _ellipsoid);
    }
    state.attitude = yawPitchRoll(so.parentFromBody);
    entity.rates = rates;
    entity.timeS = timeS;
}

void World::destroy(uint16_t entity)
{
    if (slotOf(entity) == kNone) {
        return;
    }
    _doomed.clear();
    _doomed.push_back(entity);
    for (size_t i = 0; i < _doomed.size(); ++i) {
        for (const Entity& other : _entities) {
            if (other.state.attached && other.state.parent == _doomed[i]) {
                _doomed.push_back(other.state.id);
            }
        }
    }
    for (const uint16_t id : _doomed) {
        // The last one takes its place.
        const int16_t slot = slotOf(id);
        _clamped -= _entities[static_cast<size_t>(slot)].state.clamp == Clamp::none ? 0 : 1;
        _entities[static_cast<size_t>(slot)] = _entities.back();
        _slotOfEntity[_entities.back().state.id] = slot;
        _entities.pop_back();
        _slotOfEntity[id] = kNone;
        _mayMove[id] = false;
    }
}

bool World::descends(int16_t slot, int16_t ancestor) const noexcept
{
    while (slot != kNone && slot != ancestor) {
        const EntityState& entity = _entities[static_cast<size_t>(slot)].state;
        slot = entity.attached ? slotOf(entity.parent) : kNone;
    }
    return slot == ancestor;
}

Moved World::motion(const Entity& entity, double timeS) const
{
    const glm::dmat3 attitude = parentFromChild(entity.state.attitude);
    if (!_extrapolation.enabled || !_mayMove[entity.state.id] || !(timeS > entity.timeS)) {
        return {{glm::dvec3(0.0), attitude}, entity.rates};
    }
    return movedOver(std::min(timeS - entity.timeS, _extrapolation.horizonS), entity.rates,
                     entity.accelerations, attitude);
}

// Where a clamped entity is over ground; its height is that above the ground.
Geodetic World::clampedPlace(const Entity& entity, const Motion& own) const
{
    const Geodetic& from = entity.state.position;
    glm::dvec3 wayM = own.offsetM;
    if (entity.state.clamp == Clamp::conformal) {
        wayM = horizonFromSlope(yawPitchRoll(own.parentFromBody).yawRad, entity.footing.normalNed()) * wayM;
    }
    wayM.z = 0;
    const glm::dvec3 begin =
        toEcef({from.latitudeRad, from.longitudeRad, entity.footing.heightM()}, _ellipsoid).m;
    Geodetic place =
        toGeodetic({begin + ecefFromNed(from.latitudeRad, from.longitudeRad) * wayM}, _ellipsoid);
    place.heightM = from.heightM - own.offsetM.z;
    return place;
}

World::Pose World::clampedPose(const Entity& entity, const Motion& own) const
{
    const Geodetic& from = entity.state.position;
    Geodetic at = clampedPlace(entity, own);
    at.heightM += entity.footing.heightM();
    glm::dmat3 turn = own.parentFromBody;
    if (entity.state.clamp == Clamp::conformal) {
        turn = horizonFromSlope(yawPitchRoll(turn).yawRad, entity.footing.normalNed()) * turn;
    }
    return {toEcef(at, _ellipsoid), ecefFromNed(from.latitudeRad, from.longitudeRad) * turn};
}

void World::stand(Entity& entity, GroundQueries& ground, double timeS) const
{
    if (entity.state.clamp == Clamp::none) {
        return;
    }
    const Geodetic at = clampedPlace(entity, motion(entity, timeS).motion);
    Ground under;
    const Known known = ground.groundAt(at.latitudeRad, at.longitudeRad, under);
    entity.footing.take(known, under, toEcef({at.latitudeRad, at.longitudeRad, 0}, _ellipsoid), timeS);
}

int16_t World::topOf(int16_t slot) const noexcept
{
    while (slot != kNone && _entities[static_cast<size_t>(slot)].state.attached) {
        slot = slotOf(_entities[static_cast<size_t>(slot)].state.parent);
    }
    return slot;
}

void World::standOnGround(GroundQueries& ground, double timeS)
{
    if (_clamped == 0) {
        return;
    }
    const auto standOn = [&](uint16_t entity) {
        if (const int16_t top = topOf(slotOf(entity)); top != kNone) {
            stand(_entities[static_cast<size_t>(top)], ground, timeS);
        }
    };
    standOn(0); // where views sit that the host has not placed
    for (const View& view : _views) {
        standOn(view.entity);
    }
    const size_t turns = std::min(_entities.size(), size_t{kFootingsPerFrame});
    for (size_t turn = 0; turn < turns; ++turn) {
        _nextFooting = _nextFooting + 1 < _entities.size() ? _nextFooting + 1 : 0;
        stand(_entities[_nextFooting], ground, timeS);
    }
}

// Climbs from the entity to its top-level ancestor: no recursion, however long a chain a host builds.
World::Pose World::pose(int16_t slot, double timeS) const
{
    glm::dvec3 offset(0.0);
    glm::dmat3 turn(1.0);
    for (;;) {
        const Entity& entity = _entities[static_cast<size_t>(slot)];
        const Motion own = motion(entity, timeS).motion;
        if (entity.state.clamp != Clamp::none) {
            const Pose body = clampedPose(entity, own);
            return {{body.position.m + body.ecefFromBody * offset}, body.ecefFromBody * turn};
        }
        offset = own.parentFromBody * offset + own.offsetM;
        turn = own.parentFromBody * turn;
        if (!entity.state.attached) {
            // The tangent plane of where it was: over a horizon of seconds the world is flat.
            const Geodetic& at = entity.state.position;
            const glm::dmat3 ecefFromLocal = ecefFromNed(at.latitudeRad, at.longitudeRad);
            return {{toEcef(at, _ellipsoid).m + ecefFromLocal * offset}, ecefFromLocal * turn};
        }
        offset += entity.state.offsetM;
        slot = slotOf(entity.state.parent);
    }
}

std::optional<World::Pose> World::entityPose(uint16_t entity, double timeS) const
{
    const int16_t slot = slotOf(entity);
    return slot == kNone ? std::nullopt : std::optional(pose(slot, timeS));
}

World::View World::makeView(uint16_t id) const noexcept
{
    View view;
    const auto own = std::find_if(_ownDefaults.begin(), _ownDefaults.end(),
                                  [&](const auto& defaults) { return defaults.first == id; });
    const ViewDefaults& defaults = own != _ownDefaults.end() ? own->second : _defaults;
    view.id = id;
    view.leftRad = defaults.leftRad;
    view.rightRad = defaults.rightRad;
    view.bottomRad = defaults.bottomRad;
    view.topRad = defaults.topRad;
    view.nearM = defaults.nearM;
    view.attitude = defaults.attitude;
    return view;
}

const World::View* World::find(uint16_t id) const noexcept
{
    const auto found =
        std::find_if(_views.begin(), _views.end(), [&](const View& view) { return view.id == id; });
    return found == _views.end() ? nullptr : &*found;
}

World::View* World::findOrMake(uint16_t id)
{
    if (const View* found = find(id)) {
        return const_cast<View*>(found);
    }
    if (_views.size() == kViews) {
        return nullptr;
    }
    _views.push_back(makeView(id));
    return &_views.back();
}

Applied World::set(const ViewPlacement& placement)
{
    const auto place = [&](View& view) {
        view.entity = placement.entity;
        assignIf(view.offsetM.x, placement.xM);
        assignIf(view.offsetM.y, placement.yM);
        assignIf(view.offsetM.z, placement.zM);
        assignIf(view.attitude.yawRad, placement.yawRad);
        assignIf(view.attitude.pitchRad, placement.pitchRad);
        assignIf(view.attitude.rollRad, placement.rollRad);
    };
    if (placement.group != 0) {
        for (View& view : _views) {
            if (view.group == placement.group) {
                place(view);
            }
        }
        return Applied::yes;
    }
    View* view = findOrMake(placement.view);
    if (view == nullptr) {
        return Applied::full;
    }
    place(*view);
    return Applied::yes;
}

Applied World::set(const ViewShape& shape)
{
    const View* known = find(shape.view);
    View wanted = known != nullptr ? *known : makeView(shape.view);
    wanted.group = shape.group;
    wanted.parallel = shape.parallel;
    wanted.mirrorX = shape.mirrorX;
    wanted.mirrorY = shape.mirrorY;
    assignIf(wanted.nearM, shape.nearM);
    if (shape.farM) {
        wanted.farM = shape.farM;
    }
    assignIf(wanted.leftRad, shape.leftRad);
    assignIf(wanted.rightRad, shape.rightRad);
    assignIf(wanted.bottomRad, shape.bottomRad);
    assignIf(wanted.topRad, shape.topRad);
    orient(wanted.leftRad, wanted.rightRad);
    orient(wanted.bottomRad, wanted.topRad);
    if (!drawable(wanted.leftRad, wanted.rightRad) || !drawable(wanted.bottomRad, wanted.topRad) ||
        !(wanted.nearM > 0.0) || (wanted.farM && !(*wanted.farM > wanted.nearM))) {
        return Applied::outOfRange;
    }
    View* view = findOrMake(shape.view);
    if (view == nullptr) {
        return Applied::full;
    }
    *view = wanted;
    return Applied::yes;
}

std::optional<World::Pose> World::viewPose(const View& view, double timeS) const
{
    const auto entity = entityPose(view.entity, timeS);
    if (!entity) {
        return std::nullopt;
    }
    return Pose{{entity->position.m + entity->ecefFromBody * view.offsetM},
                entity->ecefFromBody * parentFromChild(view.attitude)};
}

std::optional<World::Pose> World::viewPose(uint16_t id, double timeS) const
{
    const View* known = find(id);
    return viewPose(known != nullptr ? *known : makeView(id), timeS);
}

std::optional<ViewState> World::viewState(uint16_t id, int widthPx, int heightPx, double timeS) const
{
    const View* known = find(id);
    const View view = known != nullptr ? *known : makeView(id);
    const auto pose = viewPose(view, timeS);
    if (!pose) {
        return std::nullopt;
    }
    ViewState state;
    state.eye = pose->position;
    state.eyeFromEcef = eyeFromEcefOfView(pose->ecefFromBody);
    // The box of a parallel view has the sides that the angles have at the near plane.
    const double scale = view.parallel ? view.nearM : 1.0;
    Frustum& frustum = state.frustum;
    frustum.left = scale * std::tan(view.leftRad);
    frustum.right = scale * std::tan(view.rightRad);
    frustum.bottom = scale * std::tan(view.bottomRad);
    frustum.top = scale * std::tan(view.topRad);
    frustum.nearM = view.nearM;
    frustum.parallel = view.parallel;
    if (view.farM) {
        frustum.farM = *view.farM;
    } else if (view.parallel) {
        frustum.farM = farthestGroundM(state, _ellipsoid);
    }
    state.mirrorX = view.mirrorX;
    state.mirrorY = view.mirrorY;
    state.widthPx = widthPx;
    state.heightPx = heightPx;
    state.visibilityM = _environment.airAt(toGeodetic(state.eye, _ellipsoid)).visibilityM;
    return state;
}

} // namespace ig::scene
