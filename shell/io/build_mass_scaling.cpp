#include "shell/io/build_mass_scaling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "coupler/scene/names.h"
#include "shell/io/build_seams.h"
#include "shell/io/space_places.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr double kMostAdded = 0.05, kMostError = 0.02;  // bounds where the scene gives none [-]
constexpr int kComparedModes = 6;
constexpr int kCorrections = 12;      // of the limit of elements, after the first try
constexpr double kTighter = 0.97;     // margin of a correction: without it the last ones would be too small
constexpr double kNearEnough = 1.02;  // ratio of a step that passes to one that does not, where a search ends

/// Shells whose elements may get mass, their stable steps and their frequencies.
class Scaler {
 public:
  Scaler(const scene::LoadedScene& scene, RunSetup& setup) : scene_(scene), setup_(setup) {
    const proto::MassScaling& m = scene.message.mass_scaling();
    bounds_.most_added = m.has_most_added() ? m.most_added() : kMostAdded;
    bounds_.most_error = m.has_most_error() ? m.most_error() : kMostError;
    count_ = m.has_modes() ? m.modes() : kComparedModes;
    for (std::size_t k = 0; k < setup.shells.size(); ++k)
      if (scales(k)) scaled_.push_back(k);
    check_shells();
    for (const ShellSetup& s : setup.shells) own_.push_back(s.model.mass);
    for (std::size_t k = 0; k < setup.shells.size(); ++k) {
      std::vector<double> of_elements = element_eigenvalues(setup.shells[k].model);
      largest_ = std::max(largest_, *std::max_element(of_elements.begin(), of_elements.end()));
      if (scales(k)) eigenvalues_.push_back(std::move(of_elements));
    }
    std::vector<double> steps = stable_steps();
    bounds_.step_before = *std::min_element(steps.begin(), steps.end());
    for (const std::vector<int>& group : groups())
      for (const int k : group) {
        for (const double mass : own_[k]) mass_ += mass;
        steps[k] = std::numeric_limits<double>::infinity();
      }
    slowest_other_ = std::min_element(steps.begin(), steps.end()) - steps.begin();
    step_of_others_ = steps[slowest_other_];
  }

  void scale() {
    const proto::MassScaling& m = scene_.message.mass_scaling();
    const std::string field = m.has_factor() ? "mass_scaling.factor" : "mass_scaling.step_s";
    const double before = bounds_.step_before, wanted = m.has_factor() ? m.factor() * before : m.step_s();
    scene_.check(wanted > before, field,
                 "is {} s, and the stable step is {:.4g} s without added mass; leave mass_scaling out", wanted, before);
    MassScaling result;
    const std::string problem = try_step(wanted, result);
    if (!problem.empty())
      scene_.fail(field, fmt::format("asks for a stable step of {:.4g} s instead of {:.4g} s: {}; {}", wanted, before,
                                     problem, remedy(wanted)));
    setup_.mass_scaling = std::move(result);
  }

 private:
  bool scales(std::size_t k) const {
    const auto& names = scene_.message.mass_scaling().shells();
    const std::string& own = setup_.shells[k].model.name;
    return names.empty() || std::any_of(names.begin(), names.end(), [&](const std::string& name) {
             return name == own || name == own.substr(0, own.find('.'));
           });
  }

  void check_shells() const {
    const auto& names = scene_.message.mass_scaling().shells();
    for (int i = 0; i < names.size(); ++i) {
      std::vector<std::string> all;
      for (const ShellSetup& s : setup_.shells) all.push_back(s.model.name);
      const bool found = std::any_of(all.begin(), all.end(), [&](const std::string& name) {
        return name == names[i] || name.substr(0, name.find('.')) == names[i];
      });
      if (!found) refuse_name(scene_, fmt::format("mass_scaling.shells[{}]", i), names[i], "shell", all);
    }
    for (const std::size_t k : scaled_)
      scene_.check(!setup_.shells[k].can_crack(), "mass_scaling",
                   "would add mass to shell '{}', which can crack: pieces would carry it off as their own; name other "
                   "shells in mass_scaling.shells, or leave it out",
                   setup_.shells[k].model.name);
  }

