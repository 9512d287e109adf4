// Runs every target on every file of its folder in the corpus: what was found once stays mended. With a number, also
// that many mutations of each message target's files: more than a fuzzer gets through, but blind. Another seed gives
// other mutations, so that runs can share the work.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "coupler/core/error.h"
#include "tests/fuzz/targets.h"

namespace {

constexpr std::size_t kMost = 4096;    // bytes of a mutated input
constexpr long kMutationsOfEach = 20;  // where no number is given
constexpr unsigned kGenerations = 8;   // of mutations of mutations
constexpr unsigned kFirstSeed = 1;     // where none is given

using Inputs = std::vector<std::string>;

void run(const sunder::fuzz::Target& target, const std::string& bytes) {
  target.run(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

void mutate(const sunder::fuzz::Target& target, const Inputs& inputs, long runs, unsigned seed) {
  std::mt19937 seeds(seed);  // a count would give the run of a later seed the mutations of this one
  for (long done = 0; done < runs;)
    for (std::size_t k = 0; k < inputs.size() && done < runs; ++k) {
      std::string bytes = inputs[k];
      for (unsigned g = 0; g < kGenerations && done < runs; ++g, ++done)
        run(target, bytes = target.mutate(bytes, kMost, static_cast<unsigned>(seeds())));
    }
}

}  // namespace

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  if (argc != 2 && argc != 4 && argc != 5)
    return std::fputs("fuzz_replay CORPUS [TARGET MUTATIONS [SEED]]\n", stderr), 2;
  const unsigned seed = argc == 5 ? static_cast<unsigned>(std::strtoul(argv[4], nullptr, 10)) : kFirstSeed;
  bool known = argc == 2;
  for (const auto& target : sunder::fuzz::targets()) {
    if (argc > 2 && std::string(argv[2]) != target.name) continue;
    known = true;
    Inputs inputs;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(fs::path(argv[1]) / target.name)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());  // a seed gives the same mutations everywhere
    for (const fs::path& file : files) {
      std::ifstream in(file, std::ios::binary);
      inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
      fmt::print("{} {}\n", target.name, file.filename().string());
      std::fflush(stdout);  // the last line names the file where one ends the process
      run(target, inputs.back());
    }
    sunder::fuzz::demand(!inputs.empty(), std::string("no corpus of ") + target.name);
    if (target.mutate == nullptr) continue;
    const long runs = argc > 2 ? std::atol(argv[3]) : kMutationsOfEach * static_cast<long>(inputs.size());
    mutate(target, inputs, runs, seed);
    fmt::print("{}: {} mutations\n", target.name, runs);
  }
  if (!known) return fmt::print(stderr, "fuzz_replay: this build has no target {}\n", argv[2]), 2;
  return 0;
}
