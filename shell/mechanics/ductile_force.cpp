#include "shell/mechanics/ductile_force.h"

#include "shell/mechanics/row_element.h"

namespace sunder::shell {
namespace {

// f(law) of the law in force.
template <class F>
auto with_ductile(const LayerMemory& memory, F&& f) {
  return DuctileLayers<true>::in_force(memory) ? f(DuctileLayers<true>{}) : f(DuctileLayers<false>{});
}

template <int kSupport, RowShape kShape, class Law>
RowFunction ductile_row_of(bool energy, bool stress) {
  if (energy)
    return stress ? element_row<kSupport, kShape, true, true, Law> : element_row<kSupport, kShape, true, false, Law>;
  return stress ? element_row<kSupport, kShape, false, true, Law> : element_row<kSupport, kShape, false, false, Law>;
}

}  // namespace

RowFunction ductile_row(const RowTables& t, const LayerMemory& memory, bool energy, bool stress, double* flow) {
  memory.plastic->sums = flow;
  return with_ductile(memory, [&]<class Law>(Law) {
    const auto of = [&]<RowShape kShape>(std::integral_constant<RowShape, kShape>) -> RowFunction {
      return t.degree == 2 ? ductile_row_of<3, kShape, Law>(energy, stress)
                           : ductile_row_of<4, kShape, Law>(energy, stress);
    };
    if (t.varies()) return of(std::integral_constant<RowShape, RowShape::kVarying>());
    if (t.rational) return of(std::integral_constant<RowShape, RowShape::kRational>());
    return of(std::integral_constant<RowShape, RowShape::kPolynomial>());
  });
}

BatchFunction ductile_batch(const LayerMemory& memory, bool energy, bool record, double* flow) {
  memory.plastic->sums = flow;
  return with_ductile(memory, [&]<class Law>(Law) -> BatchFunction {
    if (energy) return record ? sum_batch<true, true, Law> : sum_batch<true, false, Law>;
    return record ? sum_batch<false, true, Law> : sum_batch<false, false, Law>;
  });
}

void book_ductile_rows(const LayerMemory& memory, double damage, double flow) {
  memory.plastic->dissipated += flow, memory.plastic->sums = nullptr;
  with_ductile(memory, [&]<class Law>(Law) { Law::book_rows(memory, damage); });
}

void book_ductile_points(const LayerMemory& memory, double damage, double flow) {
  memory.plastic->dissipated += flow, memory.plastic->sums = nullptr;
  with_ductile(memory, [&]<class Law>(Law) { Law::book_points(memory, damage); });
}

}  // namespace sunder::shell
