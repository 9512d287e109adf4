// Prescribed cuts as polylines: where they run, when they are made, and which edges of the patch they open.
#include "shell/io/cuts.h"

#include <cmath>

#include "shell/fracture/constants.h"
#include "tests/coupler/small_scene.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kSheet = 0.2, kElementOfSheet = 0.01;  // of brittle_sheet() [m]

std::vector<PrescribedCut> cut_of(const ShellModel& model, const std::vector<Vec2>& points) {
  scene::LoadedScene scene;
  scene.path = "cuts.textproto";
  proto::Cut cut;
  for (const Vec2& p : points) {
    proto::ParameterPoint& point = *cut.add_points();
    point.set_u(p.x()), point.set_v(p.y());
  }
  return make_cut(scene, cut, model, "shells[0].cuts[0]");
}

void expect_cut_refused(const std::vector<Vec2>& points, const std::string& field, const std::string& says) {
  try {
    cut_of(brittle_sheet(), points);
    ADD_FAILURE() << says;
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.field, "shells[0].cuts[0]" + field);
    EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
  }
}

ShellModel held_sheet(int edges, bool clamped) {
  Support support;
  support.edges = edges, support.clamped = clamped;
  return make_shell("held", plate(kSheet, kSheet, 20, 20, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2,
                    {support});
}

// What becomes of a cut from 0.25 to 0.75 of an edge; the message where it is refused.
std::string settled(const ShellModel& model, int seamed, int edge, PrescribedCut& cut) {
  scene::LoadedScene scene;
  scene.path = "cuts.textproto";
  cut.on_edges = {{edge, 0.25, 0.75}};
  try {
    settle_edges(scene, model, seamed, "shells[0].cuts[3]", cut);
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.field, "shells[0].cuts[3]");
    return e.what();
  }
  return "accepted";
}

}  // namespace

TEST(Cuts, SegmentsOnEdgesOfThePatchStandApart) {
  const ShellModel sheet = brittle_sheet();
  const double end = sheet.patch.knots_u.end();  // 0.2 m but for round-off
  const std::vector<PrescribedCut> cuts =
      cut_of(sheet, {{0.05, 0}, {0.15, 0}, {0.15, 0.1}, {end, 0.1}, {end, 0.15}, {0.1, 0.15}});
  ASSERT_EQ(cuts.size(), 1u);
  const PrescribedCut& cut = cuts[0];
  ASSERT_EQ(cut.lines.size(), 2u);
  EXPECT_EQ(cut.lines[0], (std::vector<Vec2>{{0.15, 0}, {0.15, 0.1}, {end, 0.1}}));
  EXPECT_EQ(cut.lines[1], (std::vector<Vec2>{{end, 0.15}, {0.1, 0.15}}));
  ASSERT_EQ(cut.on_edges.size(), 2u);
  EXPECT_EQ(cut.on_edges[0].edge, kVMin);
  EXPECT_NEAR(cut.on_edges[0].from, 0.25, 1e-15);  // round-off of a quotient
  EXPECT_NEAR(cut.on_edges[0].to, 0.75, 1e-15);
  EXPECT_EQ(cut.on_edges[1].edge, kUMax);
  EXPECT_NEAR(cut.on_edges[1].from, 0.5, 1e-15);
  EXPECT_NEAR(cut.on_edges[1].to, 0.75, 1e-15);
}

TEST(Cuts, SharesOfAnEdgeRiseWhicheverWayACutRuns) {
  const PrescribedCut cut = cut_of(brittle_sheet(), {{0.15, 0.2}, {0.05, 0.2}})[0];
  EXPECT_TRUE(cut.lines.empty());
  ASSERT_EQ(cut.on_edges.size(), 1u);
  EXPECT_EQ(cut.on_edges[0].edge, kVMax);
  EXPECT_LT(cut.on_edges[0].from, cut.on_edges[0].to);
}

// The line of a closed cut that begins inside stays one line.
TEST(Cuts, AClosedOneIsFollowedFromItsFirstSegmentOnAnEdge) {
  const PrescribedCut cut = cut_of(brittle_sheet(), {{0.1, 0.1}, {0.1, 0}, {0.05, 0}, {0.05, 0.1}, {0.1, 0.1}})[0];
  ASSERT_EQ(cut.on_edges.size(), 1u);
  ASSERT_EQ(cut.lines.size(), 1u);
  EXPECT_EQ(cut.lines[0], (std::vector<Vec2>{{0.05, 0}, {0.05, 0.1}, {0.1, 0.1}, {0.1, 0}}));
}

