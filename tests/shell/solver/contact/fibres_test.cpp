// Shells with fibres: what control points feel, and what that costs.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/solver/contact/fibres.h"
#include "shell/solver/cracking/polyline.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/pile.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

const FibreLaw kLaw{3e5, 2e5, 0.4};

ShellModel sheet(double size, int elements, const Vec3& at, const Quat& turn = Quat::Identity(),
                 double thickness = 0.01) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = 1e7, m.poisson_ratio = 0.3;
  return make_shell("sheet", plate(size, size, elements, elements, at, turn), thickness, m, 2, 2, {});
}

// Two sheets that meet askew and spinning: they will be bent, pressed and sheared, and some of it slips.
Pile meeting() {
  const Quat turn(Eigen::AngleAxisd(0.4, Vec3(0.05, 0.1, 1.0).normalized()));
  Pile l({{sheet(0.5, 10, Vec3::Zero()), kLaw}, {sheet(0.4, 9, Vec3(0.02, 0.03, 0.05), turn), kLaw, Vec3(3, 1, -6)}},
         0.06);
  ShellState& s = l.state(1);
  for (int i = 0; i < l.model(1).control_points(); ++i) {
    const int slot = l.model(1).tables.slot(i);
    s.add_velocity(slot, Vec3(1, -2, 3).cross(s.position(slot)));
  }
  return l;
}

// Fibres' forces alone, and the velocities' power on them.
struct Felt {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double sum = 0.0, torque_sum = 0.0, power = 0.0;
};
Felt felt(Pile& l) {
  for (const ShellRef& r : l.refs()) r.state->motion.force.assign(r.state->motion.force.size(), 0.0);
  l.fibres().add_forces(l.refs());
  Felt out;
  for (const ShellRef& r : l.refs())
    for (int i = 0; i < r.model->control_points(); ++i) {
      const int slot = r.model->tables.slot(i);
      const Vec3 f = r.state->at(r.state->motion.force, slot), x = r.state->position(slot);
      out.force += f, out.torque += x.cross(f), out.sum += f.norm(), out.torque_sum += x.norm() * f.norm();
      out.power += f.dot(r.state->velocity(slot));
    }
  return out;
}

}  // namespace

TEST(Fibres, ForcesHaveNeitherSumNorTorque) {
  Pile l = meeting();
  const double dt = 0.5 * l.stable();
  int strained = 0;
  for (int k = 0; k < 60; ++k) {
    l.run(10, dt);
    const Felt f = felt(l);
    if (f.sum == 0.0) continue;
    ++strained;
    EXPECT_LT(f.force.norm(), 1e-13 * f.sum) << k;
    EXPECT_LT(f.torque.norm(), 1e-13 * f.torque_sum) << k;
  }
  EXPECT_GT(strained, 5);
}

TEST(Fibres, ForcesDoTheWorkThatIsStoredAndSlips) {
  Pile l = meeting();
  const double dt = 0.5 * l.stable();
  int compared = 0;
  for (int k = 0; k < 60; ++k) {
    l.run(10, dt);
    const Felt f = felt(l);
    const double before = l.fibres().energy() + l.contact();
    if (f.sum == 0.0 || std::abs(f.power) < 1.0) continue;
    ++compared;
    std::vector<ShellState> kept{l.state(0), l.state(1)};
    const double tiny = 1e-5 * dt;  // differences: error of that order, and 1e-15 of the energy over tiny
    for (const ShellRef& r : l.refs())
      for (std::size_t i = 0; i < r.state->motion.x.size(); ++i) r.state->motion.x[i] += tiny * r.state->motion.v[i];
    l.fibres().advance(l.refs(), tiny);
    const double after = l.fibres().energy() + l.contact();
    EXPECT_NEAR((after - before) / tiny, -f.power, 1e-3 * std::abs(f.power)) << k;
    for (std::size_t i = 0; i < 2; ++i) l.state(i) = kept[i];
    l.fibres().forget();
  }
  EXPECT_GT(compared, 3);
}

