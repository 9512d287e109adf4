#pragma once
// Parts of one CAD file or mesh that are nearer than their thickness and that no seam joins.
#include <string>
#include <vector>

#include "shell/io/build.h"

namespace sunder::shell {

/// Two shells of different groups (joined_groups) of one shell of the scene, where they are nearest.
struct NearParts {
  int first = 0, second = 0;
  double apart = 0.0;      // middle surfaces [m]
  double thickness = 0.0;  // mean of both [m]
  Vec3 at = Vec3::Zero();  // [m]
};

/// The nearest places of groups that are nearer than their mean thickness: contact parts them from the start. Places
/// are looked for at Gauss points, and distances are those of tangent planes.
std::vector<NearParts> near_parts(const RunSetup& setup);

/// The given thickness, or the largest that keeps all such parts apart; those that touch do not count.
double free_thickness(const RunSetup& setup, double thickness);

/// What is said of them, with the remedy.
std::string near_warning(const RunSetup& setup, const NearParts& near);

}  // namespace sunder::shell
