// Ties along trims: what they keep, and what they refuse.
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/solver/joining/seam_ties.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/stitched.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

// Trims move control points beside them, so that the pieces of a coarse cylinder are as far apart.
constexpr double kTolerance = 1e-4;

ShellModel piece(const Patch& p, const std::vector<Vec2>& ring, const std::string& name,
                 const std::vector<Support>& supports = {}) {
  const Patch own = with_parameters_as_lengths(p);
  const Vec2 high(own.knots_u.end(), own.knots_v.end());
  return make_shell(name, p, 0.01, glass(), 2, p.degree(), supports, {},
                    TrimLoops(Vec2::Zero(), high, {{ring, false, {}}}));
}

// A square in two pieces along a bent line, of different elements. The supports are those of the left and the right.
std::vector<ShellModel> bent(const std::vector<Support>& supports = {}, const std::vector<Support>& of_right = {}) {
  return {piece(flat(0, 0.8, 0, 1, 8, 10), {{0, 0}, {0.4, 0}, {0.55, 0.5}, {0.5, 1}, {0, 1}, {0, 0}}, "left", supports),
          piece(flat(0.3, 1, 0, 1, 10, 13), {{0.1, 0}, {0.7, 0}, {0.7, 1}, {0.2, 1}, {0.25, 0.5}, {0.1, 0}}, "right",
                of_right)};
}

// Across the seam of bent(): it holds control points that are tied, along two axes.
Support diaphragm() {
  Support out;
  out.edges = kVMin | kVMax, out.clamped = false, out.axes = {true, true, false};
  return out;
}

// Pieces of one cylinder of radius 0.5 along a line that is straight in its parameters.
std::vector<ShellModel> round() {
  const auto of = [](int nu, int nv) { return cylinder(0.5, 1.0, 1.2, nu, nv); };
  const Patch one = with_parameters_as_lengths(of(9, 10));
  const double u = one.knots_u.end(), v = one.knots_v.end();
  const Patch other = with_parameters_as_lengths(of(12, 13));
  const double s = other.knots_u.end(), t = other.knots_v.end();
  return {piece(of(9, 10), {{0, 0}, {0.4 * u, 0}, {0.6 * u, v}, {0, v}, {0, 0}}, "left"),
          piece(of(12, 13), {{0.4 * s, 0}, {s, 0}, {s, t}, {0.6 * s, t}, {0.4 * s, 0}}, "right")};
}

// A trimmed flap at right angles on a trimmed plate.
std::vector<ShellModel> crease() {
  const Patch upright = placed(flat(-0.5, 0.5, -0.5, 0.5, 9, 9), Vec3(0.6, 0.5, 0.5),
                               Quat(Eigen::AngleAxisd(-0.5 * M_PI, Vec3::UnitY())));
  return {piece(flat(0, 1, 0, 1, 10, 10), {{0, 0}, {0.6, 0}, {0.6, 1}, {0, 1}, {0, 0}}, "plate"),
          piece(upright, {{0, 0.2}, {0, 0.8}, {0.7, 0.5}, {0, 0.2}}, "flap")};
}

void shake(Stitched& s, double size) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-size, size);
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); ++i)
      if (const int slot = s.model(k).tables.slot(i); s.state(k).motion.inverse_mass[slot] > 0.0)
        s.state(k).add_velocity(slot, Vec3(uniform(random), uniform(random), uniform(random)));
}

double energy(const Stitched& s) {
  double sum = 0.0;
  for (std::size_t k = 0; k < s.size(); ++k)
    for (std::size_t i = 0; i < s.state(k).motion.mass.size(); ++i)
      sum += 0.5 * s.state(k).motion.mass[i] * s.state(k).velocity(static_cast<int>(i)).squaredNorm();
  return sum;
}

// Largest difference across a seam of velocities [m/s], weighted over an element.
double parted(Stitched& s) {
  double most = 0.0;
  std::vector<const ShellModel*> models;
  for (std::size_t k = 0; k < s.size(); ++k) models.push_back(&s.model(k));
  for (const Seam& seam : s.seams())
    for (const auto& row : seam_rows(seam, models).ties) {
      Vec3 sum = Vec3::Zero();
      for (const WeightedSlot& t : row) sum += t.weight * s.state(t.shell).velocity(t.slot);
      most = std::max(most, sum.norm());
    }
  return most;
}

}  // namespace

