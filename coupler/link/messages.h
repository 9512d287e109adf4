#pragma once
// Plain types <-> messages. Everything decoded here is checked: finite, sizes, ids, unit quaternions.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "exchange.pb.h"

namespace sunder::link {

constexpr std::uint32_t kProtocol = 1;
constexpr double kQuaternionTolerance = 1e-9;  // off unit length: round-off of a window, no more
constexpr int kMaxBodies = 100000, kMaxParts = 4096, kMaxCorners = 4096;
constexpr std::size_t kMaxMessage = 256u << 20;  // bytes

proto::Vec3 encode(const Vec3& v);
proto::Quaternion encode(const Quat& q);
proto::RigidBody encode(const RigidBody& body);

/// All throw Error(peer_lost status, "bad_message") with the field and the value.
Vec3 decode(const proto::Vec3& v, const std::string& field);
Quat decode(const proto::Quaternion& q, const std::string& field);
RigidBody decode(const proto::RigidBody& body, const std::string& field);
std::vector<ContactLaw> decode_contacts(const proto::Load& load);

}  // namespace sunder::link
