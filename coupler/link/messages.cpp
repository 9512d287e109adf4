#include "coupler/link/messages.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "coupler/core/error.h"

namespace sunder::link {
namespace {

// Path of a field of a body's entry in a list, as "states[id 7].position". It becomes text only in an error, since a
// window has four such fields for every body.
struct Member {
  const char* list;
  std::size_t id;
  const char* field;
};

// The same of an entry that is counted from 0, as "rows[7].normal".
struct Entry {
  std::size_t index;
  const char* field;
};

}  // namespace
}  // namespace sunder::link

template <>
struct fmt::formatter<sunder::link::Member> : fmt::formatter<std::string_view> {
  template <class Context>
  auto format(const sunder::link::Member& m, Context& context) const {
    return fmt::format_to(context.out(), "{}[id {}]{}", m.list, m.id, m.field);
  }
};

template <>
struct fmt::formatter<sunder::link::Entry> : fmt::formatter<std::string_view> {
  template <class Context>
  auto format(const sunder::link::Entry& e, Context& context) const {
    return fmt::format_to(context.out(), "rows[{}]{}", e.index, e.field);
  }
};

namespace sunder::link {
namespace {

template <class... Args>
void check(bool good, fmt::format_string<Args...> format, Args&&... args) {
  if (!good) throw Error(Exit::kPeerLost, "bad_message", fmt::format(format, std::forward<Args>(args)...));
}

// In place, because a separate message would be copied into the arena.
void encode(const Vec3& v, proto::Vec3* m) { m->set_x(v.x()), m->set_y(v.y()), m->set_z(v.z()); }

void encode(const Quat& q, proto::Quaternion* m) { m->set_w(q.w()), m->set_x(q.x()), m->set_y(q.y()), m->set_z(q.z()); }

// Encodes into any message with the four fields of a motion.
template <class Message>
void encode_motion(const BodyMotion& motion, Message* m) {
  encode(motion.position, m->mutable_position()), encode(motion.orientation, m->mutable_orientation());
  encode(motion.velocity, m->mutable_velocity());
  encode(motion.angular_momentum, m->mutable_angular_momentum());
}

template <class Field>
Vec3 decode_vector(const proto::Vec3& v, const Field& field) {
  const Vec3 r(v.x(), v.y(), v.z());
  check(r.allFinite(), "{} is ({}, {}, {}): not finite", field, v.x(), v.y(), v.z());
  return r;
}

template <class Field>
Quat decode_quaternion(const proto::Quaternion& q, const Field& field) {
  const Quat r(q.w(), q.x(), q.y(), q.z());
  check(r.coeffs().allFinite() && std::abs(r.norm() - 1.0) < kQuaternionTolerance,
        "{} is ({}, {}, {}, {}): not of unit length", field, q.w(), q.x(), q.y(), q.z());
  return r;
}

// Decodes an entry of `list`, which errors name by its id.
template <class Message>
BodyMotion decode_motion(const Message& m, const char* list) {
  const auto field = [&](const char* name) { return Member{list, m.id(), name}; };
  BodyMotion motion;
  motion.position = decode_vector(m.position(), field(".position"));
  motion.orientation = decode_quaternion(m.orientation(), field(".orientation"));
  motion.velocity = decode_vector(m.velocity(), field(".velocity"));
  motion.angular_momentum = decode_vector(m.angular_momentum(), field(".angular_momentum"));
  return motion;
}

}  // namespace

void refuse(const std::string& message) { throw Error(Exit::kPeerLost, "bad_message", message); }

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

proto::Vec3 encode(const Vec3& v) {
  proto::Vec3 m;
  encode(v, &m);
  return m;
}

proto::Quaternion encode(const Quat& q) {
  proto::Quaternion m;
  encode(q, &m);
  return m;
}

proto::RigidBody encode(const RigidBody& b) {
  proto::RigidBody m;
  m.set_id(b.id), m.set_name(b.name), m.set_is_static(b.is_static), m.set_mass(b.mass);
  *m.mutable_principal_inertia() = encode(b.principal_inertia);
  *m.mutable_position() = encode(b.motion.position);
  *m.mutable_orientation() = encode(b.motion.orientation);
  *m.mutable_velocity() = encode(b.motion.velocity);
  *m.mutable_angular_momentum() = encode(b.motion.angular_momentum);
  m.set_contact_group(b.contact_group);
  if (const auto* s = std::get_if<SphereShape>(&b.shape)) m.set_sphere_radius_m(s->radius);
  if (const auto* s = std::get_if<BoxShape>(&b.shape)) *m.mutable_box_half_size_m() = encode(s->half_size);
  if (std::holds_alternative<HalfSpaceShape>(b.shape)) m.set_half_space(true);
  if (const auto* s = std::get_if<ConvexShape>(&b.shape))
    for (const auto& part : s->parts) {
      auto* p = m.mutable_convex()->add_parts();
      for (const Vec3& c : part)
        for (int d = 0; d < 3; ++d) p->add_corners(c[d]);
    }
  return m;
}

Vec3 decode(const proto::Vec3& v, const std::string& field) { return decode_vector(v, field); }

Quat decode(const proto::Quaternion& q, const std::string& field) { return decode_quaternion(q, field); }

RigidBody decode(const proto::RigidBody& m, const std::string& field) {
  RigidBody b;
  b.id = m.id(), b.name = m.name(), b.is_static = m.is_static(), b.mass = m.mass();
  check(b.id != 0, "{}.id is 0; ids start at 1", field);
  check(b.name.size() <= kMaxWord, "{}.name has {} bytes; {} at most", field, b.name.size(), kMaxWord);
  b.principal_inertia = decode(m.principal_inertia(), field + ".principal_inertia");
  if (!b.is_static)
    check(std::isfinite(b.mass) && b.mass > 0.0 && b.principal_inertia.minCoeff() > 0.0,
          "{}: mass {} and inertia must be positive", field, b.mass);
  b.motion.position = decode(m.position(), field + ".position");
  b.motion.orientation = decode(m.orientation(), field + ".orientation");
  b.motion.velocity = decode(m.velocity(), field + ".velocity");
  b.motion.angular_momentum = decode(m.angular_momentum(), field + ".angular_momentum");
  b.contact_group = m.contact_group();
  switch (m.shape_case()) {
    case proto::RigidBody::kSphereRadiusM:
      check(std::isfinite(m.sphere_radius_m()) && m.sphere_radius_m() > 0.0, "{}.sphere_radius_m is {}", field,
            m.sphere_radius_m());
      b.shape = SphereShape{m.sphere_radius_m()};
      break;
    case proto::RigidBody::kBoxHalfSizeM: {
      const Vec3 half = decode(m.box_half_size_m(), field + ".box_half_size_m");
      check(half.minCoeff() > 0.0, "{}.box_half_size_m must be positive", field);
      b.shape = BoxShape{half};
      break;
    }
    case proto::RigidBody::kHalfSpace:
      b.shape = HalfSpaceShape{};
      break;
    case proto::RigidBody::kConvex: {
      ConvexShape shape;
      check(m.convex().parts_size() >= 1 && m.convex().parts_size() <= kMaxParts, "{}.convex has {} parts", field,
            m.convex().parts_size());
      for (const auto& part : m.convex().parts()) {
        check(part.corners_size() % 3 == 0 && part.corners_size() >= 12 && part.corners_size() <= 3 * kMaxCorners,
              "{}.convex: {} coordinates in a part", field, part.corners_size());
        auto& corners = shape.parts.emplace_back();
        for (int i = 0; i < part.corners_size(); i += 3) {
          corners.emplace_back(part.corners(i), part.corners(i + 1), part.corners(i + 2));
          check(corners.back().allFinite(), "{}.convex: a corner is not finite", field);
        }
      }
      b.shape = std::move(shape);
      break;
    }
    default:
      check(false, "{} has no shape", field);
  }
  return b;
}

proto::Contact encode(const ContactLaw& law) {
  proto::Contact m;
  m.set_first_group(law.first_group), m.set_second_group(law.second_group);
  m.set_friction(law.friction), m.set_restitution(law.restitution);
  return m;
}

proto::Joint encode(const Joint& j) {
  proto::Joint m;
  m.set_id(j.id), m.set_name(j.name), m.set_first(j.first), m.set_second(j.second);
  m.set_kind(static_cast<proto::Joint::Kind>(static_cast<int>(j.kind) + 1));
  const auto frame = [](const Joint::Frame& f, proto::Pose* pose) {
    *pose->mutable_position() = encode(f.position), *pose->mutable_orientation() = encode(f.orientation);
  };
  frame(j.first_frame, m.mutable_first_frame()), frame(j.second_frame, m.mutable_second_frame());
  return m;
}

void encode(const Motion& motion, proto::PredictedState* out) {
  out->set_id(motion.id);
  encode_motion(motion.motion, out);
}

proto::PredictedState encode(const Motion& motion) {
  proto::PredictedState h;
  encode(motion, &h);
  return h;
}

void encode(const ContactRow& row, proto::ContactRow* out) {
  out->set_first(row.first), out->set_second(row.second);
  encode(row.first_point, out->mutable_first_point()), encode(row.second_point, out->mutable_second_point());
  encode(row.normal, out->mutable_normal());
  out->set_friction(row.friction), out->set_restitution(row.restitution), out->set_allowance_m(row.allowance);
}

void encode_states(const std::vector<State>& states, google::protobuf::RepeatedPtrField<proto::BodyState>* out) {
  out->Reserve(static_cast<int>(states.size()));
  for (const State& s : states) {
    auto* m = out->Add();
    m->set_id(s.id), m->set_mass(s.mass);
    encode_motion(s.motion, m);
  }
}

namespace {

template <class Field>
void check_coefficients(double friction, double restitution, const Field& field) {
  check(std::isfinite(friction) && friction >= 0.0, "{}.friction is {}", field, friction);
  check(restitution >= 0.0 && restitution <= 1.0, "{}.restitution is {}", field, restitution);
}

Joint decode_joint(const proto::Joint& m, const std::string& field) {
  Joint j;
  j.id = m.id(), j.name = m.name(), j.first = m.first(), j.second = m.second();
  check(j.id != 0 && j.first != 0, "{}: joint {} of body {}; ids start at 1", field, j.id, j.first);
  check(j.name.size() <= kMaxWord, "{}.name has {} bytes; {} at most", field, j.name.size(), kMaxWord);
  check(m.kind() >= proto::Joint::BALL && m.kind() <= proto::Joint::FIXED, "{}.kind is {}", field,
        static_cast<int>(m.kind()));
  j.kind = static_cast<Joint::Kind>(static_cast<int>(m.kind()) - 1);
  const auto frame = [&](const proto::Pose& pose, const char* name) {
    return Joint::Frame{decode(pose.position(), field + name), decode(pose.orientation(), field + name)};
  };
  j.first_frame = frame(m.first_frame(), ".first_frame"), j.second_frame = frame(m.second_frame(), ".second_frame");
  return j;
}

}  // namespace

std::vector<RigidBody> decode_bodies(const google::protobuf::RepeatedPtrField<proto::RigidBody>& bodies,
                                     const std::string& field) {
  check(bodies.size() <= kMaxBodies, "{}: {} bodies; {} at most", field, bodies.size(), kMaxBodies);
  std::vector<RigidBody> out;
  for (const auto& b : bodies) out.push_back(decode(b, fmt::format("{}[{}]", field, b.id())));
  return out;
}

World decode(const proto::Load& load) {
  World world;
  world.bodies = decode_bodies(load.bodies(), "bodies");
  check(load.contacts_size() <= kMaxLaws, "contacts: {} of them; {} at most", load.contacts_size(), kMaxLaws);
  for (const auto& c : load.contacts()) {
    check_coefficients(c.friction(), c.restitution(), "contacts");
    world.laws.push_back({c.first_group(), c.second_group(), c.friction(), c.restitution()});
  }
  check(load.joints_size() <= kMaxJoints, "joints: {} of them; {} at most", load.joints_size(), kMaxJoints);
  for (const auto& j : load.joints()) world.joints.push_back(decode_joint(j, fmt::format("joints[{}]", j.id())));
  world.tick = load.tick(), world.keep_windows = load.keep_windows();
  const double thickness = load.thickness_m();
  check(thickness == 0.0 || (thickness >= kThinnest && thickness <= kThickest), "thickness_m is {}; {:g} to {:g}, or 0",
        thickness, kThinnest, kThickest);
  world.thickness = thickness;
  return world;
}

std::vector<Motion> decode_motions(const google::protobuf::RepeatedPtrField<proto::PredictedState>& motions,
                                   const std::string& field) {
  check(motions.size() <= kMaxBodies, "{}: {} bodies; {} at most", field, motions.size(), kMaxBodies);
  std::vector<Motion> out;
  out.reserve(static_cast<std::size_t>(motions.size()));
  for (const auto& h : motions) {
    check(out.empty() || h.id() > out.back().id, "{}: twice, or out of order", Member{field.c_str(), h.id(), ""});
    out.push_back({h.id(), decode_motion(h, field.c_str())});
  }
  return out;
}

std::vector<std::uint32_t> decode_ids(const google::protobuf::RepeatedField<std::uint32_t>& ids,
                                      const std::string& field) {
  check(ids.size() <= kMaxBodies, "{}: {} of them; {} at most", field, ids.size(), kMaxBodies);
  for (int i = 1; i < ids.size(); ++i) check(ids[i] > ids[i - 1], "{}: {} comes twice, or out of order", field, ids[i]);
  return {ids.begin(), ids.end()};
}

WindowTask decode(const proto::Window& w) {
  WindowTask task;
  task.tick = w.tick(), task.ticks = w.ticks(), task.window_s = w.window_s(), task.again = w.again();
  task.predicted = decode_motions(w.predicted(), "predicted");
  task.solved = decode_ids(w.solved(), "solved");
  task.released = decode_ids(w.released(), "released");
  task.births = decode_bodies(w.births(), "births");
  return task;
}

EngineInfo decode_peer(const proto::HelloReply& hello) {
  const auto plain = [](const std::string& word) {  // printed and written into reports, so no control characters
    return std::all_of(word.begin(), word.end(),
                       [](unsigned char c) { return c >= 0x20 && c < 0x7f && c != '"' && c != '\\'; });
  };
  check(plain(hello.engine_name()) && plain(hello.engine_version()), "hello: name or version is no plain text");
  check(!hello.engine_name().empty() && hello.engine_name().size() <= kMaxWord, "hello.engine_name has {} bytes",
        hello.engine_name().size());
  check(hello.engine_version().size() <= kMaxWord, "hello.engine_version has {} bytes", hello.engine_version().size());
  check(hello.capabilities_size() <= static_cast<int>(kMaxWord), "hello has {} capabilities",
        hello.capabilities_size());
  EngineInfo info{hello.engine_name(), hello.engine_version(), {}};
  for (const std::string& word : hello.capabilities()) {
    check(!word.empty() && plain(word) && word.size() <= kMaxWord, "hello.capabilities: a word of {} bytes",
          word.size());
    info.capabilities.push_back(word);
  }
  return info;
}

Error decode_error(const proto::Error& error, const std::string& who) {
  const std::string& kind = error.kind();
  const bool named = !kind.empty() && kind.size() <= kMaxWord && std::all_of(kind.begin(), kind.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  const std::string& whole = error.message();
  std::size_t size = std::min(whole.size(), kMaxReport);
  while (size > 0 && size < whole.size() && (whole[size] & 0xc0) == 0x80) --size;  // keep UTF-8 characters whole
  std::string message = whole.substr(0, size);
  for (char& c : message)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n') c = ' ';  // no control of the terminal
  Error told(Exit::kPeerLost, named ? kind : "peer_failed", who + " reports: " + message);
  if (error.body() != 0) told.body = std::to_string(error.body());
  return told;
}

namespace {

// Refuses states that are not one of each expected body by ascending id. Names the bodies that are missing, the surplus
// ones and those out of order.
void check_ids(const google::protobuf::RepeatedPtrField<proto::BodyState>& states, const BodyIds& expected) {
  constexpr std::size_t kMostNamed = 9;
  std::vector<BodyId> came, surplus, twice, unordered, missing;
  for (const auto& m : states) {
    if (!expected.contains(m.id())) surplus.push_back(m.id());
    if (!came.empty() && m.id() < came.back()) unordered.push_back(m.id());
    came.push_back(m.id());
  }
  std::sort(came.begin(), came.end());
  for (std::size_t i = 1; i < came.size(); ++i)
    if (came[i] == came[i - 1] && (twice.empty() || twice.back() != came[i])) twice.push_back(came[i]);
  for (const BodyId id : expected)
    if (!std::binary_search(came.begin(), came.end(), id)) missing.push_back(id);
  std::string found;
  BodyId first = 0;
  const auto tell = [&](const char* what, std::vector<BodyId>& ids) {
    if (ids.empty()) return;
    if (first == 0) first = ids.front();
    const std::size_t more = ids.size() - std::min(ids.size(), kMostNamed);
    ids.resize(ids.size() - more);
    found += fmt::format("; {} {}{}", what, fmt::join(ids, ", "), more ? fmt::format(" and {} more", more) : "");
  };
  tell("missing: id", missing), tell("surplus: id", surplus), tell("twice: id", twice);
  if (found.empty()) tell("out of order: id", unordered);
  if (found.empty()) return;
  Error e(Exit::kPeerLost, "bad_message",
          fmt::format("states: {} for {} bodies{}; give one of each that moves, by ascending id", states.size(),
                      expected.size(), found));
  e.body = std::to_string(first);
  throw e;
}

}  // namespace

std::vector<State> decode_states(const google::protobuf::RepeatedPtrField<proto::BodyState>& states,
                                 const BodyIds& expected) {
  std::vector<State> out;
  out.reserve(expected.size());
  auto next = expected.begin();
  BodyId of = 0;
  try {
    for (const auto& m : states) {
      of = m.id();
      if (next == expected.end() || *next != of) check_ids(states, expected);
      ++next;
      check(std::isfinite(m.mass()) && m.mass() > 0.0, "{} is {}", Member{"states", of, ".mass"}, m.mass());
      out.push_back({of, m.mass(), decode_motion(m, "states")});
    }
    if (next != expected.end()) check_ids(states, expected);
  } catch (Error& e) {
    if (e.body.empty()) e.body = std::to_string(of);
    throw;
  }
  return out;
}

std::vector<ContactRow> decode_rows(const proto::ExportReply& reply, const BodyIds& known) {
  check(reply.rows_size() <= kMaxRows, "rows: {} of them; {} at most", reply.rows_size(), kMaxRows);
  std::vector<ContactRow> out;
  for (const auto& m : reply.rows()) {
    const auto name = [&](const char* of) { return Entry{out.size(), of}; };
    const Entry field = name("");
    check(known.contains(m.first()) && known.contains(m.second()) && m.first() != m.second(), "{}: bodies {} and {}",
          field, m.first(), m.second());
    ContactRow row{m.first(),
                   m.second(),
                   decode_vector(m.first_point(), name(".first_point")),
                   decode_vector(m.second_point(), name(".second_point")),
                   decode_vector(m.normal(), name(".normal")),
                   m.friction(),
                   m.restitution(),
                   m.allowance_m()};
    check(std::abs(row.normal.norm() - 1.0) < kNormalTolerance, "{}.normal has length {}, must be 1", field,
          row.normal.norm());
    check_coefficients(row.friction, row.restitution, field);
    check(std::isfinite(row.allowance) && row.allowance >= 0.0, "{}.allowance_m is {}", field, row.allowance);
    out.push_back(std::move(row));
  }
  return out;
}

}  // namespace sunder::link
