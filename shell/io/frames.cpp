#include "shell/io/frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "coupler/core/disjoint_sets.h"
#include "coupler/core/error.h"
#include "shell/io/probes.h"
#include "shell/io/thick_sheet.h"
#include "shell/io/vtp.h"
#include "shell/solver/cracking/insertion.h"

namespace sunder::shell {
namespace {

struct Corner {
  Vec3 x, v, u;  // position, velocity, displacement
};

// Evaluates a surface point with the functions of its own side of the cracks.
Corner evaluate(const ShellModel& m, const ShellState& s, const Vec2& p, bool near_crack) {
  Corner c{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  const auto add = [&](double n, int slot) {
    c.x += n * s.position(slot), c.v += n * s.velocity(slot), c.u += n * (s.position(slot) - s.at(m.rest, slot));
  };
  const std::vector<GatheredFunction> functions = shell_functions(m, p);
  const auto visible = [&](int slot) {
    return s.cracks.graph.visible(
        p, m.trim.empty() ? m.parameter_of_slot[slot] : m.trim.home[m.tables.control_point(slot)]);
  };
  if (!near_crack || std::all_of(functions.begin(), functions.end(), [&](const auto& f) { return visible(f.slot); })) {
    for (const GatheredFunction& f : functions) add(f.n[0], f.slot);
    return c;
  }
  Visibility visibility =
      first_visibility(m, s.cracks.graph, p, m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y()));
  visibility.update(control_grid(m), s.cracks.graph, static_cast<int>(s.cracks.graph.edges().size()));
  const MlsPoint mls = mls_point(control_grid(m), visibility);
  if (mls.basis != MlsBasis::kNone) {
    for (const MlsFunction& n : mls.functions) add(n.n[0], m.tables.slot(n.control_point));
    return c;
  }
  // Too few control points are visible: the point moves with the nearest one.
  int slot = 0;
  double distance = 1e300;
  for (const GatheredFunction& f : functions) {
    const double d = (m.parameter_of_slot[f.slot] - p).squaredNorm() + (visible(f.slot) ? 0.0 : 1.0);
    if (d < distance) distance = d, slot = f.slot;
  }
  c.u = s.position(slot) - s.at(m.rest, slot), c.v = s.velocity(slot);
  c.x = m.patch.evaluate(p).x + c.u;
  return c;
}

// Numbers the corners of all triangles. Corners at one vertex have the same number where their triangles are connected
// around it.
std::vector<std::array<int, 3>> fans(const Triangulation& t) {
  const int n = static_cast<int>(t.triangles.size());
  DisjointSets corners(3 * n);
  for (int i = 0; i < n; ++i)
    for (const int other : t.neighbours[i]) {
      if (other < 0) continue;
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l)
          if (t.triangles[i][k] == t.triangles[other][l]) corners.join(3 * i + k, 3 * other + l);
    }
  std::vector<std::array<int, 3>> fan(n);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) fan[i][k] = corners.root(3 * i + k);
  return fan;
}

// Returns the largest stretch at which a triangle is still drawn as surface. Control points of an element fly freely
// where most of its Gauss points bear no stress, and some may where a crack has touched it.
double most_stretch(const ShellModel& m, const ShellState& s, const Vec2& p) {
  constexpr double kRubble = 1.5, kTouched = 6.0;
  const RowTables& t = m.tables;
  const int lane = m.patch.knots_u.span_of(p.x()), f = m.patch.knots_v.span_of(p.y()), points = t.gauss * t.gauss;
  int dead = 0, touched = 0;
  for (int sub = 0; sub < points; ++sub) {
    const int point = s.cracked.point_of[static_cast<std::size_t>(f * points + sub) * t.lanes + lane];
    if (point < 0 || s.cracked.gathered[point].in_rows) continue;
    ++touched, dead += s.cracked.gathered[point].kind == PointKind::kDead;
  }
  return 2 * dead > points ? kRubble : touched > 0 ? kTouched : std::numeric_limits<double>::infinity();
}

