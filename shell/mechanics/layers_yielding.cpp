#include "shell/mechanics/layers_yielding.h"

namespace sunder::shell {

void RowPlasticity::make_states(std::size_t layers) const {
  if (has_states()) return;
#pragma omp critical(sunder_plastic_states)
  {
    if (states->empty()) states->assign(forms->size() / kFormFields * 4 * layers, 0.0);
    std::atomic_ref<char>(*made).store(1, std::memory_order_release);
  }
}

}  // namespace sunder::shell
