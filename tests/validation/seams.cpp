// Shells of several patches against a single patch, frames of beams, and conserved quantities.
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "coupler/core/dense.h"
#include "coupler/core/error.h"
#include "shell/geometry/builders.h"
#include "tests/validation/cases.h"
#include "tests/validation/linear.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr double kSeamYoung = 2e11, kSeamThickness = 0.01;
constexpr int kSeamModes = 4;
constexpr double kDamping = 0.6;  // share of critical damping, for frames that come to rest
constexpr double kSwings = 4.0;   // periods until they are at rest

ShellMaterial seam_steel(double poisson = 0.3) {
  ShellMaterial m;
  m.density = 7800, m.youngs_modulus = kSeamYoung, m.poisson_ratio = poisson;
  return m;
}

// Division of a surface into columns x rows patches. `finer` adds elements to each along u and v; `turn` turns
// parameters.
struct Division {
  std::string name;
  int columns, rows;
  std::function<std::pair<int, int>(int i, int j)> finer = [](int, int) { return std::pair{0, 0}; };
  bool turn = false;
};

// A surface over the shares 0 to 1 of two lengths. `piece` makes the part from (u0, v0) to (u1, v1) in nu x nv
// elements.
struct Shape {
  std::string name;
  int elements_u, elements_v;
  std::function<Patch(double u0, double u1, double v0, double v1, int nu, int nv)> piece;
};

Shape flat_surface() {
  return {"plate", 24, 24, [](double u0, double u1, double v0, double v1, int nu, int nv) {
            return plate(u1 - u0, 0.7 * (v1 - v0), nu, nv, Vec3(0.5 * (u0 + u1), 0.35 * (v0 + v1), 0.0),
                         Quat::Identity());
          }};
}
// Returns the part from (u0, v0) to (u1, v1), as shares of its domain, of a patch of one span, in uniform elements. It
// interpolates the patch at as many points as it has control points.
Patch part_of(const Patch& whole, double u0, double u1, double v0, double v1, int nu, int nv) {
  const auto knots = [](double from, double to, int n) {
    std::vector<double> k(2, from);
    for (int i = 0; i <= n; ++i) k.push_back(i < n ? from + (to - from) * i / n : to);
    k.insert(k.end(), 2, to);
    return KnotVector(k, 2, "part");
  };
  const double size_u = whole.knots_u.end(), size_v = whole.knots_v.end();
  Patch p{knots(u0 * size_u, u1 * size_u, nu), knots(v0 * size_v, v1 * size_v, nv), {}, {}};
  const auto collocation = [](const KnotVector& k) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(k.control_points(), k.control_points());
    for (int i = 0; i < k.control_points(); ++i) {
      const int span = k.span_of(k.greville(i));
      const Basis b = k.basis(span, k.greville(i));
      for (int d = 0; d <= 2; ++d) a(i, span + d) = b.value[d];
    }
    return solved(a, Eigen::MatrixXd::Identity(a.rows(), a.rows()));
  };
  const Eigen::MatrixXd along_u = collocation(p.knots_u), along_v = collocation(p.knots_v);
  std::vector<Eigen::MatrixXd> homogeneous(4, Eigen::MatrixXd(p.columns(), p.rows()));
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i) {
      const Vec2 at(p.knots_u.greville(i), p.knots_v.greville(j));
      double weight = 0.0;
      const Basis u = whole.knots_u.basis(0, at.x()), v = whole.knots_v.basis(0, at.y());
      for (int k = 0; k < 9; ++k) weight += u.value[k % 3] * v.value[k / 3] * whole.weights[k];
      const Vec3 x = whole.evaluate(at).x;
      for (int d = 0; d < 4; ++d) homogeneous[d](i, j) = d < 3 ? weight * x[d] : weight;
    }
  for (Eigen::MatrixXd& h : homogeneous) h = (along_u * h * along_v.transpose()).eval();
  for (int j = 0; j < p.rows(); ++j)
    for (int i = 0; i < p.columns(); ++i) {
      p.weights.push_back(homogeneous[3](i, j));
      p.control_points.push_back(Vec3(homogeneous[0](i, j), homogeneous[1](i, j), homogeneous[2](i, j)) /
                                 p.weights.back());
    }
  return p;
}

// 120 degrees of a cylinder of 1 m. Its parts keep its parametrisation, since others would change the elements.
Shape curved_surface() {
  return {"cylinder", 36, 24, [](double u0, double u1, double v0, double v1, int nu, int nv) {
            return part_of(with_parameters_as_lengths(cylinder(1.0, 1.5, 2.0 * pi / 3.0, 1, 1)), u0, u1, v0, v1, nu,
                           nv);
          }};
}

