#include "coupler/core/free_rotation.h"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "coupler/core/body.h"

using namespace sunder;

namespace {

double energy(const Vec3& inertia, const Vec3& momentum, const Quat& q) {
  const Vec3 local = q.conjugate() * momentum;
  return 0.5 * local.dot(local.cwiseQuotient(inertia));
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
}

}  // namespace

// Ten thousand steps at most: a spin that no window resolves must not stop the run.
TEST(FreeRotation, OfAnAbsurdSpinEndsWithARotation) {
  const Vec3 inertia(0.1, 0.2, 0.25);
  for (const double spin : {1e6, 1e12, 1e100}) {
    const Quat q = free_rotation(inertia, spin * Vec3(0.3, 1.0, -0.2), Quat::Identity(), 1e-3);
    EXPECT_NEAR(q.norm(), 1.0, 1e-12) << spin;
  }
  free_rotation(inertia, Vec3(0.0, INFINITY, 0.0), Quat::Identity(), 1e-3);  // what it gives is no number; it ends
}

// A handle that spins about its middle axis turns over again and again. The times are those of Jacobi's elliptic
// functions. They are 1.676303 s apart.
TEST(FreeRotation, TurnsAHandleOverAtTheSameTimesInEveryWindow) {
  for (const double window : {1e-4, 4e-3, 1e-2, 4e-2, 0.1}) {
    RigidBody handle;
    handle.mass = 0.4, handle.principal_inertia = {0.0084167, 0.0414167, 0.0351667};
    handle.motion.angular_momentum = handle.apply_inertia({0.0, 0.1, 10.0});
    const double at_first = handle.kinetic_energy();
    std::vector<double> times;
    double worst = 0.0;
    const auto spin = [&](const RigidBody& b) { return (b.motion.orientation.conjugate() * b.angular_velocity()).z(); };
    for (int k = 0; k * window < 6.0; ++k) {
      const RigidBody before = handle;
      handle.drift(window);
      worst = std::max(worst, std::abs(handle.kinetic_energy() / at_first - 1.0));
      if (spin(before) * spin(handle) > 0.0) continue;
      double early = 0.0, late = window;  // bisection within the window
      for (int i = 0; i < 40; ++i) {
        RigidBody b = before;
        const double middle = 0.5 * (early + late);
        b.drift(middle);
        (spin(before) * spin(b) > 0.0 ? early : late) = middle;
      }
      times.push_back(k * window + early);
    }
    const std::vector<double> right{0.83815, 2.51445, 4.19075, 5.86705};  // to five decimals
    ASSERT_EQ(times.size(), right.size()) << window;
    for (std::size_t i = 0; i < right.size(); ++i) EXPECT_NEAR(times[i], right[i], 3e-5) << window;
    EXPECT_LT(worst, 1e-8) << window;
  }
}

TEST(FreeRotation, IsExactForABodyWithTwoEqualMoments) {
  for (const Vec3& inertia : {Vec3(2.0, 2.0, 3.5), Vec3(2.0, 0.1, 2.0), Vec3(3.0, 1.5, 1.5), Vec3(2.0, 2.0, 2.0)}) {
    int axis = 2;
    if (inertia.x() != inertia.y()) axis = inertia.x() == inertia.z() ? 1 : 0;
    const double across = inertia[(axis + 1) % 3];
    const Quat start = rotation_from_vector({0.3, -0.2, 0.9});
    const Vec3 momentum = start * inertia.cwiseProduct(Vec3(3.0, -2.0, 5.0));
    const double h = 7.0;  // some ten turns at once
    // It precesses about the angular momentum, and spins about its axis.
    const Vec3 own = start.conjugate() * momentum;
    const Quat right = rotation_from_vector(h / across * momentum) * start *
                       rotation_from_vector(h * own[axis] * (1.0 / inertia[axis] - 1.0 / across) * Vec3::Unit(axis));
    const Quat found = free_rotation(inertia, momentum, start, h);
    EXPECT_LT(rotation_vector(found * right.conjugate()).norm(), 1e-12) << inertia.transpose();
  }
}

TEST(FreeRotation, FollowsTheAngularVelocity) {  // its derivative, by central differences of error O(h^2)
  const Vec3 inertia(1.0, 2.0, 2.6), spin(0.4, -1.0, 0.7);
  const Quat start = rotation_from_vector({1.0, 0.4, -0.3});
  const Vec3 momentum = start * inertia.cwiseProduct(spin);
  const double h = 1e-5;
  const Quat after = free_rotation(inertia, momentum, start, h), before = free_rotation(inertia, momentum, start, -h);
  EXPECT_LT((rotation_vector(after * before.conjugate()) / (2.0 * h) - start * spin).norm(), 1e-9);
}

TEST(FreeRotation, TakesStepsThatTheSpinNeeds) {
  std::mt19937 random(1);
  const auto moment = [&] { return std::pow(10.0, uniform(random, -4.0, 0.0)); };
  for (const double turn : {1e-4, 4e-4, 1e-2, 0.09, 0.5, 3.0, 30.0})
    for (int trial = 0; trial < 100; ++trial) {
      const double x = moment(), y = moment(), z = moment();
      const Vec3 inertia(y + z, x + z, x + y);
      const Vec3 axis(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
      const Vec3 momentum = inertia.cwiseProduct(axis.normalized());
      const Quat once = free_rotation(inertia, momentum, Quat::Identity(), turn);
      Quat often = Quat::Identity();
      for (int k = 0; k < 1000; ++k) often = free_rotation(inertia, momentum, often, turn / 1000);
      EXPECT_LT(rotation_vector(once * often.conjugate()).norm(), 1e-7 * turn) << turn << ": " << inertia.transpose();
      const double at_first = energy(inertia, momentum, Quat::Identity());
      EXPECT_NEAR(energy(inertia, momentum, once), at_first, 1e-8 * at_first) << turn;
    }
}
