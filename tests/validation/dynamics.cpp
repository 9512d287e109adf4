// Shells in motion.
#include "tests/validation/cases.h"

namespace sunder::validation {

std::vector<Case> dynamic_cases() { return {}; }

}  // namespace sunder::validation
