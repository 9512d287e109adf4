#pragma once
// Layers that yield: J2 plasticity in plane stress, with isotropic hardening, by a plastic reference metric.
#include <atomic>

#include "shell/mechanics/layers_elastic.h"

namespace sunder::shell {

struct Yielding {
  double yield_stress = 0.0;       // [Pa]; 0: does not yield
  double hardening_modulus = 0.0;  // slope of the yield stress over the plastic strain [Pa]
  double youngs_modulus = 0.0, poisson_ratio = 0.0;
};

/// Plastic state of a layer.
template <class T>
struct PlasticState {
  Sym2<T> change;  // of the reference metric, covariant
  T strain;        // equivalent plastic strain
};

constexpr int kReturnSteps = 12;  // of Newton; the equation is convex, so from zero it converges from one side

/// Returns the trial state at metric `c` to the yield surface (Simo, Taylor 1986). The elastic strain is (C - Abar)/2
/// with the plastic metric Abar = a + change. It is small, so trial stresses follow Hooke's law. The law and the yield
/// condition have the same eigentensors, mean and deviator, so the return scales both:
///   mean /= 1 + E dg / (3 (1 - nu)),  deviator /= 1 + 2 mu dg,
///   sigma P sigma(dg) = mean'^2 / 6 + dev' : dev' = 2/3 yield(strain + dg sqrt(2/3 sigma P sigma))^2.
/// The change of the elastic strain goes into the plastic metric, in any coordinates. Returns true where there is flow.
template <class T>
inline auto return_to_yield(PlasticState<T>& p, const Sym2<T>& c, const Sym2<T>& a, const Yielding& y) {
  const double nu = y.poisson_ratio, two_mu = y.youngs_modulus / (1.0 + nu), bulk = y.youngs_modulus / (1.0 - nu);
  const Sym2<T> e{0.5 * (c.c11 - a.c11 - p.change.c11), 0.5 * (c.c22 - a.c22 - p.change.c22),
                  0.5 * (c.c12 - a.c12 - p.change.c12)};
  const T inverse = 1.0 / determinant(c);
  const T mean = 0.5 * (c.c22 * e.c11 + c.c11 * e.c22 - 2.0 * c.c12 * e.c12) * inverse;  // half the trace
  const Sym2<T> d{e.c11 - mean * c.c11, e.c22 - mean * c.c22, e.c12 - mean * c.c12};
  // square of the deviator: for a tensor without trace it is -2 det in mixed components
  const T square = -2.0 * determinant(d) * inverse;
  const T sum = 2.0 * bulk * mean;  // sigma_11 + sigma_22
  const T part_mean = sum * sum * (1.0 / 6.0), part_dev = (two_mu * two_mu) * square;
  const double k_mean = y.youngs_modulus / (3.0 * (1.0 - nu));
  const T limit0 = y.yield_stress + y.hardening_modulus * p.strain;
  const T over = part_mean + part_dev - (2.0 / 3.0) * limit0 * limit0;
  if (!any(over > 0.0)) return over > 0.0;  // the common case; the loop would change nothing, at ten times the cost
  T gamma{};
  for (int i = 0; i < kReturnSteps; ++i) {
    const T q_mean = 1.0 / (1.0 + k_mean * gamma), q_dev = 1.0 / (1.0 + two_mu * gamma);
    const T m2 = part_mean * q_mean * q_mean, d2 = part_dev * q_dev * q_dev, phi = m2 + d2;
    const T root = square_root(phi * (2.0 / 3.0));
    const T slope_phi = -2.0 * (k_mean * q_mean * m2 + two_mu * q_dev * d2);
    const T limit = limit0 + y.hardening_modulus * gamma * root;
    // d(gamma root)/dgamma = root + gamma slope_phi / (3 root)
    const T safe = select(root > 0.0, root, T{} + 1.0);
    const T slope = slope_phi - (4.0 / 3.0) * limit * y.hardening_modulus * (root + gamma * slope_phi / (3.0 * safe));
    const T f = phi - (2.0 / 3.0) * limit * limit;
    const T next = gamma - f / select(slope < 0.0, slope, T{} - 1.0);
    gamma = select(over > 0.0, select(next > 0.0, next, T{}), T{});
  }
  const T q_mean = 1.0 / (1.0 + k_mean * gamma), q_dev = 1.0 / (1.0 + two_mu * gamma);
  const T phi = part_mean * q_mean * q_mean + part_dev * q_dev * q_dev;
  p.strain = p.strain + gamma * square_root(phi * (2.0 / 3.0));
  const T lost_mean = (1.0 - q_mean) * mean, lost_dev = 1.0 - q_dev;  // exactly zero without flow
  p.change.c11 = p.change.c11 + 2.0 * (lost_mean * c.c11 + lost_dev * d.c11);
  p.change.c22 = p.change.c22 + 2.0 * (lost_mean * c.c22 + lost_dev * d.c22);
  p.change.c12 = p.change.c12 + 2.0 * (lost_mean * c.c12 + lost_dev * d.c12);
  return over > 0.0;
}

/// Work [J/m^3] of the stress `s` at metric `c` while the plastic metric changes by `flow` to `a`. The elastic energy
/// depends on C Abar^-1, so it is s : (C Abar^-1 flow) / 2, or s : flow / 2 for small elastic strains. Energy that
/// hardening stores is included.
template <class T>
inline T plastic_work(const Sym2<T>& s, const Sym2<T>& c, const Sym2<T>& a, const Sym2<T>& flow) {
  const T inverse = 1.0 / determinant(a);
  // Abar^-1 flow, rows by columns
  const T k11 = (a.c22 * flow.c11 - a.c12 * flow.c12) * inverse, k12 = (a.c22 * flow.c12 - a.c12 * flow.c22) * inverse;
  const T k21 = (a.c11 * flow.c12 - a.c12 * flow.c11) * inverse, k22 = (a.c11 * flow.c22 - a.c12 * flow.c12) * inverse;
  return 0.5 * (s.c11 * (c.c11 * k11 + c.c12 * k21) + s.c22 * (c.c12 * k12 + c.c22 * k22) +
                s.c12 * (c.c11 * k12 + c.c12 * k22 + c.c12 * k11 + c.c22 * k21));
}

/// sqrt(1 + x), and 1 / sqrt(1 + x). Near rest a power series takes the place of a root, which costs ten times as much:
/// below kSmallShare the first term that is left out is round-off.
constexpr int kRootTerms = 9;
template <class T>
inline T root_of_one_and(const T& x) {
  if (!all_below(x, kSmallShare)) return square_root(1.0 + x);
  T sum = splat<T>(1.0);
  for (int k = kRootTerms; k >= 1; --k) sum = 1.0 + sum * x * ((1.5 - k) / k);  // binomial series
  return sum;
}
template <class T>
inline T inverse_root_of_one_and(const T& x) {
  if (!all_below(x, kSmallShare)) return 1.0 / square_root(1.0 + x);
  T sum = splat<T>(1.0);
  for (int k = kRootTerms; k >= 1; --k) sum = 1.0 + sum * x * ((0.5 - k) / k);
  return sum;
}

/// U S U with U^2 = C: Kirchhoff stress without the rotation. It is the Cauchy stress if the volume is constant.
template <class T>
inline Sym2<T> unrotated_stress(const Sym2<T>& s, const Sym2<T>& c) {
  const T root = root_of_one_and<T>(determinant(c) - 1.0);
  const T inverse = 0.5 * inverse_root_of_one_and<T>(0.25 * (c.c11 + c.c22 + 2.0 * root) - 1.0);
  const T u11 = (c.c11 + root) * inverse, u22 = (c.c22 + root) * inverse, u12 = c.c12 * inverse;
  const T a11 = u11 * s.c11 + u12 * s.c12, a12 = u11 * s.c12 + u12 * s.c22;  // U S
  const T a21 = u12 * s.c11 + u22 * s.c12, a22 = u12 * s.c12 + u22 * s.c22;
  return {a11 * u11 + a12 * u12, a21 * u12 + a22 * u22, a11 * u12 + a12 * u22};
}

/// Stress at the face, `half` the thickness off the middle: extrapolated from the outermost layer at `z` along the line
/// through the next layer at `next`. Where the layer `flowed` it is the layer's own stress.
template <class T, class Mask>
inline Sym2<T> extrapolated(const Sym2<T>& s, const Sym2<T>& beside, const Mask& flowed, double z, double next,
                            double half) {
  const double on = ((z < next ? -half : half) - z) / (z - next);
  const auto part = [&](const T& own, const T& other) { return select(flowed, own, own + on * (own - other)); };
  return {part(s.c11, beside.c11), part(s.c22, beside.c22), part(s.c12, beside.c12)};
}

/// Stress scaled down to the von Mises stress `limit` where it is above. A face yields before the layer below it. And
/// the stress of the strain energy is some per cent above Hooke's law, which the return uses.
template <class T>
inline Sym2<T> within(const Sym2<T>& s, const T& limit) {
  const T square = s.c11 * s.c11 - s.c11 * s.c22 + s.c22 * s.c22 + 3.0 * s.c12 * s.c12;
  const T share = select(square > limit * limit, limit / square_root(square), T{} + 1.0);
  return {share * s.c11, share * s.c22, share * s.c12};
}

/// Forms at which a section bore last.
template <class T>
struct LastForms {
  Forms<T> forms;
  decltype(T{} < T{}) known;  // lanes that bore; for others `forms` are the present ones
};

/// Resultants of layers that yield. `plastic` has the state of each layer, and `kAdvance` replaces it by the new state.
/// With `kAdvance` or `kEnergy`, `dissipated` gains the plastic work per reference area [J/m^2] of the step from the
/// forms `last` to `f`. It is taken at the mean of both stresses: the work of leapfrog's forces, to second order of the
/// step. Lanes that did not bear add none: no force did work on the way to `f`. Without `last` the work is taken at the
/// present stress. `faces`, if given, gets the true stress of the outermost layers, extrapolated to the face while they
/// are elastic. Resultants would give 1.5 times the yield stress for a section that yields through its thickness.
template <class T, bool kEnergy, bool kAdvance>
inline Resultants<T> integrate_yielding_layers(const Forms<T>& f, const ReferenceMetric<T>& ref, const Layers& layers,
                                               const Elasticity& e, const Yielding& y, PlasticState<T>* plastic,
                                               T& dissipated, FaceStress<T>* faces = nullptr,
                                               const LastForms<T>* last = nullptr) {
  Resultants<T> r{{T{}, T{}, T{}}, {T{}, T{}, T{}}, T{}};
  const std::size_t top = layers.zeta.size() - 1;
  const double half = half_height(layers);
  Sym2<T> below{T{}, T{}, T{}};  // stress of the previous layer
  decltype(return_to_yield<T>(*plastic, below, below, y)) flowed_low{};
  T limit_low{};
  for (std::size_t l = 0; l < layers.zeta.size(); ++l) {
    const double z = layers.zeta[l], w = layers.weight[l];
    const Sym2<T> c = at_height(f.a, f.b, z);
    const Sym2<T> a = reference_at(ref, layers, l);
    PlasticState<T> s = plastic[l];
    const auto with = [&](const Sym2<T>& change) {
      return Sym2<T>{a.c11 + change.c11, a.c22 + change.c22, a.c12 + change.c12};
    };
    const auto flowed = return_to_yield<T>(s, c, a, y);
    const Sym2<T> now = with(s.change);
    const PlaneStress<T> p = plane_stress<T>(c, now, e);
    r.n.c11 += w * p.s.c11, r.n.c22 += w * p.s.c22, r.n.c12 += w * p.s.c12;
    r.m.c11 += (w * z) * p.s.c11, r.m.c22 += (w * z) * p.s.c22, r.m.c12 += (w * z) * p.s.c12;
    if constexpr (kEnergy) r.energy += w * plane_stress_energy<T>(p, c, now, e);
    if constexpr (kAdvance || kEnergy) {
      const Sym2<T>& old = plastic[l].change;
      const Sym2<T> flow{s.change.c11 - old.c11, s.change.c22 - old.c22, s.change.c12 - old.c12};
      T work = plastic_work<T>(p.s, c, now, flow);
      if (last && any(flowed)) {
        const Sym2<T> before = at_height(last->forms.a, last->forms.b, z), from = with(old);
        work = 0.5 * (work + plastic_work<T>(plane_stress<T>(before, from, e).s, before, from, flow));
        work = select(last->known, work, T{});
      }
      dissipated += w * work;
      if constexpr (kAdvance) plastic[l] = s;
    }
    if (!faces) continue;
    const Sym2<T> own = unrotated_stress<T>(p.s, c);
    const T limit = y.yield_stress + y.hardening_modulus * s.strain;
    if (l == 0) faces->low = own, flowed_low = flowed, limit_low = limit;
    if (l == 1)
      faces->low =
          within<T>(extrapolated<T>(faces->low, own, flowed_low, layers.zeta[0], layers.zeta[1], half), limit_low);
    if (l == top)
      faces->high = within<T>(extrapolated<T>(own, below, flowed, layers.zeta[top], layers.zeta[top - 1], half), limit);
    below = own;
  }
  return r;
}

/// Stress of the faces by the resultants of elastic layers, whose stress is linear through the thickness.
template <class T>
inline FaceStress<T> linear_faces(const Resultants<T>& r, const SectionFaces& section) {
  const double of_n = 1.0 / section.thickness, of_m = 6.0 / section.squared;
  const auto face = [&](double side) {
    const auto part = [&](const T& n, const T& m) { return n * of_n + side * (m * of_m); };
    return Sym2<T>{part(r.n.c11, r.m.c11), part(r.n.c22, r.m.c22), part(r.n.c12, r.m.c12)};
  };
  return {face(-1.0), face(1.0)};
}

/// True where layers that have never flowed surely do not flow at this stress of a face at metric `c`. Along the
/// thickness the von Mises stress is convex, so the faces bound all layers. The share of the yield stress leaves room
/// for the difference between the elastic law and the law of Hooke that the return uses, and for a curved section.
template <class T>
inline auto surely_elastic(const Sym2<T>& s, const Sym2<T>& c, const Yielding& y) {
  constexpr double kSurelyElastic = 0.7;  // share of the yield stress
  const double limit = kSurelyElastic * y.yield_stress;
  const T trace = s.c11 * c.c11 + s.c22 * c.c22 + 2.0 * s.c12 * c.c12;
  return trace * trace - 3.0 * determinant(s) * determinant(c) < limit * limit;  // false for NaN
}

constexpr int kFormFields = 6;  // first fundamental form 11 22 12, then the second
/// Memory of layers that yield, for all Gauss points of a patch.
struct RowPlasticity {
  Yielding law;
  // [block][layer][change 11 22 12, strain][lane]; null: no layer yields. Empty until a layer first flows: all are
  // zero.
  std::vector<double>* states = nullptr;
  char* made = nullptr;  // whether `states` are there; threads ask while one of them makes the states. Null: they are
  // Forms at which the states last advanced: [block][kFormFields][lane]. The first is negative where the point did not
  // bear; the flow by which it bears again does no work. The second is negative where the states of the point may
  // differ from zero. Where it is positive they are all zero, and nobody has to read them.
  std::vector<double>* forms = nullptr;
  bool advance = false;     // states advance
  double dissipated = 0.0;  // gains the plastic work of states that advance [J]
  double* sums = nullptr;   // of DuctileLayers: plastic work by the sum_slot() of its place [J]

