// Window and reply between two processes, without physics: the free-flight engine gives back what it is handed. Timed
// from the task to the checked states: encode, ZeroMQ, decode, check, and the same back. Beside it the same bytes
// through ZeroMQ alone, with who waits awake as in a session and asleep, and all once more where all threads share a
// processor.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <sched.h>
#include <zmq.hpp>

#include "coupler/link/channel.h"
#include "coupler/link/remote.h"
#include "tests/benchmarks/two_processes.h"
#include "tests/conformance/process.h"
#include "tests/temporary_folder.h"

namespace sunder::bench {
namespace {

constexpr int kFourKilobytes = 31;  // bodies whose predicted states, 131 bytes each, are about 4 KB; states have 140
constexpr int kManyFragments = 1000;
constexpr double kWindow = 1e-3;  // [s]
constexpr double kFinish = 2.0;   // [s] that an engine may take to end after Bye
constexpr auto kRest = std::chrono::milliseconds(3);
constexpr int kWarm = 10;  // windows before those that count

// Notes how large what passes is.
class Weighed final : public link::Transport {
 public:
  Weighed(std::unique_ptr<link::Transport> inner, RoundTrips& trips) : inner_(std::move(inner)), trips_(trips) {}
  std::string ask(const std::string& request, double deadline_s, const char* what) override {
    std::string reply = inner_->ask(request, deadline_s, what);
    trips_.request_bytes = request.size(), trips_.reply_bytes = reply.size();
    return reply;
  }
  void tell(const std::string& request) override { inner_->tell(request); }
  void check_peer() override { inner_->check_peer(); }

 private:
  std::unique_ptr<link::Transport> inner_;
  RoundTrips& trips_;
};

// Every number differs from zero, which would not be sent, and from its neighbour's.
RigidBody fragment(int number) {
  const double s = 1.0 + 1e-3 * number;
  RigidBody b;
  b.id = static_cast<BodyId>(number), b.name = fmt::format("shard_{}", number);
  b.mass = 0.01 * s, b.principal_inertia = Vec3(1e-6, 2e-6, 2.5e-6) * s;
  b.motion = {Vec3(0.1 * s, -0.2 * s, 0.3 + s), Quat(0.8, 0.2 * s, -0.4, 0.3).normalized(),
              Vec3(1.0 * s, -0.5, -3.0 * s), Vec3(1e-6, -2e-6, 3e-6) * s};
  const double a = 5e-3;
  b.shape = ConvexShape{{{{a, a, a}, {-a, -a, a}, {-a, a, -a}, {a, -a, -a}}}};
  return b;
}

bool same(const BodyMotion& a, const BodyMotion& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs() && a.velocity == b.velocity &&
         a.angular_momentum == b.angular_momentum;
}

class Exchange {
 public:
  explicit Exchange(int bodies)
      : engine_({{SUNDER_RIGID, "--engine", "freeflight"}, ""}),
        rigid_(std::make_unique<Weighed>(
                   std::make_unique<link::Channel>(link::Channel::Role::kConnect, engine_.endpoint()), trips_),
               "benchmark") {
    link::World world;
    for (int i = 1; i <= bodies; ++i) {
      world.bodies.push_back(fragment(i));
      task_.predicted.push_back({world.bodies.back().id, world.bodies.back().motion});
    }
    task_.window_s = kWindow;
    rigid_.load(world);
  }

  void windows(int count, bool noted) {
    for (int k = 0; k < count; ++k) {
      for (link::Motion& m : task_.predicted) m.motion.position += kWindow * m.motion.velocity;
      const auto start = std::chrono::steady_clock::now();
      const std::vector<link::State> states = rigid_.window(task_);
      const auto end = std::chrono::steady_clock::now();
      task_.tick += task_.ticks;
      if (noted) trips_.us.push_back(std::chrono::duration<double, std::micro>(end - start).count());
      for (std::size_t i = 0; i < states.size(); ++i)
        ensure(same(states[i].motion, task_.predicted[i].motion), "body {} comes back from free flight another way",
               states[i].id);
    }
  }

