#pragma once
// Principal axes of inertia. One file includes the eigensolver, because it is slow to compile.
#include "coupler/core/vec.h"

namespace sunder {

/// A symmetric tensor as axes * moments.asDiagonal() * axes.transpose().
struct PrincipalAxes {
  Vec3 moments;  // ascending, in the tensor's unit
  Mat3 axes;     // columns, right-handed: a rotation
};

/// Eigenvalues and eigenvectors of a symmetric tensor. Only its lower triangle is read.
PrincipalAxes principal_axes(const Mat3& tensor);

}  // namespace sunder
