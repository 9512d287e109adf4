#pragma once
// Contact between shells, or of a shell with itself: finds candidate samples and passes them to the grid
// (contact/field_contact.h).
#include <functional>

#include "coupler/core/archive.h"
#include "shell/contact/field_contact.h"
#include "shell/solver/contact/near_tiles.h"

namespace sunder::shell {

/// Contact between all shells of a simulation.
class ShellContact {
 public:
  /// `laws[i][k]` is the contact law between shells i and k.
  ShellContact(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams,
               std::vector<std::vector<SurfaceLaw>> laws);

  /// What shell b has got from shell a at one place [N s].
  using Exchange = std::function<void(int a, int b, const Vec3& impulse)>;

  /// Applies contact impulses to control points after the kick of `dt` [s] and books their work. Candidates are looked
  /// up every kContactRefresh substeps; without candidates there is no other cost. `share` is called between passes, so
  /// that dependent control points pass their impulses on; `exchanged` for each impulse between two different shells.
  /// Returns the number of places in contact.
  int act(const std::vector<ShellRef>& shells, double dt, const std::function<void()>& share = {},
          const Exchange& exchanged = {});
  /// Makes the next substep look up candidates again.
  void forget() { age_ = 0; }
  /// Energy [J] that impulses have taken so far, and how much more than that they may give: it parts what overlaps from
  /// the start. Once that is given, overlaps only stop. Else a fold that is tighter than its shell is thick would make
  /// energy in each substep.
  /// Dependent control points at seams count as if they were free; what the seam changes of that is not in it.
  double taken() const { return taken_; }
  void go_on_from(double taken) { taken_ = taken; }
  double lent() const { return lent_; }
  template <class A>
  void archive_state(A& a) {
    archive_one(a, taken_);
  }
  int candidates() const { return static_cast<int>(samples_.size()); }

 private:
  void refresh(const std::vector<ShellRef>& shells, double dt);
  void separate_folds(const std::vector<ShellRef>& shells, double dt, bool may_give, const Exchange& exchanged);
  void add_impulses_to_control_points(const std::vector<ShellRef>& shells, double dt);
  void add_samples(const ShellRef& shell, const Tile& tile);
  /// Calls f(slot, value) for each function of a sample.
  template <class F>
  void each_function(std::size_t sample, F&& f) const {
    for (std::size_t i = first_[sample]; i < first_[sample + 1]; ++i) f(functions_[i].first, functions_[i].second);
  }

  struct Share {
    int shell, slot;
    double share;  // derivative of two samples' separation by this control point's motion
  };

  FieldContact fields_;
  NearTiles near_;
  std::vector<SurfaceSample> samples_;
  std::vector<std::pair<int, double>> functions_;  // slots and values of all samples, one after the other
  std::vector<std::size_t> first_;                 // first function of each sample, then their total number
  std::vector<GatheredFunction> gathered_;         // scratch: functions of one sample
  std::vector<std::vector<Vec3>> impulses_;        // scratch: [shell][slot]
  std::vector<std::vector<int>> touched_;          // scratch: slots of each shell
  std::vector<Share> parting_;                     // scratch: of two samples
  int age_ = 0;
  double taken_ = 0.0;
  double lent_ = 0.0;  // kinetic energy of all shells at the speeds at which overlaps are taken back
};

}  // namespace sunder::shell
