#pragma once
// A rigid-body engine as the coupler asks for it: in this process, or behind a session.
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "coupler/core/error.h"

namespace sunder::link {

/// Words of EngineInfo::capabilities; rigid/README.md says what each promises.
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
constexpr const char* kDoublePrecision = "double_precision";
constexpr const char* kDeterministic = "deterministic";
}  // namespace capability

struct EngineInfo {
  std::string name, version;
  std::vector<std::string> capabilities;
  bool can(const std::string& what) const {
    return std::find(capabilities.begin(), capabilities.end(), what) != capabilities.end();
  }
};

/// A body and how it moves: at the end of a window before engine contacts (a handback), or where the engine has it.
struct Motion {
  BodyId id = 0;
  BodyMotion motion;
};

/// What the engine makes of a body.
struct State {
  BodyId id = 0;
  double mass = 0.0;  // [kg], as the engine holds it
  BodyMotion motion;
};

/// A point of each of two bodies that must not pass one another along the normal.
struct ContactRow {
  BodyId first = 0, second = 0;
  Vec3 first_point = Vec3::Zero(), second_point = Vec3::Zero();  // body coordinates [m]
  Vec3 normal = Vec3::UnitZ();                                   // world, from the second body to the first
  double friction = 0.0, restitution = 0.0;
  double allowance = 0.0;  // by which the two may overlap [m]
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual EngineInfo info() const = 0;
  /// Throws Error (bad_body) where the engine cannot hold the shape.
  virtual void add(const RigidBody& body) = 0;
  virtual void set_contact_laws(const std::vector<ContactLaw>& laws) = 0;
  /// One window of `window_s` seconds (rigid/README.md "A window"): each body takes the window with the average
  /// velocity that leads to its handback pose, contacts and joints are found and solved on that, and it ends on its
  /// handback velocity plus the change that the solver made; then a velocity-only solve at the new pose. One handback
  /// for each body that is not static, by id. Contacts and joints of bodies in `solved` (by id) are left out.
  virtual void advance(double window_s, const std::vector<Motion>& predicted, const std::vector<BodyId>& solved) = 0;
  /// Every body that is not static, by ascending id.
  virtual std::vector<State> states() const = 0;

  /// Capability joints. Both bodies are there already. Throws Error (bad_joint).
  virtual void add_joint(const Joint& joint) { lacks(capability::kJoints, joint.name); }
  /// Capability release_joints: it holds no longer, from the next window on; its bodies still do not collide with one
  /// another. Of no effect where it let go before. The joint is there.
  virtual void release_joint(std::uint32_t id) { lacks(capability::kReleaseJoints, std::to_string(id)); }
  /// Capability export_rows: contacts that `bodies` (by id) may have in a window in which every body that is not static
  /// would come to its place in `motions` without them. Nothing moves.
  virtual std::vector<ContactRow> rows(double window_s, const std::vector<Motion>& motions,
                                       const std::vector<BodyId>& bodies) {
    (void)window_s, (void)motions, (void)bodies;
    lacks(capability::kExportRows, "rows");
  }
  /// Capability save_restore: what states() do not tell. From here on this engine and another one that holds the same
  /// bodies with the same motions, added in the same order, and is restored with it, agree to the bit.
  virtual std::string save() { lacks(capability::kSaveRestore, "save"); }
  /// Puts every body that is not static to its motion, by id, and takes the caches. Throws Error (bad_state).
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