struct Divided {
  Stitched shells;
  int shell = 0;  // shell of the probe
  Vec2 at = Vec2::Zero();
  double finest_u = 1.0, finest_v = 1.0;  // side of an element, as a share of the whole
};

constexpr double kProbeU = 0.4, kProbeV = 0.3;

std::string place_name(int i, int j) { return fmt::format("p{}_{}", i, j); }

Divided divide(const Shape& whole, const Division& d) {
  std::vector<ShellModel> models;
  int shell = 0;
  Vec2 at = Vec2::Zero();
  double finest_u = 1.0, finest_v = 1.0;
  for (int j = 0; j < d.rows; ++j)
    for (int i = 0; i < d.columns; ++i) {
      const auto [more_u, more_v] = d.finer(i, j);
      const int nu = whole.elements_u / d.columns + more_u, nv = whole.elements_v / d.rows + more_v;
      finest_u = std::min(finest_u, 1.0 / (nu * d.columns)), finest_v = std::min(finest_v, 1.0 / (nv * d.rows));
      Patch p =
          whole.piece(double(i) / d.columns, (i + 1.0) / d.columns, double(j) / d.rows, (j + 1.0) / d.rows, nu, nv);
      const int times = d.turn ? (i + 2 * j + 1) % 4 : 0;
      // The border of the whole surface is held, on whichever edges it lies after the turns.
      int border[4] = {i == 0 ? kUMin : 0, j == 0 ? kVMin : 0, i + 1 == d.columns ? kUMax : 0,
                       j + 1 == d.rows ? kVMax : 0};
      constexpr int kAround[4] = {kUMin, kVMin, kUMax, kVMax};
      Support hold;
      hold.clamped = false;
      for (int side = 0; side < 4; ++side)
        if (border[side]) hold.edges |= kAround[(side + 3 * times) % 4];
      // Place of the probe as a share of the patch.
      Vec2 share(kProbeU * d.columns - i, kProbeV * d.rows - j);
      const bool here = share.minCoeff() >= 0.0 && share.maxCoeff() < 1.0;
      for (int t = 0; t < times; ++t) share = Vec2(share.y(), 1.0 - share.x());
      p = turned(p, times);
      Load pressure;
      pressure.kind = Load::Kind::kPressure, pressure.size = 1000.0;
      models.push_back(make_shell(place_name(i, j), p, kSeamThickness, seam_steel(), 2, 2,
                                  hold.edges ? std::vector<Support>{hold} : std::vector<Support>{}, {pressure}));
      if (here) {
        shell = static_cast<int>(models.size()) - 1;
        const Patch& own = models.back().patch;
        at = share.cwiseProduct(Vec2(own.knots_u.end(), own.knots_v.end()));
      }
    }
  return {Stitched(std::move(models)), shell, at, finest_u, finest_v};
}

double probe(const Divided& d, const Displacement& u) {
  const ShellModel& m = d.shells.model(d.shell);
  std::vector<Vec3> net;
  for (int i = 0; i < m.control_points(); ++i) {
    const std::vector<double>& all = u[d.shell];
    const int slot = m.tables.slot(i), stride = static_cast<int>(all.size() / 3);
    net.emplace_back(all[slot], all[stride + slot], all[2 * stride + slot]);
  }
  const SurfacePoint x = m.patch.evaluate(d.at);
  return m.patch.evaluate(d.at, net).x.dot(x.u.cross(x.v).normalized());
}

// Returns the motion of the probe along the normal [m] in `steps` steps from rest under the load.
std::vector<double> swing_of(Divided& d, double dt, int steps) {
  std::vector<double> out;
  const SurfacePoint x = d.shells.model(d.shell).patch.evaluate(d.at);
  const Vec3 normal = x.u.cross(x.v).normalized();
  for (int k = 0; k < steps; ++k) {
    d.shells.step(dt);
    out.push_back((d.shells.at(d.shell, d.at) - x.x).dot(normal));
  }
  return out;
}

