#pragma once
// The interface of a rigid-body engine, in this process or behind a session.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/core/error.h"

namespace sunder::link {

/// Words of EngineInfo::capabilities. rigid/README.md says what each promises.
namespace capability {
constexpr const char* kSpheres = "spheres";
constexpr const char* kBoxes = "boxes";
constexpr const char* kHalfSpaces = "half_spaces";
constexpr const char* kConvexHulls = "convex_hulls";
constexpr const char* kCompound = "compound";
constexpr const char* kContact = "contact";
constexpr const char* kFriction = "friction";
constexpr const char* kRestitution = "restitution";
constexpr const char* kJoints = "joints";
constexpr const char* kReleaseJoints = "release_joints";
constexpr const char* kExportRows = "export_rows";
constexpr const char* kSaveRestore = "save_restore";
constexpr const char* kMassRatios = "mass_ratios";
constexpr const char* kDoublePrecision = "double_precision";
constexpr const char* kDeterministic = "deterministic";
}  // namespace capability

/// Name, version and capabilities of an engine.
struct EngineInfo {
  std::string name, version;
  std::vector<std::string> capabilities;
  /// True where the engine declares a capability.
  bool can(const std::string& what) const {
    return std::find(capabilities.begin(), capabilities.end(), what) != capabilities.end();
  }
};

/// Motion of a body. At the end of a window before the engine's contacts it is the body's *predicted state* (field
/// `predicted` of a window).
struct Motion {
  BodyId id = 0;
  BodyMotion motion;
};

/// A body as the engine holds it after a window.
struct State {
  BodyId id = 0;
  double mass = 0.0;  // [kg], as the engine holds it
  BodyMotion motion;
};

/// A contact of two bodies: a point of each, which must not pass one another along the normal.
struct ContactRow {
  BodyId first = 0, second = 0;
  Vec3 first_point = Vec3::Zero(), second_point = Vec3::Zero();  // body coordinates [m]
  Vec3 normal = Vec3::UnitZ();                                   // world, from the second body to the first
  double friction = 0.0, restitution = 0.0;
  double allowance = 0.0;  // overlap of the two bodies that is not pushed apart [m]
};

/// Holds rigid bodies and takes them through windows. Every call throws Error where its arguments cannot be.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  /// Adds a body with its motion. Throws Error (bad_body) where the engine cannot hold the shape.
  virtual void add(const RigidBody& body) = 0;
  /// Replaces the laws of all pairs of contact groups. Pairs without a law have friction 0.5 and restitution 0.
  virtual void set_contact_laws(const std::vector<ContactLaw>& laws) = 0;
  /// One window of `window_s` seconds (rigid/README.md "A window"). Each body starts with the average velocity that
  /// leads to its predicted pose; contacts and joints are found and solved on these velocities. A body ends with its
  /// predicted velocity plus the change that the solver made. Then velocities are solved once more at the new pose.
  /// `predicted`: one state for each body that is not static, by ascending id. Contacts and joints of bodies in
  /// `solved` (by id) are left out. Throws Error (bad_predicted_state) where the states do not match the bodies.
  virtual void advance(double window_s, const std::vector<Motion>& predicted, const std::vector<BodyId>& solved) = 0;
  /// State of every body that is not static, by ascending id.
  virtual std::vector<State> states() const = 0;

  /// Capability joints. Adds a joint between bodies that the engine holds. Throws Error (bad_joint).
  virtual void add_joint(const Joint& joint) { lacks(capability::kJoints, joint.name); }
  /// Capability release_joints. From the next window on the joint, which exists, does not hold. Its bodies still do not
  /// collide with one another. A joint that is released already stays so.
  virtual void release_joint(std::uint32_t id) { lacks(capability::kReleaseJoints, std::to_string(id)); }
  /// Capability export_rows. Contacts that `bodies` (by id) may have in a window of `window_s` seconds. `motions`: the
  /// predicted state of every body that is not static, by id. Nothing moves.
  virtual std::vector<ContactRow> rows(double window_s, const std::vector<Motion>& motions,
                                       const std::vector<BodyId>& bodies) {
    (void)window_s, (void)motions, (void)bodies;
    lacks(capability::kExportRows, "rows");
  }
  /// Capability save_restore. Returns the state of the engine that states() does not show, such as starting impulses of
  /// solvers. Another engine with the same bodies and motions, added in the same order and restored with these bytes,
  /// agrees with this one to the bit from here on.
  virtual std::string save() { lacks(capability::kSaveRestore, "save"); }
  /// Capability save_restore. Sets the motion of every body that is not static, by id, and the saved state. Throws
  /// Error (bad_state).
  virtual void restore(const std::string& caches, const std::vector<Motion>& motions) {
    (void)caches, (void)motions;
    lacks(capability::kSaveRestore, "restore");
  }

 private:
  [[noreturn]] void lacks(const char* what, const std::string& asked) const {
    throw Error(Exit::kBadInput, "no_capability", info().name + " cannot do '" + what + "' (" + asked + ")");
  }
};

}  // namespace sunder::link
