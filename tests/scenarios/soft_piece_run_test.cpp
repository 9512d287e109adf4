// A piece that its own weight bends stays a shell; a stiff one becomes a rigid body.
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "rigid/engine/free_flight.h"
#include "tests/validation/coupled.h"

using namespace sunder;
using namespace sunder::validation;

namespace {

struct Fall {
  std::size_t bodies = 0;  // at the end
  double elastic = 0.0;    // at the end [J]
};

// A square of 16 cm is cut out of a clamped cloth of 20 cm and falls. Its half diagonal is 11 cm; cloth of Young's
// modulus 3.2 kPa sags over 3.3 cm. `post`: a ball stands 1 cm below its middle.
Fall fall(const std::string& pieces, bool post, double youngs_modulus = 3200.0) {
  std::string text = fmt::format(
      "name: \"soft\" end_time_s: 0.12 window_s: 1e-3\n"
      "materials {{ name: \"cloth\" density: 20 youngs_modulus: {} poisson_ratio: 0.3 }}\n"
      "shells {{ name: \"cloth\" material: \"cloth\" thickness_m: 0.005 {}\n"
      "  plate {{ size_x_m: 0.2 size_y_m: 0.2 elements_x: 20 elements_y: 20 }}\n"
      "  supports {{ edges: ALL kind: CLAMPED }}\n"
      "  cuts {{ points {{ u: 0.02 v: 0.02 }} points {{ u: 0.18 v: 0.02 }} points {{ u: 0.18 v: 0.18 }}\n"
      "    points {{ u: 0.02 v: 0.18 }} points {{ u: 0.02 v: 0.02 }} }} }}\n"
      "output {{ frame_interval_s: 1e9 checkpoint_interval_s: 0 }}\n",
      youngs_modulus, pieces);
  if (post)
    text +=
        "materials { name: \"stone\" density: 2000 }\n"
        "bodies { name: \"post\" material: \"stone\" is_static: true sphere { radius_m: 0.03 } pose { position { z: "
        "-0.0425 } } }\n";
  rigid::FreeFlight engine;
  Fall out;
  WatchedRun end;
  EXPECT_EQ(run_text(
                text, engine, [&](double, double, const auto& all) { out.bodies = all.size(); }, &end),
            "");
  out.elastic = nlohmann::json::parse(end.summary).at("energy").at("elastic").get<double>();
  return out;
}

}  // namespace

TEST(SoftPiece, BendsOverABodyAndNeverBecomesAShard) {
  const Fall on_post = fall("", true), free = fall("", false);
  EXPECT_EQ(on_post.bodies, 1u);  // the post
  EXPECT_EQ(free.bodies, 0u);
  // only the rim, which stays clamped, holds energy where the square falls freely
  EXPECT_GT(on_post.elastic, 3.0 * free.elastic);
}

TEST(SoftPiece, BecomesAShardWhereTheSceneSaysSo) {
  EXPECT_EQ(fall("pieces: RIGID", true).bodies, 3u);  // the post, the square and the frozen rim
}

TEST(SoftPiece, AStiffOneBecomesAShardUnlessTheSceneSaysOtherwise) {
  constexpr double kStiff = 3.2e6;  // sags over 33 cm
  EXPECT_EQ(fall("", true, kStiff).bodies, 3u);
  EXPECT_EQ(fall("pieces: SOFT", true, kStiff).bodies, 1u);
}
