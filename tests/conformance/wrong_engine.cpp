// wrong-engine: an engine with one fault, to show that the suite finds it. Without a fault it behaves as its base
// engine.
#include <chrono>
#include <cstdio>
#include <map>
#include <set>
#include <thread>

#include <sys/prctl.h>

#include <csignal>

#include "coupler/core/command_line.h"
#include "coupler/link/channel.h"
#include "coupler/link/session.h"
#include "exchange.pb.h"
#include "rigid/engine/engine.h"

namespace {

using namespace sunder;
using namespace sunder::link;

const std::set<std::string> kFaults = {"none",     "leaks",    "bouncy",   "stale",     "hovers",   "slippery",
                                       "sticky",   "sieve",    "random",   "forgetful", "unhinged", "rowless",
                                       "flipped",  "meddling", "polite",   "lingers",   "late",     "twists",
                                       "clinging", "echoes",   "misspells"};

class WrongEngine final : public Engine {
 public:
  WrongEngine(const std::string& base, std::string fault)
      : inner_(rigid::make_engine(base)), fault_(std::move(fault)) {}

  EngineInfo info() const override {
    EngineInfo info = inner_->info();
    const auto declare = [&](const char* word) {
      if (!info.can(word)) info.capabilities.push_back(word);
    };
    if (fault_ == "sieve")
      for (const char* word : {capability::kContact, capability::kFriction, capability::kRestitution}) declare(word);
    if (fault_ == "misspells") declare("compond");
    if (fault_ == "unhinged") declare(capability::kJoints);
    declare(capability::kExportRows);
    return info;
  }

  void add(const RigidBody& body) override {
    bodies_[body.id] = body;
    RigidBody held = body;
    if (auto* box = std::get_if<BoxShape>(&held.shape); box && fault_ == "hovers") box->half_size.array() += 1e-3;
    if (auto* ball = std::get_if<SphereShape>(&held.shape); ball && fault_ == "hovers") ball->radius += 1e-3;
    if (fault_ == "late" && advanced_) held.motion.velocity *= 1.0 + 1e-6;
    inner_->add(held);
  }

  void set_contact_laws(const std::vector<ContactLaw>& laws) override {
    std::vector<ContactLaw> changed = laws_ = laws;
    for (ContactLaw& law : changed) {
      if (fault_ == "slippery") law.friction *= 0.85;
      if (fault_ == "sticky") law.restitution = 0.0;
    }
    inner_->set_contact_laws(changed);
  }

  void advance(double window_s, const std::vector<Motion>& predicted, const std::vector<BodyId>& solved) override {
    if (fault_ == "stale") before_ = inner_->states();
    inner_->advance(window_s, predicted, fault_ == "meddling" ? std::vector<BodyId>{} : solved);
    predicted_.clear();
    for (const Motion& m : predicted) predicted_[m.id] = m.motion;
    // A correct engine leaves a solved body in its predicted state.
    solved_ = fault_ == "meddling" ? std::set<BodyId>{} : std::set<BodyId>(solved.begin(), solved.end());
    ++advanced_;
  }

  std::vector<State> states() const override {
    if (fault_ == "stale" && !before_.empty()) return before_;
    std::vector<State> out = inner_->states();
    for (State& s : out) {
      const auto given = predicted_.find(s.id);
      if (given == predicted_.end()) continue;
      BodyMotion& m = s.motion;
      if (solved_.count(s.id)) m = given->second;
      const Vec3 change = m.velocity - given->second.velocity;
      if (fault_ == "leaks" && change.norm() > 0.0) m.velocity *= 1.0 - 1e-6;
      if (fault_ == "twists" && change.norm() > 0.0) m.angular_momentum *= 1.0 + 1e-6;
      if (fault_ == "bouncy") m.velocity += 1.2 * change;
      if (fault_ == "forgetful") m.velocity.x() += 1e-9 * static_cast<double>(advanced_ % 7);
      if (fault_ == "random")
        m.velocity.x() += 1e-12 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch().count() % 89);
    }
    return out;
  }

  void add_joint(const Joint& joint) override {
    if (fault_ != "unhinged") inner_->add_joint(joint);
  }
  void release_joint(std::uint32_t id) override {
    if (fault_ != "clinging") inner_->release_joint(id);
  }

  /// Rows for boxes with their lower face on the plane z = 0 of body 1.
  std::vector<ContactRow> rows(double, const std::vector<Motion>&, const std::vector<BodyId>& ids) override {
    std::vector<ContactRow> out;
    for (const BodyId id : ids) {
      const auto* box = std::get_if<BoxShape>(&bodies_.at(id).shape);
      if (!box || fault_ == "rowless") continue;
      for (const auto& [x, y] : {std::pair{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
        const Vec3 corner = box->half_size.cwiseProduct(Vec3(x, y, -1)), &place = bodies_.at(id).motion.position;
        const Vec3 on_floor(corner.x() + place.x(), corner.y() + place.y(), 0.0);
        const Vec3 normal = fault_ == "flipped" ? Vec3(0, 0, -1) : Vec3(0, 0, 1);
        out.push_back({id, 1, corner, on_floor, normal, laws_[0].friction, laws_[0].restitution, 0.0});
      }
    }
    return out;
  }

  std::string save() override { return inner_->save(); }
  void restore(const std::string& caches, const std::vector<Motion>& motions) override {
    inner_->restore(caches, motions);
  }

 private:
  std::unique_ptr<Engine> inner_;
  std::string fault_;
  std::map<BodyId, RigidBody> bodies_;
  std::vector<ContactLaw> laws_;
  std::map<BodyId, BodyMotion> predicted_;
  std::set<BodyId> solved_;
  std::vector<State> before_;
  long advanced_ = 0;
};

/// As serve(), but a reply has the request's sequence, also where another one was due.
void serve_echoing(const std::string& endpoint, Engine& engine) {
  Channel channel(Channel::Role::kBind, endpoint);
  Session session(engine);
  while (!session.over()) {
    const std::string bytes = channel.receive(30.0);
    proto::Request request;
    proto::Reply reply;
    request.ParseFromString(bytes), reply.ParseFromString(session.answer(bytes));
    reply.set_sequence(request.sequence());
    channel.send(reply.SerializeAsString());
  }
  channel.wait_for_close();
  session.rethrow();
}

}  // namespace

int main(int argc, char** argv) {
  std::string base = "bullet", fault = "none", endpoint;
  bool die_with_parent = false;
  CLI::App app("An engine with one fault.", "wrong-engine");
  app.add_option("--base", base, "The engine that it behaves as otherwise")->type_name("NAME");
  app.add_option("--fault", fault, "What it does wrong")->check(CLI::IsMember(kFaults));
  app.add_option("--endpoint", endpoint, "Where the client connects")->type_name("ADDRESS")->required();
  app.add_flag("--die-with-parent", die_with_parent, "Ends when the process that started this one does");
  int status = 0;
  try {
    if (!read_arguments(app, argc, argv)) return 0;
    if (die_with_parent) prctl(PR_SET_PDEATHSIG, SIGTERM);
    WrongEngine engine(base, fault);
    fault == "echoes" ? serve_echoing(endpoint, engine) : serve(endpoint, engine);
  } catch (const Error& e) {
    fmt::print(stderr, "wrong-engine: {}\n", e.what());
    status = static_cast<int>(e.status);
  }
  if (fault == "lingers") std::this_thread::sleep_for(std::chrono::seconds(3));
  return fault == "polite" ? 0 : status;
}
