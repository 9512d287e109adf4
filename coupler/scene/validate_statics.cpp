// Checks scenes in which nothing moves, and load steps.
#include "coupler/scene/checks.h"

namespace sunder::scene {
namespace {

constexpr int kMostFactors = 10000;
constexpr double kLargestFactor = 1e9;

void load_factors(const LoadedScene& s, const std::string& f, const proto::Shell& shell) {
  const auto& factors = shell.equilibrium().load_factors();
  for (int k = 0; k < factors.size(); ++k)
    s.check(std::isfinite(factors[k]) && std::abs(factors[k]) <= kLargestFactor,
            fmt::format("{}.equilibrium.load_factors[{}]", f, k), "is {}; a number of at most 1e9", factors[k]);
  s.check(factors.size() <= kMostFactors, f + ".equilibrium.load_factors", "has {} factors; at most {}", factors.size(),
          kMostFactors);
  for (int k = 0; k < shell.loads_size(); ++k)
    s.check(shell.loads(k).factor().empty(), fmt::format("{}.loads[{}].factor", f, k),
            "is over time, and load_factors are given; leave one of them out");
  for (int k = 0; k < shell.supports_size(); ++k)
    s.check(shell.supports(k).motion_size() <= 1, fmt::format("{}.supports[{}].motion", f, k),
            "has {} points in time, and load_factors are given: give one point, which the factors multiply",
            shell.supports(k).motion_size());
  s.check(shell.cuts_size() == 0, f + ".cuts", "are made in time, and load_factors are given; leave one of them out");
}

}  // namespace

bool is_static(const proto::Scene& m) {
  return !m.has_end_time_s() && !m.has_window_s() && m.shells_size() > 0 && m.bodies_size() == 0 &&
         m.soft_bodies_size() == 0;
}

void validate_statics(const LoadedScene& s) {
  const proto::Scene& m = s.message;
  int first = -1;
  for (int i = 0; i < m.shells_size(); ++i)
    if (m.shells(i).equilibrium().load_factors_size() > 0 && first < 0) first = i;
  if (first >= 0) {
    const char* why = "is given, but a shell has load_factors, between which nothing moves; leave it out";
    for (const auto& [given, field] :
         {std::pair{m.has_end_time_s(), "end_time_s"}, std::pair{m.has_window_s(), "window_s"},
          std::pair{m.bodies_size() > 0, "bodies[0]"}, std::pair{m.soft_bodies_size() > 0, "soft_bodies[0]"}})
      s.check(!given, field, "{}", why);
  }
  if (!is_static(m)) return;
  const char* no_time = "is a time, and in this scene nothing moves; leave it out, or give end_time_s and window_s";
  for (const auto& [given, field] :
       {std::pair{m.has_settle_window_s(), "settle_window_s"}, std::pair{m.has_time_step_s(), "time_step_s"},
        std::pair{m.has_coupling(), "coupling"},
        std::pair{m.output().has_frame_interval_s(), "output.frame_interval_s"},
        std::pair{m.output().has_shell_frame_interval_s(), "output.shell_frame_interval_s"},
        std::pair{m.output().has_probe_interval_s(), "output.probe_interval_s"},
        std::pair{m.output().has_checkpoint_interval_s(), "output.checkpoint_interval_s"},
        std::pair{m.fracture().has_latest_freeze_s(), "fracture.latest_freeze_s"}})
    s.check(!given, field, "{}", no_time);
  for (int i = 0; i < m.shells_size(); ++i) {
    const std::string f = fmt::format("shells[{}]", i);
    const int count = m.shells(i).equilibrium().load_factors_size();
    const int wanted = m.shells(std::max(first, 0)).equilibrium().load_factors_size();
    s.check(count == wanted, f + ".equilibrium.load_factors",
            "has {} factors, and shell '{}' has {}; give every shell as many", count,
            m.shells(std::max(first, 0)).name(), wanted);
    load_factors(s, f, m.shells(i));
  }
}

}  // namespace sunder::scene