// Tests whether a side of the polygon is longer than `most` times its length at rest.
bool is_stretched(const VtpMesh& mesh, const VtpArray& displacement, const std::vector<int>& polygon, double most) {
  const auto rest = [&](int i) -> Vec3 {
    const double* u = &displacement.values[3 * static_cast<std::size_t>(i)];
    return mesh.points[i] - Vec3(u[0], u[1], u[2]);
  };
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const int a = polygon[k], b = polygon[(k + 1) % polygon.size()];
    if ((mesh.points[a] - mesh.points[b]).norm() > most * (rest(a) - rest(b)).norm()) return true;
  }
  return false;
}

// Returns the id that most control points of a piece have; of several such, the lowest.
BodyId id_of(const Piece& piece, const std::vector<BodyId>& ids) {
  std::map<BodyId, int> count;
  for (const int i : piece.control_points) ++count[ids[i]];
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  return count.empty() ? 0 : std::max_element(count.begin(), count.end(), fewer)->first;
}

// Arrays of the fields that a scene asks for, cell by cell.
class CellFields {
 public:
  CellFields(const ShellModel& m, const ShellState& s, FieldSet set, const ContactOverTime& contact) {
    for (const FieldArray& a : field_arrays(set))
      arrays_.push_back({a.with_unit(), static_cast<int>(a.size()), {}, false, a.unit, a.components});
    if (!arrays_.empty()) sampler_.emplace(m, s, set, contact);
  }
  // The next cell, with its centre.
  void add(const Vec2& centre) {
    if (!sampler_) return;
    values_.clear();
    sampler_->add_values(centre, values_);
    auto from = values_.begin();
    for (VtpArray& a : arrays_) {
      a.values.insert(a.values.end(), from, from + a.components);
      from += a.components;
    }
  }
  std::vector<VtpArray>& arrays() { return arrays_; }

 private:
  std::vector<VtpArray> arrays_;
  std::optional<FieldSampler> sampler_;
  std::vector<double> values_;
};

// A shell as its middle surface and, where it is asked for, as a solid.
struct ShellMeshes {
  VtpMesh middle, solid{};
};

// `ids` are those of the pieces of control points.
ShellMeshes shell_mesh(const ShellModel& m, const ShellState& s, const std::vector<BodyId>& ids,
                       const FrameFields& fields, const ContactOverTime& contact) {
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  std::vector<BodyId> id;
  for (const Piece& p : pieces) id.push_back(id_of(p, ids));
  VtpMesh mesh;
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, displacement{"displacement", 3, {}, false, "m"};
  VtpArray uv{"uv", 2, {}}, damage{"damage", 1, {}}, history{"c_his", 1, {}}, fragment{"fragment", 1, {}, true};
  CellFields asked(m, s, fields.set, contact);
  FieldSet thickness;
  if (fields.thick) thickness.add(FieldSet::kThickness);
  CellFields thick(m, s, thickness, contact);
  const auto corner = [&](const Vec2& p, bool near_crack) {
    const Corner c = evaluate(m, s, p, near_crack);
    mesh.points.push_back(c.x);
    velocity.values.insert(velocity.values.end(), {c.v.x(), c.v.y(), c.v.z()});
    displacement.values.insert(displacement.values.end(), {c.u.x(), c.u.y(), c.u.z()});
    const Vec2 share = unit_parameter(m, p);
    uv.values.insert(uv.values.end(), {share.x(), share.y()});
    return static_cast<int>(mesh.points.size()) - 1;
  };
  std::vector<char> near(t.vertices.size(), 0);
  for (std::size_t i = 0; i < near.size(); ++i)
    if (!m.laminated())  // an interlayer is continuous, as the patch is
      s.cracks.graph.near(t.vertices[i], t.vertices[i], 2.0 * m.spacing, [&](int e) {
        Vec2 foot;
        if (s.cracks.graph.distance(t.vertices[i], e, foot) < 2.0 * m.spacing) near[i] = 1;
        return !near[i];
      });
  // A vertex on a crack is written once for each fan of connected triangles around it.
  const std::vector<std::array<int, 3>> fan = fans(t);
  std::map<int, Vec2> fan_sum;  // sum of centres and their number: they tell the fan's side of the vertex
  std::map<int, int> fan_count;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto& c = t.triangles[i];
      if (!near[c[k]]) continue;
      const auto [it, fresh] = fan_sum.try_emplace(fan[i][k], Vec2::Zero());
      it->second += (t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0;
      ++fan_count[fan[i][k]];
    }
  std::map<int, int> shared;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (pieces[t.piece[i]].handed_off || pieces[t.piece[i]].control_points.empty()) continue;
    const auto& c = t.triangles[i];
    const Vec2 centre = (t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0;
    std::vector<int> polygon;
    for (int k = 0; k < 3; ++k) {
      const auto [it, fresh] = shared.try_emplace(fan[i][k], 0);
      if (fresh) {
        Vec2 p = t.vertices[c[k]];
        if (near[c[k]]) p += 0.01 * (fan_sum[fan[i][k]] / fan_count[fan[i][k]] - p);
        it->second = corner(p, near[c[k]]);
      }
      polygon.push_back(it->second);
    }
    if (!m.laminated() && is_stretched(mesh, displacement, polygon, most_stretch(m, s, centre))) continue;
    mesh.polygons.push_back(polygon);
    const int lane = m.patch.knots_u.span_of(centre.x()), f = m.patch.knots_v.span_of(centre.y());
    const std::size_t g = static_cast<std::size_t>(f) * m.tables.gauss * m.tables.gauss * m.tables.lanes + lane;
    damage.values.push_back(s.layers.c[g]), history.values.push_back(s.layers.c_his[g]),
        fragment.values.push_back(id[t.piece[i]]);
    asked.add(centre), thick.add(centre);
  }
  mesh.point_data = {velocity, displacement, uv};
  mesh.cell_data = {damage, history, fragment};
  for (VtpArray& a : asked.arrays()) mesh.cell_data.push_back(std::move(a));
  if (!fields.thick) return {std::move(mesh)};
  std::vector<double>& now = thick.arrays().front().values;
  for (double& t : now)
    if (t <= 0.0) t = m.thickness;  // nothing bears stress there
  VtpMesh solid = thick_sheet(mesh, now, m.thickness);
  return {std::move(mesh), std::move(solid)};
}

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