  // Shells that may get mass, with those that seams join to them.
  std::vector<std::vector<int>> groups() const {
    std::vector<std::vector<int>> all = joined_groups(setup_);
    std::erase_if(all, [&](const std::vector<int>& group) {
      return std::none_of(group.begin(), group.end(), [&](int k) { return scales(k); });
    });
    return all;
  }

  // Stable steps of all shells with the masses that they have now [s], as a run and `check` find them.
  std::vector<double> stable_steps() const {
    std::vector<ShellState> states;
    std::vector<ShellRef> refs;
    std::vector<double> steps;
    std::vector<char> as_if_free;
    const std::vector<const ShellModel*> models = setup_.models();
    for (const ShellModel* m : models) states.push_back(make_state(*m, Vec3::Zero(), 0));
    for (std::size_t k = 0; k < models.size(); ++k) {
      refs.push_back({models[k], &states[k]}), as_if_free.push_back(steps_as_if_free(setup_, k));
      steps.push_back(stable_step(*models[k], states[k], kStepIterations, 1, as_if_free[k]));
    }
    if (Stitching stitching(setup_.stitches, models); !stitching.empty()) {
      stitching.move_masses(refs);
      steps = joined_steps(refs, stitching, steps, as_if_free, kJoinedIterations, 1);
    }
    return steps;
  }

  double smallest_step() const {
    const std::vector<double> steps = stable_steps();
    return *std::min_element(steps.begin(), steps.end());
  }

  // Natural frequencies of all shells that get mass and of those that seams join to them, with the masses that they
  // have now [Hz], by group.
  std::vector<std::vector<double>> frequencies() {
    if (vibrations_.empty()) prepare_vibrations();
    for (std::size_t k = 0; k < states_.size(); ++k) states_[k]->motion.mass = setup_.shells[k].model.mass;
    std::vector<std::vector<double>> out;
    for (const auto& v : vibrations_) {
      std::vector<double>& own = out.emplace_back();
      for (const Mode& mode : v->lowest(count_).modes)  // a mode that grows is told by its rate
        own.push_back(std::sqrt(std::abs(mode.eigenvalue)) / (2.0 * std::numbers::pi));
    }
    return out;
  }

  void prepare_vibrations() {
    for (const ShellSetup& s : setup_.shells)
      states_.push_back(std::make_unique<ShellState>(make_state(s.model, Vec3::Zero(), 0)));
    stitching_ = Stitching(setup_.stitches, setup_.models());
    for (const std::vector<int>& group : groups()) {
      JoinedShells joined;
      joined.numbers = group;
      if (group.size() > 1) joined.stitching = &stitching_;
      std::vector<std::string> names;
      for (const int k : group) {
        joined.shells.push_back({&setup_.shells[k].model, states_[k].get()});
        joined.gravity.push_back(Vec3::Zero());
        names.push_back(setup_.shells[k].model.name);
      }
      vibrations_.push_back(std::make_unique<Vibrations>(joined, 1));
      names_.push_back(fmt::format("{}", fmt::join(names, "+")));
    }
  }

  void compare(MassScaling& result) {
    const std::vector<std::vector<double>> after = frequencies();
    if (before_.empty()) {
      const std::vector<std::vector<double>> scaled = masses();
      for (std::size_t k = 0; k < own_.size(); ++k) setup_.shells[k].model.mass = own_[k];
      before_ = frequencies();
      for (std::size_t k = 0; k < own_.size(); ++k) setup_.shells[k].model.mass = scaled[k];
    }
    result.modes.clear();
    for (std::size_t g = 0; g < after.size(); ++g)
      for (std::size_t k = 0; k < after[g].size(); ++k)
        result.modes.push_back({names_[g], static_cast<int>(k) + 1, before_[g][k], after[g][k]});
    std::stable_sort(result.modes.begin(), result.modes.end(),
                     [](const auto& a, const auto& b) { return a.before < b.before; });
    result.modes.resize(std::min<std::size_t>(result.modes.size(), count_));
  }

