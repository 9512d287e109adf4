// Mutations that keep a message a message: most flipped bits only break its lengths.
#include <limits>
#include <random>

#include "coupler/link/messages.h"
#include "tests/fuzz/samples.h"
#include "tests/fuzz/targets.h"

namespace sunder::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;
using Random = std::minstd_rand;

template <class T, std::size_t N>
T pick(const T (&from)[N], Random& random) {
  return from[random() % N];
}

double number(double was, Random& random) {
  using limits = std::numeric_limits<double>;
  constexpr double kOdd[] = {0.0,
                             -0.0,
                             1.0,
                             -1.0,
                             1e-9,
                             1e9,
                             1e154,
                             -1e300,
                             limits::max(),
                             limits::min(),
                             limits::denorm_min(),
                             limits::infinity(),
                             -limits::infinity(),
                             limits::quiet_NaN()};
  constexpr double kFactors[] = {-1.0, 0.5, 2.0, 1.0 + 1e-10, 1e3, 1e-3};
  return random() % 2 ? pick(kOdd, random) : was * pick(kFactors, random);
}

std::uint64_t integer(std::uint64_t was, Random& random) {
  constexpr std::uint64_t kOdd[] = {0, 1, 2, 3, 4, 101, 102, 0x7fffffff, 0x80000000, 0xffffffff, 1ull << 63, ~0ull};
  constexpr std::uint64_t kSteps[] = {1, ~0ull, 2};
  return random() % 2 ? pick(kOdd, random) : was + pick(kSteps, random);
}

std::string text(std::string was, Random& random) {
  constexpr std::size_t kSizes[] = {0, 1, 255, 256, 257, 1000};
  if (random() % 2 || was.empty()) return std::string(pick(kSizes, random), 'a');
  was[random() % was.size()] = static_cast<char>(random() % 128);  // proto3 refuses what is not UTF-8 by itself
  return was;
}

void change_scalar(Message& m, const FieldDescriptor* f, int index, Random& random) {
  const Reflection* r = m.GetReflection();
  const bool one = index >= 0;  // of a repeated field
  switch (f->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      one ? r->SetRepeatedDouble(&m, f, index, number(r->GetRepeatedDouble(m, f, index), random))
          : r->SetDouble(&m, f, number(r->GetDouble(m, f), random));
      break;
    case FieldDescriptor::CPPTYPE_UINT32:
      one ? r->SetRepeatedUInt32(&m, f, index,
                                 static_cast<std::uint32_t>(integer(r->GetRepeatedUInt32(m, f, index), random)))
          : r->SetUInt32(&m, f, static_cast<std::uint32_t>(integer(r->GetUInt32(m, f), random)));
      break;
    case FieldDescriptor::CPPTYPE_UINT64:
      r->SetUInt64(&m, f, integer(r->GetUInt64(m, f), random));
      break;
    case FieldDescriptor::CPPTYPE_INT32:
      r->SetInt32(&m, f, static_cast<std::int32_t>(integer(static_cast<std::uint64_t>(r->GetInt32(m, f)), random)));
      break;
    case FieldDescriptor::CPPTYPE_INT64:
      r->SetInt64(&m, f, static_cast<std::int64_t>(integer(static_cast<std::uint64_t>(r->GetInt64(m, f)), random)));
      break;
    case FieldDescriptor::CPPTYPE_BOOL:
      r->SetBool(&m, f, random() % 2);
      break;
    case FieldDescriptor::CPPTYPE_ENUM:
      r->SetEnumValue(&m, f, static_cast<int>(integer(static_cast<std::uint64_t>(r->GetEnumValue(m, f)), random)));
      break;
    case FieldDescriptor::CPPTYPE_STRING:
      one ? r->SetRepeatedString(&m, f, index, text(r->GetRepeatedString(m, f, index), random))
          : r->SetString(&m, f, text(r->GetString(m, f), random));
      break;
    default:
      break;
  }
}

