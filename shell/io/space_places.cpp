#include "shell/io/space_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "shell/geometry/plane_curves.h"
#include "shell/meshes/surface_fit.h"

namespace sunder::shell {
namespace {

constexpr double kFarFromSurface = 1.0;  // elements: corners of a line are nearer
constexpr double kLineSample = 0.25;     // spacings between places of a line
constexpr double kMostSamplesOfLine = 1e5;
constexpr double kLargestStride = 4.0;  // how much further than the line its place on the surface may go
constexpr double kNearPlaces = 0.05;    // spacings: places of a cut are further apart
constexpr int kHalvings = 40;           // to find where a line passes to another shell

// A place on one of the shells.
struct LinePlace {
  int shell = -1;
  Vec2 at = Vec2::Zero();
  Vec3 x = Vec3::Zero();
  double away = std::numeric_limits<double>::infinity();  // [m]
};

// Nearest places on shells, each within its trims.
class SurfaceSearch {
 public:
  SurfaceSearch(const RunSetup& setup, const std::vector<int>& shells) : setup_(setup), shells_(shells) {
    for (const int k : shells) {
      const ShellModel& m = model(k);
      auto& own = known_.emplace_back();
      for (int q = 0; q < m.tables.blocks(); ++q)
        for (int e = 0; e < m.tables.spans_u; ++e)
          if (const GaussPoint g = gauss_point(m.patch, m.tables, q, e); g.weight > 0.0)
            own.push_back({g.parameter, m.patch.evaluate(g.parameter).x});
    }
  }

  const ShellModel& model(int shell) const { return setup_.shells[shell].model; }

  LinePlace nearest(const Vec3& x) const {
    std::vector<std::pair<double, std::size_t>> first;  // of each shell: distance of a Gauss point, its number
    double least = std::numeric_limits<double>::infinity();
    for (const auto& own : known_) {
      std::pair<double, std::size_t> best{std::numeric_limits<double>::infinity(), 0};
      for (std::size_t i = 0; i < own.size(); ++i)
        if (const double d = (own[i].second - x).squaredNorm(); d < best.first) best = {d, i};
      best.first = std::sqrt(best.first), least = std::min(least, best.first), first.push_back(best);
    }
    LinePlace out;
    for (std::size_t k = 0; k < shells_.size(); ++k) {
      const ShellModel& m = model(shells_[k]);
      if (first[k].first > least + 2.0 * m.longest_element) continue;
      const LinePlace place = from(shells_[k], x, known_[k][first[k].second].first);
      if (place.away < out.away) out = place;
    }
    return out;
  }

  // The place of one shell that is nearest, from a place near it.
  LinePlace from(int shell, const Vec3& x, const Vec2& start) const {
    const ShellModel& m = model(shell);
    LinePlace out{shell, nearest_place(m.patch, x, start)};
    if (!m.trim.empty()) out.at = m.trim.loops.moved_inside(out.at, 0.0);
    out.x = m.patch.evaluate(out.at).x, out.away = (out.x - x).norm();
    return out;
  }

 private:
  const RunSetup& setup_;
  std::vector<int> shells_;
  std::vector<std::vector<std::pair<Vec2, Vec3>>> known_;  // Gauss points of each shell
};

// A stretch of a cut on one shell, and the shares of the cut's length at its ends.
struct LineRun {
  int shell = 0;
  std::vector<Vec2> points;
  double begin = 0.0, end = 1.0;
};

std::string said(const Vec3& x) { return fmt::format("({:.4g}, {:.4g}, {:.4g}) m", x.x(), x.y(), x.z()); }

class LineOnSurface {
 public:
  LineOnSurface(const scene::LoadedScene& scene, const std::string& field, const proto::CutLine& line,
                const SurfaceSearch& search, double spacing)
      : search_(search) {
    double length = 0.0;
    for (int i = 1; i < line.points_size(); ++i)
      length += (scene::to_vec(line.points(i)) - scene::to_vec(line.points(i - 1))).norm();
    scene.check(length <= kMostSamplesOfLine * kLineSample * spacing, field,
                "is {:.3g} m long, {:.3g} spacings of the shell; at most {:.0g}: give points in metres", length,
                length / spacing, kMostSamplesOfLine * kLineSample);
    for (int i = 0; i < line.points_size(); ++i) {
      const Vec3 to = scene::to_vec(line.points(i)), from = i > 0 ? way_.back() : to;
      const int pieces =
          i > 0 ? std::max(1, static_cast<int>(std::ceil((to - from).norm() / (kLineSample * spacing)))) : 1;
      for (int k = 1; k <= pieces; ++k) {
        way_.push_back(k == pieces ? to : Vec3(from + k / static_cast<double>(pieces) * (to - from)));
        places_.push_back(search.nearest(way_.back()));
        if (places_.size() > 1) check_step(scene, field, spacing);
      }
      const double reach = kFarFromSurface * search.model(places_.back().shell).longest_element;
      scene.check(places_.back().away <= reach, fmt::format("{}.points[{}]", field, i),
                  "is {:.3g} m from the surface, more than an element, {:.3g} m; the nearest place is {}",
                  places_.back().away, reach, said(places_.back().x));
    }
  }

