// Trim loops of a shell as polygons: areas are those of the curves, and loops that do not fit are refused.
#include "shell/io/trims.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "shell/geometry/edges.h"
#include "tests/coupler/small_scene.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

const std::string kRoundHole = "trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.1 } } ";
const std::string kTriangle =
    "trims { points { u: 0.05 v: 0.05 } points { u: 0.45 v: 0.05 } points { u: 0.25 v: 0.45 } points { u: 0.05 v: 0.05 "
    "} } ";

// A plate of 0.4 m by 0.2 m in elements of 0.01 m.
Patch trimmed_plate() { return plate(0.4, 0.2, 40, 20, Vec3::Zero(), Quat::Identity()); }

void add_corners(proto::Trim& trim, const std::vector<Vec2>& points) {
  for (const Vec2& p : points) trim.add_points()->set_u(p.x()), trim.mutable_points()->rbegin()->set_v(p.y());
}
void add_disc(proto::Shell& shell, const Vec2& centre, double radius, bool hole = true) {
  proto::Trim& trim = *shell.add_trims();
  trim.set_hole(hole);
  trim.mutable_circle()->mutable_center()->set_u(centre.x()),
      trim.mutable_circle()->mutable_center()->set_v(centre.y());
  trim.mutable_circle()->set_radius_m(radius);
}

TrimLoops loops_of(const proto::Shell& shell, const std::vector<CadLoop>& of_file = {}) {
  scene::LoadedScene scene;
  scene.path = "trims.textproto";
  return make_trims(scene, shell, trimmed_plate(), "shells[4]", of_file);
}

void expect_trims_refused(const proto::Shell& shell, const std::string& field, const std::string& says,
                          const std::vector<CadLoop>& of_file = {}) {
  try {
    loops_of(shell, of_file);
    ADD_FAILURE() << says;
  } catch (const Error& e) {
    EXPECT_EQ(e.status, Exit::kBadInput);
    EXPECT_EQ(e.field, "shells[4]" + field) << e.what();
    EXPECT_NE(std::string(e.what()).find(says), std::string::npos) << e.what();
  }
}

// A straight border of a CAD face; `sides` as in CadBorder.
CadBorder straight_border(const Vec2& a, const Vec2& b, int sides = 0) {
  return {{[a, b](double t) { return Vec2(a + t * (b - a)); }, (b - a).norm(), false}, sides};
}
// The lower half of the plate, and a hole in it that is a circle.
std::vector<CadLoop> lower_half(const Vec2& centre, double radius) {
  const Patch p = trimmed_plate();
  const double end = p.knots_u.end();
  CadLoop border;
  border.borders = {straight_border({0, 0}, {end, 0}, kVMin), straight_border({end, 0}, {end, 0.1}, kUMax),
                    straight_border({end, 0.1}, {0, 0.1}), straight_border({0, 0.1}, {0, 0}, kUMin)};
  CadLoop hole;
  const PlaneCurve circle = circle_curve(centre, radius);
  hole.borders = {{{[circle](double t) { return circle.at(1.0 - t); }, circle.length, true}, 0}};
  hole.hole = true;
  return {border, hole};
}

}  // namespace

TEST(Trims, OfNoLoopAreNone) { EXPECT_TRUE(loops_of({}).empty()); }

TEST(Trims, APolygonKeepsItsCornersToTheBit) {
  const std::vector<Vec2> corners{{0.05, 0.02}, {0.3, 0.02}, {0.3, 0.15}, {0.05, 0.15}, {0.05, 0.02}};
  std::vector<Vec2> back(corners.rbegin(), corners.rend());
  for (const std::vector<Vec2>& given : {corners, back}) {
    proto::Shell shell;
    add_corners(*shell.add_trims(), given);
    const TrimLoops loops = loops_of(shell);
    ASSERT_EQ(loops.loops().size(), 1u);
    EXPECT_FALSE(loops.loops()[0].hole);
    EXPECT_TRUE(loops.loops()[0].curves.empty());
    EXPECT_EQ(loops.loops()[0].points, corners);    // counter-clockwise, whichever way it is given
    EXPECT_NEAR(loops.area(), 0.25 * 0.13, 1e-16);  // round-off
  }
}

