#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction quadratic_row(bool rational, bool yields, bool energy, bool stress) {
  return row_function<3>(rational, yields, energy, stress);
}

}  // namespace sunder::shell
