#include <cmath>

#include "coupler/core/command_line.h"
#include "shell/io/inspect.h"
#include "shell/io/inspect_mesh.h"
#include "shell/run/program.h"

namespace sunder::shell {

int inspect_program(int argc, char** argv) {
  std::string file;
  double element = 0.0;
  CLI::App app("Prints as JSON what a STEP, IGES or mesh file holds, and what of it would be refused.",
               "sunder-shell inspect");
  app.add_option("FILE", file, "The file")->required();
  app.add_option("--element", element, "Spacing of shells [m]; default: a fortieth of the file's size")->take_last();
  if (!read_arguments(app, argc, argv)) return 0;
  require(app.count("--element") == 0 || (element > 0.0 && std::isfinite(element)),
          "--element {}: must be positive and finite [m]; leave it out for a fortieth of the file's size", element);
  fmt::print("{}", is_mesh_file(file) ? inspect_mesh_report(file, element) : inspect_report(file, element));
  return 0;
}

}  // namespace sunder::shell