void surface_case(Report& r, const Shape& whole) {
  const auto differ = [](int most) {
    return [most](int i, int j) { return std::pair{(i + 2 * j) % (most + 1), (2 * i + j + 1) % (most + 1)}; };
  };
  const std::vector<Division> divisions{{"2", 2, 1},
                                        {"2_other_knots", 2, 1,
                                         [](int i, int) {
                                           return std::pair{0, 5 * i};
                                         }},
                                        {"4", 2, 2},
                                        {"4_turned", 2, 2,
                                         [](int, int) {
                                           return std::pair{0, 0};
                                         },
                                         true},
                                        {"4_other_knots", 2, 2, differ(3)},
                                        {"4_turned_other_knots", 2, 2, differ(3), true},
                                        {"12", 4, 3},
                                        {"12_other_knots", 4, 3, differ(2)}};
  Divided single = divide(whole, {"1", 1, 1});
  const Linear exact = linear_response(single.shells, kSeamModes);
  const double u_single = probe(single, exact.under_load), step_single = single.shells.stable();
  const double dt = 0.5 * step_single;
  // One swing up and down in the lowest mode.
  const int steps = static_cast<int>(2.0 * pi / exact.frequencies[0] / dt);
  const std::vector<double> swing_single = swing_of(single, dt, steps);
  const auto largest = [](const std::vector<double>& v) {
    double most = 0.0;
    for (const double x : v) most = std::max(most, std::abs(x));
    return most;
  };
  for (const Division& way : divisions) {
    const double start = seconds_now();
    Divided d = divide(whole, way);
    const std::string name = whole.name + "_" + way.name;
    const double step = d.shells.stable();
    // A single patch with the spacing of the finest of these patches.
    const Division fine{"", 1, 1, [&](int, int) {
                          return std::pair{int(std::lround(1.0 / d.finest_u)) - whole.elements_u,
                                           int(std::lround(1.0 / d.finest_v)) - whole.elements_v};
                        }};
    const double reference = divide(whole, fine).shells.stable();
    const Linear found = linear_response(d.shells, kSeamModes);
    r.add(name + "_displacement", probe(d, found.under_load), u_single, 0.005, seconds_now() - start);
    for (int k = 0; k < kSeamModes; ++k)
      r.add(fmt::format("{}_frequency_{}", name, k + 1), found.frequencies[k], exact.frequencies[k], 0.005, 0.0);
    r.add(name + "_stable_step", step, reference, 0.1, 0.0);
    const double middle = seconds_now();
    const std::vector<double> moved = swing_of(d, dt, steps);
    std::vector<double> off(moved.size());
    for (std::size_t k = 0; k < moved.size(); ++k) off[k] = moved[k] - swing_single[k];
    r.add(name + "_swing", largest(off) / largest(swing_single), 0.0, 0.005, seconds_now() - middle);
  }
  r.lines.push_back(
      fmt::format("{}: {} x {} elements, displacement {:.4e} m, frequencies {:.1f} {:.1f} {:.1f} {:.1f} "
                  "Hz, stable step {:.3e} s; swing: largest difference over {} substeps",
                  whole.name, whole.elements_u, whole.elements_v, u_single, exact.frequencies[0] / (2 * pi),
                  exact.frequencies[1] / (2 * pi), exact.frequencies[2] / (2 * pi), exact.frequencies[3] / (2 * pi),
                  step_single, steps));
}

// A strip of width kWidth from a to b in the plane across y, with `elements` along it. Its normal is (b - a) x y.
constexpr double kSeamWidth = 0.1;
Patch strip(const Vec3& a, const Vec3& b, int elements, int across) {
  const Vec3 along = (b - a).normalized(), y = Vec3::UnitY();
  Mat3 axes;
  axes << along, y, along.cross(y);
  return plate((b - a).norm(), kSeamWidth, elements, across, 0.5 * (a + b), Quat(axes));
}

// Returns the final place of the middle of an edge under the loads: the mean over one slowly damped swing.
Vec3 settled(Stitched& s, int shell, int edge, double period) {
  const double dt = 0.8 * s.stable();
  const auto at = [&] {
    const Patch& p = s.model(shell).patch;
    return s.at(shell, edge_point(p, edge, 0.5));
  };
  const Vec3 start = at();
  const auto steps = static_cast<std::int64_t>(kSwings * period / dt);
  Vec3 sum = Vec3::Zero();
  std::int64_t count = 0;
  for (std::int64_t k = 0; k < steps; ++k) {
    s.step(dt);
    if (k >= steps - steps / 8 && k % 16 == 0) sum += at() - start, ++count;
  }
  return sum / static_cast<double>(count);
}

