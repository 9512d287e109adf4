// Fibres that shear and pressure damage, in sheets that are pressed together and drawn over each other.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "shell/solver/contact/fibres.h"
#include "tests/shell/fixtures.h"
#include "tests/shell/pile.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

constexpr double kDepth = 0.01, kSide = 0.5;  // thickness and width [m]
// complete at three times the shear of its strength: at a shear of 0.3
const FibreLaw kTearing{1e6, 1e5, 0.5, 1e4, FibreLaw{}.crushing_strength, 0.5};

ShellModel strong_sheet(double z) {
  ShellMaterial m;
  m.density = 1000, m.youngs_modulus = 1e7, m.poisson_ratio = 0.3, m.strength = 1e6, m.fracture_energy = 1e3;
  return make_shell("sheet", plate(kSide, kSide, 8, 8, Vec3(0, 0, z), Quat::Identity()), kDepth, m, 2, 2, {});
}

// Two sheets that touch; the upper one is moved as a whole, and the lower one stays.
struct Rubbed {
  Pile pile;
  double work = 0.0;  // of what moves it [J]
  Vec3 force = Vec3::Zero();

  explicit Rubbed(const FibreLaw& law, bool heals = true)
      : pile({{strong_sheet(0.0), law}, {strong_sheet(kDepth * (1.0 + 1e-9)), law}}, 0.0625) {
    for (std::size_t k = 0; k < 2; ++k) pile.state(k).layers.heals = heals;
  }
  /// Moves it by `way` [m] in this many steps; `look` after each.
  template <class F>
  void move(const Vec3& way, int steps, F&& look) {
    constexpr double kTime = 1e-4;  // of a step [s]; fibres know no rate
    for (int k = 0; k < steps; ++k) {
      ShellState& s = pile.state(1);
      const std::size_t stride = s.motion.mass.size();
      for (std::size_t i = 0; i < stride; ++i)
        for (std::size_t d = 0; d < 3; ++d)
          if (s.motion.mass[i] > 0.0)
            s.motion.v[d * stride + i] = way[d] / steps / kTime, s.motion.x[d * stride + i] += way[d] / steps;
      pile.fibres().advance(pile.refs(), kTime);
      const Vec3 before = std::exchange(force, felt());
      work -= 0.5 * (before + force).dot(way) / steps;
      look();
    }
  }
  void move(const Vec3& way, int steps) {
    move(way, steps, [] {});
  }
  /// Presses it until p is k (1 - r33)^2 with this r33.
  void press(double length) { move(Vec3(0, 0, (length - 1.0) * kDepth), 100); }
  /// Sum of the fibres' forces on it [N].
  Vec3 felt() {
    for (const ShellRef& r : pile.refs()) r.state->motion.force.assign(r.state->motion.force.size(), 0.0);
    pile.fibres().add_forces(pile.refs());
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < pile.model(1).control_points(); ++i)
      sum += pile.state(1).at(pile.state(1).motion.force, pile.model(1).tables.slot(i));
    return sum;
  }
  /// Least and largest damage of the fibres that touch.
  std::pair<float, float> touching(bool worst = false) const {
    std::pair<float, float> out{1.0f, 0.0f};
    each([&](const ShellState& s, std::size_t i, bool touches) {
      const float c = (worst ? s.layers.through_his : s.layers.through)[i];
      if (touches) out = {std::min(out.first, c), std::max(out.second, c)};
    });
    return out;
  }
  /// Largest damage of the fibres on the other faces.
  float apart() const {
    float out = 0.0f;
    each([&](const ShellState& s, std::size_t i, bool touches) {
      if (!touches) out = std::max(out, s.layers.through_his[i]);
    });
    return out;
  }
  double book(double EnergyBook::*entry) const { return pile.state(0).book.*entry + pile.state(1).book.*entry; }

 private:
  template <class F>
  void each(F&& f) const {
    for (std::size_t k = 0; k < 2; ++k) {
      const RowTables& t = pile.model(k).tables;
      for (int q = 0; q < t.blocks(); ++q)
        for (int e = 0; e < t.spans_u; ++e)
          for (std::size_t side = 0; side < 2; ++side)
            f(pile.state(k), 2 * (static_cast<std::size_t>(q) * t.lanes + e) + side, (k == 0) == (side == 1));
    }
  }
};

