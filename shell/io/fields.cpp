#include "shell/io/fields.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shell/mechanics/principal.h"
#include "shell/mechanics/section_state.h"

namespace sunder::shell {
namespace {

constexpr std::array<const char*, kSectionPlaces> kPlaceNames = {"outside", "middle", "inside"};
const std::vector<std::string> kTensor = {"xx", "yy", "zz", "xy", "yz", "xz"}, kVector = {"x", "y", "z"},
                               kPrincipal = {"larger", "smaller"};
using Tensor = Eigen::Matrix<double, 6, 1>;

// The tensor with components 11 22 12 along `first` and `second`, in world axes.
Tensor in_world(const Sym2<double>& t, const Vec3& first, const Vec3& second) {
  const Mat3 sum = t.c11 * first * first.transpose() + t.c22 * second * second.transpose() +
                   t.c12 * (first * second.transpose() + second * first.transpose());
  return (Tensor() << sum(0, 0), sum(1, 1), sum(2, 2), sum(0, 1), sum(1, 2), sum(0, 2)).finished();
}

// Appends a tensor, its principal values and the direction of the larger one.
void add_tensor(const Tensor& t, const Vec3& normal, bool mises, std::vector<double>& out) {
  out.insert(out.end(), t.data(), t.data() + t.size());
  if (normal.isZero(0.0)) {
    out.insert(out.end(), mises ? 6 : 5, 0.0);
    return;
  }
  const Vec3 first = normal.unitOrthogonal(), second = normal.cross(first);
  Mat3 full;
  full << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  const Principal p = principal(first.dot(full * first), second.dot(full * second), first.dot(full * second));
  const Vec3 direction = p.crack.y() * first - p.crack.x() * second;  // across the crack that it opens
  out.insert(out.end(), {p.high, p.low, direction.x(), direction.y(), direction.z()});
  if (mises) out.push_back(std::sqrt(p.high * p.high - p.high * p.low + p.low * p.low));
}

void add_tensor_arrays(const std::string& name, const std::string& unit, bool mises, std::vector<FieldArray>& out) {
  out.push_back({name, unit, kTensor});
  out.push_back({name + "_principal", unit, kPrincipal});
  out.push_back({name + "_direction", "", kVector});
  if (mises) out.push_back({name + "_von_mises", unit, {}});
}

}  // namespace

std::string FieldArray::with_unit() const {
  if (unit.empty()) return name;
  std::string out = name + "_" + unit;
  if (const std::size_t per = out.find('/'); per != std::string::npos) out.replace(per, 1, "_per_");
  return out;
}

std::vector<FieldArray> field_arrays(FieldSet fields) {
  std::vector<FieldArray> out;
  for (const char* place : kPlaceNames)
    if (fields.has(FieldSet::kStress)) add_tensor_arrays(std::string("stress_") + place, "Pa", true, out);
  for (const char* place : kPlaceNames)
    if (fields.has(FieldSet::kStrain)) add_tensor_arrays(std::string("strain_") + place, "", false, out);
  if (fields.has(FieldSet::kMembraneForce)) add_tensor_arrays("membrane_force", "N/m", false, out);
  if (fields.has(FieldSet::kBendingMoment)) add_tensor_arrays("bending_moment", "N", false, out);
  for (const char* place : kPlaceNames)
    if (fields.has(FieldSet::kPlasticStrain)) out.push_back({std::string("plastic_strain_") + place, "", {}});
  if (fields.has(FieldSet::kThickness)) out.push_back({"thickness", "m", {}});
  if (fields.has(FieldSet::kContactPressure)) out.push_back({"contact_pressure", "Pa", {}});
  return out;
}

FieldSampler::FieldSampler(const ShellModel& model, const ShellState& state, FieldSet fields,
                           const ContactOverTime& contact)
    : model_(model), state_(state), fields_(fields), contact_(contact) {}

const FieldSampler::Known& FieldSampler::at_gauss(int block, int lane) {
  const auto [at, is_new] = known_.try_emplace(static_cast<std::size_t>(block) * model_.tables.lanes + lane);
  if (is_new) compute(block, lane, at->second);
  return at->second;
}

double FieldSampler::pressure(const GatheredPoint& point, const Vec3& normal) const {
  if (contact_.impulse.empty() || contact_.time <= 0.0) return 0.0;
  double sum = 0.0;
  for (const GatheredFunction& f : point.functions) {
    if (model_.mass[f.slot] <= 0.0) continue;  // the area of a control point is its mass over that of an area
    const Vec3 j = state_.at(contact_.impulse, f.slot);
    sum -= f.n[0] * j.dot(normal) * model_.mass_per_area(f.slot) / (model_.mass[f.slot] * contact_.time);
  }
  return sum;
}

void FieldSampler::compute(int block, int lane, Known& known) const {
  const RowTables& t = model_.tables;
  if (gauss_point(model_.patch, t, block, lane).weight == 0.0) return;
  const auto uncut = [&](const RowTables& tables) {
    GatheredPoint p;
    p.block = block, p.lane = lane, p.kind = PointKind::kQuadratic;
    const auto metric = [&](int field) { return tables.metric[tables.at(block, kMetricFields, field, lane)]; };
    p.metric = {{metric(kA11), metric(kA22), metric(kA12)}, {metric(kB11), metric(kB22), metric(kB12)}};
    shell_functions(model_, block, lane, p.functions);
    return p;
  };
  const CrackedPoints& cracked = state_.cracked;
  const int index = cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
  const GatheredPoint own = index < 0 ? uncut(t) : cracked.gathered[index];
  if (own.functions.empty() || own.handed_off || state_.motion.detached[own.functions[0].slot]) return;
  const Yielding yielding{model_.material.yield_stress, model_.material.hardening_modulus,
                          model_.material.youngs_modulus, model_.material.poisson_ratio};
  SectionMemory memory;
  if (state_.yields()) memory.yielding = &yielding, memory.plastic = &state_.layers.plastic;
  if (index >= 0 && state_.weakens() && !cracked.damage.empty())
    memory.damage = &cracked.damage[index], memory.brittleness = state_.layers.brittleness,
    memory.heals = state_.layers.heals;
  std::optional<SectionState> s;
  if (model_.laminated()) {
    const int beside =
        model_.trim.empty() ? -1 : model_.trim.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
    const GatheredPoint core = beside < 0 ? uncut(model_.interlayer) : model_.trim.points[beside];
    const SectionCore inner{model_.interlayer, core};
    s = section_state(t, own, state_.motion.x, model_.thickness, memory, &inner);
  } else {
    s = section_state(t, own, state_.motion.x, model_.thickness, memory);
  }
  if (!s) return;
  if (const double factor = t.thickness_factor(block, lane); factor != 1.0) thicken(*s, factor);
  known.bears = true;
  Values& v = known.values;
  v.segment<3>(kNormal) = s->normal;
  const auto put = [&](int at, const Sym2<double>& tensor) {
    v.segment<6>(at) = in_world(tensor, s->first, s->second);
  };
  for (int k = 0; k < kSectionPlaces; ++k) {
    put(kStress + 6 * k, s->stress[k]), put(kStrain + 6 * k, s->strain[k]);
    v[kPlastic + k] = s->plastic[k];
  }
  put(kForce, s->force), put(kMoment, s->moment);
  v[kThickness] = s->thickness, v[kPressure] = pressure(own, s->normal);
}

// Weights of the Gauss points of an element by the polynomial through all of them; false where they are not a lattice.
bool FieldSampler::weights_of(const Vec2& at, int first_block, int lane, std::vector<double>& weights) const {
  const int each = model_.tables.gauss;
  std::vector<double> along[2];
  for (int d = 0; d < 2; ++d)
    for (int a = 0; a < each; ++a) {
      const int block = first_block + (d == 0 ? a : a * each);
      const Vec2 own = gauss_point(model_.patch, model_.tables, block, lane).parameter;
      double weight = 1.0;
      for (int b = 0; b < each; ++b) {
        if (b == a) continue;
        const Vec2 other =
            gauss_point(model_.patch, model_.tables, first_block + (d == 0 ? b : b * each), lane).parameter;
        if (other[d] == own[d]) return false;
        weight *= (at[d] - other[d]) / (own[d] - other[d]);
      }
      along[d].push_back(weight);
    }
  for (int b = 0; b < each; ++b)
    for (int a = 0; a < each; ++a) weights.push_back(along[0][a] * along[1][b]);
  return true;
}

bool FieldSampler::add_values(const Vec2& at, std::vector<double>& out) {
  const RowTables& t = model_.tables;
  const int lane = model_.patch.knots_u.span_of(at.x()), points = t.gauss * t.gauss;
  const int first = model_.patch.knots_v.span_of(at.y()) * points;
  std::vector<int> blocks;
  for (int k = 0; k < points; ++k) {
    const GaussPoint g = gauss_point(model_.patch, t, first + k, lane);
    if (g.weight == 0.0 || !at_gauss(first + k, lane).bears) continue;
    if (model_.laminated() || state_.cracks.graph.visible(at, g.parameter)) blocks.push_back(first + k);
  }
  std::vector<double> weights;
  const bool whole = static_cast<int>(blocks.size()) == points && model_.trim.empty();
  if (!whole || !weights_of(at, first, lane, weights)) weights.assign(blocks.size(), 1.0 / blocks.size());
  Values sum = Values::Zero();
  for (std::size_t k = 0; k < blocks.size(); ++k) sum += weights[k] * at_gauss(blocks[k], lane).values;
  const Vec3 normal = sum.segment<3>(kNormal).stableNormalized();
  for (int k = 0; k < kSectionPlaces; ++k)
    if (fields_.has(FieldSet::kStress)) add_tensor(sum.segment<6>(kStress + 6 * k), normal, true, out);
  for (int k = 0; k < kSectionPlaces; ++k)
    if (fields_.has(FieldSet::kStrain)) add_tensor(sum.segment<6>(kStrain + 6 * k), normal, false, out);
  if (fields_.has(FieldSet::kMembraneForce)) add_tensor(sum.segment<6>(kForce), normal, false, out);
  if (fields_.has(FieldSet::kBendingMoment)) add_tensor(sum.segment<6>(kMoment), normal, false, out);
  for (int k = 0; k < kSectionPlaces; ++k)
    if (fields_.has(FieldSet::kPlasticStrain)) out.push_back(std::max(0.0, sum[kPlastic + k]));
  if (fields_.has(FieldSet::kThickness)) out.push_back(sum[kThickness]);
  if (fields_.has(FieldSet::kContactPressure)) out.push_back(sum[kPressure]);
  return !blocks.empty();
}

}  // namespace sunder::shell
