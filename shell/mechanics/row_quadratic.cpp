#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction quadratic_row(bool rational, LayerLaw law, bool energy, bool stress) {
  return row_function<3>(rational, law, energy, stress);
}

}  // namespace sunder::shell
