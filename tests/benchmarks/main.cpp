// sunder-bench: what a force evaluation costs, beside the machine's own limits, and what it costs to have the engine in
// another process; all in one run.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <omp.h>
#include <nlohmann/json.hpp>

#include "coupler/core/command_line.h"
#include "coupler/core/error.h"
#include "shell/mechanics/operations.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "tests/benchmarks/absent.h"
#include "tests/benchmarks/beside.h"
#include "tests/benchmarks/two_processes.h"
#include "tests/shell/rig.h"

namespace {

using namespace sunder;
using namespace sunder::shell;

constexpr int kLayers = 4;

struct Sheet {
  ShellModel model;
  ShellState state;
  double layer_points;
};

constexpr double kElement = 5e-3;  // [m]

// A glass-like sheet of square elements, bent and stretched a little, so that no branch is the trivial one.
std::unique_ptr<Sheet> sheet(int across, int along, double strength = 0.0, double strain = 1e-4, int degree = 2,
                             const TrimLoops& trim = {}) {
  ShellMaterial g;
  g.density = 2500, g.youngs_modulus = 70e9, g.poisson_ratio = 0.22, g.strength = strength, g.fracture_energy = 1e6;
  const double h = kElement;
  auto s = std::make_unique<Sheet>(
      Sheet{make_shell("sheet", plate(h * across, h * along, across, along, Vec3::Zero(), Quat::Identity(), degree),
                       4e-3, g, kLayers, degree, {}, {}, trim),
            {},
            0.0});
  s->state = make_state(s->model, Vec3::Zero(), 1);
  const std::size_t stride = s->model.tables.component_stride;
  for (int i = 0; i < s->model.control_points(); ++i) {
    const int slot = s->model.tables.slot(i);
    const Vec3 x = s->state.position(slot);
    s->state.motion.x[slot] *= 1.0 + strain;
    s->state.motion.x[2 * stride + slot] = 1e-5 * std::sin(40.0 * x.x()) * std::cos(30.0 * x.y());
  }
  s->layer_points = static_cast<double>(s->model.tables.gauss_points()) * kLayers;
  return s;
}

// The circle in a square sheet of `elements` along a side that leaves a margin of a tenth of it.
TrimLoops circle(int elements) {
  const double side = kElement * elements;
  const int corners = 8 * elements;
  TrimLoop loop;
  for (int k = 0; k <= corners; ++k) {
    const double angle = 2.0 * std::numbers::pi * (k % corners) / corners;
    loop.points.push_back(Vec2::Constant(0.5 * side) + 0.4 * side * Vec2(std::cos(angle), std::sin(angle)));
  }
  return TrimLoops(Vec2::Zero(), Vec2::Constant(side), {loop});
}

// The edges of a square sheet of `elements` along a side: it cuts nothing off.
TrimLoops whole_loop(int elements) {
  const double side = kElement * elements;
  const TrimLoop loop{{{0.0, 0.0}, {side, 0.0}, {side, side}, {0.0, side}, {0.0, 0.0}}, false};
  return TrimLoops(Vec2::Zero(), Vec2::Constant(side), {loop});
}

// Gauss points beside the loop of a trimmed sheet, and those inside that are summed by rows.
std::pair<double, double> border_and_inner(const Sheet& s) {
  const RowTables& t = s.model.tables;
  double border = 0.0, inner = 0.0;
  for (const GatheredPoint& g : s.state.cracked.gathered) border += g.kind != PointKind::kDead;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e)
      inner += s.state.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + e] < 0 &&
               t.metric[t.at(q, kMetricFields, kArea, e)] > 0.0;
  return {border, inner};
}

void force(benchmark::State& b, Sheet& s, int threads) {
  compute_forces(s.model, s.state, false, 0.0, threads);
  for (auto _ : b) benchmark::DoNotOptimize(compute_forces(s.model, s.state, false, 0.0, threads));
}

void whole_substep(benchmark::State& b, const Sheet& s, int threads) {
  const double dt = 1e-9;  // it must not wander off while it is timed
  RunSetup setup = setup_of({{s.model}});
  setup.gravity = Vec3(0, 0, -9.81);
  Rig rig(std::move(setup), threads);
  rig.state() = s.state;
  for (auto _ : b) rig.step(dt);
}

