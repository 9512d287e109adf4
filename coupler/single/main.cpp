// sunder-single: shell solver and engine in one process, for tests and to measure the cost of the process boundary.
#include "coupler/link/host.h"
#include "rigid/engine/engine.h"
#include "shell/run/program.h"

namespace {

// A link that owns its engine. The engine is a base class, so that it exists before the host.
struct Owned {
  std::unique_ptr<sunder::link::Engine> engine;
};
class OwningHost final : private Owned, public sunder::link::EngineHost {
 public:
  explicit OwningHost(std::unique_ptr<sunder::link::Engine> e) : Owned{std::move(e)}, EngineHost(*engine) {}
};

std::unique_ptr<sunder::link::RigidLink> connect(const std::string& name, const sunder::shell::RunOptions& o) {
  sunder::require(o.record.empty() && o.replay.empty() && o.keys.empty(),
                  "--record, --replay and --keys are for two processes; leave them out");
  return std::make_unique<OwningHost>(sunder::rigid::make_engine(name));
}

}  // namespace

int main(int argc, char** argv) {
  return sunder::shell::run_program({"sunder-single", "--engine", "NAME", connect}, argc, argv);
}
