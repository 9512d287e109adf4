#include "tests/fuzz/samples.h"

#include "coupler/link/messages.h"

namespace sunder::fuzz {

std::vector<RigidBody> sample_bodies() {
  std::vector<RigidBody> bodies(4);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    RigidBody& b = bodies[i];
    b.id = static_cast<BodyId>(i + 1), b.name = std::string("b"), b.mass = 1.0, b.principal_inertia = {0.1, 0.2, 0.25};
    b.motion.position = {0, 0, 0.5 * static_cast<double>(i)};
    b.contact_group = static_cast<std::uint32_t>(i);
  }
  bodies[0].shape = SphereShape{0.1};
  bodies[1].shape = BoxShape{{0.1, 0.2, 0.3}};
  const std::vector<Vec3> part{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  bodies[2].shape = ConvexShape{{part, part}};
  bodies[3].shape = HalfSpaceShape{}, bodies[3].is_static = true, bodies[3].mass = 0.0;
  return bodies;
}

static std::vector<proto::Request> make_requests() {
  std::vector<proto::Request> all(10);
  auto* hello = all[0].mutable_hello();
  hello->set_protocol_min(link::kProtocol), hello->set_protocol_max(link::kProtocol);
  hello->set_scene_hash(kSceneHash);
  auto* load = all[1].mutable_load();
  for (const RigidBody& b : sample_bodies()) *load->add_bodies() = link::encode(b);
  *load->add_contacts() = link::encode(ContactLaw{0, 1, 0.5, 0.1});
  load->set_keep_windows(false);
  auto* window = all[2].mutable_window();
  window->set_ticks(1), window->set_window_s(1e-3);
  auto* rows = all[3].mutable_export_();
  rows->set_window_s(1e-3);
  for (const RigidBody& b : sample_bodies()) {
    if (b.is_static) continue;
    *window->add_predicted() = link::encode(link::Motion{b.id, b.motion});
    *rows->add_motions() = link::encode(link::Motion{b.id, b.motion});
    rows->add_bodies(b.id);
  }
  window->add_solved(1);
  RigidBody born = sample_bodies()[2];
  born.id = 101;
  all[4] = all[2];
  *all[4].mutable_window()->add_births() = link::encode(born);
  born.id = 102;
  *all[5].mutable_add_bodies()->add_bodies() = link::encode(born);
  all[6].mutable_save();
  all[7].mutable_restore()->set_caches("");
  all[8].mutable_bye();
  all[9].mutable_error()->set_kind("unstable"), all[9].mutable_error()->set_message("the energy has changed");
  return all;
}

const std::vector<proto::Request>& sample_requests() {
  static const std::vector<proto::Request> all = make_requests();
  return all;
}

const std::vector<std::string>& opening(int state) {
  static const std::vector<std::vector<std::string>> all = [] {
    std::vector<proto::Request> samples = sample_requests();
    samples[0].set_sequence(1), samples[1].set_sequence(2);
    const std::string hello = samples[0].SerializeAsString(), load = samples[1].SerializeAsString();
    return std::vector<std::vector<std::string>>{{}, {hello}, {hello, load}};
  }();
  return all[static_cast<std::size_t>(state)];
}

Requests split(const std::string& bytes) {
  Requests out;
  if (bytes.empty()) return out;
  out.state = static_cast<unsigned char>(bytes[0]) % 3;
  for (std::size_t at = 1; at + 2 <= bytes.size();) {
    const std::size_t size = static_cast<unsigned char>(bytes[at]) | static_cast<unsigned char>(bytes[at + 1]) << 8;
    out.list.push_back(bytes.substr(at + 2, size));  // what there is of it
    at += 2 + size;
  }
  return out;
}

std::string join(const Requests& requests) {
  std::string out(1, static_cast<char>(requests.state));
  for (const std::string& r : requests.list) {
    const std::size_t size = std::min<std::size_t>(r.size(), 0xffff);
    out += static_cast<char>(size & 0xff), out += static_cast<char>(size >> 8);
    out.append(r, 0, size);
  }
  return out;
}

proto::Request::KindCase answered(std::uint8_t number) {
  constexpr proto::Request::KindCase kinds[] = {
      proto::Request::kHello,  proto::Request::kLoad,      proto::Request::kRestore, proto::Request::kExport,
      proto::Request::kWindow, proto::Request::kAddBodies, proto::Request::kSave,    proto::Request::kBye};
  return kinds[number % std::size(kinds)];
}

}  // namespace sunder::fuzz
