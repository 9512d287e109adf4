#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction cubic_row(bool rational, LayerLaw law, bool energy, bool stress) {
  return row_function<4>(rational, law, energy, stress);
}

}  // namespace sunder::shell
