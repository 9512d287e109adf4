#include "shell/io/frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "coupler/core/error.h"
#include "shell/io/crack_lines.h"
#include "shell/io/frame_bodies.h"
#include "shell/io/probes.h"
#include "shell/io/thick_sheet.h"
#include "shell/io/vtp.h"
#include "shell/solver/cracking/crack_sides.h"

namespace sunder::shell {
namespace {

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

using Corners = TornTriangles::mapped_type::value_type;

std::array<int, 2> spans_of(const ShellModel& m, const Vec2& p) {
  return {m.patch.knots_u.span_of(p.x()), m.patch.knots_v.span_of(p.y())};
}

bool contains(const Corners& c, const Vec2& p) {
  for (int k = 0; k < 3; ++k)
    if (triangle_area(c.col(k), c.col((k + 1) % 3), p) < 0.0) return false;
  return true;
}

// Tests whether a point lies in a torn triangle. Those are tried whose centres are in its element or in one beside it:
// few triangles are wider.
bool lies_in(const TornTriangles& torn, const std::array<int, 2>& spans, const Vec2& p) {
  for (int i = spans[0] - 1; i <= spans[0] + 1; ++i)
    for (int j = spans[1] - 1; j <= spans[1] + 1; ++j)
      if (const auto it = torn.find({i, j}); it != torn.end())
        for (const Corners& c : it->second)
          if (contains(c, p)) return true;
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
  double area = 0.0;  // of the middle surface now, cracked or not [m^2]
};

// Area of all that is drawn [m^2]: elements that bear all over as the solver integrates them, and of the others the
// triangles. `element` is that of each triangle, row by row.
double area_now(const ShellModel& m, const ShellState& s, const VtpMesh& mesh, const std::vector<int>& element) {
  const RowTables& t = m.tables;
  std::vector<char> whole(static_cast<std::size_t>(t.spans_v) * t.spans_u);
  double area = 0.0;
  for (int k = 0; k < t.spans_v * t.spans_u; ++k) {
    const SurfaceArea one = surface_area(m, s, k / t.spans_u, k % t.spans_u);
    whole[k] = one.whole();
    if (whole[k]) area += one.now;
  }
  for (std::size_t i = 0; i < element.size(); ++i) {
    const std::vector<int>& c = mesh.polygons[i];
    const Vec3 a = mesh.points[c[0]];
    if (!whole[element[i]]) area += 0.5 * (mesh.points[c[1]] - a).cross(mesh.points[c[2]] - a).norm();
  }
  return area;
}

// Arrays that a frame has where some shell of it has such a thing: a thickness that varies, colours, fibres that damage
// may weaken.
struct Varying {
  bool thickness = false, colour = false, fibres = false;
};

// `ids` are those of the pieces of control points. `torn` are the triangles that are drawn no more; more are added.
ShellMeshes shell_mesh(const ShellModel& m, const ShellState& s, const std::vector<BodyId>& ids,
                       const FrameFields& fields, const ContactOverTime& contact, const Varying& varies,
                       TornTriangles& torn) {
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  std::vector<BodyId> id;
  for (const Piece& p : pieces) id.push_back(id_of(p, ids));
  VtpMesh mesh;
  VtpArray velocity{"velocity", 3, {}, false, "m/s"}, displacement{"displacement", 3, {}, false, "m"};
  VtpArray uv{"uv", 2, {}}, colour{"colour", 3, {}}, damage{"damage", 1, {}}, history{"c_his", 1, {}},
      through{"fibre_damage", 1, {}}, fragment{"fragment", 1, {}, true};
  CellFields asked(m, s, fields.set, contact);
  FieldSet thickness;
  if (fields.thick) thickness.add(FieldSet::kThickness);
  CellFields thick(m, s, thickness, contact);
  std::vector<double> at_rest;                                 // thickness of each triangle [m]
  std::vector<int> element;                                    // of each triangle
  VtpArray of_points{"thickness_at_rest", 1, {}, false, "m"};  // where it varies
  const auto corner = [&](const SideCorners::Corner& from) {
    const Vec2& p = from.at;
    const SidePoint c = side_point(m, s, p, from.near);
    mesh.points.push_back(c.x);
    velocity.values.insert(velocity.values.end(), {c.v.x(), c.v.y(), c.v.z()});
    displacement.values.insert(displacement.values.end(), {c.u.x(), c.u.y(), c.u.z()});
    const Vec2 share = drawn_parameter(m, p);
    uv.values.insert(uv.values.end(), {share.x(), share.y()});
    if (varies.colour) {
      const Vec3 rgb = drawn_colour(m, p);
      colour.values.insert(colour.values.end(), {rgb.x(), rgb.y(), rgb.z()});
    }
    if (varies.thickness) of_points.values.push_back(m.thickness_at(p));
    return static_cast<int>(mesh.points.size()) - 1;
  };
  const SideCorners corners = side_corners(m, s, t);
  std::map<int, int> shared;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    if (pieces[t.piece[i]].handed_off || pieces[t.piece[i]].control_points.empty()) continue;
    const auto& c = t.triangles[i];
    const Vec2 centre = (t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0;
    std::vector<int> polygon;
    for (int k = 0; k < 3; ++k) {
      const auto [it, fresh] = shared.try_emplace(corners.of[i][k], 0);
      if (fresh) it->second = corner(corners.corners[corners.of[i][k]]);
      polygon.push_back(it->second);
    }
    if (!m.laminated()) {
      const std::array<int, 2> spans = spans_of(m, centre);
      if (lies_in(torn, spans, centre)) continue;
      if (is_stretched(mesh, displacement, polygon, most_stretch(m, s, centre))) {
        torn[spans].emplace_back() << t.vertices[c[0]], t.vertices[c[1]], t.vertices[c[2]];
        continue;
      }
    }
    mesh.polygons.push_back(polygon);
    const int lane = m.patch.knots_u.span_of(centre.x()), f = m.patch.knots_v.span_of(centre.y());
    const std::size_t g = static_cast<std::size_t>(f) * m.tables.gauss * m.tables.gauss * m.tables.lanes + lane;
    damage.values.push_back(s.layers.c[g]), history.values.push_back(s.layers.c_his[g]),
        fragment.values.push_back(id[t.piece[i]]);
    if (varies.fibres) through.values.push_back(s.layers.fibre_damage(g));
    asked.add(centre), thick.add(centre), at_rest.push_back(m.thickness_at(centre));
    element.push_back(f * m.tables.spans_u + lane);
  }
  mesh.point_data = {velocity, displacement, uv};
  if (varies.colour) mesh.point_data.push_back(std::move(colour));
  if (varies.thickness) mesh.point_data.push_back(std::move(of_points));
  mesh.cell_data = {damage, history, fragment};
  if (varies.fibres) mesh.cell_data.push_back(std::move(through));
  for (VtpArray& a : asked.arrays()) mesh.cell_data.push_back(std::move(a));
  const double area = area_now(m, s, mesh, element);
  if (!fields.thick) return {std::move(mesh), {}, area};
  std::vector<double>& now = thick.arrays().front().values;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now[i] <= 0.0) now[i] = at_rest[i];  // nothing bears stress there
  VtpMesh solid = thick_sheet(mesh, now, at_rest);
  return {std::move(mesh), std::move(solid), area};
}

// Appends the mesh of shell number `shell`, with that number as a cell array.
void append(VtpMesh& all, VtpMesh one, int shell) {
  const int first = static_cast<int>(all.points.size());
  one.cell_data.push_back({"shell", 1, std::vector<double>(one.polygons.size(), shell), true});
  if (first == 0 && all.cell_data.empty()) {
    all = std::move(one);
    return;
  }
  all.points.insert(all.points.end(), one.points.begin(), one.points.end());
  for (std::vector<int>& corners : one.polygons) {
    for (int& i : corners) i += first;
    all.polygons.push_back(std::move(corners));
  }
  const auto join = [](std::vector<VtpArray>& to, const std::vector<VtpArray>& from) {
    for (std::size_t k = 0; k < to.size(); ++k)
      to[k].values.insert(to[k].values.end(), from[k].values.begin(), from[k].values.end());
  };
  join(all.point_data, one.point_data), join(all.cell_data, one.cell_data);
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
    VtpMesh shell, thick;
    std::vector<DrawnLine> lines;
    Varying varies;
    for (const ShellView& view : shells)
      varies.thickness |= view.model->varies(), varies.colour |= static_cast<bool>(view.model->colour),
          varies.fibres |= view.model->fibres.breaks();
    for (std::size_t k = 0; k < shells.size(); ++k) {
      const ContactOverTime& contact = k < fields.contact.size() ? fields.contact[k] : none;
      ShellMeshes meshes = shell_mesh(*shells[k].model, *shells[k].state, pieces[k], fields, contact, varies,
                                      torn_[shells[k].model->name]);
      append(shell, std::move(meshes.middle), static_cast<int>(k));
      shell.shell_areas.push_back(meshes.area);
      if (fields.thick) append(thick, std::move(meshes.solid), static_cast<int>(k));
      shell.shell_names.push_back(shells[k].model->name);
      const std::vector<DrawnLine> own = crack_lines(*shells[k].model, *shells[k].state, static_cast<int>(k));
      lines.insert(lines.end(), own.begin(), own.end());
    }
    thick.shell_names = shell.shell_names;
    if (fields.thick) write("thick", std::move(thick)), list(thick_index_, 0, "thick");
    VtpMesh cracks = line_mesh(lines);
    cracks.shell_names = shell.shell_names;
    put(0, "shell", std::move(shell)), put(1, "cracks", std::move(cracks));
  }
  put(2, "bodies", body_mesh(bodies, first_shard, drawn_, piece_, fields));
  if (!soft.empty()) put(3, "soft", soft_mesh(soft));
  std::vector<DrawnLine> carried;
  VtpArray carrier{"body", 1, {}, true};  // as in bodies
  for (const RigidBody& b : bodies)
    if (const auto it = drawn_.find(b.id); it != drawn_.end()) {
      add_carried(b.motion, it->second.lines, carried);
      carrier.values.resize(carried.size(), static_cast<double>(piece_.at(b.id)));
    }
  if (!carried.empty()) {
    VtpMesh cracks = line_mesh(carried);
    cracks.cell_data.push_back(std::move(carrier));
    put(4, "carried_cracks", std::move(cracks));
  }
  if (fields.thick) list(thick_index_, 1, "bodies");
  if (fields.thick && !soft.empty()) list(thick_index_, 2, "soft");
  ++count_;
  write_atomically(folder_ + "/frames.pvd", collection(index_));
  if (fields.thick) write_atomically(folder_ + "/thick.pvd", collection(thick_index_));
}

}  // namespace sunder::shell
