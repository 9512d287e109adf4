// Writes good messages of every kind, to begin with where there is no corpus.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "coupler/core/error.h"
#include "coupler/link/session.h"
#include "rigid/engine/free_flight.h"
#include "tests/fuzz/samples.h"

int main(int argc, char** argv) {
  using namespace sunder;
  namespace fs = std::filesystem;
  if (argc != 2) return std::fputs("fuzz_seeds FOLDER\n", stderr), 2;
  const auto write = [&](const char* target, const std::string& name, const std::string& bytes) {
    fs::create_directories(fs::path(argv[1]) / target);
    std::ofstream(fs::path(argv[1]) / target / name, std::ios::binary) << bytes;
  };
  std::vector<proto::Request> samples = fuzz::sample_requests();
  for (int k = 0; k < static_cast<int>(samples.size()); ++k) {
    fuzz::Requests requests{std::min(k, 2), {}};
    samples[static_cast<std::size_t>(k)].set_sequence(static_cast<std::uint64_t>(requests.state) + 1);
    requests.list.push_back(samples[static_cast<std::size_t>(k)].SerializeAsString());
    for (const char* target : {"session", "bullet", "ode"})
      write(target, fmt::format("request_{}", k), fuzz::join(requests));
  }
  for (int number = 0; number < 8; ++number) {
    rigid::FreeFlight engine;
    link::Session session(engine);
    std::uint64_t sequence = 0;
    // all that is asked before, in the shell's order; Export comes empty from this engine
    for (const std::size_t k : {0, 1, 7, 3, 4, 5, 6, 8}) {
      samples[k].set_sequence(++sequence);
      std::string reply = session.answer(samples[k].SerializeAsString());
      if (samples[k].kind_case() == proto::Request::kExport) {
        proto::Reply rows;
        rows.ParseFromString(reply);
        auto* row = rows.mutable_export_()->add_rows();
        row->set_first(1), row->set_second(4), row->mutable_normal()->set_z(1.0), row->set_friction(0.5);
        row->mutable_first_point()->set_z(-0.1);
        reply = rows.SerializeAsString();
      }
      if (samples[k].kind_case() == fuzz::answered(static_cast<std::uint8_t>(number)))
        write("replies", fmt::format("reply_{}", number), std::string(1, static_cast<char>(number)) + reply);
    }
  }
  return 0;
}
