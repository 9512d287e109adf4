#pragma once
// Pictures of a moment: shell, cracks and bodies as .vtp, all moments in frames.pvd.
#include <map>
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "shell/io/probes.h"
#include "shell/soft/soft_bodies.h"
#include "shell/solver/parting/handoff.h"

namespace sunder::shell {

class FrameWriter {
 public:
  explicit FrameWriter(std::string folder);
  /// Without shells only bodies are written. Shards start at body id `first_shard`.
  void write(double time, const std::vector<ShellView>& shells, const SoftBodies& soft,
             const std::vector<RigidBody>& bodies, BodyId first_shard);
  /// From now on the body is drawn as this mesh, not as its convex parts.
  void draw_as(BodyId id, DrawnMesh mesh) { drawn_[id] = std::move(mesh); }
  int count() const { return count_; }
  /// Calls f with all members that a checkpoint keeps.
  template <class F>
  void saved(F&& f) {
    f(count_, index_, drawn_);
  }

 private:
  std::string folder_;
  int count_ = 0;
  std::string index_;
  std::map<BodyId, DrawnMesh> drawn_;
};

}  // namespace sunder::shell
