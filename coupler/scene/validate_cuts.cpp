// Checks prescribed cuts and trim loops of shells.
#include <cmath>

#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

void all_finite(const LoadedScene& s, const std::string& f, const auto& points) {
  for (int k = 0; k < points.size(); ++k) finite(s, fmt::format("{}.points[{}]", f, k), points[k]);
}

void circle(const LoadedScene& s, const std::string& f, const proto::CutCircle& m) {
  s.check(m.has_center(), f + ".center", "is missing; give u and v");
  finite(s, f + ".center", m.center());
  positive(s, f + ".radius_m", m.has_radius_m(), m.radius_m(), "m");
}

// `line`: what the points could be in place of the curve.
void curve(const LoadedScene& s, const std::string& f, const proto::CutCurve& c, const char* line) {
  const int degree = c.has_degree() ? c.degree() : 3, least = c.closed() ? 3 : degree + 1, count = c.points_size();
  s.check(degree >= 2 && degree <= 5, f + ".degree", "is {}; 2 to 5, or give the {} itself", degree, line);
  s.check(count >= least, f + ".points", "has {} points; {} of degree {} has at least {}", count,
          c.closed() ? "a closed curve" : "a curve", degree, least);
  all_finite(s, f, c.points());
  s.check(!c.closed() || c.points(0).u() != c.points(count - 1).u() || c.points(0).v() != c.points(count - 1).v(),
          fmt::format("{}.points[{}]", f, count - 1),
          "is the first point again, but a closed curve goes back to that by itself; leave the last one out");
}

void space_line(const LoadedScene& s, const std::string& f, const proto::CutLine& m) {
  s.check(m.points_size() >= 2, f + ".points", "has {} of them; a line has two or more", m.points_size());
  for (int k = 0; k < m.points_size(); ++k) {
    const std::string own = fmt::format("{}.points[{}]", f, k);
    finite(s, own, m.points(k));
    s.check(k == 0 || to_vec(m.points(k)) != to_vec(m.points(k - 1)), own,
            "is where the point before it is; leave one of them out");
  }
}

void cut(const LoadedScene& s, const std::string& g, const proto::Cut& m) {
  const bool curved = m.shape_case() != proto::Cut::SHAPE_NOT_SET;
  s.check(!curved || m.points_size() == 0, g + ".points", "are given, and so is a curve; give one of them");
  s.check(curved || m.points_size() >= 2, g + ".points",
          "has {} points; a cut has at least two, or is a circle, curve, spiral or line", m.points_size());
  not_negative(s, g + ".time_s", true, m.time_s());
  const auto& f = s.message.fracture();
  const double last =
      f.has_latest_freeze_s() ? std::min(f.latest_freeze_s(), s.message.end_time_s()) : s.message.end_time_s();
  const char* limit = last < s.message.end_time_s() ? "fracture.latest_freeze_s" : "end_time_s";
  s.check(m.time_s() < last, g + ".time_s",
          "is {0} s, and the shell is solved until {1} s at the latest: the cut would never be made; give time_s below "
          "{1} s, or a later {2}",
          m.time_s(), last, limit);
  if (m.has_until_s()) {
    s.check(std::isfinite(m.until_s()) && m.until_s() > m.time_s(), g + ".until_s",
            "is {} s, and the cut begins at {} s; give a later time, or leave it out to cut at once", m.until_s(),
            m.time_s());
    s.check(m.until_s() < last, g + ".until_s",
            "is {0} s, and the shell is solved until {1} s at the latest: the cut would not become whole; give until_s "
            "below {1} s, or a later {2}",
            m.until_s(), last, limit);
  }
  all_finite(s, g, m.points());
  if (m.has_circle()) circle(s, g + ".circle", m.circle());
  if (m.has_curve()) curve(s, g + ".curve", m.curve(), "cut's points");
  if (m.has_line()) space_line(s, g + ".line", m.line());
  if (m.has_spiral()) {
    const auto& c = m.spiral();
    const std::string f = g + ".spiral";
    s.check(c.has_center(), f + ".center", "is missing; give u and v");
    finite(s, f + ".center", c.center());
    not_negative(s, f + ".inner_radius_m", true, c.inner_radius_m());
    positive(s, f + ".outer_radius_m", c.has_outer_radius_m(), c.outer_radius_m(), "m");
    s.check(c.outer_radius_m() > c.inner_radius_m(), f + ".outer_radius_m",
            "is {} m; must be above inner_radius_m, {} m", c.outer_radius_m(), c.inner_radius_m());
    positive(s, f + ".turns", c.has_turns(), c.turns(), "-");
  }
}

void trim(const LoadedScene& s, const std::string& f, const proto::Trim& m) {
  const bool curved = m.shape_case() != proto::Trim::SHAPE_NOT_SET;
  s.check(!curved || m.points_size() == 0, f + ".points", "are given, and so is a curve; give one of them");
  s.check(curved || m.points_size() > 0, f, "has no shape; give points, or circle or curve {{...}}");
  all_finite(s, f, m.points());
  if (m.has_circle()) circle(s, f + ".circle", m.circle());
  if (!m.has_curve()) return;
  curve(s, f + ".curve", m.curve(), "loop's points");
  s.check(m.curve().closed(), f + ".curve.closed", "is false, and a loop is closed; give closed: true");
}

}  // namespace

void validate_cuts(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  for (int i = 0; i < shell.cuts_size(); ++i) cut(s, fmt::format("{}.cuts[{}]", f, i), shell.cuts(i));
  if (shell.trims_size() == 0) return;
  for (int i = 0; i < shell.trims_size(); ++i) trim(s, fmt::format("{}.trims[{}]", f, i), shell.trims(i));
  const std::string trims = f + ".trims";
  s.check(!shell.has_fibres(), trims, "cannot go with {}; leave one of them out", kTrimsAndFibres);
  s.check(s.message.fracture().mode() != proto::Fracture::DAMAGE, trims,
          "cannot go with {}; take TIPS, or leave them out", kTrimsAndDamage);
  s.check(s.message.transfer().kind() == proto::GridTransfer::DIRECT, trims, "cannot go with {}; leave one of them out",
          kTrimsAndGrid);
}

}  // namespace sunder::scene
