#include "shell/io/crack_lines.h"

#include <algorithm>

#include "shell/solver/trimming.h"

namespace sunder::shell {
namespace {

// Moves the end of an edge that leaves the patch to the border, along the edge.
Vec2 held_back(const ShellModel& m, Vec2 p, const Vec2& other) {
  const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()), high(m.patch.knots_u.end(), m.patch.knots_v.end());
  for (int k = 0; k < 2; ++k) {
    const double held = std::clamp(p[k], low[k], high[k]);
    if (held != p[k] && other[k] != p[k])
      p = other + std::clamp((held - other[k]) / (p[k] - other[k]), 0.0, 1.0) * (p - other);
  }
  return p.cwiseMax(low).cwiseMin(high);  // an edge entirely outside
}

Vec3 place_now(const ShellModel& m, const ShellState& s, const Vec2& p) {
  Vec3 x = Vec3::Zero();
  for (const GatheredFunction& f : shell_functions(m, p)) x += f.n[0] * s.position(f.slot);
  return x;
}

// Slot of the control point whose function is the largest in the middle of an edge.
int nearest_slot(const ShellModel& m, const CrackEdge& e) {
  const std::vector<GatheredFunction> functions =
      shell_functions(m, 0.5 * (held_back(m, e.a, e.b) + held_back(m, e.b, e.a)));
  return std::max_element(functions.begin(), functions.end(),
                          [](const auto& a, const auto& b) { return a.n[0] < b.n[0]; })
      ->slot;
}

DrawnLine line_of(const ShellModel& m, const ShellState& s, const CrackEdge& e, int shell, bool moves) {
  DrawnLine line;
  for (const int end : {0, 1}) {
    const Vec2& p = end == 0 ? e.a : e.b;
    const Vec2 drawn = held_back(m, p, end == 0 ? e.b : e.a);
    line.rest[end] = m.patch.evaluate(drawn).x, line.parameter[end] = p;
    line.displacement[end] = moves ? Vec3(place_now(m, s, drawn) - line.rest[end]) : Vec3(Vec3::Zero());
    line.points[end] = line.rest[end] + line.displacement[end];
  }
  line.crack = e.crack, line.time = e.time, line.shell = shell;
  return line;
}

}  // namespace

std::vector<DrawnLine> leaving_lines(const ShellModel& m, const ShellState& s, int shell,
                                     const std::function<bool(int slot)>& leaves) {
  std::vector<DrawnLine> lines;
  for (const CrackEdge& e : s.cracks.graph.edges())
    if (!e.is_trim() && leaves(nearest_slot(m, e))) lines.push_back(line_of(m, s, e, shell, true));
  return lines;
}

std::vector<DrawnLine> crack_lines(const ShellModel& m, const ShellState& s, int shell) {
  std::vector<DrawnLine> lines;
  for (const CrackEdge& e : s.cracks.graph.edges())
    if (!e.is_trim()) lines.push_back(line_of(m, s, e, shell, m.laminated() && !s.motion.detached[nearest_slot(m, e)]));
  return lines;
}

std::vector<DrawnLine> seen_from(const BodyMotion& body, std::vector<DrawnLine> lines) {
  for (DrawnLine& line : lines)
    for (Vec3& x : line.points) x = body.orientation.conjugate() * (x - body.position);
  return lines;
}

void add_carried(const BodyMotion& body, const std::vector<DrawnLine>& carried, std::vector<DrawnLine>& lines) {
  for (DrawnLine line : carried) {
    for (const int end : {0, 1}) {
      line.points[end] = body.position + body.orientation * line.points[end];
      line.displacement[end] = line.points[end] - line.rest[end];
    }
    lines.push_back(line);
  }
}

VtpMesh line_mesh(const std::vector<DrawnLine>& lines) {
  VtpMesh mesh;
  VtpArray crack{"crack", 1, {}, true}, time{"time", 1, {}, false, "s"}, shell{"shell", 1, {}, true};
  VtpArray displacement{"displacement", 3, {}, false, "m"}, parameter{"parameter", 3, {}};
  for (const DrawnLine& line : lines) {
    const int first = static_cast<int>(mesh.points.size());
    for (const int end : {0, 1}) {
      const Vec3& u = line.displacement[end];
      const Vec2& p = line.parameter[end];
      mesh.points.push_back(line.points[end]);
      displacement.values.insert(displacement.values.end(), {u.x(), u.y(), u.z()});
      parameter.values.insert(parameter.values.end(), {p.x(), p.y(), 0.0});
    }
    mesh.lines.push_back({first, first + 1});
    crack.values.push_back(line.crack), time.values.push_back(line.time), shell.values.push_back(line.shell);
  }
  mesh.point_data = {displacement, parameter};
  mesh.cell_data = {crack, time, shell};
  return mesh;
}

}  // namespace sunder::shell
