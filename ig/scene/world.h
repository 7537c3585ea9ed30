// SPDX-License-Identifier: MIT
// ig/scene: what the host has said about the world (entities, views, environment), and the ViewState that
// follows from it. It knows no packets and no GL; ig/app translates. Everything is last-writer-wins, nothing
// reads a clock, nothing allocates after construction.
//
// Time. A statement is true at the time it is given with; a view is asked for at a time. In between an entity
// moves with its rates where extrapolation is on for it and for the world, for at most the horizon: after
// that it holds. Otherwise it is where the host last put it. Times are seconds of any one clock.
//
// Rates are the host's, or for an entity that it has never given any, where statements are stamped with the
// host's own time, what its last two places show. They count when they agree with those before, as far as
// something can accelerate (kHardestMps2, kQuickestRadPerS2): a step or a leap is none.
//
// Ground. A clamped entity's height is above the ground under it, and with conformal its pitch and roll are
// from the slope there; it moves along the slope. Its footing is taken once per frame by standOnGround(), at
// the place where the entity is at that frame's time, and every pose until the next call uses it:
//   finest terrain      as it is, at once
//   being read          the terrain at hand, shifted so that nothing jumps; the shift ends after
//                       Footing::kWaitS anyway
//   outside, in a hole  the footing stays; an entity that never had one stands on height 0
// What a change between these would make jump is kept and let go over Footing::kSettleS. A statement that
// puts the entity more than Footing::kLeapM from where it was takes the new footing at once.
#pragma once

#include "ig/geo/attitude.h"
#include "ig/geo/geodesy.h"
#include "ig/geo/ground_queries.h"
#include "ig/geo/view_state.h"
#include "ig/scene/environment.h"
#include "ig/scene/footing.h"
#include "ig/scene/motion.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace ig::scene {

enum class Clamp : uint8_t {
    none,
    level,     // height above the ground, attitude from the local horizon
    conformal, // height above the ground; pitch and roll from its slope, yaw from north
};

// A host's statement about one entity. Top level: geodetic position, attitude from the local horizon; clamped
// as above. Attached: offset (m) in the parent's body axes, attitude from the parent's axes, no clamp.
struct EntityState {
    uint16_t id = 0;
    bool attached = false;
    Clamp clamp = Clamp::none;
    uint16_t parent = 0;     // when attached
    Geodetic position;       // when not attached
    glm::dvec3 offsetM{0.0}; // when attached
    YawPitchRoll attitude;
};

// A host's statement that a body stays on its course over ground: heights, pitch, roll and clamp stay.
struct GroundTrack {
    uint16_t entity = 0;
    double latitudeRad = 0;
    double longitudeRad = 0;
    double yawRad = 0;
};

// A change to where a view sits; what is absent keeps its value. All of it refers to the entity's body axes:
// first translate, then rotate about the eyepoint.
struct ViewPlacement {
    uint16_t view = 0;
    uint8_t group = 0;   // not 0: every view of that group, `view` is ignored
    uint16_t entity = 0; // always applied
    std::optional<double> xM, yM, zM;
    std::optional<double> yawRad, pitchRad, rollRad;
};

// A change to a view's frustum; what is absent keeps its value. Angles are signed, from the viewing axis.
struct ViewShape {
    uint16_t view = 0;
    uint8_t group = 0; // the group that the view belongs to from now on; 0: none
    // The projection is that of the newest statement. Parallel: the sides are where the angles meet the near
    // plane.
    bool parallel = false;
    bool mirrorX = false, mirrorY = false; // the picture has left and right, top and bottom exchanged
    std::optional<double> nearM, farM;
    std::optional<double> leftRad, rightRad, bottomRad, topRad;
};

// What a view is before the host has said anything about it.
struct ViewDefaults {
    double leftRad = -36.0 * kRadPerDeg, rightRad = 36.0 * kRadPerDeg;
    double bottomRad = -22.5 * kRadPerDeg, topRad = 22.5 * kRadPerDeg;
    double nearM = 0.5;
    YawPitchRoll attitude;  // from the entity's body axes
    double visibilityM = 0; // until the host sends one; 0: no limit
};

struct Extrapolation {
    bool enabled = false; // the master switch
    double horizonS = 0;
    bool stamped = false; // statements' times are the host's own, free of what the network adds
};

enum class Applied {
    yes,
    full,       // no room for another entity or view
    noEntity,   // about an entity that does not exist
    noParent,   // attachment to an entity that does not exist, or to itself or one of its children
    outOfRange, // a value that no view can have
};

class World {
public:
    static constexpr size_t kEntities = 4096;
    static constexpr size_t kViews = 64;
    static constexpr double kHardestMps2 = 200;     // of rates that are seen, not given: twenty times gravity
    static constexpr double kQuickestRadPerS2 = 20; // the same