  bool has_states() const { return !made || std::atomic_ref<char>(*made).load(std::memory_order_acquire) != 0; }
  /// Makes the states of `layers` layers, where they are not there yet. Any thread may call it at any time.
  void make_states(std::size_t layers) const;
};

/// The law of layers that yield, for both kernels.
struct YieldingLayers {
  // A plastic hinge may fold more sharply than an elastic shell. A pack takes folded points at rest.
  // States advance by `advance`, whether or not stress is recorded.
  static constexpr bool kRemembers = true, kFolds = true, kAdvances = true;
  static bool in_force(const LayerMemory& m) { return m.plastic && m.plastic->states; }

  template <class Places>
  struct At {
    using T = typename Places::Value;
    const Places places;
    const RowPlasticity& law;
    PlasticState<T> states[kMostLayers];  // before; after resultants() with `advance` the new ones
    T work{};                             // plastic work per reference area [J/m^2]
    FaceStress<T> faces;                  // only where stress is recorded
    bool elastic = false;                 // no layer flows, or ever has
    decltype(T{} < T{}) written{};        // lanes whose states may not be zero
    // leaves the arrays as they are: clearing them would cost as much as loading
    At(const Places& p, const RowPlasticity& plastic) : places(p), law(plastic) {}

    /// Resultants at the forms `f`. Reads the states, and advances the copy here with kAdvance. Lanes that are not
    /// `summed` have no previous forms. Out of line, so that the elastic case fits the registers.
    template <bool kEnergy, bool kRecord, bool kAdvance, class Mask>
    [[gnu::noinline]] Resultants<T> integrate(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask& summed) {
      load_states();
      const LastForms<T> last = last_forms(f, summed);
      return integrate_yielding_layers<T, kEnergy, kAdvance>(f, ref, places.t.layers, places.t.elasticity, law.law,
                                                             states, work, kRecord ? &faces : nullptr, &last);
    }
    /// The same, with kAdvance by the memory. Layers that have never flowed and are far below the yield stress are
    /// elastic: no state is read or written.
    template <bool kEnergy, bool kRecord, class Mask>
    Resultants<T> resultants(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask& summed) {
      Resultants<T> r;
      if (try_elastic<kEnergy, kRecord>(f, ref, section_faces(places.t.layers), r)) return r;
      return yielding_resultants<kEnergy, kRecord>(f, ref, summed);
    }
    /// The same in two parts: true, and the resultants, where layers are surely elastic; otherwise the second part
    /// follows. A pack that is surely elastic bears: at so little stress C is near the metric at rest.
    template <bool kEnergy, bool kRecord>
    bool try_elastic(const Forms<T>& f, const ReferenceMetric<T>& ref, const SectionFaces& section, Resultants<T>& r) {
      if (!never_flowed()) return false;
      r = integrate_layers<T, kEnergy>(f, ref, places.t.layers, places.t.elasticity);
      faces = linear_faces<T>(r, section);
      const Sym2<T> low = at_height(f.a, f.b, -section.half), high = at_height(f.a, f.b, section.half);
      elastic = !any(!(surely_elastic<T>(faces.low, low, law.law) & surely_elastic<T>(faces.high, high, law.law)));
      if constexpr (kRecord)
        if (elastic) faces = {unrotated_stress<T>(faces.low, low), unrotated_stress<T>(faces.high, high)};
      return elastic;
    }
    template <bool kEnergy, bool kRecord, class Mask>
    Resultants<T> yielding_resultants(const Forms<T>& f, const ReferenceMetric<T>& ref, const Mask& summed) {
      if (law.advance) return integrate<kEnergy, kRecord, true>(f, ref, summed);
      return integrate<kEnergy, kRecord, false>(f, ref, summed);
    }

