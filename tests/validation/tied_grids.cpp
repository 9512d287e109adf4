// Tied surfaces of many pieces: plates and roofs, divided by two families of curves.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "shell/geometry/builders.h"
#include "tests/validation/tied_pieces.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;

// A surface over shares (x, y) from 0 to 1, divided into columns and rows by curves x = across(i, y), y = along(j, x).
struct Grid {
  int columns = 1, rows = 1;

  int cells() const { return columns * rows; }
  // Moved off even parts, so that the middle of the surface is inside of a cell. The first and the last are straight.
  double across(int i, double y) const {
    if (i == 0 || i == columns) return i == 0 ? 0.0 : 1.0;
    return (i + 0.12 + 0.15 * std::sin(2.0 * pi * y + i) + 0.1 * (y - 0.5)) / columns;
  }
  double along(int j, double x) const {
    if (j == 0 || j == rows) return j == 0 ? 0.0 : 1.0;
    return (j + 0.1 + 0.13 * std::sin(2.0 * pi * x - 0.7 * j)) / rows;
  }
  // Where two curves cross: each is flat enough for this to contract.
  Vec2 crossing(int i, int j) const {
    Vec2 x(static_cast<double>(i) / columns, static_cast<double>(j) / rows);
    for (int k = 0; k < 200; ++k) x = Vec2(across(i, x.y()), along(j, x.x()));
    return x;
  }
  // The four sides of a cell, counter-clockwise from the lower one.
  std::array<PlaneCurve, 4> sides(int i, int j) const {
    const Grid g = *this;
    const auto row = [g](int j, const Vec2& a, const Vec2& b) {
      return PlaneCurve{[=](double t) {
                          const double x = a.x() + t * (b.x() - a.x());
                          return Vec2(x, g.along(j, x));
                        },
                        (b - a).norm(), false};
    };
    const auto column = [g](int i, const Vec2& a, const Vec2& b) {
      return PlaneCurve{[=](double t) {
                          const double y = a.y() + t * (b.y() - a.y());
                          return Vec2(g.across(i, y), y);
                        },
                        (b - a).norm(), false};
    };
    const Vec2 a = crossing(i, j), b = crossing(i + 1, j), c = crossing(i + 1, j + 1), d = crossing(i, j + 1);
    return {row(j, a, b), column(i + 1, b, c), row(j + 1, c, d), column(i, d, a)};
  }
  // Number of the cell with a place inside; cells count along rows.
  int cell_of(const Vec2& x) const {
    int i = 0, j = 0;
    while (i + 1 < columns && across(i + 1, x.y()) < x.x()) ++i;
    while (j + 1 < rows && along(j + 1, x.x()) < x.y()) ++j;
    return j * columns + i;
  }
  int seams() const { return (columns - 1) * rows + columns * (rows - 1); }
};

// Elements along a metre, or a side, of piece k: no two neighbours match.
int elements_of(int k, int elements) { return elements + 5 * (k % 3) - 2 * (k % 4); }

// Every piece is cut from a patch of its own, turned by another angle.
struct PlateGrid {
  Grid grid;
  int elements;

  Vec2 middle(int k) const {
    return Vec2((k % grid.columns + 0.55) / grid.columns, (k / grid.columns + 0.55) / grid.rows);
  }
  double side() const { return 1.9 / std::min(grid.columns, grid.rows); }  // of a patch [m]
  double turn(int k) const { return 0.3 + 0.37 * k; }                      // [rad]
  Vec2 on(int k, const Vec2& x) const {
    return Eigen::Rotation2Dd(-turn(k)) * (x - middle(k)) + Vec2::Constant(0.5 * side());
  }
  Pieces pieces() const {
    Pieces out;
    for (int k = 0; k < grid.cells(); ++k) {
      const int n = static_cast<int>(std::lround(side() * elements_of(k, elements)));
      const PlateGrid own = *this;
      const PieceOf piece{plate(side(), side(), n, n, Vec3(middle(k).x(), middle(k).y(), 0.0),
                                Quat(Eigen::AngleAxisd(turn(k), Vec3::UnitZ())), 2),
                          [own, k](const Vec2& x) { return own.on(k, x); }};
      std::vector<CadBorder> borders;
      for (const PlaneCurve& c : grid.sides(k % grid.columns, k / grid.columns)) borders.push_back(piece.border(c));
      std::vector<Load> loads;
      if (grid.cell_of({0.5, 0.5}) == k) loads.push_back(point_load(on(k, {0.5, 0.5}), 1.0));
      for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)})
        if (grid.cell_of(corner) == k) loads.push_back(point_load(on(k, corner), -0.25));
      piece.add_to(out, fmt::format("piece{}", k), borders, kTiedThickness, steel(), {}, loads);
    }
    out.find_seams();
    return out;
  }
  // Deflection of the middle against the corners [m].
  double bent(TiedSystem& system, const Eigen::VectorXd& u) const {
    const auto at = [&](const Vec2& x) { return system.value(u, grid.cell_of(x), on(grid.cell_of(x), x), 2); };
    return at({0.5, 0.5}) - 0.25 * (at({0, 0}) + at({1, 0}) + at({0, 1}) + at({1, 1}));
  }
};