VtpMesh crack_mesh(const ShellModel& m, const ShellState& s) {
  VtpMesh mesh;
  VtpArray crack{"crack", 1, {}, true}, time{"time", 1, {}, false, "s"};
  // Lines lie on the surface at rest with zero displacement, so that they fit any frame. On an interlayer they move
  // with it: it is one surface that no piece leaves.
  VtpArray displacement{"displacement", 3, {}, false, "m"};
  VtpArray parameter{"parameter", 3, {}};  // of the graph itself, also beyond the border; third component 0
  for (const CrackEdge& e : s.cracks.graph.edges()) {
    if (e.is_trim()) continue;
    std::vector<int> line;
    for (const bool first : {true, false}) {
      const Vec2& p = first ? e.a : e.b;
      const Vec2 drawn = held_back(m, p, first ? e.b : e.a);
      const Vec3 rest = m.patch.evaluate(drawn).x;
      const Vec3 u = m.laminated() ? Vec3(evaluate(m, s, drawn, false).x - rest) : Vec3(Vec3::Zero());
      mesh.points.push_back(rest + u);
      displacement.values.insert(displacement.values.end(), {u.x(), u.y(), u.z()});
      parameter.values.insert(parameter.values.end(), {p.x(), p.y(), 0.0});
      line.push_back(static_cast<int>(mesh.points.size()) - 1);
    }
    mesh.lines.push_back(line);
    crack.values.push_back(e.crack), time.values.push_back(e.time);
  }
  mesh.point_data = {displacement, parameter};
  mesh.cell_data = {crack, time};
  return mesh;
}

// Appends the mesh of shell number `shell`, with that number as a cell array.
void append(VtpMesh& all, VtpMesh one, int shell) {
  const int first = static_cast<int>(all.points.size());
  const std::size_t cells = one.polygons.size() + one.lines.size();
  one.cell_data.push_back({"shell", 1, std::vector<double>(cells, shell), true});
  if (first == 0 && all.cell_data.empty()) {
    all = std::move(one);
    return;
  }
  all.points.insert(all.points.end(), one.points.begin(), one.points.end());
  for (auto* lists : {&one.polygons, &one.lines})
    for (std::vector<int>& list : *lists) {
      for (int& i : list) i += first;
      (lists == &one.lines ? all.lines : all.polygons).push_back(std::move(list));
    }
  const auto join = [](std::vector<VtpArray>& to, const std::vector<VtpArray>& from) {
    for (std::size_t k = 0; k < to.size(); ++k)
      to[k].values.insert(to[k].values.end(), from[k].values.begin(), from[k].values.end());
  };
  join(all.point_data, one.point_data), join(all.cell_data, one.cell_data);
}

