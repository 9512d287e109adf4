// Fibres of shells that seams join.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/solver/contact/fibres.h"
#include "tests/shell/pile.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

const FibreLaw kJoinedLaw{3e5, 2e5, 0.4};
constexpr double kSheet = 0.01;  // thickness [m]

ShellModel soft_sheet(const Patch& patch) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = 1e7, m.poisson_ratio = 0.3;
  ShellModel out = make_shell("sheet", patch, kSheet, m, 2, 2, {});
  out.fibres = kJoinedLaw;
  return out;
}

// Shells joined where their edges meet, with fibres on a grid of this spacing [m]. Velocities are those of the shells.
Pile joined_pile(std::vector<ShellModel> models, const std::vector<Vec3>& velocities, double spacing) {
  RunSetup out = Stitched::joined(std::move(models), Join::kClamped, 1e-6);
  for (std::size_t k = 0; k < velocities.size(); ++k) out.shells[k].velocity = velocities[k];
  out.fibre_spacing = spacing;
  return Pile(std::move(out));
}

// A sheet half a metre wide in one or two patches along x, and a smaller one askew that comes down on its middle.
Pile struck(int patches) {
  std::vector<ShellModel> models;
  if (patches == 1)
    models = {soft_sheet(flat(-0.25, 0.25, -0.25, 0.25, 12, 12))};
  else
    models = {soft_sheet(flat(-0.25, 0.0, -0.25, 0.25, 6, 12)), soft_sheet(flat(0.0, 0.25, -0.25, 0.25, 6, 12))};
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
  models.push_back(soft_sheet(placed(flat(-0.1, 0.1, -0.1, 0.1, 5, 5), Vec3(0.01, 0.02, 0.011), turn)));
  std::vector<Vec3> velocities(models.size(), Vec3::Zero());
  velocities.back() = Vec3(1, 0.5, -3);
  return joined_pile(std::move(models), velocities, 0.045);
}

Vec3 momentum_of(const Pile& p, std::size_t k) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < p.state(k).motion.mass.size(); ++i)
    sum += p.state(k).motion.mass[i] * p.state(k).velocity(static_cast<int>(i));
  return sum;
}

}  // namespace

// Forces on control points that depend on others pass to those, and the sums stay.
TEST(FibreSeams, ForcesOverASeamHaveNeitherSumNorTorque) {
  Pile l = struck(2);
  const double dt = 0.5 * l.stable();
  int strained = 0;
  for (int k = 0; k < 60; ++k) {
    l.run(5, dt);
    for (const ShellRef& r : l.refs()) r.state->motion.force.assign(r.state->motion.force.size(), 0.0);
    l.fibres().add_forces(l.refs());
    double on_seam = 0.0;
    l.now().stitching.each_dependent([&](int shell, int slot, const auto&) {
      on_seam += l.state(shell).at(l.state(shell).motion.force, slot).norm();
    });
    l.now().stitching.move_forces(l.refs());
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    double sum = 0.0, torque_sum = 0.0;
    for (const ShellRef& r : l.refs())
      for (int i = 0; i < r.model->control_points(); ++i) {
        const int slot = r.model->tables.slot(i);
        if (r.state->motion.mass[slot] == 0.0) continue;  // its force is what makes it follow
        const Vec3 f = r.state->at(r.state->motion.force, slot), x = r.state->position(slot);
        force += f, torque += x.cross(f), sum += f.norm(), torque_sum += x.norm() * f.norm();
      }
    if (on_seam == 0.0) continue;
    ++strained;
    EXPECT_LT(force.norm(), 1e-13 * sum) << k;
    EXPECT_LT(torque.norm(), 1e-13 * torque_sum) << k;
  }
  EXPECT_GT(strained, 5);
}

// What strikes two patches feels what it feels on one. On a seam functions are less smooth than within a patch.
TEST(FibreSeams, TwoPatchesFeelLikeOne) {
  Pile one = struck(1), two = struck(2);
  const double dt = 0.5 * std::min(one.stable(), two.stable());
  const Vec3 before = momentum_of(one, 1);
  double pressed = 0.0, off = 0.0;
  for (int k = 0; k < 40; ++k) {
    one.run(10, dt), two.run(10, dt);
    pressed = std::max(pressed, one.fibres().energy());
    off = std::max(off, std::abs(one.fibres().energy() - two.fibres().energy()));
  }
  const Vec3 given = momentum_of(one, 1) - before;
  EXPECT_GT(given.z(), 0.3 * std::abs(before.z()));
  EXPECT_LT((momentum_of(two, 2) - momentum_of(one, 1)).norm(), 0.01 * given.norm());
  EXPECT_LT(off, 0.02 * pressed);
  EXPECT_NEAR(two.contact() / one.contact(), 1.0, 0.02);
}

TEST(FibreSeams, BooksClose) {
  Pile l = struck(2);
  const double dt = 0.25 * l.stable(), start = l.energy(dt);
  double worst = 0.0, pressed = 0.0;
  for (int k = 0; k < 80; ++k) {
    l.run(10, dt);
    pressed = std::max(pressed, l.fibres().energy());
    worst = std::max(worst, std::abs(l.energy(dt) - start));
  }
  EXPECT_GT(pressed, 0.1 * start);
  EXPECT_GT(l.contact(), 0.01 * start);
  EXPECT_LT(worst, 2e-3 * start);  // fibres are of first order in the step
}