  const RoundTrips& trips() const { return trips_; }

  RoundTrips finish() {
    const RoundTrips trips = trips_;  // without Bye
    rigid_.bye();
    const auto status = engine_.wait(kFinish);
    ensure(status == 0, "the engine process ends with status {}: {}", status.value_or(-1), engine_.last_words());
    return trips;
  }

 private:
  conformance::EngineProcess engine_;
  RoundTrips trips_;
  link::RemoteRigid rigid_;
  link::WindowTask task_;
};

// As the channel of a session does.
bool receive_awake(zmq::socket_t& socket, zmq::message_t& message) {
  for (const auto start = std::chrono::steady_clock::now();
       std::chrono::steady_clock::now() - start < std::chrono::duration<double>(link::Channel::kAwakeSeconds);
       sched_yield())
    if (socket.recv(message, zmq::recv_flags::dontwait)) return true;
  return socket.recv(message).has_value();
}

// Says back as many bytes as a reply has, from a thread with sockets of its own.
class Bare {
 public:
  Bare(std::size_t request_bytes, std::size_t reply_bytes, bool awake)
      : awake_(awake), endpoint_("ipc://" + folder_.path + "/bare"), request_(request_bytes, 'q') {
    near_.bind(endpoint_);
    echo_ = std::thread([this, reply = std::string(reply_bytes, 'r')] {
      zmq::context_t context{1};
      zmq::socket_t far{context, zmq::socket_type::pair};
      far.connect(endpoint_);
      zmq::message_t message;
      while (receive(far, message) && message.size() > 0) far.send(zmq::buffer(reply), zmq::send_flags::none);
    });
  }
  ~Bare() {
    near_.send(zmq::message_t(), zmq::send_flags::none);
    echo_.join();
  }
  Bare(const Bare&) = delete;
  Bare& operator=(const Bare&) = delete;

  void windows(int count, std::vector<double>* noted) {
    for (int k = 0; k < count; ++k) {
      zmq::message_t reply;
      const auto start = std::chrono::steady_clock::now();
      near_.send(zmq::buffer(request_), zmq::send_flags::none);
      receive(near_, reply);
      const auto end = std::chrono::steady_clock::now();
      if (noted) noted->push_back(std::chrono::duration<double, std::micro>(end - start).count());
    }
  }

 private:
  bool receive(zmq::socket_t& socket, zmq::message_t& message) const {
    return awake_ ? receive_awake(socket, message) : socket.recv(message).has_value();
  }

  bool awake_;
  TemporaryFolder folder_;
  std::string endpoint_, request_;
  zmq::context_t context_{1};
  zmq::socket_t near_{context_, zmq::socket_type::pair};
  std::thread echo_;
};

// While it is there, this thread, and what it starts, runs on the processor that it is on.
class OneProcessor {
 public:
  OneProcessor() {
    ensure(sched_getaffinity(0, sizeof before_, &before_) == 0, "the system does not say where this may run");
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    ensure(sched_setaffinity(0, sizeof one, &one) == 0, "the system does not let this run on one processor");
  }
  ~OneProcessor() { (void)sched_setaffinity(0, sizeof before_, &before_); }
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;