struct BodyMesh {
  VtpMesh mesh;
  VtpArray body{"body", 1, {}, true}, kind{"kind", 1, {}, true};
  // where the scene asks for them
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, spin{"spin_rad_per_s", 3, {}, false, "rad/s"},
      mass{"mass_kg", 1, {}, false, "kg"};
  // displacement and parameters of pieces of shells; zero for other bodies
  VtpArray displacement{"displacement", 3, {}, false, "m"}, uv{"uv", 2, {}};
  BodyId id = 0;  // of the body that is drawn, and its kind
  int kind_now = 0;
  void cell(std::vector<int> corners) {
    mesh.polygons.push_back(std::move(corners));
    body.values.push_back(id), kind.values.push_back(kind_now);
  }
  void polygon(const std::vector<Vec3>& points) {
    std::vector<int> p;
    for (const Vec3& x : points) {
      p.push_back(static_cast<int>(mesh.points.size()));
      mesh.points.push_back(x);
    }
    for (std::size_t i = 1; i + 1 < p.size(); ++i) cell({p[0], p[i], p[i + 1]});
  }
};

void add_prism(BodyMesh& out, const RigidBody& b, const std::vector<Vec3>& corners) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  const std::size_t n = corners.size() / 2;
  std::vector<Vec3> low, high;
  for (std::size_t i = 0; i < n; ++i)
    low.insert(low.begin(), world(corners[2 * i])), high.push_back(world(corners[2 * i + 1]));
  out.polygon(low), out.polygon(high);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    out.polygon({world(corners[2 * i]), world(corners[2 * j]), world(corners[2 * j + 1]), world(corners[2 * i + 1])});
  }
}

void add_hull(BodyMesh& out, const RigidBody& b, const std::vector<Vec3>& c) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  for (std::size_t i = 0; i < c.size(); ++i)
    for (std::size_t j = 0; j < c.size(); ++j)
      for (std::size_t k = 0; k < c.size(); ++k) {
        if (i >= j || i >= k || j == k) continue;
        const Vec3 n = (c[j] - c[i]).cross(c[k] - c[i]);
        bool face = n.norm() > 0.0;
        for (std::size_t l = 0; l < c.size() && face; ++l) face = n.dot(c[l] - c[i]) <= 1e-9 * n.norm();
        if (face) out.polygon({world(c[i]), world(c[j]), world(c[k])});
      }
}

int kind_of(const RigidBody& b, BodyId first_shard) {
  return b.id >= first_shard ? (b.is_static ? 3 : 1) : (b.is_static ? 2 : 0);
}

void add_mesh(BodyMesh& out, const RigidBody& b, const DrawnMesh& mesh) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  const int first = static_cast<int>(out.mesh.points.size());
  for (const Vec3& p : mesh.points) out.mesh.points.push_back(world(p));
  for (const auto& c : mesh.triangles) out.cell({first + c[0], first + c[1], first + c[2]});
}

