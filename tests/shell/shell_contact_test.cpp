// Shells that touch one another, and themselves.
#include <cmath>

#include <gtest/gtest.h>

#include "shell/solver/shell_contact.h"
#include "shell/solver/stable_step.h"
#include "shell/solver/step.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

ShellMaterial rubber() {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = 1e8, m.poisson_ratio = 0.3;
  return m;
}

ShellModel sheet(double size, int elements, const Vec3& at, double thickness, const Quat& turn = Quat::Identity()) {
  return make_shell("sheet", plate(size, size, elements, elements, at, turn), thickness, rubber(), 2, 2, {});
}

struct Sum {
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();   // [kg m/s], [kg m^2/s]
  double scale = 0.0, angular_scale = 0.0, energy = 0.0;  // sums of sizes; J with what contact took
};

// `steps` substeps of free shells that touch; `look` after each.
template <class F>
Sum fly(const std::vector<ShellRef>& shells, ShellContact& contact, double dt, int steps, F&& look) {
  for (int k = 0; k < steps; ++k) {
    for (const ShellRef& r : shells) compute_forces(*r.model, *r.state, false, 0.0, 1);
    for (const ShellRef& r : shells) kick(*r.model, *r.state, Vec3::Zero(), dt);
    contact.act(shells, dt);
    for (const ShellRef& r : shells) drift(*r.model, *r.state, dt);
    look();
  }
  Sum sum;
  for (const ShellRef& r : shells) {
    sum.energy += compute_forces(*r.model, *r.state, true, 0.0, 1) + r.state->book.contact;
    sum.energy += kinetic_energy(*r.model, *r.state, dt);
    for (int i = 0; i < r.model->control_points(); ++i) {
      const int slot = r.model->tables.slot(i);
      const Vec3 p = r.state->mass[slot] * r.state->velocity(slot);
      const Vec3 l = r.state->position(slot).cross(p);
      sum.momentum += p, sum.scale += p.norm(), sum.angular += l, sum.angular_scale += l.norm();
    }
  }
  return sum;
}

double mean_z(const ShellRef& r) {
  double sum = 0.0;
  for (int i = 0; i < r.model->control_points(); ++i) sum += r.state->position(r.model->tables.slot(i)).z();
  return sum / r.model->control_points();
}

}  // namespace

TEST(ShellContact, MomentumStaysAndEnergyIsBooked) {
  const ShellModel low = sheet(0.5, 20, Vec3::Zero(), 0.004),
                   high = sheet(0.4, 14, Vec3(0.02, 0.01, 0.008), 0.004, Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ())));
  ShellState a = make_state(low, Vec3::Zero(), 0), b = make_state(high, Vec3(1, 0, -5), 0);
  const std::vector<ShellRef> shells{{&low, &a}, {&high, &b}};
  ShellContact contact({&low, &high}, {}, {2, std::vector<SurfaceLaw>(2, {0.3, 0.0})});
  const double dt = 0.5 * std::min(stable_step(low, a, 60, 1, false), stable_step(high, b, 60, 1, false));
  const Sum before = fly(shells, contact, dt, 0, [] {});
  const Sum after = fly(shells, contact, dt, 400, [] {});
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-12 * before.angular_scale);
  const double lost = a.book.contact + b.book.contact;
  EXPECT_GT(lost, 0.1 * before.energy);  // they did meet, inelastically
  EXPECT_NEAR(after.energy, before.energy, 2e-3 * before.energy);
  for (int i = 0; i < high.control_points(); ++i) {  // it is over what is under it
    const Vec3 x = b.position(high.tables.slot(i));
    double below = 0.0, nearest = 1e300;
    for (int k = 0; k < low.control_points(); ++k) {
      const Vec3 y = a.position(low.tables.slot(k));
      const double d = (y - x).head<2>().norm();
      if (d < nearest) nearest = d, below = y.z();
    }
    if (nearest < 0.5 * low.spacing) {
      EXPECT_GT(x.z() - below, 0.0) << i;
    }
  }
}

