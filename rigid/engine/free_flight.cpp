#include "rigid/engine/free_flight.h"

#include "rigid/engine/checks.h"

namespace sunder::rigid {

EngineInfo FreeFlight::info() const {
  using namespace link::capability;
  return {"freeflight",
          "1",
          {kSpheres, kBoxes, kHalfSpaces, kConvexHulls, kCompound, kExportRows, kSaveRestore, kDoublePrecision,
           kDeterministic}};
}

void FreeFlight::add(const RigidBody& body) {
  check_body(body);
  if (!bodies_.emplace(body.id, body).second) reject_body(body, "id", "is held already; ids are for the whole run");
}

void FreeFlight::move(const std::vector<PredictedState>& motions) {
  match_predicted(
      bodies_, motions, [](const RigidBody& body) { return body.is_static; },
      [](RigidBody& body, const BodyMotion& motion) { body.motion = motion; });
}

void FreeFlight::advance(double window_s, const std::vector<PredictedState>& predicted, const std::vector<BodyId>&) {
  check_window(window_s);
  move(predicted);
}

std::vector<EngineState> FreeFlight::states() const {
  std::vector<EngineState> out;
  for (const auto& [id, body] : bodies_)
    if (!body.is_static) out.push_back({id, body.mass, body.motion});
  return out;
}

void FreeFlight::restore(const std::string& caches, const std::vector<PredictedState>& motions) {
  if (!caches.empty())
    throw Error(Exit::kBadInput, "bad_state", fmt::format("freeflight keeps no caches; {} bytes given", caches.size()));
  move(motions);
}

}  // namespace sunder::rigid