// Point by point in plain double: the formulas of the kernel without rows and packs.
void scalar_reference(benchmark::State& b, Sheet& s) {
  const RowTables& t = s.model.tables;
  std::vector<GatheredPoint> points;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      GatheredPoint g;
      g.functions = patch_functions(s.model.patch, gauss_point(s.model.patch, t, q, e).parameter, t.stride);
      const double* m = &t.metric[t.at(q, kMetricFields, 0, e)];
      const auto field = [&](int k) { return m[k * t.lanes]; };
      g.metric = {{field(kA11), field(kA22), field(kA12)}, {field(kB11), field(kB22), field(kB12)}};
      g.area = field(kArea);
      points.push_back(std::move(g));
    }
  const std::size_t stride = t.component_stride;
  std::vector<double> out(3 * stride);
  for (auto _ : b) {
    std::fill(out.begin(), out.end(), 0.0);
    for (const GatheredPoint& p : points) {
      const Derivatives<double> d = gather(t, p, s.state.motion.x);
      const Forms<double> f = surface_forms(d);
      const Resultants<double> r = integrate_layers<double, false>(f, p.metric, t.layers, t.elasticity);
      const Derivatives<double> g = section_forces(d, f, r, p.area);
      const Vector<double>* all[5] = {&g.u, &g.v, &g.uu, &g.vv, &g.uv};
      for (const GatheredFunction& n : p.functions)
        for (int k = 0; k < 5; ++k) {
          out[n.slot] += n.n[k + 1] * all[k]->x;
          out[stride + n.slot] += n.n[k + 1] * all[k]->y;
          out[2 * stride + n.slot] += n.n[k + 1] * all[k]->z;
        }
    }
    benchmark::DoNotOptimize(out.data());
  }
}

// Multiply-adds that depend on nothing but registers.
void multiply_add(benchmark::State& b) {
  constexpr int kChains = 12, kRounds = 1000;
  Pack x[kChains];
  for (int i = 0; i < kChains; ++i) x[i] = splat<Pack>(1.0 + 0.01 * i);
  const Pack a = splat<Pack>(0.999999), c = splat<Pack>(1e-6);
  for (auto _ : b) {
    for (int r = 0; r < kRounds; ++r)
      for (int i = 0; i < kChains; ++i) x[i] = x[i] * a + c;
    for (int i = 0; i < kChains; ++i) benchmark::DoNotOptimize(x[i]);
  }
  b.counters["flop"] = 2.0 * lanes<Pack>() * kChains * kRounds;
}

void triad(benchmark::State& b) {
  std::vector<double> x(8'000'000, 1.0), y(x.size(), 2.0), z(x.size(), 3.0);
  for (auto _ : b) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = y[i] + 0.5 * z[i];
    benchmark::DoNotOptimize(x.data());
  }
  b.counters["bytes"] = 24.0 * static_cast<double>(x.size());
}

// Whether a benchmark reported an error. The member has another name from version 1.8 of the library on.
template <class Run>
bool failed(const Run& r) {
  if constexpr (requires { r.error_occurred; })
    return r.error_occurred;
  else
    return static_cast<int>(r.skipped) != 0;
}

// Least seconds a round over all repetitions.
class Minima : public benchmark::ConsoleReporter {
 public:
  std::map<std::string, double> seconds, counter;
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& r : runs) {
      if (r.run_type != Run::RT_Iteration || failed(r)) continue;
      const std::string name = r.run_name.function_name;
      const double s = r.real_accumulated_time / static_cast<double>(r.iterations);
      if (!seconds.count(name) || s < seconds[name]) seconds[name] = s;
      for (const auto& [key, value] : r.counters) counter[name] = value.value;
    }
  }
};

constexpr const char* kKernels[] = {"force_10k",    "force_160k",  "force_1250k", "force_cubic", "force_scalar",
                                    "force_damage", "force_sound", "force_cut",   "force_trim",  "force_whole_loop",
                                    "step_1",       "step_2",      "fma",         "triad"};

// Those of their numbers that have goals, as they are or as ratios.
constexpr const char* kKernelKeys[] = {
    "share_of_fma_peak",          "thread_speedup_2",    "force_ns_per_layer_point_mls",
    "trimmed_border_point_ratio", "trimmed_point_ratio", "whole_loop_time_ratio"};

bool chosen(const std::string& name, const std::string& filter) { return name.find(filter) != std::string::npos; }