TEST(ShellContact, SheetsThatMeetSquarelyGoOnTogetherAtAThicknessApart) {
  // equal, one over the other: without restitution both go on with half the velocity
  const ShellModel low = sheet(0.3, 10, Vec3::Zero(), 0.01), high = sheet(0.3, 10, Vec3(0, 0, 0.0101), 0.01);
  ShellState a = make_state(low, Vec3::Zero(), 0), b = make_state(high, Vec3(0, 0, -2), 0);
  const std::vector<ShellRef> shells{{&low, &a}, {&high, &b}};
  ShellContact contact({&low, &high}, {}, {2, std::vector<SurfaceLaw>(2)});
  const double dt = 2e-6;
  fly(shells, contact, dt, 200, [] {});
  EXPECT_NEAR(a.velocity(low.tables.slot(70)).z(), -1.0, 0.05);
  EXPECT_NEAR(b.velocity(high.tables.slot(70)).z(), -1.0, 0.05);
  EXPECT_NEAR(mean_z(shells[1]) - mean_z(shells[0]), 0.01, 1e-4);
}

TEST(ShellContact, FrictionIsCoulombs) {
  for (const double friction : {0.0, 0.2, 10.0}) {
    FieldContact contact(0.1, {{1, 0}, {0, 1}}, {2, std::vector<SurfaceLaw>(2, {friction, 0.0})});
    std::vector<SurfaceSample> samples;
    for (int i = 0; i < 20; ++i)
      for (int j = 0; j < 20; ++j)
        for (const int shell : {0, 1}) {
          SurfaceSample p;
          p.x = p.rest = Vec3(0.03 * i, 0.03 * j, 0.0499 + 0.0099 * shell);
          p.v = shell == 0 ? Vec3(0, 0, 0) : Vec3(3, 0, -2);
          p.normal = Vec3::UnitZ(), p.mass = 1.0, p.thickness = 0.01, p.shell = shell;
          samples.push_back(p);
        }
    EXPECT_GT(contact.solve(samples, 1e-3), 0);
    Vec3 on_first = Vec3::Zero(), on_second = Vec3::Zero();
    for (const SurfaceSample& p : samples) (p.shell == 0 ? on_first : on_second) += p.impulse;
    EXPECT_LT((on_first + on_second).norm(), 1e-12 * on_first.norm());
    const double normal = on_second.z();
    // the reduced masses of both layers of nodes, of which the surfaces have unequal shares; 0.1 mm of overlap is let
    // go at 0.01 m/s
    const double reduced = 400.0 * (0.501 * 0.402 / 0.903 + 0.499 * 0.598 / 1.097);
    EXPECT_NEAR(normal, reduced * 2.01, 1e-9 * normal);
    EXPECT_NEAR(-on_second.x(), std::min(friction * normal, reduced * 3.0), 1e-9 * normal);
  }
}

TEST(ShellContact, WhatCannotMeetCostsNothing) {
  const ShellModel low = sheet(0.5, 20, Vec3::Zero(), 0.004), high = sheet(0.5, 20, Vec3(0, 0, 0.3), 0.004);
  ShellState a = make_state(low, Vec3::Zero(), 0), b = make_state(high, Vec3::Zero(), 0);
  ShellContact contact({&low, &high}, {}, {2, std::vector<SurfaceLaw>(2)});
  EXPECT_EQ(contact.act({{&low, &a}, {&high, &b}}, 1e-6), 0);
  EXPECT_EQ(contact.candidates(), 0);
}

TEST(ShellContact, ASheetFoldedOnItselfDoesNotPassThrough) {
  const ShellModel m = sheet(1.0, 40, Vec3::Zero(), 0.01);
  ShellState s = make_state(m, Vec3::Zero(), 0);
  // both ends are turned up and thrown at one another
  fold_up(m, s, [](double straight) { return 60.0 * straight; });
  ShellContact contact({&m}, {}, {1, std::vector<SurfaceLaw>(1)});
  const std::vector<ShellRef> shells{{&m, &s}};
  const double dt = 0.5 * stable_step(m, s, 60, 1, false);
  double nearest = 1.0;
  int met = 0;
  const int right = m.tables.slot(21 * m.tables.columns + m.tables.columns - 2),
            left = m.tables.slot(21 * m.tables.columns + 1);
  for (int k = 0; k < 40; ++k) {
    fly(shells, contact, dt, static_cast<int>(0.001 / dt),
        [&] { nearest = std::min(nearest, s.position(right).x() - s.position(left).x()); });
    met += contact.candidates() > 0;
  }
  EXPECT_GT(met, 0);
  EXPECT_LT(nearest, 0.1);         // they came together
  EXPECT_GT(nearest, 0.5 * 0.01);  // and stayed on their sides
}
