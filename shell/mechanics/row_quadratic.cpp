#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction quadratic_row(RowShape shape, const LayerMemory& memory, bool energy, bool stress) {
  return row_function<3>(shape, memory, energy, stress);
}

}  // namespace sunder::shell
