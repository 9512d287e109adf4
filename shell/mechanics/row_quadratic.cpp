#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction quadratic_row(bool rational, const LayerMemory& memory, bool energy, bool stress) {
  return row_function<3>(rational, memory, energy, stress);
}

}  // namespace sunder::shell