// L frame: a column clamped at its foot, and an arm loaded at its end. Portal: two columns clamped at their feet, and a
// beam that is pushed sideways. Poisson's ratio is zero, so strips are beams. Loads are small, so geometry is linear.
void frame_case(Report& r, int) {
  constexpr double kForce = 0.1, kHeight = 0.3, kArm = 0.4;
  const double bending = kSeamYoung * kSeamWidth * std::pow(kSeamThickness, 3) / 12.0;
  const auto end_load = [](int edge, const Vec3& force) {
    Load l;
    l.kind = Load::Kind::kEdgeForce, l.edges = edge, l.force = force / kSeamWidth;
    return l;
  };
  const auto edge_support = [](int edge) {
    Support s;
    s.edges = edge;
    return s;
  };
  const auto damped = [](double frequency) {
    ShellMaterial m = seam_steel(0.0);
    m.mass_damping = 2.0 * kDamping * frequency;
    return m;
  };
  // Lowest frequency [rad/s] from the static deflection under the own mass, exact enough for damping.
  const double area_mass = 7800.0 * kSeamThickness * kSeamWidth;
  const auto lowest = [&](double deflection) {
    return std::sqrt(kForce / deflection / (0.5 * area_mass * (kHeight + kArm)));
  };
  const Vec3 base(0, 0, 0), corner(0, 0, kHeight), tip(kArm, 0, kHeight), far(kArm, 0, 0);
  for (const int n : {8, 16, 32})
    for (const bool other_knots : {false, true}) {
      const double start = seconds_now();
      const double exact = -kForce * (std::pow(kArm, 3) / 3.0 + kArm * kArm * kHeight) / bending;
      const double omega = lowest(-exact);
      std::vector<ShellModel> models;
      models.push_back(
          make_shell("column", strip(base, corner, n, 3), kSeamThickness, damped(omega), 2, 2, {edge_support(kUMin)}));
      models.push_back(make_shell("arm", strip(corner, tip, n, other_knots ? 4 : 3), kSeamThickness, damped(omega), 2,
                                  2, {}, {end_load(kUMax, {0, 0, -kForce})}));
      Stitched s(std::move(models));
      const double found = settled(s, 1, kUMax, 2.0 * pi / omega).z();
      // A crease transmits a moment as two forces half an element apart. The elements beside it deform more, by a
      // factor of (thickness / element)^2 of their bending. Elements shorter than the thickness are outside of
      // thin-shell theory.
      if (kHeight / n > 1.5 * kSeamThickness)
        r.add(fmt::format("l_frame_{}{}", n, other_knots ? "_other_knots" : ""), found, exact, 0.01,
              seconds_now() - start);
      else
        r.lines.push_back(fmt::format("frames: elements of {:.2f} thicknesses{}: {:+.2f} %",
                                      kHeight / n / kSeamThickness, other_knots ? ", other knots" : "",
                                      100.0 * (found / exact - 1.0)));
    }
  for (const Join join : {Join::kClamped, Join::kHinge}) {
    const double start = seconds_now();
    const double k = kHeight / kArm, all = kForce * std::pow(kHeight, 3) / bending;
    const double exact = join == Join::kHinge ? all / 6.0 : all / 12.0 * (3.0 * k + 2.0) / (6.0 * k + 1.0);
    const double omega = lowest(exact);
    std::vector<ShellModel> models;
    models.push_back(
        make_shell("left", strip(base, corner, 12, 3), kSeamThickness, damped(omega), 2, 2, {edge_support(kUMin)}));
    models.push_back(make_shell("beam", strip(corner, tip, 16, 3), kSeamThickness, damped(omega), 2, 2, {},
                                {end_load(kUMin, {kForce, 0, 0})}));
    models.push_back(
        make_shell("right", strip(tip, far, 12, 3), kSeamThickness, damped(omega), 2, 2, {edge_support(kUMax)}));
    Stitched s(std::move(models), join);
    r.add(join == Join::kHinge ? "portal_hinged" : "portal_clamped", settled(s, 1, kUMin, 2.0 * pi / omega).x(), exact,
          0.01, seconds_now() - start);
  }
}

