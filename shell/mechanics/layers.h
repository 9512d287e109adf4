#pragma once
// The list of what layers may do beside elasticity, and the choice between them.
#include <tuple>

#include "shell/mechanics/layers_elastic.h"
#include "shell/mechanics/layers_weakening.h"
#include "shell/mechanics/layers_yielding.h"

namespace sunder::shell {

/// The first whose memory is there is in force; layers that remember both flow and damage have DuctileLayers.
/// `at(places, memory)` of a law gives its state at a pack of either kernel, or at one point. The state has these
/// members:
///   resultants<kEnergy, kRecord>(forms, ref, summed)
///       n, m and, with kEnergy, the energy [J/m^2].
///   keep<kEnergy, kRecord>(forms, own, sound, area, booked)
///       Takes over the new state. `booked` gains what the law books [J]. Returns the energy that is not stored [J].
///   unbooked()           Energy that counts as stored until it is booked [J/m^2]; null: none.
///   sound(forms, ref)    Lanes that bear; a law with kFolds needs none.
///   faces                Stress of the faces [Pa], of a law with kFolds.
/// kRemembers: there is a state to keep. kAdvances: also where no stress is recorded. kFolds: a pack takes folded
/// points at rest. book_rows and book_points add the sum of `booked` to the memory of the law.
using LayerLaws = std::tuple<YieldingLayers,          //
                             WeakeningLayers<true>,   //
                             WeakeningLayers<false>,  //
                             ElasticLayers>;

/// f(law) of the law in force.
template <std::size_t k = 0, class F>
auto with_layers(const LayerMemory& memory, F&& f) {
  using Law = std::tuple_element_t<k, LayerLaws>;
  if constexpr (k + 1 < std::tuple_size_v<LayerLaws>)
    if (!Law::in_force(memory)) return with_layers<k + 1>(memory, f);
  return f(Law{});
}

}  // namespace sunder::shell
