#pragma once
// Converts plain types to messages and back. Decoding checks every value: finite, sizes, ids, unit quaternions.
#include <string>
#include <vector>

#include "coupler/core/body_ids.h"
#include "coupler/core/error.h"
#include "coupler/link/rigid_link.h"
#include "exchange.pb.h"

namespace sunder::link {

constexpr std::uint32_t kProtocol = 2;
constexpr double kQuaternionTolerance = 1e-9;  // deviation from unit length: round-off of a window
constexpr double kNormalTolerance = 1e-6;      // deviation from unit length: single precision is enough for a normal
constexpr int kMaxBodies = 100000, kMaxParts = 65536, kMaxCorners = 4096;
constexpr int kMaxJoints = 100000, kMaxRows = 1000000, kMaxLaws = 1000000;
constexpr double kThinnest = 1e-12, kThickest = 1e6;   // shell thickness [m]
constexpr std::size_t kMaxHash = 256, kMaxWord = 255;  // bytes
constexpr std::size_t kMaxReport = 4096;               // bytes of the other side's error message
constexpr std::size_t kMaxMessage = 256u << 20;        // bytes

proto::Vec3 encode(const Vec3& v);
proto::Quaternion encode(const Quat& q);
proto::RigidBody encode(const RigidBody& body);
proto::Contact encode(const ContactLaw& law);
proto::Joint encode(const Joint& joint);
proto::PredictedState encode(const Motion& motion);
/// The same in place, for messages with many bodies: no copy.
void encode(const Motion& motion, proto::PredictedState* out);
void encode(const ContactRow& row, proto::ContactRow* out);
void encode_states(const std::vector<State>& states, google::protobuf::RepeatedPtrField<proto::BodyState>* out);

/// Throws Error: bad_message, status peer lost.
[[noreturn]] void refuse(const std::string& message);
/// Nanoseconds of this computer's steady clock.
std::int64_t now_ns();

/// All decode functions throw Error (bad_message, status peer lost) with field and value. `field`: path for messages.
Vec3 decode(const proto::Vec3& v, const std::string& field);
Quat decode(const proto::Quaternion& q, const std::string& field);
RigidBody decode(const proto::RigidBody& body, const std::string& field);
World decode(const proto::Load& load);
WindowTask decode(const proto::Window& window);
EngineInfo decode_peer(const proto::HelloReply& hello);
/// The error that the other side, `who`, reports. Its kind is peer_failed where the message names none. The text is cut
/// to kMaxReport bytes and loses control characters, since it goes to the terminal and to run.json.
Error decode_error(const proto::Error& error, const std::string& who);
std::vector<RigidBody> decode_bodies(const google::protobuf::RepeatedPtrField<proto::RigidBody>& bodies,
                                     const std::string& field);
std::vector<Motion> decode_motions(const google::protobuf::RepeatedPtrField<proto::PredictedState>& motions,
                                   const std::string& field);
std::vector<BodyId> decode_ids(const google::protobuf::RepeatedField<std::uint32_t>& ids, const std::string& field);
/// States with exactly one entry for each body in `expected`, by ascending id.
std::vector<State> decode_states(const google::protobuf::RepeatedPtrField<proto::BodyState>& states,
                                 const BodyIds& expected);
/// Contact rows between bodies in `known`.
std::vector<ContactRow> decode_rows(const proto::ExportReply& reply, const BodyIds& known);

}  // namespace sunder::link