  std::vector<LineRun> runs() const {
    std::vector<double> length{0.0};
    for (std::size_t k = 1; k < places_.size(); ++k)
      length.push_back(length.back() + (places_[k].x - places_[k - 1].x).norm());
    const double whole = std::max(length.back(), 1e-300);
    std::vector<LineRun> out;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      if (k == 0) {
        out.push_back({places_[0].shell, {}, 0.0, 1.0});
      } else if (places_[k].shell != places_[k - 1].shell) {
        const auto [leaves, enters] = passage(k);
        out.back().points.push_back(leaves.at);
        out.back().end = (length[k - 1] + (leaves.x - places_[k - 1].x).norm()) / whole;
        out.push_back({places_[k].shell, {enters.at}, out.back().end, 1.0});
      }
      out.back().points.push_back(places_[k].at);
    }
    return out;
  }

 private:
  void check_step(const scene::LoadedScene& scene, const std::string& field, double spacing) const {
    const LinePlace &a = places_[places_.size() - 2], &b = places_.back();
    const double step = (way_.back() - way_[way_.size() - 2]).norm();
    scene.check((b.x - a.x).norm() <= kLargestStride * step + 2.0 * kLineSample * spacing, field,
                "passes from {} to {} at once, since no surface is near the line between; give it more points, along "
                "the surface",
                said(a.x), said(b.x));
  }

  // Places of both shells where the line passes from one to the other, between places k - 1 and k.
  std::pair<LinePlace, LinePlace> passage(std::size_t k) const {
    Vec3 low = way_[k - 1], high = way_[k];
    for (int i = 0; i < kHalvings; ++i) {
      const Vec3 x = 0.5 * (low + high);
      const LinePlace a = search_.from(places_[k - 1].shell, x, places_[k - 1].at),
                      b = search_.from(places_[k].shell, x, places_[k].at);
      (a.away <= b.away ? low : high) = x;
    }
    return {search_.from(places_[k - 1].shell, low, places_[k - 1].at),
            search_.from(places_[k].shell, high, places_[k].at)};
  }

  const SurfaceSearch& search_;
  std::vector<Vec3> way_;  // places of the line
  std::vector<LinePlace> places_;
};

// Leaves out places that are too near to each other; both ends stay.
void spread(std::vector<Vec2>& points, double least) {
  std::vector<Vec2> out{points.front()};
  for (std::size_t k = 1; k < points.size(); ++k)
    if ((points[k] - out.back()).norm() > least) out.push_back(points[k]);
  if (out.back() != points.back()) {
    if (out.size() > 1) out.pop_back();
    out.push_back(points.back());
  }
  points = std::move(out);
}

// Where two stretches of a cut meet on one shell.
std::optional<Vec2> where_they_meet(const LineRun& one, const LineRun& other) {
  for (std::size_t i = 1; i < one.points.size() && one.shell == other.shell; ++i)
    for (std::size_t k = 1; k < other.points.size(); ++k)
      if (const auto at = segments_touch(one.points[i - 1], one.points[i], other.points[k - 1], other.points[k], 0.0))
        return at;
  return {};
}

}  // namespace

