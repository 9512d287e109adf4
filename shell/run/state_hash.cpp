#include "shell/run/state_hash.h"

#include "coupler/core/hash.h"

namespace sunder::shell {

std::string state_hash(const std::string& before, const State& state) {
  Sha256 h;
  h.add(before.data(), before.size());
  for (const ShellPart& part : state.shells) {
    if (!part.state) continue;
    const ShellState& s = *part.state;
    h.add(s.motion.x), h.add(s.motion.v);
    if (!s.layers.fibres.empty()) h.add(s.layers.fibres);
    h.add(s.layers.c_his.data(), s.layers.c_his.size() * sizeof(float));
    for (const CrackEdge& e : s.cracks.graph.edges())
      h.add(std::vector<double>{e.a.x(), e.a.y(), e.b.x(), e.b.y(), e.time});
  }
  for (const SoftState& s : state.soft.states()) {
    h.add(s.x.data(), s.x.size() * sizeof(Vec3)), h.add(s.v.data(), s.v.size() * sizeof(Vec3));
    h.add(s.f.data(), s.f.size() * sizeof(Mat3)), h.add(s.affine.data(), s.affine.size() * sizeof(Mat3));
  }
  for (const Proxy& p : state.bodies) {
    const BodyMotion& m = p.body.motion;
    h.add(std::vector<double>{static_cast<double>(p.body.id), m.position.x(), m.position.y(), m.position.z(),
                              m.orientation.w(), m.orientation.x(), m.orientation.y(), m.orientation.z(),
                              m.velocity.x(), m.velocity.y(), m.velocity.z(), m.angular_momentum.x(),
                              m.angular_momentum.y(), m.angular_momentum.z()});
  }
  return h.hex();
}

}  // namespace sunder::shell