// The functions beside a cut are rounded to 2^-30 of the largest: they keep sums, and torques to about that.
TEST(Fibres, BesideACutForcesBalanceAndDoTheirWork) {
  Pile l = meeting();
  insert_polyline(l.model(0), l.state(0), {{0.1, 0.21}, {0.42, 0.31}}, 0.0);
  insert_polyline(l.model(1), l.state(1), {{0.05, 0.05}, {0.33, 0.36}}, 0.0);
  const double dt = 0.5 * l.stable();
  int strained = 0, compared = 0;
  for (int k = 0; k < 60; ++k) {
    l.run(10, dt);
    const Felt f = felt(l);
    if (f.sum == 0.0) continue;
    ++strained;
    EXPECT_LT(f.force.norm(), 1e-12 * f.sum) << k;
    EXPECT_LT(f.torque.norm(), 1e-8 * f.torque_sum) << k;
    const double before = l.fibres().energy() + l.contact();
    if (std::abs(f.power) < 1.0) continue;
    ++compared;
    std::vector<ShellState> kept{l.state(0), l.state(1)};
    const double tiny = 1e-5 * dt;
    for (const ShellRef& r : l.refs())
      for (std::size_t i = 0; i < r.state->motion.x.size(); ++i) r.state->motion.x[i] += tiny * r.state->motion.v[i];
    l.fibres().advance(l.refs(), tiny);
    EXPECT_NEAR((l.fibres().energy() + l.contact() - before) / tiny, -f.power, 1e-3 * std::abs(f.power)) << k;
    for (std::size_t i = 0; i < 2; ++i) l.state(i) = kept[i];
    l.fibres().forget();
  }
  EXPECT_GT(strained, 5);
  EXPECT_GT(compared, 3);
}

// A cut that comes while layers are pressed changes no stored energy of fibres, and what became rubble releases its
// own.
TEST(Fibres, ACutWhileLayersArePressedIsSeenAtOnce) {
  Pile l = meeting();
  const double dt = 0.5 * l.stable();
  for (int k = 0; k < 60 && felt(l).sum == 0.0; ++k) l.run(10, dt);
  l.run(30, dt);
  ASSERT_GT(felt(l).sum, 0.0);
  const double stored = l.fibres().energy(), contact = l.contact();
  insert_polyline(l.model(0), l.state(0), {{0.1, 0.21}, {0.42, 0.31}}, 0.0);
  int rubble = 0;
  for (GatheredPoint& g : l.state(0).cracked.gathered)
    if (!g.in_rows && rubble < 40) ++rubble, g.kind = PointKind::kDead, g.functions.clear();
  l.fibres().advance(l.refs(), 1e-12);
  EXPECT_LT(l.fibres().energy(), stored);
  EXPECT_NEAR(l.fibres().energy() + l.contact(), stored + contact, 1e-6 * stored);
  EXPECT_LT(felt(l).force.norm(), 1e-12 * felt(l).sum);
}

TEST(Fibres, KeepTheirStateInRigidMotion) {
  Pile l = meeting();
  const double dt = 0.5 * l.stable();
  for (int k = 0; k < 60 && felt(l).sum == 0.0; ++k) l.run(10, dt);
  l.run(30, dt);
  ASSERT_GT(felt(l).sum, 0.0);
  const std::vector<double> before = l.state(0).layers.fibres;
  const double contact = l.state(0).book.contact;
  const Vec3 spin(30, -50, 80);  // a tenth of a radian in all
  for (int k = 0; k < 100; ++k) {
    for (const ShellRef& r : l.refs())
      for (int i = 0; i < r.model->control_points(); ++i) {
        const int slot = r.model->tables.slot(i);
        const Vec3 v = spin.cross(r.state->position(slot)) + Vec3(7, 8, 9);
        for (int d = 0; d < 3; ++d) {
          const std::size_t at = d * r.state->motion.mass.size() + slot;
          r.state->motion.v[at] = v[d], r.state->motion.x[at] += 1e-5 * v[d];
        }
      }
    // the gradient of v as it is at the new place: positions moved by (1 + dt w x), which is no rotation but in limit
    l.fibres().advance(l.refs(), 1e-5);
  }
  int kept = 0;
  for (std::size_t i = 0; i < before.size(); i += 3) {
    const Vec3 was(before[i], before[i + 1], before[i + 2]);
    const Vec3 is(l.state(0).layers.fibres[i], l.state(0).layers.fibres[i + 1], l.state(0).layers.fibres[i + 2]);
    if (was == Vec3::UnitZ()) continue;
    // at the rim, nodes of the grid that the surfaces now share are others: there fibres are released
    if (is != Vec3::UnitZ()) {
      EXPECT_LT((was - is).norm(), 1e-4);  // 100 (dt w)^2
      ++kept;
    }
  }
  EXPECT_GT(kept, 10);
  EXPECT_NEAR(l.state(0).book.contact, contact, 1e-2 * l.fibres().energy());
}

