// Factors of the strength at Gauss points: of regions, lines, maps and lines in space, and their product.
#include "shell/io/strength_factors.h"

#include <cmath>
#include <map>

#include "tests/shell/fixtures.h"
#include "tests/shell/io/own_file.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

/// Number of Gauss points of a shell with each factor of strength.
std::map<double, int> counted_factors(const ShellModel& m) {
  std::map<double, int> out;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) ++out[m.strength_factor_at(q, e)];
  return out;
}

struct StrengthScene {
  scene::LoadedScene scene;
  proto::Shell& shell;
  ShellModel model = brittle_sheet();  // 0.2 m, 20 x 20 elements of 2 x 2 Gauss points
  StrengthScene() : shell(*scene.message.add_shells()) {
    scene.path = small_scene::own_file("strength.textproto");
    shell.set_name("p");
  }
  proto::StrengthRegion& region(const Vec2& low, const Vec2& high, double factor) {
    proto::StrengthRegion& r = *shell.add_strength_regions();
    r.mutable_low()->set_u(low.x()), r.mutable_low()->set_v(low.y());
    r.mutable_high()->set_u(high.x()), r.mutable_high()->set_v(high.y());
    r.set_factor(factor);
    return r;
  }
  proto::SpaceLine& line(const Vec3& from, const Vec3& to, double width) {
    proto::SpaceLine& l = *scene.message.add_strength_lines();
    for (const Vec3& x : {from, to}) {
      proto::Vec3& p = *l.add_points();
      p.set_x(x.x()), p.set_y(x.y()), p.set_z(x.z());
    }
    l.set_width_m(width), l.set_factor(0.5);
    return l;
  }
  std::vector<float> factors() const { return strength_factors(scene, shell, model, "shells[0]"); }
  std::string error() const {
    try {
      factors();
      check_space_lines(scene, {&shell}, {&model});
    } catch (const Error& e) {
      EXPECT_EQ(e.status, Exit::kBadInput);
      return e.what();
    }
    return "accepted";
  }
  void expect(const std::string& says) const { EXPECT_NE(error().find(says), std::string::npos) << error(); }
};

}  // namespace

TEST(StrengthFactors, AreEmptyWhereAShellHasNone) {
  StrengthScene s;
  EXPECT_TRUE(s.factors().empty());
  s.line({-1, 0, 0}, {1, 0, 0}, 0.02).add_shells("other");
  EXPECT_TRUE(s.factors().empty());
  s.scene.message.mutable_strength_lines(0)->set_shells(0, "p");
  EXPECT_FALSE(s.factors().empty());
  s.model.material.strength = 0.0;  // what does not break has no strength to weaken
  EXPECT_TRUE(s.factors().empty());
}

// A region holds the points on its border, and a factor is stored in single precision.
TEST(StrengthFactors, OfARegionAreExact) {
  StrengthScene s;
  const Vec2 point = gauss_point(s.model.patch, s.model.tables, 6, 3).parameter;
  s.region(point, point, 0.1);  // one point is a region
  s.region({0, 0}, {0.2, 0.2}, 3.0);
  const std::vector<float> f = s.factors();
  ASSERT_EQ(f.size(), static_cast<std::size_t>(s.model.tables.blocks()) * s.model.tables.lanes);
  for (int q = 0; q < s.model.tables.blocks(); ++q)
    for (int e = 0; e < s.model.tables.spans_u; ++e) {
      const bool here = gauss_point(s.model.patch, s.model.tables, q, e).parameter == point;
      EXPECT_EQ(f[static_cast<std::size_t>(q) * s.model.tables.lanes + e], static_cast<float>(here ? 0.1 * 3.0 : 3.0));
      EXPECT_EQ(here, q == 6 && e == 3);
    }
}

