// Files that once ended OpenCASCADE's reader, found by mutations. Each is refused, and this process goes on.
#ifdef SUNDER_CAD
#include <filesystem>

#include "tests/shell/io/cad_fixture.h"

using namespace sunder;
using namespace sunder::shell;

namespace {

class CadHostile : public Cad {};

// The first byte of a file of the corpus says its format, as in tests/fuzz/cad.cpp.
TEST_F(CadHostile, AFileThatStopsTheReaderIsRefusedWithTheSignal) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SUNDER_CORPUS "/cad")) {
    if (entry.path().filename().string().rfind("stops_", 0) != 0) continue;
    ++files;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const std::string name = bytes[0] % 2 ? "part.igs" : "part.step";
    std::ofstream(file(name), std::ios::binary) << bytes.substr(1);
    const std::string told = error(fmt::format("path: '{}'", name));
#if OCC_VERSION_HEX < 0x070700  // later ones may survive them
    EXPECT_SAYS(told, fmt::format("shells[0].cad.path: '{}' stops OpenCASCADE's reader with SIG", name));
    EXPECT_SAYS(told, "; export it again, or simpler");
#endif
  }
  EXPECT_GT(files, 0);
}

}  // namespace
#endif