// Stable step of pieces, below 0.8 of the least of whole surfaces with the elements of each.
void add_step(Report& r, const std::string& name, const Pieces& pieces, int threads, const Grid& grid,
              const std::function<Pieces(int)>& whole, int elements) {
  double least = INFINITY;
  for (int k = 0; k < std::min(grid.cells(), 12); ++k)
    least = std::min(least, step_of(whole(elements_of(k, elements)), threads));
  const double step = step_of(pieces, threads) / least;
  r.add_step(name + "_step", step, 0.0, " of the least of whole ones'");
}

void plate_grid(Report& r, int threads, const Grid& grid) {
  constexpr int kElements = 24;
  constexpr double kHeld = 1e-4;  // of the lowest eigenvalue, as in tied.cpp
  const std::string name = fmt::format("tied_plate_{}", grid.cells());
  const double start = seconds_now(), slow = slow_of_plate();
  const PlateGrid divided{grid, kElements};
  const Pieces pieces = divided.pieces(), one = whole_plate(2 * kElements, 2);
  r.add(name + "_seams", static_cast<double>(pieces.stitches.seams.size()), grid.seams(), 0.0, 0.0);
  TiedSystem tied(pieces), whole(one);
  double mass = 0.0;
  for (const ShellModel& m : pieces.models)
    for (const double part : m.mass) mass += part;
  r.add(name + "_mass", mass, steel().density * kTiedThickness, 1e-6, 0.0);
  const Eigen::VectorXd u = tied.solve(tied.load(), kHeld * slow), v = whole.solve(whole.load(), kHeld * slow);
  double wanted = whole.value(v, 0, {0.5, 0.5}, 2);
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)})
    wanted -= 0.25 * whole.value(v, 0, corner, 2);
  r.add(name + "_deflection", divided.bent(tied, u), wanted, 0.005, seconds_now() - start);
  add_frequencies(r, name, tied, whole, 0.1 * slow, 6);
  add_step(
      r, name, pieces, threads, grid, [](int n) { return whole_plate(n, 2); }, kElements);
}

// A part of a cylinder under its weight. Every piece is cut from a whole patch with elements of its own.
struct Arc {
  std::string name;
  double radius, length, angle, thickness;  // [m], [rad]
  ShellMaterial material;
  Support support;  // of edges of the whole
  double gravity;   // [m/s^2]
  double held;      // [1/s^2], stiffness in proportion to the mass where something is free
  double slow;      // [1/s^2], shift of the search for frequencies
  int rigid;        // motions without stiffness
  Vec2 probe;       // share at which the sag is taken
  int elements;     // of a piece, about; along a side of the whole