TEST(Fibres, StableStepBoundsThatOfStacks) {
  // Power iteration on the forces that a motion changes, fibres following it; all pressed to 0.6 of their length.
  struct Case {
    int layers, elements;
    double spacing, shear;
  };
  for (const Case& c : {Case{2, 8, 0.0625, 1.0}, Case{2, 8, 0.15, 3.0}, Case{3, 8, 0.0625, 1.0}, Case{4, 8, 0.07, 3.0},
                        Case{2, 40, 0.02, 3.0}}) {
    std::vector<Layer> layers;
    for (int k = 0; k < c.layers; ++k)
      layers.push_back({sheet(0.5, c.elements, Vec3(0.003 * k, 0.002 * k, 0.0099 * k)), {1e8, c.shear * 1e8, 1e6}});
    Pile l(layers, c.spacing);
    const auto press = [&](double by, double dt) {
      for (int k = 0; k < c.layers; ++k) {
        ShellState& s = l.state(k);
        const std::size_t stride = s.motion.mass.size();
        for (std::size_t i = 0; i < stride; ++i)
          if (s.motion.mass[i] > 0.0) s.motion.v[2 * stride + i] = -by * k / dt, s.motion.x[2 * stride + i] -= by * k;
      }
      l.fibres().advance(l.refs(), dt);
    };
    for (int k = 0; k < 8; ++k) press(0.0005, 1e-3);
    const double bound = l.stable();
    std::vector<std::vector<double>> x, force, fibres;
    l.forces();
    for (std::size_t k = 0; k < l.size(); ++k) {
      const ShellState& s = l.state(k);
      x.push_back(s.motion.x), force.push_back(s.motion.force), fibres.push_back(s.layers.fibres);
    }
    std::mt19937_64 random(3);
    for (std::size_t k = 0; k < l.size(); ++k) {
      Motion& s = l.state(k).motion;
      for (std::size_t i = 0; i < s.v.size(); ++i)
        s.v[i] = s.mass[i % s.mass.size()] > 0.0 ? uniform(random, -1.0, 1.0) : 0.0;
    }
    double lambda = 0.0;
    for (int it = 0; it < 60; ++it) {
      double norm = 0.0;
      for (std::size_t k = 0; k < l.size(); ++k)
        for (const double v : l.state(k).motion.v) norm += v * v;
      norm = std::sqrt(norm);
      const double dt = 1e-8;
      for (std::size_t k = 0; k < l.size(); ++k) {
        ShellState& s = l.state(k);
        s.layers.fibres = fibres[k];
        for (std::size_t i = 0; i < s.motion.v.size(); ++i)
          s.motion.v[i] *= 10.0 / norm, s.motion.x[i] = x[k][i] + dt * s.motion.v[i];
      }
      l.fibres().advance(l.refs(), dt);
      l.forces();
      double sum = 0.0;
      for (std::size_t k = 0; k < l.size(); ++k) {
        ShellState& s = l.state(k);
        for (std::size_t i = 0; i < s.motion.v.size(); ++i) {
          s.motion.v[i] =
              -(s.motion.force[i] - force[k][i]) / dt * s.motion.inverse_mass[i % s.motion.mass.size()] / 10.0;
          sum += s.motion.v[i] * s.motion.v[i];
        }
      }
      lambda = std::sqrt(sum);
    }
    const double found = 2.0 / std::sqrt(lambda);
    EXPECT_GT(found, bound) << c.layers << " layers, " << c.elements << " elements";
    EXPECT_LT(found, 4.0 * bound) << c.layers << " layers, " << c.elements << " elements";  // it is of use
  }
}

namespace {

// Largest eigenvalue of the stiffness of leaning fibres over the mass [1/s^2], exactly.
double steepest_lean(const ShellModel& m, const ShellState& s) {
  const RowTables& t = m.tables;
  const int n = m.control_points();
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n, n);
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const double area = t.metric[t.at(q, kMetricFields, kArea, e)];
      if (area == 0.0) continue;
      const int own = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + e];
      const auto functions = own < 0 ? patch_functions(m.patch, gauss_point(m.patch, t, q, e).parameter, t.stride)
                                     : s.cracked.gathered[own].functions;
      for (const GatheredFunction& a : functions)  // parameters are lengths of a flat sheet
        for (const GatheredFunction& b : functions)
          k(t.control_point(a.slot), t.control_point(b.slot)) +=
              m.fibres.shear * m.thickness * area * (a.n[1] * b.n[1] + a.n[2] * b.n[2]);
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) k(i, j) /= std::sqrt(s.motion.mass[t.slot(i)] * s.motion.mass[t.slot(j)]);
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(k, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

}  // namespace

