#include "shell/solver/parting/piece_geometry.h"

namespace sunder::shell {
namespace {

// Where the thickness varies, with its value at the middle of each side.
PieceGeometry tapered_geometry(const ShellModel& m, const Triangulation& t, int piece) {
  PieceGeometry g;
  for (const int i : t.triangles_of(piece)) {
    Vec2 p[3];
    Vec3 c[3];
    for (int k = 0; k < 3; ++k) p[k] = t.vertices[t.triangles[i][k]], c[k] = m.patch.evaluate(p[k]).x;
    const Vec3 cross = (c[1] - c[0]).cross(c[2] - c[0]);
    const double area = 0.5 * cross.norm();
    if (area == 0.0) continue;
    const Vec3 n = cross / (2.0 * area);
    g.area += area;
    for (int k = 0; k < 3; ++k) {
      const double tau = m.thickness_at(Vec2(0.5 * (p[k] + p[(k + 1) % 3]))), part = area / 3.0 * tau / m.thickness;
      const Vec3 x = 0.5 * (c[k] + c[(k + 1) % 3]);
      g.volume += part, g.centre += part * x;
      g.second += part * (x * x.transpose() + tau * tau / 12.0 * n * n.transpose());
    }
  }
  if (g.volume > 0.0) {
    g.centre /= g.volume;
    g.second -= g.volume * g.centre * g.centre.transpose();
  }
  return g;
}

}  // namespace

PieceGeometry rest_geometry(const ShellModel& m, const Triangulation& t, int piece) {
  if (m.varies()) return tapered_geometry(m, t, piece);
  PieceGeometry g;
  Mat3 about_origin = Mat3::Zero();
  for (const int i : t.triangles_of(piece)) {
    Vec3 c[3];
    for (int k = 0; k < 3; ++k) c[k] = m.patch.evaluate(t.vertices[t.triangles[i][k]]).x;
    const Vec3 cross = (c[1] - c[0]).cross(c[2] - c[0]);
    const double area = 0.5 * cross.norm();
    if (area == 0.0) continue;
    const Vec3 n = cross / (2.0 * area), sum = c[0] + c[1] + c[2];
    g.area += area, g.centre += area / 3.0 * sum;
    Mat3 second = sum * sum.transpose();
    for (const Vec3& p : c) second += p * p.transpose();
    about_origin += area / 12.0 * second + area * m.thickness * m.thickness / 12.0 * n * n.transpose();
  }
  if (g.area > 0.0) {
    g.centre /= g.area;
    g.second = about_origin - g.area * g.centre * g.centre.transpose();
  }
  g.volume = g.area;
  return g;
}

}  // namespace sunder::shell