// The grid makes lengths and shears of fibres wrong by up to this share (`validate contact --case compression`).
constexpr double kGridError = 0.01;
// Damage at a shear stress of q strengths; its slope over q is at most 1.5.
double eq9(double q) { return std::clamp(1.5 * (1.0 - 1.0 / q), 0.0, 1.0); }

}  // namespace

TEST(TornFibres, OfSheetsThatAreDrawnOverEachOtherFollowTheClosedForm) {
  for (const bool heals : {true, false}) {
    Rubbed r(kTearing, heals);
    r.press(0.8);  // p is 4e4 Pa, and friction holds 2e4
    EXPECT_EQ(r.touching().second, 0.0f);
    const double pressed = r.force.z();
    EXPECT_NEAR(pressed, 4e4 * kSide * kSide, 2.0 * kGridError * 4e4 * kSide * kSide);  // (1 - r33)^2
    double slid = 0.0;
    for (int k = 0; k < 40; ++k) {
      r.move(Vec3(1e-4, 0, 0), 10), slid += 1e-4;
      const double shear = slid / kDepth, c = eq9(shear * 1e5 / 1e4);
      EXPECT_NEAR(r.touching().first, c, 1.5 * kGridError) << shear;
      EXPECT_NEAR(r.touching().second, c, 1.5 * kGridError) << shear;
      EXPECT_NEAR(r.force.x(), -(1.0 - c) * 1e5 * shear * kSide * kSide, kGridError * 1e4 * kSide * kSide) << shear;
    }
    EXPECT_EQ(r.touching(), std::pair(1.0f, 1.0f));
    EXPECT_EQ(r.apart(), 0.0f);                          // those touch nothing
    EXPECT_NEAR(r.force.z(), pressed, 1e-3 * pressed);   // torn by shear, they bear the pressure
    const double all = 1500.0 * kDepth * kSide * kSide;  // J/m^3 of the half of either sheet
    const double taken = r.book(heals ? &EnergyBook::healing : &EnergyBook::fracture);
    EXPECT_NEAR(taken, all, 1e-3 * all);  // a thousandth of its shear a step
    EXPECT_EQ(r.book(heals ? &EnergyBook::fracture : &EnergyBook::healing), 0.0);
    EXPECT_NEAR(r.work, r.pile.fibres().energy() + r.pile.contact() + taken, 1e-3 * r.work);
  }
}

TEST(TornFibres, ThatFrictionHoldsLessThanTheirStrengthSlipAndStayWhole) {
  for (const int steps : {400, 4}) {  // a long step overshoots what friction holds, and damages nothing either
    Rubbed r(kTearing);
    r.press(0.9);  // friction holds 5e3 Pa, half of the strength
    r.move(Vec3(4e-3, 0, 0), steps);
    EXPECT_EQ(r.touching(true).second, 0.0f) << steps;
    EXPECT_NEAR(r.force.x(), -5e3 * kSide * kSide, 2.0 * kGridError * 5e3 * kSide * kSide) << steps;
    EXPECT_EQ(r.book(&EnergyBook::healing) + r.book(&EnergyBook::fracture), 0.0) << steps;
  }
}

TEST(TornFibres, HealOrGoBackAlongTheSecant) {
  for (const bool heals : {true, false}) {
    Rubbed r(kTearing, heals);
    r.press(0.8);
    r.move(Vec3(2e-3, 0, 0), 200);
    EXPECT_NEAR(r.touching().second, 0.75, 1.5 * kGridError);
    const double there = r.force.x(), taken = r.book(&EnergyBook::healing) + r.book(&EnergyBook::fracture);
    r.move(Vec3(-1e-3, 0, 0), 100);
    const double half = heals ? -1e4 * kSide * kSide : 0.5 * there;  // whole again, at its strength
    EXPECT_NEAR(r.force.x(), half, 2.0 * kGridError * 1e4 * kSide * kSide);
    EXPECT_NEAR(r.touching(true).second, 0.75, 1.5 * kGridError);
    const double healing = r.book(&EnergyBook::healing), fracture = r.book(&EnergyBook::fracture);
    if (heals) {
      EXPECT_LT(r.touching().second, 0.75 * kGridError + 1.5 * kGridError);
      EXPECT_NEAR(healing, 0.0, kGridError * taken);  // it came back
      EXPECT_EQ(fracture, 0.0);
    } else {
      EXPECT_EQ(r.touching(), r.touching(true));
      EXPECT_EQ(fracture, taken);
      EXPECT_EQ(healing, 0.0);
    }
  }
}

