#pragma once
// Shells that touch one another, or themselves: finds what may meet, and hands it to the grid
// (contact/field_contact.h).
#include <functional>

#include "shell/contact/field_contact.h"
#include "shell/solver/contact/near_tiles.h"

namespace sunder::shell {

class ShellContact {
 public:
  /// `laws[i][k]` between shells i and k.
  ShellContact(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams,
               std::vector<std::vector<SurfaceLaw>> laws);

  /// Impulses on control points, after the kick of `dt` [s]; their work is booked. What may meet is looked up every
  /// kContactRefresh substeps; where that is nothing, this costs nothing else. `share` is called between its passes, to
  /// let control points that follow others hand on what they were given. Returns the places in contact.
  int act(const std::vector<ShellRef>& shells, double dt, const std::function<void()>& share = {});
  /// What may meet is looked up anew in the next substep.
  void forget() { age_ = 0; }
  int candidates() const { return static_cast<int>(samples_.size()); }

 private:
  void refresh(const std::vector<ShellRef>& shells, double dt);
  void hold_folds_open(const std::vector<ShellRef>& shells, double dt);
  void hand_over(const std::vector<ShellRef>& shells, double dt);
  void add_samples(const ShellRef& shell, const Tile& tile);
  /// Calls f(slot, value) with each function of a sample.
  template <class F>
  void each_function(std::size_t sample, F&& f) const {
    for (std::size_t i = first_[sample]; i < first_[sample + 1]; ++i) f(functions_[i].first, functions_[i].second);
  }

  struct Share {
    int shell, slot;
    double share;  // of the control point's motion in how two samples part
  };

  FieldContact fields_;
  NearTiles near_;
  std::vector<SurfaceSample> samples_;
  std::vector<std::pair<int, double>> functions_;  // slots and values, of all samples
  std::vector<std::size_t> first_;                 // function of each sample, and their number
  std::vector<GatheredFunction> gathered_;         // scratch: of a sample
  std::vector<std::vector<Vec3>> impulses_;        // scratch: [shell][slot]
  std::vector<std::vector<int>> touched_;          // scratch: slots of each shell
  std::vector<Share> parting_;                     // scratch: of two samples
  int age_ = 0;
};

}  // namespace sunder::shell