TEST(StrengthFactors, BoundsOfTheProductAreAccepted) {
  for (const auto& [first, second, says] : {std::tuple{1e3, 1e3, ""},
                                            {1e-3, 1e-3, ""},
                                            {1e6, 2.0, "multiply to 2e+06 at (0.002113, 0.002113)"},
                                            {1e-6, 0.5, "multiply to 5e-07 at (0.002113, 0.002113)"}}) {
    StrengthScene s;
    s.region({0, 0}, {0.2, 0.2}, first), s.region({0, 0}, {0.1, 0.1}, second);
    if (*says == '\0') {
      EXPECT_EQ(s.error(), "accepted");
    } else {
      s.expect("shells[0].strength_regions: ");
      s.expect(says);
    }
  }
}

TEST(StrengthFactors, OfARegionBetweenGaussPointsAreRefused) {
  StrengthScene s;
  s.region({0.004, 0.004}, {0.006, 0.006}, 0.5);  // in the middle of an element
  s.expect(
      "shells[0].strength_regions[0]: holds no Gauss point of the shell, whose parameters run from 0 to 0.2 along u");
  s.expect("with a spacing of 0.01 m; move it, or make it larger");
}

TEST(SpaceLines, ThatPassNoShellAreRefused) {
  StrengthScene s;
  proto::SpaceLine& line = s.line({-1, 0, 0.01}, {1, 0, 0.01}, 0.02);  // above the sheet, at less than its length
  EXPECT_EQ(s.error(), "accepted");
  for (int i : {0, 1}) line.mutable_points(i)->set_y(0.2);
  s.expect("strength_lines[0]: passes no Gauss point of a shell with a strength");
  for (int i : {0, 1}) line.mutable_points(i)->set_y(0.0);
  s.model.material.strength = 0.0;
  s.expect("strength_lines[0]: passes no Gauss point of a shell with a strength");
}

TEST(SpaceLines, MayPassOneShellOfSeveral) {
  const StrengthScene s, t;
  scene::LoadedScene scene;
  scene.path = s.scene.path;
  EXPECT_NO_THROW(check_space_lines(scene, {}, {}));  // no lines, no shells
  StrengthScene lined;
  lined.line({-1, 0, 0}, {1, 0, 0}, 0.02);
  ShellModel far = brittle_sheet();
  for (Vec3& p : far.patch.control_points) p.z() += 10.0;
  EXPECT_NO_THROW(check_space_lines(lined.scene, {&s.shell, &t.shell}, {&far, &lined.model}));
  EXPECT_THROW(check_space_lines(lined.scene, {&s.shell}, {&far}), Error);
  EXPECT_THROW(check_space_lines(lined.scene, {}, {}), Error);
}

// The line is as wide as it says, along the surface: rows of Gauss points lie 2.11 mm and 7.89 mm from the middle.
TEST(SpaceLines, WeakenWhatIsWithinHalfTheirWidth) {
  for (const auto& [width, rows] : {std::pair{0.0101, 2}, {0.0157, 2}, {0.0159, 4}}) {
    StrengthScene s;
    s.line({-1, 0, 0}, {1, 0, 0}, width);
    s.model.strength_factor = s.factors();
    EXPECT_EQ(counted_factors(s.model)[0.5], 40 * rows) << width;
  }
  StrengthScene narrow;
  narrow.line({-1, 0, 0}, {1, 0, 0}, 0.0099);
  narrow.expect(
      "strength_lines[0].width_m: is 0.0099 m, and the longest element of shell 'p' is 0.01 m, so the line "
      "would have gaps; give 0.01001 m or more");
}

