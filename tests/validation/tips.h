#pragma once
// What the lattice adds to the turn of a bent crack; tips.cpp.
#include "shell/fracture/calibrated_constants.h"

namespace sunder::validation {

/// Turn of a bent crack midway between an axis and a diagonal of the lattice, on the mean over so many places in an
/// element [degrees]; 0 on no lattice.
double bent_crack_turns(const shell::CalibratedConstants& constants, int places, int threads);

}  // namespace sunder::validation