void add_body(BodyMesh& out, const RigidBody& b) {
  const auto world = [&](const Vec3& p) -> Vec3 { return b.motion.position + b.motion.orientation * p; };
  if (const auto* s = std::get_if<SphereShape>(&b.shape)) {
    constexpr int kRings = 12, kSectors = 24;
    const auto at = [&](int i, int j) -> Vec3 {
      const double polar = std::numbers::pi * i / kRings, around = 2.0 * std::numbers::pi * j / kSectors;
      return world(s->radius *
                   Vec3(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)));
    };
    for (int i = 0; i < kRings; ++i)
      for (int j = 0; j < kSectors; ++j) out.polygon({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  } else if (const auto* s = std::get_if<BoxShape>(&b.shape)) {
    std::vector<Vec3> corners;
    for (const auto& [x, y] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
      for (const int z : {-1, 1}) corners.push_back(s->half_size.cwiseProduct(Vec3(x, y, z)));
    add_prism(out, b, corners);
  } else if (std::holds_alternative<HalfSpaceShape>(b.shape)) {
    out.polygon({world({-1, -1, 0}), world({1, -1, 0}), world({1, 1, 0}), world({-1, 1, 0})});
  } else if (const auto* s = std::get_if<ConvexShape>(&b.shape)) {
    if (s->surface)
      add_mesh(out, b, {s->surface->corners, s->surface->triangles});
    else
      for (const auto& part : s->parts) add_hull(out, b, part);
  }
}

// Draws particles as points. `radius` is that of a ball with the particle's volume. `surface` is 1 where the particle
// has faces, and `normal` is the sum of their normals.
VtpMesh soft_mesh(const SoftBodies& soft) {
  VtpMesh mesh;
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, volume{"J", 1, {}}, stress{"von_mises", 1, {}, false, "Pa"},
      radius{"radius", 1, {}, false, "m"}, surface{"surface", 1, {}, true}, normal{"normal", 3, {}},
      body{"soft_body", 1, {}, true};
  for (std::size_t i = 0; i < soft.models().size(); ++i) {
    const SoftModel& m = soft.models()[i];
    const SoftState& s = soft.states()[i];
    const std::size_t first = mesh.points.size();
    for (std::size_t p = 0; p < s.x.size(); ++p) {
      const double j = s.f[p].determinant();
      mesh.verts.push_back(static_cast<int>(mesh.points.size()));
      mesh.points.push_back(s.x[p]);
      velocity.values.insert(velocity.values.end(), {s.v[p].x(), s.v[p].y(), s.v[p].z()});
      volume.values.push_back(j), stress.values.push_back(von_mises(m, s.f[p]));
      radius.values.push_back(std::cbrt(0.75 / std::numbers::pi * j * m.mass[p] / m.material.density));
      surface.values.push_back(0.0), body.values.push_back(static_cast<double>(i));
    }
    normal.values.resize(3 * mesh.points.size(), 0.0);
    for (const SoftSurface& f : m.surface) {
      surface.values[first + f.particle] = 1.0;
      const Vec3 n = s.surface_normal(f).normalized();  // summed at an edge
      for (int d = 0; d < 3; ++d) normal.values[3 * (first + f.particle) + d] += n[d];
    }
  }
  mesh.point_data = {velocity, volume, stress, radius, surface, normal, body};
  return mesh;
}

// Adds places at rest and parameters to the points that a body has just got: none where it was no piece of a shell.
void add_places(BodyMesh& out, const DrawnMesh* piece) {
  const std::size_t first = out.uv.values.size() / 2;
  for (std::size_t i = first; i < out.mesh.points.size(); ++i) {
    const Vec3 u = piece ? Vec3(out.mesh.points[i] - piece->rest[i - first]) : Vec3(Vec3::Zero());
    const Vec2 p = piece ? piece->uv[i - first] : Vec2(Vec2::Zero());
    out.displacement.values.insert(out.displacement.values.end(), {u.x(), u.y(), u.z()});
    out.uv.values.insert(out.uv.values.end(), {p.x(), p.y()});
  }
}

// Adds the motion of a body to the points and cells that it has just got.
void add_motion(BodyMesh& out, const RigidBody& b, std::size_t number, const FrameFields& fields) {
  const Vec3 w = b.is_static ? Vec3(Vec3::Zero()) : b.angular_velocity();
  for (std::size_t i = out.velocity.values.size() / 3; i < out.mesh.points.size(); ++i) {
    const Vec3 v = fields.velocity(number, out.mesh.points[i]);
    out.velocity.values.insert(out.velocity.values.end(), {v.x(), v.y(), v.z()});
  }
  while (out.mass.values.size() < out.mesh.polygons.size()) {
    out.spin.values.insert(out.spin.values.end(), {w.x(), w.y(), w.z()});
    out.mass.values.push_back(b.mass);
  }
}

// Begins each entry of frames.pvd that is of this time.
std::string moment(double time) { return fmt::format("<DataSet timestep=\"{:.9g}\" ", time); }

std::string collection(const std::string& entries) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
         "<Collection>\n" +
         entries + "</Collection>\n</VTKFile>\n";
}

}  // namespace

