#include "rigid/engine/engine.h"

#include "coupler/core/error.h"
#include "coupler/core/nearest.h"
#include "rigid/engine/bullet_engine.h"
#include "rigid/engine/free_flight.h"
#include "rigid/engine/ode_solver.h"

namespace sunder::rigid {

std::vector<std::string> engine_names() { return {"bullet", "ode", "freeflight"}; }

std::unique_ptr<Engine> make_engine(const std::string& name) {
  if (name == "bullet") return std::make_unique<BulletEngine>();
  if (name == "ode") return std::make_unique<OdeEngine>();
  if (name == "freeflight") return std::make_unique<FreeFlight>();
  throw Error(Exit::kBadInput, "unknown_engine",
              fmt::format("engine '{}' is unknown; {}", name, did_you_mean(name, engine_names())));
}

}  // namespace sunder::rigid
