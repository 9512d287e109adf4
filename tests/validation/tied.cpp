// Tied surfaces: plates and roofs of pieces that meet along curved trims, against the same surface in one piece.
#include "tests/validation/tied_pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "shell/geometry/builders.h"
#include "tests/validation/tied.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr int kRigid = 6;

// Where the pieces of a plate meet, from (0, y = 0) to y = 1.
double course(double y) { return 0.52 + 0.08 * std::sin(2.0 * pi * y) + 0.05 * (y - 0.5); }

PlaneCurve course_curve(bool back) {
  return {[back](double t) { return Vec2(course(back ? 1.0 - t : t), back ? 1.0 - t : t); }, 1.2, false};
}

const Vec2 kMiddle(0.5, 0.5), kRight(0.77, 0.51);  // of the plate, of the patch of its right piece
constexpr double kRightSide = 1.3;                 // of that patch [m]

// Parameters of a place on the right piece, whose patch is turned.
Vec2 on_right(const Vec2& x, double degrees) {
  return Eigen::Rotation2Dd(degrees * pi / 180.0).inverse() * (x - kRight) + Vec2::Constant(0.5 * kRightSide);
}

int right_elements(int elements) { return static_cast<int>(std::lround(1.07 * elements)); }

// A square plate of two pieces: the left one keeps three edges of its patch; the right one is cut from a larger, turned
// patch of other elements. A force on the middle is borne by the corners.
Pieces plate_pieces(int elements, double degrees, int degree) {
  const int left = static_cast<int>(std::lround(0.75 * elements));
  const PieceOf a{plate(0.75, 1.0, left, elements, Vec3(0.375, 0.5, 0.0), Quat::Identity(), degree),
                  [](const Vec2& x) { return x; }};
  const PieceOf b{
      plate(kRightSide, kRightSide, right_elements(elements), right_elements(elements),
            Vec3(kRight.x(), kRight.y(), 0.0), Quat(Eigen::AngleAxisd(degrees * pi / 180.0, Vec3::UnitZ())), degree),
      [degrees](const Vec2& x) { return on_right(x, degrees); }};
  Pieces out;
  const double c0 = course(0.0), c1 = course(1.0);
  a.add_to(out, "left",
           {a.border(line({0, 0}, {c0, 0}), kVMin), a.border(course_curve(false)),
            a.border(line({c1, 1}, {0, 1}), kVMax), a.border(line({0, 1}, {0, 0}), kUMin)},
           kTiedThickness, steel(), {},
           {point_load(kMiddle, 1.0), point_load({0, 0}, -0.25), point_load({0, 1}, -0.25)});
  b.add_to(out, "right",
           {b.border(line({c0, 0}, {1, 0})), b.border(line({1, 0}, {1, 1})), b.border(line({1, 1}, {c1, 1})),
            b.border(course_curve(true))},
           kTiedThickness, steel(), {},
           {point_load(on_right({1, 0}, degrees), -0.25), point_load(on_right({1, 1}, degrees), -0.25)});
  out.find_seams();
  return out;
}

void tied_plate(Report& r, int threads, double degrees, int degree) {
  constexpr int kElements = 24;
  constexpr double kHeld = 1e-4;  // of the lowest eigenvalue: stiffness in proportion to the mass holds rigid motions
  const std::string name = fmt::format("tied_{}{:.0f}", degree == 3 ? "cubic_" : "", degrees);
  const double start = seconds_now();
  const double slow = slow_of_plate();
  const Pieces pieces = plate_pieces(kElements, degrees, degree), one = whole_plate(2 * kElements, degree);
  r.add(name + "_seams", static_cast<double>(pieces.stitches.seams.size()), 1.0, 0.0, 0.0);
  TiedSystem tied(pieces), whole(one);
  double mass = 0.0;
  for (const ShellModel& m : pieces.models)
    for (const double part : m.mass) mass += part;
  r.add(name + "_mass", mass, steel().density * kTiedThickness, 1e-6, 0.0);
  const Eigen::VectorXd u = tied.solve(tied.load(), kHeld * slow), v = whole.solve(whole.load(), kHeld * slow);
  double bent = tied.value(u, 0, kMiddle, 2), wanted = whole.value(v, 0, kMiddle, 2);
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)}) {
    bent -= 0.25 * (corner.x() == 0.0 ? tied.value(u, 0, corner, 2) : tied.value(u, 1, on_right(corner, degrees), 2));
    wanted -= 0.25 * whole.value(v, 0, corner, 2);
  }
  r.add(name + "_deflection", bent, wanted, 0.005, seconds_now() - start);
  add_frequencies(r, name, tied, whole, 0.1 * slow, kRigid);
  const int like_right = static_cast<int>(std::lround(right_elements(kElements) / kRightSide));
  const double least =
      std::min(step_of(whole_plate(kElements, degree), threads), step_of(whole_plate(like_right, degree), threads));
  const double step = step_of(pieces, threads) / least;
  r.add_step(name + "_step", step, 0.0, " of the smaller of both whole plates'");
}

