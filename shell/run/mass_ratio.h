#pragma once
// Bodies that an engine does not hold as they are: heavy ones on light ones, which it squeezes out, and bodies with a
// prescribed motion on what does not give way.
#include <string>
#include <vector>

#include "shell/contact/proxy.h"

namespace sunder::shell {

/// The body that lies on the lightest one for its weight. Plain numbers, so a checkpoint stores them as bytes.
struct HeavyPair {
  BodyId heavy = 0, light = 0;
  double ratio = 0.0;      // of their masses [-]
  double window = 0.0;     // the longest one that is known to hold them [s]
  std::int64_t looks = 0;  // in which they lay so
};

/// Looks for a pair of moving bodies, among the first `count`, of which the heavy one lies on the light one. `window`
/// [s] is the present one. Pairs that it is known to hold do not count; it holds fewer where the engine solves in
/// single precision.
void look_for_heavy(const std::vector<Proxy>& bodies, std::size_t count, const Vec3& gravity, double window,
                    bool double_precision, HeavyPair& pair);

/// A sentence for run.json about a pair that was seen often enough; empty where there is none.
std::string heavy_warning(const std::vector<Proxy>& bodies, const HeavyPair& pair, const std::string& engine);

/// A sentence for run.json about a body with a prescribed motion that met what does not give way, first at `when` [s].
std::string blocked_warning(const std::vector<Proxy>& bodies, BodyId id, double when);

}  // namespace sunder::shell