void grow(Message& m, const FieldDescriptor* f, Random& random) {
  const Reflection* r = m.GetReflection();
  const int n = r->FieldSize(m, f);
  switch (f->cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      Message* added = r->AddMessage(&m, f);
      if (n > 0 && random() % 4) added->CopyFrom(r->GetRepeatedMessage(m, f, static_cast<int>(random() % n)));
      break;
    }
    case FieldDescriptor::CPPTYPE_DOUBLE:
      for (unsigned k = 0; k < 1 + 2 * (random() % 2); ++k) r->AddDouble(&m, f, number(0.1, random));
      break;
    case FieldDescriptor::CPPTYPE_UINT32:
      r->AddUInt32(&m, f, static_cast<std::uint32_t>(integer(1, random)));
      break;
    case FieldDescriptor::CPPTYPE_STRING:
      r->AddString(&m, f, text("", random));
      break;
    default:
      break;
  }
}

// Changes one thing somewhere in the message.
void change(Message& m, Random& random) {
  const auto* type = m.GetDescriptor();
  if (type->field_count() == 0) return;
  const Reflection* r = m.GetReflection();
  const FieldDescriptor* f = type->field(static_cast<int>(random() % static_cast<unsigned>(type->field_count())));
  const bool is_message = f->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  // rather what is there: of a oneof above all
  for (int k = 0; k < 4 && (f->is_repeated() ? r->FieldSize(m, f) == 0 : is_message && !r->HasField(m, f)); ++k)
    f = type->field(static_cast<int>(random() % static_cast<unsigned>(type->field_count())));
  const bool message = f->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  if (!f->is_repeated()) {
    if (random() % 16 == 0) return r->ClearField(&m, f);
    return message ? change(*r->MutableMessage(&m, f), random) : change_scalar(m, f, -1, random);
  }
  const int n = r->FieldSize(m, f);
  if (n == 0 || random() % 6 == 0) return grow(m, f, random);
  const int index = static_cast<int>(random() % static_cast<unsigned>(n));
  if (random() % 8 == 0) return r->RemoveLast(&m, f);
  if (random() % 8 == 0) return r->SwapElements(&m, f, index, n - 1);
  message ? change(*r->MutableRepeatedMessage(&m, f, index), random) : change_scalar(m, f, index, random);
}

}  // namespace

std::string mutate_session(const std::string& bytes, std::size_t most, unsigned seed) {
  Random random(seed);
  Requests requests = split(bytes);
  const std::vector<proto::Request>& samples = sample_requests();
  const auto sample = [&] { return samples[random() % samples.size()].SerializeAsString(); };
  if (requests.list.empty() || random() % 6 == 0)
    requests.list.insert(requests.list.begin() + static_cast<std::ptrdiff_t>(random() % (requests.list.size() + 1)),
                         sample());
  else if (random() % 8 == 0)
    requests.list.erase(requests.list.begin() + static_cast<std::ptrdiff_t>(random() % requests.list.size()));
  if (random() % 16 == 0) requests.state = static_cast<int>(random() % 3);
  const std::size_t which = requests.list.empty() ? 0 : random() % requests.list.size();
  const bool in_turn = random() % 8 != 0;
  std::uint64_t sequence = static_cast<std::uint64_t>(requests.state);
  for (std::size_t k = 0; k < requests.list.size(); ++k) {
    proto::Request request;
    ++sequence;
    if (!request.ParseFromString(requests.list[k])) continue;
    if (k == which)
      for (unsigned n = 1 + random() % 3; n > 0; --n) change(request, random);
    if (in_turn) request.set_sequence(sequence);
    requests.list[k] = request.SerializeAsString();
  }
  while (!requests.list.empty() && join(requests).size() > most) requests.list.pop_back();
  return join(requests);
}

std::string mutate_reply(const std::string& bytes, std::size_t most, unsigned seed) {
  Random random(seed);
  proto::Reply reply;
  if (bytes.empty() || !reply.ParseFromString(bytes.substr(1))) return bytes;
  for (unsigned n = 1 + random() % 3; n > 0; --n) change(reply, random);
  std::string mutated(1, bytes[0]);
  mutated += reply.SerializeAsString();
  return mutated.size() <= most ? mutated : bytes;
}

}  // namespace sunder::fuzz