// Chords lie inside of their arcs; corners are moved out until the area is that of the circle.
TEST(Trims, ACircleKeepsItsArea) {
  for (const double radius : {0.005, 0.03, 0.0995}) {  // from half a spacing on
    const double area = std::numbers::pi * radius * radius;
    for (const bool hole : {true, false}) {
      proto::Shell shell;
      add_disc(shell, {0.2, 0.1}, radius, hole);
      const TrimLoops loops = loops_of(shell);
      const TrimLoop& loop = loops.loops()[0];
      EXPECT_EQ(loop.hole, hole);
      EXPECT_EQ(loop.points.front(), loop.points.back());
      ASSERT_EQ(loop.curves.size(), 1u);
      EXPECT_NEAR((loop.curves[0].at(0.25) - Vec2(0.2, 0.1)).norm(), radius, 1e-15);
      // A regular polygon of n corners lacks `first` of the area. A step along normals is too short by the cosine of
      // half an angle, and leaves that share of the rest; there are three.
      const double angle = std::numbers::pi / static_cast<double>(loop.points.size() - 1);
      const double first = 1.0 - std::sin(2.0 * angle) / (2.0 * angle);
      const double bound = first * std::pow(1.0 - std::cos(angle), 3) + 1e-14;
      EXPECT_NEAR(hole ? 0.4 * 0.2 - loops.area() : loops.area(), area, bound * area) << radius;
    }
  }
}

// Where a circle touches the border, its corners stay inside of the patch.
TEST(Trims, ACircleThatTouchesTheBorderStaysInside) {
  proto::Shell shell;
  add_disc(shell, {0.1, 0.1}, 0.1, false);
  const Patch p = trimmed_plate();
  const TrimLoops loops = loops_of(shell);
  for (const Vec2& corner : loops.loops()[0].points) EXPECT_TRUE(p.contains(corner)) << corner.transpose();
}

TEST(Trims, LoopsMayRunAlongTheBorder) {
  proto::Shell shell;
  const Patch p = trimmed_plate();
  const double end = p.knots_v.end();
  add_corners(*shell.add_trims(), {{0, 0}, {0.2, 0}, {0.2, 0.2 + 1e-8}, {0, 0.2 - 1e-8}, {0, 0}});
  const TrimLoops loops = loops_of(shell);
  EXPECT_EQ(loops.loops()[0].points[2], Vec2(0.2, end));  // moved onto the border
  EXPECT_NEAR(loops.area(), 0.04, 1e-15);
}

TEST(Trims, TooManyCornersAreRefused) {
  proto::Shell shell;
  proto::Trim& trim = *shell.add_trims();
  for (int k = 0; k <= 20000; ++k) add_corners(trim, {{0.1, 0.1}});
  expect_trims_refused(shell, ".trims[0].points", "has 20001 points; at most 20000");
}

TEST(Trims, AnOutlineIsAnyOfTheLoops) {
  proto::Shell shell;
  add_disc(shell, {0.2, 0.1}, 0.02);
  add_corners(*shell.add_trims(), {{0.05, 0.02}, {0.35, 0.02}, {0.35, 0.18}, {0.05, 0.18}, {0.05, 0.02}});
  add_disc(shell, {0.3, 0.1}, 0.02);
  const double hole = std::numbers::pi * 4e-4;  // a millionth of it: what correcting the corners leaves
  EXPECT_NEAR(loops_of(shell).area(), 0.3 * 0.16 - 2.0 * hole, 1e-6 * hole);
  add_disc(shell, {0.02, 0.1}, 0.01);
  expect_trims_refused(shell, ".trims[3]", "trims[1]: the hole lies outside of the outline and cuts away nothing");
}

TEST(Trims, HolesThatTouchInAPointMeet) {
  const auto with_gap = [](double gap) {
    proto::Shell shell;
    add_corners(*shell.add_trims(), {{0.1, 0.05}, {0.15, 0.1}, {0.1, 0.15}, {0.1, 0.05}});
    add_corners(*shell.add_trims(), {{0.15 + gap, 0.1}, {0.2, 0.05}, {0.2, 0.15}, {0.15 + gap, 0.1}});
    for (proto::Trim& trim : *shell.mutable_trims()) trim.set_hole(true);
    return shell;
  };
  expect_trims_refused(with_gap(0.0), ".trims[1]", "meets trims[0] at (0.15, 0.1); loops do not meet: join them");
  EXPECT_EQ(loops_of(with_gap(1e-6)).loops().size(), 2u);
}

TEST(Trims, OfAFileCountBeforeThoseOfTheScene) {
  proto::Shell shell;
  shell.mutable_cad()->set_path("part.step");
  const std::vector<CadLoop> face = lower_half({0.1, 0.05}, 0.02);
  const double hole = std::numbers::pi * 4e-4;  // a millionth of it: what correcting the corners leaves
  EXPECT_NEAR(loops_of(shell, face).area(), 0.04 - hole, 1e-6 * hole);
  add_disc(shell, {0.3, 0.05}, 0.02);
  const TrimLoops loops = loops_of(shell, face);
  ASSERT_EQ(loops.loops().size(), 3u);
  EXPECT_EQ(loops.loops()[0].curves.size(), 4u);
  EXPECT_NEAR(loops.area(), 0.04 - 2.0 * hole, 1e-6 * hole);
}