 private:
  cpu_set_t before_;
};

// Percentiles of all, and beside them those of the calmest and the busiest block: what else the machine did.
void tell(const char* what, const RoundTrips& trips, int bodies, int blocks) {
  fmt::print("{}: {} windows of {} bodies, {} bytes there and {} back, in {} blocks\n", what, trips.us.size(), bodies,
             trips.request_bytes, trips.reply_bytes, blocks);
  const std::size_t size = trips.us.size() / static_cast<std::size_t>(blocks);
  for (const double share : {0.5, 0.99}) {
    std::vector<double> found;
    for (auto at = trips.us.begin(); at != trips.us.end(); at += static_cast<std::ptrdiff_t>(size))
      found.push_back(percentile({at, at + static_cast<std::ptrdiff_t>(size)}, share));
    const auto [least, most] = std::minmax_element(found.begin(), found.end());
    fmt::print("  p{:.0f} {:.1f} us; of a block {:.1f} to {:.1f}\n", 100.0 * share, percentile(trips.us, share), *least,
               *most);
  }
}

void measure(const char* name, int bodies, int blocks, int windows, std::map<std::string, double>& out) {
  const RoundTrips trips = measure_round_trips(bodies, blocks, windows);
  tell(name, trips, bodies, blocks);
  const auto together = [&] {
    const OneProcessor all_threads;
    return measure_round_trips(bodies, blocks, windows);
  }();
  const auto half = [](const std::vector<double>& us) { return percentile(us, 0.5); };
  const std::string key = name;
  out[key + "_p50"] = half(trips.us), out[key + "_bare_p50"] = half(trips.bare_us);
  out[key + "_asleep_p50"] = half(trips.asleep_us), out[key + "_one_processor_p50"] = half(together.us);
  fmt::print(
      "  the same bytes through ZeroMQ alone: p50 {:.1f} us, {:.1f} us asleep; with all threads on one processor: p50 "
      "{:.1f} us, ZeroMQ alone {:.1f} us\n",
      half(trips.bare_us), half(trips.asleep_us), half(together.us), half(together.bare_us));
  if (bodies == kFourKilobytes) out[key + "_p99"] = percentile(trips.us, 0.99);
}

void four_kilobytes(std::map<std::string, double>& out) {
  measure("window_roundtrip_us_4k", kFourKilobytes, 40, 250, out);
}

void many_fragments(std::map<std::string, double>& out) {
  measure("window_roundtrip_us_1000_fragments", kManyFragments, 20, 50, out);
}

}  // namespace

double percentile(std::vector<double> samples, double share) {
  ensure(!samples.empty() && share > 0.0 && share <= 1.0, "percentile {} of {} samples", share, samples.size());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(samples.size())));
  const auto at = samples.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(samples.begin(), at, samples.end());
  return *at;
}

RoundTrips measure_round_trips(int bodies, int blocks, int windows) {
  Exchange exchange(bodies);
  exchange.windows(windows, false);
  std::vector<double> bare_us, asleep_us;
  const std::size_t there = exchange.trips().request_bytes, back = exchange.trips().reply_bytes;
  Bare bare(there, back, true), asleep(there, back, false);
  for (int k = 0; k < blocks; ++k) {
    // who was awake in the block before sleeps again, and who takes part in this one is up
    const auto block = [](auto&& warm, auto&& noted) {
      std::this_thread::sleep_for(kRest);
      warm(), noted();
    };
    block([&] { exchange.windows(kWarm, false); }, [&] { exchange.windows(windows, true); });
    block([&] { bare.windows(kWarm, nullptr); }, [&] { bare.windows(windows, &bare_us); });
    block([&] { asleep.windows(kWarm, nullptr); }, [&] { asleep.windows(windows, &asleep_us); });
  }
  RoundTrips trips = exchange.finish();
  trips.bare_us = std::move(bare_us), trips.asleep_us = std::move(asleep_us);
  return trips;
}

const std::vector<ProcessBenchmark>& process_benchmarks() {
  static const std::vector<ProcessBenchmark> all{
      {"window_roundtrip_us_4k", {"window_roundtrip_us_4k_p50", "window_roundtrip_us_4k_p99"}, four_kilobytes},
      {"window_roundtrip_us_1000_fragments", {"window_roundtrip_us_1000_fragments_p50"}, many_fragments},
      {"process_boundary_overhead", {"process_boundary_overhead_percent"}, measure_process_boundary}};
  return all;
}

}  // namespace sunder::bench
