// Runs a scene's text in this process.
#include <fstream>

#include "coupler/link/host.h"
#include "coupler/scene/load.h"
#include "rigid/engine/engine.h"
#include "shell/run/run.h"
#include "tests/temporary_folder.h"
#include "tests/validation/coupled.h"

namespace sunder::validation {

std::string run_text(const std::string& text, const std::string& engine, const Watch& watch, WatchedRun* end,
                     const Tamper& tamper, const std::map<std::string, std::string>& files) {
  return run_text(text, *rigid::make_engine(engine), watch, end, tamper, files);
}

std::string run_text(const std::string& text, link::Engine& engine, const Watch& watch, WatchedRun* end,
                     const Tamper& tamper, const std::map<std::string, std::string>& files) {
  const TemporaryFolder folder;
  for (const auto& [name, content] : files) std::ofstream(folder.path + "/" + name) << content;
  const std::string file = folder.path + "/scene.textproto";
  std::ofstream(file) << text;
  std::string failure;
  try {
    const auto scene = scene::load(file, {});
    shell::RunOptions options;
    options.out = folder.path, options.quiet = true, options.scene_hash = scene.hash;
    options.connect = [&](const shell::RunOptions&) { return std::make_unique<link::EngineHost>(engine); };
    options.observe = [&](const shell::Run& run) {
      std::vector<const RigidBody*> bodies;
      for (const shell::Proxy& p : run.bodies()) bodies.push_back(&p.body);
      if (watch) watch(run.time(), run.mechanical_energy(), bodies);
      if (end) end->hardest = run.stiffest_ratio(), end->exported = run.exported();
    };
    options.tamper = tamper;
    shell::Run run(shell::build(scene), options);
    const std::atomic<bool> never{false};
    run.execute(never);
  } catch (const Error& e) {
    failure = e.kind + ": " + e.what();
  }
  if (end) {
    std::ifstream summary(folder.path + "/run.json");
    end->summary.assign(std::istreambuf_iterator<char>(summary), {});
  }
  return failure;
}

}  // namespace sunder::validation