std::vector<ShellModel> tube() {
  std::vector<ShellModel> models;
  for (int k = 0; k < 3; ++k) {
    const Quat turn(Eigen::AngleAxisd(2.0 * pi / 3.0 * k, Vec3::UnitZ()));
    const Patch p =
        with_parameters_as_lengths(placed(cylinder(0.3, 0.5, 2.0 * pi / 3.0, 8 + 2 * k, 7 + k), Vec3::Zero(), turn));
    models.push_back(make_shell(fmt::format("sector{}", k), turned(p, k), kSeamThickness, seam_steel(), 2, 2, {}));
  }
  return models;
}
std::vector<ShellModel> box() {
  std::vector<ShellModel> models;
  int k = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      Mat3 axes;
      axes.col(2) = side * Vec3::Unit(axis), axes.col(0) = Vec3::Unit((axis + 1) % 3);
      axes.col(1) = axes.col(2).cross(axes.col(0));
      models.push_back(make_shell(fmt::format("face{}", k),
                                  plate(0.4, 0.4, 5 + k % 3, 5 + k % 2, 0.2 * axes.col(2), Quat(axes)), kSeamThickness,
                                  seam_steel(), 2, 2, {}));
      ++k;
    }
  return models;
}

void motion_case(Report& r, int) {
  for (const bool round : {true, false}) {
    const std::string name = round ? "tube" : "box";
    double start = seconds_now();
    Stitched s(round ? tube() : box());
    const Quat turn = rotation_from_vector(Vec3(0.9, -1.3, 0.6));
    double volume = 0.0;
    for (std::size_t k = 0; k < s.size(); ++k) {
      const std::vector<double> x = s.state(k).motion.x;
      for (std::size_t i = 0; i < x.size() / 3; ++i) {
        const Vec3 y = turn * s.state(k).at(x, static_cast<int>(i)) + Vec3(0.3, 0.1, -0.7);
        for (int d = 0; d < 3; ++d) s.state(k).motion.x[d * x.size() / 3 + i] = y[d];
      }
      for (const double m : s.model(k).mass) volume += m / s.model(k).material.density;
    }
    // Relative to the energy of a strain of 1.
    r.add(name + "_turned_energy", s.forces(true) / (kSeamYoung * volume), 0.0, 1e-12, seconds_now() - start);
    start = seconds_now();
    Stitched f(round ? tube() : box());
    for (std::size_t k = 0; k < f.size(); ++k)
      for (int i = 0; i < f.model(k).control_points(); ++i) {
        const int slot = f.model(k).tables.slot(i);
        const Vec3 x = f.state(k).position(slot);
        const Vec3 v = Vec3(1.0, -2.0, 0.5) + Vec3(4.0, 3.0, 7.0).cross(x) +
                       0.5 * Vec3(std::sin(7.0 * x.y()), std::cos(9.0 * x.z()), std::sin(8.0 * x.x() + x.y()));
        f.state(k).add_velocity(slot, v);
      }
    f.stitching().update_dependent_velocities(f.refs());
    const double dt = 0.8 * f.stable();
    constexpr int kSteps = 20000;
    const auto before = f.sums();
    double first = 0.0, drift = 0.0;
    for (int k = 0; k < kSteps; ++k) {
      const bool look = k % 100 == 0;
      if (look) {
        const double stored = f.forces(true), energy = stored + f.kinetic(dt);
        if (k == 0) first = energy;
        drift = std::max(drift, std::abs(energy / first - 1.0));
      }
      f.step(dt);
    }
    const auto after = f.sums();
    r.add(name + "_momentum", (after.momentum - before.momentum).norm() / before.momentum_scale, 0.0, 1e-12,
          seconds_now() - start);
    r.add(name + "_angular_momentum", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-12, 0.0);
    r.add(name + "_energy", drift, 0.0, 1e-3, 0.0);
    double apart = 0.0;  // of what follows from what it follows
    for (const Dependence& d : f.stitches().points) {
      const auto position = [&](const PatchPoint& p) {
        return f.state(p.patch).position(f.model(p.patch).tables.slot(p.point));
      };
      Vec3 mean = Vec3::Zero();
      for (const auto& [p, weight] : d.on) mean += weight * position(p);
      apart = std::max(apart, (mean - position(d.point)).norm());
    }
    r.add(name + "_seams_apart_m", apart, 0.0, 1e-11, 0.0);
  }
}

}  // namespace

std::vector<Case> seam_cases() {
  return {
      {"plate", "a supported plate of 2, 4 and 12 patches, turned, knots that do not match",
       [](Report& r, int) { surface_case(r, flat_surface()); }},
      {"cylinder", "120 degrees of a cylinder, the same", [](Report& r, int) { surface_case(r, curved_surface()); }},
      {"frames", "creases of 90 degrees against beam frames, clamped and hinged", frame_case},
      {"motion", "a tube and a box, turned, and flying free for 20,000 substeps", motion_case}};
}

}  // namespace sunder::validation