void check_boxes(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, const RunSetup& r) {
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& shell = scene.message.shells(i);
    Eigen::AlignedBox3d around;
    double longest = 0.0;
    bool all_held = true, any_box = false;
    std::vector<const ShellModel*> own;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (parts[k].shell != i) continue;
      own.push_back(&r.shells[k].model);
      all_held = all_held && own.back()->wholly_held(), longest = std::max(longest, own.back()->longest_element);
    }
    for (int s = 0; s < shell.supports_size(); ++s)
      for (int b = 0; b < shell.supports(s).boxes_size(); ++b) {
        any_box = true;
        const std::string name = fmt::format("support_{}_box_{}", s, b);
        const bool holds = std::any_of(own.begin(), own.end(), [&](const ShellModel* m) {
          const auto& held = m->constraints.parts;
          return std::any_of(held.begin(), held.end(), [&](const auto& part) { return part.name == name; });
        });
        if (holds) continue;
        for (const ShellModel* m : own)
          for (int q = 0; q < m->tables.blocks(); ++q)
            for (int e = 0; e < m->tables.spans_u; ++e)
              if (const GaussPoint g = gauss_point(m->patch, m->tables, q, e); g.weight > 0.0)
                around.extend(m->patch.evaluate(g.parameter).x);
        scene.fail(fmt::format("shells[{}].supports[{}].boxes[{}]", i, s, b),
                   fmt::format("holds no control point of shell '{}', which reaches from {} to {}, in elements of up "
                               "to {:.3g} m; move it, or make it larger",
                               shell.name(), said(around.min()), said(around.max()), longest));
      }
    scene.check(!any_box || !all_held, fmt::format("shells[{}].supports", i),
                "hold every control point of shell '{}', so nothing of it would move; take smaller boxes",
                shell.name());
  }
}

bool steps_as_if_free(const RunSetup& setup, std::size_t shell) {
  const ShellSetup& own = setup.shells[shell];
  const auto& seams = setup.stitches.seams;
  const auto is_of = [&](const Seam& s) {
    return static_cast<std::size_t>(s.first) == shell || static_cast<std::size_t>(s.second) == shell;
  };
  return own.can_crack() || !own.model.releases.empty() ||
         (own.model.wholly_held() && std::any_of(seams.begin(), seams.end(), is_of));
}

void add_space_cuts(const scene::LoadedScene& scene, const std::vector<ScenePart>& parts, RunSetup& r) {
  for (int i = 0; i < scene.message.shells_size(); ++i) {
    const proto::Shell& shell = scene.message.shells(i);
    const auto& cuts = shell.cuts();
    if (std::none_of(cuts.begin(), cuts.end(), [](const proto::Cut& c) { return c.has_line(); })) continue;
    std::vector<int> own;
    double spacing = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (parts[k].shell == i)
        own.push_back(static_cast<int>(k)), spacing = std::min(spacing, r.shells[k].model.spacing);
    const SurfaceSearch search(r, own);
    for (int c = 0; c < cuts.size(); ++c) {
      if (!cuts[c].has_line()) continue;
      const std::string field = fmt::format("shells[{}].cuts[{}].line", i, c);
      const auto& given = cuts[c].line().points();
      std::vector<LineRun> runs = LineOnSurface(scene, field, cuts[c].line(), search, spacing).runs();
      const double from = cuts[c].time_s(), until = cuts[c].has_until_s() ? cuts[c].until_s() : from;
      const bool returns = scene::to_vec(given[0]) == scene::to_vec(given[given.size() - 1]);
      const bool closed = returns && until == from;
      if (closed && runs.size() > 1 && runs.front().shell == runs.back().shell) {
        runs.back().points.insert(runs.back().points.end(), runs.front().points.begin() + 1, runs.front().points.end());
        runs.erase(runs.begin());
      }
      for (LineRun& run : runs) {
        const ShellModel& m = r.shells[run.shell].model;
        spread(run.points, kNearPlaces * m.spacing);
        if ((run.points.back() - run.points.front()).norm() <= kNearPlaces * m.spacing && run.points.size() == 2)
          continue;  // a corner of a shell that the line touches
        run.points = thinned(run.points, kSag * m.spacing);
        if (closed && runs.size() == 1) run.points.back() = run.points.front();
        if (const auto hit = meets_itself(run.points, kNearPlaces * kNearPlaces * m.spacing))
          scene.fail(field, fmt::format("meets itself at {}; a cut neither crosses nor touches itself: give two cuts",
                                        said(m.patch.evaluate(hit->at).x)));
        for (const LineRun& other : runs) {
          if (&other == &run) break;
          if (const auto hit = where_they_meet(other, run); hit && !(returns && &run == &runs.back()))
            scene.fail(field, fmt::format("meets itself at {}; a cut neither crosses nor touches itself: give two cuts",
                                          said(m.patch.evaluate(*hit).x)));
        }
        std::vector<PrescribedCut> made =
            cut_along(m, run.points, from + run.begin * (until - from), from + run.end * (until - from));
        for (PrescribedCut& cut : made) cut.number = c;
        made.back().goes_on = &run != &runs.back() && until > from;
        std::move(made.begin(), made.end(), std::back_inserter(r.shells[run.shell].fracture.cuts));
      }
    }
  }
}

}  // namespace sunder::shell