bool FrameWriter::has_frame_of(double time) const { return index_.find(moment(time)) != std::string::npos; }

FrameWriter::FrameWriter(std::string folder) : folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_ + "/frames", error);
  if (error) throw Error(Exit::kBadInput, "bad_output", fmt::format("{}/frames: {}", folder_, error.message()));
}

void FrameWriter::write(double time, const std::vector<ShellView>& shells,
                        const std::vector<std::vector<BodyId>>& pieces, const SoftBodies& soft,
                        const std::vector<RigidBody>& bodies, BodyId first_shard, const FrameFields& fields) {
  if (has_frame_of(time)) --count_;
  for (std::string* index : {&index_, &thick_index_})
    if (const std::size_t same = index->find(moment(time)); same != std::string::npos) index->resize(same);
  const auto list = [&](std::string& index, int part, const char* kind) {
    index += fmt::format("{}part=\"{}\" name=\"{}\" file=\"frames/{}_{:06d}.vtp\"/>\n", moment(time), part, kind, kind,
                         count_);
  };
  const auto write = [&](const char* kind, VtpMesh mesh) {
    mesh.time = time;
    write_vtp(fmt::format("{}/frames/{}_{:06d}.vtp", folder_, kind, count_), mesh);
  };
  const auto put = [&](int part, const char* kind, VtpMesh mesh) {
    write(kind, std::move(mesh)), list(index_, part, kind);
  };
  const ContactOverTime none;
  if (!shells.empty()) {
    VtpMesh shell, cracks, thick;
    for (std::size_t k = 0; k < shells.size(); ++k) {
      const ContactOverTime& contact = k < fields.contact.size() ? fields.contact[k] : none;
      ShellMeshes meshes = shell_mesh(*shells[k].model, *shells[k].state, pieces[k], fields, contact);
      append(shell, std::move(meshes.middle), static_cast<int>(k));
      if (fields.thick) append(thick, std::move(meshes.solid), static_cast<int>(k));
      shell.shell_names.push_back(shells[k].model->name);
      shell.shell_areas.push_back(surface_area(*shells[k].model, *shells[k].state).second);
      append(cracks, crack_mesh(*shells[k].model, *shells[k].state), static_cast<int>(k));
    }
    cracks.shell_names = thick.shell_names = shell.shell_names;
    if (fields.thick) write("thick", std::move(thick)), list(thick_index_, 0, "thick");
    put(0, "shell", std::move(shell)), put(1, "cracks", std::move(cracks));
  }
  BodyMesh out;
  for (std::size_t number = 0; number < bodies.size(); ++number) {
    const RigidBody& b = bodies[number];
    const auto it = drawn_.find(b.id);
    out.id = it != drawn_.end() ? piece_.at(b.id) : b.id, out.kind_now = kind_of(b, first_shard);
    if (it != drawn_.end())
      add_mesh(out, b, it->second);
    else
      add_body(out, b);
    if (!drawn_.empty()) add_places(out, it != drawn_.end() ? &it->second : nullptr);
    if (fields.set.has(FieldSet::kBodyMotion)) add_motion(out, b, number, fields);
  }
  out.mesh.cell_data = {out.body, out.kind};
  if (!drawn_.empty()) out.mesh.point_data = {out.displacement, out.uv};
  if (fields.set.has(FieldSet::kBodyMotion))
    out.mesh.point_data.push_back(out.velocity),
        out.mesh.cell_data.insert(out.mesh.cell_data.end(), {out.spin, out.mass});
  put(2, "bodies", std::move(out.mesh));
  if (!soft.empty()) put(3, "soft", soft_mesh(soft));
  if (fields.thick) list(thick_index_, 1, "bodies");
  if (fields.thick && !soft.empty()) list(thick_index_, 2, "soft");
  ++count_;
  write_atomically(folder_ + "/frames.pvd", collection(index_));
  if (fields.thick) write_atomically(folder_ + "/thick.pvd", collection(thick_index_));
}

}  // namespace sunder::shell