// The step allows for leaning fibres by a constant that is one of whole patches. Functions beside cracks are others.
TEST(Fibres, LeanNoFasterBesideCracksThanTheStepAllows) {
  ShellModel m = sheet(0.5, 10, Vec3::Zero());
  m.fibres = kLaw;
  const double allowed = 16.0 * kLaw.shear / (m.material.density * m.shortest_element * m.shortest_element);
  const double step = stable_step_with_fibres(1e9, {&m});  // with layers that touch
  EXPECT_GT(4.0 / (step * step), allowed);
  ShellState whole = make_state(m, Vec3::Zero(), 0);
  const double before = steepest_lean(m, whole);
  EXPECT_LT(before, allowed);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(0.02, 0.48);
  double most = 0.0;
  for (int n = 0; n < 40; ++n) {
    ShellState s = make_state(m, Vec3::Zero(), 0);
    for (int k = 0; k < 1 + n % 5; ++k) {
      const double x = place(random), y = place(random), u = place(random), v = place(random);
      insert_polyline(m, s, {{x, y}, {u, v}}, 0.0);
    }
    most = std::max(most, steepest_lean(m, s));
  }
  EXPECT_GT(most, 1.02 * before);  // cracks make them steeper
  EXPECT_LT(most, allowed);
}

TEST(Fibres, WhatCannotMeetCostsNothing) {
  Pile l({{sheet(0.5, 20, Vec3::Zero()), kLaw}, {sheet(0.5, 20, Vec3(0, 0, 0.4)), kLaw}}, 0.03);
  l.run(3, 1e-6);
  EXPECT_EQ(l.fibres().candidates(), 0);
  EXPECT_EQ(l.fibres().energy(), 0.0);
}

TEST(Fibres, LayersThatArePressedToNothingStopTheRun) {
  const Vec3 fast(0, 0, -60);  // 9 kJ/m^2 against 2 k t / 3 = 2 kJ/m^2
  Pile l({{sheet(0.4, 8, Vec3::Zero()), kLaw}, {sheet(0.4, 8, Vec3(0, 0, 0.0101)), kLaw, fast}}, 0.05);
  try {
    l.run(2000, 0.5 * l.stable());
    FAIL() << "went on";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind, "fibres");
    EXPECT_NE(std::string(e.what()).find("raise fibres.compression_modulus"), std::string::npos) << e.what();
  }
}

TEST(Fibres, ASheetFoldedOnItselfDoesNotPassThrough) {
  // both ends are turned up, and one is thrown at the other whole: so their faces meet (fibres do not hold edge on
  // edge)
  for (const double speed : {13.0, 16.0}) {
    ShellMaterial rubber;
    rubber.density = 1000, rubber.youngs_modulus = 1e7, rubber.poisson_ratio = 0.3;
    const ShellModel sheet =
        make_shell("sheet", plate(1.0, 0.25, 40, 10, Vec3::Zero(), Quat::Identity()), 0.01, rubber, 2, 2, {});
    Pile l({{sheet, {1e7, 1e7, 0.3}}}, sheet.longest_element);
    const ShellModel& m = l.model(0);
    ShellState& s = l.state(0);
    fold_up(m, s, [](double) { return 0.0; });
    for (int i = 0; i < m.control_points(); ++i)
      if (m.rest[m.tables.slot(i)] < -kFoldFlat) s.motion.v[m.tables.slot(i)] = speed;
    const double dt = 0.5 * l.stable();
    double nearest = 1.0, pressed = 0.0;
    l.run(static_cast<int>(0.04 / dt), dt, [&] {
      const int row = 5 * m.tables.columns;
      for (int k = 0; k < 10; ++k)
        nearest = std::min(nearest, s.position(m.tables.slot(row + m.tables.columns - 1 - k)).x() -
                                        s.position(m.tables.slot(row + k)).x());
      pressed = std::max(pressed, l.fibres().energy());
    });
    EXPECT_GT(pressed, 0.1) << speed;  // they met: of 50 J and more
    EXPECT_LT(nearest, 0.02) << speed;
    EXPECT_GT(nearest, 0.1 * 0.01) << speed;  // and stayed on their sides
  }
}

// Below one thickness of 0.01 m between their middles, and above it.
TEST(Fibres, SayWhereLayersOverlapAndChangeNothing) {
  for (const double gap : {0.0099, 0.0101}) {
    Pile l({{sheet(0.5, 10, Vec3::Zero()), kLaw}, {sheet(0.2, 9, Vec3(0.1, 0.05, gap)), kLaw}}, 0.06);
    const std::vector<double> before = l.state(0).layers.fibres;
    const auto found = l.fibres().overlap(l.refs());
    EXPECT_EQ(found.has_value(), gap < 0.01) << gap;
    EXPECT_EQ(l.state(0).layers.fibres, before);
    EXPECT_EQ(felt(l).sum, 0.0);  // fibres start at their length at rest
    EXPECT_EQ(l.contact(), 0.0);
    if (!found) continue;
    EXPECT_NEAR(found->x.z(), 0.5 * gap, 0.51 * gap);         // on one of the two
    EXPECT_LE(std::abs(found->x.x() - 0.1), 0.1 + 2 * 0.06);  // where the smaller one is, within the reach of a node
    EXPECT_LE(std::abs(found->x.y() - 0.05), 0.1 + 2 * 0.06);
  }
}