TEST(StrengthLines, WeakenWhatIsWithinHalfTheirWidth) {
  const auto setup = small_scene::built(small_scene::strong(
      "strength_lines { points { u: 0.1 v: 0 } points { u: 0.1 v: 0.3 } points { u: 0.4 v: 0.3 } width_m: 0.08 "
      "factor: 0.25 } strength_regions { low {} high { u: 0.1 v: 0.5 } factor: 2 }"));
  const auto& m = setup.shells[0].model;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, m.tables, q, e).parameter;
      const Vec2 corner(0.1, 0.3);
      const double to_first = std::hypot(p.x() - 0.1, std::max(0.0, p.y() - 0.3)),
                   to_second = std::hypot(std::max({0.1 - p.x(), 0.0, p.x() - 0.4}), p.y() - 0.3);
      const bool near = std::min(to_first, to_second) <= 0.04;
      EXPECT_EQ(m.strength_factor_at(q, e), (near ? 0.25 : 1.0) * (p.x() <= 0.1 ? 2.0 : 1.0));
    }
  EXPECT_EQ(counted_factors(m).size(), 4u);
}

// A line in space runs over both shells, and leaves out one that it does not name.
TEST(StrengthLines, InSpaceRunOverShells) {
  const std::string line =
      "strength_lines { points { x: -0.2 y: 0.05 } points { x: 0.7 y: 0.05 } width_m: 0.04 factor: 0.5 ";
  const auto both = small_scene::built(small_scene::strong("", small_scene::kWing + line + "}\n"));
  for (const auto& s : both.shells) {
    auto points = counted_factors(s.model);
    EXPECT_GT(points[0.5], 0) << s.model.name;
    EXPECT_EQ(points.size(), 2u) << s.model.name;
  }
  EXPECT_EQ(both.shells[0].model.strength_factor_at(0, 0), 1.0);
  const auto one = small_scene::built(small_scene::strong("", small_scene::kWing + line + "shells: \"wing\" }\n"));
  EXPECT_TRUE(one.shells[0].model.strength_factor.empty());
  EXPECT_EQ(counted_factors(one.shells[1].model).size(), 2u);
}

// The chord of an arc lies below it; the line weakens the arc all the same, and not what lies opposite.
TEST(StrengthLines, InSpaceFollowACurvedShell) {
  const std::string shell =
      "name: \"vault\" material: \"glass\" thickness_m: 0.01 cylinder { radius_m: 1 length_m: 1 angle_deg: 120 "
      "elements_u: 96 elements_v: 48 }";
  const auto setup = small_scene::built(
      small_scene::strong("", "shells { " + shell +
                                  " }\nstrength_lines { shells: \"vault\" width_m: 0.1 factor: 0.5 "
                                  "points { x: 0.5 y: -0.8660254 z: 0.5 } points { x: 0.5 y: 0.8660254 z: 0.5 } }\n"));
  const auto& m = setup.shells[1].model;
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const Vec3 x = m.patch.evaluate(gauss_point(m.patch, m.tables, q, e).parameter).x;
      EXPECT_EQ(m.strength_factor_at(q, e), std::abs(x.z() - 0.5) <= 0.05 ? 0.5 : 1.0) << x.transpose();
    }
}

TEST(StrengthLines, ThatAreNarrowOrElsewhereAreRefused) {
  const std::string points = "points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } ";
  const auto refused = [](const std::string& line, const std::string& field, const std::string& says) {
    small_scene::expect_refusal(small_scene::strong("strength_lines { " + line + " }"),
                                "shells[0].strength_lines[0]" + field, {says});
  };
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "would have gaps; give 0.03128 m or more");
  EXPECT_EQ(
      small_scene::refusal(small_scene::strong("strength_lines { " + points + "width_m: 0.03128 factor: 0.5 }")).kind,
      "accepted");
  refused("points { u: 1 } points { u: 2 } width_m: 0.1 factor: 0.5", "", "passes no Gauss point");
}

TEST(StrengthLines, InSpaceThatAreNarrowOrElsewhereAreRefused) {
  const std::string points = "points { x: -0.2 } points { x: 0.2 } ", rest = "width_m: 0.1 factor: 0.5 ";
  const auto refused = [](const std::string& line, const std::string& field, const std::string& says) {
    small_scene::expect_refusal(small_scene::strong("", "strength_lines { " + line + " }\n"),
                                "strength_lines[0]" + field, {says});
  };
  refused(points + "width_m: 0.01 factor: 0.5", ".width_m", "longest element of shell 'pane'");
  refused("points { z: 3 } points { x: 0.2 z: 3 } " + rest, "", "passes no Gauss point of a shell");
}