TEST(Cuts, APointBesideTheBorderIsOnIt) {
  const ShellModel sheet = brittle_sheet();
  // within a millionth of the patch, 2e-7 m
  const PrescribedCut cut = cut_of(sheet, {{0.1, 0.1}, {0.2 + 1e-7, 0.1}})[0];
  EXPECT_EQ(cut.lines[0].back().x(), sheet.patch.knots_u.end());
  expect_cut_refused({{0.1, 0.1}, {0.2 + 1e-6, 0.1}}, ".points[1]", "1e-06 m outside the patch");
}

TEST(Cuts, PointsNearerThanAnElementResolvesAreLeftOut) {
  std::vector<Vec2> points;
  for (int k = 0; k <= 100; ++k) points.emplace_back(0.02 + 1e-3 * k, 0.1);
  for (int k = 1; k <= 50; ++k) points.emplace_back(0.12, 0.1 + 1e-3 * k);
  const std::vector<Vec2> line = cut_of(brittle_sheet(), points)[0].lines[0];
  EXPECT_EQ(line, (std::vector<Vec2>{points.front(), points[100], points.back()}));
  // half a spacing apart, all of them stay
  const std::vector<Vec2> few{{0.02, 0.1}, {0.025, 0.1}, {0.03, 0.1}};
  EXPECT_EQ(cut_of(brittle_sheet(), {few[0], few[1] + Vec2(1e-5, 0), few[2] + Vec2(2e-5, 0)})[0].lines[0].size(), 3u);
}

// Gauss points of an element of a are 0.211 a from its corners.
TEST(Cuts, ARingRoundNoGaussPointIsRefused) {
  const auto ring = [](double half) {
    return std::vector<Vec2>{{0.1 - half, 0.1 - half},
                             {0.1 + half, 0.1 - half},
                             {0.1 + half, 0.1 + half},
                             {0.1 - half, 0.1 + half},
                             {0.1 - half, 0.1 - half}};
  };
  EXPECT_EQ(cut_of(brittle_sheet(), ring(0.22 * kElementOfSheet)).size(), 1u);
  expect_cut_refused(ring(0.2 * kElementOfSheet), "",
                     "goes round no Gauss point of the shell, whose spacing is 0.01 m");
}

TEST(Cuts, OneThatGrowsIsDividedIntoPiecesOfOneLength) {
  const ShellModel sheet = brittle_sheet();
  // 0.055 m: six pieces of at most a spacing, with the corner at the end of the third
  const Vec2 corner(0.0475, 0.1);
  const std::vector<PrescribedCut> cuts = cut_along(sheet, {{0.02, 0.1}, corner, {0.0475, 0.1275}}, 1.0, 2.5);
  ASSERT_EQ(cuts.size(), 6u);
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    ASSERT_EQ(cuts[k].lines.size(), 1u);
    const std::vector<Vec2>& line = cuts[k].lines[0];
    ASSERT_EQ(line.size(), 2u) << k;  // no segment without length at the corner
    EXPECT_NEAR((line[1] - line[0]).norm(), 0.055 / 6.0, 1e-15);
    EXPECT_NEAR(cuts[k].time, 1.0 + 1.5 * (k + 1) / 6.0, 1e-15);
    EXPECT_EQ(cuts[k].goes_on, k < 5);
    if (k > 0) {
      EXPECT_EQ(line[0], cuts[k - 1].lines[0][1]);
    }
  }
  EXPECT_LT((cuts[2].lines[0][1] - corner).norm(), 1e-15);
  EXPECT_EQ(cuts.back().time, 2.5);
}

TEST(Cuts, OneThatIsShortOrMadeAtOnceIsOnePiece) {
  const ShellModel sheet = brittle_sheet();
  const std::vector<Vec2> brief{{0.1, 0.1}, {0.109, 0.1}}, lengthy{{0.02, 0.1}, {0.18, 0.1}};
  const std::vector<PrescribedCut> growing = cut_along(sheet, brief, 0.25, 0.75);
  ASSERT_EQ(growing.size(), 1u);
  EXPECT_EQ(growing[0].time, 0.75);
  EXPECT_FALSE(growing[0].goes_on);
  EXPECT_EQ(growing[0].lines[0], brief);
  for (const double until : {0.25, 0.0}) {
    const std::vector<PrescribedCut> at_once = cut_along(sheet, lengthy, 0.25, until);
    ASSERT_EQ(at_once.size(), 1u);
    EXPECT_EQ(at_once[0].time, 0.25);
    EXPECT_FALSE(at_once[0].goes_on);
    EXPECT_EQ(at_once[0].lines[0], lengthy);
  }
}

