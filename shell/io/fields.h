#pragma once
// Fields of shells for engineers: stress, strain, resultants and more, at any place of a shell (scene.proto, Output).
#include <string>
#include <unordered_map>
#include <vector>

#include "coupler/core/vec.h"
#include "shell/io/field_set.h"
#include "shell/solver/state.h"

namespace sunder::shell {

/// An array that a field makes, for example stress_outside [Pa] with components xx yy zz xy yz xz.
struct FieldArray {
  std::string name, unit;               // the unit is empty for pure numbers
  std::vector<std::string> components;  // empty: a number
  std::size_t size() const { return components.empty() ? 1 : components.size(); }
  /// Name with its unit as a suffix, for example stress_outside_Pa, membrane_force_N_per_m.
  std::string with_unit() const;
};

/// The arrays of the fields of shells in a set, in one order.
std::vector<FieldArray> field_arrays(FieldSet fields);

/// Impulse of contact on control points over a time, which makes the mean pressure.
struct ContactOverTime {
  std::vector<double> impulse;  // [3][component stride] [N s]; empty: none
  double time = 0.0;            // [s]
};

/// Fields of one shell at one moment. A place takes its values from the Gauss points of its element that it sees: by
/// the polynomial through all of them, or their mean where a crack or a trim has taken some.
class FieldSampler {
 public:
  FieldSampler(const ShellModel& model, const ShellState& state, FieldSet fields, const ContactOverTime& contact);
  /// Appends the values of all arrays at a parameter point, components side by side. Returns whether anything bears
  /// stress there; where nothing does, as in a piece that was handed off, they are zeros.
  bool add_values(const Vec2& at, std::vector<double>& out);

 private:
  // Values that may be averaged: normal; stress, strain of three places, force and moment in world axes; plastic strain
  // of three places, thickness, pressure.
  static constexpr int kNormal = 0, kStress = 3, kStrain = 21, kForce = 39, kMoment = 45, kPlastic = 51,
                       kThickness = 54, kPressure = 55, kValues = 56;
  using Values = Eigen::Matrix<double, kValues, 1>;
  struct Known {
    bool bears = false;
    Values values = Values::Zero();
  };
  const Known& at_gauss(int block, int lane);
  bool weights_of(const Vec2& at, int first_block, int lane, std::vector<double>& weights) const;
  void compute(int block, int lane, Known& known) const;
  double pressure(const GatheredPoint& point, const Vec3& normal) const;

  const ShellModel& model_;
  const ShellState& state_;
  FieldSet fields_;
  const ContactOverTime& contact_;
  std::unordered_map<std::size_t, Known> known_;  // by block and lane, those that were asked for
};

}  // namespace sunder::shell
