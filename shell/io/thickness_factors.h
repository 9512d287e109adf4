#pragma once
// Where the thickness of a shell varies.
#include <string>

#include "coupler/scene/load.h"
#include "shell/mechanics/row_tables.h"
#include "shell/meshes/paint.h"

namespace sunder::shell {

/// The factor on the thickness of a shell: the product of thickness_law, thickness_map and `paint` (null: none); empty
/// where the shell has none. `patch` has parameters that are lengths, `field` is the shell's. Throws Error where a map
/// cannot be read. With `fits`, throws it as well where a map has the wrong aspect ratio or a law does not reach the
/// shell. `fits` is false for a patch that is a face of the sheet, since the middle surface is another patch.
ThicknessFactor thickness_factors(const scene::LoadedScene& scene, const proto::Shell& shell, const Patch& patch,
                                  const std::string& field, const Paint* paint, bool fits = true);

/// The factor of a law along X, Y or Z at a place in the world.
double law_factor(const proto::ThicknessLaw& law, const Vec3& place);

/// Throws Error where the product is out of bounds at a Gauss point.
void check_thickness(const scene::LoadedScene& scene, const RowTables& tables, const Patch& patch,
                     const std::string& field);

}  // namespace sunder::shell
