#pragma once
// Whether the elements of a shell are even enough for explicit steps.
#include <string>

#include "shell/solver/model.h"

namespace sunder::shell {

struct ElementFit {
  double step = 0.0;    // stable step of the shell alone [s]
  double slower = 1.0;  // times as many substeps as even elements of the length that is wanted need [-]
  bool unfit = false;   // a run would not end
  std::string warning;  // what is wrong and the remedy; empty: nothing
};

/// Compares the stable step of a shell with that of even elements `element` [m] long. A pole or a sliver makes it
/// short.
ElementFit element_fit(const ShellModel& model, double element);

}  // namespace sunder::shell
