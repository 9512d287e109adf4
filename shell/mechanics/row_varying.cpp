#include "shell/mechanics/row_element.h"

namespace sunder::shell {

RowFunction varying_row(int degree, const LayerMemory& memory, bool energy, bool stress) {
  return degree == 2 ? row_of_shape<3, RowShape::kVarying>(memory, energy, stress)
                     : row_of_shape<4, RowShape::kVarying>(memory, energy, stress);
}

}  // namespace sunder::shell
