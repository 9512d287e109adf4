#include "tests/fuzz/targets.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <google/protobuf/stubs/logging.h>
#include <unistd.h>

#include "coupler/core/error.h"
#include "tests/temporary_folder.h"

namespace sunder::fuzz {

const std::vector<Target>& targets() {
  google::protobuf::SetLogHandler(nullptr);  // it writes a line for every text that is not UTF-8
  static const std::vector<Target> all{
      {"session", run_session, mutate_session},
      {"bullet", run_bullet, mutate_session},
      {"ode", run_ode, mutate_session},
      {"replies", run_replies, mutate_reply},
      {"scene", run_scene, nullptr},
      {"pgm", run_pgm, nullptr},
      {"mesh", run_mesh, mutate_file},
      {"surface", run_surface, mutate_file},
      {"pc2", run_pc2, nullptr},
#ifdef SUNDER_CAD
      {"cad", run_cad, mutate_file},
#endif
  };
  return all;
}

void demand(bool good, const std::string& what) {
  if (good) return;
  fmt::print(stderr, "finding: {}\n", what);
  std::abort();
}

void refuses_by_name(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    demand(e.status == Exit::kBadInput && !e.kind.empty() && *e.what() != '\0',
           fmt::format("status {}, kind '{}': {}", static_cast<int>(e.status), e.kind, e.what()));
  }
}

std::string file_with(const std::string& name, const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const std::string path = folder.path + "/" + name;
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

}  // namespace sunder::fuzz
