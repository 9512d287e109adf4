// A loose piece that a body flies towards stays a shell until it is struck, so that it can break.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "rigid/engine/free_flight.h"
#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

// Masses [kg] of the bodies at the end: a disc that is cut out of a brittle plate at the start, and a ball above it.
// `height`: of the ball's centre [m]; `end` [s].
std::vector<double> masses(double speed, double height = 0.01225, double end = 2.2e-4) {
  const std::string text = fmt::format(
      "name: \"loose\" end_time_s: {} window_s: 2e-6 gravity {{}}\n"
      "materials {{ name: \"disc\" density: 2200 youngs_modulus: 22.35e9 poisson_ratio: 0.25 strength: 11.2e6\n"
      "  fracture_energy: 20.8 }}\n"
      "materials {{ name: \"ball\" density: 7700 }}\n"
      "shells {{ name: \"disc\" material: \"disc\" thickness_m: 0.0025\n"
      "  plate {{ size_x_m: 0.08 size_y_m: 0.08 elements_x: 26 elements_y: 26 }}\n"
      "  cuts {{ circle {{ center {{ u: 0.04 v: 0.04 }} radius_m: 0.037 }} }} }}\n"
      "bodies {{ name: \"ball\" material: \"ball\" sphere {{ radius_m: 0.005 }} pose {{ position {{ z: {} }} }}\n"
      "  twist {{ linear {{ z: {} }} }} }}\n"
      "fracture {{ mode: TIPS seed: 1 }}\noutput {{ frame_interval_s: 1e9 checkpoint_interval_s: 0 }}\n",
      end, height, speed);
  rigid::FreeFlight engine;
  std::vector<double> mass;
  EXPECT_EQ(run_text(text, engine,
                     [&](double, double, const auto& all) {
                       mass.clear();
                       for (const auto& b : all) mass.push_back(b->mass);
                     }),
            "");
  return mass;
}

constexpr double kDisc = 2200 * 0.0025 * 0.0042978;  // mass of the polygon that is cut out [kg]

bool has_left_whole(const std::vector<double>& mass) {
  return std::any_of(mass.begin(), mass.end(), [](double m) { return std::abs(m - kDisc) < 0.01 * kDisc; });
}

}  // namespace

TEST(LoosePiece, BreaksWhereABodyStrikesItLater) {
  const std::vector<double> mass = masses(-100.0);
  EXPECT_FALSE(has_left_whole(mass));
  // As the same disc does where the ball is at it from the start: 60 us earlier, and the end as well.
  const std::size_t near = masses(-100.0, 0.0063, 1.6e-4).size();
  EXPECT_GE(near, 12u);
  EXPECT_GE(2 * mass.size(), near);  // patterns of few cracks are chance
  EXPECT_LE(mass.size(), 2 * near);
}

TEST(LoosePiece, LeavesAtOnceWhereNothingComesThatCouldBreakIt) {
  EXPECT_TRUE(has_left_whole(masses(100.0)));  // away from it
  EXPECT_TRUE(has_left_whole(masses(-0.5)));   // 0.4 mJ; a crack across it takes 3.4 mJ
}