  Pieces pieces(const Grid& grid, int elements, bool whole) const {
    Pieces out;
    for (int k = 0; k < grid.cells(); ++k) {
      const int n = whole ? elements : elements_of(k, elements);
      const Patch patch = cylinder(radius, length, angle, n, whole ? n : n + 1 - 3 * (k % 2)),
                  lengths = with_parameters_as_lengths(patch);
      const Vec2 size(lengths.knots_u.end(), lengths.knots_v.end());
      const PieceOf piece{patch, [size](const Vec2& share) { return Vec2(share.cwiseProduct(size)); }};
      const int i = k % grid.columns, j = k / grid.columns;
      const std::array<int, 4> edges{j == 0 ? kVMin : 0, i + 1 == grid.columns ? kUMax : 0,
                                     j + 1 == grid.rows ? kVMax : 0, i == 0 ? kUMin : 0};
      std::vector<CadBorder> borders;
      Support own = support;
      own.edges &= edges[0] | edges[1] | edges[2] | edges[3];
      const auto sides = grid.sides(i, j);
      for (int e = 0; e < 4 && !whole; ++e) borders.push_back(piece.border(sides[e], edges[e]));
      piece.add_to(out, fmt::format("piece{}", k), borders, thickness, material,
                   own.edges != 0 ? std::vector<Support>{own} : std::vector<Support>{}, {});
    }
    if (!whole) out.find_seams();
    return out;
  }
  // Along the first axis, which is up [m].
  double sag(TiedSystem& system, const Pieces& p, const Grid& grid) const {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(system.count());
    for (std::size_t k = 0; k < p.models.size(); ++k)
      for (int i = 0; i < p.models[k].control_points(); ++i)
        if (const int n = system.degree(static_cast<int>(k), p.models[k].tables.slot(i), 0); n >= 0)
          load[n] = -gravity * system.mass()[n];
    const Eigen::VectorXd u = system.solve(load, held);
    const int shell = grid.cell_of(probe);
    const Patch& patch = p.models[shell].patch;
    return -system.value(u, shell, {probe.x() * patch.knots_u.end(), probe.y() * patch.knots_v.end()}, 0);
  }
};

// The roof of Scordelis and Lo (1964), as in tied.cpp.
Arc roof_arc() {
  ShellMaterial material;
  material.density = 360.0, material.youngs_modulus = 4.32e8, material.poisson_ratio = 0.0;
  Support diaphragm;
  diaphragm.edges = kVMin | kVMax, diaphragm.clamped = false, diaphragm.axes = {true, true, false};
  return {"roof", 25.0, 50.0, 80.0 * pi / 180.0, 0.25, material, diaphragm, 1.0, 1e-6, 1e-2, 1, {0.0, 0.5}, 24};
}

// A third of a cylinder whose places along one arc are held. Its free end bends without stretch, which quadratic
// elements follow with their square only, so pieces of 24 elements would miss by more than is asked of the ties. The
// arc is hinged, since a clamp holds its second row of control points along the length too, an error of first order.
Arc panel_of_a_cylinder() {
  Support hinge;
  hinge.edges = kVMin, hinge.clamped = false;
  return {"cylinder", 0.5, 1.0, 2.0 * pi / 3.0, 0.01, steel(), hinge, 9.81, 0.0, 1e3, 0, {0.5, 1.0}, 48};
}

void arc_grid(Report& r, int threads, const Arc& arc, const Grid& grid) {
  const std::string name = fmt::format("tied_{}_{}", arc.name, grid.cells());
  const double start = seconds_now();
  const Pieces pieces = arc.pieces(grid, arc.elements, false), one = arc.pieces({}, 2 * arc.elements, true);
  r.add(name + "_seams", static_cast<double>(pieces.stitches.seams.size()), grid.seams(), 0.0, 0.0);
  TiedSystem tied(pieces), whole(one);
  const double sag = arc.sag(tied, pieces, grid), wanted = arc.sag(whole, one, {});
  r.add(name + "_sag", sag, wanted, 0.005, seconds_now() - start);
  add_frequencies(r, name, tied, whole, arc.slow, arc.rigid);
  add_step(
      r, name, pieces, threads, grid, [&](int n) { return arc.pieces({}, n + 1, true); }, arc.elements);
}

}  // namespace

std::vector<Case> tied_grid_cases() {
  std::vector<Case> out;
  const auto add = [&](const std::string& name, const char* what, std::function<void(Report&, int)> run) {
    out.push_back({name, what, std::move(run)});
  };
  const Grid two{2, 1}, four{2, 2}, twelve{4, 3};
  for (const Grid& g : {four, twelve})
    add(fmt::format("tied_plate_{}", g.cells()), "a plate of so many pieces that meet along curves",
        [g](Report& r, int threads) { plate_grid(r, threads, g); });
  for (const Grid& g : {four, twelve})
    add(fmt::format("tied_roof_{}", g.cells()), "the Scordelis-Lo roof of so many pieces that meet along curves",
        [g](Report& r, int threads) { arc_grid(r, threads, roof_arc(), g); });
  for (const Grid& g : {two, four, twelve})
    add(fmt::format("tied_cylinder_{}", g.cells()), "a hinged panel of a cylinder of so many pieces under its weight",
        [g](Report& r, int threads) { arc_grid(r, threads, panel_of_a_cylinder(), g); });
  return out;
}

}  // namespace sunder::validation
