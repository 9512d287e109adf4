#include "shell/run/state_hash.h"

#include "coupler/core/archive.h"
#include "coupler/core/hash.h"

namespace sunder::shell {

namespace {

template <class T>
requires kAsBytes<T>
void hash_member(Sha256& h, const std::vector<T>& list) { h.add(list.data(), list.size() * sizeof(T)); }

void hash_member(Sha256& h, const CrackGraph& graph) {
  for (const CrackEdge& e : graph.edges())
    hash_member(h, std::vector<double>{e.a.x(), e.a.y(), e.b.x(), e.b.y(), e.time});
}

// Adds what a kind of state lists in its hashed(); nothing of a kind without it.
template <class Kind>
void hash_kind(Sha256& h, const Kind& kind) {
  const auto take = [&h](const auto&... members) { (hash_member(h, members), ...); };
  if constexpr (requires { Kind::hashed(kind, take); }) Kind::hashed(kind, take);
}

}  // namespace

std::string state_hash(const std::string& before, const State& state) {
  Sha256 h;
  h.add(before.data(), before.size());
  for (const ShellPart& part : state.shells)
    if (part.state) ShellState::kinds(*part.state, [&h](const auto&... kinds) { (hash_kind(h, kinds), ...); });
  for (const SoftState& s : state.soft.states()) hash_kind(h, s);
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
