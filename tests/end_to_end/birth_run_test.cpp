// What an engine makes of a piece as it is born is compared with what the shell has lost.
#include <gtest/gtest.h>

#include "rigid/engine/free_flight.h"
#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

const std::string kCutPane =
    "name: \"cut\" end_time_s: 1e-3 window_s: 1e-4 gravity { z: -9.81 }\n"
    "materials { name: \"glass\" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }\n"
    "shells { name: \"pane\" material: \"glass\" thickness_m: 0.004 velocity { z: -1 }\n"
    "  plate { size_x_m: 0.3 size_y_m: 0.3 elements_x: 12 elements_y: 12 } supports { edges: ALL kind: CLAMPED }\n"
    "  cuts { circle { center { u: 0.15 v: 0.15 } radius_m: 0.06 } time_s: 2e-4 } }\n"
    "fracture { mode: CUTS }\noutput { frame_interval_s: 1e9 checkpoint_interval_s: 0 }\n";

// Says of every body another mass, velocity or spin than it was given.
struct Forgetful final : link::Engine {
  rigid::FreeFlight exact;
  double mass = 0.0, momentum = 0.0, spin = 0.0;  // that it adds to 1
  bool rounds = false;                            // declares no double precision
  link::EngineInfo info() const override {
    link::EngineInfo info = exact.info();
    if (rounds) std::erase(info.capabilities, link::capability::kDoublePrecision);
    return info;
  }
  void add(const RigidBody& body) override { exact.add(body); }
  void set_contact_laws(const std::vector<ContactLaw>&) override {}
  void advance(double window_s, const std::vector<link::Motion>& handbacks,
               const std::vector<BodyId>& solved) override {
    exact.advance(window_s, handbacks, solved);
  }
  std::vector<link::State> states() const override {
    std::vector<link::State> out = exact.states();
    for (link::State& s : out) {
      s.mass *= 1.0 + mass, s.motion.velocity *= 1.0 + momentum;
      s.motion.angular_momentum += spin * Vec3::UnitX();
    }
    return out;
  }
};

}  // namespace

TEST(Birth, AnEngineThatKeepsWhatItIsGivenIsTaken) {
  Forgetful engine;
  std::size_t bodies = 0;
  EXPECT_EQ(run_text(kCutPane, engine, [&](double, double, const auto& all) { bodies = all.size(); }), "");
  EXPECT_EQ(bodies, 1u);
}

TEST(Birth, OneThatLosesMassMomentumOrSpinStopsTheRun) {
  for (double Forgetful::*const what : {&Forgetful::mass, &Forgetful::momentum, &Forgetful::spin}) {
    Forgetful engine;
    engine.*what = 1e-6;
    const std::string failure = run_text(kCutPane, engine, {});
    EXPECT_EQ(failure.rfind("ledger: window ", 0), 0u) << failure;
    EXPECT_NE(failure.find("in the engine"), std::string::npos) << failure;
  }
}

TEST(Birth, AnEngineOfSinglePrecisionMayRoundAndNoMore) {
  Forgetful engine;
  engine.rounds = true, engine.momentum = 1e-6;
  EXPECT_EQ(run_text(kCutPane, engine, {}), "");
  Forgetful worse;
  worse.rounds = true, worse.momentum = 1e-3;
  EXPECT_EQ(run_text(kCutPane, worse, {}).rfind("ledger: window ", 0), 0u);
}

// Nothing else parts: there is one piece all the time, and it leaves because the clamp no longer holds it.
TEST(Birth, OfAPlateThatBreaksOffItsClampLeavesNothingBehind) {
  const std::string plate =
      "name: \"plate\" end_time_s: 8e-3 window_s: 1e-4 gravity {}\n"
      "materials { name: \"glass\" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 strength: 80e6\n"
      "  fracture_energy: 20 }\n"
      "shells { name: \"pane\" material: \"glass\" thickness_m: 0.004\n"
      "  plate { size_x_m: 0.2 size_y_m: 0.1 elements_x: 20 elements_y: 10 }\n"
      "  strength_regions { factor: 0.5 low { u: 0 v: 0 } high { u: 0.01 v: 0.1 } }\n"
      "  supports { edges: U_MIN kind: CLAMPED } loads { pressure: 3.2e3 } }\n"
      "fracture { mode: TIPS seed: 1 quiet_time_s: 1 latest_freeze_s: 1 }\n"
      "output { frame_interval_s: 1e9 checkpoint_interval_s: 0 }\n";
  rigid::FreeFlight engine;
  double first = -1.0, mass = 0.0;
  std::size_t bodies = 0;
  EXPECT_EQ(run_text(plate, engine,
                     [&](double time, double, const auto& all) {
                       if (first < 0.0 && !all.empty()) first = time;
                       bodies = all.size(), mass = 0.0;
                       for (const RigidBody* body : all) mass += body->mass;
                     }),
            "");
  EXPECT_GT(first, 0.0);
  EXPECT_LT(first, 7e-3);
  EXPECT_EQ(bodies, 1u);
  EXPECT_NEAR(mass, 2500 * 0.004 * 0.02, 1e-9);
}