TEST(TornFibres, AreTornByPressureToo) {
  FibreLaw law = kTearing;
  law.crushing_strength = 2e4;
  Rubbed r(law);
  r.press(0.8);  // twice that
  EXPECT_NEAR(r.touching().first, 0.75, 3.0 * kGridError);
  EXPECT_NEAR(r.book(&EnergyBook::healing), 0.0, 1e-12);  // [J] no shear was lost: the pressure is borne
  EXPECT_NEAR(r.force.z(), 4e4 * kSide * kSide, 2.0 * kGridError * 4e4 * kSide * kSide);
  const double c = r.touching().first;
  r.move(Vec3(5e-4, 0, 0), 50);
  EXPECT_NEAR(r.force.x(), -(1.0 - c) * 5e3 * kSide * kSide, 3.0 * kGridError * 5e3 * kSide * kSide);
}

TEST(TornFibres, HaveTheStrengthOfTheirPlace) {
  Rubbed r(kTearing);
  for (std::size_t k = 0; k < 2; ++k)
    for (double& strength : r.pile.state(k).layers.strength) strength *= 1.5;
  r.press(0.8);
  r.move(Vec3(1.4e-3, 0, 0), 140);  // 1.4e4 Pa, as friction holds
  EXPECT_EQ(r.touching(true).second, 0.0f);
  r.move(Vec3(1.6e-3, 0, 0), 160);
  EXPECT_NEAR(r.touching().first, 0.75, 1.5 * kGridError);
}

// Layers that come apart release what their fibres still held.
TEST(TornFibres, ThatComeApartAreReleasedAndBooksClose) {
  for (const bool heals : {true, false}) {
    Rubbed r(kTearing, heals);
    r.press(0.8);
    r.move(Vec3(2e-3, 0, 0), 200);
    r.move(Vec3(0, 0, 4e-3), 400);
    r.move(Vec3(0, 0, 0.2), 4);  // out of reach
    EXPECT_EQ(r.pile.fibres().energy(), 0.0);
    EXPECT_EQ(r.touching().second, heals ? 0.0f : r.touching(true).second);
    const double lost = r.pile.contact() + r.book(&EnergyBook::healing) + r.book(&EnergyBook::fracture);
    EXPECT_NEAR(r.work, lost, 5e-3 * lost) << heals;  // the last steps are long beside what is left of the overlap
    for (std::size_t k = 0; k < 2; ++k)
      for (std::size_t i = 0; i < r.pile.state(k).layers.fibres.size(); ++i)
        EXPECT_EQ(r.pile.state(k).layers.fibres[i], i % 3 == 2 ? 1.0 : 0.0);
  }
}

TEST(TornFibres, TakeNoMemoryWhereTheyCannotTear) {
  ShellModel m = strong_sheet(0.0);
  m.fibres = {1e6, 1e5, 0.5};
  const ShellState whole = make_state(m, Vec3::Zero(), 0);
  EXPECT_FALSE(whole.layers.fibres.empty());
  EXPECT_EQ(whole.layers.through.capacity() + whole.layers.through_his.capacity(), 0u);
  m.fibres = kTearing;
  const ShellState torn = make_state(m, Vec3::Zero(), 0);
  EXPECT_EQ(torn.layers.through.size(), torn.layers.fibres.size() / 3);
  EXPECT_EQ(torn.layers.through_his, std::vector<float>(torn.layers.through.size(), 0.0f));
}