    /// Plastic work that is not booked yet and counts as stored [J/m^2]; null: none.
    const T* unbooked() const { return law.advance ? nullptr : &work; }

    /// If `advance`: writes the states of `sound` lanes and adds their work to `booked` [J]. Other lanes of `own` lose
    /// their forms.
    template <bool kEnergy, bool kRecord, class Mask>
    T keep(const Forms<T>& f, const Mask& own, const Mask& sound, const T& area, double& booked) {
      if (!law.advance) return T{};
      const auto writes = elastic ? written : written | sound;
      const T now[kFormFields] = {f.a.c11, select(writes, -f.a.c22, f.a.c22), f.a.c12, f.b.c11, f.b.c22, f.b.c12};
      for (int k = 0; k < kFormFields; ++k)
        places.store(*law.forms, kFormFields, k, own, select(sound, now[k], splat<T>(-1.0)));
      if (elastic || !must_store(sound)) return T{};
      each_field([&](const T& v, int fields, int field) { places.store(*law.states, fields, field, sound, v); });
      places.add(booked, sound, area, work);
      return T{};
    }

    // The previous forms of lanes that are `summed` and have any, elsewhere `f`.
    template <class Mask>
    LastForms<T> last_forms(const Forms<T>& f, const Mask& summed) const {
      const decltype(T{} < T{}) known = summed & (places.load(*law.forms, kFormFields, 0) > 0.0);
      const auto before = [&](const T& now, int k) {
        return select(known, places.load(*law.forms, kFormFields, k), now);
      };
      const T a22 = before(f.a.c22, 1);
      Forms<T> last{};
      last.a = {before(f.a.c11, 0), select(a22 < 0.0, -a22, a22), before(f.a.c12, 2)};
      last.b = {before(f.b.c11, 3), before(f.b.c22, 4), before(f.b.c12, 5)};
      return {last, known};
    }