  std::vector<std::vector<double>> masses() const {
    std::vector<std::vector<double>> out;
    for (const ShellSetup& s : setup_.shells) out.push_back(s.model.mass);
    return out;
  }

  // Adds mass until the stable step is `wanted` [s]. Returns what is wrong with it; empty: nothing.
  std::string try_step(double wanted, MassScaling& result) {
    result = bounds_;
    if (wanted > step_of_others_)
      return fmt::format("shell '{}' gets no mass, and its stable step is {:.4g} s",
                         setup_.shells[slowest_other_].model.name, step_of_others_);
    double limit = largest_ * std::pow(bounds_.step_before / wanted, 2);
    for (int k = 0; k <= kCorrections && result.step_after < wanted; ++k) {
      if (k > 0) limit *= kTighter * std::pow(result.step_after / wanted, 2);
      result.added = 0.0;
      for (std::size_t i = 0; i < scaled_.size(); ++i)
        result.added += add_mass(setup_.shells[scaled_[i]].model, own_[scaled_[i]], eigenvalues_[i], limit);
      result.share = result.added / mass_;
      if (result.share > result.most_added)
        return fmt::format("it would add {:.3g} % to the mass of these shells, more than most_added, {:.3g} %",
                           100.0 * result.share, 100.0 * result.most_added);
      result.step_after = smallest_step();
    }
    if (result.step_after < wanted)
      return fmt::format("mass on these shells leads to {:.4g} s only", result.step_after);
    compare(result);
    if (const MassScaling::Lowered& worst = result.worst(); worst.error() > result.most_error)
      return fmt::format(
          "it would make frequency {} of {} {:.3g} % too low, {:.6g} Hz instead of {:.6g} Hz, more than "
          "most_error, {:.3g} %",
          worst.mode, worst.shells, 100.0 * worst.error(), worst.after, worst.before, 100.0 * result.most_error);
    return "";
  }

  // The largest step that passes, as a value for step_s.
  std::string remedy(double fails) {
    double passes = bounds_.step_before;
    std::string text;
    MassScaling result;
    while (fails > kNearEnough * passes) {
      const std::string middle = fmt::format("{:.4g}", std::sqrt(passes * fails));
      const double step = std::stod(middle);
      if (try_step(step, result).empty())
        passes = step, text = middle;
      else
        fails = step;
    }
    return text.empty() ? "no longer step passes: leave mass_scaling out, or take larger elements"
                        : fmt::format("step_s: {} would pass", text);
  }

  const scene::LoadedScene& scene_;
  RunSetup& setup_;
  MassScaling bounds_;  // with the step without added mass
  int count_ = 0;
  std::size_t slowest_other_ = 0;  // of shells that get no mass and are not joined to such as do
  double step_of_others_ = 0.0;    // its stable step [s]; infinite: there is none
  std::vector<std::size_t> scaled_;
  std::vector<std::vector<double>> own_, eigenvalues_;  // masses of all shells [kg]; of elements of `scaled_` [1/s^2]
  double largest_ = 0.0, mass_ = 0.0;  // eigenvalue of any element [1/s^2]; mass of all that may get more [kg]
  std::vector<std::unique_ptr<ShellState>> states_;
  Stitching stitching_;
  std::vector<std::unique_ptr<Vibrations>> vibrations_;  // of each group
  std::vector<std::string> names_;
  std::vector<std::vector<double>> before_;  // frequencies of each group without added mass [Hz]
};

}  // namespace

void scale_masses(const scene::LoadedScene& scene, RunSetup& setup) {
  try {
    Scaler(scene, setup).scale();
  } catch (const Error& e) {
    if (e.kind != "bad_input" || !e.field.empty()) throw;
    scene.fail("mass_scaling.modes", fmt::format("cannot be compared: {}", e.what()));  // too few displacements
  }
}

}  // namespace sunder::shell
