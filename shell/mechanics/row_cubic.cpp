#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction cubic_row(bool rational, bool yields, bool energy, bool stress) {
  return row_function<4>(rational, yields, energy, stress);
}

}  // namespace sunder::shell