TEST(Cuts, OnAClampedEdgeRunJustInside) {
  const double inside = kOnBorder * kElementOfSheet;
  for (const auto& [edge, axis, at] :
       {std::tuple{kUMin, 0, inside}, {kUMax, 0, kSheet - inside}, {kVMin, 1, inside}, {kVMax, 1, kSheet - inside}}) {
    PrescribedCut cut;
    EXPECT_EQ(settled(held_sheet(edge, true), 0, edge, cut), "accepted");
    EXPECT_TRUE(cut.on_edges.empty());
    ASSERT_EQ(cut.lines.size(), 1u);
    ASSERT_EQ(cut.lines[0].size(), 2u);
    for (const int end : {0, 1}) {
      EXPECT_NEAR(cut.lines[0][end][axis], at, 1e-15);  // round-off of the sheet's size
      EXPECT_NEAR(cut.lines[0][end][1 - axis], (end == 0 ? 0.25 : 0.75) * kSheet, 1e-15);
    }
  }
}

TEST(Cuts, OnAnEdgeOpenItsSeamOrAreRefused) {
  PrescribedCut cut;
  EXPECT_EQ(settled(brittle_sheet(), kVMin | kUMax, kVMin, cut), "accepted");
  EXPECT_TRUE(cut.lines.empty());
  ASSERT_EQ(cut.on_edges.size(), 1u);
  EXPECT_EQ(cut.on_edges[0].edge, kVMin);
  EXPECT_EQ(cut.on_edges[0].from, 0.25);
  EXPECT_EQ(cut.on_edges[0].to, 0.75);
  const std::string free = settled(brittle_sheet(), kUMax, kVMin, cut);
  EXPECT_NE(free.find("lies on an edge of the patch from (0.05, 0) to (0.15, 0), on which nothing hangs"),
            std::string::npos)
      << free;
  const std::string held = settled(held_sheet(kVMin, false), kVMin, kVMin, cut);
  EXPECT_NE(held.find("from (0.05, 0) to (0.15, 0) that a support holds without its slope"), std::string::npos) << held;
}

TEST(Cuts, WithoutLengthOrTooFineIsRefused) {
  small_scene::expect_refusal(
      small_scene::with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.1 } points { u: 0.2 v: 0.1 } }"),
      "shells[0].cuts[0].points[2]", {"as points[1] is", "leave one of them out"});
  small_scene::expect_refusal(small_scene::with_fields("cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.01 } }"),
                              "shells[0].cuts[0].circle.radius_m", {"half a spacing", "more elements"});
  small_scene::expect_refusal(small_scene::with_fields("cuts { curve { points {} points {} points {} points {} } }"),
                              "shells[0].cuts[0].curve", {"has no length"});
  small_scene::expect_refusal(
      small_scene::with_fields("cuts { spiral { center { u: 0.2 v: 0.2 } outer_radius_m: 0.1 turns: 40 } }"),
      "shells[0].cuts[0].spiral.turns", {"take fewer"});
}

TEST(Cuts, ThatLeavesTheDomainIsRefusedWithHowFar) {
  small_scene::expect_refusal(small_scene::with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.62 v: 0.1 } }"),
                              "shells[0].cuts[0].points[1]",
                              {":10:", "(0.62, 0.1), 0.12 m outside the patch", "from 0 to 0.5 along u"});
  small_scene::expect_refusal(small_scene::with_fields("cuts { circle { center { u: 0.1 v: 0.3 } radius_m: 0.15 } }"),
                              "shells[0].cuts[0].circle", {"outside the patch", "from 0 to 0.5 along u"});
  small_scene::expect_refusal(
      small_scene::with_fields("cuts { spiral { center { u: 0.3 v: 0.3 } outer_radius_m: 0.25 turns: 2 } }"),
      "shells[0].cuts[0].spiral", {"outside the patch"});
  small_scene::expect_refusal(
      small_scene::with_fields(
          "cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.9 } points { u: 0.3 v: 0.9 } "
          "points { u: 0.4 v: 0.1 } } }"),
      "shells[0].cuts[0].curve", {"reaches", "outside the patch"});
  // control points may lie outside if the curve does not; a circle may touch the border
  EXPECT_EQ(small_scene::refusal(
                small_scene::with_fields(
                    "cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.2 v: 0.6 } points { u: 0.3 v: 0.6 } "
                    "points { u: 0.4 v: 0.1 } } } cuts { circle { center { u: 0.25 v: 0.25 } radius_m: 0.25 } }"))
                .kind,
            "accepted");
}

