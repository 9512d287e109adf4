#pragma once
// How near moving bodies come to shells before one of them touches a shell.
#include <limits>
#include <string>
#include <vector>

#include "shell/run/simulation.h"

namespace sunder::shell {

/// Plain numbers, so a checkpoint stores them as bytes.
struct Nearness {
  std::int64_t touched =
      0;  // 1: a moving body of the scene has pushed a shell or a soft body, or overlapped with a shell
  int body = -1, shell = -1;                             // which came nearest; -1: no look so far
  double gap = std::numeric_limits<double>::infinity();  // between them [m], and when [s]
  double time = 0.0;
};

/// Notes bodies that had impulses since the window began.
void note_touches(const RunSetup& setup, const State& state, Nearness& near);

/// Looks at `time` [s] which moving body of the scene is nearest to a shell, at the points where contact is felt. It
/// does nothing once a shell was touched.
void look_how_near(const RunSetup& setup, const State& state, double time, Nearness& near);

/// A sentence for run.json where no moving body has touched a shell up to `time` [s]; empty where one has, or where
/// nobody has looked. `frozen`: why the shells were frozen at that time, as in run.json; empty: they were not.
std::string apart_warning(const RunSetup& setup, const Nearness& near, double time, const std::string& frozen = "");

}  // namespace sunder::shell