TEST(SeamTies, RowsOfRestAreZeroAndSoAreThoseOfAnyRigidMotion) {
  for (const auto& pieces : {bent(), round()}) {
    Stitched s(pieces, Join::kClamped, kTolerance);
    ASSERT_EQ(s.seams().size(), 1u);
    EXPECT_TRUE(s.seams()[0].smooth);
    const std::vector<const ShellModel*> models{&s.model(0), &s.model(1)};
    const SeamRows rows = seam_rows(s.seams()[0], models);
    EXPECT_TRUE(rows.creases.empty());
    EXPECT_GE(rows.ties.size(), 16u);  // position and slope, an element apart
    for (const auto& row : rows.ties) {
      double weight = 0.0, size = 0.0;
      Vec3 at = Vec3::Zero();
      for (const WeightedSlot& t : row)
        weight += t.weight, size += std::abs(t.weight), at += t.weight * s.state(t.shell).position(t.slot);
      EXPECT_NEAR(weight, 0.0, 1e-13 * size);
      EXPECT_LT(at.norm(), 1e-13 * size);
    }
  }
}

TEST(SeamTies, AlignKeepsMomentaAndTakesWhatItSays) {
  for (const auto& pieces : {bent(), round()}) {
    Stitched s(pieces, Join::kClamped, kTolerance);
    shake(s, 1.0);
    const auto before = s.sums();
    const double start = energy(s);
    EXPECT_GT(parted(s), 0.1);
    std::vector<const ShellModel*> models{&s.model(0), &s.model(1)};
    SeamTies ties(seam_rows(s.seams()[0], models).ties, {}, models);
    const double lost = ties.align(s.refs(), 0.0, false);
    const auto after = s.sums();
    EXPECT_LT(parted(s), 1e-12);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
    EXPECT_NEAR(start - energy(s), lost, 1e-12 * start);
    EXPECT_GT(lost, 0.0);
  }
}

TEST(SeamTies, ForcesHaveNeitherSumNorMomentAndTiedPointsAccelerateAlike) {
  Stitched s(round(), Join::kClamped, kTolerance);
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (std::size_t k = 0; k < s.size(); ++k)
    for (double& f : s.state(k).motion.force) f = uniform(random);
  const auto sums = [&] {
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    for (std::size_t k = 0; k < s.size(); ++k)
      for (int i = 0; i < s.model(k).control_points(); ++i) {
        const int slot = s.model(k).tables.slot(i);
        const Vec3 f = s.state(k).at(s.state(k).motion.force, slot);
        force += f, moment += s.state(k).position(slot).cross(f);
      }
    return std::pair(force, moment);
  };
  const auto before = sums();
  s.stitching().move_forces(s.refs());
  const auto after = sums();
  EXPECT_LT((after.first - before.first).norm(), 1e-11);
  EXPECT_LT((after.second - before.second).norm(), 1e-11);
  for (std::size_t k = 0; k < s.size(); ++k)
    for (int i = 0; i < s.model(k).control_points(); ++i) {
      const int slot = s.model(k).tables.slot(i);
      ShellState& state = s.state(k);
      state.add_velocity(slot, state.motion.inverse_mass[slot] * state.at(state.motion.force, slot));
    }
  double most = 0.0;
  for (std::size_t k = 0; k < s.size(); ++k)
    for (const double v : s.state(k).motion.v) most = std::max(most, std::abs(v));
  EXPECT_LT(parted(s), 1e-10 * most);
}

// Flight of pieces that spin and shake: momenta stay, energy too, and the seam stays together.
TEST(SeamTies, FlightKeepsMomentaEnergyAndTheSeam) {
  for (const auto& [pieces, smooth] : {std::pair{round(), true}, {crease(), false}}) {
    Stitched s(pieces, Join::kClamped, kTolerance);
    ASSERT_EQ(s.seams().size(), 1u);
    EXPECT_EQ(s.seams()[0].smooth, smooth);
    s.stitching().move_masses(s.refs());
    for (std::size_t k = 0; k < s.size(); ++k)
      for (int i = 0; i < s.model(k).control_points(); ++i) {
        const int slot = s.model(k).tables.slot(i);
        if (s.state(k).motion.inverse_mass[slot] == 0.0) continue;
        const Vec3 x = s.state(k).position(slot);
        s.state(k).add_velocity(
            slot, Vec3(3, 5, -4).cross(x) + Vec3(0.3 * x.y() * x.z(), x.x() * x.z(), 2.0 * x.y() * x.x()));
      }
    s.stitching().align_velocities(s.refs());
    const double dt = 0.7 * s.stable();
    const auto before = s.sums();
    const std::vector<const ShellModel*> models{&s.model(0), &s.model(1)};
    const SeamRows rows = seam_rows(s.seams()[0], models);
    EXPECT_EQ(rows.creases.empty(), smooth);
    const auto lengths = [&] {
      std::vector<double> out;
      for (const auto& row : rows.creases) {
        Vec3 sum = Vec3::Zero();
        for (const WeightedSlot& t : row) sum += t.weight * s.state(t.shell).position(t.slot);
        out.push_back(sum.norm());
      }
      return out;
    };
    const std::vector<double> rest = lengths();
    const double first = s.forces(true) + s.kinetic(dt);
    for (int step = 0; step < 2000; ++step) s.step(dt);
    const auto after = s.sums();
    // Round-off of 2000 steps. Leapfrog keeps energy to the square of the step over the period of the shake. A
    // crease is kept at the end of a step and not within it.
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-13 * before.angular_scale);
    EXPECT_NEAR((s.forces(true) + s.kinetic(dt)) / first, 1.0, smooth ? 1e-7 : 2e-5);
    const std::vector<double> length = lengths();
    for (std::size_t k = 0; k < rest.size(); ++k) EXPECT_NEAR(length[k] / rest[k], 1.0, 1e-12) << k;
    double apart = 0.0;
    for (const SeamPlace& p : s.seams()[0].places)
      apart = std::max(apart, (s.at(s.seams()[0].first, p.first) - s.at(s.seams()[0].second, p.second)).norm());
    EXPECT_LT(apart, 3e-4);  // ties are kept over elements, of a tenth, not at each place: to a part in 300 of one
  }
}

