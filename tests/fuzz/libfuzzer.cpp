// One target behind clang's libFuzzer; SUNDER_FUZZ_TARGET names it.
#include <algorithm>
#include <cstring>

#include "tests/fuzz/targets.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

const sunder::fuzz::Target& target() {
  static const auto& all = sunder::fuzz::targets();
  static const auto& found =
      *std::find_if(all.begin(), all.end(), [](const auto& t) { return std::strcmp(t.name, SUNDER_FUZZ_TARGET) == 0; });
  return found;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  target().run(data, size);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  if (target().mutate == nullptr || seed % 4 == 0) return LLVMFuzzerMutate(data, size, most);
  const std::string mutated = target().mutate(std::string(data, data + size), most, seed / 4);
  std::copy(mutated.begin(), mutated.end(), data);
  return mutated.size();
}
