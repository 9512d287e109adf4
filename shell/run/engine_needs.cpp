// Capabilities of the engine that a scene needs.
#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "coupler/link/capabilities.h"
#include "shell/run/coupler.h"

namespace sunder::shell {
void check_engine(const RunSetup& setup, const link::EngineInfo& peer) {
  const std::vector<link::UnknownWord> unknown = link::unknown_words(peer);
  const auto need = [&](const char* what, const std::string& why, const char* remedy = "change the scene") {
    if (peer.can(what)) return;
    std::string meant;  // by a word that the engine declares in its place
    for (const link::UnknownWord& u : unknown)
      if (meant.empty() && !u.near.empty() && u.near.front() == what)
        meant = fmt::format(" (it declares '{}', which is no capability: did you mean '{}'?)", u.word, what);
    require(false, "the engine '{}' cannot do '{}'{}, which {}; take another engine, or {}", peer.name, what, meant,
            why, remedy);
  };
  using namespace link::capability;
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    const RigidBody& b = setup.bodies[i];
    if (setup.proxy(i).deforms()) continue;  // the engine does not get it
    if (std::holds_alternative<SphereShape>(b.shape)) need(kSpheres, "body '" + b.name + "' needs");
    if (std::holds_alternative<BoxShape>(b.shape)) need(kBoxes, "body '" + b.name + "' needs");
    if (std::holds_alternative<HalfSpaceShape>(b.shape)) need(kHalfSpaces, "body '" + b.name + "' needs");
    const auto* convex = std::get_if<ConvexShape>(&b.shape);
    if (convex) need(kConvexHulls, "body '" + b.name + "' needs");
    if (convex && convex->parts.size() > 1) need(kCompound, "body '" + b.name + "' needs");
  }
  for (const Joint& j : setup.joints) need(kJoints, "joint '" + j.name + "' needs");
  for (std::size_t i = 0; i < setup.joints.size(); ++i)
    if (setup.breaks[i].can()) need(kReleaseJoints, "joint '" + setup.joints[i].name + "', which breaks, needs");
  if (setup.can_crack())
    for (const char* what : {kConvexHulls, kCompound}) need(what, "shards need", "leave 'strength' and 'cuts' out");
  if (setup.coupling.scheme == CouplingRules::Scheme::kExported) need(kExportRows, "coupling.scheme EXPORTED needs");
  if (setup.coupling.scheme == CouplingRules::Scheme::kIterated) need(kSaveRestore, "coupling.scheme ITERATED needs");
}

std::vector<std::string> engine_notes(const RunSetup& setup, const link::EngineInfo& peer) {
  using namespace link::capability;
  const auto moving = static_cast<std::size_t>(
      std::count_if(setup.bodies.begin(), setup.bodies.end(), [](const RigidBody& b) { return !b.is_static; }));
  const bool meet = setup.can_crack() || (moving > 0 && setup.bodies.size() > 1);
  std::vector<std::string> notes;
  const auto without = [&](const char* what, const std::string& why) {
    if (!peer.can(what)) notes.push_back(fmt::format("the engine '{}' cannot do '{}': {}", peer.name, what, why));
  };
  if (meet && !peer.can(kContact)) {
    without(kContact, "bodies and shards pass through one another, shells alone stop them");
  } else if (meet) {
    const auto any = [&](auto has) { return std::any_of(setup.laws.begin(), setup.laws.end(), has); };
    if (any([](const ContactLaw& law) { return law.friction > 0.0; })) without(kFriction, "bodies slide freely");
    if (any([](const ContactLaw& law) { return law.restitution > 0.0; })) without(kRestitution, "bodies do not bounce");
  }
  const bool held = moving > 0 && (setup.bodies.size() > 1 || !setup.joints.empty());
  if (held && !setup.shells.empty() && setup.coupling.scheme == CouplingRules::Scheme::kProxy)
    without(
        kExportRows,
        fmt::format("a body that is squeezed between a shell and another body, or that a joint holds, may gain "
                    "energy where k H^2/M passes {:g} (coupling in run.json says what it came to); shorten window_s",
                    setup.coupling.export_above));
  return notes;
}

}  // namespace sunder::shell