    // Prestress is not linear through the thickness: its layers are looked at one by one.
    bool never_flowed() {
      if (!places.t.layers.growth.empty() || places.t.layers.bending > 0.0) return false;
      written = places.load(*law.forms, kFormFields, 1) < 0.0;
      if (!any(written) || !law.has_states()) return true;
      const int count = static_cast<int>(places.t.layers.zeta.size());
      T strain{};
      for (int l = 0; l < count; ++l) strain += places.load(*law.states, 4 * count, 4 * l + 3);
      return !any(strain != 0.0);
    }

    void load_states() {
      const bool there = law.has_states();
      each_field([&](T& v, int fields, int field) { v = there ? places.load(*law.states, fields, field) : T{}; });
    }
    // False where the patch has no states yet, and none of the `sound` lanes has flowed.
    template <class Mask>
    bool must_store(const Mask& sound) {
      if (law.has_states()) return true;
      const std::size_t count = places.t.layers.zeta.size();
      bool flowed = false;
      for (std::size_t l = 0; l < count; ++l) flowed = flowed || any(sound & (states[l].strain != 0.0));
      if (flowed) law.make_states(count);
      return flowed;
    }

    template <class F>
    void each_field(F&& f) {
      const int count = static_cast<int>(places.t.layers.zeta.size());
      for (int l = 0; l < count; ++l) {
        PlasticState<T>& s = states[l];
        f(s.change.c11, 4 * count, 4 * l), f(s.change.c22, 4 * count, 4 * l + 1);
        f(s.change.c12, 4 * count, 4 * l + 2), f(s.strain, 4 * count, 4 * l + 3);
      }
    }
  };
  template <class Places>
  static At<Places> at(const Places& p, const LayerMemory& m) {
    return {p, *m.plastic};
  }
  static void book_rows(const LayerMemory& m, double booked) { m.plastic->dissipated += booked; }
  static void book_points(const LayerMemory& m, double booked) { m.plastic->dissipated += booked; }
};

}  // namespace sunder::shell
