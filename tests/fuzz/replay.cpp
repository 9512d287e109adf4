// Runs every target on every file of its folder in the corpus: what was found once stays mended. With a number, also
// that many mutations of each message target's files: more than a fuzzer gets through, but blind.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "coupler/core/error.h"
#include "tests/fuzz/targets.h"

namespace {

constexpr std::size_t kMost = 4096;    // bytes of a mutated input
constexpr long kMutationsOfEach = 20;  // where no number is given
constexpr unsigned kGenerations = 8;   // of mutations of mutations

using Inputs = std::vector<std::string>;

void run(const sunder::fuzz::Target& target, const std::string& bytes) {
  target.run(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

void mutate(const sunder::fuzz::Target& target, const Inputs& inputs, long runs) {
  unsigned seed = 1;
  for (long done = 0; done < runs;)
    for (std::size_t k = 0; k < inputs.size() && done < runs; ++k) {
      std::string bytes = inputs[k];
      for (unsigned g = 0; g < kGenerations && done < runs; ++g, ++done)
        run(target, bytes = target.mutate(bytes, kMost, seed++ * 2654435761u));
    }
}

}  // namespace

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  if (argc != 2 && argc != 4) return std::fputs("fuzz_replay CORPUS [TARGET MUTATIONS]\n", stderr), 2;
  for (const auto& target : sunder::fuzz::targets()) {
    if (argc == 4 && std::string(argv[2]) != target.name) continue;
    Inputs inputs;
    for (const auto& entry : fs::directory_iterator(fs::path(argv[1]) / target.name)) {
      std::ifstream in(entry.path(), std::ios::binary);
      inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
      fmt::print("{} {}\n", target.name, entry.path().filename().string());
      std::fflush(stdout);  // the last line names the file where one ends the process
      run(target, inputs.back());
    }
    sunder::fuzz::demand(!inputs.empty(), std::string("no corpus of ") + target.name);
    if (target.mutate == nullptr) continue;
    const long runs = argc == 4 ? std::atol(argv[3]) : kMutationsOfEach * static_cast<long>(inputs.size());
    mutate(target, inputs, runs);
    fmt::print("{}: {} mutations\n", target.name, runs);
  }
  return 0;
}