namespace {

// Largest eigenvalue of the stiffness of leaning fibres over the mass [1/s^2], exactly, of flat shells that seams join.
double steepest_joined_lean(Stitched& s) {
  std::vector<int> first{0};
  for (std::size_t k = 0; k < s.size(); ++k) first.push_back(first.back() + s.model(k).control_points());
  const auto number = [&](int shell, int slot) { return first[shell] + s.model(shell).tables.control_point(slot); };
  const int n = first.back();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(3 * n, 3 * n);  // along x, y and z: of creases, normals differ
  Eigen::VectorXd mass(3 * n);
  for (std::size_t shell = 0; shell < s.size(); ++shell) {
    const ShellModel& m = s.model(shell);
    const RowTables& t = m.tables;
    for (int i = 0; i < m.control_points(); ++i)
      for (int d = 0; d < 3; ++d) mass[3 * (first[shell] + i) + d] = s.state(shell).motion.mass[t.slot(i)];
    for (int q = 0; q < t.blocks(); ++q)
      for (int e = 0; e < t.spans_u; ++e) {
        const double area = t.metric[t.at(q, kMetricFields, kArea, e)];
        if (area == 0.0) continue;
        const auto functions = patch_functions(m.patch, gauss_point(m.patch, t, q, e).parameter, t.stride);
        Vec3 u = Vec3::Zero(), v = Vec3::Zero();
        for (const GatheredFunction& f : functions)
          u += f.n[1] * s.state(shell).at(m.rest, f.slot), v += f.n[2] * s.state(shell).at(m.rest, f.slot);
        const Mat3 normal = u.cross(v).normalized() * u.cross(v).normalized().transpose();
        for (const GatheredFunction& a : functions)  // parameters are lengths of a flat sheet
          for (const GatheredFunction& b : functions)
            k.block<3, 3>(3 * number(shell, a.slot), 3 * number(shell, b.slot)) +=
                m.fibres.shear * m.thickness * area * (a.n[1] * b.n[1] + a.n[2] * b.n[2]) * normal;
      }
  }
  // control points that depend on others move with them
  Eigen::MatrixXd w = Eigen::MatrixXd::Identity(3 * n, 3 * n);
  s.stitching().each_dependent([&](int shell, int slot, const auto& on) {
    for (int d = 0; d < 3; ++d) {
      const int row = 3 * number(shell, slot) + d;
      w.row(row).setZero(), mass[row] = 1.0;
      for (const auto& p : on) w(row, 3 * number(p.shell, p.slot) + d) += p.weight;
    }
  });
  k = w.transpose() * k * w;
  const Eigen::VectorXd scale = mass.cwiseSqrt().cwiseInverse();
  k = scale.asDiagonal() * k * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

}  // namespace

// The step allows for leaning fibres by a constant that is one of whole patches. Beside seams, control points carry the
// mass of those that depend on them, and move them. Ties and the angles of creases only take motions away.
TEST(FibreSeams, LeanNoFasterBesideSeamsThanTheStepAllows) {
  const Quat up(Eigen::AngleAxisd(-0.5 * M_PI, Vec3::UnitY()));
  const auto part = [](double x0, double x1, double y0, double y1, int nx, int ny) {
    return flat(x0, x1, y0, y1, nx, ny);
  };
  const struct {
    const char* name;
    std::vector<Patch> patches;
  } cases[] = {
      {"alike", {part(0, 0.5, 0, 0.5, 6, 6), part(0.5, 1, 0, 0.5, 6, 6)}},
      {"finer", {part(0, 0.5, 0, 0.5, 5, 5), part(0.5, 1, 0, 0.5, 9, 9)}},
      {"other knots", {part(0, 0.5, 0, 0.5, 6, 6), part(0.5, 1, 0, 0.5, 7, 7)}},
      {"turned", {part(0, 0.5, 0, 0.5, 6, 6), turned(part(0.5, 1, 0, 0.5, 6, 7))}},
      {"crease", {part(-0.5, 0, -0.25, 0.25, 6, 6), placed(part(0, 0.5, -0.25, 0.25, 6, 7), Vec3::Zero(), up)}},
      {"four",
       {part(0, 0.5, 0, 0.5, 5, 5), part(0.5, 1, 0, 0.5, 6, 5), part(0, 0.5, 0.5, 1, 5, 7),
        part(0.5, 1, 0.5, 1, 7, 6)}}};
  for (const auto& c : cases) {
    std::vector<ShellModel> models;
    double shortest = 1e300;
    for (const Patch& p : c.patches) {
      models.push_back(soft_sheet(p));
      shortest = std::min(shortest, models.back().shortest_element);
    }
    const double allowed = 16.0 * kJoinedLaw.shear / (models[0].material.density * shortest * shortest);
    std::vector<const ShellModel*> all;
    for (const ShellModel& m : models) all.push_back(&m);
    const double step = stable_step_with_fibres(1e9, all);  // with layers that touch
    EXPECT_GT(4.0 / (step * step), allowed) << c.name;
    Stitched s(std::move(models));
    ASSERT_FALSE(s.seams().empty()) << c.name;
    const double found = steepest_joined_lean(s);
    EXPECT_LT(found, allowed) << c.name;
    EXPECT_GT(found, 0.25 * allowed) << c.name;  // the allowance costs at most a factor of two of the step
  }
}
