#pragma once
// The list of elastic laws, and the stress of a layer by whichever of them a material has.
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "shell/mechanics/law_ghf18.h"
#include "shell/mechanics/law_jgt17.h"
#include "shell/mechanics/law_neo_hookean.h"
#include "shell/mechanics/law_paper_projection.h"

namespace sunder::shell {

template <IsElasticLaw... Laws>
using OneOfLaws = std::variant<Laws...>;

/// All elastic laws. The place of a law is its number in Shell.StressModel of proto/shell.proto.
using ElasticLaw = OneOfLaws<NeoHookean,       //
                             PaperProjection,  //
                             Jgt17,            //
                             Ghf18>;
constexpr int kElasticLaws = std::variant_size_v<ElasticLaw>;

/// Place in the list.
enum class StressModel : int {};
template <class Law>
constexpr StressModel model_of = [] {
  int k = 0;
  return [&]<class... Laws>(std::variant<Laws...>*) {
    (void)((std::is_same_v<Law, Laws> || (++k, false)) || ...);
    return StressModel{k};
  }(static_cast<ElasticLaw*>(nullptr));
}();

/// An elastic material: its moduli at small strain, and its law.
struct Elasticity : Lame {
  ElasticLaw law;

  StressModel model() const { return StressModel{static_cast<int>(law.index())}; }
  bool keeps_thickness() const {
    return std::visit([](const auto& l) { return l.kKeepsThickness; }, law);
  }
  /// Least ln J0 that the law has an answer for; minus infinity where it has one for all.
  double least_log_area() const {
    const auto least = [](const auto& l) {
      if constexpr (requires { l.least_log_area; })
        return l.least_log_area;
      else
        return -std::numeric_limits<double>::infinity();
    };
    return std::visit(least, law);
  }
};

inline Elasticity elasticity(const ElasticConstants& c, StressModel model = model_of<NeoHookean>) {
  Elasticity e{lame_constants(c), NeoHookean()};
  const auto make = [&]<std::size_t... k>(std::index_sequence<k...>) {
    ((static_cast<std::size_t>(model) == k ? (void)e.law.emplace<k>(c) : void()), ...);
  };
  make(std::make_index_sequence<kElasticLaws>());
  return e;
}

/// Names of all laws, in the order of the list.
inline std::vector<std::string> elastic_law_names() {
  return []<class... Laws>(std::variant<Laws...>*) {
    return std::vector<std::string>{Laws::kName...};
  }(static_cast<ElasticLaw*>(nullptr));
}

/// The laws but the first, which is the common one. Out of line: the common case then fits the registers.
template <class T>
[[gnu::noinline]] PlaneStress<T> stress_by_other_law(const Sym2<T>& c, const Sym2<T>& a, const ElasticLaw& law) {
  return std::visit([&](const auto& l) { return l.template stress<T>(c, a); }, law);
}
template <class T>
[[gnu::noinline]] T energy_by_other_law(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a,
                                        const ElasticLaw& law) {
  return std::visit([&](const auto& l) { return l.template energy<T>(p, c, a); }, law);
}

/// Stress of a layer with current metric `c` and reference metric `a`, both covariant and positive definite.
template <class T>
[[gnu::always_inline]] inline PlaneStress<T> plane_stress(const Sym2<T>& c, const Sym2<T>& a, const Elasticity& e) {
  const auto* common = std::get_if<NeoHookean>(&e.law);
  if (!common) {
    const Sym2<T> c_there = c, a_there = a;  // only these copies have an address, the rest stays in registers
    return stress_by_other_law<T>(c_there, a_there, e.law);
  }
  return common->stress<T>(c, a);
}

/// Energy per reference volume [J/m^3] of the same state. Out of line, so that it is rounded alike for all callers.
template <class T>
[[gnu::noinline]] T plane_stress_energy(const PlaneStress<T>& p, const Sym2<T>& c, const Sym2<T>& a,
                                        const Elasticity& e) {
  if (const auto* common = std::get_if<NeoHookean>(&e.law)) return common->energy<T>(p, c, a);
  return energy_by_other_law<T>(p, c, a, e.law);
}

/// Volume ratio J. A root costs more than the series.
template <class T>
inline T volume_ratio(const PlaneStress<T>& p, const Elasticity& e) {
  if (const auto* common = std::get_if<NeoHookean>(&e.law); common && all_below(p.share, kSmallShare))
    return series<T>(common->volume, p.share);
  return square_root(p.area2 * p.stretch2);
}

}  // namespace sunder::shell
