#pragma once
// Surfaces of several pieces that are tied along trims.
#include <vector>

#include "tests/validation/cases.h"

namespace sunder::validation {

std::vector<Case> tied_cases();
/// Surfaces of triangles (mesh_surfaces.cpp).
std::vector<Case> mesh_cases();
/// Shells whose thickness varies (tapers.cpp).
std::vector<Case> taper_cases();

}  // namespace sunder::validation
