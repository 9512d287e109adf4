#include "coupler/core/version.h"

namespace sunder {

const char* version() { return SUNDER_VERSION; }

}  // namespace sunder