void measure_kernels(const std::string& filter, std::map<std::string, double>& out) {
  const auto small = sheet(32, 20), middle = sheet(100, 100), large = sheet(280, 279);
  const auto cubic = sheet(66, 67, 0.0, 1e-4, 3);  // as many layer points as the middle one
  const auto damaged = sheet(60, 60, 7e6, 1.5e-4), sound = sheet(60, 60);
  damaged->state.layers.brittleness = 0.5;
  const RowTables& t = damaged->model.tables;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) watch_point(damaged->model, damaged->state, q, e);
  const auto cut = sheet(60, 60);
  for (int k = 1; k < 15; ++k)
    insert_polyline(cut->model, cut->state, {{0.02 * k, 0.013}, {0.02 * k + 0.011, 0.287}}, 0.0);
  const auto round = sheet(60, 60, 0.0, 1e-4, 2, circle(60)), looped = sheet(60, 60, 0.0, 1e-4, 2, whole_loop(60));
  const auto add = [&](const std::string& name, auto&& f) {
    ensure(std::count(std::begin(kKernels), std::end(kKernels), name) == 1, "{} is not in the list", name);
    if (!chosen(name, filter)) return;
    benchmark::RegisterBenchmark(name.c_str(), f)
        ->Repetitions(5)
        ->MinTime(0.15)
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
  };
  add("force_10k", [&](benchmark::State& b) { force(b, *small, 1); });
  add("force_160k", [&](benchmark::State& b) { force(b, *middle, 1); });
  add("force_1250k", [&](benchmark::State& b) { force(b, *large, 1); });
  add("force_cubic", [&](benchmark::State& b) { force(b, *cubic, 1); });
  add("force_scalar", [&](benchmark::State& b) { scalar_reference(b, *middle); });
  add("force_damage", [&](benchmark::State& b) { force(b, *damaged, 1); });
  add("force_sound", [&](benchmark::State& b) { force(b, *sound, 1); });
  add("force_cut", [&](benchmark::State& b) { force(b, *cut, 1); });
  add("force_trim", [&](benchmark::State& b) { force(b, *round, 1); });
  add("force_whole_loop", [&](benchmark::State& b) { force(b, *looped, 1); });
  add("step_1", [&](benchmark::State& b) { whole_substep(b, *middle, 1); });
  add("step_2", [&](benchmark::State& b) { whole_substep(b, *middle, 2); });
  add("fma", multiply_add);
  add("triad", triad);
  // repetitions of different benchmarks take turns, so that a slow moment of the machine meets all of them
  std::string own = "sunder-bench", interleave = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> options{own.data(), interleave.data()};
  int count = static_cast<int>(options.size());
  benchmark::Initialize(&count, options.data());
  Minima minima;
  benchmark::RunSpecifiedBenchmarks(&minima);
  const auto seconds = [&](const char* name) { return minima.seconds.count(name) ? minima.seconds[name] : 0.0; };
  const auto put = [&](const std::string& key, const char* name, double scale) {
    if (seconds(name) > 0.0) out[key] = seconds(name) * scale;
  };
  put("force_ns_per_layer_point", "force_160k", 1e9 / middle->layer_points);
  put("force_ns_per_layer_point_10k", "force_10k", 1e9 / small->layer_points);
  put("force_ns_per_layer_point_160k", "force_160k", 1e9 / middle->layer_points);
  put("force_ns_per_layer_point_1250k", "force_1250k", 1e9 / large->layer_points);
  put("force_ns_per_layer_point_cubic", "force_cubic", 1e9 / cubic->layer_points);
  put("scalar_reference_ns_per_layer_point", "force_scalar", 1e9 / middle->layer_points);
  put("force_ns_per_layer_point_damage", "force_damage", 1e9 / damaged->layer_points);
  put("step_ms_160k_layer_points", "step_2", 1e3);
  if (seconds("step_2") > 0.0 && seconds("step_1") > 0.0)
    out["thread_speedup_2"] = seconds("step_1") / seconds("step_2");
  if (seconds("force_cut") > 0.0 && seconds("force_sound") > 0.0) {  // what is left of the rows costs as without cuts
    const double gathered = static_cast<double>(cut->state.cracked.gathered.size()) * kLayers;
    out["force_ns_per_layer_point_mls"] =
        1e9 * (seconds("force_cut") - seconds("force_sound") * (1.0 - gathered / cut->layer_points)) / gathered;
  }
  if (seconds("force_trim") > 0.0 &&
      seconds("force_sound") > 0.0) {  // rows of the round sheet compute what is outside too
    const double point = seconds("force_sound") * kLayers / sound->layer_points;
    const auto [border, inner] = border_and_inner(*round);
    // Of a point beside the loop, where all others cost as in a whole sheet.
    out["trimmed_border_point_ratio"] = (seconds("force_trim") / point - inner) / border;
    // Of a point inside, as a mean of those beside the loop and those in rows: what a user pays for the sheet.
    out["trimmed_point_ratio"] = seconds("force_trim") / point / (border + inner);
  }
  if (seconds("force_whole_loop") > 0.0 && seconds("force_sound") > 0.0)
    out["whole_loop_time_ratio"] = seconds("force_whole_loop") / seconds("force_sound");
  if (seconds("fma") > 0.0) out["fma_peak_gflops"] = 1e-9 * minima.counter["fma"] / seconds("fma");
  if (seconds("triad") > 0.0) out["memory_gb_per_s"] = 1e-9 * minima.counter["triad"] / seconds("triad");
  const double operations = operations_of_row_point(middle->model.tables);
  out["operations_per_layer_point"] = operations / kLayers;
  if (seconds("force_160k") > 0.0)
    out["achieved_gflops"] = 1e-9 * operations * middle->layer_points / kLayers / seconds("force_160k");
  if (out.count("achieved_gflops") && out.count("fma_peak_gflops"))
    out["share_of_fma_peak"] = out["achieved_gflops"] / out["fma_peak_gflops"];
  const RowTables& mt = middle->model.tables;
  out["bytes_per_layer_point"] = (8.0 * static_cast<double>(mt.metric.size() + mt.basis_u.size() + mt.basis_v.size()) +
                                  8.0 * 9.0 * mt.component_stride) /
                                 middle->layer_points;
}