// The roof of Scordelis and Lo (1964): diaphragms hold its ends, its weight bends it. `divided`: in two pieces along a
// curve, of other elements on both sides.
constexpr double kTiedRadius = 25.0, kTiedLength = 50.0, kArc = 80.0 * pi / 180.0, kRoofThickness = 0.25;
constexpr double kTiedWeight = 90.0;  // for each area

Pieces roof(bool divided, int elements) {
  ShellMaterial material;
  material.density = 360.0, material.youngs_modulus = 4.32e8, material.poisson_ratio = 0.0;
  Support diaphragm;
  diaphragm.edges = kVMin | kVMax, diaphragm.clamped = false, diaphragm.axes = {true, true, false};
  const auto piece_of = [&](int nu, int nv) {
    const Patch patch = cylinder(kTiedRadius, kTiedLength, kArc, nu, nv), lengths = with_parameters_as_lengths(patch);
    const Vec2 size(lengths.knots_u.end(), lengths.knots_v.end());
    return PieceOf{patch, [size](const Vec2& share) { return Vec2(share.cwiseProduct(size)); }};
  };
  const auto at = [](double v) { return 0.46 + 0.1 * std::sin(2.0 * pi * v); };
  const PlaneCurve forth{[at](double t) { return Vec2(at(t), t); }, 1.2, false},
      back{[at](double t) { return Vec2(at(1.0 - t), 1.0 - t); }, 1.2, false};
  Pieces out;
  const PieceOf a = piece_of(elements, elements), b = piece_of(elements + 5, elements - 3);
  if (!divided) {
    a.add_to(out, "roof", {}, kRoofThickness, material, {diaphragm}, {});
    return out;
  }
  a.add_to(out, "left",
           {a.border(line({0, 0}, {at(0), 0}), kVMin), a.border(forth), a.border(line({at(1), 1}, {0, 1}), kVMax),
            a.border(line({0, 1}, {0, 0}), kUMin)},
           kRoofThickness, material, {diaphragm}, {});
  b.add_to(out, "right",
           {b.border(line({at(0), 0}, {1, 0}), kVMin), b.border(line({1, 0}, {1, 1}), kUMax),
            b.border(line({1, 1}, {at(1), 1}), kVMax), b.border(back)},
           kRoofThickness, material, {diaphragm}, {});
  out.find_seams();
  return out;
}

// Sag of the middle of a free edge, that of the first or of the last shell.
double sag(TiedSystem& system, const Pieces& p, bool first) {
  constexpr double kSlow = 1e-6;  // [1/s^2]: far below all modes; it holds the motion along the axis
  const double gravity = kTiedWeight / (p.models[0].material.density * kRoofThickness);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(system.count());
  for (std::size_t k = 0; k < p.models.size(); ++k)
    for (int i = 0; i < p.models[k].control_points(); ++i)
      if (const int n = system.degree(static_cast<int>(k), p.models[k].tables.slot(i), 0); n >= 0)
        load[n] = -gravity * system.mass()[n];
  const Eigen::VectorXd u = system.solve(load, kSlow);
  const int shell = first ? 0 : static_cast<int>(p.models.size()) - 1;
  const Patch& patch = p.models[shell].patch;
  return -system.value(u, shell, {first ? patch.knots_u.begin() : patch.knots_u.end(), 0.5 * patch.knots_v.end()}, 0);
}

void tied_roof(Report& r, int threads) {
  constexpr int kElements = 24;
  const double start = seconds_now();
  const Pieces pieces = roof(true, kElements), one = roof(false, 2 * kElements);
  r.add("tied_roof_seams", static_cast<double>(pieces.stitches.seams.size()), 1.0, 0.0, 0.0);
  TiedSystem tied(pieces), whole(one);
  const double wanted = sag(whole, one, true);
  r.add("tied_roof_sag_left", sag(tied, pieces, true), wanted, 0.005, seconds_now() - start);
  r.add("tied_roof_sag_right", sag(tied, pieces, false), wanted, 0.005, 0.0);
  add_frequencies(r, "tied_roof", tied, whole, 1e-2, 1);
  const double least = std::min(step_of(roof(false, kElements), threads), step_of(roof(false, kElements + 5), threads));
  const double step = step_of(pieces, threads) / least;
  r.add_step("tied_roof_step", step, 0.0, " of the whole roofs'");
}

}  // namespace

std::vector<Case> tied_cases() {
  std::vector<Case> out;
  for (const double degrees : {0.0, 17.0, 45.0})
    out.push_back({fmt::format("tied_{:.0f}", degrees), "a plate of two pieces that meet along a curve",
                   [degrees](Report& r, int threads) { tied_plate(r, threads, degrees, 2); }});
  out.push_back({"tied_roof", "the Scordelis-Lo roof of two pieces that meet along a curve", tied_roof});
  out.push_back({"tied_cubic_17", "the plate of tied_17, degree 3",
                 [](Report& r, int threads) { tied_plate(r, threads, 17.0, 3); }});
  for (Case& c : tied_grid_cases()) out.push_back(std::move(c));
  return out;
}

}  // namespace sunder::validation
