#include "shell/mechanics/layers_weakening.h"

#include <utility>

namespace sunder::shell {

double retained_since(const PointDamage& d, const Loss& now, double area) {
  double work = 0.0;
  for (int k = 0; k < 6 && !d.fresh; ++k) {
    const double mean = 0.5 * (now.lost[k] + d.lost[k]) * (k % 3 == 2 ? 2.0 : 1.0);  // 12 counts twice
    work += mean * (now.forms[k] - d.forms[k]) * (k < 3 ? 0.5 : -1.0);               // dE = da / 2 - zeta db
  }
  return area * work;
}

double keep(PointDamage& d, const Loss& now, double area) {
  d.retained += retained_since(d, now, area);
  d.forms = now.forms, d.lost = now.lost, d.fresh = false;
  return d.damage() > 0.0f ? 0.0 : std::exchange(d.retained, 0.0);
}

double keep_worst(PointDamage& d, const Loss& now, double area) {
  const double stays = area * now.energy;
  // less work goes in by the retained energy, and less is stored by the growth of `stays`
  const double dissipated = stays - d.retained - retained_since(d, now, area);
  d.retained = stays, d.forms = now.forms, d.lost = now.lost, d.fresh = false;
  return dissipated;
}

}  // namespace sunder::shell
