#include "shell/io/build_seams.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>

#include <Eigen/Geometry>

#include "shell/fracture/constants.h"
#include "shell/geometry/edges.h"
#include "shell/geometry/trim_seams.h"
#include "shell/io/build_shell.h"
#include "shell/io/mesh_parts.h"
#include "shell/io/part_names.h"
#include "shell/solver/joining/stitching.h"

namespace sunder::shell {
namespace {

constexpr double kLoose = 1e-12;         // a smaller weight of a control point counts for nothing
constexpr double kSeamTolerance = 1e-6;  // share of the largest shell's size

// EdgeBits of edges that exist over their whole length: trims leave both rows of control points and every place.
int whole_edges(const ShellModel& m) {
  constexpr int kPlaces = 64;
  int whole = 0;
  for (const int edge : kEdges) {
    bool all = true;
    for (const int depth : {0, 1})
      for (const int point : edge_row(m.patch, edge, depth)) all = all && !m.trim.drops(m.tables.slot(point));
    for (int k = 0; k <= kPlaces && all && !m.trim.empty(); ++k)
      all = m.trim.loops.contains(edge_point(m.patch, edge, static_cast<double>(k) / kPlaces));
    if (all) whole |= edge;
  }
  return whole;
}

// Gives seams the strength of their rule.
void give_strengths(const scene::LoadedScene& scene, const std::vector<std::string>& names, Stitches& found) {
  const proto::Seams& m = scene.message.seams();
  for (int i = 0; i < m.rules_size(); ++i) {
    const proto::SeamRule& rule = m.rules(i);
    if (!rule.has_strength()) continue;
    for (Seam& seam : found.seams) {
      if (std::minmax(names[seam.first], names[seam.second]) != std::minmax(rule.first(), rule.second())) continue;
      scene.check(!seam.trimmed(), fmt::format("seams.rules[{}].strength", i),
                  "is given, and '{}' and '{}' are joined along a trim, which holds as a whole; leave it out",
                  rule.first(), rule.second());
      seam.strength = rule.strength();
    }
  }
}

// Slots of the control points of one of the shells of a seam of whole edges that the seam joins.
std::vector<int> joined_slots(const Seam& seam, bool first, const ShellModel& m) {
  std::vector<int> out;
  for (const int depth : {0, 1})
    for (const int i : edge_row(m.patch, first ? seam.first_edge : seam.second_edge, depth))
      out.push_back(m.tables.slot(i));
  return out;
}

// A support with a release holds no control point of a seam of whole edges: which of them depend on others was settled
// with the support in place. Ties along trims take the present supports.
void check_releases(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const Stitches& found,
                    const RunSetup& r) {
  for (const Seam& seam : found.seams)
    for (const bool first : {true, false}) {
      const int k = first ? seam.first : seam.second;
      const ShellModel& m = r.shells[k].model;
      if (m.releases.empty() || seam.trimmed()) continue;
      const std::vector<int> joined = joined_slots(seam, first, m);
      for (const SupportStage& stage : m.releases) {
        const auto released = [&](int slot) { return m.held[slot] && !stage.held[slot]; };
        scene.check(
            std::none_of(joined.begin(), joined.end(), released), fmt::format("shells[{}].supports", parts[k].shell),
            "are released at {} s, and hold control points of the seam between '{}' and '{}'; hold a part off the "
            "seam, or leave until_s out",
            stage.from, r.shells[seam.first].model.name, r.shells[seam.second].model.name);
      }
    }
}

// What holds, ties or drives control points of a shell at a time, by axis and slot.
std::array<std::vector<char>, 3> bound_at(const ShellModel& m, double time) {
  const Constraints* now = &m.constraints;
  for (const SupportStage& stage : m.releases)
    if (stage.from <= time) now = &stage.constraints;
  std::array<std::vector<char>, 3> bound;
  for (int d = 0; d < 3; ++d) {
    bound[d].assign(m.tables.component_stride, 0);
    const auto bind = [&](const std::vector<int>& slots) {
      for (const int slot : slots) bound[d][slot] = 1;
    };
    bind(now->held[d]);
    for (const std::vector<int>& together : now->tied[d]) bind(together);
    for (const Constraints::Driven& driven : now->driven) bind(driven.slots[d]);
  }
  return bound;
}

// Whether a support of an edge across may bind it: it is at the end of an edge, or in the row beside.
bool is_at_end(const Patch& patch, int point) {
  return std::any_of(std::begin(kEdges), std::end(kEdges), [&](int edge) {
    const std::vector<int> row = edge_row(patch, edge, 0);
    const auto at = std::find(row.begin(), row.end(), point) - row.begin(), size = std::ssize(row);
    return at < size && (at < 2 || at + 2 >= size);
  });
}

// A dependent control point is where its independent ones are. A support that binds it along an axis must bind them
// too, or it would do nothing. At its ends a seam may meet a support of one shell.
void check_axes(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const Stitches& found,
                const RunSetup& r) {
  std::set<double> times{0.0};
  for (const ShellSetup& s : r.shells)
    for (const SupportStage& stage : s.model.releases) times.insert(stage.from);
  for (const double time : times) {
    std::vector<std::array<std::vector<char>, 3>> bound;
    for (const ShellSetup& s : r.shells) bound.push_back(bound_at(s.model, time));
    const auto is_bound = [&](const PatchPoint& p, int d) {
      return bound[p.patch][d][r.shells[p.patch].model.tables.slot(p.point)] != 0;
    };
    const auto other = [](const Dependence& of) {
      for (const auto& [on, weight] : of.on)
        if (on.patch != of.point.patch) return on.patch;
      return of.point.patch;
    };
    for (const Dependence& point : found.points)
      for (int d = 0; d < 3 && !is_at_end(r.shells[point.point.patch].model.patch, point.point.point); ++d)
        for (const auto& [on, weight] : point.on)
          scene.check(!is_bound(point.point, d) || std::abs(weight) <= kLoose || is_bound(on, d),
                      fmt::format("shells[{}].supports", parts[point.point.patch].shell),
                      "at {} s one binds control points of a seam with shell '{}' along the axis {}, where they depend "
                      "on others that are free; "
                      "give it to the edges of both and join them by a rule of kind HINGE, or hold all axes there",
                      time, r.shells[other(point)].model.name, "XYZ"[d]);
  }
}

// A rule that joins two shells requires that they meet. Throws Error at the rule otherwise.
void check_rules(const scene::LoadedScene& scene, const Stitches& found, const std::vector<std::string>& names,
                 double tolerance) {
  const proto::Seams& m = scene.message.seams();
  for (int i = 0; i < m.rules_size(); ++i) {
    const proto::SeamRule& rule = m.rules(i);
    const bool meet = std::any_of(found.seams.begin(), found.seams.end(), [&](const Seam& s) {
      return std::minmax(names[s.first], names[s.second]) == std::minmax(rule.first(), rule.second());
    });
    scene.check(meet || rule.kind() == proto::SeamRule::OPEN, fmt::format("seams.rules[{}]", i),
                "fastens '{}' and '{}', which have no whole edge in common, nor borders along a trim, to {:.3g} m; "
                "move them together, or leave it "
                "out",
                rule.first(), rule.second(), tolerance);
  }
}

// Largest angle between the surfaces of a seam of whole edges [rad], its ends left out: they may be poles.
double angle_inside(const Seam& seam, const Patch& first, const Patch& second) {
  constexpr int kPlaces = 10;
  const auto inward = [](const Patch& p, int edge, double t) {
    const SurfacePoint x = p.evaluate(edge_point(p, edge, t));
    const Vec3 along = (edge < kVMin ? x.v : x.u).normalized(), across = edge < kVMin ? x.u : x.v;
    const Vec3 in = (across - across.dot(along) * along).normalized();
    return edge == kUMax || edge == kVMax ? Vec3(-in) : in;
  };
  double most = 0.0;
  for (int k = 1; k < kPlaces; ++k) {
    const double t = static_cast<double>(k) / kPlaces;
    const Vec3 a = inward(first, seam.first_edge, t), b = inward(second, seam.second_edge, seam.reversed ? 1.0 - t : t);
    most = std::max(most, std::atan2(a.cross(b).norm(), -a.dot(b)));
  }
  return most;
}

// Stitches of whole edges; `whole` loses those that are to be tied. Faces of a file may be smooth where their control
// points are not in line, as beside a pole. Where their edges do not fit otherwise, as in degree, all of the file's are
// tied.
Stitches stitched(const std::vector<ScenePart>& parts, const std::vector<const Patch*>& patches,
                  const std::vector<std::string>& names, double tolerance, const std::vector<std::vector<Join>>& join,
                  const std::function<bool(const PatchPoint&)>& held, std::vector<int>& whole) {
  const auto of_file = [&](int part) { return parts[part].message.has_cad() || parts[part].message.has_mesh(); };
  for (;;) {
    bool again = false;
    Stitches found;
    try {
      found = find_stitches(patches, names, tolerance, join, held, whole);
    } catch (const Error&) {
      for (std::size_t k = 0; k < parts.size(); ++k)
        if (of_file(static_cast<int>(k)) && whole[k] != 0) whole[k] = 0, again = true;
      if (!again) throw;
      continue;
    }
    for (const Seam& s : found.seams) {
      if (s.smooth || s.join != Join::kClamped || !of_file(s.first) || !of_file(s.second)) continue;
      if (angle_inside(s, *patches[s.first], *patches[s.second]) <= kSmoothAngle)
        whole[s.first] &= ~s.first_edge, whole[s.second] &= ~s.second_edge, again = true;
    }
    if (!again) return found;
  }
}

// Charts of a mesh meet where it says, but for whole edges that are stitched already. `join` is open for them
// afterwards.
void add_mesh_seams(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                    const std::vector<BorderedPatch>& bordered, std::vector<std::vector<Join>>& join, Stitches& found) {
  std::vector<KnownBorder> borders = mesh_borders(scene, parts, files);
  std::erase_if(borders, [&](const KnownBorder& b) {
    return std::any_of(found.seams.begin(), found.seams.end(), [&](const Seam& s) {
      return !s.trimmed() && std::minmax(s.first, s.second) == std::minmax(b.first, b.second);
    });
  });
  for (Seam& seam : known_seams(bordered, borders, join)) found.seams.push_back(std::move(seam));
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (parts[i].message.has_mesh() && parts[i].shell == parts[k].shell) join[i][k] = Join::kOpen;
}

}  // namespace

Stitches make_stitches(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, CadFiles& files,
                       const RunSetup& r) {
  const proto::Seams& m = scene.message.seams();
  std::vector<const Patch*> patches;
  std::vector<std::string> names;
  std::vector<const ShellModel*> models;
  double largest = 0.0;
  std::vector<int> whole;  // EdgeBits of the edges that trims leave
  for (std::size_t i = 0; i < r.shells.size(); ++i) {
    const ShellSetup& s = r.shells[i];
    patches.push_back(&s.model.patch), names.push_back(s.model.name), models.push_back(&s.model);
    Eigen::AlignedBox3d box;
    for (const Vec3& x : s.model.patch.control_points) box.extend(x);
    largest = std::max(largest, box.diagonal().norm());
    whole.push_back(whole_edges(s.model));
    scene.check(
        s.transfer.kind == Transfer::kDirect, "transfer",
        "cannot go with seams: the grid gives each control point a velocity of its own, and those that a seam ties "
        "move together; leave one of them out");
  }
  std::vector<std::vector<Join>> join(patches.size(), std::vector<Join>(patches.size(), Join::kClamped));
  const std::vector<std::vector<char>> meet = may_meet(scene, parts, files);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (!meet[i][k]) join[i][k] = Join::kOpen;
  for (int n = 0; n < m.rules_size(); ++n) {
    const std::string field = fmt::format("seams.rules[{}]", n);
    const int i = shell_named(scene, parts, field + ".first", m.rules(n).first()),
              k = shell_named(scene, parts, field + ".second", m.rules(n).second());
    join[i][k] = join[k][i] = static_cast<Join>(m.rules(n).kind());
  }
  double tolerance = m.has_tolerance_m() ? m.tolerance_m() : kSeamTolerance * largest;
  if (!m.has_tolerance_m())
    for (const ScenePart& part : parts) tolerance = std::max(tolerance, part.apart);
  Stitches found;
  try {
    const auto held = [&](const PatchPoint& p) {
      return models[p.patch]->held[models[p.patch]->tables.slot(p.point)] != 0;
    };
    found = stitched(parts, patches, names, tolerance, join, held, whole);
    std::vector<Patch> untrimmed;
    for (const ScenePart& part : parts)
      untrimmed.push_back(whole_patch(scene, part.message, fmt::format("shells[{}]", part.shell), files, part.part));
    std::vector<BorderedPatch> bordered;
    for (std::size_t i = 0; i < patches.size(); ++i)
      bordered.push_back({&untrimmed[i], &models[i]->trim.loops, whole[i], names[i]});
    add_mesh_seams(scene, parts, files, bordered, join, found);
    for (Seam& seam : find_trim_seams(bordered, tolerance, join)) found.seams.push_back(std::move(seam));
    Stitching(found, models);  // throws where supports do not fit the seams
  } catch (const Error& e) {
    scene.fail("seams", e.what());
  }
  check_rules(scene, found, names, tolerance);
  give_strengths(scene, names, found);
  check_axes(scene, parts, found, r);
  check_releases(scene, parts, found, r);
  for (const Seam& seam : found.seams)
    for (const auto& [own, other] : {std::pair{seam.first, seam.second}, std::pair{seam.second, seam.first}})
      scene.check(r.shells[own].equilibrium == 0.0 || r.shells[other].equilibrium > 0.0,
                  fmt::format("shells[{}].equilibrium", parts[own].shell),
                  "is given, and shell '{}', which a seam joins to '{}', has none; give it to both", names[other],
                  names[own]);
  return found;
}

std::vector<std::vector<int>> joined_groups(const RunSetup& setup) {
  std::vector<int> lowest(setup.shells.size());
  std::iota(lowest.begin(), lowest.end(), 0);
  const auto of = [&](int k) {
    while (lowest[k] != k) k = lowest[k];
    return k;
  };
  for (const Seam& seam : setup.stitches.seams) {
    const int a = of(seam.first), b = of(seam.second);
    lowest[std::max(a, b)] = std::min(a, b);
  }
  std::vector<std::vector<int>> out;
  std::vector<int> place(lowest.size(), -1);
  for (int k = 0; k < static_cast<int>(lowest.size()); ++k) {
    int& at = place[of(k)];
    if (at < 0) at = static_cast<int>(out.size()), out.emplace_back();
    out[at].push_back(k);
  }
  return out;
}

}  // namespace sunder::shell