TEST(Trims, OfAFileAreNamedByTheirFile) {
  proto::Shell shell;
  shell.mutable_cad()->set_path("part.step");
  expect_trims_refused(shell, ".cad.path", "'part.step': hole 1 of the face meets the face's border at (",
                       lower_half({0.1, 0.09}, 0.02));
  expect_trims_refused(shell, ".cad.path", "'part.step': hole 1 of the face encloses", lower_half({0.1, 0.05}, 0.002));
  add_disc(shell, {0.1, 0.05}, 0.04);
  expect_trims_refused(shell, ".trims[0]", "and hole 1 of the face are holes one in the other",
                       lower_half({0.1, 0.05}, 0.02));
  proto::Shell mesh;
  mesh.mutable_mesh()->set_path("part.obj");
  expect_trims_refused(mesh, ".mesh.path", "'part.obj': hole 1 of the surface meets the surface's border at (",
                       lower_half({0.1, 0.09}, 0.02));
}

TEST(Trims, ShapeTheShell) {
  const std::string path = small_scene::own_file("trim_scene.textproto");
  std::ofstream(path) << small_scene::with_fields(
      "trims { curve { closed: true points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { "
      "u: 0.4 v: 0.4 } points { u: 0.1 v: 0.4 } } } " +
      kRoundHole);
  const auto setup = sunder::shell::build(sunder::scene::load(path, {}));
  std::remove(path.c_str());
  const auto& m = setup.shells[0].model;
  double mass = 0.0;
  for (const double part : m.mass) mass += part;
  // A closed uniform cubic spline around a square of side a = 0.3: its area is 0.6 a^2 to the digits of a fine polygon.
  const double hole = std::numbers::pi * 0.01, found = mass / (2500 * 0.004);
  EXPECT_NEAR(found, m.trim.loops.area(), 1e-12);
  EXPECT_NEAR(
      -m.trim.loops.area() +
          [&] {
            double area = 0.0;
            const auto& p = m.trim.loops.loops()[0].points;
            for (std::size_t k = 0; k + 1 < p.size(); ++k)
              area += 0.5 * (p[k].x() * p[k + 1].y() - p[k].y() * p[k + 1].x());
            return area;
          }(),
      hole, 1e-9);
}

TEST(Trims, ThatMeetThemselvesOrEachOtherAreRefused) {
  small_scene::expect_refusal(
      small_scene::with_fields(
          "trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.4 } points { u: 0.4 v: 0.1 } points { u: "
          "0.1 v: 0.4 } points { u: 0.1 v: 0.1 } }"),
      "shells[0].trims[0]", {"meets itself at (0.25, 0.25)"});
  small_scene::expect_refusal(
      small_scene::with_fields(kRoundHole +
                               "trims { hole: true circle { center { u: 0.35 v: 0.25 } radius_m: 0.05 } }"),
      "shells[0].trims[1]", {"meets trims[0]", "join them to one"});
  small_scene::expect_refusal(
      small_scene::with_fields(kRoundHole +
                               "trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.05 } }"),
      "shells[0].trims[1]", {"one in the other", "leave the inner one out"});
  small_scene::expect_refusal(
      small_scene::with_fields(kTriangle + "trims { hole: true circle { center { u: 0.42 v: 0.42 } radius_m: 0.05 } }"),
      "shells[0].trims[1]", {"outside of the outline"});
  small_scene::expect_refusal(
      small_scene::with_fields(kTriangle + "trims { circle { center { u: 0.25 v: 0.2 } radius_m: 0.05 } }"),
      "shells[0].trims[1]", {"second outline", "two shells"});
}

TEST(Trims, ThatAreOpenAreRefused) {
  small_scene::expect_refusal(
      small_scene::with_fields(
          "trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.2 v: 0.4 } points { u: "
          "0.1 v: 0.11 } }"),
      "shells[0].trims[0].points[3]", {":10:", "it is open", "end it with its first point"});
  small_scene::expect_refusal(
      small_scene::with_fields("trims { points { u: 0.1 v: 0.1 } points { u: 0.4 v: 0.1 } points { u: 0.1 v: 0.1 } }"),
      "shells[0].trims[0].points", {"has 3 points", "three corners"});
}

TEST(Trims, ThatLeaveThePatchOrAreTooSmallAreRefused) {
  small_scene::expect_refusal(small_scene::with_fields("trims { circle { center { u: 0.25 v: 0.25 } radius_m: 0.3 } }"),
                              "shells[0].trims[0].circle", {"outside the patch", "from 0 to 0.5 along u"});
  small_scene::expect_refusal(
      small_scene::with_fields("trims { hole: true circle { center { u: 0.25 v: 0.25 } radius_m: 0.01 } }"),
      "shells[0].trims[0].circle.radius_m", {"half a spacing", "more elements"});
  small_scene::expect_refusal(
      small_scene::with_fields(
          "trims { points { u: 0.1 v: 0.1 } points { u: 0.11 v: 0.1 } points { u: 0.1 v: 0.11 } points { "
          "u: 0.1 v: 0.1 } }"),
      "shells[0].trims[0]", {"quarter of an element"});
}