TEST(SeamTies, StableStepIsThatOfThePieces) {
  for (const auto& pieces : {bent(), round(), crease(), bent({diaphragm()}, {diaphragm()})}) {
    double least = 1e300;
    for (const ShellModel& m : pieces) {
      ShellState alone = make_state(m, Vec3::Zero(), 0);
      least = std::min(least, stable_step(m, alone, kStepIterations, 1, true));
    }
    Stitched s(pieces, Join::kClamped, kTolerance);
    s.stitching().move_masses(s.refs());
    // constraints take no step away, with supports or without; power iteration comes from above
    for (const char free : {0, 1})
      EXPECT_GE(stable_step(s.refs(), s.stitching(), 400, 1, std::vector<char>(s.size(), free)), 0.999 * least);
  }
}

// A support takes the velocity along its axes, and the forces of ties count on that.
TEST(SeamTies, PointsThatAreHeldAlongSomeAxesAccelerateAlikeOnceTheirSupportsHaveActed) {
  Stitched s(bent({diaphragm()}, {diaphragm()}), Join::kClamped, kTolerance);
  s.stitching().move_masses(s.refs());
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (std::size_t k = 0; k < s.size(); ++k)
    for (double& f : s.state(k).motion.force) f = uniform(random);
  s.stitching().move_forces(s.refs());
  double most = 0.0;
  for (std::size_t k = 0; k < s.size(); ++k) {
    ShellState& state = s.state(k);
    for (int i = 0; i < s.model(k).control_points(); ++i) {
      const int slot = s.model(k).tables.slot(i);
      state.add_velocity(slot, state.motion.inverse_mass[slot] * state.at(state.motion.force, slot));
    }
    for (const double v : state.motion.v) most = std::max(most, std::abs(v));
  }
  EXPECT_GT(parted(s), 1e-3 * most);
  for (std::size_t k = 0; k < s.size(); ++k) {
    std::vector<double>& v = s.state(k).motion.v;
    for (int d = 0; d < 3; ++d)
      for (const int slot : s.model(k).constraints.held[d]) v[d * (v.size() / 3) + slot] = 0.0;
  }
  EXPECT_LT(parted(s), 1e-10 * most);
}

TEST(SeamTies, HingesTieNoSlope) {
  Stitched s(bent(), Join::kHinge, 1e-5);
  Stitched clamped(bent(), Join::kClamped, 1e-5);
  const std::vector<const ShellModel*> models{&s.model(0), &s.model(1)};
  EXPECT_EQ(2 * seam_rows(s.seams()[0], models).ties.size(), seam_rows(clamped.seams()[0], models).ties.size());
}

TEST(SeamTies, SupportsThatMoveAtASeamAreRefused) {
  Support moving;
  moving.edges = kVMin, moving.motion = {{0.0, Vec3::Zero()}, {1.0, Vec3(0, 0, 0.1)}};
  Support symmetry;
  symmetry.edges = kVMin, symmetry.symmetry = 1;
  for (const Support& support : {moving, symmetry}) {
    try {
      Stitched s(bent({support}), Join::kClamped, 1e-5);
      FAIL() << "accepted";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("lies at a seam along a trim; hold another part"), std::string::npos)
          << e.what();
    }
  }
  Support still;
  still.edges = kVMin;
  Stitched s(bent({still}), Join::kClamped, 1e-5);
  EXPECT_FALSE(s.stitching().empty());
}