TEST(StrengthRegions, MultiplyAndScatterWithTheStrength) {
  const auto s = small_scene::built(
      small_scene::with_fields("strength_regions { low { u: 0 v: 0 } high { u: 0.25 v: 0.5 } factor: 0.3 } "
                               "strength_regions { disc { center { u: 0.25 v: 0.25 } radius_m: 0.1 } factor: 2 }",
                               small_scene::kStrong),
      {"shells[pane].strength_regions[0].factor=0.5"});
  const auto& m = s.shells[0].model;
  const auto state = make_state(m, Vec3::Zero(), 1);
  int seen[4] = {};
  for (int q = 0; q < m.tables.blocks(); ++q)
    for (int e = 0; e < m.tables.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, m.tables, q, e).parameter;
      const bool box = p.x() <= 0.25, disc = (p - Vec2(0.25, 0.25)).norm() <= 0.1;
      EXPECT_EQ(state.layers.strength[static_cast<std::size_t>(q) * m.tables.lanes + e],
                6e7 * (box ? 0.5 : 1.0) * (disc ? 2.0 : 1.0));
      ++seen[box + 2 * disc];
    }
  for (const int n : seen) EXPECT_GT(n, 0);
  EXPECT_TRUE(
      small_scene::built(small_scene::with_fields("", small_scene::kStrong)).shells[0].model.strength_factor.empty());
}

TEST(StrengthMap, IsStretchedOverTheDomainLinearBetweenPixels) {
  // black, grey; white, 100 of 200: the first row is at the top, v = 0.5
  for (const std::string& content :
       {std::string("P2\n# made by hand\n2 2 200\n0 100\n200 100\n"), std::string("P5 2 2 200\n\x00\x64\xc8\x64", 15),
        std::string("P5 2 2 2000\n\x00\x00\x03\xe8\x07\xd0\x03\xe8", 20)}) {
    const OwnFile map("stretched.pgm", content);
    const auto m = small_scene::built(
                       small_scene::with_fields(
                           fmt::format("strength_map {{ path: \"{}\" low_factor: 0.5 high_factor: 1.5 }}", map.name),
                           small_scene::kStrong))
                       .shells[0]
                       .model;
    for (int q = 0; q < m.tables.blocks(); ++q)
      for (int e = 0; e < m.tables.spans_u; ++e) {
        const Vec2 p = gauss_point(m.patch, m.tables, q, e).parameter / 0.5;
        const double a = std::clamp(2.0 * p.x() - 0.5, 0.0, 1.0), b = std::clamp(2.0 * p.y() - 0.5, 0.0, 1.0);
        EXPECT_NEAR(m.strength_factor_at(q, e), 0.5 + (1.0 - a) * b * 0.0 + (1.0 - a) * (1.0 - b) * 1.0 + a * 0.5,
                    1e-6);
      }
  }
}

TEST(StrengthRegions, ElsewhereOrOutOfBoundsAreRefused) {
  const std::string box = "low { u: 0.1 v: 0.1 } high { u: 0.3 v: 0.3 } ";
  const auto refused = [](const std::string& region, const std::string& field, const std::string& says) {
    small_scene::expect_refusal(small_scene::with_fields("strength_regions { " + region + " }", small_scene::kStrong),
                                "shells[0].strength_regions" + field, {says});
  };
  refused("low { u: 0.6 } high { u: 0.7 v: 1 } factor: 2", "[0]", "holds no Gauss point");
  refused(box + "factor: 1e6 } strength_regions { " + box + "factor: 10", "", "multiply to 1e+07");
}