TEST(Cuts, ThatMeetsItselfIsRefusedWithBothSegmentsAndThePlace) {
  small_scene::expect_refusal(
      small_scene::with_fields("cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.2 v: 0.2 } "
                               "points { u: 0.2 v: 0.05 } }"),
      "shells[0].cuts[0].points[2]", {"from here to points[3]", "points[0] to points[1] at (0.2, 0.1)", "two cuts"});
  small_scene::expect_refusal(
      small_scene::with_fields(
          "cuts { curve { points { u: 0.1 v: 0.1 } points { u: 0.5 v: 0.4 } points { u: 0 v: 0.4 } "
          "points { u: 0.4 v: 0.1 } } }"),
      "shells[0].cuts[0].curve", {"meets itself at (0.25", "two cuts"});
  // two cuts may cross each other, and a cut may be closed
  EXPECT_EQ(small_scene::refusal(
                small_scene::with_fields(
                    "cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } } cuts { points { u: 0.2 v: 0.2 } "
                    "points { u: 0.2 v: 0.05 } } cuts { points { u: 0.3 v: 0.3 } points { u: 0.4 v: 0.3 } "
                    "points { u: 0.3 v: 0.4 } points { u: 0.3 v: 0.3 } }"))
                .kind,
            "accepted");
}

TEST(Cuts, TakesSettingsAndKeepsItsTime) {
  const std::string text =
      small_scene::with_fields("cuts { time_s: 0.25 circle { center { u: 0.25 v: 0.25 } radius_m: 0.1 } }");
  const auto cut = small_scene::built(text, {"shells[pane].cuts[0].circle.radius_m=0.2"}).shells[0].fracture.cuts[0];
  EXPECT_EQ(cut.time, 0.25);
  ASSERT_EQ(cut.lines.size(), 1u);
  EXPECT_TRUE(cut.on_edges.empty());
  EXPECT_EQ(cut.lines[0].front(), cut.lines[0].back());
  for (const Vec2& p : cut.lines[0]) EXPECT_NEAR((p - Vec2(0.25, 0.25)).norm(), 0.2, 1e-12);
  small_scene::expect_refusal(text, "shells[0].cuts[0].circle", {"set by --set"},
                              {"shells[pane].cuts[0].circle.radius_m=0.3"});
}

TEST(Cuts, WithMorePointsThanAShellCanResolveIsRefused) {
  std::string points;
  for (int k = 0; k <= 20000; ++k) points += fmt::format("points {{ u: {} v: 0.1 }} ", 0.1 + 1e-5 * k);
  small_scene::expect_refusal(small_scene::with_fields("cuts { " + points + "}"), "shells[0].cuts[0]",
                              {"has 20001 points", "at most 20000"});
}

TEST(Cuts, GrowsInPiecesThatFollowOneAnother) {
  const std::string line = "cuts { points { u: 0.1 v: 0.1 } points { u: 0.3 v: 0.1 } points { u: 0.3 v: 0.25 } ";
  const auto setup = small_scene::built(small_scene::with_fields(
      line + "time_s: 0.2 until_s: 0.6 } cuts { points { u: 0.1 v: 0.4 } points { u: 0.2 v: 0.4 } }"));
  std::vector<sunder::shell::PrescribedCut> cuts = setup.shells[0].fracture.cuts;
  EXPECT_EQ(cuts.back().number, 1);
  EXPECT_FALSE(cuts.back().goes_on);
  cuts.pop_back();
  // 0.35 m in pieces of at most a spacing, 0.5 m / 16
  ASSERT_EQ(cuts.size(), 12u);
  double length = 0.0;
  for (std::size_t k = 0; k < cuts.size(); ++k) {
    ASSERT_EQ(cuts[k].lines.size(), 1u);
    const std::vector<Vec2>& p = cuts[k].lines[0];
    for (std::size_t i = 1; i < p.size(); ++i) length += (p[i] - p[i - 1]).norm();
    EXPECT_NEAR(cuts[k].time, 0.2 + 0.4 * length / 0.35, 1e-12);
    EXPECT_EQ(cuts[k].number, 0);
    EXPECT_EQ(cuts[k].goes_on, k + 1 < cuts.size());
    if (k > 0) {
      EXPECT_EQ(p.front(), cuts[k - 1].lines[0].back());
    }
  }
  EXPECT_NEAR(length, 0.35, 1e-12);
  EXPECT_EQ(cuts.front().lines[0].front(), Vec2(0.1, 0.1));
  EXPECT_EQ(cuts.back().lines[0].back(), Vec2(0.3, 0.25));
  EXPECT_EQ(small_scene::built(small_scene::with_fields(line + "until_s: 0.999999 }")).shells[0].fracture.cuts.size(),
            12u);
}
