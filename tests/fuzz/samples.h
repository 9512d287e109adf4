#pragma once
// Requests as they should be, from which mutations start.
#include <string>
#include <vector>

#include "coupler/core/body.h"
#include "exchange.pb.h"

namespace sunder::fuzz {

inline const std::string kSceneHash = "hash of the scene";
constexpr std::size_t kMovingSamples = 3;

/// A sphere, a box, a shard of two parts; a floor that is static.
std::vector<RigidBody> sample_bodies();

/// An input of the session: how far it is before, and the requests that follow.
struct Requests {
  int state = 0;  // 0 new, 1 greeted, 2 loaded
  std::vector<std::string> list;
};
/// First byte: the state; then requests, each with its length in two bytes before it. Any bytes are an input.
Requests split(const std::string& bytes);
std::string join(const Requests& requests);
/// What is said before, sequence numbers from 1.
const std::vector<std::string>& opening(int state);
/// One good request of every kind, for a loaded session at tick 0.
const std::vector<proto::Request>& sample_requests();
/// The kind of request that a number stands for.
proto::Request::KindCase answered(std::uint8_t number);

}  // namespace sunder::fuzz
