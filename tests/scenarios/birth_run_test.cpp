// The engine's state of a new body is compared with what the shell has lost.
#include <algorithm>

#include <fmt/format.h>
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

// An engine that reports another mass, velocity or spin of each new body than it received.
struct Forgetful final : link::Engine {
  rigid::FreeFlight exact;
  double mass = 0.0, momentum = 0.0, spin = 0.0;  // relative errors that it adds
  bool rounds = false;                            // declares no double precision
  link::EngineInfo info() const override {
    link::EngineInfo info = exact.info();
    if (rounds) std::erase(info.capabilities, link::capability::kDoublePrecision);
    return info;
  }
  void add(const RigidBody& body) override { exact.add(body); }
  void set_contact_laws(const std::vector<ContactLaw>&) override {}
  void advance(double window_s, const std::vector<link::Motion>& predicted,
               const std::vector<BodyId>& solved) override {
    exact.advance(window_s, predicted, solved);
  }
  std::string save() override { return exact.save(); }
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

// Three cuts: on the seam, beside it with no control point between, and beside it with some between, where a strip
// detaches.
TEST(Birth, PlatesThatACutAlongTheirSeamPartsAreTwoBodies) {
  for (const bool matching : {true, false})
    for (const double beside : {0.0, 5e-6, 0.003}) {
      std::string text =
          "name: \"joined\" end_time_s: 1e-3 window_s: 1e-5\n"
          "materials { name: \"plaster\" density: 1000 youngs_modulus: 3e9 poisson_ratio: 0.2 }\n"
          "fracture { mode: CUTS }\noutput { frame_interval_s: 1e9 checkpoint_interval_s: 0 }\nseams {}\n";
      for (const int k : {0, 1})
        text += fmt::format(
            "shells {{ name: \"p{}\" material: \"plaster\" thickness_m: 0.002 plate {{ size_x_m: 0.2 size_y_m: 0.2\n"
            "  elements_x: 20 elements_y: {} pose {{ position {{ x: {} }} }} }} velocity {{ x: {} z: 3 }} {} }}\n",
            k, k == 1 && !matching ? 27 : 20, 0.2 * k, k,
            k == 0 ? fmt::format("cuts {{ points {{ u: {0} v: 0 }} points {{ u: {0} v: 0.2 }} }}", 0.2 - beside) : "");
      rigid::FreeFlight engine;
      std::vector<double> mass, speed;
      EXPECT_EQ(run_text(text, engine,
                         [&](double, double, const auto& all) {
                           mass.clear(), speed.clear();
                           for (const auto& b : all) mass.push_back(b->mass), speed.push_back(b->motion.velocity.x());
                         }),
                "");
      ASSERT_EQ(mass.size(), beside == 0.003 ? 3u : 2u) << matching << " " << beside;
      EXPECT_NEAR(*std::max_element(mass.begin(), mass.end()), 0.08, 1e-9);
      EXPECT_GT(*std::max_element(speed.begin(), speed.end()), 0.98);
      EXPECT_LT(*std::min_element(speed.begin(), speed.end()), 0.02);
    }
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

// There is only one piece all the time. It detaches because the clamp no longer holds it.
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