    World(const Ellipsoid& ellipsoid, const ViewDefaults& defaults);
    // Defaults of one view, but for the visibility, which is the world's; before the host speaks. Allocates.
    void setDefaults(uint16_t view, const ViewDefaults& defaults);

    // Forgets every entity and view, as a host's Reset/Standby orders.
    void reset();

    // timeS: when it was true. The entity keeps its rates, as they have become by then.
    Applied set(const EntityState& state, double timeS = 0);
    Applied set(const GroundTrack& track, double timeS = 0);
    // Rates from timeS on; where the entity has got to by then, with its rates so far, is where they begin.
    Applied set(uint16_t entity, const Rates& rates, double timeS);
    // The same for how rates change.
    Applied set(uint16_t entity, const Accelerations& accelerations, double timeS);
    // Whether this entity may be moved on; it need not exist yet.
    void allowExtrapolation(uint16_t entity, bool allowed) { _mayMove[entity] = allowed; }
    void set(const Extrapolation& extrapolation) noexcept { _extrapolation = extrapolation; }
    // Removes an entity and everything attached to it.
    void destroy(uint16_t entity);
    Applied set(const ViewPlacement& placement);
    Applied set(const ViewShape& shape);

    // Takes the footing of clamped entities for a frame that is displayed at timeS: of those that views sit
    // on, and of the others at most kFootingsPerFrame, in turns. Nothing is clamped: nothing is done or
    // asked.
    void standOnGround(GroundQueries& ground, double timeS);
    static constexpr int kFootingsPerFrame = 256;

    bool has(uint16_t entity) const noexcept { return slotOf(entity) != kNone; }

    // A body's place and attitude in the world.
    struct Pose {
        EcefPos position;
        glm::dmat3 ecefFromBody{1.0};
    };
    std::optional<Pose> entityPose(uint16_t entity, double timeS) const;
    // Axes of a view: X along the line of sight, Y right, Z down.
    std::optional<Pose> viewPose(uint16_t view, double timeS) const;

    // The view as it is to be drawn at a time, or nothing while the entity that it sits on does not exist.
    // Views the host never mentioned sit on entity 0, without an offset. widthPx, heightPx: of the picture.
    std::optional<ViewState> viewState(uint16_t view, int widthPx, int heightPx, double timeS = 0) const;

    Environment& environment() noexcept { return _environment; }
    const Environment& environment() const noexcept { return _environment; }
    const Ellipsoid& ellipsoid() const noexcept { return _ellipsoid; }

private:
    static constexpr int16_t kNone = -1;
    struct Entity {
        EntityState state;
        double timeS = 0; // when it is true
        Rates rates;
        Accelerations accelerations;
        Footing footing;         // when clamped
        bool ratesGiven = false; // by the host
        Rates seen;              // between the last two statements
        double seenOverS = 0;    // 0: there are none
    };
    struct View {
        uint16_t id = 0;
        uint8_t group = 0;
        uint16_t entity = 0;
        glm::dvec3 offsetM{0.0};
        YawPitchRoll attitude;
        double leftRad = 0, rightRad = 0, bottomRad = 0, topRad = 0, nearM = 0;
        std::optional<double> farM; // none: nothing is cut off
        bool parallel = false, mirrorX = false, mirrorY = false;
    };

    int16_t slotOf(uint16_t entity) const noexcept { return _slotOfEntity[entity]; }
    // The entity's own motion since its statement, and its rates then; none where it may not be moved on.
    Moved motion(const Entity& entity, double timeS) const;
    // Makes the state that of timeS, if it is later and the entity moves.
    void rebase(Entity& entity, double timeS) const;
    Geodetic clampedPlace(const Entity& entity, const Motion& own) const;
    Pose clampedPose(const Entity& entity, const Motion& own) const;
    void observe(Entity& entity, const EntityState& next, double timeS) const;
    void stand(Entity& entity, GroundQueries& ground, double timeS) const;
    int16_t topOf(int16_t slot) const noexcept;
    Pose pose(int16_t slot, double timeS) const;
    bool descends(int16_t slot, int16_t ancestor) const noexcept;
    const View* find(uint16_t view) const noexcept;
    View* findOrMake(uint16_t view);
    View makeView(uint16_t id) const noexcept;
    std::optional<Pose> viewPose(const View& view, double timeS) const;

    Ellipsoid _ellipsoid;
    ViewDefaults _defaults;
    std::vector<std::pair<uint16_t, ViewDefaults>> _ownDefaults; // of some views
    std::vector<int16_t> _slotOfEntity;                          // 65536
    std::vector<Entity> _entities;                               // the used ones, in no order
    std::vector<bool> _mayMove;                                  // 65536
    Extrapolation _extrapolation;
    Environment _environment;
    std::vector<uint16_t> _doomed; // scratch of destroy
    size_t _clamped = 0;           // entities
    size_t _nextFooting = 0;       // whose turn it is
    std::vector<View> _views;
};

} // namespace ig::scene
