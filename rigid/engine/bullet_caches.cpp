#include "rigid/engine/bullet_caches.h"

#include <cmath>
#include <cstring>

#include "coupler/core/error.h"
#include "coupler/core/hash.h"

namespace sunder::rigid {
namespace {

// Layout, in the byte order of the machine: kMagic, kVersion (u32), three lists (encode_caches), and the SHA-256 of all
// this in hexadecimal. A list is its length (u32) and its entries.
constexpr char kMagic[] = "sunder bullet caches";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kDigest = 64;  // [bytes]

[[noreturn]] void refuse(const std::string& what) {
  throw Error(Exit::kBadInput, "bad_state", "caches for bullet: " + what + "; give what save() returned, unchanged");
}

std::string digest(const std::string& bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

class Writer {
 public:
  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic_v<Number>);
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }
  void put_size(std::size_t size) { put(static_cast<std::uint32_t>(size)); }

  std::string bytes;
};

class Reader {
 public:
  Reader(const std::string& bytes, std::size_t begin, std::size_t end) : bytes_(bytes), at_(begin), end_(end) {}

  template <class Number>
  Number get() {
    if (end_ - at_ < sizeof(Number)) refuse("they end too early");
    Number number;
    std::memcpy(&number, bytes_.data() + at_, sizeof(number));
    at_ += sizeof(number);
    return number;
  }
  /// Length of a list whose entries take `entry` bytes each. Refuses lengths that the rest of the bytes cannot hold.
  std::size_t get_size(std::size_t entry) {
    const std::size_t size = get<std::uint32_t>();
    if (size > (end_ - at_) / entry) refuse(fmt::format("a list of {} entries does not fit in", size));
    return size;
  }
  double get_finite() {
    const double number = get<double>();
    if (!std::isfinite(number)) refuse("a number is not finite");
    return number;
  }
  bool at_end() const { return at_ == end_; }

 private:
  const std::string& bytes_;
  std::size_t at_, end_;
};

}  // namespace

std::string encode_caches(const WorldMemory& memory) {
  Writer out;
  out.bytes = kMagic;
  out.put(kVersion);
  out.put_size(memory.newborn.size());
  for (const auto& [id, newborn] : memory.newborn) out.put(id), out.put(static_cast<std::uint8_t>(newborn));
  out.put_size(memory.allowances.size());
  for (const auto& [pair, allowance] : memory.allowances) out.put(pair.first), out.put(pair.second), out.put(allowance);
  out.put_size(memory.joints.size());
  for (const auto& [id, impulses] : memory.joints) {
    out.put(id);
    for (const JointImpulse& stage : impulses)
      for (const double impulse : stage) out.put(impulse);
  }
  return out.bytes + digest(out.bytes);
}

WorldMemory decode_caches(const std::string& bytes) {
  const std::size_t start = sizeof(kMagic) - 1;
  if (bytes.size() < start + sizeof(kVersion) + kDigest || bytes.compare(0, start, kMagic) != 0)
    refuse(fmt::format("{} bytes that are none", bytes.size()));
  const std::size_t end = bytes.size() - kDigest;
  Reader in(bytes, start, end);
  const auto version = in.get<std::uint32_t>();
  if (version != kVersion) refuse(fmt::format("version {}, {} is read here", version, kVersion));
  if (bytes.substr(end) != digest(bytes.substr(0, end))) refuse("they have been changed");

  WorldMemory memory;
  for (std::size_t left = in.get_size(5); left > 0; --left) {
    const auto id = in.get<BodyId>();
    const auto newborn = in.get<std::uint8_t>();
    if (id == 0 || newborn > 1 || !memory.newborn.emplace(id, newborn == 1).second) refuse(fmt::format("body {}", id));
  }
  for (std::size_t left = in.get_size(16); left > 0; --left) {
    BodyPair pair;
    pair.first = in.get<BodyId>(), pair.second = in.get<BodyId>();
    const double allowance = in.get_finite();
    if (pair.first >= pair.second || !memory.newborn.count(pair.first) || !memory.newborn.count(pair.second) ||
        !(allowance > 0.0) || !memory.allowances.emplace(pair, allowance).second)
      refuse(fmt::format("overlap {} of bodies {} and {}", allowance, pair.first, pair.second));
  }
  for (std::size_t left = in.get_size(4 + 12 * sizeof(double)); left > 0; --left) {
    const auto id = in.get<std::uint32_t>();
    std::array<JointImpulse, 2> impulses;
    for (JointImpulse& stage : impulses)
      for (double& impulse : stage) impulse = in.get_finite();
    if (id == 0 || !memory.joints.emplace(id, impulses).second) refuse(fmt::format("joint {}", id));
  }
  if (!in.at_end()) refuse("there is more than they should hold");
  return memory;
}

}  // namespace sunder::rigid