std::vector<bench::ProcessBenchmark> benchmarks_of_runs() {
  std::vector<bench::ProcessBenchmark> all = bench::process_benchmarks();
  all.push_back(bench::absent_benchmark());
  all.push_back(bench::beside_benchmark());
  return all;
}

int measure(const std::string& filter, const std::string& json) {
  std::map<std::string, double> out;
  bool any = false;
  std::string names;
  // before the kernels' threads and memory, which a new process would be made of
  for (const bench::ProcessBenchmark& b : benchmarks_of_runs()) {
    names += fmt::format(" {}", b.name);
    if (!chosen(b.name, filter)) continue;
    any = true;
    b.measure(out);
  }
  bool kernels = false;
  for (const std::string name : kKernels) names += " " + name, kernels = kernels || chosen(name, filter);
  if (!any && !kernels) {
    std::cerr << "sunder-bench: no benchmark's name holds '" << filter << "'; there are:" << names << "\n";
    return 2;
  }
  if (kernels) measure_kernels(filter, out);
  double load = 0.0;  // what takes turns with a window's two processes shows in its slowest hundredth first
  if (getloadavg(&load, 1) == 1)
    fmt::print("load average over the last minute {:.1f}, on {} processors\n", load, omp_get_num_procs());
  for (const auto& [key, value] : out)
    if (json.empty()) fmt::print("{:<40} {:.6g}\n", key, value);
  if (json.empty()) return 0;
  std::ofstream file(json);
  file << nlohmann::json(out).dump(2) << "\n";
  file.close();
  require(file.good(), "--json {}: cannot be written", json);
  return 0;
}

void print_list() {
  for (const char* name : kKernels) fmt::print("{}\n", name);
  for (const char* key : kKernelKeys) fmt::print("kernels: {}\n", key);
  for (const bench::ProcessBenchmark& b : benchmarks_of_runs())
    for (const char* key : b.keys) fmt::print("{}: {}\n", b.name, key);
}

int run(int argc, char** argv) {
  std::string filter, json;
  bool list = false;
  CLI::App app("Measures what a force evaluation and an engine in another process cost.", "sunder-bench");
  app.add_option("--filter", filter, "Runs benchmarks whose name holds NAME")->type_name("NAME")->take_last();
  app.add_option("--json", json, "Writes the numbers here instead of printing them")->type_name("FILE")->take_last();
  app.add_flag("--list", list, "Prints the benchmarks, and the numbers that have goals, and ends");
  if (!read_arguments(app, argc, argv)) return 0;
  if (!list) return measure(filter, json);
  print_list();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& e) {
    std::cerr << "sunder-bench: " << e.kind << ": " << e.what() << "\n";
    return static_cast<int>(e.status);
  } catch (const std::exception& e) {
    std::cerr << "sunder-bench: " << e.what() << "\n";
    return static_cast<int>(Exit::kPhysics);
  }
}
