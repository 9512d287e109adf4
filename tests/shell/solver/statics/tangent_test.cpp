// Free displacements, and the tangent stiffness against difference quotients of the forces.
#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "shell/solver/forces.h"
#include "shell/solver/statics/tangent.h"
#include "tests/shell/fixtures.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

Support clamp_of(int edges) {
  Support s;
  s.edges = edges;
  return s;
}

Support mirror_of(int edges) {
  Support s;
  s.edges = edges, s.clamped = false, s.symmetry = 1;
  return s;
}

Eigen::MatrixXd tangent_of(const ShellModel& m, ShellState& s, const FreeDegrees& free, Differences differences) {
  return tangent_stiffness(m, s, free, differences, [&] { compute_forces(m, s, false, 0.0, 1); });
}

// Forces of all free displacements; what is tied together has their sum.
Eigen::VectorXd forces_of(const ShellModel& m, ShellState& s, const FreeDegrees& free) {
  compute_forces(m, s, false, 0.0, 1);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(free.count);
  for (std::size_t k = 0; k < free.number.size(); ++k)
    if (free.number[k] >= 0) sum[free.number[k]] += s.motion.force[k];
  return sum;
}

// Each displacement alone is moved to both sides.
Eigen::MatrixXd one_by_one(const ShellModel& m, ShellState& s, const FreeDegrees& free) {
  const double step = 1e-5 * m.spacing;
  const std::vector<double> x = s.motion.x;
  Eigen::MatrixXd out(free.count, free.count);
  for (int column = 0; column < free.count; ++column) {
    const auto moved = [&](double by) {
      for (std::size_t k = 0; k < x.size(); ++k)
        if (free.number[k] == column) s.motion.x[k] = x[k] + by;
      const Eigen::VectorXd f = forces_of(m, s, free);
      s.motion.x = x;
      return f;
    };
    out.col(column) = (moved(-step) - moved(step)) / (2.0 * step);
  }
  return out;
}

}  // namespace

TEST(FreeDegrees, AreThoseThatNoSupportHolds) {
  const ShellModel m = strip({clamp_of(kUMin)}, {});
  const FreeDegrees free = free_degrees(m, make_state(m, Vec3::Zero(), 0));
  EXPECT_EQ(free.count, 3 * (m.tables.columns - 2) * m.tables.rows);  // both columns of the clamped edge are held
  std::set<int> numbers;
  for (int i = 0; i < m.control_points(); ++i)
    for (int d = 0; d < 3; ++d) {
      const int n = free.number[static_cast<std::size_t>(d) * m.tables.component_stride + m.tables.slot(i)];
      EXPECT_EQ(n < 0, i % m.tables.columns < 2);
      if (n >= 0) numbers.insert(n);
    }
  EXPECT_EQ(static_cast<int>(numbers.size()), free.count);
  EXPECT_EQ(*numbers.rbegin(), free.count - 1);
}

TEST(FreeDegrees, OfWhatMovesTogetherAreOne) {
  const ShellModel m = strip({clamp_of(kUMin), mirror_of(kVMin)}, {});
  ASSERT_FALSE(m.constraints.tied[2].empty());
  const FreeDegrees free = free_degrees(m, make_state(m, Vec3::Zero(), 0));
  for (const auto& group : m.constraints.tied[2]) {
    std::set<int> numbers;
    for (const int slot : group)
      numbers.insert(free.number[2 * static_cast<std::size_t>(m.tables.component_stride) + slot]);
    EXPECT_EQ(numbers.size(), 1u);
  }
}

// In a sheet that is strained and bent, so that stress adds to the stiffness too.
TEST(Tangent, IsThatOfEachDisplacementMovedAlone) {
  const ShellModel m = make_shell("p", plate(0.2, 0.2, 6, 5, Vec3::Zero(), Quat::Identity()), 0.004, glass(), 2, 2,
                                  {clamp_of(kUMin), mirror_of(kVMin)});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  disturb(s, m, 1e-4);
  const FreeDegrees free = free_degrees(m, s);
  const Eigen::MatrixXd wanted = one_by_one(m, s, free);
  const double scale = wanted.cwiseAbs().maxCoeff();
  ASSERT_GT(scale, 0.0);
  compute_forces(m, s, false, 0.0, 1);
  const std::vector<double> x = s.motion.x, force = s.motion.force;
  // one-sided differences are off by about their share of a spacing, over the thickness
  for (const auto& [differences, tolerance] :
       {std::pair{Differences::kOneSided, 1e-4}, {Differences::kCentral, 1e-6}, {Differences::kFourthOrder, 1e-6}}) {
    const Eigen::MatrixXd found = tangent_of(m, s, free, differences);
    EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), tolerance * scale) << static_cast<int>(differences);
    EXPECT_EQ(s.motion.x, x);
    EXPECT_EQ(s.motion.force, force);
  }
}

TEST(Tangent, IsSymmetricAndResistsNoRigidMotion) {
  const ShellModel m = make_shell("p", rational_patch(), 0.02, glass(), 2, 2, {});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const FreeDegrees free = free_degrees(m, s);
  ASSERT_EQ(free.count, 3 * m.control_points());
  const Eigen::MatrixXd k = tangent_of(m, s, free, Differences::kFourthOrder);
  const double scale = k.cwiseAbs().maxCoeff();
  EXPECT_LT((k - k.transpose()).cwiseAbs().maxCoeff(), 1e-7 * scale);
  for (int d = 0; d < 3; ++d)
    for (const bool turns : {false, true}) {
      Eigen::VectorXd motion = Eigen::VectorXd::Zero(free.count);
      for (int i = 0; i < m.control_points(); ++i) {
        const int slot = m.tables.slot(i);
        const Vec3 u = turns ? Vec3(Vec3::Unit(d).cross(s.position(slot))) : Vec3(Vec3::Unit(d));
        for (int e = 0; e < 3; ++e)
          motion[free.number[e * static_cast<std::size_t>(m.tables.component_stride) + slot]] = u[e];
      }
      EXPECT_LT((k * motion).cwiseAbs().maxCoeff(), 1e-7 * scale) << d << turns;  // of points about a metre away
    }
}
