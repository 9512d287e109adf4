#pragma once
// A run of a small scene beside an engine that lets bodies fly on as they are predicted, and keeps what it was asked.
#include <atomic>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "coupler/scene/load.h"
#include "shell/run/run.h"
#include "tests/temporary_folder.h"

namespace sunder::shell {

/// An engine without contacts.
class FreeLink final : public link::RigidLink {
 public:
  /// What it was asked; it outlives the link.
  struct Asked {
    link::World world;
    std::vector<link::WindowTask> tasks;
    std::string restored = "nothing", aborted;
    bool ended = false;
    std::vector<std::string> declares{};  // beside what it can
  };
  explicit FreeLink(Asked& asked) : asked_(asked) {
    info_.capabilities.insert(info_.capabilities.end(), asked.declares.begin(), asked.declares.end());
  }

  const link::EngineInfo& peer() const override { return info_; }
  std::vector<link::State> load(const link::World& world) override {
    asked_.world = world;
    return add_bodies(world.bodies);
  }
  void restore(const std::string& caches) override { asked_.restored = caches; }
  std::vector<link::ContactRow> rows(std::int64_t, double, const std::vector<link::Motion>&,
                                     const std::vector<BodyId>&) override {
    return {};
  }
  std::vector<link::State> window(const link::WindowTask& task) override {
    asked_.tasks.push_back(task);
    for (link::State& s : states_)
      for (const link::Motion& m : task.predicted)
        if (m.id == s.id) s.motion = m.motion;
    return add_bodies(task.births);
  }
  std::vector<link::State> add_bodies(const std::vector<RigidBody>& bodies) override {
    for (const RigidBody& b : bodies)
      if (!b.is_static) states_.push_back({b.id, b.mass, b.motion});
    return states_;
  }
  std::string save() override { return "caches of the engine"; }
  void bye() override { asked_.ended = true; }
  void abort(const std::string& kind, const std::string&) noexcept override { asked_.aborted = kind; }
  void check_peer() override {}

 private:
  Asked& asked_;
  std::vector<link::State> states_;
  link::EngineInfo info_{"free",
                         "3.1",
                         {link::capability::kSpheres, link::capability::kDoublePrecision,
                          link::capability::kSaveRestore, link::capability::kContact, link::capability::kFriction,
                          link::capability::kMassRatios, link::capability::kDeterministic}};
};

/// A loose plate that swings, and a ball that falls beside it: ten windows of 0.1 ms.
inline const std::string kFreeScene = R"(name: "free_run"
end_time_s: 1e-3
window_s: 1e-4
gravity { z: -10 }
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.004
  velocity { z: 2 }
  plate { size_x_m: 0.2 size_y_m: 0.2 elements_x: 6 elements_y: 6 }
  supports { edges: U_MIN kind: CLAMPED }
}
bodies {
  name: "ball"
  material: "glass"
  sphere { radius_m: 0.02 }
  pose { position { x: 1 z: 0.5 } }
  twist { linear { x: 3 } }
}
output { frame_interval_s: 5e-4 checkpoint_interval_s: 2e-4 probes { name: "middle" shell: "pane" } }
)";

/// Runs a scene in a folder of its own, or in that of another run.
struct FreeRun {
  std::shared_ptr<TemporaryFolder> folder = std::make_shared<TemporaryFolder>();
  FreeLink::Asked asked;
  std::string text = kFreeScene;
  RunOptions options;

  FreeRun() { options.quiet = true; }
  scene::LoadedScene loaded() const {
    const std::string file = folder->path + "/given.textproto";
    std::ofstream(file) << text;
    return scene::load(file, {});
  }
  /// Returns how the run ends. Throws Error.
  Exit execute(bool interrupted = false) {
    const scene::LoadedScene scene = loaded();
    options.out = folder->path, options.scene_text = text;
    if (options.scene_hash.empty()) options.scene_hash = scene.hash;
    options.connect = [this](const RunOptions&) { return std::make_unique<FreeLink>(asked); };
    Run run(build(scene), options);
    const std::atomic<bool> stop{interrupted};
    return run.execute(stop);
  }
  std::string content(const std::string& name) const {
    std::ifstream in(folder->path + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  nlohmann::json summary() const { return nlohmann::json::parse(content("run.json")); }
};

}  // namespace sunder::shell
