#pragma once
// Writes frames: shells, cracks and bodies as .vtp files, listed in frames.pvd.
#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/io/fields.h"
#include "shell/io/probes.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

/// Fields that a scene asks for, and the contact of each shell since the last frame.
struct FrameFields {
  FieldSet set{};
  std::vector<ContactOverTime> contact{};
  bool thick = false;  // shells with their thickness too, in thick.pvd
  /// Velocity [m/s] of a body's material at a world point on it, by its number among the bodies of the frame.
  std::function<Vec3(std::size_t body, const Vec3& at)> velocity{};
};

/// Triangles of a shell that were once too stretched to be drawn: their corners in parameters, a column each [m], by
/// the knot spans (u, v) of their centres. What is torn stays torn, so that no film flickers where it springs back or
/// where cracks divide it again.
using TornTriangles = std::map<std::array<int, 2>, std::vector<Eigen::Matrix<double, 2, 3>>>;

/// Writes one frame after another into a folder.
class FrameWriter {
 public:
  explicit FrameWriter(std::string folder);
  /// Writes the frame of this time [s], which is that of the last frame or later. A frame of the same time is replaced.
  /// Without shells it writes bodies only. Body ids from `first_shard` on are shards. Throws Error (bad_output).
  /// `pieces` is the id of the piece of each control point of each shell: the cell array `fragment`.
  void write(double time, const std::vector<ShellView>& shells, const std::vector<std::vector<BodyId>>& pieces,
             const SoftBodies& soft, const std::vector<RigidBody>& bodies, BodyId first_shard,
             const FrameFields& fields = {});
  bool has_frame_of(double time) const;
  /// Draws the body from now on as this mesh, not as its convex parts, and with the id of the piece that it was.
  void draw_as(BodyId id, BodyId piece, DrawnMesh mesh) { drawn_[id] = std::move(mesh), piece_[id] = piece; }
  int count() const { return count_; }
  /// Calls f with all members that a checkpoint saves.
  template <class F>
  void saved(F&& f) {
    f(count_, index_, thick_index_, drawn_, piece_, torn_);
  }

 private:
  std::string folder_;
  int count_ = 0;
  std::string index_, thick_index_;
  std::map<BodyId, DrawnMesh> drawn_;
  std::map<BodyId, BodyId> piece_;
  std::map<std::string, TornTriangles> torn_;  // by the shell's name
};

}  // namespace sunder::shell
