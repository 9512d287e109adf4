#include "coupler/link/units.h"

#include <cmath>

namespace sunder::link {
namespace {

constexpr double kUsualThickness = 4e-3;  // of shards that suit the engines' fixed lengths [m]
constexpr double kSuited = 32.0;          // engines are used in SI up to this ratio to it, and down to its inverse

double power(double unit, int exponent) { return std::ldexp(1.0, exponent * std::ilogb(unit)); }

Shape scaled(Shape shape, double by) {
  if (auto* s = std::get_if<SphereShape>(&shape)) s->radius *= by;
  if (auto* s = std::get_if<BoxShape>(&shape)) s->half_size *= by;
  if (auto* s = std::get_if<ConvexShape>(&shape)) {
    s->surface = nullptr;  // engines do not use it
    for (auto& part : s->parts)
      for (Vec3& corner : part) corner *= by;
  }
  return shape;
}

}  // namespace

double length_unit(double thickness) {
  const double ratio = thickness / kUsualThickness;
  if (!(ratio > 0.0) || (ratio <= kSuited && ratio >= 1.0 / kSuited)) return 1.0;
  return std::exp2(std::round(std::log2(ratio)));
}

// Lengths and times are divided by the unit, masses by its cube. So speeds stay, and an angular momentum is divided by
// the fourth power.
BodyMotion InUnits::inward(BodyMotion m) const {
  m.position *= power(unit_, -1), m.angular_momentum *= power(unit_, -4);
  return m;
}
std::vector<Motion> InUnits::inward(std::vector<Motion> motions) const {
  for (Motion& m : motions) m.motion = inward(m.motion);
  return motions;
}

// Adds the units to an error, because its numbers are the engine's.
template <class F>
void InUnits::in_units(F&& call) const {
  try {
    call();
  } catch (const Error& e) {
    if (unit_ == 1.0) throw;
    Error told(e.status, e.kind, fmt::format("{} (in units of {:g} m, {:g} kg)", e.what(), unit_, power(unit_, 3)));
    told.file = e.file, told.line = e.line, told.column = e.column, told.field = e.field, told.window = e.window;
    told.body = e.body;
    throw told;
  }
}

void InUnits::add(const RigidBody& body) {
  if (unit_ == 1.0) return inner_.add(body);
  RigidBody b = body;
  b.mass *= power(unit_, -3), b.principal_inertia *= power(unit_, -5);
  b.motion = inward(b.motion), b.shape = scaled(b.shape, power(unit_, -1));
  in_units([&] { inner_.add(b); });
}

void InUnits::add_joint(const Joint& joint) {
  Joint j = joint;
  j.first_frame.position *= power(unit_, -1), j.second_frame.position *= power(unit_, -1);
  in_units([&] { inner_.add_joint(j); });
}

void InUnits::advance(double window_s, const std::vector<Motion>& predicted, const std::vector<BodyId>& solved) {
  if (unit_ == 1.0) return inner_.advance(window_s, predicted, solved);
  inner_.advance(window_s * power(unit_, -1), inward(predicted), solved);
}

std::vector<State> InUnits::states() const {
  std::vector<State> states = inner_.states();
  if (unit_ == 1.0) return states;
  for (State& s : states) {
    s.mass *= power(unit_, 3);
    s.motion.position *= unit_, s.motion.angular_momentum *= power(unit_, 4);
  }
  return states;
}

std::vector<ContactRow> InUnits::rows(double window_s, const std::vector<Motion>& motions,
                                      const std::vector<BodyId>& bodies) {
  if (unit_ == 1.0) return inner_.rows(window_s, motions, bodies);
  std::vector<ContactRow> rows = inner_.rows(window_s * power(unit_, -1), inward(motions), bodies);
  for (ContactRow& r : rows) r.first_point *= unit_, r.second_point *= unit_, r.allowance *= unit_;
  return rows;
}

void InUnits::restore(const std::string& caches, const std::vector<Motion>& motions) {
  inner_.restore(caches, inward(motions));
}

}  // namespace sunder::link
