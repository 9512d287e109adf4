#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction cubic_row(RowShape shape, const LayerMemory& memory, bool energy, bool stress) {
  return row_function<4>(shape, memory, energy, stress);
}

}  // namespace sunder::shell
